//! An explicit list of the states of a model, by the reference semantics of its commands.

use ahash::AHashMap;

use super::graph::{Column, Graph, Players, Row, fits};
use super::label::{Regions, members, unique};
use meliora_base::error::Result;
use meliora_base::value::{Type, Value};
use meliora_engine::Engine;
use meliora_model::expr::ExprId;
use meliora_model::step::Step;
use meliora_model::{ModelKind, Program, State, Variable, fault};
use meliora_planning::Analysis;

/// Lists the states that an engine found, each with its choices, whatever the requirements. The
/// labels are those of the model, the regions of the finished analysis, and the ranks. Cost: one step of the program per state.
///
/// # Errors
/// There are more than `limit` states; the model has no meaning in a state; a limit is reached.
pub fn explored<E: Engine>(analysis: &Analysis<E>, program: &Program, limit: usize) -> Result<Graph> {
    let engine = analysis.whole_engine();
    let states = engine.list_states(&engine.all_states(), limit.saturating_add(1))?;
    fits(states.len().saturating_sub(1), limit)?;
    let initial = engine.initial_states();
    let starts = members(engine, &initial, &states)?;
    let (first, others): (Vec<_>, Vec<_>) =
        states.into_iter().enumerate().partition(|(number, _)| starts.binary_search(number).is_ok());
    let states: Vec<State> = first.into_iter().chain(others).map(|(_, state)| state).collect();
    let index: AHashMap<&State, usize> = states.iter().zip(0..).collect();
    let (mut rows, mut owners) = (Vec::with_capacity(states.len()), Vec::new());
    for state in &states {
        if let Some(limit) = engine.settings().sink.stop() {
            return Err(limit.into());
        }
        let steps = program.steps(state).map_err(|e| fault::error(program, &e, state))?;
        owners.push(owner(program, &steps));
        let row = |step: Step| {
            let known = step.successors.iter().filter_map(|(s, p)| Some((*index.get(s)?, *p)));
            let mut successors: Vec<(usize, f64)> = known.collect();
            successors.sort_by_key(|s| s.0);
            Row { action: step.name, successors }
        };
        rows.push(steps.into_iter().map(row).collect());
    }
    let labels = labels(analysis, program, &states)?;
    let columns = program.variables.iter().map(column).collect();
    let is_dtmc = program.kind == ModelKind::Dtmc;
    let players = program.players.as_ref().map(|players| Players { names: names(players), owners });
    Ok(Graph { is_dtmc, players, columns, initial: (0..starts.len()).collect(), rows, labels, states })
}

/// Returns the names of players.
pub(super) fn names(players: &meliora_model::players::Players) -> Vec<String> {
    players.list.iter().map(|player| player.name.clone()).collect()
}

/// Returns the player whose choices these steps are, 0 if they are nobody's.
fn owner(program: &Program, steps: &[Step]) -> usize {
    steps.iter().find_map(|step| program.player_of_choice(&step.choice)).unwrap_or_default()
}

pub(super) fn column(variable: &Variable) -> Column {
    let range = Some((variable.low, variable.high));
    Column { name: variable.name.clone(), is_bool: variable.ty == Type::Bool, range }
}

/// Returns the labels: "deadlock", those of the model, and the regions and ranks.
fn labels<E: Engine>(
    analysis: &Analysis<E>,
    program: &Program,
    states: &[State],
) -> Result<Vec<(String, Vec<usize>)>> {
    let engine = analysis.engine();
    let deadlocks = engine.deadlock_states();
    let mut labels = vec![("deadlock".to_owned(), members(engine, &deadlocks, states)?)];
    labels.extend(of_model(program, states)?);
    let regions = Regions::of(analysis);
    labels.extend(regions.all(states)?);
    Ok(distinct(labels))
}

/// Returns the labels of the model, each with the numbers of its states.
///
/// # Errors
/// A label has no value in some state.
pub(super) fn of_model(program: &Program, states: &[State]) -> Result<Vec<(String, Vec<usize>)>> {
    let holds = |e: ExprId, state: &State| match program.pool.eval(e, state) {
        Ok(value) => Ok(value == Value::Bool(true)),
        Err(_) => Err(fault::in_predicate(program, &program.predicate(e), state)),
    };
    let mut labels = Vec::with_capacity(program.labels.len());
    for (name, e) in &program.labels {
        let mut own = Vec::new();
        for (number, state) in states.iter().enumerate() {
            if holds(*e, state)? {
                own.push(number);
            }
        }
        labels.push((name.clone(), own));
    }
    Ok(labels)
}

/// Makes the names of labels distinct.
pub(super) fn distinct(labels: Vec<(String, Vec<usize>)>) -> Vec<(String, Vec<usize>)> {
    let names = unique(labels.iter().map(|(name, _)| name.as_str()), &["init"]);
    names.into_iter().zip(labels).map(|(name, (_, states))| (name, states)).collect()
}
