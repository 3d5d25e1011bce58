//! An analysis, and its strategies.

use std::sync::Arc;

use super::{Exploration, States};
use crate::engine::AnyEngine;
use crate::error::{Error, Result};
use crate::model::preference::Preferences;
use crate::model::{Program, State};
use crate::planning::explain::Explanation;
use crate::planning::regions::regions;
use crate::planning::result::Prospects;
use crate::planning::simulate::Tally;
use crate::planning::{
    Analysis, AnalysisResult, Event, FiniteMemoryStrategy, Kind, Options, Phase, Rank, Setup, Simulation,
};

/// The winning regions, classes, improvement MDP and levels of an explored model under preferences.
pub struct Planning {
    engine: Arc<AnyEngine>,
    preferences: Arc<Preferences>,
    analysis: Analysis<AnyEngine>,
    /// The name of the text with the preferences.
    source: Arc<str>,
}

impl Planning {
    pub(super) fn of(
        engine: AnyEngine,
        preferences: Preferences,
        source: impl Into<Arc<str>>,
        options: Options,
    ) -> Self {
        Self::new(Arc::new(engine), Arc::new(preferences), source.into(), options)
    }

    fn new(
        engine: Arc<AnyEngine>,
        preferences: Arc<Preferences>,
        source: Arc<str>,
        options: Options,
    ) -> Self {
        let analysis = Analysis::new(&engine, &preferences, options);
        Planning { engine, preferences, analysis, source }
    }

    /// Computes all phases that are not complete yet; `listener` receives an event for each step.
    ///
    /// # Errors
    /// A limit is reached; a target has no value in some state. Earlier results are kept.
    pub fn run(&mut self, listener: &mut dyn FnMut(Event<'_>)) -> Result<()> {
        self.analysis.run(listener)
    }

    /// Computes one phase, if the phases before it are complete.
    ///
    /// # Errors
    /// The errors of [`Planning::run`].
    pub fn run_phase(&mut self, phase: Phase, listener: &mut dyn FnMut(Event<'_>)) -> Result<()> {
        self.analysis.run_phase(phase, listener)
    }

    /// Returns a planning with the same model and preferences under other options, without results.
    pub fn with_options(&self, options: Options) -> Self {
        let (engine, preferences) = (Arc::clone(&self.engine), Arc::clone(&self.preferences));
        Self::new(engine, preferences, Arc::clone(&self.source), options)
    }

    /// Returns the counts of all results so far.
    pub fn result(&self) -> &AnalysisResult {
        self.analysis.result()
    }

    /// Returns the analysis.
    pub fn analysis(&self) -> &Analysis<AnyEngine> {
        &self.analysis
    }

    /// Returns the engine, which has the targets of the preferences.
    pub fn engine(&self) -> &AnyEngine {
        &self.engine
    }

    /// Returns the states that are analysed: the explored ones, or with `history = play` those of
    /// the product with the monitors.
    pub fn exploration(&self) -> Exploration {
        Exploration::of(AnyEngine::clone(&self.engine))
    }

    /// Returns the program, with the targets of the preferences.
    pub fn program(&self) -> &Arc<Program> {
        self.engine.program()
    }

    /// Returns the name of the text with the preferences.
    pub fn source(&self) -> &str {
        &self.source
    }

    /// Returns the preferences.
    pub fn preferences(&self) -> &Preferences {
        &self.preferences
    }

    /// Returns all regions known so far with their names: `target:A`, `almost-sure:A`,
    /// `positive:A`, `class:A+B`, `sasi:1`, …
    pub fn regions(&self) -> Vec<(String, States)> {
        let of = |(name, set): (String, &crate::engine::any::AnyStates)| {
            (name, States::of(&self.engine, set.clone()))
        };
        regions(&self.analysis).into_iter().map(of).collect()
    }

    /// Returns the region with a name, if it is known.
    pub fn region(&self, name: &str) -> Option<States> {
        let (_, set) = regions(&self.analysis).into_iter().find(|(own, _)| own == name)?;
        Some(States::of(&self.engine, set.clone()))
    }

    /// Returns the levels W_1 ⊋ W_2 ⊋ … of one kind that are known.
    pub fn levels(&self, kind: Kind) -> Vec<States> {
        let found = &self.analysis.levels(kind).found;
        found.iter().map(|level| States::of(&self.engine, level.states.clone())).collect()
    }

    /// Returns rank(s) = max { k : s ∈ W_k }.
    ///
    /// # Errors
    /// The errors of [`Engine::contains`](crate::engine::Engine::contains).
    pub fn rank(&self, kind: Kind, state: &[i64]) -> Result<Rank> {
        self.analysis.levels(kind).rank(&self.engine, state)
    }

    /// Returns the names of the most preferred objectives of a state; empty before the classes are
    /// known.
    ///
    /// # Errors
    /// The errors of [`Engine::contains`](crate::engine::Engine::contains).
    pub fn most_preferred(&self, state: &[i64]) -> Result<Vec<&str>> {
        let Some(classes) = self.analysis.classes() else { return Ok(Vec::new()) };
        Ok(self.preferences.names(&classes.most_preferred(&*self.engine, state)?))
    }

    /// Returns the prospects of a state, as far as they are known.
    ///
    /// # Errors
    /// A command has no meaning in the state; a limit is reached.
    pub fn prospects(&self, state: &[i64]) -> Result<Prospects> {
        self.analysis.prospects(self.program(), state)
    }

    /// Returns the strategies of one kind.
    ///
    /// # Errors
    /// [`Error::Usage`] before the levels of this kind were computed.
    pub fn strategy(&self, kind: Kind) -> Result<Strategy> {
        let missing = || Error::Usage("strategies need the levels; run the planning first".to_owned());
        let book = FiniteMemoryStrategy::new(&self.analysis, self.program(), kind).ok_or_else(missing)?;
        Ok(Strategy { book })
    }
}

/// A finite-memory strategy with explanations.
pub struct Strategy {
    book: FiniteMemoryStrategy<AnyEngine>,
}

impl Strategy {
    /// Returns true if the explanation of a start state needs no further computation.
    ///
    /// # Errors
    /// The errors of [`Engine::contains`](crate::engine::Engine::contains).
    pub fn knows(&self, state: &[i64]) -> Result<bool> {
        Ok(self.book.knows(self.book.start(state)?))
    }

    /// Returns the finite-memory strategy, with the parts computed so far.
    pub fn book(&mut self) -> &mut FiniteMemoryStrategy<AnyEngine> {
        &mut self.book
    }

    /// Explains every enabled action of a start state: if it is permitted, if it comes closer to an
    /// improvement, and why.
    ///
    /// # Errors
    /// A command has no meaning in the state; a limit is reached.
    pub fn explain(&mut self, state: &[i64]) -> Result<Explanation> {
        let memory = self.book.start(state)?;
        self.book.explain(state, memory)
    }

    /// Returns the names of the permitted actions of a start state.
    ///
    /// # Errors
    /// The errors of [`Strategy::explain`].
    pub fn permitted(&mut self, state: &[i64]) -> Result<Vec<String>> {
        let actions = self.explain(state)?.actions;
        Ok(actions.into_iter().filter(|a| a.permitted).map(|a| a.name).collect())
    }

    /// Simulates random runs from a state.
    ///
    /// # Errors
    /// The errors of [`Strategy::explain`].
    pub fn simulate(&mut self, setup: Setup, start: &State) -> Result<Tally> {
        Simulation::new(&mut self.book, setup).run(start)
    }
}
