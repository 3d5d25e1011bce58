//! Construction of an engine from a program: its states first.

use std::sync::{Arc, OnceLock};

use super::draft::{Draft, Translated};
use super::encoding::Encoding;
use super::encoding::transitions::{Piece, Transitions};
use super::encoding::translate::Translator;
use super::games::Game;
use super::order::{Bit, Order, Ordered, from_structure};
use super::relations::lists::Lists;
use super::relations::partial_relation::PartialRelation;
use super::store::Store;
use super::store::diagram::Bdd;
use super::store::walk::Direction;
use super::{ChoiceSet, StateSet, SymbolicEngine};
use crate::settings::{Scope, Settings};
use meliora_base::error::{Limit, Result};
use meliora_model::{ModelKind, Program, State};

/// Maximum number of bits of a state, which is the depth of recursions over diagrams.
const MOST_BITS: usize = 1 << 16;

/// A function that returns the states of the scope and replaces the exploration.
pub(super) type Given<'a> = dyn Fn(&Store) -> Result<Bdd> + 'a;

impl SymbolicEngine {
    /// Creates the engine of the valuations from which no state is reached in which some part of the program has no
    /// meaning; `None` if an initial state is not one of these. They contain all reachable states and are closed under
    /// steps, so each region of this engine contains the same reachable states as that of the scope
    /// [`Scope::Reachable`]. The scope of the settings is not used.
    ///
    /// Cost: one backward fixpoint if parts of the program have no meaning in some valuations.
    ///
    /// # Errors
    /// A limit, or the variable order is wrong.
    pub fn everywhere(program: Arc<Program>, settings: Settings) -> Result<Option<Self>> {
        let order = settings.order.bits(&program)?;
        Explored::everywhere(program, order, settings)?.map(Explored::engine).transpose()
    }
}

/// A program with its states as diagrams, in the store of the exploration.
///
/// The fixpoints may need a larger one, which is made only for an engine that is used.
pub(crate) struct Explored {
    pub(super) draft: Draft,
    states: Bdd,
    /// A state in which an enabled command has probabilities that were rounded.
    rounded: Option<State>,
}

impl Explored {
    /// Explores the scope, as [`SymbolicEngine::new`] does.
    ///
    /// # Errors
    /// The errors of [`SymbolicEngine::new`].
    pub(super) fn new(program: Arc<Program>, settings: Settings) -> Result<Self> {
        if settings.order == Order::Auto {
            return Explored::in_order(Arc::clone(&program), &from_structure(&program), settings);
        }
        let order = settings.order.bits(&program)?;
        Explored::with(program, order, settings, None)
    }

    /// Explores the scope with the bits in an order that has a reason.
    pub(super) fn in_order(program: Arc<Program>, order: &Ordered, settings: Settings) -> Result<Self> {
        let mut found = Explored::with(program, order.bits.clone(), settings, None)?;
        found.draft.encoding.set_why(&order.why);
        Ok(found)
    }

    /// Explores the scope, or takes the given states, with the bits in an order.
    pub(super) fn with(
        program: Arc<Program>,
        order: Vec<Bit>,
        settings: Settings,
        given: Option<&Given<'_>>,
    ) -> Result<Self> {
        check_width(order.len())?;
        let draft = Draft::new(program, order, settings)?;
        let states = match given {
            Some(given) => draft.store.and(&given(&draft.store)?, &draft.domain)?,
            None => draft.explore()?,
        };
        Explored::checked(draft, states)
    }

    /// Takes the states of [`SymbolicEngine::everywhere`], with the bits in an order.
    fn everywhere(program: Arc<Program>, order: Vec<Bit>, settings: Settings) -> Result<Option<Self>> {
        check_width(order.len())?;
        let draft = Draft::new(program, order, Settings { scope: Scope::All, ..settings })?;
        draft.meaningful()?.map(|states| Explored::checked(draft, states)).transpose()
    }

    /// Checks that every part of the program has a meaning in the states.
    fn checked(mut draft: Draft, states: Bdd) -> Result<Self> {
        let rounded = draft.checked(&states)?;
        if draft.program.kind == ModelKind::Dtmc {
            let Draft { store, lists, translated: Translated { transitions, .. }, .. } = &mut draft;
            transitions.pieces = disjoint(store, lists, std::mem::take(&mut transitions.pieces), &states)?;
        }
        Ok(Explored { draft, states, rounded })
    }

    /// Builds the engine. Cost: no image.
    ///
    /// # Errors
    /// A limit.
    pub(crate) fn engine(self) -> Result<SymbolicEngine> {
        let Explored { mut draft, mut states, rounded } = self;
        draft.size_to(&mut states)?;
        let Draft { program, settings, encoding, store, lists, domain, translated, list } = draft;
        let Translated { transitions, initial, .. } = translated;
        let (enabled, looping) = enabled(&store, &transitions, &states)?;
        let deadlocks = deadlocks(&program, &encoding, &store, &states)?.unwrap_or(looping);
        let game = Game::find(&program, &encoding, &store, &transitions, &enabled)?;
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
            few_parts: OnceLock::new(),
            list,
            domain,
            states: StateSet(states),
            initial: StateSet(initial),
            deadlocks: StateSet(deadlocks),
            rounded,
            choices: ChoiceSet(Arc::clone(&enabled)),
            enabled,
            has_loops: true,
            game,
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
