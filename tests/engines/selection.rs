//! Several ways race for an answer: whichever ends first, the answer is the same.

use std::sync::Mutex;

use meliora::engine::{RacedQuestion, Racer, Selection};
use meliora::error::Result;
use meliora::progress::CancellationToken;
use proptest::prelude::*;

use crate::common::prelude::*;
use crate::engines::explicit::numbers;

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
    #![proptest_config(meliora_amount::random(40))]

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
        for (stage, threads) in [(0, 1), (1, 1), (2, 3), (5, 1), (13, 2), (200, 1), (200, 4), (1 << 20, 1)] {
            for lists_states in [false, true] {
                let answer = || {
                    let settings = Settings { threads, ..settings(scope, stage) };
                    let mut selection = Selection::open();
                    let by_states = |_: &Racer, engine: AnyEngine| Ok(listed(&engine, &target));
                    let question = RacedQuestion { lists_states, ..RacedQuestion::new(&by_states) };
                    let found = selection.answer(&program, settings, &question).unwrap();
                    (found, selection)
                };
                let (found, selection) = answer();
                prop_assert_eq!(&found, &expected, "{} {} {}", stage, threads, lists_states);
                prop_assert!(!selection.is_open);
                if threads == 1 {
                    prop_assert_eq!(answer().1, selection, "each run takes the same way");
                }
            }
        }
    }
}

pub(crate) fn program(text: &str) -> Arc<Program> {
    Arc::new(parsed(text))
}

/// Builds the engine that is the first to know all states.
fn built(
    selection: &mut Selection,
    program: &Arc<Program>,
    settings: Settings,
    lists_states: bool,
) -> Result<AnyEngine> {
    let by_states = |_: &Racer, engine: AnyEngine| Ok(engine);
    selection.answer(program, settings, &RacedQuestion { lists_states, ..RacedQuestion::new(&by_states) })
}

fn taken(text: &str, lists_states: bool) -> (AnyEngine, String) {
    taken_in(text, Settings::default(), lists_states)
}

fn taken_in(text: &str, settings: Settings, lists_states: bool) -> (AnyEngine, String) {
    let program = program(text);
    let mut selection = Selection::open();
    let engine = built(&mut selection, &program, settings, lists_states).unwrap();
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
            let settings = settings(Scope::Reachable, stage);
            let error = built(&mut Selection::open(), &program, settings, lists_states).err().unwrap();
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
        let settings = Settings { memory, ..Settings::default() };
        let error = built(&mut Selection::open(), &program, settings, lists_states).err().unwrap();
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

/// A model of 14,021 states that diagrams find at once, but whose fixpoints are long by diagrams.
const LONG_FIXPOINTS: &str = "mdp module m t : [0..1]; x : [0..2002] init 1; y : [0..6]; \
    [] t=0 -> (t'=1) & (x'=mod(5*x+y, 2003)); [] t=0 -> (t'=1) & (x'=mod(x*3+1, 2003)); \
    [] t=1 -> (t'=0) & (y'=mod(y+x, 7)); [] t=1 -> 0.5: (t'=0) & (y'=0) + 0.5: (t'=0); endmodule";

/// Answers by the regions of a target; the engine of diagrams has to wait after its first turn.
fn regions_in_short_turns(threads: usize) -> (Regions<Vec<State>>, Selection, Vec<usize>) {
    let program = program(LONG_FIXPOINTS);
    let asked = Mutex::new(Vec::new());
    let by_states = |racer: &Racer, engine: AnyEngine| {
        // The question is long for the first to know the states.
        let rounds = if asked.lock().unwrap().is_empty() { 200 } else { 1 };
        asked.lock().unwrap().push(racer.way);
        let target = engine.singleton(&[1, 0, 0])?;
        let mut found = regions(&engine, &target)?;
        for _ in 1..rounds {
            found = regions(&engine, &target)?;
        }
        Ok(found.map(|x| engine.list_states(&x, usize::MAX).unwrap()))
    };
    let settings = in_turns(Scope::Reachable, 1, 1 << 12);
    let thresholds = Thresholds { lead: 0, ..settings.thresholds };
    let settings = Settings { threads, thresholds, ..settings };
    let mut selection = Selection::open();
    let found = selection.answer(&program, settings, &RacedQuestion::new(&by_states)).unwrap();
    (found, selection, asked.into_inner().unwrap())
}

#[test]
fn other_ways_answer_a_question_that_is_long_for_the_first_to_know_the_states() {
    let (found, selection, asked) = regions_in_short_turns(1);
    let alone =
        ExplicitEngine::new(program(LONG_FIXPOINTS), Settings::default()).map(AnyEngine::from).unwrap();
    let expected = regions(&alone, &alone.singleton(&[1, 0, 0]).unwrap()).unwrap();
    let expected = expected.map(|x| alone.list_states(&x, usize::MAX).unwrap());
    assert_eq!(found, expected);
    assert!(asked.len() > 1, "{asked:?}");
    assert_eq!(regions_in_short_turns(1), (found.clone(), selection, asked), "each run takes the same turns");
    assert_eq!(regions_in_short_turns(3).0, found);
}

#[test]
fn an_engine_that_has_won_goes_on_without_turns() {
    let (engine, _) = taken_in(LONG_FIXPOINTS, in_turns(Scope::Reachable, 1, 1 << 10), false);
    let found = regions(&engine, &engine.singleton(&[1, 0, 0]).unwrap());
    assert!(found.is_ok());
}

/// Answers by the number of the way, in turns so short that each way begins. `by` says what a way does in its
/// first call, once it knows all states.
fn each_way(threads: usize, by: &(dyn Fn(&Racer) -> Result<()> + Sync)) -> Result<usize> {
    let thresholds = Thresholds { lead: 0, ..in_turns(Scope::Reachable, 1, 1 << 10).thresholds };
    let settings = Settings { threads, thresholds, ..Settings::default() };
    let by_states = |racer: &Racer, engine: AnyEngine| {
        by(racer)?;
        // The others have turns meanwhile.
        regions(&engine, &engine.singleton(&[1, 0, 0])?)?;
        Ok(racer.way)
    };
    Selection::open().answer(&program(LONG_FIXPOINTS), settings, &RacedQuestion::new(&by_states))
}

#[test]
fn a_real_way_that_panics_or_has_no_memory_does_the_same_in_each_position() {
    for threads in [1, 2, 8] {
        let known = Mutex::new(Vec::new());
        each_way(threads, &|racer| {
            known.lock().unwrap().push(racer.way);
            Ok(())
        })
        .unwrap();
        let known = known.into_inner().unwrap();
        assert!(!known.is_empty());
        for way in known {
            let full = || Err(Limit::Memory { what: "a table".to_owned() }.into());
            let left = each_way(threads, &|racer| if racer.way == way { full() } else { Ok(()) });
            assert_ne!(left.unwrap(), way, "another way has the answer");
            // Ways that no race with all cores needs may end before they begin.
            let raced = || each_way(1, &|racer| if racer.way == way { panic!("a fault") } else { Ok(()) });
            let panic = std::panic::catch_unwind(raced);
            assert!(threads > 1 || panic.is_err(), "the fault is passed on");
        }
    }
}

#[test]
fn a_cancelled_question_ends_all_ways() {
    for threads in [1, 2, 4] {
        let sink = Arc::new(CancellationToken::default());
        let settings =
            Settings { threads, sink: Arc::clone(&sink) as _, ..in_turns(Scope::Reachable, 1, 1 << 10) };
        let by_states = |_: &Racer, engine: AnyEngine| {
            sink.cancel();
            // This way never ends, and the others wait for their turns.
            loop {
                regions(&engine, &engine.singleton(&[1, 0, 0])?)?;
            }
        };
        let found: Result<()> =
            Selection::open().answer(&program(LONG_FIXPOINTS), settings, &RacedQuestion::new(&by_states));
        assert!(matches!(found, Err(Error::Limit(Limit::Interrupted))));
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
