//! Values of games with many components, in which both sides together can stay.

use std::sync::Arc;

use bitvec::vec::BitVec;
use meliora_engine::{AnyEngine, Settings, Storage};
use meliora_model::Optimum;

use super::arenas::load;
use crate::graphs::arena::Arena;
use crate::graphs::game_graph::Extremes;
use crate::values::value::Value;
use crate::values::vector::{Accumulation, Asked, Until};

/// A row of rounds: in each, both sides may play again, or we may take the chance 2/5 to enter the next one. The last one
/// is won with the probability 1/2.
const ROUNDS: &str = "smg player us [a], [b] endplayer player them [c], [d] endplayer
    module m x : [0..4]; i : [0..300];
    [a] x=1 -> (x'=0); [b] x=1 & i<300 -> 2/5 : (x'=0)&(i'=i+1) + 3/5 : (x'=0);
    [b] x=1 & i=300 -> 1/2 : (x'=3) + 1/2 : (x'=4);
    [a] x=2 -> (x'=0); [b] x=2 & i<300 -> 2/5 : (x'=0)&(i'=i+1) + 3/5 : (x'=0);
    [c] x=0 -> (x'=1); [d] x=0 -> 1/2 : (x'=1) + 1/2 : (x'=2); [c] x>2 -> true; endmodule
    rewards [b] x=1 & i=300 : 2; endrewards";

/// Asks for the value in the initial state; returns its bounds, which are no fractions.
fn bounds(ask: impl Fn(&Arena<'_>, &AnyEngine, BitVec) -> Value) -> (f64, f64) {
    let program = load(ROUNDS);
    let settings = Settings { storage: Storage::Explicit, ..Settings::default() };
    let engine = AnyEngine::new(Arc::new(program.clone()), settings).unwrap();
    let arena = Arena::new(&engine, &program).unwrap();
    let won = (0..arena.states()).map(|state| arena.state(state)[0] == 3).collect();
    let Value::Finite(bounds) = ask(&arena, &engine, won) else { panic!("infinite") };
    assert_eq!(bounds.exact, None);
    (bounds.interval.lower, bounds.interval.upper)
}

fn start(arena: &Arena<'_>) -> usize {
    (0..arena.states()).find(|&state| arena.state(state) == [0, 0]).unwrap()
}

#[test]
fn components_in_which_both_sides_can_stay_have_narrow_bounds_in_doubles() {
    let goal = Extremes::against(Optimum::Max);
    let (lower, upper) = bounds(|arena, _, won| {
        let left = BitVec::repeat(true, arena.states());
        let until = Until::unbounded(left, won);
        Asked::all(arena, goal, 1e-6).probability(&until).unwrap().values.swap_remove(start(arena))
    });
    assert!(lower <= 0.5 && 0.5 <= upper && upper - lower <= 1e-6, "{lower} {upper}");
    let (lower, upper) = bounds(|arena, engine, won| {
        let rewards = arena.rewards(engine, 0).unwrap();
        let anyway = Accumulation::Anyway(won);
        Asked::all(arena, goal, 1e-6).reward(&rewards, &anyway).unwrap().values.swap_remove(start(arena))
    });
    assert!(lower <= 2.0 && 2.0 <= upper && upper - lower <= 2e-6, "{lower} {upper}");
}
