//! Construction of an engine from a program.

use std::sync::{Arc, OnceLock};

use super::draft::{Draft, Translated};
use super::encoding::Encoding;
use super::encoding::transitions::{Piece, Transitions};
use super::encoding::translate::Translator;
use super::games::Game;
use super::order::Bit;
use super::relations::lists::Lists;
use super::relations::partial_relation::PartialRelation;
use super::store::Store;
use super::store::diagram::Bdd;
use super::store::walk::Direction;
use super::{ChoiceSet, StateSet, SymbolicEngine};
use crate::settings::Settings;
use meliora_model::error::{Limit, Result};
use meliora_model::{ModelKind, Program};

/// Maximum number of bits of a state, which is the depth of recursions over diagrams.
const MOST_BITS: usize = 1 << 16;

/// A function that returns the states of the scope and replaces the exploration.
pub(super) type Given<'a> = dyn Fn(&Store) -> Result<Bdd> + 'a;

/// Builds the engine; see [`SymbolicEngine::new`]. The states of the scope may be given.
pub(super) fn build(
    program: Arc<Program>,
    order: Vec<Bit>,
    settings: Settings,
    given: Option<&Given<'_>>,
) -> Result<SymbolicEngine> {
    check_width(order.len())?;
    let mut draft = Draft::new(program, order, settings)?;
    let mut states = match given {
        Some(given) => draft.store.and(&given(&draft.store)?, &draft.domain)?,
        None => draft.explore()?,
    };
    let rounded = draft.checked(&states)?;
    draft.size_to(&mut states)?;
    let Draft { program, settings, encoding, store, lists, domain, translated, clusters } = draft;
    let Translated { mut transitions, initial, .. } = translated;
    let (enabled, looping) = enabled(&store, &transitions, &states)?;
    let deadlocks = deadlocks(&program, &encoding, &store, &states)?.unwrap_or(looping);
    if program.kind == ModelKind::Dtmc {
        transitions.pieces = disjoint(&store, &lists, std::mem::take(&mut transitions.pieces), &states)?;
    }
    let game = Game::of(&program, (&encoding, &store), &transitions, &enabled)?;
    let groups = transitions.lists(&store, &lists)?;
    let enabled = Arc::new(enabled);
    Ok(SymbolicEngine {
        program,
        settings,
        encoding: Arc::new(encoding),
        transitions: Arc::new(transitions),
        tuple: OnceLock::new(),
        lists,
        groups,
        few_parts: Default::default(),
        suits_layers: Default::default(),
        clusters: Arc::new(clusters),
        domain,
        states: StateSet(states),
        initial: StateSet(initial),
        deadlocks: StateSet(deadlocks),
        rounded,
        choices: ChoiceSet(Arc::clone(&enabled)),
        enabled,
        has_loops: true,
        game,
        reaching: Default::default(),
        workers: Default::default(),
        store: Arc::new(store),
    })
}

fn check_width(bits: usize) -> Result<()> {
    if bits > MOST_BITS {
        let what = format!("states of {bits} bits; the symbolic engine supports at most {MOST_BITS}");
        return Err(Limit::Size { what }.into());
    }
    Ok(())
}

/// Returns the states in which each group is enabled, last those of the self-loops of deadlocks,
/// and the deadlocks.
fn enabled(store: &Store, transitions: &Transitions, states: &Bdd) -> Result<(Vec<Bdd>, Bdd)> {
    let mut enabled = Vec::new();
    for guard in &transitions.guards {
        enabled.push(store.and(guard, states)?);
    }
    let deadlocks = store.minus(states, &store.any(enabled.iter().cloned())?)?;
    enabled.push(deadlocks.clone());
    Ok((enabled, deadlocks))
}

/// Returns the deadlocks of the model if monitors step there; for the engine, that step is a choice
/// like any other.
fn deadlocks(program: &Program, encoding: &Encoding, store: &Store, states: &Bdd) -> Result<Option<Bdd>> {
    let Some(deadlock) = program.monitors.as_ref().and_then(|o| o.deadlock) else { return Ok(None) };
    let (holds, _) = Translator::new(program, encoding, store).condition(deadlock)?;
    store.and(&holds, states).map(Some)
}

/// Unites pieces that have a source in common, so that no transition is counted twice.
fn disjoint(store: &Store, lists: &Arc<Lists>, pieces: Vec<Piece>, states: &Bdd) -> Result<Vec<Piece>> {
    let mut done: Vec<(Bdd, Piece)> = Vec::new();
    for mut piece in pieces {
        let list = lists.of(store, vec![piece.steps.clone()])?;
        let mut sources = store.step(Direction::Backward, &list, &store.one(), states)?;
        let (mut apart, mut together) = (Vec::new(), Vec::new());
        for (theirs, other) in done {
            let overlap = !store.is_zero(&store.and(&theirs, &sources)?);
            (if overlap { &mut together } else { &mut apart }).push((theirs, other));
        }
        for (theirs, other) in together {
            piece.steps = PartialRelation::union(store, &[&piece.steps, &other.steps])?;
            sources = store.or(&sources, &theirs)?;
        }
        apart.push((sources, piece));
        done = apart;
    }
    Ok(done.into_iter().map(|(_, piece)| piece).collect())
}
