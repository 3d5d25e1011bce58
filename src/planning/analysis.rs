//! The whole analysis, phase by phase; what is known stays when a limit ends the work.

use std::sync::Arc;
use std::time::Duration;

use super::classes::Classes;
use super::finite_memory::FiniteMemoryStrategy;
use super::improvement::{Improvement, Safety};
use super::levels::{End, Kind, Levels, Rank};
use super::result::{
    AnalysisResult, ClassCount, LevelCounts, LevelsEnd, ModelCounts, ObjectiveCounts, Plan, Prospects,
};
use super::winning_regions::WinningRegions;
use super::{strategy, temporal};
use crate::engine::{Count, Engine};
use crate::error::{Error, Result};
use crate::held::Held;
use crate::model::preference::{Goal, Objective, ObjectiveSet, Preferences};
use crate::model::step::Choice;
use crate::model::{Program, State, fault};

/// What to compute.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Options {
    /// What the improvement MDP keeps.
    pub safety: Safety,
    /// The greatest level to compute; none for all.
    pub max_level: Option<usize>,
}

/// The phases of an analysis, in their order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Phase {
    /// Counting the model.
    Counts,
    /// The regions of the objectives, and the classes.
    Outcomes,
    /// The improvement MDP.
    Improvement,
    /// The SASI levels.
    Sasi,
    /// The SPI levels.
    Spi,
}

impl Phase {
    /// All phases in their order.
    pub const ALL: [Phase; 5] = [Phase::Counts, Phase::Outcomes, Phase::Improvement, Phase::Sasi, Phase::Spi];

    /// The phase that finds the levels of a kind.
    pub fn levels(kind: Kind) -> Phase {
        match kind {
            Kind::Sasi => Phase::Sasi,
            Kind::Spi => Phase::Spi,
        }
    }

    /// The phase that must be done before it.
    fn needs(self) -> Option<Phase> {
        match self {
            Phase::Counts | Phase::Outcomes => None,
            Phase::Improvement => Some(Phase::Outcomes),
            Phase::Sasi | Phase::Spi => Some(Phase::Improvement),
        }
    }

    /// The name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Phase::Counts => "counts",
            Phase::Outcomes => "outcomes",
            Phase::Improvement => "improvement",
            Phase::Sasi => "sasi",
            Phase::Spi => "spi",
        }
    }
}

/// What the listener of an analysis hears.
#[derive(Debug, Clone, Copy)]
pub enum Event<'a> {
    /// A phase begins.
    Started(Phase),
    /// The regions of an objective are known.
    Objective(&'a ObjectiveCounts),
    /// A level is known: which kind, which number (from 1), how many states.
    Level(Kind, usize, &'a Count),
    /// A phase is done, after so long by [`crate::progress::ProgressSink::clock`]. A phase that a limit ends has
    /// no such event.
    Finished(Phase, Duration),
}

/// WinningRegions, classes, improvement MDP and levels of one model under one preference file.
pub struct Analysis<'a, E: Engine> {
    engine: Held<'a, E>,
    preferences: Held<'a, Preferences>,
    options: Options,
    outcomes: Option<WinningRegions<E>>,
    // Shared with the strategies made of them.
    classes: Option<Arc<Classes<E>>>,
    improvement: Option<Arc<Improvement<E>>>,
    sasi: Arc<Levels<E>>,
    spi: Arc<Levels<E>>,
    result: AnalysisResult,
}

impl<'a, E: Engine> Analysis<'a, E> {
    /// An analysis of which nothing is computed yet.
    pub fn new(
        engine: impl Into<Held<'a, E>>,
        preferences: impl Into<Held<'a, Preferences>>,
        options: Options,
    ) -> Self {
        Analysis {
            engine: engine.into(),
            preferences: preferences.into(),
            options,
            outcomes: None,
            classes: None,
            improvement: None,
            sasi: Arc::new(Levels::new(Kind::Sasi)),
            spi: Arc::new(Levels::new(Kind::Spi)),
            result: AnalysisResult::default(),
        }
    }

    /// Everything, in the order of [`Phase`]. May be called again after a limit and goes on there.
    ///
    /// # Errors
    /// A limit of the engine, or a target without a value in some state. What was found before
    /// stays in [`Analysis::result`]. Cost: that of the phases; see [`WinningRegions::advance`],
    /// [`Improvement::new`] and [`super::levels::next_level`].
    pub fn run(&mut self, listener: &mut dyn FnMut(Event<'_>)) -> Result<()> {
        Phase::ALL.into_iter().try_for_each(|phase| self.run_phase(phase, listener))
    }

    /// One phase, or what a limit left of it; does nothing where it is done.
    ///
    /// # Errors
    /// As [`Analysis::run`]; [`Error::Usage`] where a phase that it needs is not done.
    pub fn run_phase(&mut self, phase: Phase, listener: &mut dyn FnMut(Event<'_>)) -> Result<()> {
        if self.is_done(phase) {
            return Ok(());
        }
        if let Some(before) = phase.needs().filter(|before| !self.is_done(*before)) {
            let message = format!("the phase `{}` needs the phase `{}`", phase.name(), before.name());
            return Err(Error::Usage(message));
        }
        let clock = Arc::clone(&self.engine.settings().sink);
        let start = clock.clock();
        listener(Event::Started(phase));
        match phase {
            Phase::Counts => self.run_counts()?,
            Phase::Outcomes => self.run_outcomes(listener)?,
            Phase::Improvement => self.run_improvement()?,
            Phase::Sasi => self.run_levels(Kind::Sasi, listener)?,
            Phase::Spi => self.run_levels(Kind::Spi, listener)?,
        }
        listener(Event::Finished(phase, clock.clock().saturating_sub(start)));
        Ok(())
    }

    /// Whether a phase has run to its end.
    pub fn is_done(&self, phase: Phase) -> bool {
        match phase {
            Phase::Counts => self.result.counts.is_some(),
            Phase::Outcomes => self.classes.is_some(),
            Phase::Improvement => self.improvement.is_some(),
            Phase::Sasi => self.result.sasi.end != LevelsEnd::Open,
            Phase::Spi => self.result.spi.end != LevelsEnd::Open,
        }
    }

    fn run_counts(&mut self) -> Result<()> {
        self.result.counts = Some(ModelCounts::of(&*self.engine)?);
        Ok(())
    }

    /// The regions of the objectives, and the classes. Cost: see [`WinningRegions::advance`] and [`Classes::new`].
    fn run_outcomes(&mut self, listener: &mut dyn FnMut(Event<'_>)) -> Result<()> {
        if self.outcomes.is_none() {
            let target = |o: &Objective| match &o.goal {
                Goal::Reach(target) => self.engine.states_where(*target),
                // A formula is satisfied by reaching where it is secured.
                Goal::Satisfy { condition, .. } => temporal::secured(&*self.engine, condition),
            };
            let targets = self.preferences.objectives.iter().map(target).collect::<Result<Vec<_>>>()?;
            self.outcomes = Some(WinningRegions::new(&*self.engine, targets)?);
        }
        while let Some(counts) = self.next_outcome()? {
            listener(Event::Objective(&counts));
            self.result.objectives.push(counts);
            self.result.objectives.sort_by_key(|o| o.objective);
        }
        let Some(almost_sure) = self.outcomes.as_ref().and_then(WinningRegions::almost_sure) else {
            return Ok(());
        };
        let classes = Classes::new(&*self.engine, &self.preferences, &almost_sure)?;
        let count = |c: &super::Class<E>| {
            let states = self.engine.count(&c.states)?;
            Ok(ClassCount { most_preferred: c.most_preferred.clone(), states })
        };
        self.result.classes = Some(classes.list.iter().map(count).collect::<Result<Vec<_>>>()?);
        self.classes = Some(Arc::new(classes));
        Ok(())
    }

    /// Computes one more objective, or counts one that a limit left uncounted.
    fn next_outcome(&mut self) -> Result<Option<ObjectiveCounts>> {
        let Some(outcomes) = &mut self.outcomes else { return Ok(None) };
        let counted = |i: &usize| self.result.objectives.iter().any(|o| o.objective == *i);
        let mut all = 0..self.preferences.objectives.len();
        let uncounted = all.find(|i| outcomes.get(*i).is_some() && !counted(i));
        let next = match uncounted {
            Some(objective) => Some(objective),
            None => outcomes.advance(&*self.engine)?,
        };
        let Some(objective) = next else { return Ok(None) };
        let Some(outcome) = outcomes.get(objective) else { return Ok(None) };
        Ok(Some(ObjectiveCounts {
            objective,
            target: self.engine.count(&outcome.target)?,
            almost_sure: self.engine.count(&outcome.almost_sure)?,
            positive: self.engine.count(&outcome.positive)?,
        }))
    }

    /// The improvement MDP. Cost: see [`Improvement::new`].
    fn run_improvement(&mut self) -> Result<()> {
        let Some(classes) = &self.classes else { return Ok(()) };
        let improvement = Improvement::new(&*self.engine, classes, self.options.safety)?;
        self.result.improvement = improvement.sizes(&*self.engine)?;
        self.improvement = Some(Arc::new(improvement));
        Ok(())
    }

    /// The levels of one kind; those found stay. Cost: see [`super::levels::next_level`].
    fn run_levels(&mut self, kind: Kind, listener: &mut dyn FnMut(Event<'_>)) -> Result<()> {
        let (Some(classes), Some(improvement)) = (&self.classes, &self.improvement) else {
            return Ok(());
        };
        let (levels, counts) = match kind {
            Kind::Sasi => (&mut self.sasi, &mut self.result.sasi),
            Kind::Spi => (&mut self.spi, &mut self.result.spi),
        };
        // Levels that strategies share are complete, but not always counted.
        if let Some(levels) = Arc::get_mut(levels) {
            while levels.advance(&*self.engine, classes, improvement, self.options.max_level)? {
                count_levels(&*self.engine, levels, counts, listener)?;
            }
        }
        count_levels(&*self.engine, levels, counts, listener)?;
        counts.end = match &levels.end {
            None => LevelsEnd::Open,
            Some(End::Cut) => LevelsEnd::Cut,
            Some(End::Empty) => LevelsEnd::Empty,
            Some(End::Unbounded(level)) => LevelsEnd::Unbounded(self.engine.count(&level.states)?),
        };
        Ok(())
    }

    /// What can be done from a state of the scope, as far as it is known.
    ///
    /// The actions at states of unknown rank are those of the greatest level found.
    ///
    /// # Errors
    /// A limit of the engine, or a command without a meaning in the state. Cost: that of
    /// [`strategy::permitted_at_start`] for the state's level.
    pub fn prospects(&self, program: &Program, state: &[i64]) -> Result<Prospects> {
        let choices = program.choices(state).map_err(|fault| fault::error(program, &fault, state))?;
        let most_preferred = match &self.classes {
            Some(classes) => classes
                .of(&*self.engine, state)
                .map_or_else(ObjectiveSet::new, |c| classes.list[c].most_preferred.clone()),
            None => ObjectiveSet::new(),
        };
        Ok(Prospects {
            state: state.to_vec(),
            most_preferred,
            sasi: self.plan(&self.sasi, state, &choices)?,
            spi: self.plan(&self.spi, state, &choices)?,
        })
    }

    /// The prospects of the first `limit` initial states.
    ///
    /// # Errors
    /// As [`Analysis::prospects`]. Cost: that for each state.
    pub fn initial_prospects(&self, program: &Program, limit: usize) -> Result<Vec<Prospects>> {
        let states: Vec<State> = self.engine.list_states(&self.engine.initial_states(), limit)?;
        states.iter().map(|state| self.prospects(program, state)).collect()
    }

    fn plan(&self, levels: &Levels<E>, state: &[i64], choices: &[(Choice, String)]) -> Result<Option<Plan>> {
        let (Some(classes), Some(improvement)) = (&self.classes, &self.improvement) else {
            return Ok(None);
        };
        if levels.found.is_empty() && levels.end.is_none() {
            return Ok(None);
        }
        let rank: Rank = levels.rank(&*self.engine, state);
        let mut actions = Vec::new();
        if let Some(level) = levels.level(rank) {
            let permitted =
                strategy::permitted_at_start(&*self.engine, levels.kind, classes, improvement, level)?;
            let allowed = choices.iter().filter(|(c, _)| self.engine.contains_choice(&permitted, state, c));
            actions = allowed.map(|(_, name)| name.clone()).collect();
        }
        Ok(Some(Plan { rank, actions }))
    }

    /// The counts of all that is known.
    pub fn result(&self) -> &AnalysisResult {
        &self.result
    }

    /// The engine.
    pub fn engine(&self) -> &E {
        &self.engine
    }

    /// The preferences.
    pub fn preferences(&self) -> &Preferences {
        &self.preferences
    }

    /// What was asked for.
    pub fn options(&self) -> Options {
        self.options
    }

    /// The regions of the objectives, once begun.
    pub fn outcomes(&self) -> Option<&WinningRegions<E>> {
        self.outcomes.as_ref()
    }

    /// The classes, once known.
    pub fn classes(&self) -> Option<&Classes<E>> {
        self.classes.as_deref()
    }

    /// The improvement MDP, once known.
    pub fn improvement(&self) -> Option<&Improvement<E>> {
        self.improvement.as_deref()
    }

    /// The levels of one kind, as far as they are known.
    pub fn levels(&self, kind: Kind) -> &Levels<E> {
        self.shared_levels(kind)
    }

    fn shared_levels(&self, kind: Kind) -> &Arc<Levels<E>> {
        match kind {
            Kind::Sasi => &self.sasi,
            Kind::Spi => &self.spi,
        }
    }
}

impl<'a, E: Engine> FiniteMemoryStrategy<'a, E> {
    /// The finite-memory strategy of an analysis; none before the levels of this kind were searched.
    pub fn new(
        analysis: &Analysis<'a, E>,
        program: impl Into<Held<'a, Program>>,
        kind: Kind,
    ) -> Option<Self> {
        let levels = analysis.shared_levels(kind);
        levels.end.as_ref()?;
        let lent = (analysis.engine.clone(), analysis.preferences.clone());
        let (classes, improvement) = (analysis.classes.clone()?, analysis.improvement.clone()?);
        Some(FiniteMemoryStrategy::of(lent, program.into(), classes, improvement, Arc::clone(levels)))
    }
}

/// Counts and announces the levels that are not counted yet.
fn count_levels<E: Engine>(
    engine: &E,
    levels: &Levels<E>,
    counts: &mut LevelCounts,
    listener: &mut dyn FnMut(Event<'_>),
) -> Result<()> {
    for level in &levels.found[counts.levels.len()..] {
        let count = engine.count(&level.states)?;
        listener(Event::Level(levels.kind, counts.levels.len() + 1, &count));
        counts.levels.push(count);
    }
    Ok(())
}
