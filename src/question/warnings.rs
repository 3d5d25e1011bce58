//! Warnings about a model that its user may not expect.

use crate::number::Number;
use meliora_base::error::{Diagnostic, Result};
use meliora_engine::{Count, Engine};
use meliora_model::predicate::Predicate;
use meliora_model::{ModelKind, Program, fault};

/// A warning.
#[derive(Debug, Clone)]
pub enum Warning {
    /// A sentence.
    Text(String),
    /// Messages that point into a text.
    Pointed(Vec<Diagnostic>),
}

/// Returns the warnings of deadlocks, of rounded probabilities, and of states in which a `dtmc` draws a command
/// uniformly; `overlap` is that of [`overlap`]. Cost: no image.
///
/// # Errors
/// A limit is reached.
pub fn of_states<E: Engine>(
    engine: &E,
    program: &Program,
    deadlocks: &Count,
    overlap: Option<&Predicate>,
) -> Result<Vec<Warning>> {
    let mut warnings = Vec::new();
    if *deadlocks != Count::ZERO {
        let (count, plural) = counted(deadlocks);
        let what = if plural { "states are deadlocks: each" } else { "state is a deadlock: it" };
        let example = engine.list_states(&engine.deadlock_states(), 1)?.pop().unwrap_or_default();
        let (such_as, example) = (if plural { ", such as " } else { ": " }, program.show_state(&example));
        warnings.push(Warning::Text(format!("{count} {what} gets a self-loop{such_as}{example}")));
    }
    if let Some(state) = engine.rounded_state()
        && let Some((command, sum)) = program.rounded_in(state)
    {
        warnings.push(Warning::Pointed(vec![fault::rounded(program, command, sum, state)]));
    }
    let Some(overlap) = overlap else { return Ok(warnings) };
    let states = match engine.drawing_states() {
        Some(states) => states,
        None => engine.count(&engine.states_where(overlap)?)?,
    };
    if states != Count::ZERO {
        let (count, plural) = counted(&states);
        let what = if plural { "states" } else { "state" };
        let drawn = "several commands are enabled in";
        warnings.push(Warning::Text(format!("{drawn} {count} {what} of this dtmc; one is drawn uniformly")));
    }
    Ok(warnings)
}

/// Returns the states of a `dtmc` in which several choices are merged into one; `None` for other models.
pub fn overlap(program: &Program) -> Option<Predicate> {
    (program.kind == ModelKind::Dtmc).then(|| program.overlap())
}

fn counted(count: &Count) -> (String, bool) {
    (Number(count.clone()).grouped(), *count != Count::from(1u32))
}
