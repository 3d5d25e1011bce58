//! The explicit engine: every state is stored, choices and successors are sparse rows, sets are bit
//! sets.
//!
//! The states and their rows are those of [`meliora_space`]. Fixpoints visit the reversed graph, states
//! near each other in memory one after the other (`fixpoint`, `almost_sure`, `games`, `frontier`).

mod almost_sure;
mod fixpoint;
mod frontier;
mod games;
mod guided;
mod images;
mod marks;
mod operators;
mod visit;

use std::sync::Arc;
use std::sync::atomic::AtomicUsize;

use super::settings::Settings;
use games::Game;
pub use guided::{Guided, Guiding};
use meliora_base::error::Result;
use meliora_model::{Program, State};
use meliora_space::enabled::Enabled;
use meliora_space::explore::{Exploration, Explored, Space, Task};
use meliora_space::graph::Graph;
use meliora_space::layout::Layout;
use meliora_space::meter::Meter;
use meliora_space::probabilities::Probabilities;
use meliora_space::program::Prepared;
use meliora_space::set::BitSet;
pub use visit::Listing;

/// A set of states: one bit per state.
#[derive(Debug, Clone)]
pub struct StateSet(BitSet);

/// A set of (state, choice) pairs: one bit per pair.
#[derive(Debug, Clone)]
pub struct ChoiceSet(BitSet);

impl AsRef<BitSet> for StateSet {
    fn as_ref(&self) -> &BitSet {
        &self.0
    }
}

impl AsRef<BitSet> for ChoiceSet {
    fn as_ref(&self) -> &BitSet {
        &self.0
    }
}

/// The explicit engine. Clones share the explored states.
#[derive(Clone)]
pub struct ExplicitEngine {
    program: Arc<Program>,
    settings: Settings,
    layout: Arc<Layout>,
    prepared: Arc<Prepared>,
    meter: Meter,
    space: Arc<Space>,
    graph: Arc<Graph>,
    /// The states and choices that the engine admits: all of the graph, or after
    /// [`Engine::restricted_to`](super::Engine::restricted_to) those of a region.
    every_state: BitSet,
    every_choice: BitSet,
    initial: BitSet,
    deadlocks: BitSet,
    drawing: u64,
    rounded: Option<State>,
    /// The choices of the states by their commands; see [`Settings::keeps_choices`].
    choices: Option<Arc<Enabled>>,
    /// The probabilities of the choices, if they are kept.
    probabilities: Option<Arc<Probabilities>>,
    /// The players of a game; `None` for other models.
    game: Option<Game>,
    /// The number of work list steps, which decides when to check the progress sink.
    ticks: Arc<AtomicUsize>,
}

impl ExplicitEngine {
    /// Explores the scope and checks that every command has a meaning in each of its states. Cost:
    /// evaluates all guards once per state, one index look-up per transition.
    ///
    /// # Errors
    /// - A limit is reached; the error says how many states were reached.
    /// - An update leaves the range of its variable, probabilities are not a distribution, or an
    ///   expression has no value: an input error with an example state of the scope.
    pub fn new(program: Arc<Program>, settings: Settings) -> Result<Self> {
        let (task, explored) = Exploration::new(program, settings.limits())?.finish()?;
        let Task { program, layout, prepared, meter, .. } = task;
        let Explored { space, graph, initial, deadlocks, drawing, rounded, players, .. } = explored;
        let every_state = BitSet::full(&meter, graph.states());
        let every_choice = BitSet::full(&meter, graph.choices());
        let coalition = program.players.iter().flat_map(|players| players.coalition()).collect();
        let empty = || BitSet::empty(&meter, graph.states());
        let game = players.map(|players| Game::new(Arc::new(players), coalition, empty()));
        Ok(ExplicitEngine {
            game,
            program,
            settings,
            layout: Arc::new(layout),
            prepared,
            meter,
            space: Arc::new(space),
            graph: Arc::new(graph),
            every_state,
            every_choice,
            initial,
            deadlocks,
            drawing,
            rounded,
            choices: explored.choices.map(Arc::new),
            probabilities: explored.probabilities.map(Arc::new),
            ticks: Arc::default(),
        })
    }

    /// Sets the most bytes of its arrays.
    pub(crate) fn set_memory(&mut self, bytes: u64) {
        self.settings.memory = bytes;
        self.allow(bytes);
    }

    /// Sets the most bytes of the arrays of this engine and its clones.
    pub(crate) fn allow(&self, bytes: u64) {
        self.meter.set_limit(bytes);
    }

    /// Returns the program.
    pub(crate) fn program(&self) -> &Arc<Program> {
        &self.program
    }

    /// Returns whether both engines share their states, so that each accepts the sets of the other.
    pub(crate) fn shares(&self, other: &ExplicitEngine) -> bool {
        Arc::ptr_eq(&self.graph, &other.graph)
    }
}
