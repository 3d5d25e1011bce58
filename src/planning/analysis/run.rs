//! The whole analysis, phase by phase; results remain available when a limit ends the work.

use std::sync::Arc;

use super::classes::Classes;
use super::improvement::Improvement;
use super::joint::{Joint, MOST};
use super::level_search::{LevelSearch, count_levels};
use super::levels::{End, Kind, Levels, Rank};
pub use super::phases::{Event, Phase};
use super::requirements::Requirements;
use super::result::{AnalysisResult, ClassCount, JointCount, LevelsEnd, ModelCounts, ObjectiveCounts};
use super::safety::Safety;
use super::temporal::{self, AcceptingRegion};
use super::winning_regions::{Sought, WinningRegions};
use meliora_base::error::{Error, Result};
use meliora_engine::{AnyEngine, Engine};
use meliora_model::preference::{Goal, ObjectiveSet, Preferences};

/// The options of an analysis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Options {
    /// The safety mode, which selects the kept choices.
    pub safety: Safety,
    /// The greatest level to compute; `None` for all.
    pub max_level: Option<usize>,
}

/// The winning regions, classes, improvement MDP and levels of one model under one preference file.
pub struct Analysis<E: Engine = AnyEngine> {
    /// The engine of the model as it is written.
    pub(crate) whole: Arc<E>,
    /// The engine of the model that the requirements leave; `whole` until they are known.
    pub(crate) engine: Arc<E>,
    requirements: Option<Arc<Requirements<E>>>,
    pub(crate) preferences: Arc<Preferences>,
    options: Options,
    outcomes: Option<WinningRegions<E>>,
    accepting: Vec<Vec<AcceptingRegion<E>>>,
    // Shared with the strategies that are created from them.
    pub(crate) classes: Option<Arc<Classes<E>>>,
    pub(crate) improvement: Option<Arc<Improvement<E>>>,
    joint: Option<Joint<E>>,
    sasi: LevelSearch<E>,
    spi: LevelSearch<E>,
    result: AnalysisResult,
}

impl<E: Engine> Analysis<E> {
    /// Creates an analysis without results.
    pub fn new(engine: &Arc<E>, preferences: &Arc<Preferences>, options: Options) -> Self {
        Analysis {
            whole: Arc::clone(engine),
            engine: Arc::clone(engine),
            requirements: None,
            preferences: Arc::clone(preferences),
            options,
            outcomes: None,
            accepting: Vec::new(),
            classes: None,
            improvement: None,
            joint: None,
            sasi: LevelSearch::new(Kind::Sasi),
            spi: LevelSearch::new(Kind::Spi),
            result: AnalysisResult::default(),
        }
    }

    /// Runs some phases one after the other.
    ///
    /// # Errors
    /// The errors of [`Analysis::run_phase`].
    pub fn run_phases(&mut self, phases: &[Phase], listener: &mut dyn FnMut(Event<'_>)) -> Result<()> {
        let (mut known, all) = (self.result.objectives.len(), self.preferences.objectives.len());
        let mut tell = |event: Event<'_>| {
            listener(event);
            known += usize::from(matches!(event, Event::Objective(_)));
            if let Some((phase, part)) = event.next_part(known, all) {
                listener(Event::Part(phase, &part));
            }
        };
        phases.iter().try_for_each(|&phase| self.begin(phase, &mut tell))
    }

    /// Runs one phase, or the rest of it after a limit; does nothing if the phase is complete.
    ///
    /// # Errors
    /// The errors of [`Analysis::run`]; [`Error::Usage`] if a phase that it needs is not complete.
    pub fn run_phase(&mut self, phase: Phase, listener: &mut dyn FnMut(Event<'_>)) -> Result<()> {
        self.run_phases(&[phase], listener)
    }

    fn begin(&mut self, phase: Phase, listener: &mut dyn FnMut(Event<'_>)) -> Result<()> {
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
        self.check_game()?;
        self.restrict()?;
        match phase {
            Phase::Counts => self.run_counts(listener)?,
            Phase::Outcomes => self.run_outcomes(listener)?,
            Phase::Improvement => self.run_improvement(listener)?,
            Phase::Sasi => self.run_levels(Kind::Sasi, listener)?,
            Phase::Spi => self.run_levels(Kind::Spi, listener)?,
        }
        listener(Event::Finished(phase, clock.clock().saturating_sub(start)));
        Ok(())
    }

    /// Returns whether a phase is complete.
    pub fn is_done(&self, phase: Phase) -> bool {
        match phase {
            Phase::Counts => self.result.counts.is_some(),
            Phase::Outcomes => self.classes.is_some(),
            Phase::Improvement => self.improvement.is_some(),
            Phase::Sasi => self.result.sasi.end != LevelsEnd::Open,
            Phase::Spi => self.result.spi.end != LevelsEnd::Open,
        }
    }

    /// Refuses a safety mode that is not supported for games.
    fn check_game(&self) -> Result<()> {
        match self.options.safety {
            Safety::Transition if self.whole.is_game() => {
                let others = "`action` and `prefix` hold against every strategy of the opponent";
                Err(Error::Usage(format!("`--safety transition` of a game is not supported; {others}")))
            }
            _ => Ok(()),
        }
    }

    /// Restricts the model by the requirements, once. Cost: see [`Requirements::restrict`].
    fn restrict(&mut self) -> Result<()> {
        if self.requirements.is_none()
            && let Some((engine, requirements)) =
                Requirements::restrict(&*self.whole, &self.preferences.requirements)?
        {
            (self.engine, self.requirements) = (Arc::new(engine), Some(Arc::new(requirements)));
        }
        Ok(())
    }

    fn run_counts(&mut self, listener: &mut dyn FnMut(Event<'_>)) -> Result<()> {
        let unsafe_states =
            self.requirements.as_ref().map(|r| self.engine.count(&r.unsafe_states)).transpose()?;
        let counts = ModelCounts { unsafe_states, ..ModelCounts::count(&*self.whole)? };
        self.result.tell(Event::Counts(&counts), listener);
        Ok(())
    }

    /// Computes the winning regions of the objectives, and the classes. Cost: see
    /// [`WinningRegions::advance`] and [`Classes::new`].
    fn run_outcomes(&mut self, listener: &mut dyn FnMut(Event<'_>)) -> Result<()> {
        if self.outcomes.is_none() {
            let goals = self.preferences.objectives.iter().map(|o| self.sought(&o.goal));
            let (goals, accepting) = goals.collect::<Result<Vec<_>>>()?.into_iter().unzip();
            self.outcomes = Some(WinningRegions::new(&*self.engine, goals)?);
            self.accepting = accepting;
        }
        while self.next_outcomes(listener)? {}
        let Some(almost_sure) = self.outcomes.as_ref().and_then(WinningRegions::almost_sure) else {
            return Ok(());
        };
        let classes = Classes::new(&*self.engine, &self.preferences, &almost_sure)?;
        let count = |c: &crate::Class<E>| {
            let states = self.engine.count(&c.states)?;
            let most_preferred = self.preferences.owned_names(&c.most_preferred);
            Ok(ClassCount { most_preferred, states, jointly: None, jointly_limit: None })
        };
        let counts = classes.list.iter().map(count).collect::<Result<Vec<_>>>()?;
        self.result.tell(Event::Classes(&counts), listener);
        self.classes = Some(Arc::new(classes));
        Ok(())
    }

    /// Returns the goal of an objective, and the regions in which disjuncts of a temporal one can be kept.
    /// A formula can be satisfied from a state where a disjunct can be kept, so these states are the
    /// target.
    fn sought(&self, goal: &Goal) -> Result<(Sought<E>, Vec<AcceptingRegion<E>>)> {
        let engine = &*self.engine;
        match goal {
            Goal::Reach(target) => {
                Ok((Sought { target: engine.states_where(target)?, condition: None }, Vec::new()))
            }
            Goal::Satisfy { condition, .. } => {
                let regions = temporal::accepting_regions(engine, condition, &engine.all_choices())?;
                let condition = engine.theirs().map(|_| condition.clone());
                Ok((Sought { target: temporal::secured(engine, &regions)?, condition }, regions))
            }
        }
    }

    /// Computes the regions of the next objectives, and reports all that are known. Returns whether
    /// there may be more.
    fn next_outcomes(&mut self, listener: &mut dyn FnMut(Event<'_>)) -> Result<bool> {
        let Some(outcomes) = &mut self.outcomes else { return Ok(false) };
        // The results before an error are kept.
        let end = outcomes.advance(&*self.engine);
        for &objective in outcomes.order() {
            if self.result.objectives.iter().any(|o| o.objective == objective) {
                continue;
            }
            // After a limit, nothing more is counted.
            let counts = match &end {
                Ok(_) => outcomes.counts(&*self.engine, objective)?,
                Err(_) => outcomes.counted(objective),
            };
            let Some(counts) = counts else { continue };
            let counts = ObjectiveCounts::new(&self.preferences, objective, counts);
            self.result.tell(Event::Objective(&counts), listener);
        }
        end.map(|next| next.is_some())
    }

    /// Computes the improvement MDP. Cost: see [`Improvement::new`].
    fn run_improvement(&mut self, listener: &mut dyn FnMut(Event<'_>)) -> Result<()> {
        let Some(classes) = &self.classes else { return Ok(()) };
        let improvement = Improvement::new(&*self.engine, classes, self.options.safety)?;
        let counts = self.result.counts.as_ref().filter(|_| self.requirements.is_none());
        let transitions = counts.map(|counts| &counts.transitions);
        if let Some(sizes) = improvement.sizes(&*self.engine, transitions)? {
            self.result.tell(Event::Improvement(&sizes), listener);
        }
        self.improvement = Some(Arc::new(improvement));
        Ok(())
    }

    /// Computes the remaining levels of one kind. Cost: see
    /// [`super::levels::next_level`].
    fn run_levels(&mut self, kind: Kind, listener: &mut dyn FnMut(Event<'_>)) -> Result<()> {
        let (Some(classes), Some(improvement)) = (&self.classes, &self.improvement) else {
            return Ok(());
        };
        let (engine, max) = (&*self.engine, self.options.max_level);
        let search = match kind {
            Kind::Sasi => &mut self.sasi,
            Kind::Spi => &mut self.spi,
        };
        let result = &mut self.result;
        if let Some(levels) = search.open() {
            while levels.advance(engine, classes, improvement, max)? {
                count_levels(engine, levels, result, listener)?;
            }
            search.close();
        }
        // A limit may have left some of the levels uncounted.
        let levels = search.levels();
        count_levels(engine, levels, result, listener)?;
        let end = match &levels.end {
            None => LevelsEnd::Open,
            Some(End::Cut) => LevelsEnd::Cut,
            Some(End::Empty) => LevelsEnd::Empty,
            Some(End::Unbounded(level)) => LevelsEnd::Unbounded(engine.count(&level.states)?),
        };
        result.tell(Event::LevelsEnd(kind, &end), listener);
        Ok(())
    }

    /// Computes which most preferred objectives can be achieved together, and adds them to the result;
    /// for classes that are too large, the limit. Needs the classes. Cost: see `Joint::new`.
    ///
    /// # Errors
    /// The errors of `Joint::new`.
    pub fn run_jointly(&mut self, listener: &mut dyn FnMut(Event<'_>)) -> Result<()> {
        let joint = Joint::new(self)?;
        let classes = self.classes.iter().flat_map(|classes| &classes.list);
        let mut counts = self.result.classes.clone().unwrap_or_default();
        for (class, count) in classes.zip(&mut counts) {
            let counted = |(set, states): (ObjectiveSet, E::States)| {
                let objectives = self.preferences.owned_names(&set);
                Ok(JointCount { objectives, states: self.engine.count(&states)? })
            };
            match joint.of_class(&*self.engine, class)? {
                Some(found) => {
                    count.jointly = Some(found.into_iter().map(counted).collect::<Result<_>>()?);
                }
                None => count.jointly_limit = Some(MOST),
            }
        }
        self.result.tell(Event::Classes(&counts), listener);
        self.joint = Some(joint);
        Ok(())
    }

    /// Returns an analysis of the same model and preferences under other options, without results.
    pub fn with_options(&self, options: Options) -> Self {
        Analysis {
            engine: Arc::clone(&self.engine),
            requirements: self.requirements.clone(),
            ..Self::new(&self.whole, &self.preferences, options)
        }
    }

    /// Returns rank(s) = max { k : s ∈ W_k }; see [`Levels::rank`].
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub fn rank(&self, kind: Kind, state: &[i64]) -> Result<Rank> {
        self.levels(kind).rank(&*self.engine, state)
    }

    /// Returns whether no strategy keeps the requirements from a state of the scope; false before a
    /// phase has begun.
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub fn is_unsafe(&self, state: &[i64]) -> Result<bool> {
        self.requirements.as_ref().map_or(Ok(false), |r| self.engine.contains(&r.unsafe_states, state))
    }

    /// Returns the names of the objectives in MP(s); empty before the classes are known.
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub fn most_preferred(&self, state: &[i64]) -> Result<Vec<&str>> {
        let Some(classes) = &self.classes else { return Ok(Vec::new()) };
        Ok(self.preferences.names(&classes.most_preferred(&*self.engine, state)?))
    }

    /// Returns the counts of all results so far.
    pub fn result(&self) -> &AnalysisResult {
        &self.result
    }

    /// Returns the engine of the analysed model. Under requirements, and once a phase has begun, it
    /// has only the states from which they can be kept, and the choices that keep them.
    pub fn engine(&self) -> &E {
        &self.engine
    }

    /// Returns the engine of the model as it is written, which accepts the sets of
    /// [`Analysis::engine`].
    pub fn whole_engine(&self) -> &E {
        &self.whole
    }

    /// Returns the states for which the program lists a choice that is not in a set. In the others,
    /// every listed choice is in it: no test of single choices is needed there.
    ///
    /// Programs list the choices of the model as it is written, so this is about that model, whatever
    /// the requirements leave of it. Cost: no image.
    pub fn partly_in(&self, choices: &E::Choices) -> Result<E::States> {
        let listed = self.whole.all_choices();
        self.whole.sources(&self.whole.difference(&listed, choices)?)
    }

    /// Returns the sets of the requirements; `None` without requirements, and before a phase has
    /// begun.
    pub fn requirements(&self) -> Option<&Requirements<E>> {
        self.requirements.as_deref()
    }

    /// Returns the preferences.
    pub fn preferences(&self) -> &Preferences {
        &self.preferences
    }

    /// Returns the regions in which objectives are jointly achievable, once they were asked for.
    pub(crate) fn joint(&self) -> Option<&Joint<E>> {
        self.joint.as_ref()
    }

    /// Returns the options.
    pub fn options(&self) -> Options {
        self.options
    }

    /// Returns the winning regions of the objectives, once their computation has begun.
    pub fn outcomes(&self) -> Option<&WinningRegions<E>> {
        self.outcomes.as_ref()
    }

    /// Returns the sets behind the target of a temporal objective, one per disjunct; empty for
    /// other objectives, and before their computation.
    pub fn accepting_regions(&self, objective: usize) -> &[AcceptingRegion<E>] {
        self.accepting.get(objective).map_or(&[], Vec::as_slice)
    }

    /// Returns the classes, once known.
    pub fn classes(&self) -> Option<&Classes<E>> {
        self.classes.as_deref()
    }

    /// Returns the improvement MDP, once known.
    pub fn improvement(&self) -> Option<&Improvement<E>> {
        self.improvement.as_deref()
    }

    /// Returns the bad states of a game, once known; see [`Improvement::bad`].
    pub fn bad(&self) -> Option<&E::States> {
        self.improvement()?.bad.as_ref()
    }

    /// Returns the levels of one kind found so far.
    pub fn levels(&self, kind: Kind) -> &Levels<E> {
        self.search(kind).levels()
    }

    pub(crate) fn search(&self, kind: Kind) -> &LevelSearch<E> {
        match kind {
            Kind::Sasi => &self.sasi,
            Kind::Spi => &self.spi,
        }
    }
}
