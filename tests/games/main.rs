//! Turn-based games: against all strategies of both sides, against the model with one player, and one
//! engine against the other.

mod dumps;
mod levels;
mod library;
mod moves;
mod one_player;
#[path = "../common/random_game.rs"]
mod random_game;
#[path = "../common/random_program.rs"]
#[allow(dead_code, unreachable_pub, reason = "each user takes a part")]
mod random_program;
mod raw;
mod regions;
mod shields;
mod simulations;
mod states;
mod strategies;
mod temporal;
mod temporal_preferences;
mod turns;

use meliora::advanced::symbolic::Thresholds;
use meliora::engine::{Scope, Settings};
use proptest::collection::vec;
use proptest::prelude::*;

use self::raw::Raw;

/// The usual order of attempts; recursions over parts alone, over lists alone; layers of states alone; turns of
/// lists and layers; a recursion over parts that gives up after one step, and then over lists.
fn thresholds() -> [Thresholds; 7] {
    let usual = Thresholds::default();
    // No search here spends as much.
    let (free_cases, free_steps) = (1 << 40, 1 << 40);
    let parts = Thresholds { relations_per_bit: 1 << 40, free_cases, free_steps, ..usual };
    let without_parts = Thresholds { relations_per_bit: 0, ..usual };
    let recursion_first = Thresholds { most_shared_percent: 0, lose_steps_per_node: 0, ..without_parts };
    let [lists, one, few] = [u64::MAX, 1, 30].map(|lose_steps| Thresholds { lose_steps, ..recursion_first });
    let (shared_by_percent, most_shared_percent, nodes_per_bit) = (0, 100, 1 << 40);
    let layers = Thresholds { shared_by_percent, most_shared_percent, nodes_per_bit, ..lists };
    let spent = Thresholds { free_steps: 1, steps_per_node: 0, lose_steps: u64::MAX, ..parts };
    [usual, parts, lists, layers, one, few, spent]
}

fn settings(scope: Scope, thresholds: Thresholds) -> Settings {
    Settings { scope, memory: 64 << 20, thresholds, threads: 1, ..Settings::default() }
}

/// A game of up to `states` states, an even number, with up to `choices` choices each and at most 4096 pairs of
/// strategies.
fn some_game(states: usize, choices: usize) -> impl Strategy<Value = Raw> {
    let state = (any::<bool>(), vec(vec(0..states, 1..=3), 1..=choices));
    vec(state, states..=states).prop_filter_map("too many strategies", move |all| {
        let (theirs, mut choices): (Vec<bool>, Vec<Vec<Vec<usize>>>) = all.into_iter().unzip();
        for successors in choices.iter_mut().flatten() {
            successors.sort_unstable();
            successors.dedup();
        }
        let raw = Raw { theirs, choices };
        (raw.pairs() <= 4096).then_some(raw)
    })
}
