//! Where in the plane a choice leads, judged from samples: the average over their successors.

use super::{Direction, Plane};
use crate::engine::Engine;
use crate::engine::symbolic::{StateSet, SymbolicEngine};
use crate::error::Result;
use crate::model::{Program, State, VarId, fault};

/// At most so many states are looked at for all choices together.
const SAMPLES: usize = 4096;
/// So many values of a row or column are enough for one choice.
const SPREAD: usize = 6;

/// The directions of the choices with these names, in the order of their numbers.
///
/// # Errors
/// A limit; a command without a meaning in a state.
pub(super) fn of(engine: &SymbolicEngine, plane: Plane, names: Vec<String>) -> Result<Vec<Direction>> {
    let all = engine.all_choices();
    let side = (SAMPLES / names.len().max(1)).isqrt().clamp(1, SPREAD);
    let mut directions = Vec::with_capacity(names.len());
    for (number, name) in names.into_iter().enumerate() {
        let enabled = engine.numbered(&all, number);
        let mut sum = [0.0; 2];
        for state in samples(engine, plane, &enabled, side)? {
            let step = displacement(engine, plane, number, &state)?;
            sum = [sum[0] + step[0], sum[1] + step[1]];
        }
        let (row, column) = sign(sum);
        directions.push(Direction { name, row, column });
    }
    Ok(directions)
}

/// Up to `side` squared states of a set, spread over the plane.
fn samples(engine: &SymbolicEngine, plane: Plane, x: &StateSet, side: usize) -> Result<Vec<State>> {
    let mut samples = Vec::new();
    let rows: Vec<Option<(VarId, i64)>> = match plane.row {
        Some(row) => spread(engine, row, side).into_iter().map(|value| Some((row, value))).collect(),
        None => vec![None],
    };
    for row in rows {
        for column in spread(engine, plane.column, side) {
            let fixed: Vec<(VarId, i64)> = row.into_iter().chain([(plane.column, column)]).collect();
            let here = engine.intersection(x, &engine.slice(&fixed)?)?;
            samples.extend(engine.list_states(&here, 1)?);
        }
    }
    Ok(samples)
}

/// Some values of a variable, evenly spread.
fn spread(engine: &SymbolicEngine, variable: VarId, count: usize) -> Vec<i64> {
    let variable = &engine.program().variables[variable.index()];
    let width = variable.high - variable.low;
    let steps = (count as i64 - 1).max(1).min(width.max(1));
    (0..=steps).map(|k| variable.low + width * k / steps).take(count.max(1)).collect()
}

/// The average change of row and column under a choice in a state.
fn displacement(engine: &SymbolicEngine, plane: Plane, number: usize, state: &[i64]) -> Result<[f64; 2]> {
    let program = engine.program();
    let steps = program.steps(state).map_err(|fault| fault::describe(program, &fault, state))?;
    let only = engine.only(number);
    let Some(step) = steps.iter().find(|s| engine.contains_choice(&only, state, &s.choice)) else {
        return Ok([0.0; 2]);
    };
    let change = |variable: VarId| {
        let moved = |(to, p): &(State, f64)| p * (to[variable.index()] - state[variable.index()]) as f64;
        step.successors.iter().map(moved).sum::<f64>()
    };
    Ok([plane.row.map_or(0.0, change), change(plane.column)])
}

/// The nearest of the eight directions.
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

/// Whether larger rows stand higher: so it is where an action called north or up makes the row grow, and
/// where the row is a `y`.
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
