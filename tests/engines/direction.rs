//! Questions about the initial states: answered over all valuations, or with an engine of the reachable states,
//! whichever ends first.

use meliora::engine::regions::{self, Which};
use meliora::engine::{Guided, RacedQuestion, Racer, Selection};
use meliora::error::Result;
use proptest::prelude::*;

use crate::cli::direction::register;
use crate::common::prelude::*;
use crate::engines::explicit::numbers;
use crate::engines::selection::program;

fn settings(work_before_diagrams: u64, first_turn: u64) -> Settings {
    let thresholds = Thresholds { work_before_diagrams, first_turn, ..Thresholds::default() };
    Settings { memory: 64 << 20, thresholds, ..Settings::default() }
}

/// The initial states in each region.
fn initial<E: Engine>(engine: &E, target: &Predicate) -> Result<Vec<Vec<State>>> {
    let found = regions(engine, &engine.states_where(target)?)?;
    let initial = engine.initial_states();
    let inside = |which: Which| {
        let states = engine.intersection(found.get(which), &initial)?;
        engine.list_states(&states, usize::MAX)
    };
    Which::ALL.into_iter().map(inside).collect()
}

/// Returns whether some strategy reaches a target almost surely from all initial states.
fn is_sure<E: Engine>(engine: &E, target: &Predicate) -> Result<bool> {
    let sure = regions::pmax_one(engine, &engine.states_where(target)?)?;
    engine.is_empty(&engine.difference(&engine.initial_states(), &sure)?)
}

/// The way that has answered.
#[derive(Debug, Clone, Copy, PartialEq)]
enum By {
    States,
    Everywhere,
    Guided,
}

/// Asks whether some strategy reaches a target almost surely, in all ways.
fn is_sure_in_turns(program: &Arc<Program>, target: &Predicate, settings: Settings) -> Result<(bool, By)> {
    let by_states = |_: &Racer, engine: AnyEngine| Ok((is_sure(&engine, target)?, By::States));
    let judge = |engine: &SymbolicEngine| Ok((is_sure(engine, target)?, By::Everywhere));
    let searched = |search: Guided| Ok((search.answer() == Some(true), By::Guided));
    let question = RacedQuestion {
        everywhere: Some(&judge),
        guided: Some((target, &searched)),
        ..RacedQuestion::new(&by_states)
    };
    Selection::open().answer(program, settings, &question)
}

/// Asks for the initial states in each region.
fn decided(
    program: &Arc<Program>,
    target: &Predicate,
    settings: Settings,
) -> Result<(Vec<Vec<State>>, By, Selection)> {
    let by_states = |_: &Racer, engine: AnyEngine| Ok((initial(&engine, target)?, By::States));
    let judge = |engine: &SymbolicEngine| Ok((initial(engine, target)?, By::Everywhere));
    let question = RacedQuestion { everywhere: Some(&judge), ..RacedQuestion::new(&by_states) };
    let mut selection = Selection::open();
    let (found, by) = selection.answer(program, settings, &question)?;
    Ok((found, by, selection))
}

proptest! {
    #![proptest_config(meliora_amount::random(60))]

    #[test]
    fn whichever_way_ends_first_judges_the_initial_states_alike(of in numbers(160), goal in numbers(20)) {
        let mut program = random_program(&of, false);
        let target = random_predicate(&mut program, &goal);
        let program = Arc::new(program);
        let target = program.predicate(target);
        let explicit = ExplicitEngine::new(program.clone(), settings(0, 1)).unwrap();
        let expected = initial(&explicit, &target).unwrap();
        for first_turn in [1, 20, 300, 1 << 20] {
            for work in [0, 1 << 20] {
                let (found, ..) = decided(&program, &target, settings(work, first_turn)).unwrap();
                prop_assert_eq!(&found, &expected, "{} {}", work, first_turn);
            }
        }
        let sure = is_sure(&explicit, &target).unwrap();
        for first_turn in [1, 20, 300] {
            let (found, _) = is_sure_in_turns(&program, &target, settings(0, first_turn)).unwrap();
            prop_assert_eq!(found, sure, "in turns of {}", first_turn);
        }
        if let Some(engine) = SymbolicEngine::everywhere(program.clone(), settings(0, 1)).unwrap() {
            prop_assert_eq!(&initial(&engine, &target).unwrap(), &expected);
            let reached = explicit.list_states(&explicit.all_states(), usize::MAX).unwrap();
            for state in reached {
                prop_assert!(engine.contains(&engine.all_states(), &state).unwrap());
            }
        }
    }
}

fn target(program: &Arc<Program>, text: &str) -> Predicate {
    let source = meliora::error::SourceFile::new("target", text);
    let parsed = meliora::lang::parse_expression(&source).unwrap();
    meliora::lang::lower_target(program, &source, &parsed).unwrap()
}

#[test]
fn all_valuations_answer_before_a_long_way_forward_ends() {
    let program = program(&register());
    let (found, by, selection) = decided(&program, &target(&program, "done"), Settings::default()).unwrap();
    assert_eq!((found.iter().map(Vec::len).collect::<Vec<_>>(), by), (vec![1, 1, 0, 0], By::Everywhere));
    assert!(selection.reason.unwrap().contains("over all valuations"));
}

#[test]
fn a_question_of_the_scope_all_has_its_states_counted() {
    let program = program("mdp module m x : [0..9999]; [] x>0 -> (x'=x-1); endmodule");
    let settings = Settings { scope: Scope::All, ..settings(0, 1) };
    let (_, by, _) = decided(&program, &target(&program, "x=0"), settings).unwrap();
    assert_eq!(by, By::States);
}

/// A model whose command leaves the range of x where y = FAULT, and whose y is 0 or 1 where reachable.
fn faulty(fault: &str) -> Arc<Program> {
    program(&format!(
        "mdp module m x : [0..99]; y : [0..99]; [] y={fault} -> (x'=x+100); \
         [] y<2 -> 0.5: (y'=1-y) + 0.5: (x'=mod(x+7, 100)); [] y>2 -> (y'=y-1); endmodule"
    ))
}

#[test]
fn a_state_without_a_meaning_counts_only_if_it_is_reached() {
    let engine = SymbolicEngine::everywhere(faulty("5"), settings(0, 1)).unwrap().expect("5 is not reached");
    // From 6 and above, 5 is reached.
    assert_eq!(engine.count(&engine.all_states()).unwrap(), 500u32.into());
    assert!(SymbolicEngine::everywhere(faulty("1"), settings(0, 1)).unwrap().is_none());
    for first_turn in [1, 1 << 20] {
        let program = faulty("1");
        let reached = decided(&program, &target(&program, "x=3"), settings(0, first_turn));
        assert!(matches!(reached, Err(Error::Input(_))), "a fault that is reached");
        let program = faulty("5");
        let (found, ..) = decided(&program, &target(&program, "x=3"), settings(0, first_turn)).unwrap();
        assert_eq!(found.iter().map(Vec::len).collect::<Vec<_>>(), [1, 1, 1, 1]);
        // The target has no value where y = 5, which is not reached, or where y = 1, which is.
        let (found, ..) =
            decided(&program, &target(&program, "mod(x, (y-5)*(y-5)) = 3"), settings(0, first_turn)).unwrap();
        assert_eq!(found[0].len(), 1);
        let without =
            decided(&program, &target(&program, "mod(x, (y-1)*(y-1)) = 3"), settings(0, first_turn));
        assert!(matches!(without, Err(Error::Input(_))));
    }
}

#[test]
fn a_guided_search_answers_by_the_states_near_its_way() {
    let program = program(&register());
    let found = is_sure_in_turns(&program, &target(&program, "done"), settings(0, 1)).unwrap();
    assert_eq!(found, (true, By::Guided));
}
