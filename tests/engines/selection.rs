//! The selection of an engine by the states: both engines explore in turns, and whichever is taken, the
//! answers are the same.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use meliora::advanced::symbolic::Thresholds;
use meliora::engine::regions::{Regions, regions};
use meliora::engine::{
    Algebra, AnyEngine, Engine, ExplicitEngine, ProgressSink, Scope, Selection, Settings, Storage,
    SymbolicEngine,
};
use meliora::error::{Error, Limit, SourceFile};
use meliora::lang;
use meliora::model::predicate::Predicate;
use meliora::model::{Program, State};
use proptest::prelude::*;

use crate::common::handed_over;
use crate::common::random_program::{random_predicate, random_program};
use crate::explicit::numbers;

/// Settings in which the explicit engine explores for some work alone, and the first turn has as many steps.
fn settings(scope: Scope, stage: u64) -> Settings {
    in_turns(scope, stage, stage)
}

fn in_turns(scope: Scope, work_before_diagrams: u64, first_turn: u64) -> Settings {
    let thresholds = Thresholds { work_before_diagrams, first_turn, ..Thresholds::default() };
    Settings { scope, memory: 64 << 20, thresholds, ..Settings::default() }
}

fn listed<E: Engine>(engine: &E, target: &Predicate) -> (Regions<Vec<State>>, String) {
    let found = regions(engine, &engine.states_where(target).unwrap()).unwrap();
    let choices = engine.count(&engine.all_choices()).unwrap();
    let transitions = engine.count_transitions(&engine.all_choices(), &engine.all_states()).unwrap();
    let sets = [engine.all_states(), engine.initial_states(), engine.deadlock_states()];
    let sets = sets.map(|x| engine.list_states(&x, usize::MAX).unwrap());
    let found = found.map(|x| engine.list_states(&x, usize::MAX).unwrap());
    (found, format!("{choices} {transitions} {sets:?}"))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn turns_of_any_size_leave_the_answers_the_same(
        of in numbers(160),
        goal in numbers(20),
        all in any::<bool>(),
    ) {
        let mut program = random_program(&of, false);
        let target = random_predicate(&mut program, &goal);
        let program = Arc::new(program);
        let target = program.predicate(target);
        let scope = if all { Scope::All } else { Scope::Reachable };
        let symbolic = SymbolicEngine::new(program.clone(), settings(scope, 0)).unwrap();
        let explicit = ExplicitEngine::new(program.clone(), settings(scope, 0)).unwrap();
        let expected = listed(&explicit, &target);
        prop_assert_eq!(&listed(&symbolic, &target), &expected);
        for stage in [0, 1, 2, 3, 5, 8, 13, 40, 200, 1 << 20] {
            for lists_states in [false, true] {
                let build = || {
                    let mut selection = Selection::open();
                    let engine = selection.build(&program, settings(scope, stage), lists_states).unwrap();
                    (engine, selection)
                };
                let (engine, selection) = build();
                prop_assert_eq!(engine.storage(), selection.storage);
                prop_assert_eq!(&listed(&engine, &target), &expected, "{} {}", stage, lists_states);
                prop_assert_eq!(build().1, selection, "each run takes the same engine");
            }
        }
    }
}

pub(crate) fn program(text: &str) -> Arc<Program> {
    let none = SourceFile::new("constants", "");
    Arc::new(lang::load(&SourceFile::new("m", text), &none).unwrap().program)
}

fn taken(text: &str, lists_states: bool) -> (AnyEngine, String) {
    taken_in(text, Settings::default(), lists_states)
}

fn taken_in(text: &str, settings: Settings, lists_states: bool) -> (AnyEngine, String) {
    let program = program(text);
    let mut selection = Selection::open();
    let engine = selection.build(&program, settings, lists_states).unwrap();
    let name = selection.storage.name();
    (engine, format!("{name}: {}", selection.reason.unwrap_or_default()))
}

/// A round of 10,006 states whose numbers no bit tells.
const ROUND: &str =
    "x : [0..10006]; [] true -> 0.5: (x'=mod(5*x+3, 10007)) + 0.5: true; endmodule init x=0 endinit";

#[test]
fn few_states_are_found_one_by_one() {
    for kind in ["dtmc", "mdp"] {
        let text = format!("{kind} module m {ROUND}");
        for lists_states in [false, true] {
            let (engine, said) = taken(&text, lists_states);
            assert_eq!(said, "explicit: 10006 states found");
            assert_eq!(engine.count(&engine.all_states()).unwrap(), 10_006u32.into());
        }
        let (_, said) = taken_in(&text, in_turns(Scope::Reachable, 1, 1 << 11), false);
        assert_eq!(said, "explicit: 10006 states found, before diagrams found them");
    }
}

#[test]
fn states_that_are_too_many_for_a_share_of_the_memory_are_found_by_diagrams() {
    let text = "dtmc module m x : [0..99999999]; [] x<99999999 -> 0.5: (x'=x+1) + 0.5: true; endmodule";
    let settings = Settings { memory: 8 << 20, ..in_turns(Scope::Reachable, 1 << 30, 1 << 10) };
    let (engine, said) = taken_in(text, settings, false);
    assert_eq!(said, "symbolic: diagrams found all states first");
    assert_eq!(engine.count(&engine.all_states()).unwrap(), 100_000_000u32.into());
}

#[test]
fn states_that_share_their_nodes_are_found_by_diagrams() {
    let module = |i: usize| {
        format!("module m{i} x{i} : [0..9]; [] x{i}<9 -> 0.5: (x{i}'=x{i}+1) + 0.5: true; endmodule ")
    };
    for kind in ["dtmc", "mdp"] {
        let text = format!("{kind} {}", (0..9).map(module).collect::<String>());
        for lists_states in [false, true] {
            let (engine, said) = taken(&text, lists_states);
            assert_eq!(said, "symbolic: diagrams found all states first");
            assert_eq!(engine.count(&engine.all_states()).unwrap(), 1_000_000_000u32.into());
        }
    }
}

#[test]
fn many_initial_states_are_not_listed_in_vain() {
    let text = "dtmc module m x : [0..1073741823]; [] x>0 -> (x'=x-1); endmodule init true endinit";
    let (_, said) = taken(text, true);
    assert_eq!(said, "symbolic: diagrams found all states first");
}

#[test]
fn a_fault_that_either_engine_finds_is_one_of_the_model() {
    let text = "dtmc module m x : [0..999]; y : [0..999]; \
        [] x<900 -> (x'=mod(7*x+3, 1000)) & (y'=mod(3*y+x, 1000)); [] x>=900 -> (x'=x+100); endmodule";
    let program = program(text);
    for stage in [0, 100, 10_000] {
        for lists_states in [false, true] {
            let built = Selection::open().build(&program, settings(Scope::Reachable, stage), lists_states);
            let error = built.err().unwrap();
            assert!(!matches!(error, Error::Limit(_)), "{error}");
        }
    }
}

#[test]
fn a_small_memory_is_a_limit_of_both_together() {
    // Neither fits: the states are as many as the valuations, in an order that no diagram likes.
    let text = "dtmc const int N = 1000003; module m x : [0..N-1]; y : [0..N-1]; \
        [] true -> (x'=mod(5*x+3, N)) & (y'=mod(7*y+x, N)); endmodule";
    let program = program(text);
    for lists_states in [false, true] {
        let memory = 4 << 20;
        let built =
            Selection::open().build(&program, Settings { memory, ..Settings::default() }, lists_states);
        let error = built.err().unwrap();
        assert!(matches!(error, Error::Limit(Limit::Memory { .. })), "{error}");
    }
}

/// Two sides that take turns, each in a module of its own.
fn game(ours: &str, theirs: &str) -> String {
    let turn = "module turn t : [0..1]; [a] t=0 -> (t'=1); [b] t=0 -> (t'=1); [c] t=1 -> (t'=0); \
        [d] t=1 -> (t'=0); endmodule";
    format!(
        "smg player us [a], [b] endplayer player them [c], [d] endplayer {turn} \
         module ours {ours} endmodule module theirs {theirs} endmodule"
    )
}

/// Finds the states by diagrams in their first turn, then the regions of a target.
fn begun_by_diagrams(text: &str, target: &str) -> AnyEngine {
    let settings = in_turns(Scope::Reachable, 1, 1 << 40);
    let (engine, said) = taken_in(text, settings, false);
    assert_eq!(said, "symbolic: diagrams found all states first");
    assert_eq!(engine.storage(), Storage::Symbolic);
    finds_the_regions(&engine, target);
    engine
}

/// Compares the regions of a target with those of the explicit engine alone.
fn finds_the_regions(engine: &AnyEngine, target: &str) {
    let source = SourceFile::new("target", target);
    let target = lang::parse_expression(&source).unwrap();
    let target = lang::lower_target(engine.program(), &source, &target).unwrap();
    let found = regions(engine, &engine.states_where(&target).unwrap()).unwrap();
    let alone = ExplicitEngine::new(Arc::clone(engine.program()), Settings::default()).unwrap();
    let expected = regions(&alone, &alone.states_where(&target).unwrap()).unwrap();
    let [found, expected] =
        [found.map(|x| engine.count(&x).unwrap()), expected.map(|x| alone.count(&x).unwrap())];
    assert_eq!(found, expected);
}

/// A model of 14,021 states that diagrams find at once, but whose fixpoints are long by diagrams.
const LONG_FIXPOINTS: &str = "mdp module m t : [0..1]; x : [0..2002] init 1; y : [0..6]; \
    [] t=0 -> (t'=1) & (x'=mod(5*x+y, 2003)); [] t=0 -> (t'=1) & (x'=mod(x*3+1, 2003)); \
    [] t=1 -> (t'=0) & (y'=mod(y+x, 7)); [] t=1 -> 0.5: (t'=0) & (y'=0) + 0.5: (t'=0); endmodule";

#[test]
fn the_explicit_engine_takes_over_a_question_that_is_long_by_diagrams() {
    let begun = || begun_by_diagrams(LONG_FIXPOINTS, "t=1 & x=0 & y=0");
    let engine = begun();
    assert_eq!(engine.storage(), Storage::Explicit);
    let steps = engine.usage().taken_over_after;
    assert!(steps > Some(0));
    assert_eq!(begun().usage().taken_over_after, steps, "each run takes the same steps");
}

/// The engine of [`LONG_FIXPOINTS`] whose first turn ends soon.
fn in_short_turns(steps_per_work: u64) -> AnyEngine {
    let none = SourceFile::new("none", "");
    let program = lang::load(&SourceFile::new("m", LONG_FIXPOINTS), &none).unwrap().program;
    let settings = Settings { memory: 1 << 30, ..Settings::default() };
    handed_over::in_turns(&Arc::new(program), settings, steps_per_work)
}

#[test]
fn orders_take_turns_with_a_long_question_and_each_run_takes_the_same() {
    let ends = || {
        let engine = in_short_turns(u64::MAX);
        let before = engine.usage();
        for x in 0..3 {
            finds_the_regions(&engine, &format!("t=1 & x={x} & y=0"));
        }
        assert_eq!(engine.storage(), Storage::Symbolic);
        assert!(engine.usage().peak_nodes > before.peak_nodes);
        (engine.symbolic().unwrap().encoding().names(), engine.usage())
    };
    let (order, usage) = ends();
    assert_eq!(ends(), (order, usage));
}

#[test]
fn the_explicit_engine_takes_over_from_whichever_order_has_its_turn() {
    for steps_per_work in [1, 2, 4, 8, 12, 16] {
        let engine = in_short_turns(steps_per_work);
        finds_the_regions(&engine, "t=1 & x=0 & y=0");
        finds_the_regions(&engine, "t=1 & x=1 & y=0");
        let steps = engine.usage().taken_over_after;
        assert_eq!(engine.storage() == Storage::Explicit, steps.is_some());
        assert!(steps_per_work > 4 || steps.is_some(), "{steps_per_work}");
    }
}

#[test]
fn a_cancelled_question_is_not_taken_over() {
    let sink = Arc::new(Stopping::default());
    let settings = Settings { sink: Arc::clone(&sink) as _, ..in_turns(Scope::Reachable, 1, 1 << 40) };
    let (engine, _) = taken_in(LONG_FIXPOINTS, settings, false);
    sink.0.store(true, Relaxed);
    let target = engine.singleton(&[0, 0, 0]);
    assert!(matches!(target.err(), Some(Error::Limit(Limit::Interrupted))));
    assert_eq!(engine.usage().taken_over_after, None);
    sink.0.store(false, Relaxed);
    assert!(engine.singleton(&[0, 0, 0]).is_ok());
}

/// A sink that ends the work once it is true.
#[derive(Default)]
struct Stopping(AtomicBool);

impl ProgressSink for Stopping {
    fn stop(&self) -> Option<Limit> {
        self.0.load(Relaxed).then_some(Limit::Interrupted)
    }
}

#[test]
fn states_of_games_that_share_nodes_take_diagrams() {
    let ours = "x : [0..511]; u : [0..511]; [a] x<511 -> (x'=x+1); [b] u<511 -> 0.5: (u'=u+1) + 0.5: true;";
    let theirs = "y : [0..511]; [c] y<511 -> (y'=y+1); [d] true -> true;";
    let (engine, said) = taken(&game(ours, theirs), false);
    assert_eq!(said, "symbolic: diagrams found all states first");
    assert!(engine.count(&engine.all_states()).unwrap() > 1_000_000u32.into());
}
