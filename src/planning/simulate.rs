//! Random plays under a strategy: how often they improve, how soon, and whether they weaken.

use std::collections::BTreeMap;
use std::rc::Rc;

use ahash::AHashMap;

use super::explain::{Explanation, lost};
use super::finite_memory::{FiniteMemoryStrategy, Memory};
use super::induced_model::Scheduler;
use super::levels::Rank;
use crate::engine::Engine;
use crate::error::Result;
use crate::model::State;
use crate::model::preference::{Change, ObjectiveSet};
use crate::random::Draw;

/// How many explained states are kept for plays that come by again.
const REMEMBERED: usize = 1 << 16;

/// Which plays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Setup {
    /// Under which strategy.
    pub scheduler: Scheduler,
    /// How many.
    pub runs: u64,
    /// A play is given up after so many steps.
    pub steps: u64,
    /// The same seed gives the same plays, with any engine and on any machine.
    pub seed: u64,
}

/// What came of the plays from one state.
#[derive(Debug, Clone, PartialEq)]
pub struct Tally {
    /// Where they started.
    pub start: State,
    /// rank(s), and with it what the strategy promises.
    pub rank: Rank,
    /// How many plays there were.
    pub plays: u64,
    /// How many plays improved how often.
    pub improvements: BTreeMap<usize, u64>,
    /// For the first, the second, … improvement the steps that it took, counted from the start.
    pub waits: Vec<Wait>,
    /// Plays that ended where no improvement is left.
    pub settled: u64,
    /// Plays that were given up.
    pub given_up: u64,
    /// Those among them that had not yet improved as often as the rank says.
    pub undecided: u64,
    /// Plays with a step that weakens the state before it.
    pub weakened_step: u64,
    /// Plays with a step that weakens what the strategy measures against: under `prefix` the state
    /// where planning started or the last improvement after it, else the state before.
    pub weakened_reference: u64,
    /// Plays with a state that weakens the state they started in.
    pub weakened_start: u64,
    /// The first play that weakened, or else the first play.
    pub trace: Trace,
}

/// How many steps something took.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Wait {
    /// In how many plays it came.
    pub plays: u64,
    /// The fewest steps.
    pub least: u64,
    /// The most steps.
    pub most: u64,
    /// The steps of all these plays together.
    pub total: u64,
}

impl Wait {
    fn add(&mut self, steps: u64) {
        self.plays += 1;
        self.least = self.least.min(steps);
        self.most = self.most.max(steps);
        self.total += steps;
    }

    /// The average.
    pub fn mean(&self) -> f64 {
        self.total as f64 / self.plays as f64
    }
}

/// A play in full.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trace {
    /// Which play, from 1.
    pub play: u64,
    /// Its steps.
    pub turns: Vec<Turn>,
}

impl Trace {
    /// How often the play improved.
    pub fn improvements(&self) -> usize {
        self.turns.iter().filter(|turn| turn.improves).count()
    }

    fn weakens(&self) -> bool {
        self.turns.iter().any(|turn| turn.weakens_step || turn.weakens_start)
    }
}

/// How a play ended, against what the rank of its start promises.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlayEnd {
    /// It improved as often as that.
    Kept,
    /// It was given up before.
    CutOff,
    /// It ended before.
    Failed,
}

/// A step of a play.
#[derive(Debug, Clone, PartialEq)]
pub struct Turn {
    /// The action taken.
    pub action: String,
    /// The state entered.
    pub state: State,
    /// How likely that was under the action.
    pub probability: f64,
    /// MP of the state entered.
    pub most_preferred: ObjectiveSet,
    /// The rank of the state entered.
    pub rank: Rank,
    /// Whether the step was an improvement.
    pub improves: bool,
    /// What was gained against the reference.
    pub gained: ObjectiveSet,
    /// What the step is, measured against the reference. An improving step that is no improvement
    /// of the play is one after which the others that were promised could not follow.
    pub change: Change,
    /// What was lost against the state before.
    pub lost: ObjectiveSet,
    /// Whether it weakens the state before.
    pub weakens_step: bool,
    /// Whether it weakens the state that the play started in.
    pub weakens_start: bool,
}

impl Tally {
    fn new(start: &[i64], rank: Rank) -> Self {
        Tally {
            start: start.to_vec(),
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
            trace: Trace::default(),
        }
    }

    /// How many plays improved less often than `times`.
    pub fn fewer_than(&self, times: usize) -> u64 {
        self.improvements.range(..times).map(|(_, plays)| plays).sum()
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

/// Plays under the a finite-memory strategy.
pub struct Simulation<'b, 'a, E: Engine> {
    book: &'b mut FiniteMemoryStrategy<'a, E>,
    setup: Setup,
    seen: AHashMap<(State, Memory), Rc<Explanation>>,
}

impl<'b, 'a, E: Engine> Simulation<'b, 'a, E> {
    /// A simulation without plays yet.
    pub fn new(book: &'b mut FiniteMemoryStrategy<'a, E>, setup: Setup) -> Self {
        Simulation { book, setup, seen: AHashMap::new() }
    }

    /// All plays from one state of the scope.
    ///
    /// # Errors
    /// As [`FiniteMemoryStrategy::explain`]. Cost: that for each state and memory visited.
    pub fn run(&mut self, start: &[i64]) -> Result<Tally> {
        self.run_each(start, &mut |_| ())
    }

    /// As [`Simulation::run`]; `each` sees every play in full.
    ///
    /// # Errors
    /// Those of [`Simulation::run`].
    pub fn run_each(&mut self, start: &[i64], each: &mut dyn FnMut(&Trace)) -> Result<Tally> {
        let mut tally = Tally::new(start, self.book.rank(start));
        for play in 1..=self.setup.runs {
            let (turns, settled) = self.play(start, &mut Draw::numbered(self.setup.seed, play))?;
            let trace = Trace { play, turns };
            each(&trace);
            tally.add(trace, settled);
        }
        Ok(tally)
    }

    /// The first of all plays from one state that weakens nothing and improves as often as the rank of the
    /// state says; else the one that comes closest to that.
    ///
    /// # Errors
    /// Those of [`Simulation::run`].
    pub fn telling(&mut self, start: &[i64]) -> Result<(Trace, PlayEnd)> {
        let wanted = match self.book.rank(start) {
            Rank::Finite(k) | Rank::AtLeast(k) => k,
            Rank::Unbounded => usize::MAX,
        };
        let mut best = (Trace::default(), PlayEnd::Failed);
        for play in 1..=self.setup.runs {
            let (turns, settled) = self.play(start, &mut Draw::numbered(self.setup.seed, play))?;
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
            // What has no end is told by its beginning.
            let told = best.1 == PlayEnd::Kept || (wanted == usize::MAX && best.1 == PlayEnd::CutOff);
            if told && !best.0.weakens() {
                break;
            }
        }
        Ok(best)
    }

    /// One play, and whether it ended where nothing is left to improve.
    fn play(&mut self, start: &[i64], draw: &mut Draw) -> Result<(Vec<Turn>, bool)> {
        let first = self.book.most_preferred(start);
        let (mut state, mut memory) = (start.to_vec(), self.book.start(start));
        let mut turns = Vec::new();
        for _ in 0..self.setup.steps {
            let at = self.explained(&state, memory)?;
            let Some((turn, next)) = self.turn(&at, &first, draw) else { return Ok((turns, true)) };
            (state, memory) = (turn.state.clone(), next);
            turns.push(turn);
        }
        let settled = self.book.game(memory).is_none();
        Ok((turns, settled))
    }

    /// One step; none where the strategy has no action.
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
        // Rounding may leave the sum a little below 1.
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
