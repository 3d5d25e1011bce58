//! The model induced by a strategy.
//!
//! A state is a state of the model, with the memory of the strategy and whether the step into it
//! improved. A path ends where no improvement is left or the pursued objective is achieved: the state
//! has a self-loop.

use ahash::AHashMap;

use super::explore::{column, distinct, names, of_model};
use super::graph::{Column, Graph, Players, Row, fits};
use super::label::Regions;
use meliora_base::error::Result;
use meliora_engine::Engine;
use meliora_model::{Program, State};
use meliora_planning::Analysis;
use meliora_planning::finite_memory::{FiniteMemoryStrategy, Memory};
use meliora_planning::induced_model::{InducedModel, Scheduler};
use meliora_planning::levels::Rank;

/// A node of the induced model, and whether an improvement led there.
type Key = (usize, bool);

/// Builds the model that a strategy induces from the initial states: a Markov chain for
/// [`Scheduler::Progress`], a sub-MDP of the model for [`Scheduler::Permissive`]. From a game, the
/// progress strategy leaves an MDP of the opponent's choices, the permissive one a game. The labels are
/// "improved" (the last step was an improvement), "settled" (the path ends there), "achieved" (the
/// pursued objective is achieved) and "committed" (a plan has committed to it) for strategies that
/// achieve objectives, and the regions and ranks of the states.
///
/// # Errors
/// There are more than `limit` states; the errors of [`InducedModel::unfold`].
pub fn induced<E: Engine>(
    analysis: &Analysis<E>,
    program: &Program,
    strategy: &mut FiniteMemoryStrategy<E>,
    scheduler: Scheduler,
    limit: usize,
) -> Result<Graph> {
    let engine = analysis.engine();
    let starts = engine.list_states(&engine.initial_states(), limit.saturating_add(1))?;
    fits(starts.len().saturating_sub(1), limit)?;
    let unfolded = InducedModel::unfold(strategy, &starts, scheduler, limit)?;
    if !unfolded.complete {
        fits(limit, limit)?;
    }
    let mut found = KeyIndex::from(starts.len());
    let mut rows = Vec::new();
    // States are numbered, and expanded, in the order in which they are found.
    while let Some(&key) = found.keys.get(rows.len()) {
        fits(rows.len(), limit)?;
        rows.push(choices(&unfolded, key, rows.len(), &mut found));
    }
    let keys = found.keys;
    let achieves = strategy.kind().achieves();
    let labels = labels(analysis, program, &unfolded, &keys, achieves)?;
    let states = keys.iter().map(|key| values(&unfolded, *key, achieves)).collect();
    let is_dtmc = scheduler == Scheduler::Progress && program.players.is_none();
    let players = program.players.as_ref().filter(|_| scheduler == Scheduler::Permissive);
    let players = players.map(|players| owners(players, &unfolded, &keys));
    let columns = columns(program, achieves);
    let initial = (0..starts.len()).collect();
    Ok(Graph { is_dtmc, players, columns, states, rows, initial, labels })
}

/// Returns the players of the states.
fn owners(players: &meliora_model::players::Players, unfolded: &InducedModel, keys: &[Key]) -> Players {
    let owner = |(node, _): &Key| unfolded.nodes[*node].at.owner.map_or(0, |owner| owner.player);
    Players { names: names(players), owners: keys.iter().map(owner).collect() }
}

/// The states found so far.
struct KeyIndex {
    keys: Vec<Key>,
    index: AHashMap<Key, usize>,
}

impl KeyIndex {
    fn from(starts: usize) -> Self {
        let keys: Vec<Key> = (0..starts).map(|node| (node, false)).collect();
        let index = keys.iter().copied().zip(0..).collect();
        KeyIndex { keys, index }
    }

    fn number(&mut self, key: Key) -> usize {
        *self.index.entry(key).or_insert_with(|| {
            self.keys.push(key);
            self.keys.len() - 1
        })
    }
}

/// Returns the choices of the strategy in a state; a self-loop if it has none.
fn choices(unfolded: &InducedModel, (node, _): Key, number: usize, found: &mut KeyIndex) -> Vec<Row> {
    let node = &unfolded.nodes[node];
    let mut rows = Vec::new();
    for (action, next) in node.at.actions.iter().zip(&node.next) {
        let mut successors: Vec<(usize, f64)> = Vec::new();
        for (successor, to) in action.successors.iter().zip(next) {
            if let Some(to) = to {
                successors.push((found.number((*to, successor.improves)), successor.probability));
            }
        }
        if !successors.is_empty() {
            successors.sort_by_key(|s| s.0);
            rows.push(Row { action: action.name.clone(), successors });
        }
    }
    if rows.is_empty() {
        rows.push(Row { action: "settled".to_owned(), successors: vec![(number, 1.0)] });
    }
    rows
}

/// Returns the variables of the model, then the level (-1 if unbounded), the reference arena (-1 if
/// none), and whether the last step improved; for strategies that achieve objectives, then the pursued
/// objective (-1 if none), its stage, and whether the plan has committed to it.
fn columns(program: &Program, achieves: bool) -> Vec<Column> {
    let mut columns: Vec<Column> = program.variables.iter().map(column).collect();
    let pursuit: &[_] =
        if achieves { &[("pursued", false), ("stage", false), ("committed", true)] } else { &[] };
    for &(name, is_bool) in [("level", false), ("reference", false), ("improved", true)].iter().chain(pursuit)
    {
        let mut name = name.to_owned();
        while columns.iter().any(|c| c.name == name) {
            name.insert(0, '_');
        }
        columns.push(Column { name, is_bool, range: None });
    }
    columns
}

fn values(unfolded: &InducedModel, (node, improved): Key, achieves: bool) -> State {
    let at = &unfolded.nodes[node].at;
    let Memory { level, arena, pursuit } = at.memory;
    let number = |n: usize| i64::try_from(n).unwrap_or(i64::MAX);
    let level = match level {
        Rank::Finite(k) | Rank::AtLeast(k) => number(k),
        Rank::Unbounded => -1,
    };
    let mut values = at.state.clone();
    values.extend([level, arena.map_or(-1, number), i64::from(improved)]);
    if achieves {
        values.extend(pursuit.map_or([-1, 0], |p| [number(p.objective), number(p.stage)]));
        values.push(i64::from(at.commits()));
    }
    values
}

fn labels<E: Engine>(
    analysis: &Analysis<E>,
    program: &Program,
    unfolded: &InducedModel,
    keys: &[Key],
    achieves: bool,
) -> Result<Vec<(String, Vec<usize>)>> {
    let numbered = |holds: &dyn Fn(&Key) -> bool| -> Vec<usize> {
        keys.iter().enumerate().filter(|(_, key)| holds(key)).map(|(number, _)| number).collect()
    };
    let settled = |key: &Key| unfolded.nodes[key.0].next.iter().flatten().all(Option::is_none);
    let mut labels =
        vec![("improved".to_owned(), numbered(&|key| key.1)), ("settled".to_owned(), numbered(&settled))];
    if achieves {
        labels.push(("achieved".to_owned(), numbered(&|key| unfolded.nodes[key.0].at.is_achieved())));
        labels.push(("committed".to_owned(), numbered(&|key| unfolded.nodes[key.0].at.commits())));
    }
    let states: Vec<State> = keys.iter().map(|key| unfolded.nodes[key.0].at.state.clone()).collect();
    labels.extend(of_model(program, &states)?);
    labels.extend(Regions::of(analysis).all(&states)?);
    Ok(distinct(labels))
}
