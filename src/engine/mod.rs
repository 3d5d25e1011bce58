//! The interface between the algorithms and the two ways to store states.
//!
//! An engine knows two sorts: sets of states and sets of *choices*, that is of pairs (s, a) of a
//! state s of the scope and a choice a enabled in s. All algorithms of [`crate::planning`] are
//! written over these; iterating over states is not part of the interface.

pub mod any;
pub mod diagrams;
pub mod edge_labels;
pub mod explicit;
pub mod regions;
pub mod symbolic;

use std::sync::Arc;

pub use any::AnyEngine;
pub use diagrams::Dumpable;
pub use edge_labels::EdgeLabels;
use num_bigint::BigUint;
use serde::Serialize;

use crate::error::Result;
use crate::model::State;
use crate::model::expr::ExprId;
use crate::model::step::Choice;
pub use crate::progress::{NoProgress, ProgressSink};

/// An exact number of states, choices or transitions.
pub type Count = BigUint;

/// Which valuations are states.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Scope {
    /// Those reachable from the initial states.
    #[default]
    Reachable,
    /// Every valuation of the declared variables.
    All,
}

impl Scope {
    /// The name in reports and options.
    pub fn name(self) -> &'static str {
        match self {
            Scope::Reachable => "reachable",
            Scope::All => "all",
        }
    }

    /// The scope of a name.
    pub fn named(name: &str) -> Option<Scope> {
        [Scope::Reachable, Scope::All].into_iter().find(|scope| scope.name() == name)
    }
}

/// How states are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Storage {
    /// Sets of states as binary decision diagrams.
    #[default]
    Symbolic,
    /// States one by one.
    Explicit,
}

impl Storage {
    /// The name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Storage::Symbolic => "symbolic",
            Storage::Explicit => "explicit",
        }
    }
}

/// What an engine is created with: all that may be set of how to work. Results do not depend on it, but for
/// the scope.
#[derive(Clone)]
pub struct Settings {
    /// Which valuations are states.
    pub scope: Scope,
    /// How states are stored, where an engine is made by [`AnyEngine::new`].
    pub storage: Storage,
    /// Bytes for the node table and operation cache, or for the arrays.
    pub memory: u64,
    /// The order of the bits in decision diagrams.
    pub order: symbolic::Order,
    /// The threads that work on decision diagrams, from 1.
    pub threads: u32,
    /// Where the symbolic engine takes one way or another to the same result.
    pub thresholds: symbolic::Thresholds,
    /// Where progress goes and interruptions come from.
    pub sink: Arc<dyn ProgressSink>,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            scope: Scope::Reachable,
            storage: Storage::Symbolic,
            memory: 2 << 30,
            order: symbolic::Order::Auto,
            threads: 1,
            thresholds: symbolic::Thresholds::default(),
            sink: Arc::new(NoProgress),
        }
    }
}

/// What an engine used.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Usage {
    /// The largest number of diagram nodes alive at once; 0 without diagrams.
    pub peak_nodes: u64,
    /// The bytes of the engine's own tables.
    pub bytes: u64,
}

/// A region together with the choices that win in it.
#[derive(Debug, Clone)]
pub struct Region<S, C> {
    /// The winning states.
    pub states: S,
    /// Choices that keep winning: those of the winning states that can not leave them.
    pub choices: C,
}

/// The Boolean algebra of one sort of sets.
pub trait Algebra<X> {
    /// X ∪ Y
    fn union(&self, x: &X, y: &X) -> Result<X>;
    /// X ∩ Y
    fn intersection(&self, x: &X, y: &X) -> Result<X>;
    /// X \ Y
    fn difference(&self, x: &X, y: &X) -> Result<X>;
    /// X = ∅
    fn is_empty(&self, x: &X) -> bool;
    /// X = Y
    fn same(&self, x: &X, y: &X) -> bool;
    /// |X|
    fn count(&self, x: &X) -> Result<Count>;
}

/// Sets of states and sets of choices of one model, and the operators on them; those of each sort by itself
/// are its [`Algebra`].
///
/// Every operation may run out of memory or time and then returns [`crate::error::Error::Limit`].
/// Arguments must come from the same engine. Engines and sets may go from one thread to another.
pub trait Engine:
    Algebra<<Self as Engine>::States> + Algebra<<Self as Engine>::Choices> + Send + Sync
{
    /// A set of states of the scope.
    type States: Clone + Send + Sync;
    /// A set of pairs of a state of the scope and a choice enabled there.
    type Choices: Clone + Send + Sync;

    /// All states S of the scope.
    fn all_states(&self) -> Self::States;
    /// No state.
    fn no_states(&self) -> Self::States;
    /// The initial states.
    fn initial_states(&self) -> Self::States;
    /// The states in which nothing is enabled; each has the self-loop as its only choice.
    fn deadlock_states(&self) -> Self::States;
    /// A state of the scope in which an enabled command has probabilities that sum to 1 only when rounded;
    /// [`crate::model::Program::rounded_in`] says which. None where there is no such state.
    fn rounded_state(&self) -> Option<&State> {
        None
    }
    /// The states of the scope in which a Boolean expression of the program's pool holds.
    ///
    /// # Errors
    /// A limit, or an expression without a value in some state of the scope.
    fn states_where(&self, predicate: ExprId) -> Result<Self::States>;
    /// All enabled choices, the self-loops of deadlock states among them.
    fn all_choices(&self) -> Self::Choices;
    /// No choice.
    fn no_choices(&self) -> Self::Choices;

    /// { (s,a) ∈ C : s ∈ X }
    fn choices_in(&self, c: &Self::Choices, x: &Self::States) -> Result<Self::Choices>;
    /// { s : (s,a) ∈ C for some a }
    fn sources(&self, c: &Self::Choices) -> Result<Self::States>;

    /// { (s,a) ∈ C : succ(s,a) ∩ X ≠ ∅ }
    fn entering(&self, c: &Self::Choices, x: &Self::States) -> Result<Self::Choices>;
    /// { (s,a) enabled : succ(s,a) ∩ X ≠ ∅ }
    fn some_successor_in(&self, x: &Self::States) -> Result<Self::Choices> {
        self.entering(&self.all_choices(), x)
    }
    /// { (s,a) enabled : succ(s,a) ⊆ Y }; no disabled pair is ever in it.
    fn every_successor_in(&self, y: &Self::States) -> Result<Self::Choices> {
        let outside = self.difference(&self.all_states(), y)?;
        self.difference(&self.all_choices(), &self.some_successor_in(&outside)?)
    }
    /// { s' : s' ∈ succ(s,a) for some (s,a) ∈ C }
    fn successors(&self, c: &Self::Choices) -> Result<Self::States>;

    /// μX. T ∪ { s : some (s,a) ∈ C has an edge into X that is there }
    fn can_reach(
        &self,
        target: &Self::States,
        within: &Self::Choices,
        edge_labels: &[EdgeLabels<Self::States>],
    ) -> Result<Self::States>;

    /// Takes lost states out of what is left of a game, and all its pairs that may step into them other than
    /// by a safe edge; states that have no pair left then, and have not won, are lost too, and so on.
    ///
    /// The pairs of `left` are what is left of `within`, and none of a state lost before leads to what can
    /// still win. Safe is what wins and what is not there: every state of a pair is in one of `edge_labels`, or
    /// there are none, and nothing is safe.
    ///
    /// Cost: a pre-image for each part and each layer of states that are lost.
    fn remove_attractor(
        &self,
        left: Region<Self::States, Self::Choices>,
        (within, won): (&Self::Choices, &Self::States),
        edge_labels: &[EdgeLabels<Self::States>],
        lost: Self::States,
    ) -> Result<Region<Self::States, Self::Choices>>
    where
        Self: Sized,
    {
        edge_labels::remove_attractor(self, left, (within, won), edge_labels, lost, |_, _| false)
    }

    /// The greatest Z ⊆ X in which every state has a pair of C with all successors in Z, with those
    /// pairs.
    ///
    /// Cost: one pre-image of the states removed a round.
    fn stay_within(
        &self,
        x: &Self::States,
        within: &Self::Choices,
    ) -> Result<Region<Self::States, Self::Choices>>
    where
        Self: Sized,
    {
        let states = self.intersection(x, &self.sources(within)?)?;
        let removed = self.difference(&self.all_states(), &states)?;
        let left = Region { states, choices: within.clone() };
        let Region { states, choices } =
            self.remove_attractor(left, (within, &self.no_states()), &[], removed)?;
        Ok(Region { choices: self.choices_in(&choices, &states)?, states })
    }

    /// νY. μX. T ∪ { s : some (s,a) ∈ C has all successors in Y and one in X }, with the pairs of C
    /// outside T that stay inside the result.
    ///
    /// Removes losing states first: what has no pair, or cannot reach T with the pairs still allowed,
    /// is lost; pairs that may step into a lost state are disallowed; states without a pair are lost at
    /// once; repeat (Baier and Katoen, Principles of Model Checking, Algorithm 45, on sets). Only pairs
    /// that may step into a lost state are ever taken out: a lost state's own pairs lead to nothing that
    /// can still win, and what is left alone keeps what an engine remembers of it. Cost: one `can_reach`
    /// a round, and before it a pre-image for each layer of states that are lost.
    fn almost_surely_reach(
        &self,
        target: &Self::States,
        within: &Self::Choices,
    ) -> Result<Region<Self::States, Self::Choices>>
    where
        Self: Sized,
    {
        let mut left =
            Region { states: self.union(&self.sources(within)?, target)?, choices: within.clone() };
        let mut lost = self.difference(&self.all_states(), &left.states)?;
        loop {
            if !self.is_empty(&lost) {
                left = self.remove_attractor(left, (within, target), &[], lost)?;
            }
            let reaching = self.can_reach(target, &left.choices, &[])?;
            lost = self.difference(&left.states, &reaching)?;
            left.states = self.intersection(&left.states, &reaching)?;
            if self.is_empty(&lost) {
                left.choices = self.choices_in(&left.choices, &self.difference(&left.states, target)?)?;
                return Ok(left);
            }
        }
    }

    /// νY. μX. { s ∈ S : some (s,a) ∈ C has every edge winning or into Y, and one winning or into X },
    /// of edges that are there, with the pairs of C that stay; `start` holds S and C.
    ///
    /// Every pair of C must have its state in S and all its edges winning or into S. Cost: one
    /// `can_reach` a round, and a pre-image for each part and each layer of losing states.
    fn almost_surely_win(
        &self,
        start: Region<Self::States, Self::Choices>,
        edge_labels: &[EdgeLabels<Self::States>],
    ) -> Result<Region<Self::States, Self::Choices>>
    where
        Self: Sized,
    {
        edge_labels::almost_surely_win(self, start, edge_labels)
    }

    /// How many states of the model X has, whatever monitors saw; none without monitors.
    fn count_model_states(&self, x: &Self::States) -> Result<Option<Count>>;
    /// The number of triples (s, a, s') with (s,a) ∈ C and s' ∈ succ(s,a) ∩ X.
    fn count_transitions(&self, c: &Self::Choices, x: &Self::States) -> Result<Count>;

    /// Up to `limit` states of X in a fixed order: that of their values, first variable first.
    fn list_states(&self, x: &Self::States, limit: usize) -> Result<Vec<State>>;
    /// The set of one state; empty where it is not in the scope.
    fn singleton(&self, state: &[i64]) -> Result<Self::States>;
    /// s ∈ X
    fn contains(&self, x: &Self::States, state: &[i64]) -> bool;
    /// (s,a) ∈ C, for a choice that [`crate::model::Program::choices`] lists for s. For any other
    /// choice an engine may answer either way.
    fn contains_choice(&self, c: &Self::Choices, state: &[i64], choice: &Choice) -> bool;

    /// What was used so far.
    fn usage(&self) -> Usage;
    /// What the engine was created with.
    fn settings(&self) -> &Settings;
}
