//! Warnings about a model that its user may not expect.

use crate::number::Number;
use meliora_base::error::{Diagnostic, Result};
use meliora_engine::{Count, Engine, Scope};
use meliora_model::predicate::Predicate;
use meliora_model::preference::Goal;
use meliora_model::{ModelKind, Program, fault};
use meliora_planning::Analysis;
use meliora_planning::result::ObjectiveCounts;
use meliora_space::bounds::is_never_true;

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

/// Returns why no state satisfies the target of an objective, for each such one. Cost: one test per objective.
///
/// # Errors
/// A limit is reached.
pub fn of_targets<E: Engine>(analysis: &Analysis<E>, program: &Program) -> Result<Vec<Warning>> {
    let empty = analysis.result().objectives.iter().filter(|found| found.target == Count::ZERO);
    let why = |found: &ObjectiveCounts| {
        let goal = &analysis.preferences().objectives[found.objective].goal;
        why_empty(analysis.whole_engine(), program, &found.name, goal).map(Warning::Text)
    };
    empty.map(why).collect()
}

fn why_empty<E: Engine>(whole: &E, program: &Program, name: &str, goal: &Goal) -> Result<String> {
    let Goal::Reach(target) = goal else {
        return Ok(format!("no strategy can guarantee the objective `{name}`"));
    };
    Ok(if is_never_true(program, target) {
        format!("the target of objective `{name}` is false for all values that its variables can have")
    } else if !whole.is_empty(&whole.states_where(target)?)? {
        format!("the requirements exclude all states that satisfy the target of objective `{name}`")
    } else if whole.settings().scope == Scope::Reachable {
        format!("no path reaches a state that satisfies the target of objective `{name}`")
    } else {
        format!("no state satisfies the target of objective `{name}`")
    })
}

/// Returns the states of a `dtmc` in which several choices are merged into one; `None` for other models.
pub fn overlap(program: &Program) -> Option<Predicate> {
    (program.kind == ModelKind::Dtmc).then(|| program.overlap())
}

fn counted(count: &Count) -> (String, bool) {
    (Number(count.clone()).grouped(), *count != Count::from(1u32))
}
