//! The states in which the transition relation is checked a second time.

use std::collections::BTreeSet;

use num_traits::Signed;

use super::error::CheckResult;
use super::evaluation::Evaluation;
use meliora_engine::symbolic::{StateSet, SymbolicEngine};
use meliora_engine::{Algebra, Count, Engine};
use meliora_model::expr::ExprId;
use meliora_model::{Command, Program, State, VarId};

/// Maximum number of states.
const MOST_STATES: usize = 1 << 10;
/// Maximum number of states times commands.
const MOST_WORK: usize = 1 << 20;
/// Maximum number of valuations of the variables in a probability.
const MOST_VALUATIONS: usize = 1 << 12;
/// Maximum number of states per probability.
const MOST_PER_BRANCH: usize = 4;

/// Returns the states to check; `sets` are the sets of the dump.
pub(super) fn states<'s>(
    engine: &SymbolicEngine,
    sets: impl Iterator<Item = &'s StateSet>,
) -> CheckResult<BTreeSet<State>> {
    let program = engine.program();
    let most = (MOST_WORK / program.commands.len().max(1)).clamp(1, MOST_STATES);
    let all = engine.all_states();
    if engine.count(&all)? <= Count::from(most) {
        return Ok(engine.list_states(&all, most)?.into_iter().collect());
    }
    let mut found = BTreeSet::new();
    for command in &program.commands {
        for branch in &command.branches {
            if found.len() < most && program.pool.literal(branch.probability).is_none() {
                found.extend(least(engine, command, branch.probability)?);
            }
        }
    }
    for number in 0..engine.numbered_choices().len() {
        if found.len() < most {
            let sources = engine.numbered(&engine.all_choices(), number)?;
            found.extend(engine.list_states(&sources, 1)?);
        }
    }
    for set in sets {
        if found.len() < most {
            found.extend(engine.list_states(set, 1)?);
        }
    }
    Ok(found)
}

/// Returns states in which a command is enabled and a probability is 0, and others in which it is
/// least.
fn least(engine: &SymbolicEngine, command: &Command, probability: ExprId) -> CheckResult<Vec<State>> {
    let program = engine.program();
    let variables = program.pool.support(probability);
    let Some(valuations) = valuations(program, &variables) else { return Ok(Vec::new()) };
    let enabled = engine.states_where(&program.predicate(command.guard))?;
    let mut weighed = Vec::new();
    for state in valuations {
        if let Some(p) = Evaluation::new(&program.pool, &state).number(probability) {
            weighed.push((p, state));
        }
    }
    weighed.sort();
    let positive = weighed.partition_point(|(p, _)| !p.is_positive());
    let mut found = Vec::new();
    for side in [&weighed[..positive], &weighed[positive..]] {
        let most = found.len() + MOST_PER_BRANCH;
        for (_, state) in side.iter().take(2 * MOST_PER_BRANCH) {
            let fixed: Vec<(VarId, i64)> = variables.iter().map(|v| (*v, state[v.index()])).collect();
            let here = engine.intersection(&engine.slice(&fixed)?, &enabled)?;
            if found.len() < most {
                found.extend(engine.list_states(&here, 1)?);
            }
        }
    }
    Ok(found)
}

/// Returns all valuations of some variables, within states whose other values do not matter; `None`
/// if there are too many.
fn valuations(program: &Program, variables: &[VarId]) -> Option<Vec<State>> {
    let mut all = vec![program.variables.iter().map(|v| v.low).collect::<State>()];
    for variable in variables {
        let declared = &program.variables[variable.index()];
        let values = declared.high.checked_sub(declared.low)?.checked_add(1)?;
        let count = usize::try_from(values).ok()?.checked_mul(all.len())?;
        if count > MOST_VALUATIONS {
            return None;
        }
        let with = |(state, value): (&State, i64)| {
            let mut state = state.clone();
            state[variable.index()] = value;
            state
        };
        let values = || declared.low..=declared.high;
        all = all.iter().flat_map(|state| values().map(move |value| (state, value))).map(with).collect();
    }
    Some(all)
}
