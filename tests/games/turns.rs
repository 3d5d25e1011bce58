//! Random games of modules that synchronise and take turns: one engine against the other.

use proptest::prelude::*;

use super::{settings, thresholds};
use crate::common::prelude::*;
use crate::common::random_game::with_turns;

fn listed<E: Engine>(engine: &E, target: &Predicate) -> Regions<Vec<State>> {
    let found = regions(engine, &engine.states_where(target).unwrap()).unwrap();
    found.map(|x| engine.list_states(&x, usize::MAX).unwrap())
}

/// The regions when both sides may only do what lets us stay in a set.
fn required<E: Engine>(engine: &E, target: &Predicate, kept: &Predicate) -> Regions<Vec<State>> {
    let kept = engine.states_where(kept).unwrap();
    let region = engine.stay_within(&kept, &engine.all_choices()).unwrap();
    listed(&engine.restricted_to(&region).unwrap(), target)
}

fn players<E: Engine>(engine: &E) -> Vec<Vec<State>> {
    engine.player_states().iter().map(|x| engine.list_states(x, usize::MAX).unwrap()).collect()
}

proptest! {
    #![proptest_config(meliora_amount::random(300))]

    #[test]
    fn both_engines_agree_on_random_games(
        of in proptest::collection::vec(0u16..1000, 0..160),
        target in proptest::collection::vec(0u16..1000, 0..20),
        kept in proptest::collection::vec(0u16..1000, 0..20),
        bits in any::<u64>(),
        all in any::<bool>(),
    ) {
        let mut program = random_program(&of, false);
        program.kind = ModelKind::Mdp;
        with_turns(&mut program, bits);
        let [target, kept] = [target, kept].map(|of| random_predicate(&mut program, &of));
        let [target, kept] = [target, kept].map(|id| program.predicate(id));
        let program = Arc::new(program);
        let scope = if all { Scope::All } else { Scope::Reachable };
        let explicit = ExplicitEngine::new(program.clone(), settings(scope, thresholds()[0])).unwrap();
        for thresholds in thresholds() {
            let symbolic = SymbolicEngine::new(program.clone(), settings(scope, thresholds)).unwrap();
            prop_assert_eq!(players(&symbolic), players(&explicit));
            for coalition in [[true, false], [false, true], [true, true], [false, false]] {
                let (one, other) =
                    (symbolic.with_coalition(&coalition).unwrap(), explicit.with_coalition(&coalition).unwrap());
                prop_assert_eq!(listed(&one, &target), listed(&other, &target), "{:?}", coalition);
                let (one, other) = (required(&one, &target, &kept), required(&other, &target, &kept));
                prop_assert_eq!(one, other, "{:?} under a requirement", coalition);
            }
        }
    }
}
