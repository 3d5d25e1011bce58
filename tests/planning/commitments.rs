//! Plans on random models, against literal definitions: until a plan commits, no step weakens; it
//! commits only where kept choices achieve no most preferred objective; then it achieves the objective
//! that it committed to.

use meliora::model::preference::ObjectiveSet;
use meliora::planning::finite_memory::{Manner, Pursuit};
use meliora::planning::induced_model::Node;
use meliora::planning::tally::{Commitment, Trace};
use proptest::prelude::*;
use proptest::test_runner::Config;

use crate::common::coverage::draw_until;
use crate::common::graphs::{bottom_components, edges};
use crate::common::prelude::*;
use crate::planning::Case;
use crate::planning::generate::{case, order};
use crate::planning::literal::{Literal, Set, almost_sure};
use crate::planning::tiny::Mdp;

/// Models in which a path chooses between two hubs, and each hub between four targets: with four
/// objectives, going to one hub often loses objectives that are sure at the other.
fn crossing() -> impl Strategy<Value = Case> {
    let to = |states: Vec<usize>, branches| prop::collection::vec(prop::sample::select(states), 1..=branches);
    let start = prop::collection::vec(to(vec![0, 1, 2], 2), 1..=3);
    let hubs = prop::collection::vec(prop::collection::vec(to(vec![3, 4, 5, 6, 6], 2), 1..=3), 2);
    let ends = prop::collection::vec(prop::collection::vec(to((0..7).collect(), 1), 0..=1), 4);
    let strict = |left, right| Statement { left, right, relation: Relation::Strict };
    let crossed = Just(vec![strict(2, 0), strict(3, 1)]);
    let statements = prop_oneof![3 => crossed, 1 => order(4)];
    (start, hubs, ends, statements).prop_map(|(start, hubs, ends, statements)| Case {
        mdp: Mdp::new([vec![start], hubs, ends].concat()),
        targets: (3..7).map(|state| vec![state]).collect(),
        statements,
    })
}

/// Writes the case as a model in which paths start in every state.
fn load(case: &Case, empty: Empty) -> (Arc<Program>, Arc<Preferences>) {
    let last = case.mdp.0.len() - 1;
    let mut text = format!("mdp\nmodule m\n  s : [0..{last}];\n");
    for (s, choices) in case.mdp.0.iter().enumerate() {
        for to in choices {
            let branch = |t: &usize| format!("1/{}: (s'={t})", to.len());
            text += &format!("  [] s={s} -> {};\n", to.iter().map(branch).collect::<Vec<_>>().join(" + "));
        }
    }
    text += "endmodule\ninit true endinit\n";
    let mut wishes = format!("empty = {empty};\n");
    for (i, target) in case.targets.iter().enumerate() {
        let states: Vec<String> = target.iter().map(|t| format!("s={t}")).collect();
        let target = if states.is_empty() { "false".to_owned() } else { states.join(" | ") };
        wishes += &format!("objective o{i} = F ({target});\n");
    }
    for statement in &case.statements {
        let relation = match statement.relation {
            Relation::Strict => ">",
            Relation::Weak => ">=",
            Relation::Indifferent => "~",
        };
        wishes += &format!("prefer o{} {relation} o{};\n", statement.left, statement.right);
    }
    task(text, wishes)
}

/// The numbers of checks, so that a test that checks nothing fails.
#[derive(Debug, Default)]
struct Seen {
    kept: usize,
    passed_over: usize,
    committed: usize,
    exchanged: usize,
    given_up: usize,
}

impl Seen {
    fn is_enough(&self) -> bool {
        let kept = self.kept > 2000 && self.passed_over > 40;
        kept && self.committed > 60 && self.exchanged > 20 && self.given_up > 15
    }
}

struct Check<'a> {
    literal: &'a Literal<'a>,
    preferences: &'a Preferences,
    safety: Safety,
}

fn set(objectives: &ObjectiveSet) -> Set {
    objectives.iter().collect()
}

fn state(node: &Node) -> usize {
    node.at.state[0] as usize
}

impl Check<'_> {
    /// The states from which kept choices reach the target of an objective almost surely.
    fn kept_alone(&self, objective: usize, reference: &Set) -> Set {
        let (case, literal) = (self.literal.case, self.literal);
        let safe = literal.safe(reference);
        let keeps = |s: usize, a: usize| match self.safety {
            Safety::Prefix => safe.contains(&s) && case.mdp.0[s][a].iter().all(|t| safe.contains(t)),
            // A choice that `transition` keeps may still weaken, so it has to be one of `action`.
            _ => !literal.kept(Safety::Action, s, a).is_empty(),
        };
        let choices = |s: usize| {
            let kept = (0..case.mdp.0[s].len()).filter(|&a| keeps(s, a));
            kept.map(|a| case.mdp.0[s][a].clone()).collect()
        };
        let kept = Mdp((0..case.mdp.0.len()).map(choices).collect());
        almost_sure(&kept, &case.targets[objective].iter().copied().collect())
    }

    fn of_prefix(&self, reference: &Set, s: usize) -> Set {
        if self.safety == Safety::Prefix { reference.clone() } else { self.literal.mp[s].clone() }
    }

    /// Checks the pursuit that begins in a state: the first candidate that kept choices achieve, else a
    /// commitment to the first one.
    fn begins(&self, s: usize, candidates: &Set, reference: &Set, pursuit: Pursuit, seen: &mut Seen) {
        let kept = |objective: &&usize| self.kept_alone(**objective, reference).contains(&s);
        match candidates.iter().find(kept) {
            Some(&objective) => {
                assert_eq!((pursuit.objective, pursuit.manner), (objective, Manner::Kept), "state {s}");
                seen.kept += 1;
                seen.passed_over += usize::from(candidates.first() != Some(&objective));
            }
            None => {
                let first = *candidates.first().unwrap();
                assert_eq!((pursuit.objective, pursuit.manner), (first, Manner::Committed), "state {s}");
                seen.committed += 1;
            }
        }
    }

    /// Checks a step of the plan.
    fn step(&self, from: &Node, to: &Node, improves: bool, dropped: bool, seen: &mut Seen) {
        let ((s, t), literal) = ((state(from), state(to)), self.literal);
        let committed = |node: &Node| node.at.memory.pursuit.is_some_and(|p| p.manner == Manner::Committed);
        let reference = self.of_prefix(&set(&from.at.reference), s);
        if !committed(from) {
            let taken_by_the_system = dropped && from.at.memory.pursuit.is_none();
            let weakens = literal.weakens(&reference, &literal.mp[t]);
            assert!(!weakens || taken_by_the_system, "{s} to {t}: {from:?}");
        }
        let next = if improves || committed(from) { literal.mp[t].clone() } else { reference };
        if self.safety == Safety::Prefix && !committed(to) {
            assert_eq!(set(&to.at.reference), next, "{s} to {t}");
        }
        match (from.at.memory.pursuit, to.at.memory.pursuit) {
            (Some(before), Some(now)) if before.objective == now.objective => {
                assert_eq!(before.manner, now.manner);
            }
            (Some(before), now) => {
                let now = now.expect("a plan keeps an objective");
                let better = |&&other: &&usize| self.preferences.order.strictly(other, before.objective);
                let candidates: Set = literal.mp[t].iter().filter(better).copied().collect();
                assert!(!literal.mp[t].contains(&before.objective));
                self.begins(t, &candidates, &self.of_prefix(&next, t), now, seen);
                seen.exchanged += 1;
            }
            (None, Some(now)) => self.begins(t, &literal.mp[t], &self.of_prefix(&next, t), now, seen),
            (None, None) => {}
        }
    }

    fn unfolded(&self, unfolded: &InducedModel, seen: &mut Seen) {
        assert!(unfolded.complete);
        let (start, nodes) = (&unfolded.nodes[0], &unfolded.nodes);
        if let Some(pursuit) = start.at.memory.pursuit {
            let mp = &self.literal.mp[state(start)];
            self.begins(state(start), mp, mp, pursuit, seen);
        }
        for node in nodes {
            assert_eq!(set(&node.at.most_preferred), self.literal.mp[state(node)]);
            for (action, next) in node.at.actions.iter().zip(&node.next) {
                for (successor, to) in action.successors.iter().zip(next) {
                    let Some(to) = to else { continue };
                    self.step(node, &nodes[*to], successor.improves, successor.dropped, seen);
                }
            }
        }
        self.ends(unfolded);
    }

    /// The pursued objective is achieved almost surely.
    fn ends(&self, unfolded: &InducedModel) {
        let to = |(node, next): (usize, Vec<(usize, bool)>)| match next.is_empty() {
            true => vec![node],
            false => next.into_iter().map(|(to, _)| to).collect(),
        };
        let chain: Vec<Vec<usize>> = edges(unfolded).into_iter().enumerate().map(to).collect();
        for component in bottom_components(&chain, 0, &Set::new()) {
            for &node in &component {
                let Some(pursuit) = unfolded.nodes[node].at.memory.pursuit else { continue };
                let target = &self.literal.case.targets[pursuit.objective];
                assert!(component.len() == 1 && target.contains(&state(&unfolded.nodes[node])));
            }
        }
    }

    /// Recounts a simulated run.
    fn run(&self, start: usize, trace: &Trace, seen: &mut Seen) {
        let (mut s, mut committed, mut expected) = (start, false, Vec::new());
        let first = &self.literal.mp[start];
        for turn in &trace.turns {
            let t = turn.state[0] as usize;
            let (from, to) = (&self.literal.mp[s], &self.literal.mp[t]);
            if let Some(objective) = turn.commits {
                committed = true;
                expected.push((objective, Set::new()));
            }
            let weakens = self.literal.weakens(from, to);
            assert_eq!(turn.weakens_step, weakens && !committed);
            assert_eq!(turn.weakens_start, self.literal.weakens(first, to) && !committed);
            assert_eq!(turn.committed, committed);
            if committed
                && weakens
                && let Some((_, given_up)) = expected.last_mut()
            {
                let worse =
                    |i: usize| to.is_empty() || to.iter().any(|&j| self.preferences.order.strictly(i, j));
                given_up.extend(from.iter().filter(|&&i| worse(i)));
            }
            s = t;
        }
        seen.given_up += expected.iter().filter(|(_, given_up)| !given_up.is_empty()).count();
        let found = trace.commitments().into_iter();
        let found: Vec<_> =
            found.map(|Commitment { objective, gives_up }| (objective, set(&gives_up))).collect();
        assert_eq!(found, expected);
    }
}

fn check(case: &Case, empty: Empty, storage: Storage, seen: &mut Seen) {
    let (program, preferences) = load(case, empty);
    let literal = Literal::new(case, empty);
    let settings = Settings { scope: Scope::All, storage, memory: 16 << 20, ..Settings::default() };
    let engine = Arc::new(AnyEngine::new(Arc::clone(&program), settings).unwrap());
    for &safety in Safety::ALL {
        let analysis = finished(&engine, &preferences, Options { safety, max_level: None });
        let kind = StrategyKind::Plan;
        let strategy = FiniteMemoryStrategy::of_kind(&analysis, &program, kind, Kind::Sasi, None).unwrap();
        let mut strategy = strategy.unwrap();
        let check = Check { literal: &literal, preferences: &preferences, safety };
        for start in 0..case.mdp.0.len() {
            let starts = [vec![start as i64]];
            for scheduler in [Scheduler::Progress, Scheduler::Permissive] {
                let unfolded = InducedModel::unfold(&mut strategy, &starts, scheduler, 10_000).unwrap();
                check.unfolded(&unfolded, seen);
            }
            let setup = Setup { scheduler: Scheduler::Permissive, runs: 5, steps: 30, seed: 1 };
            let mut each = |trace: &Trace| check.run(start, trace, seen);
            Simulation::new(&mut strategy, setup).run_each(&starts[0], &mut each).unwrap();
        }
    }
}

#[test]
fn plans_keep_what_they_promise() {
    let config = Config { cases: 400, failure_persistence: None, ..Config::default() };
    let drawn = (prop_oneof![case(6), crossing()], prop::sample::select(Empty::ALL), any::<bool>());
    draw_until(&config, &drawn, Seen::is_enough, |(case, empty, symbolic), seen| {
        let storage = if symbolic { Storage::Symbolic } else { Storage::Explicit };
        check(&case, empty, storage, seen);
    });
}
