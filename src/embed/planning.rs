//! An analysis, and the strategies found by it.

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

/// WinningRegions, classes, improvement MDP and levels of an explored model under preferences.
pub struct Planning {
    engine: Arc<AnyEngine>,
    preferences: Arc<Preferences>,
    analysis: Analysis<'static, AnyEngine>,
    /// The name of the text that the preferences are from.
    source: Arc<str>,
}

impl Planning {
    pub(super) fn of(
        engine: AnyEngine,
        preferences: Preferences,
        source: impl Into<Arc<str>>,
        options: Options,
    ) -> Self {
        Self::new((Arc::new(engine), Arc::new(preferences)), source.into(), options)
    }

    fn new(
        (engine, preferences): (Arc<AnyEngine>, Arc<Preferences>),
        source: Arc<str>,
        options: Options,
    ) -> Self {
        let analysis = Analysis::new(Arc::clone(&engine), Arc::clone(&preferences), options);
        Planning { engine, preferences, analysis, source }
    }

    /// Computes everything, or what a limit left open; `listener` hears of each step.
    ///
    /// # Errors
    /// A limit, a target without a value in some state. What was found before stays.
    pub fn run(&mut self, listener: &mut dyn FnMut(Event<'_>)) -> Result<()> {
        self.analysis.run(listener)
    }

    /// Computes one phase, where those before it are known.
    ///
    /// # Errors
    /// Those of [`Planning::run`].
    pub fn run_phase(&mut self, phase: Phase, listener: &mut dyn FnMut(Event<'_>)) -> Result<()> {
        self.analysis.run_phase(phase, listener)
    }

    /// The same model and preferences under other options; of the phases, nothing is computed yet.
    pub fn with_options(&self, options: Options) -> Self {
        let shared = (Arc::clone(&self.engine), Arc::clone(&self.preferences));
        Self::new(shared, Arc::clone(&self.source), options)
    }

    /// The counts of all that is known.
    pub fn result(&self) -> &AnalysisResult {
        self.analysis.result()
    }

    /// The analysis itself.
    pub fn analysis(&self) -> &Analysis<'static, AnyEngine> {
        &self.analysis
    }

    /// The engine, which knows the targets of the preferences.
    pub fn engine(&self) -> &AnyEngine {
        &self.engine
    }

    /// The states that it is about: those explored, or where whole plays count those beside monitors.
    pub fn exploration(&self) -> Exploration {
        Exploration::of(AnyEngine::clone(&self.engine))
    }

    /// The program, with the targets of the preferences.
    pub fn program(&self) -> &Arc<Program> {
        self.engine.program()
    }

    /// The name of the text that the preferences are from.
    pub fn source(&self) -> &str {
        &self.source
    }

    /// The preferences.
    pub fn preferences(&self) -> &Preferences {
        &self.preferences
    }

    /// All regions known so far by name: `target:A`, `almost-sure:A`, `positive:A`, `class:A+B`, `sasi:1`, …
    pub fn regions(&self) -> Vec<(String, States)> {
        let of = |(name, set): (String, &crate::engine::any::AnyStates)| {
            (name, States::of(&self.engine, set.clone()))
        };
        regions(&self.analysis).into_iter().map(of).collect()
    }

    /// The region of a name, if it is known.
    pub fn region(&self, name: &str) -> Option<States> {
        let (_, set) = regions(&self.analysis).into_iter().find(|(own, _)| own == name)?;
        Some(States::of(&self.engine, set.clone()))
    }

    /// W_1 ⊋ W_2 ⊋ … of one kind, as far as they are known.
    pub fn levels(&self, kind: Kind) -> Vec<States> {
        let found = &self.analysis.levels(kind).found;
        found.iter().map(|level| States::of(&self.engine, level.states.clone())).collect()
    }

    /// rank(s) = max { k : s ∈ W_k }
    pub fn rank(&self, kind: Kind, state: &[i64]) -> Rank {
        self.analysis.levels(kind).rank(&self.engine, state)
    }

    /// The names of the most preferred outcomes of a state; empty before the classes are known.
    pub fn most_preferred(&self, state: &[i64]) -> Vec<&str> {
        let Some(classes) = self.analysis.classes() else { return Vec::new() };
        let class = classes.of(&*self.engine, state).map(|c| &classes.list[c].most_preferred);
        class.map_or_else(Vec::new, |mp| self.preferences.names(mp))
    }

    /// What can be done from a state, as far as it is known.
    ///
    /// # Errors
    /// A limit; a command without a meaning in the state.
    pub fn prospects(&self, state: &[i64]) -> Result<Prospects> {
        self.analysis.prospects(self.program(), state)
    }

    /// The strategies of one kind.
    ///
    /// # Errors
    /// [`Error::Usage`] before the levels of this kind were searched.
    pub fn strategy(&self, kind: Kind) -> Result<Strategy> {
        let missing = || Error::Usage("strategies need the levels; run the planning first".to_owned());
        let book = FiniteMemoryStrategy::new(&self.analysis, Arc::clone(self.program()), kind)
            .ok_or_else(missing)?;
        Ok(Strategy { book })
    }
}

/// What to do in each state, and why.
pub struct Strategy {
    book: FiniteMemoryStrategy<'static, AnyEngine>,
}

impl Strategy {
    /// Whether nothing is left to compute before a state in which planning starts is explained.
    pub fn knows(&self, state: &[i64]) -> bool {
        self.book.knows(self.book.start(state))
    }

    /// The playbook, with the strategies computed so far.
    pub fn book(&mut self) -> &mut FiniteMemoryStrategy<'static, AnyEngine> {
        &mut self.book
    }

    /// Every enabled action of a state in which planning starts: whether it is permitted, whether it comes
    /// closer to an improvement, and why.
    ///
    /// # Errors
    /// A limit; a command without a meaning in the state.
    pub fn explain(&mut self, state: &[i64]) -> Result<Explanation> {
        let memory = self.book.start(state);
        self.book.explain(state, memory)
    }

    /// The names of the permitted actions of a state in which planning starts.
    ///
    /// # Errors
    /// Those of [`Strategy::explain`].
    pub fn permitted(&mut self, state: &[i64]) -> Result<Vec<String>> {
        let actions = self.explain(state)?.actions;
        Ok(actions.into_iter().filter(|a| a.permitted).map(|a| a.name).collect())
    }

    /// Random plays from a state.
    ///
    /// # Errors
    /// Those of [`Strategy::explain`].
    pub fn simulate(&mut self, setup: Setup, start: &State) -> Result<Tally> {
        Simulation::new(&mut self.book, setup).run(start)
    }
}
