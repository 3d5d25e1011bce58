//! Outcomes, classes, levels and permitted actions of games against the definitions: each level is
//! decided by enumerating all memoryless strategies of both sides in the game of that level.

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;

use super::raw::{Enforced, Raw, Won, loaded};
use super::{settings, some_game, thresholds};
use crate::common::prelude::*;

pub(crate) type Set = BTreeSet<usize>;

/// A game with objectives, of which the first are never below later ones.
#[derive(Debug, Clone)]
pub(crate) struct Case {
    pub(crate) raw: Raw,
    pub(crate) targets: Vec<Won>,
    /// Pairs of objectives of which the first is strictly preferred.
    pub(crate) pairs: Vec<(usize, usize)>,
    pub(crate) empty: &'static str,
    /// The states in which a requirement is kept; `None` without a requirement.
    pub(crate) required: Option<Won>,
}

pub(crate) fn some_case() -> impl Strategy<Value = Case> {
    let targets = vec(vec(any::<bool>(), 6), 1..=3);
    let pairs = vec((0..3usize, 0..3usize), 0..=3);
    let empty = select(&["bottom", "gain", "incomparable"][..]);
    let required = prop::option::weighted(0.3, vec(prop::bool::weighted(0.8), 6));
    (some_game(6, 2), targets, pairs, empty, required).prop_map(|(raw, targets, pairs, empty, required)| {
        let n = targets.len();
        let pairs = pairs.into_iter().filter(|(i, j)| i < j && *j < n).collect();
        Case { raw, targets, pairs, empty, required }
    })
}

impl Case {
    pub(crate) fn preferences(&self) -> String {
        let states = |set: &Won| {
            let all = (0..set.len()).filter(|&s| set[s]).map(|s| format!("x={s}")).collect::<Vec<_>>();
            if all.is_empty() { "false".to_owned() } else { all.join(" | ") }
        };
        let mut text = format!("empty = {};\n", self.empty);
        for (i, target) in self.targets.iter().enumerate() {
            text += &format!("objective o{i} = F ({});\n", states(target));
        }
        self.pairs.iter().for_each(|(i, j)| text += &format!("prefer o{i} > o{j};\n"));
        if let Some(required) = &self.required {
            text += &format!("require G ({});\n", states(required));
        }
        text
    }
}

/// The definitions.
pub(crate) struct Reference<'a> {
    pub(crate) case: &'a Case,
    /// The states from which we can keep the requirement.
    pub(crate) safe: Won,
    /// The choices of the restricted model, by their position.
    pub(crate) open: Vec<Vec<usize>>,
    pub(crate) mp: Vec<Set>,
    strict: Vec<Vec<bool>>,
}

impl<'a> Reference<'a> {
    pub(crate) fn new(case: &'a Case) -> Self {
        let (raw, n) = (&case.raw, case.targets.len());
        let mut strict = vec![vec![false; n]; n];
        case.pairs.iter().for_each(|&(i, j)| strict[i][j] = true);
        for k in 0..n {
            for i in 0..n {
                (0..n).for_each(|j| strict[i][j] |= strict[i][k] && strict[k][j]);
            }
        }
        let safe = staying(raw, case.required.clone().unwrap_or_else(|| vec![true; raw.len()]));
        let inside = |c: &[usize]| c.iter().all(|&t| safe[t]);
        let open: Vec<Vec<usize>> = (0..raw.len())
            .map(|s| (0..raw.choices[s].len()).filter(|&a| safe[s] && inside(&raw.choices[s][a])).collect())
            .collect();
        let mut reference = Reference { case, safe, open, mp: Vec::new(), strict };
        let game = reference.game(|_| true, |s, a| raw.choices[s][a].clone());
        let sure: Vec<Won> = case
            .targets
            .iter()
            .map(|target| {
                let target: Won =
                    (0..raw.len()).map(|s| target[s] && reference.safe[s]).chain([false]).collect();
                game.enforced(&target)[0].surely.clone()
            })
            .collect();
        let most_preferred = |s: usize| -> Set {
            let out: Set = (0..n).filter(|&i| sure[i][s] && reference.safe[s]).collect();
            out.iter().copied().filter(|&i| !out.iter().any(|&j| reference.strict[j][i])).collect()
        };
        reference.mp = (0..raw.len()).map(most_preferred).collect();
        reference
    }

    /// The game of the open choices of some states, each with the ends that a function gives; others
    /// lead nowhere. The last state is a goal.
    fn game(&self, is_in: impl Fn(usize) -> bool, ends: impl Fn(usize, usize) -> Vec<usize>) -> Raw {
        let goal = self.case.raw.len();
        let mut choices: Vec<Vec<Vec<usize>>> = (0..goal)
            .map(|s| {
                let open = if is_in(s) { &self.open[s][..] } else { &[] };
                let all: Vec<Vec<usize>> = open.iter().map(|&a| ends(s, a)).collect();
                if all.is_empty() { vec![vec![s]] } else { all }
            })
            .collect();
        choices.push(vec![vec![goal]]);
        Raw { theirs: self.case.raw.theirs.iter().copied().chain([false]).collect(), choices }
    }

    fn compare(&self, from: &Set, to: &Set, better: impl Fn(usize, usize) -> bool) -> bool {
        from.iter().any(|&i| to.iter().any(|&j| better(i, j)))
    }

    pub(crate) fn improves(&self, from: &Set, to: &Set) -> bool {
        match (from.is_empty(), to.is_empty()) {
            (true, false) => self.case.empty != "incomparable",
            _ => self.compare(from, to, |i, j| self.strict[j][i]),
        }
    }

    pub(crate) fn weakens(&self, from: &Set, to: &Set) -> bool {
        match (from.is_empty(), to.is_empty()) {
            (false, true) => self.case.empty == "bottom",
            _ => self.compare(from, to, |i, j| self.strict[i][j]),
        }
    }

    pub(crate) fn successors(&self, s: usize, a: usize) -> &[usize] {
        &self.case.raw.choices[s][a]
    }

    /// The opponent's states in which it can weaken, or lead to another such state.
    pub(crate) fn bad(&self) -> Won {
        let n = self.case.raw.len();
        let mut bad = vec![false; n];
        loop {
            let is_bad = |s: usize| {
                let wrong = |t: &usize| self.weakens(&self.mp[s], &self.mp[*t]) || bad[*t];
                self.case.raw.theirs[s]
                    && self.open[s].iter().any(|&a| self.successors(s, a).iter().any(wrong))
            };
            let more: Won = (0..n).map(is_bad).collect();
            if more == bad {
                return bad;
            }
            bad = more;
        }
    }

    /// The kept choices of each state under `action`.
    pub(crate) fn kept(&self) -> Vec<Vec<usize>> {
        let bad = self.bad();
        let keeps = |s: usize, a: usize| {
            let wrong = |t: &usize| self.weakens(&self.mp[s], &self.mp[*t]) || bad[*t];
            !bad[s] && !self.successors(s, a).iter().any(wrong)
        };
        let of = |s: usize| self.open[s].iter().copied().filter(|&a| keeps(s, a)).collect();
        (0..self.case.raw.len()).map(of).collect()
    }

    /// The arenas: for each class, or one for all (`None`), the kept choices.
    fn arenas(&self, safety: Safety) -> Vec<(Option<Set>, Vec<Vec<usize>>)> {
        if safety == Safety::Action {
            return vec![(None, self.kept())];
        }
        let n = self.case.raw.len();
        let classes: BTreeSet<&Set> = (0..n).filter(|&s| self.safe[s]).map(|s| &self.mp[s]).collect();
        let arena = |class: &Set| {
            let start = (0..n).map(|s| self.safe[s] && !self.weakens(class, &self.mp[s])).collect();
            let inside = staying_among(&self.case.raw, start, &self.open);
            let keeps = |s: usize, a: &usize| inside[s] && self.successors(s, *a).iter().all(|&t| inside[t]);
            let of = |s: usize| self.open[s].iter().copied().filter(|a| keeps(s, a)).collect();
            (Some(class.clone()), (0..n).map(of).collect())
        };
        classes.into_iter().map(arena).collect()
    }

    /// The game of an arena at the level after W, and its winner's states.
    fn level(&self, (class, kept): &(Option<Set>, Vec<Vec<usize>>), entered: &Won) -> (Raw, Enforced) {
        let goal = self.case.raw.len();
        let end = |s: usize, t: usize| {
            let from = class.as_ref().unwrap_or(&self.mp[s]);
            if self.safe[t] && entered[t] && self.improves(from, &self.mp[t]) { goal } else { t }
        };
        let ends = |s: usize, a: usize| self.successors(s, a).iter().map(|&t| end(s, t)).collect::<Vec<_>>();
        let mut game = self.game(|_| false, |_, _| Vec::new());
        for (s, kept) in kept.iter().enumerate().filter(|(_, kept)| !kept.is_empty()) {
            game.choices[s] = kept.iter().map(|&a| ends(s, a)).collect();
        }
        let target = (0..=goal).map(|s| s == goal).collect::<Vec<_>>();
        let [us, _] = game.enforced(&target);
        (game, us)
    }

    /// The rank of each state and the permitted choices of that rank when planning starts there.
    fn plans(&self, kind: Kind, safety: Safety) -> Vec<(Rank, Vec<usize>)> {
        let (n, arenas) = (self.case.raw.len(), self.arenas(safety));
        let mut entered: Won = self.safe.clone();
        let mut plans = vec![(Rank::Finite(0), Vec::new()); n];
        for k in 1.. {
            let mut next = vec![false; n];
            let mut permitted = vec![Vec::new(); n];
            for arena in &arenas {
                let (game, us) = self.level(arena, &entered);
                let won = if kind == Kind::Sasi { &us.surely } else { &us.possibly };
                for s in (0..n).filter(|&s| won[s] && self.safe[s]) {
                    if arena.0.as_ref().is_none_or(|class| *class == self.mp[s]) {
                        next[s] = true;
                        permitted[s] = permitted_in(&game, won, &arena.1[s], (kind, s));
                    }
                }
            }
            let unchanged = next == entered && k > 1;
            let rank = if unchanged { Rank::Unbounded } else { Rank::Finite(k) };
            for s in (0..n).filter(|&s| next[s]) {
                plans[s] = (rank, std::mem::take(&mut permitted[s]));
            }
            if unchanged || !next.contains(&true) {
                break;
            }
            entered = next;
        }
        for (plan, _) in plans.iter_mut().zip(&self.case.raw.theirs).filter(|(_, theirs)| **theirs) {
            plan.1.clear();
        }
        plans
    }
}

/// The kept choices with only good ends (SASI), or with a good end (SPI): won, or the goal.
fn permitted_in(game: &Raw, won: &Won, kept: &[usize], (kind, s): (Kind, usize)) -> Vec<usize> {
    let good = |&t: &usize| won[t];
    let permits = |at: &usize| match kind {
        Kind::Sasi => game.choices[s][*at].iter().all(good),
        Kind::Spi => game.choices[s][*at].iter().any(good),
    };
    (0..kept.len()).filter(permits).map(|at| kept[at]).collect()
}

/// The greatest part of a set in which we can stay.
fn staying(raw: &Raw, z: Won) -> Won {
    let all: Vec<Vec<usize>> = raw.choices.iter().map(|choices| (0..choices.len()).collect()).collect();
    staying_among(raw, z, &all)
}

fn staying_among(raw: &Raw, mut z: Won, open: &[Vec<usize>]) -> Won {
    loop {
        let stays = |s: usize| {
            let mut inside = open[s].iter().map(|&a| raw.choices[s][a].iter().all(|&t| z[t]));
            z[s] && if raw.theirs[s] { inside.all(|i| i) } else { inside.any(|i| i) }
        };
        let fewer: Won = (0..z.len()).map(stays).collect();
        if fewer == z {
            return z;
        }
        z = fewer;
    }
}

/// The name of each choice: the k-th command of its side's module.
fn names(raw: &Raw) -> Vec<Vec<String>> {
    let mut numbers = [0, 0];
    let mut name = |theirs: bool| {
        numbers[usize::from(theirs)] += 1;
        format!("{}#{}", if theirs { "yours" } else { "mine" }, numbers[usize::from(theirs)])
    };
    let of =
        |(s, choices): (usize, &Vec<_>)| choices.iter().map(|_: &Vec<usize>| name(raw.theirs[s])).collect();
    raw.choices.iter().enumerate().map(of).collect()
}

fn check<E: Engine>(
    engine: E,
    (program, preferences): (&Program, &Arc<Preferences>),
    reference: &Reference<'_>,
    safety: Safety,
) {
    let options = Options { safety, ..Options::default() };
    let analysis = finished(&Arc::new(engine), preferences, options);
    let (case, names) = (reference.case, names(&reference.case.raw));
    let plans = Kind::ALL.iter().map(|&kind| reference.plans(kind, safety)).collect::<Vec<_>>();
    for s in 0..case.raw.len() {
        let state = [s as i64];
        assert_eq!(analysis.is_unsafe(&state).unwrap(), !reference.safe[s], "unsafe {s}: {case:?}");
        if !reference.safe[s] {
            continue;
        }
        let mp: Vec<String> = reference.mp[s].iter().map(|i| format!("o{i}")).collect();
        assert_eq!(analysis.most_preferred(&state).unwrap(), mp, "MP of {s}: {case:?}");
        let prospects = analysis.prospects(program, &state).unwrap();
        let expected = |plan: &(Rank, Vec<usize>)| {
            (plan.0, plan.1.iter().map(|&a| names[s][a].clone()).collect::<Vec<_>>())
        };
        let found = [&prospects.sasi, &prospects.spi].map(|plan| plan.clone().unwrap());
        for (kind, (plans, found)) in plans.iter().zip(found).enumerate() {
            let found = (found.rank, found.actions);
            assert_eq!(found, expected(&plans[s]), "{:?} {safety} of {s}: {case:?}", Kind::ALL[kind]);
        }
    }
    if safety == Safety::Action {
        let kept = reference.kept();
        let count = |choices: &[Vec<usize>]| -> usize {
            let of = |(s, all): (usize, &Vec<usize>)| {
                all.iter().map(|&a| case.raw.choices[s][a].len()).sum::<usize>()
            };
            choices.iter().enumerate().map(of).sum()
        };
        let sizes = analysis.result().improvement.as_ref().unwrap();
        assert_eq!(sizes.transitions, (2 * count(&kept)).into(), "{case:?}");
        assert_eq!(sizes.dropped, (count(&reference.open) - count(&kept)).into(), "{case:?}");
    }
}

proptest! {
    #![proptest_config(meliora_amount::random(300))]

    #[test]
    fn levels_are_those_of_the_definitions(case in some_case()) {
        let (program, preferences) = loaded(&case.raw.text(), &case.preferences());
        let reference = Reference::new(&case);
        for safety in [Safety::Action, Safety::Prefix] {
            let of = (&*program, &preferences);
            let settings = |thresholds| settings(Scope::All, thresholds);
            let explicit = ExplicitEngine::new(program.clone(), settings(thresholds()[0])).unwrap();
            check(explicit, of, &reference, safety);
            for thresholds in thresholds() {
                let symbolic = SymbolicEngine::new(program.clone(), settings(thresholds)).unwrap();
                check(symbolic, of, &reference, safety);
            }
        }
    }

    /// An objective that we can enforce stays enforceable after any move of the opponent, unless
    /// the state left was a target itself.
    #[test]
    fn the_opponent_weakens_only_where_a_target_is_left(case in some_case()) {
        let reference = Reference::new(&case);
        for s in (0..case.raw.len()).filter(|&s| case.raw.theirs[s] && reference.safe[s]) {
            let is_target = reference.mp[s].iter().any(|&i| case.targets[i][s]);
            for &t in reference.open[s].iter().flat_map(|&a| reference.successors(s, a)) {
                let weakens = reference.weakens(&reference.mp[s], &reference.mp[t]);
                prop_assert!(!weakens || is_target, "{} to {}: {:?}", s, t, case);
            }
        }
    }
}
