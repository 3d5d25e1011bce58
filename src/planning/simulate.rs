//! Random runs under a strategy: the number of improvements, their times, and weakening steps.

use std::collections::BTreeMap;
use std::rc::Rc;

use ahash::AHashMap;

use super::estimate::Sample;
use super::explain::{Explanation, lost};
use super::finite_memory::{FiniteMemoryStrategy, Memory};
use super::induced_model::Scheduler;
use super::levels::Rank;
use crate::engine::Engine;
use crate::error::Result;
use crate::model::State;
use crate::model::preference::{Change, ObjectiveSet};
use crate::random::Draw;

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

/// The statistics of the runs from one state.
#[derive(Debug, Clone, PartialEq)]
pub struct Tally {
    /// The state in which the runs start.
    pub start: State,
    /// True if no strategy keeps the requirements from it; the runs then have no step.
    pub is_unsafe: bool,
    /// rank(s), the number of improvements that the strategy guarantees (SASI) or makes possible
    /// (SPI).
    pub rank: Rank,
    /// The number of runs.
    pub plays: u64,
    /// The number of runs by number of improvements.
    pub improvements: BTreeMap<usize, u64>,
    /// For each improvement (first, second, …), its number of steps since the start.
    pub waits: Vec<Wait>,
    /// The number of runs that ended in a state where no improvement is left.
    pub settled: u64,
    /// The number of runs that were given up.
    pub given_up: u64,
    /// The number of given-up runs that had made fewer improvements than the rank.
    pub undecided: u64,
    /// The number of runs with a step that weakens the state before it.
    pub weakened_step: u64,
    /// The number of runs with a step that weakens the strategy's reference. Under `prefix` this is
    /// the state where planning started or the last improvement after it, else the state before the
    /// step.
    pub weakened_reference: u64,
    /// The number of runs with a state that weakens the start state.
    pub weakened_start: u64,
    /// The runs as a sample of the value that a decision rule attains, if there is a rule.
    pub sample: Option<Sample>,
    /// The first run that weakened, or the first run if none did.
    pub trace: Trace,
}

/// The number of steps until an improvement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Wait {
    /// The number of runs with this improvement.
    pub plays: u64,
    /// The smallest number of steps.
    pub least: u64,
    /// The largest number of steps.
    pub most: u64,
    /// The sum of the steps over these runs.
    pub total: u64,
}

impl Wait {
    fn add(&mut self, steps: u64) {
        self.plays += 1;
        self.least = self.least.min(steps);
        self.most = self.most.max(steps);
        self.total += steps;
    }

    /// Returns the mean number of steps.
    pub fn mean(&self) -> f64 {
        self.total as f64 / self.plays as f64
    }
}

/// A complete run.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trace {
    /// The number of the run, from 1.
    pub play: u64,
    /// The steps.
    pub turns: Vec<Turn>,
}

impl Trace {
    /// Returns the number of improvements.
    pub fn improvements(&self) -> usize {
        self.turns.iter().filter(|turn| turn.improves).count()
    }

    /// Returns the cost until the k-th improvement; `None` if there are fewer.
    fn cost_until(&self, k: usize) -> Option<f64> {
        let (mut left, mut cost) = (k, 0.0);
        let mut turns = self.turns.iter();
        while left > 0 {
            let turn = turns.next()?;
            cost += turn.cost;
            left -= usize::from(turn.improves);
        }
        Some(cost)
    }

    fn weakens(&self) -> bool {
        self.turns.iter().any(|turn| turn.weakens_step || turn.weakens_start)
    }
}

/// The end of a run, compared with the rank of its start state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlayEnd {
    /// The run made as many improvements as the rank says.
    Kept,
    /// The run was given up before.
    CutOff,
    /// The run ended before.
    Failed,
}

/// A step of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Turn {
    /// The action taken.
    pub action: String,
    /// The state entered.
    pub state: State,
    /// The probability of this branch of the action.
    pub probability: f64,
    /// MP of the state entered.
    pub most_preferred: ObjectiveSet,
    /// The rank of the state entered.
    pub rank: Rank,
    /// True if the step was an improvement.
    pub improves: bool,
    /// The objectives gained, compared with the reference.
    pub gained: ObjectiveSet,
    /// The effect of the step, compared with the reference. An improving step may not count as an
    /// improvement of the run: the other improvements of the level could then not follow.
    pub change: Change,
    /// The objectives lost, compared with the state before.
    pub lost: ObjectiveSet,
    /// True if the step weakens the state before.
    pub weakens_step: bool,
    /// True if the step weakens the start state of the run.
    pub weakens_start: bool,
    /// The cost of the step under a decision rule; 0 without one.
    pub cost: f64,
}

impl Tally {
    fn new(start: &[i64], rank: Rank) -> Self {
        Tally {
            start: start.to_vec(),
            is_unsafe: false,
            rank,
            plays: 0,
            improvements: BTreeMap::new(),
            waits: Vec::new(),
            settled: 0,
            given_up: 0,
            undecided: 0,
            weakened_step: 0,
            weakened_reference: 0,
            weakened_start: 0,
            sample: None,
            trace: Trace::default(),
        }
    }

    /// Returns the number of runs with fewer than `times` improvements.
    pub fn fewer_than(&self, times: usize) -> u64 {
        self.improvements.range(..times).map(|(_, plays)| plays).sum()
    }

    /// Returns the number of runs with fewer improvements than the rank says; `None` if the rank is
    /// unbounded.
    pub fn fewer_than_rank(&self) -> Option<u64> {
        match self.rank {
            Rank::Finite(k) | Rank::AtLeast(k) => Some(self.fewer_than(k)),
            Rank::Unbounded => None,
        }
    }

    fn add(&mut self, trace: Trace, settled: bool) {
        self.plays += 1;
        let mut improved = 0;
        for (step, turn) in (1..).zip(&trace.turns) {
            if !turn.improves {
                continue;
            }
            if improved == self.waits.len() {
                self.waits.push(Wait { plays: 0, least: u64::MAX, most: 0, total: 0 });
            }
            self.waits[improved].add(step);
            improved += 1;
        }
        *self.improvements.entry(improved).or_default() += 1;
        if settled {
            self.settled += 1;
        } else {
            self.given_up += 1;
            let kept = matches!(self.rank, Rank::Finite(k) | Rank::AtLeast(k) if improved >= k);
            self.undecided += u64::from(!kept);
        }
        let step = trace.turns.iter().any(|t| t.weakens_step);
        let start = trace.turns.iter().any(|t| t.weakens_start);
        let first_to_weaken = (step || start) && self.weakened_step + self.weakened_start == 0;
        self.weakened_step += u64::from(step);
        let reference = trace.turns.iter().any(|t| t.change == Change::Weakening);
        self.weakened_reference += u64::from(reference);
        self.weakened_start += u64::from(start);
        if first_to_weaken || self.plays == 1 {
            self.trace = trace;
        }
    }
}

/// A simulated run.
struct Run {
    turns: Vec<Turn>,
    /// The memory after the last step.
    last: Memory,
    /// True if it ended where nothing is left to improve.
    settled: bool,
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
    book: &'b mut FiniteMemoryStrategy<E>,
    setup: Setup,
    seen: AHashMap<(State, Memory), Rc<Explanation>>,
}

impl<'b, E: Engine> Simulation<'b, E> {
    /// Creates a simulation without runs.
    pub fn new(book: &'b mut FiniteMemoryStrategy<E>, setup: Setup) -> Self {
        Simulation { book, setup, seen: AHashMap::new() }
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
        let mut tally = Tally::new(start, self.book.rank(start)?);
        tally.is_unsafe = self.book.is_unsafe(start)?;
        let mut sample = match self.book.rule {
            Some(_) => Some(Sample::new(aim(self.book.start(start)?))),
            None => None,
        };
        for play in 1..=self.setup.runs {
            let Run { turns, last, settled } = self.play(start, play)?;
            let trace = Trace { play, turns };
            each(&trace);
            if let Some(sample) = &mut sample {
                match trace.cost_until(sample.improvements) {
                    Some(cost) => sample.reach(cost),
                    None => sample.miss(trace.improvements() + aim(last) >= sample.improvements),
                }
            }
            tally.add(trace, settled);
        }
        tally.sample = sample;
        Ok(tally)
    }

    /// Returns the first run from one state that weakens nothing and makes as many improvements as
    /// the state's rank says; if there is none, returns the run that comes closest.
    ///
    /// # Errors
    /// The errors of [`Simulation::run`].
    pub fn telling(&mut self, start: &[i64]) -> Result<(Trace, PlayEnd)> {
        let wanted = match self.book.rank(start)? {
            Rank::Finite(k) | Rank::AtLeast(k) => k,
            Rank::Unbounded => usize::MAX,
        };
        let mut best = (Trace::default(), PlayEnd::Failed);
        for play in 1..=self.setup.runs {
            let Run { turns, settled, .. } = self.play(start, play)?;
            let trace = Trace { play, turns };
            let end = match trace.improvements() >= wanted {
                true => PlayEnd::Kept,
                false if settled => PlayEnd::Failed,
                false => PlayEnd::CutOff,
            };
            let merit = |t: &Trace| (!t.weakens(), t.improvements());
            if play == 1 || merit(&trace) > merit(&best.0) {
                best = (trace, end);
            }
            // For an unbounded rank, a run that is cut off is sufficient.
            let told = best.1 == PlayEnd::Kept || (wanted == usize::MAX && best.1 == PlayEnd::CutOff);
            if told && !best.0.weakens() {
                break;
            }
        }
        Ok(best)
    }

    /// Simulates one run.
    fn play(&mut self, start: &[i64], number: u64) -> Result<Run> {
        let draw = &mut Draw::numbered(self.setup.seed, number);
        let first = self.book.most_preferred(start)?;
        let (mut state, mut memory) = (start.to_vec(), self.book.start(start)?);
        let mut turns = Vec::new();
        for _ in 0..self.setup.steps {
            let at = self.explained(&state, memory)?;
            let Some((turn, next)) = self.turn(&at, &first, draw) else {
                return Ok(Run { turns, last: memory, settled: true });
            };
            (state, memory) = (turn.state.clone(), next);
            turns.push(turn);
        }
        let settled = self.book.game(memory).is_none();
        Ok(Run { turns, last: memory, settled })
    }

    /// Simulates one step; `None` if the strategy has no action.
    fn turn(&self, at: &Explanation, first: &ObjectiveSet, draw: &mut Draw) -> Option<(Turn, Memory)> {
        let played: Vec<usize> =
            (0..at.actions.len()).filter(|&a| self.setup.scheduler.plays(at, a)).collect();
        let action = &at.actions[*played.get(draw.below(played.len()))?];
        let drawn = draw.unit();
        let mut sum = 0.0;
        let reached = action.successors.iter().find(|s| {
            sum += s.probability;
            drawn < sum
        });
        // The sum may be slightly below 1 because of rounding.
        let to = reached.or(action.successors.last())?;
        let weakens = |from| self.book.preferences.change(from, &to.most_preferred) == Change::Weakening;
        let turn = Turn {
            action: action.name.clone(),
            state: to.state.clone(),
            probability: to.probability,
            most_preferred: to.most_preferred.clone(),
            rank: to.rank,
            improves: to.improves,
            gained: to.gained.clone(),
            change: to.change,
            lost: lost(&self.book.preferences, &at.most_preferred, &to.most_preferred),
            weakens_step: weakens(&at.most_preferred),
            weakens_start: weakens(first),
            cost: self.book.rule.as_ref().map_or(0.0, |rule| rule.cost(at.memory, &at.state)),
        };
        Some((turn, to.next))
    }

    fn explained(&mut self, state: &[i64], memory: Memory) -> Result<Rc<Explanation>> {
        let key = (state.to_vec(), memory);
        if let Some(found) = self.seen.get(&key) {
            if let Some(limit) = self.book.engine.settings().sink.stop() {
                return Err(limit.into());
            }
            return Ok(Rc::clone(found));
        }
        let found = Rc::new(self.book.explain(state, memory)?);
        if self.seen.len() >= REMEMBERED {
            self.seen.clear();
        }
        self.seen.insert(key, Rc::clone(&found));
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wait_has_its_extremes_and_its_average() {
        let mut wait = Wait { plays: 0, least: u64::MAX, most: 0, total: 0 };
        [4, 2, 9].into_iter().for_each(|steps| wait.add(steps));
        assert_eq!(wait, Wait { plays: 3, least: 2, most: 9, total: 15 });
        assert_eq!(wait.mean(), 5.0);
    }

    fn trace(play: u64, weakens_step: bool, weakens_start: bool) -> Trace {
        let turn = Turn {
            action: String::new(),
            state: Vec::new(),
            probability: 1.0,
            most_preferred: ObjectiveSet::new(),
            rank: Rank::Finite(0),
            improves: false,
            gained: ObjectiveSet::new(),
            change: Change::Lateral,
            lost: ObjectiveSet::new(),
            weakens_step,
            weakens_start,
            cost: 0.0,
        };
        Trace { play, turns: vec![turn] }
    }

    #[test]
    fn a_tally_shows_the_first_play_that_weakens() {
        let mut tally = Tally::new(&[], Rank::Finite(0));
        tally.add(trace(1, false, false), true);
        assert_eq!(tally.trace.play, 1);
        tally.add(trace(2, true, false), false);
        tally.add(trace(3, false, true), false);
        let mut last = trace(4, true, true);
        last.turns[0].change = Change::Weakening;
        tally.add(last, true);
        assert_eq!(tally.trace.play, 2);
        assert_eq!((tally.plays, tally.settled, tally.given_up), (4, 2, 2));
        assert_eq!((tally.weakened_step, tally.weakened_start, tally.weakened_reference), (2, 2, 1));
    }
}
