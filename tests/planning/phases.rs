//! Analyses phase by phase: partial results, and another run after a limit.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use meliora::planning::Phase;

use crate::common::prelude::*;
use crate::planning::examples::{circle, toy};
use crate::planning::loaded::ladder;
use crate::planning::{Case, analyse};

/// Stops the work at one question, and never again.
struct StopOnce(AtomicU64);

impl ProgressSink for StopOnce {
    fn stop(&self) -> Option<Limit> {
        (self.0.fetch_sub(1, Relaxed) == 0).then_some(Limit::Interrupted)
    }
}

/// Stops an analysis at each question in turn, and runs it again: the result is that of a run
/// without a stop. `with_strategies`: during the second run strategies share the levels, where
/// their search had ended.
fn check_second_runs(case: &Case, safety: Safety, with_strategies: bool) {
    let engine = case.engine();
    let preferences = case.preferences(&engine, Empty::Bottom);
    let whole = analyse(&engine, &preferences, safety);
    let program = ladder().program;
    for question in 0.. {
        let sink = Arc::new(StopOnce(AtomicU64::new(question)));
        let engine = Arc::into_inner(case.engine()).unwrap().with_sink(sink);
        let engine = Arc::new(engine);
        let mut analysis = Analysis::new(&engine, &preferences, Options { safety, max_level: None });
        match analysis.run(&mut |_| ()) {
            Ok(()) => {
                assert!(question > 10, "stopped at few questions only");
                break;
            }
            Err(Error::Limit(Limit::Interrupted)) => {}
            Err(other) => panic!("{other}"),
        }
        let strategy = |kind| FiniteMemoryStrategy::new(&analysis, &program, kind);
        let strategies = with_strategies.then(|| [Kind::Sasi, Kind::Spi].map(strategy));
        analysis.run(&mut |_| ()).unwrap();
        assert_eq!(analysis.result(), whole.result(), "{safety}: stopped at question {question}");
        drop(strategies);
    }
}

#[test]
fn an_analysis_that_was_stopped_while_it_counted_is_completed_by_another_run() {
    for case in [toy(), circle(&[3])] {
        for &safety in Safety::ALL {
            check_second_runs(&case, safety, false);
        }
    }
}

#[test]
fn levels_that_a_strategy_shares_are_counted_by_another_run() {
    for case in [toy(), circle(&[3])] {
        check_second_runs(&case, Safety::Action, true);
    }
}

#[test]
fn another_run_of_a_finished_analysis_computes_nothing() {
    let case = toy();
    let engine = case.engine();
    let preferences = case.preferences(&engine, Empty::Bottom);
    let mut analysis = analyse(&engine, &preferences, Safety::Action);
    analysis.run(&mut |event| panic!("{event:?}")).unwrap();
}

#[test]
fn a_phase_needs_the_phase_before_it() {
    let case = toy();
    let engine = case.engine();
    let preferences = case.preferences(&engine, Empty::Bottom);
    let mut analysis = Analysis::new(&engine, &preferences, Options::default());
    let mut needs = |phase, before: &str| match analysis.run_phase(phase, &mut |_| ()) {
        Err(Error::Usage(message)) => assert!(message.ends_with(&format!("needs the phase `{before}`"))),
        other => panic!("{phase:?} without {before}: {other:?}"),
    };
    needs(Phase::Improvement, "outcomes");
    needs(Phase::Sasi, "improvement");
    needs(Phase::Spi, "improvement");
}

#[test]
fn there_are_no_plans_and_no_strategies_before_levels_are_searched() {
    let model = ladder();
    let mut analysis = model.fresh(Options::default());
    for (phase, known) in
        Phase::ALL.iter().zip([[false; 2], [false; 2], [false; 2], [true, false], [true; 2]])
    {
        let plans = |analysis: &Analysis<_>| {
            let prospects = analysis.prospects(&model.program, &[0]).unwrap();
            [prospects.sasi.is_some(), prospects.spi.is_some()]
        };
        let strategies = |analysis: &Analysis<_>| {
            [Kind::Sasi, Kind::Spi]
                .map(|kind| FiniteMemoryStrategy::new(analysis, &model.program, kind).is_some())
        };
        analysis.run_phase(*phase, &mut |_| ()).unwrap();
        assert_eq!((plans(&analysis), strategies(&analysis)), (known, known), "after {phase:?}");
    }
}
