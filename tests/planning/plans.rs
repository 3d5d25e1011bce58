//! Plans and strategies that achieve an objective, on random models: the chain that they induce ends
//! almost surely in what they promise.

use std::sync::Arc;

use meliora::engine::{AnyEngine, Engine, Scope, Settings, Storage};
use meliora::error::SourceFile;
use meliora::lang;
use meliora::model::Program;
use meliora::model::preference::{Goal, Preferences};
use meliora::planning::{
    Analysis, FiniteMemoryStrategy, InducedModel, Options, Rank, Scheduler, StrategyKind, temporal,
};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};

use crate::SAFETIES;
use crate::literal::Set;
use crate::plays::edges;
use crate::regions::bottom_components;

pub(crate) const FORMULAS: [&str; 12] = [
    "F s=1",
    "F (s=2 | s=3)",
    "G F s=0",
    "F G !(s=1)",
    "F (s=1 & F s=2)",
    "!(s=1) U s=2",
    "(G F s=0) & (G F s=3)",
    "G !(s=2)",
    "(F G s=0) | ((G F s=1) & (F s=2))",
    "!(s=2) U (G s!=1)",
    "(F s=1) W s=2",
    "G (s=1 => F (s=0 & G F s=3))",
];

/// A random model: for each state its choices, for each choice where it leads; formulas by their
/// positions; which are preferred to which; whether the history counts; a state to avoid.
pub(crate) type Drawn = (Vec<Vec<Vec<usize>>>, Vec<usize>, Vec<(usize, usize)>, bool, Option<usize>);

pub(crate) fn drawn() -> impl Strategy<Value = Drawn> {
    let leads = prop::collection::vec(0..5usize, 1..=3);
    let choices = prop::collection::vec(prop::collection::vec(leads, 0..=3), 4..=5);
    let formulas = prop::collection::vec(0..FORMULAS.len(), 1..=3);
    let above = prop::collection::vec((0..3usize, 0..3usize), 0..=3);
    (choices, formulas, above, any::<bool>(), prop::option::weighted(0.2, 0..4usize))
}

/// Writes a model in which paths start in every state.
pub(crate) fn model(choices: &[Vec<Vec<usize>>]) -> String {
    let last = choices.len() - 1;
    let mut text = format!("mdp\nmodule m\n  s : [0..{last}];\n");
    for (s, choices) in choices.iter().enumerate() {
        for to in choices {
            let branch = |t: &usize| format!("1/{}: (s'={})", to.len(), t.min(&last));
            text += &format!("  [] s={s} -> {};\n", to.iter().map(branch).collect::<Vec<_>>().join(" + "));
        }
    }
    text + "endmodule\ninit true endinit\n"
}

fn load((choices, formulas, above, history, avoid): &Drawn) -> (Arc<Program>, Arc<Preferences>) {
    // Without a history, only the first two formulas are objectives.
    let kinds = if *history { FORMULAS.len() } else { 2 };
    let mut wishes = if *history { "history = play;\n".to_owned() } else { String::new() };
    for (i, formula) in formulas.iter().enumerate() {
        wishes += &format!("objective o{i} = {};\n", FORMULAS[formula % kinds]);
    }
    for (i, j) in above.iter().filter(|(i, j)| i > j && *i < formulas.len()) {
        wishes += &format!("prefer o{i} > o{j};\n");
    }
    if let Some(state) = avoid {
        wishes += &format!("require G !(s={state});\n");
    }
    let text = model(choices);
    let mut program = lang::load(&SourceFile::new("m", text), &SourceFile::new("c", "")).unwrap().program;
    let preferences = lang::load_preferences(&SourceFile::new("p", wishes), &mut program).unwrap();
    (Arc::new(program), Arc::new(preferences))
}

/// What was checked, so that a test that checks nothing fails.
#[derive(Debug, Default)]
struct Seen {
    achieved: usize,
    kept: usize,
    improved: usize,
}

struct Check<'a> {
    analysis: &'a Analysis<AnyEngine>,
    kind: StrategyKind,
    objective: Option<usize>,
}

impl Check<'_> {
    /// Checks the chain from a state of the scope in which the kind promises to achieve something.
    fn chain(&self, unfolded: &InducedModel, seen: &mut Seen) {
        assert!(unfolded.complete);
        let edges = edges(unfolded);
        seen.improved += usize::from(edges.iter().flatten().any(|(_, improves)| *improves));
        let chain: Vec<Vec<usize>> = edges
            .iter()
            .enumerate()
            .map(|(node, to)| match to.is_empty() {
                true => vec![node],
                false => to.iter().map(|(to, _)| *to).collect(),
            })
            .collect();
        for component in bottom_components(&chain, 0, &Set::new()) {
            self.component(unfolded, &component, seen);
        }
    }

    /// Checks the nodes that a run visits infinitely often, or the one where it ends.
    fn component(&self, unfolded: &InducedModel, component: &Set, seen: &mut Seen) {
        let first = &unfolded.nodes[*component.first().unwrap()].at;
        let Some(objective) = first.pursued() else {
            let unbounded = first.memory.level == Rank::Unbounded;
            let nothing = first.most_preferred.is_empty();
            assert!(self.kind == StrategyKind::Plan && (nothing || unbounded), "{first:?}");
            return;
        };
        for &node in component {
            let at = &unfolded.nodes[node].at;
            assert_eq!(at.pursued(), Some(objective));
            match self.kind {
                StrategyKind::Plan => assert!(at.most_preferred.contains(objective), "{at:?}"),
                _ => assert_eq!(self.objective, Some(objective)),
            }
        }
        if first.is_achieved() {
            assert_eq!(component.len(), 1);
            seen.achieved += 1;
        } else {
            self.kept(unfolded, component, objective);
            seen.kept += 1;
        }
    }

    /// Checks the acceptance condition on the nodes that are visited infinitely often.
    fn kept(&self, unfolded: &InducedModel, component: &Set, objective: usize) {
        let engine = self.analysis.engine();
        let Goal::Satisfy { condition, .. } = &self.analysis.preferences().objectives[objective].goal else {
            panic!("a target is reached almost surely");
        };
        let all = |set: &<AnyEngine as Engine>::States, some: bool| {
            let holds = |node: &usize| engine.contains(set, &unfolded.nodes[*node].at.state).unwrap();
            if some { component.iter().any(holds) } else { component.iter().all(holds) }
        };
        let accepted = condition.disjuncts().unwrap().iter().any(|disjunct| {
            all(&temporal::allowed(engine, disjunct).unwrap(), false)
                && disjunct.again.iter().all(|mark| all(&engine.states_where(*mark).unwrap(), true))
        });
        assert!(accepted, "objective {objective} is not satisfied forever: {component:?}");
    }
}

fn check(drawn: &Drawn, storage: Storage, seen: &mut Seen) {
    let (program, preferences) = load(drawn);
    let settings = Settings { scope: Scope::All, storage, memory: 16 << 20, ..Settings::default() };
    let engine = Arc::new(AnyEngine::new(Arc::clone(&program), settings).unwrap());
    for safety in SAFETIES {
        let mut analysis = Analysis::new(&engine, &preferences, Options { safety, max_level: None });
        analysis.run(&mut |_| ()).unwrap();
        let achieve = (0..preferences.objectives.len()).map(|o| (StrategyKind::Achieve, Some(o)));
        for (kind, objective) in achieve.chain([(StrategyKind::Plan, None)]) {
            let strategy =
                FiniteMemoryStrategy::of_kind(&analysis, &program, kind, kind.levels(), objective).unwrap();
            let mut strategy = strategy.unwrap();
            let analysed = analysis.engine();
            let starts = match objective {
                None => analysed.all_states(),
                Some(o) => analysis.outcomes().unwrap().get(o).unwrap().almost_sure.clone(),
            };
            for start in analysed.list_states(&starts, 12).unwrap() {
                for scheduler in [Scheduler::Progress, Scheduler::Permissive] {
                    let starts = std::slice::from_ref(&start);
                    let unfolded = InducedModel::unfold(&mut strategy, starts, scheduler, 10_000).unwrap();
                    Check { analysis: &analysis, kind, objective }.chain(&unfolded, seen);
                }
            }
        }
    }
}

#[test]
fn what_is_sure_is_achieved() {
    let mut seen = Seen::default();
    let config = Config { cases: 150, failure_persistence: None, ..Config::default() };
    let seen_by = std::cell::RefCell::new(&mut seen);
    let outcome = TestRunner::new(config).run(&drawn(), |drawn| {
        for storage in [Storage::Symbolic, Storage::Explicit] {
            check(&drawn, storage, &mut seen_by.borrow_mut());
        }
        Ok(())
    });
    outcome.unwrap_or_else(|e| panic!("{e}"));
    assert!(seen.achieved > 1000 && seen.kept > 1000, "{seen:?}");
}

// Few random models have guaranteed improvements.
#[test]
fn plans_improve_and_then_achieve() {
    // From 0, chance decides between 1 and 2, where different objectives are sure.
    let choices = vec![vec![vec![1, 2]], vec![vec![1]], vec![vec![2]], vec![]];
    for (history, formulas) in [(false, vec![0, 1]), (true, vec![0, 1, 7])] {
        for storage in [Storage::Symbolic, Storage::Explicit] {
            let mut seen = Seen::default();
            let drawn = (choices.clone(), formulas.clone(), vec![], history, None);
            check(&drawn, storage, &mut seen);
            assert!(seen.achieved > 0 && seen.improved > 0, "{drawn:?}: {seen:?}");
        }
    }
}
