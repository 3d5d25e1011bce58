//! The direction of a choice in the plane: the average over the successors of sampled states.

use std::collections::BTreeMap;

use super::{Direction, Plane};
use crate::describe::ChoiceNames;
use meliora_base::error::Result;
use meliora_engine::symbolic::{ChoiceSet, StateSet, SymbolicEngine};
use meliora_engine::{Algebra, Engine, position};
use meliora_model::{Program, State, VarId, fault};

/// The approximate number of sampled states, for all choices together.
const SAMPLES: usize = 4096;
/// The maximum number of values of a row or column that are sampled per choice.
const SPREAD: usize = 6;

/// Computes the directions of the choices with these names, in the order of their numbers. Cost:
/// one pre-image for each of a few values of row and column, and some steps of single states.
///
/// # Errors
/// A command has no meaning in a state; a limit is reached.
pub(super) fn of(engine: &SymbolicEngine, plane: Plane, names: Vec<ChoiceNames>) -> Result<Vec<Direction>> {
    let side = (SAMPLES / names.len().max(1)).isqrt().clamp(1, SPREAD);
    let rows = plane.row.map_or_else(|| Ok(Vec::new()), |row| leaving(engine, row, side))?;
    let columns = leaving(engine, plane.column, side)?;
    let mut directions = Vec::with_capacity(names.len());
    for (number, ChoiceNames { label, own }) in names.into_iter().enumerate() {
        let mut sum = [0.0; 2];
        for state in samples(engine, &rows, &columns, number)? {
            let step = displacement(engine, plane, number, &state)?;
            sum = [sum[0] + step[0], sum[1] + step[1]];
        }
        let (row, column) = sign(sum);
        directions.push(Direction { name: label, own, several: None, row, column });
    }
    Ok(directions)
}

/// Choices with the same label, and the states where several of them are enabled.
pub(super) struct Namesakes {
    pub(super) choices: Vec<usize>,
    pub(super) several: StateSet,
}

/// Returns the labels that several choices have. Cost: no image.
///
/// # Errors
/// A limit is reached.
pub(super) fn namesakes(engine: &SymbolicEngine, choices: &[Direction]) -> Result<Vec<Namesakes>> {
    let mut by_label: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (number, choice) in choices.iter().enumerate() {
        by_label.entry(&choice.name).or_default().push(number);
    }
    let several = |choices: &[usize]| -> Result<StateSet> {
        let (mut once, mut twice) = (engine.no_states(), engine.no_states());
        for &number in choices {
            let enabled = engine.numbered(&engine.all_choices(), number)?;
            twice = engine.union(&twice, &engine.intersection(&once, &enabled)?)?;
            once = engine.union(&once, &enabled)?;
        }
        Ok(twice)
    };
    let shared = by_label.into_values().filter(|choices| choices.len() > 1);
    shared.map(|choices| Ok(Namesakes { several: several(&choices)?, choices })).collect()
}

/// The states with one value of a variable of the plane, and the choices that may change this
/// value.
struct Leaving {
    here: StateSet,
    choices: ChoiceSet,
}

/// Computes the choices that may change a variable, for some of its values.
fn leaving(engine: &SymbolicEngine, variable: VarId, side: usize) -> Result<Vec<Leaving>> {
    let mut all = Vec::new();
    for value in spread(engine, variable, side) {
        let here = engine.slice(&[(variable, value)])?;
        let elsewhere = engine.difference(&engine.all_states(), &here)?;
        let choices = engine.pre(&engine.choices_in(&engine.all_choices(), &here)?, &elsewhere)?;
        all.push(Leaving { here, choices });
    }
    Ok(all)
}

/// Samples states in which a choice may lead to another cell, at most one per pair of a row and a
/// column.
fn samples(
    engine: &SymbolicEngine,
    rows: &[Leaving],
    columns: &[Leaving],
    number: usize,
) -> Result<Vec<State>> {
    let mut samples = Vec::new();
    for column in columns {
        let along = engine.numbered(&column.choices, number)?;
        if rows.is_empty() {
            samples.extend(engine.list_states(&along, 1)?);
        }
        for row in rows {
            let across = engine.intersection(&engine.numbered(&row.choices, number)?, &column.here)?;
            let moving = engine.union(&across, &engine.intersection(&along, &row.here)?)?;
            samples.extend(engine.list_states(&moving, 1)?);
        }
    }
    Ok(samples)
}

/// Returns some values of a variable, evenly spread.
fn spread(engine: &SymbolicEngine, variable: VarId, count: usize) -> Vec<i64> {
    let variable = &engine.program().variables[variable.index()];
    let width = variable.high - variable.low;
    let steps = (count as i64 - 1).max(1).min(width.max(1));
    (0..=steps).map(|k| variable.low + width * k / steps).take(count.max(1)).collect()
}

/// Returns the average change of row and column under a choice in a state.
fn displacement(engine: &SymbolicEngine, plane: Plane, number: usize, state: &[i64]) -> Result<[f64; 2]> {
    let program = engine.program();
    let steps = program.steps(state).map_err(|fault| fault::error(program, &fault, state))?;
    let only = engine.only(number);
    let Some(taken) = position(&steps, |s| engine.contains_choice(&only, state, &s.choice))? else {
        return Ok([0.0; 2]);
    };
    let change = |variable: VarId| {
        let moved = |(to, p): &(State, f64)| p * (to[variable.index()] - state[variable.index()]) as f64;
        steps[taken].successors.iter().map(moved).sum::<f64>()
    };
    Ok([plane.row.map_or(0.0, change), change(plane.column)])
}

/// Returns the nearest of the eight directions.
fn sign(sum: [f64; 2]) -> (i8, i8) {
    let most = sum[0].abs().max(sum[1].abs());
    let one = |x: f64| {
        if most < 1e-9 || x.abs() < most / 2.0 {
            0
        } else if x > 0.0 {
            1
        } else {
            -1
        }
    };
    (one(sum[0]), one(sum[1]))
}

/// Returns true if larger rows are drawn higher. This is the case if an action called north or up
/// increases the row, or, without such actions, if the name of the row contains `y`.
pub(super) fn rows_up(program: &Program, plane: Plane, choices: &[Direction]) -> bool {
    let Some(row) = plane.row else { return false };
    let is = |name: &str, first: char, words: [&str; 2]| {
        let name = name.to_ascii_lowercase();
        words.iter().any(|w| name.contains(w)) || name.starts_with(first) && name.len() <= 2
    };
    let north = choices.iter().find(|c| c.row != 0 && is(&c.name, 'n', ["north", "up"]));
    let south = choices.iter().find(|c| c.row != 0 && is(&c.name, 's', ["south", "down"]));
    match (north, south) {
        (Some(north), _) => north.row > 0,
        (None, Some(south)) => south.row < 0,
        (None, None) => program.variables[row.index()].name.to_ascii_lowercase().contains('y'),
    }
}
