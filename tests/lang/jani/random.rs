//! Random programs, written as JANI and read again, do the same in every state.

use meliora::model::step::StepError;
use proptest::prelude::*;

use super::write;
use crate::common::brute::valuations;
use crate::common::prelude::*;

/// Returns the sorted successors of all choices without action names; none for an error.
fn outcomes(steps: Result<Vec<Step>, StepError>) -> Option<Vec<Vec<(State, f64)>>> {
    let mut all: Vec<_> = steps.ok()?.into_iter().map(|s| s.successors).collect();
    all.sort_by(|a, b| format!("{a:?}").cmp(&format!("{b:?}")));
    Some(all)
}

fn read(program: &Program) -> Program {
    let text = write::document(program).to_string();
    parsed(text)
}

proptest! {
    #![proptest_config(meliora_amount::random(300))]
    #[test]
    fn written_and_read_again_programs_do_the_same(numbers in prop::collection::vec(any::<u16>(), 0..150),
                                                   faulty in any::<bool>()) {
        let program = random_program(&numbers, faulty);
        let again = read(&program);
        for state in valuations(&program) {
            let initial = |p: &Program| p.pool.eval(p.initial, &state).ok();
            prop_assert_eq!(initial(&program), initial(&again), "{:?}", state);
            prop_assert_eq!(outcomes(program.steps(&state)), outcomes(again.steps(&state)), "{:?}", state);
        }
    }

    #[test]
    fn written_in_the_modelling_language_they_do_the_same_too(
        numbers in prop::collection::vec(any::<u16>(), 0..150),
    ) {
        let program = read(&random_program(&numbers, false));
        let text = lang::flat(&program).unwrap();
        let again = lang::load(&SourceFile::new("flat.prism", &*text), &SourceFile::new("c", ""));
        let again = again.unwrap_or_else(|e| panic!("{e}: {text}")).program;
        // Variables may stand in another order.
        let positions: Vec<usize> =
            again.variables.iter().map(|v| program.variable(&v.name).unwrap().index()).collect();
        let there = |state: &[i64]| positions.iter().map(|&p| state[p]).collect::<State>();
        for state in valuations(&program) {
            let moved = |mut steps: Vec<Step>| {
                steps.iter_mut().flat_map(|s| &mut s.successors).for_each(|s| s.0 = there(&s.0));
                steps.iter_mut().for_each(|s| s.successors.sort_by(|a, b| a.0.cmp(&b.0)));
                steps
            };
            let here = outcomes(program.steps(&state).map(moved));
            prop_assert_eq!(here, outcomes(again.steps(&there(&state))), "{:?} {}", state, text);
        }
    }
}
