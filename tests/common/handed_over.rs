//! Engines of diagrams whose question the explicit engine takes over.

use std::sync::Arc;

use meliora::advanced::symbolic::Thresholds;
use meliora::engine::{AnyEngine, Selection, Settings, Storage};
use meliora::model::Program;

/// Diagrams find all states, and the explicit engine takes over the question after `steps_per_work` steps for each state
/// and successor.
pub fn handed_over(program: &Arc<Program>, settings: Settings, steps_per_work: u64) -> AnyEngine {
    let first_turn = 1 << 40;
    let thresholds =
        Thresholds { work_before_diagrams: 0, first_turn, steps_per_work, ..settings.thresholds };
    let mut selection = Selection { storage: Storage::Symbolic, reason: None, is_open: true };
    selection.build(program, Settings { thresholds, ..settings }, false).unwrap()
}
