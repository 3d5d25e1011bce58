//! Construction of an engine from a program: its states first.

use std::sync::{Arc, OnceLock};

use super::attempts::has_few_parts;
use super::draft::{Draft, Translated, beginnings};
use super::encoding::Encoding;
use super::encoding::transitions::{Piece, Transitions};
use super::encoding::translate::Translator;
use super::games::Game;
use super::order::{Bit, Order, candidates};
use super::pick;
use super::relations::lists::Lists;
use super::relations::partial_relation::PartialRelation;
use super::store::Store;
use super::store::diagram::Bdd;
use super::store::walk::Direction;
use super::turns;
use super::{ChoiceSet, StateSet, SymbolicEngine};
use crate::settings::{Count, Settings};
use meliora_model::error::{Limit, Result};
use meliora_model::{ModelKind, Program, State};

/// Maximum number of bits of a state, which is the depth of recursions over diagrams.
const MOST_BITS: usize = 1 << 16;

/// A function that returns the states of the scope and replaces the exploration.
pub(super) type Given<'a> = dyn Fn(&Store) -> Result<Bdd> + 'a;

/// A program with its states as diagrams, in a store whose operation cache suits the exploration.
///
/// The fixpoints need a larger cache, which takes as long to clear as many models to explore; so it is made
/// only for an engine that is used.
pub(crate) struct Explored {
    draft: Draft,
    states: Bdd,
    /// A state in which an enabled command has probabilities that were rounded.
    rounded: Option<State>,
    /// The result of [`Explored::has_few_parts`] once it has been computed.
    few_parts: OnceLock<bool>,
}

impl Explored {
    /// Explores the scope, as [`SymbolicEngine::new`] does.
    ///
    /// # Errors
    /// The errors of [`SymbolicEngine::new`].
    pub(crate) fn new(program: Arc<Program>, settings: Settings) -> Result<Self> {
        if settings.order == Order::Auto {
            return turns::first_to_end(&candidates(&program), &settings, |order, settings| {
                let mut found = Explored::with(Arc::clone(&program), order.bits.clone(), settings, None)?;
                found.draft.encoding.set_why(&order.why);
                Ok(found)
            });
        }
        let order = settings.order.bits(&program)?;
        Explored::with(program, order, settings, None)
    }

    /// Explores the scope, or takes the given states, with the bits in an order.
    pub(super) fn with(
        program: Arc<Program>,
        order: Vec<Bit>,
        settings: Settings,
        given: Option<&Given<'_>>,
    ) -> Result<Self> {
        check_width(order.len())?;
        let mut draft = Draft::new(program, order, settings)?;
        let states = match given {
            Some(given) => draft.store.and(&given(&draft.store)?, &draft.domain)?,
            None => draft.explore()?,
        };
        let rounded = draft.checked(&states)?;
        if draft.program.kind == ModelKind::Dtmc {
            let Draft { store, lists, translated: Translated { transitions, .. }, .. } = &mut draft;
            transitions.pieces = disjoint(store, lists, std::mem::take(&mut transitions.pieces), &states)?;
        }
        Ok(Explored { draft, states, rounded, few_parts: OnceLock::new() })
    }

    /// Returns the number of states.
    pub(crate) fn count(&self) -> Result<Count> {
        self.draft.store.count(&self.states, self.draft.encoding.width() as u32)
    }

    /// Returns the states in which the exploration begins, ordered by their values; all states if nothing
    /// was explored.
    ///
    /// # Errors
    /// A limit.
    pub(crate) fn beginnings(&self) -> Result<Vec<State>> {
        let Draft { program, settings, encoding, store, domain, translated, .. } = &self.draft;
        let sets = (&translated.initial, domain);
        let start = beginnings(program, encoding, store, settings.scope, sets)?;
        pick::list(store, encoding, start.as_ref().unwrap_or(&self.states), usize::MAX)
    }

    /// Returns the number of nodes of the states and of all partial relations.
    pub(crate) fn nodes(&self) -> Result<usize> {
        let relations = self.draft.translated.transitions.pieces.iter().map(|p| &p.steps.relation);
        relations.chain([&self.states]).map(|f| self.draft.store.size(f)).sum()
    }

    /// Computes [`SymbolicEngine::has_few_parts`].
    pub(crate) fn has_few_parts(&self) -> Result<bool> {
        let Draft { store, lists, translated, encoding, .. } = &self.draft;
        let few = has_few_parts(store, encoding, &translated.transitions.lists(store, lists)?)?;
        Ok(*self.few_parts.get_or_init(|| few))
    }

    /// Returns the bytes in use.
    pub(crate) fn bytes(&self) -> u64 {
        self.draft.store.usage().bytes
    }

    /// Builds the engine. Cost: no image.
    ///
    /// # Errors
    /// A limit.
    pub(crate) fn engine(self) -> Result<SymbolicEngine> {
        let Explored { mut draft, mut states, rounded, few_parts } = self;
        draft.size_to(&mut states)?;
        let Draft { program, settings, encoding, store, lists, domain, translated, clusters } = draft;
        let Translated { transitions, initial, .. } = translated;
        let (enabled, looping) = enabled(&store, &transitions, &states)?;
        let deadlocks = deadlocks(&program, &encoding, &store, &states)?.unwrap_or(looping);
        let game = Game::of(&program, (&encoding, &store), &transitions, &enabled)?;
        let groups = transitions.lists(&store, &lists)?;
        let enabled = Arc::new(enabled);
        Ok(SymbolicEngine {
            program,
            settings,
            encoding: Arc::new(encoding),
            transitions: Arc::new(transitions),
            tuple: OnceLock::new(),
            quiet: OnceLock::new(),
            lists,
            groups,
            few_parts,
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
