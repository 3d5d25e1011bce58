//! Formulas with bounds on steps, of many states.

use std::sync::Arc;

use bitvec::vec::BitVec;
use meliora_engine::{AnyEngine, Settings, Storage};
use meliora_model::Optimum;

use super::arenas::load;
use crate::graphs::arena::Arena;
use crate::graphs::game_graph::Extremes;
use crate::values::vector::{Asked, Until};

/// Walkers on a grid of 100,000 states: no state counts steps.
#[test]
fn bounded_formulas_of_many_states_take_steps_backward() {
    let text = "mdp module m x:[0..9]; y:[0..999];
        [a] x<9 -> 1/2:(x'=x+1) + 1/2:true; [b] y<999 -> 9/10:(y'=y+1) + 1/10:(x'=0); [c] x=9 -> true; endmodule
        init true endinit";
    let program = load(text);
    let settings = Settings { storage: Storage::Explicit, ..Settings::default() };
    let engine = AnyEngine::new(Arc::new(program.clone()), settings).unwrap();
    let arena = Arena::new(&engine, &program).unwrap();
    assert_eq!(arena.states(), 10_000);
    let right: BitVec = (0..10_000).map(|state| arena.state(state)[1] == 999).collect();
    let until =
        |most| Until { left: BitVec::repeat(true, 10_000), right: right.clone(), least: 0, most: Some(most) };
    let found = Asked::all(&arena, Extremes::all(Optimum::Max), 1e-6).probability(&until(30)).unwrap();
    let at = |x: usize, y: usize| found.values[x * 1000 + y].interval();
    // 30 steps are needed from y=969, all of which succeed with the probability 0.9.
    let expected = 0.9f64.powi(30);
    for x in [0, 5, 9] {
        assert!((at(x, 969).lower - expected).abs() < 1e-9 && at(x, 968).upper == 0.0, "{:?}", at(x, 969));
    }
}
