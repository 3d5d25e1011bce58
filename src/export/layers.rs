//! Layers and rounds: states by distance, and states by the round that removes them.

use super::Named;
use meliora_engine::symbolic::{ChoiceSet, StateSet, SymbolicEngine};
use meliora_engine::{Algebra, Engine};
use meliora_model::error::Result;
use meliora_model::names;

pub(super) fn layers(named: &mut Vec<Named>, region: &str, sets: &[StateSet]) {
    named.extend(sets.iter().enumerate().map(|(j, x)| Named::states(names::layer(region, j), x)));
}

pub(super) fn rounds(named: &mut Vec<Named>, region: &str, sets: &[StateSet]) {
    named.extend(sets.iter().enumerate().map(|(j, x)| Named::states(names::refuted(region, j), x)));
}

/// Computes the states of the scope by their distance from the start states of paths.
pub(super) fn forward(engine: &SymbolicEngine, start: StateSet) -> Result<Vec<StateSet>> {
    let all = engine.all_choices();
    by_distance(engine, start, |layer| engine.post(&engine.choices_in(&all, layer)?))
}

/// Computes the states that reach a target with the given choices, by their distance from it.
pub(super) fn backward(
    engine: &SymbolicEngine,
    target: &StateSet,
    within: &ChoiceSet,
) -> Result<Vec<StateSet>> {
    by_distance(engine, target.clone(), |layer| engine.can_choose(&engine.pre(within, layer)?))
}

fn by_distance(
    engine: &SymbolicEngine,
    start: StateSet,
    step: impl Fn(&StateSet) -> Result<StateSet>,
) -> Result<Vec<StateSet>> {
    let mut open = engine.difference(&engine.all_states(), &start)?;
    let (mut layer, mut layers) = (start, Vec::new());
    while !engine.is_empty(&layer)? {
        let next = engine.intersection(&step(&layer)?, &open)?;
        layers.push(layer);
        open = engine.difference(&open, &next)?;
        layer = next;
    }
    Ok(layers)
}
