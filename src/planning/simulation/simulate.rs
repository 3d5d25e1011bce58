//! Random runs under a strategy: the number of improvements, their times, and weakening steps.

use std::rc::Rc;
use std::sync::Arc;

use ahash::AHashMap;

use super::estimate::Sample;
use super::induced_model::Scheduler;
use super::opponent::Opponent;
use super::tally::{Achievements, Ending, RunEnd, Tally, Trace, Turn};
use crate::analysis::levels::Rank;
use crate::strategies::explain::{Explanation, gained, lost};
use crate::strategies::finite_memory::{FiniteMemoryStrategy, Memory, StrategyKind};
use meliora_base::error::Result;
use meliora_base::random::Draw;
use meliora_engine::Engine;
use meliora_model::State;
use meliora_model::preference::{Change, ObjectiveSet};

/// Maximum number of explained states that are kept for later visits.
const REMEMBERED: usize = 1 << 16;

/// The settings of a simulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Setup {
    /// The strategy that runs follow.
    pub scheduler: Scheduler,
    /// The number of runs per start state.
    pub runs: u64,
    /// Maximum number of steps of a run; a longer run is given up.
    pub steps: u64,
    /// The random seed: the same seed gives the same runs with any engine and on any machine.
    pub seed: u64,
}

/// A simulated run.
struct Run {
    trace: Trace,
    /// The memory after the last step.
    last: Memory,
    /// True if it ended before the limit: nothing is left to improve or to achieve, or it stays
    /// where it is.
    settled: bool,
    /// The state of its pursuit.
    end: Ending,
}

/// The part of a run that counting needs: MP of its start, and its commitment.
struct Course {
    first: ObjectiveSet,
    /// The objective to which the run committed last.
    commitment: Option<usize>,
    /// The objectives given up since then.
    given_up: ObjectiveSet,
    /// True after the first commitment.
    committed: bool,
}

impl Course {
    fn from(first: ObjectiveSet) -> Self {
        Course { first, commitment: None, given_up: ObjectiveSet::new(), committed: false }
    }

    /// Notes the commitment of the strategy in a state; returns it if it is new.
    fn commit(&mut self, at: &Explanation) -> Option<usize> {
        let present = at.pursued().filter(|_| at.commits());
        let new = present.filter(|_| present != self.commitment);
        if new.is_some() {
            self.given_up = ObjectiveSet::new();
        }
        self.committed |= new.is_some();
        self.commitment = present;
        new
    }
}

/// Returns the number of improvements that a decision rule aims at.
fn aim(memory: Memory) -> usize {
    match memory.level {
        Rank::Finite(k) | Rank::AtLeast(k) => k,
        Rank::Unbounded => usize::MAX,
    }
}

/// Simulation of runs under a finite-memory strategy.
pub struct Simulation<'b, E: Engine> {
    strategy: &'b mut FiniteMemoryStrategy<E>,
    setup: Setup,
    opponent: Opponent,
    seen: AHashMap<(State, Memory), Rc<Explanation>>,
}

impl<'b, E: Engine> Simulation<'b, E> {
    /// Creates a simulation without runs. In a game, the opponent chooses at random.
    pub fn new(strategy: &'b mut FiniteMemoryStrategy<E>, setup: Setup) -> Self {
        Simulation { strategy, setup, opponent: Opponent::Random, seen: AHashMap::new() }
    }

    /// Lets the opponent of a game choose in this way.
    #[must_use]
    pub fn against(self, opponent: Opponent) -> Self {
        Simulation { opponent, ..self }
    }

    /// Simulates all runs from one state of the scope. Cost: that of
    /// [`FiniteMemoryStrategy::explain`] per visited state and memory.
    ///
    /// # Errors
    /// The errors of [`FiniteMemoryStrategy::explain`].
    pub fn run(&mut self, start: &[i64]) -> Result<Tally> {
        self.run_each(start, &mut |_| ())
    }

    /// Simulates like [`Simulation::run`] and passes each complete run to `each`.
    ///
    /// # Errors
    /// The errors of [`Simulation::run`].
    pub fn run_each(&mut self, start: &[i64], each: &mut dyn FnMut(&Trace)) -> Result<Tally> {
        let mut tally = Tally::new(start, self.strategy.rank(start)?);
        tally.is_unsafe = self.strategy.is_unsafe(start)?;
        tally.first = self.strategy.most_preferred(start)?;
        let together = self.strategy.objectives().len() > 1;
        let none = || Achievements { together, ..Achievements::default() };
        tally.achieved = self.strategy.kind().achieves().then(none);
        let mut sample = match self.strategy.rule {
            Some(_) => Some(Sample::new(aim(self.strategy.start(start)?))),
            None => None,
        };
        let achieves = self.strategy.kind() == StrategyKind::Achieve;
        let sink = Arc::clone(&self.strategy.engine.settings().sink);
        let runs = self.setup.runs;
        for run in 1..=runs {
            sink.progress("runs", &|| format!("run {run} of {runs}"));
            let Run { trace, last, settled, end } = self.simulate(start, run)?;
            each(&trace);
            if let Some(sample) = sample.as_mut().filter(|_| achieves) {
                match end {
                    Ending::Achieved | Ending::Kept => sample.reach(0.0),
                    Ending::Open => sample.miss(!settled),
                }
            } else if let Some(sample) = &mut sample {
                match trace.cost_until(sample.improvements) {
                    Some(cost) => sample.reach(cost),
                    None => sample.miss(trace.improvements() + aim(last) >= sample.improvements),
                }
            }
            tally.add(trace, settled, end);
        }
        tally.sample = sample;
        Ok(tally)
    }

    /// Returns the first run from one state that makes as many improvements as the state's rank says
    /// and weakens nothing. If there is none, the run with most improvements is returned, and among
    /// these one that weakens nothing.
    ///
    /// # Errors
    /// The errors of [`Simulation::run`].
    pub fn telling(&mut self, start: &[i64]) -> Result<(Trace, RunEnd)> {
        let wanted = match self.strategy.rank(start)? {
            Rank::Finite(k) | Rank::AtLeast(k) => k,
            Rank::Unbounded => usize::MAX,
        };
        let mut best = (Trace::default(), RunEnd::Failed);
        let sink = Arc::clone(&self.strategy.engine.settings().sink);
        let runs = self.setup.runs;
        for run in 1..=runs {
            sink.progress("runs", &|| format!("run {run} of {runs}"));
            let Run { trace, settled, .. } = self.simulate(start, run)?;
            let end = match trace.improvements() >= wanted {
                true => RunEnd::Kept,
                false if settled => RunEnd::Failed,
                false => RunEnd::CutOff,
            };
            let merit = |t: &Trace| (t.improvements().min(wanted), !t.weakens());
            if run == 1 || merit(&trace) > merit(&best.0) {
                best = (trace, end);
            }
            // For an unbounded rank, a run that is cut off is sufficient.
            let told = best.1 == RunEnd::Kept || (wanted == usize::MAX && best.1 == RunEnd::CutOff);
            if told && !best.0.weakens() {
                break;
            }
        }
        Ok(best)
    }

    /// Simulates one run.
    fn simulate(&mut self, start: &[i64], number: u64) -> Result<Run> {
        let draw = &mut Draw::numbered(self.setup.seed, number);
        let mut course = Course::from(self.strategy.most_preferred(start)?);
        let (mut state, mut memory) = (start.to_vec(), self.strategy.start(start)?);
        let mut at = self.explained(&state, memory)?;
        let mut achieved = at.achieved.clone();
        let mut trace = Trace { run: number, achieved: achieved.clone(), turns: Vec::new() };
        let most = usize::try_from(self.setup.steps).unwrap_or(usize::MAX);
        while trace.turns.len() < most && !self.stays(&at) {
            let Some((mut turn, next)) = self.turn(&at, &mut course, draw) else { break };
            (state, memory) = (turn.state.clone(), next);
            at = self.explained(&state, memory)?;
            turn.achieved = at.achieved.iter().filter(|&objective| !achieved.contains(objective)).collect();
            achieved.extend_with(&turn.achieved);
            trace.turns.push(turn);
        }
        let settled = self.played(&at).is_empty() || self.stays(&at);
        let end = match at.memory.pursuit {
            Some(_) if at.is_achieved() => Ending::Achieved,
            Some(pursuit) if self.strategy.keeps(pursuit) => Ending::Kept,
            _ => Ending::Open,
        };
        Ok(Run { trace, last: memory, settled, end })
    }

    /// Returns the positions of the actions that the scheduler may take.
    fn played(&self, at: &Explanation) -> Vec<usize> {
        (0..at.actions.len()).filter(|&action| self.setup.scheduler.takes(at, action)).collect()
    }

    /// Returns whether a run that pursues an objective stays in the state forever, with the same
    /// memory: it keeps the objective there.
    fn stays(&self, at: &Explanation) -> bool {
        let (pursues, played) = (at.memory.pursuit.is_some(), self.played(at));
        let mut reached = played.iter().flat_map(|&action| &at.actions[action].successors);
        pursues && !played.is_empty() && reached.all(|s| s.state == at.state && s.next == at.memory)
    }

    /// Simulates one step; `None` if the strategy has no action.
    fn turn(&self, at: &Explanation, course: &mut Course, draw: &mut Draw) -> Option<(Turn, Memory)> {
        let action = match at.is_theirs() {
            true => self.opponent.pick(at, draw)?,
            false => {
                let played = self.played(at);
                *played.get(draw.below(played.len()))?
            }
        };
        let action = &at.actions[action];
        let to =
            action.successors.get(draw.by_probability(action.successors.iter().map(|s| s.probability)))?;
        let commits = course.commit(at);
        let mut gives_up = at.gives_up(to);
        gives_up = gives_up.iter().filter(|&objective| !course.given_up.contains(objective)).collect();
        course.given_up.extend_with(&gives_up);
        // Unsafe states are compared with nothing.
        let compared = !at.is_unsafe && !to.is_unsafe;
        let preferences = &self.strategy.preferences;
        let change = |from| match compared {
            true => preferences.change(from, &to.most_preferred),
            false => Change::Lateral,
        };
        let weakens = |from| !course.committed && change(from) == Change::Weakening;
        let lost = match compared {
            true => lost(preferences, &at.most_preferred, &to.most_preferred),
            false => ObjectiveSet::new(),
        };
        let gained_over_start = match change(&course.first) {
            Change::Improving => gained(preferences, &course.first, &to.most_preferred),
            Change::Weakening | Change::Lateral => ObjectiveSet::new(),
        };
        let turn = Turn {
            owner: at.owner,
            action: action.name.clone(),
            state: to.state.clone(),
            probability: to.probability,
            most_preferred: to.most_preferred.clone(),
            rank: to.rank,
            improves: to.improves,
            gained: to.gained.clone(),
            change: to.change,
            lost,
            is_unsafe: to.is_unsafe,
            weakens_step: weakens(&at.most_preferred),
            weakens_start: weakens(&course.first),
            gained_over_start,
            committed: course.committed,
            commits,
            gives_up,
            achieved: ObjectiveSet::new(),
            cost: self.strategy.rule.as_ref().map_or(0.0, |rule| rule.cost(at.memory, &at.state)),
        };
        Some((turn, to.next))
    }

    fn explained(&mut self, state: &[i64], memory: Memory) -> Result<Rc<Explanation>> {
        let key = (state.to_vec(), memory);
        if let Some(found) = self.seen.get(&key) {
            if let Some(limit) = self.strategy.engine.settings().sink.stop() {
                return Err(limit.into());
            }
            return Ok(Rc::clone(found));
        }
        let found = Rc::new(self.strategy.explain(state, memory)?);
        if self.seen.len() >= REMEMBERED {
            self.seen.clear();
        }
        self.seen.insert(key, Rc::clone(&found));
        Ok(found)
    }
}
