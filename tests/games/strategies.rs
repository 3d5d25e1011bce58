//! Strategies of games against every behaviour of the opponent: the states that a strategy may visit, with
//! its memory, are a game in which only the opponent chooses.

use meliora::model::preference::ObjectiveSet;
use meliora::planning::explain::{Successor, Verdict};
use meliora::planning::induced_model::Node;
use proptest::prelude::*;

use super::levels::{Case, Reference, Set, some_case};
use super::raw::{Raw, Won, loaded};
use super::{settings, some_game, thresholds};
use crate::common::prelude::*;

pub(crate) type Strategy = FiniteMemoryStrategy<AnyEngine>;

/// A case with its finished analyses.
pub(crate) struct Analysed {
    pub(crate) program: Arc<Program>,
    pub(crate) analysis: Analysis<AnyEngine>,
}

impl Analysed {
    pub(crate) fn new(text: &str, preferences: &str, safety: Safety, storage: Storage) -> Self {
        let (program, preferences) = loaded(text, preferences);
        let settings = Settings { storage, ..settings(Scope::All, thresholds()[0]) };
        let engine = Arc::new(AnyEngine::new(program.clone(), settings).unwrap());
        let analysis = finished(&engine, &preferences, Options { safety, ..Options::default() });
        Analysed { program, analysis }
    }

    pub(crate) fn strategy(&self, kind: StrategyKind, objectives: &[usize]) -> Strategy {
        let objectives = objectives.iter().copied();
        let (analysis, program) = (&self.analysis, &self.program);
        FiniteMemoryStrategy::of_kind(analysis, program, kind, kind.levels(), objectives).unwrap().unwrap()
    }
}

/// Runs a test for each safety mode and each engine.
pub(crate) fn each(case: &Case, test: impl Fn(&Analysed, Safety)) {
    for safety in [Safety::Action, Safety::Prefix] {
        for storage in [Storage::Explicit, Storage::Symbolic] {
            test(&Analysed::new(&case.raw.text(), &case.preferences(), safety, storage), safety);
        }
    }
}

fn number(state: &[i64]) -> usize {
    state[0] as usize
}

fn set(objectives: &ObjectiveSet) -> Set {
    objectives.iter().collect()
}

fn level(rank: Rank) -> usize {
    match rank {
        Rank::Finite(k) | Rank::AtLeast(k) => k,
        Rank::Unbounded => usize::MAX,
    }
}

fn unfolded(strategy: &mut Strategy, start: usize, scheduler: Scheduler) -> InducedModel {
    let model = InducedModel::unfold(strategy, &[vec![start as i64]], scheduler, 10_000).unwrap();
    assert!(model.complete);
    model
}

/// The nodes as a game in which only the opponent chooses: ours take one of their actions at random. Edges
/// that `reaches` accepts lead to a state of their own, the last one.
fn induced(case: &Case, model: &InducedModel, reaches: impl Fn(&Node, &Successor) -> bool) -> Raw {
    let goal = model.nodes.len();
    let mut raw = Raw { theirs: Vec::new(), choices: Vec::new() };
    for (index, node) in model.nodes.iter().enumerate() {
        let theirs = case.raw.theirs[number(&node.at.state)];
        let ends = |(action, next): (&meliora::planning::explain::Action, &Vec<Option<usize>>)| {
            let end =
                |(s, to): (&Successor, &Option<usize>)| to.map(|to| if reaches(node, s) { goal } else { to });
            action.successors.iter().zip(next).map(end).collect::<Option<Vec<_>>>()
        };
        let mut all: Vec<Vec<usize>> = node.at.actions.iter().zip(&node.next).filter_map(ends).collect();
        if theirs {
            assert!(all.is_empty() || all.len() == node.at.actions.len(), "{node:?}");
        } else if !all.is_empty() {
            all = vec![all.concat()];
        }
        raw.choices.push(if all.is_empty() { vec![vec![index]] } else { all });
        raw.theirs.push(theirs);
    }
    raw.choices.push(vec![vec![goal]]);
    raw.theirs.push(false);
    raw
}

/// The states from which we reach the target almost surely: νY. μX. over plain sets.
fn almost_surely(raw: &Raw, target: &[bool]) -> Won {
    let mut y = vec![true; raw.len()];
    loop {
        let mut x = target.to_vec();
        loop {
            let good = |c: &Vec<usize>| c.iter().all(|&t| y[t]) && c.iter().any(|&t| x[t]);
            let wins = |s: usize| match raw.theirs[s] {
                true => raw.choices[s].iter().all(good),
                false => raw.choices[s].iter().any(good),
            };
            let more: Won = (0..raw.len()).map(|s| x[s] || wins(s)).collect();
            if more == x {
                break;
            }
            x = more;
        }
        if x == y {
            return y;
        }
        y = x;
    }
}

/// Checks the steps that a strategy may take: the reference is that of the definition, and before a
/// commitment no step weakens it.
fn check_steps(reference: &Reference<'_>, safety: Safety, start: usize, model: &InducedModel) {
    let case = reference.case;
    let mut references: Vec<Option<Set>> = vec![None; model.nodes.len()];
    references[0] = Some(reference.mp[start].clone());
    // Nodes come after a node that leads to them.
    for (index, node) in model.nodes.iter().enumerate() {
        let from = references[index].clone().unwrap();
        let own = match safety {
            Safety::Prefix if !node.at.commits() => from.clone(),
            _ => reference.mp[number(&node.at.state)].clone(),
        };
        assert_eq!(set(&node.at.reference), own, "{case:?}");
        for (action, next) in node.at.actions.iter().zip(&node.next) {
            for (s, to) in action.successors.iter().zip(next) {
                let Some(to) = *to else { continue };
                let entered = &reference.mp[number(&s.state)];
                assert!(node.at.commits() || !reference.weakens(&own, entered), "{node:?} {case:?}");
                let kept = safety == Safety::Prefix && !s.improves && !model.nodes[to].at.commits();
                let new = if kept { from.clone() } else { entered.clone() };
                let known = references[to].get_or_insert_with(|| new.clone());
                assert!(safety == Safety::Action || *known == new, "{node:?} {case:?}");
            }
        }
    }
}

proptest! {
    #![proptest_config(meliora_amount::random(150))]

    /// Checks that no step under a strategy weakens, whoever takes it. From a node of level k, the next improvement
    /// follows almost surely (SASI) or with positive probability (SPI), and k - 1 levels are left then.
    #[test]
    fn improvements_follow_against_every_opponent(case in some_case()) {
        let reference = Reference::new(&case);
        each(&case, |analysed, safety| {
            for (kind, scheduler) in [
                (Kind::Sasi, Scheduler::Progress),
                (Kind::Sasi, Scheduler::Permissive),
                (Kind::Spi, Scheduler::Progress),
                (Kind::Spi, Scheduler::Permissive),
            ] {
                let mut strategy = analysed.strategy(kind.into(), &[]);
                for start in (0..case.raw.len()).filter(|&s| reference.safe[s]) {
                    let model = unfolded(&mut strategy, start, scheduler);
                    check_steps(&reference, safety, start, &model);
                    let improves = |node: &Node, s: &Successor| {
                        let (from, to) = (set(&node.at.reference), &reference.mp[number(&s.state)]);
                        let next = level(s.next.level);
                        reference.improves(&from, to) && next.saturating_add(1) >= level(node.at.memory.level)
                    };
                    let raw = induced(&case, &model, improves);
                    let goal: Won = (0..raw.len()).map(|s| s + 1 == raw.len()).collect();
                    assert_eq!(level(model.nodes[0].at.memory.level), level(strategy.rank(&[start as i64]).unwrap()));
                    if raw.pairs() > 4096 {
                        continue;
                    }
                    let [us, _] = raw.enforced(&goal);
                    let won = if kind == Kind::Sasi { us.surely } else { us.possibly };
                    for (index, node) in model.nodes.iter().enumerate() {
                        assert!(
                            node.at.is_over() || won[index],
                            "{kind} {scheduler:?} {safety} {index} of {model:?}: {case:?}"
                        );
                    }
                }
            }
        });
    }

    /// From each of its nodes, a plan almost surely improves, or ends where its objective is achieved or where
    /// nothing can be. It need not end: the opponent may let it improve again and again. A strategy of the kind
    /// `achieve` ends wherever the definition says that its objectives can be achieved.
    #[test]
    fn objectives_are_achieved_against_every_opponent(case in some_case()) {
        let reference = Reference::new(&case);
        each(&case, |analysed, safety| {
            let safe = || (0..case.raw.len()).filter(|&s| reference.safe[s]);
            let all = (0..case.targets.len()).collect::<Vec<_>>();
            let mut plan = analysed.strategy(StrategyKind::Plan, &[]);
            for (start, scheduler) in safe().flat_map(|s| Scheduler::ALL.iter().map(move |&by| (s, by))) {
                let model = unfolded(&mut plan, start, scheduler);
                check_steps(&reference, safety, start, &model);
                let over: Vec<bool> = model.nodes.iter().map(|node| node.at.is_over()).collect();
                let improves = |node: &Node, s: &Successor| {
                    reference.improves(&set(&node.at.reference), &reference.mp[number(&s.state)])
                };
                let won = almost_surely(&induced(&case, &model, improves), &[&over[..], &[true]].concat());
                assert!(won.iter().all(|&won| won), "{scheduler:?} {safety} {start}: {case:?}");
                for node in model.nodes.iter().filter(|node| node.at.is_over()) {
                    let target = node.at.pursued().is_some_and(|i| case.targets[i][number(&node.at.state)]);
                    assert!(target || node.at.most_preferred.is_empty(), "{node:?}: {case:?}");
                }
            }
            for objectives in all.iter().map(|&i| vec![i]).chain((all.len() > 1).then(|| all[..2].to_vec())) {
                let expected = reached_together(&reference, &objectives);
                let mut strategy = analysed.strategy(StrategyKind::Achieve, &objectives);
                for (start, scheduler) in safe().flat_map(|s| Scheduler::ALL.iter().map(move |&by| (s, by))) {
                    let model = unfolded(&mut strategy, start, scheduler);
                    let pursues = model.nodes[0].at.memory.pursuit.is_some();
                    assert_eq!(pursues, expected[start], "{objectives:?} {start}: {case:?}");
                    if pursues {
                        let achieved = visited(&case, &model, &objectives);
                        assert!(ends_surely(&case, &model, &achieved), "{objectives:?} {start}: {case:?}");
                    }
                }
            }
        });
    }

    /// At a state of the opponent nothing is permitted or forbidden, and each action has the verdict of the
    /// definition. An action of ours is refused for a state in which the opponent can weaken, with the
    /// shortest way to do so.
    #[test]
    fn reasons_tell_what_the_opponent_can_do(case in some_case()) {
        let reference = Reference::new(&case);
        let (bad, distances) = (reference.bad(), threats(&reference));
        each(&case, |analysed, safety| {
            let mut strategy = analysed.strategy(StrategyKind::Sasi, &[]);
            for s in (0..case.raw.len()).filter(|&s| reference.safe[s]) {
                let memory = strategy.start(&[s as i64]).unwrap();
                let at = strategy.explain(&[s as i64], memory).unwrap();
                let theirs = case.raw.theirs[s];
                assert_eq!(at.owner.map(|owner| (owner.player, owner.ours)), Some((usize::from(theirs), !theirs)));
                assert_eq!(at.is_theirs(), theirs);
                assert!(!theirs || at.pick.is_none());
                for (a, action) in at.actions.iter().enumerate() {
                    let to = |change| {
                        let is_it = |s: &Successor| s.change == change;
                        (action.successors.iter().any(is_it), action.successors.iter().all(is_it))
                    };
                    let is_bad = |s: &Successor| bad[number(&s.state)];
                    if theirs {
                        assert!(!action.permitted && !action.progress, "{action:?}");
                        let expected = match (to(Change::Weakening).0, to(Change::Improving)) {
                            (true, _) => "weakens",
                            (_, _) if action.successors.iter().any(is_bad) && safety == Safety::Action => "exposes",
                            (_, (_, true)) => "improves",
                            (_, (true, _)) => "may-improve",
                            _ => "lateral",
                        };
                        let outside = safety == Safety::Prefix && action.verdict.name() == "unsafe";
                        assert!(outside || action.verdict.name() == expected, "{action:?} {expected}: {case:?}");
                    } else if safety == Safety::Action && reference.open[s].contains(&a) {
                        let exposes = !to(Change::Weakening).0 && action.successors.iter().any(is_bad);
                        assert_eq!(matches!(action.verdict, Verdict::Exposes(_)), exposes, "{action:?}: {case:?}");
                    }
                    if let Verdict::Exposes(index) = action.verdict {
                        let threat = action.threat.as_ref().unwrap();
                        let state = number(&action.successors[index].state);
                        assert_eq!(Some(threat.actions.len()), distances[state], "{threat:?}: {case:?}");
                        assert!(threat.actions.iter().all(|(player, _)| *player == 1));
                    }
                }
            }
        });
    }

    #[test]
    fn the_fixpoint_of_this_test_is_that_of_the_definition(raw in some_game(6, 2), target in proptest::collection::vec(any::<bool>(), 6)) {
        prop_assert_eq!(almost_surely(&raw, &target), raw.enforced(&target)[0].surely.clone());
    }
}

/// Returns whether marked nodes are reached almost surely from the first one, whatever the opponent does.
fn ends_surely(case: &Case, model: &InducedModel, marked: &[bool]) -> bool {
    let raw = induced(case, model, |_, _| false);
    almost_surely(&raw, &[marked, &[false]].concat())[0]
}

/// The states from which all objectives are reached almost surely in the same path, in the product with
/// the objectives reached so far.
fn reached_together(reference: &Reference<'_>, objectives: &[usize]) -> Won {
    let (case, bits) = (reference.case, 1 << objectives.len());
    let n = case.raw.len();
    let reached = |s: usize| {
        objectives.iter().enumerate().map(|(bit, &i)| usize::from(case.targets[i][s]) << bit).sum::<usize>()
    };
    let mut raw = Raw { theirs: Vec::new(), choices: Vec::new() };
    for (s, before) in (0..n).flat_map(|s| (0..bits).map(move |before| (s, before))) {
        let end = |&t: &usize| t * bits + (before | reached(t));
        let of = |&a: &usize| case.raw.choices[s][a].iter().map(end).collect::<Vec<_>>();
        let all: Vec<_> = reference.open[s].iter().map(of).collect();
        raw.choices.push(if all.is_empty() { vec![vec![s * bits + before]] } else { all });
        raw.theirs.push(case.raw.theirs[s]);
    }
    let target: Won = (0..raw.len()).map(|at| at % bits == bits - 1).collect();
    let won = almost_surely(&raw, &target);
    (0..n).map(|s| won[s * bits + reached(s)]).collect()
}

/// For each node, whether every path to it has reached the objectives.
fn visited(case: &Case, model: &InducedModel, objectives: &[usize]) -> Vec<bool> {
    let reached = |node: usize| -> BTreeSet<usize> {
        let state = number(&model.nodes[node].at.state);
        objectives.iter().copied().filter(|&i| case.targets[i][state]).collect()
    };
    let mut all = vec![true; model.nodes.len()];
    let (mut seen, mut queue) = (BTreeSet::new(), vec![(0, reached(0))]);
    while let Some((node, so_far)) = queue.pop() {
        if !seen.insert((node, so_far.clone())) {
            continue;
        }
        all[node] &= so_far.len() == objectives.len();
        for to in model.nodes[node].next.iter().flatten().flatten() {
            queue.push((*to, so_far.union(&reached(*to)).copied().collect()));
        }
    }
    all
}

/// For each state, the number of steps after which the opponent can weaken; `None` if it cannot.
fn threats(reference: &Reference<'_>) -> Vec<Option<usize>> {
    let raw = &reference.case.raw;
    let mut distances = vec![None; raw.len()];
    for steps in 1..=raw.len() {
        let known: Vec<Option<usize>> = distances.clone();
        let threatens = |s: usize, t: usize| match steps {
            1 => reference.weakens(&reference.mp[s], &reference.mp[t]),
            _ => known[t].is_some_and(|before| before + 1 == steps),
        };
        for s in (0..raw.len()).filter(|&s| raw.theirs[s] && known[s].is_none()) {
            let mut ends = reference.open[s].iter().flat_map(|&a| reference.successors(s, a));
            if ends.any(|&t| threatens(s, t)) {
                distances[s] = Some(steps);
            }
        }
    }
    distances
}
