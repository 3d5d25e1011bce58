//! Runs and induced models keep what their strategies promise.

use std::collections::BTreeSet;
use std::sync::Arc;

use meliora::advanced::lang::ltl::{Monitoring, parse_formula};
use meliora::engine::{Algebra, AnyEngine, Engine, Settings};
use meliora::error::SourceFile;
use meliora::export::explicit::{induced, umb};
use meliora::lang::{Document, Given};
use meliora::model::State;
use meliora::model::temporal::Begin;
use meliora::planning::RegionSearch;
use meliora::planning::tally::Trace;
use meliora::planning::{
    FiniteMemoryStrategy, Kind, Rank, Safety, Scheduler, Setup, Simulation, StrategyKind,
};
use meliora::progress::NoProgress;
use meliora::quantities::{Aim, Chooser, Earned};
use proptest::prelude::*;

use crate::Analysed;
use crate::random_case::{REWARDS, random_case};

/// The largest number of steps of a run.
const STEPS: u64 = 30;

/// Follows a run with the memory of its strategy: each step is permitted, and none is unsafe.
fn follow(of: &Analysed, strategy: &mut FiniteMemoryStrategy, start: &State, trace: &Trace) {
    let (mut state, mut memory) = (start.clone(), strategy.start(start).unwrap());
    for turn in &trace.turns {
        let at = strategy.explain(&state, memory).unwrap();
        let action = at.actions.iter().find(|a| a.name == turn.action && a.permitted);
        let action = action.unwrap_or_else(|| panic!("{} is not permitted: {at:?}", turn.action));
        let to = action.successors.iter().find(|s| s.state == turn.state).unwrap();
        assert!(!to.is_unsafe && !of.analysis.is_unsafe(&turn.state).unwrap(), "{at:?}");
        (state, memory) = (turn.state.clone(), to.next);
    }
}

/// The strategies that choose by value.
fn by_value(of: &Analysed) -> [FiniteMemoryStrategy; 2] {
    [(Aim::Likely, StrategyKind::Spi), (Aim::Cheap, StrategyKind::Sasi)].map(|(aim, kind)| {
        let structure = &of.program.rewards[of.program.reward_structure(Some(REWARDS)).unwrap()];
        let costs = Earned { program: &of.program, structure };
        let states = of.safe_states();
        let rule = Chooser::compute(&of.analysis, &of.program, &states, (aim, Some(2)), &costs);
        let mut strategy = of.strategy(kind, None);
        strategy.choose_by(Arc::new(rule.unwrap()));
        strategy
    })
}

/// Checks runs from every state from which the requirements can be kept.
fn simulate(of: &Analysed) {
    let safety = of.analysis.options().safety;
    for mut strategy in of.strategies().into_iter().chain(by_value(of)) {
        for start in of.safe_states() {
            for scheduler in [Scheduler::Permissive, Scheduler::Progress] {
                let setup = Setup { scheduler, runs: 3, steps: STEPS, seed: 7 };
                let mut traces = Vec::new();
                let mut each = |trace: &Trace| traces.push(trace.clone());
                let tally = Simulation::new(&mut strategy, setup).run_each(&start, &mut each).unwrap();
                traces.iter().for_each(|trace| follow(of, &mut strategy, &start, trace));
                let improves = matches!(strategy.kind(), StrategyKind::Sasi | StrategyKind::Spi);
                match safety {
                    Safety::Action if improves => assert_eq!(tally.weakened_step, 0),
                    Safety::Prefix if improves => assert_eq!(tally.weakened_reference, 0),
                    _ => {}
                }
            }
        }
    }
}

/// Writes the Markov chain of a strategy, reads it again, and returns the initial states from which a
/// formula is almost sure, and those from which it is possible. States are those of the model.
fn regions_of(of: &Analysed, strategy: &mut FiniteMemoryStrategy, formula: &str) -> [BTreeSet<State>; 2] {
    let graph = induced(&of.analysis, &of.program, strategy, Scheduler::Progress, 10_000).unwrap();
    let archive = umb(&graph, &of.analysis, &of.program, None).unwrap();
    let given = Given { constants: SourceFile::new("c", ""), bounds: SourceFile::new("b", "") };
    let document = Document::read("m.umb", archive.as_slice()).unwrap();
    let program = document.load(&given, &NoProgress).unwrap().program;
    let position = |name: &String| program.variables.iter().position(|v| v.name == *name).unwrap();
    let positions: Vec<usize> = of.program.variables.iter().map(|v| position(&v.name)).collect();
    let source = SourceFile::new("formula", formula);
    let formula = parse_formula(&source).unwrap();
    let mut monitoring = Monitoring::new(&program);
    let condition = monitoring.watch(&source, &formula, "promise").unwrap();
    let program = monitoring.finish(Begin::Initially).unwrap();
    let condition = condition.map(&|mark| program.predicate(mark));
    let settings = Settings { memory: 16 << 20, ..Settings::default() };
    let engine = AnyEngine::new(Arc::new(program), settings).unwrap();
    let found = RegionSearch::of_condition(&engine, &condition).all().unwrap();
    [found.pmin_one, found.pmin_positive].map(|region| {
        let region = engine.intersection(&region, &engine.initial_states()).unwrap();
        let states = engine.list_states(&region, usize::MAX).unwrap();
        states.into_iter().map(|state| positions.iter().map(|&at| state[at]).collect()).collect()
    })
}

/// The formula that a number of improvements are made; with SASI, the path then ends.
fn improvements(kind: Kind, times: usize) -> String {
    let settled = if kind == Kind::Sasi { "F \"settled\"" } else { "true" }.to_owned();
    (0..times).fold(settled, |after, _| format!("F (\"improved\" & X {after})"))
}

/// Checks the chains of strategies that improve, and of those that achieve an objective.
fn induce(of: &Analysed, formulas: &[String]) -> usize {
    let engine = of.analysis.engine();
    let starts = engine.list_states(&engine.initial_states(), usize::MAX).unwrap();
    let mut kept = 0;
    for (o, formula) in formulas.iter().enumerate() {
        let [found, _] = regions_of(of, &mut of.strategy(StrategyKind::Achieve, Some(o)), formula);
        let promised = &of.analysis.outcomes().unwrap().get(o).unwrap().almost_sure;
        for start in starts.iter().filter(|s| engine.contains(promised, s).unwrap()) {
            assert!(found.contains(start), "o{o} is not achieved from {start:?}");
            kept += 1;
        }
    }
    if of.analysis.options().safety == Safety::Transition {
        return kept;
    }
    for (kind, times) in [Kind::Sasi, Kind::Spi].into_iter().flat_map(|kind| (0..=2).map(move |k| (kind, k)))
    {
        let [sure, possible] =
            regions_of(of, &mut of.strategy(kind.into(), None), &improvements(kind, times));
        let found = if kind == Kind::Sasi { sure } else { possible };
        for start in &starts {
            let rank = of.analysis.rank(kind, start).unwrap();
            let promised = !matches!(rank, Rank::Finite(k) if k < times);
            assert!(
                !promised || found.contains(start),
                "{kind}: fewer than {times} improvements from {start:?}"
            );
            kept += usize::from(promised && times > 0);
        }
    }
    kept
}

proptest! {
    #![proptest_config(crate::amount::random(30))]

    #[test]
    fn runs_take_permitted_steps_that_never_weaken_and_are_never_unsafe(case in random_case()) {
        let [symbolic, explicit, _] = Analysed::all(&case);
        simulate(&symbolic);
        simulate(&explicit);
    }

    #[test]
    fn induced_models_read_again_keep_the_promise_almost_surely(case in random_case()) {
        let [symbolic, explicit, _] = Analysed::all(&case);
        assert_eq!(induce(&symbolic, &case.formulas), induce(&explicit, &case.formulas));
    }
}
