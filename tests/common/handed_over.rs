//! Engines of diagrams whose question other orders answer in turns with them, until the explicit engine takes over.

use std::sync::Arc;

use meliora::advanced::symbolic::Thresholds;
use meliora::engine::{AnyEngine, Selection, Settings, Storage};
use meliora::model::Program;

/// Diagrams find all states, and the explicit engine takes over the question after `steps_per_work` steps for each state
/// and successor.
pub fn handed_over(program: &Arc<Program>, settings: Settings, steps_per_work: u64) -> AnyEngine {
    begun(program, settings, 1 << 40, steps_per_work)
}

/// Diagrams find all states in their first turn, which is hardly longer than it has to be, as are those of the question.
pub fn in_turns(program: &Arc<Program>, settings: Settings, steps_per_work: u64) -> AnyEngine {
    let engine = begun(program, settings.clone(), 1 << 40, u64::MAX);
    let steps = engine.symbolic().map_or(0, |engine| engine.ways().steps);
    let engine = begun(program, settings.clone(), steps + 1, steps_per_work);
    // Long operations count their steps in thousands.
    let is_enough = engine.storage() == Storage::Symbolic;
    if is_enough { engine } else { begun(program, settings, steps + (1 << 11), steps_per_work) }
}

fn begun(program: &Arc<Program>, settings: Settings, first_turn: u64, steps_per_work: u64) -> AnyEngine {
    let thresholds =
        Thresholds { work_before_diagrams: 0, first_turn, steps_per_work, ..settings.thresholds };
    let mut selection = Selection { storage: Storage::Symbolic, reason: None, is_open: true };
    selection.build(program, Settings { thresholds, ..settings }, false).unwrap()
}
