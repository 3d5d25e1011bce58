//! Turn-based games: against all strategies of both sides, against the model with one player, and one
//! engine against the other.

mod action_values;
mod dumps;
mod levels;
mod library;
mod raw;
mod regions;
mod shields;
mod simulations;
mod states;
mod strategies;
mod temporal;
mod temporal_preferences;
mod turns;
mod values;

use self::raw::Raw;
use proptest::collection::vec;
use proptest::prelude::*;

use crate::common::prelude::*;

/// The usual turns; recursions over parts alone, over lists alone; turns of both that begin with few steps.
fn thresholds() -> [Thresholds; 5] {
    let usual = Thresholds::default();
    // No search here spends as much.
    let parts = Thresholds { relations_per_bit: 1 << 40, first_turn: 1 << 40, ..usual };
    let lists = Thresholds { relations_per_bit: 0, ..parts };
    let [one, few] = [1, 30].map(|first_turn| Thresholds { first_turn, ..parts });
    [usual, parts, lists, one, few]
}

fn settings(scope: Scope, thresholds: Thresholds) -> Settings {
    Settings { scope, memory: 64 << 20, thresholds, ..Settings::default() }
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
