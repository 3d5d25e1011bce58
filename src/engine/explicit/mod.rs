//! The explicit engine: every state stored, choices and successors in sparse rows, sets as bits.
//!
//! States are codes of a few words (`layout`). The program is compiled (`compile`, `machine`,
//! `program`) and stepped through state by state (`stepper`, `explore`); codes are numbered by
//! an open-addressing index (`index`). Fixpoints are work lists over a reversed graph
//! (`fixpoint`, `almost_sure`, `graph`).

mod almost_sure;
mod bounds;
mod compile;
mod explore;
mod fixpoint;
mod graph;
mod guard_index;
mod index;
mod initial;
mod layout;
mod machine;
mod meter;
mod operators;
mod program;
mod set;
mod share;
mod stepper;
mod visit;

use std::sync::Arc;
use std::sync::atomic::AtomicUsize;

use super::Settings;
use crate::error::Result;
use crate::model::{Program, State};
use explore::{Explored, Space, Task};
use graph::Graph;
use layout::Layout;
use meter::Meter;
use program::Prepared;
use set::BitSet;
pub use visit::Listing;

/// A set of states: one bit a state.
#[derive(Debug, Clone)]
pub struct StateSet(BitSet);

/// A set of (state, choice) pairs: one bit a pair.
#[derive(Debug, Clone)]
pub struct ChoiceSet(BitSet);

/// The explicit engine.
pub struct ExplicitEngine {
    program: Arc<Program>,
    settings: Settings,
    layout: Layout,
    prepared: Prepared,
    meter: Meter,
    space: Space,
    graph: Graph,
    every_state: BitSet,
    every_choice: BitSet,
    initial: BitSet,
    deadlocks: BitSet,
    rounded: Option<State>,
    /// Counts steps of work lists, to look at the progress sink now and then.
    ticks: AtomicUsize,
}

impl ExplicitEngine {
    /// Explores the scope and checks that every command has a meaning in every state of it.
    ///
    /// # Errors
    /// A limit, with the number of states reached so far; or, as input errors with an example state
    /// of the scope, an update that leaves its range, probabilities that are no distribution, an
    /// expression without a value.
    ///
    /// Cost: all guards in every state once, one look-up a transition.
    pub fn new(program: Arc<Program>, settings: Settings) -> Result<Self> {
        let layout = explore::layout(&program, &settings)?;
        let prepared = Prepared::new(&program, &layout, &*settings.sink)?;
        let meter = Meter::new(settings.memory);
        let task = Task {
            program: &program,
            settings: &settings,
            layout: &layout,
            prepared: &prepared,
            meter: &meter,
        };
        let Explored { space, graph, initial, deadlocks, rounded } = task.run()?;
        let every_state = BitSet::full(&meter, graph.states());
        let every_choice = BitSet::full(&meter, graph.choices());
        Ok(ExplicitEngine {
            program,
            settings,
            layout,
            prepared,
            meter,
            space,
            graph,
            every_state,
            every_choice,
            initial,
            deadlocks,
            rounded,
            ticks: AtomicUsize::new(0),
        })
    }

    /// The program.
    pub fn program(&self) -> &Arc<Program> {
        &self.program
    }
}
