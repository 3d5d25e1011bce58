//! The statistics of simulated runs.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use super::estimate::Sample;
use crate::analysis::levels::Rank;
use meliora_model::State;
use meliora_model::players::Owner;
use meliora_model::preference::{Change, ObjectiveSet};

/// The statistics of the runs from one state.
#[derive(Debug, Clone, PartialEq)]
pub struct Tally {
    /// The state in which the runs start.
    pub start: State,
    /// MP of this state.
    pub first: ObjectiveSet,
    /// True if no strategy keeps the requirements from it; the runs then have no step.
    pub is_unsafe: bool,
    /// rank(s), the number of improvements that the strategy guarantees (SASI) or makes possible
    /// (SPI).
    pub rank: Rank,
    /// The number of runs.
    pub runs: u64,
    /// The number of runs by number of improvements.
    pub improvements: BTreeMap<usize, u64>,
    /// For each improvement (first, second, …), its number of steps since the start.
    pub waits: Vec<Wait>,
    /// The number of steps of all runs that each player of a game chose, by its position.
    pub steps_of: BTreeMap<usize, u64>,
    /// The number of runs that ended in a state where no improvement is left.
    pub settled: u64,
    /// The number of runs that were given up.
    pub given_up: u64,
    /// The number of given-up runs that had made fewer improvements than the rank.
    pub undecided: u64,
    /// The number of runs with a step that weakens the state before it. Steps after a commitment are
    /// not counted as weakening, here and below.
    pub weakened_step: u64,
    /// The number of runs with a step that weakens the strategy's reference. Under `prefix` this is
    /// the state where planning started or the last improvement after it, else the state before the
    /// step.
    pub weakened_reference: u64,
    /// The number of runs with a state that weakens the start state.
    pub weakened_start: u64,
    /// The number of runs with a state that improves on the start state.
    pub better_than_start: u64,
    /// The number of runs that gain each objective over the start state.
    pub gained: BTreeMap<usize, u64>,
    /// The number of runs that entered an unsafe state. It is 0: a strategy has no choice that may
    /// lead there.
    pub entered_unsafe: u64,
    /// The objectives that the runs achieved, if the strategy achieves objectives.
    pub achieved: Option<Achievements>,
    /// The number of runs with each commitment.
    pub commitments: BTreeMap<Commitment, u64>,
    /// The runs as a sample of the value that a decision rule attains, if there is a rule.
    pub sample: Option<Sample>,
    /// The first run that weakened, or the first run if none did.
    pub trace: Trace,
}

/// The objectives that runs achieved.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Achievements {
    /// True if the runs pursue several objectives together.
    pub together: bool,
    /// For each objective that some run achieved, the number of steps until then.
    pub waits: BTreeMap<usize, Wait>,
    /// The number of runs that ended because they had achieved the objective that they pursued.
    pub runs: u64,
    /// The number of other runs that ended, or were given up, while they kept the objective that they
    /// pursued: no step achieves it, but the steps that follow can satisfy it almost surely without a
    /// further condition.
    pub kept: u64,
}

/// A commitment of a run: the objective that it then pursues, and the objectives that its steps lost
/// afterwards.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Commitment {
    /// The objective.
    pub objective: usize,
    /// The other objectives, each of which was a most preferred one before it was lost.
    pub gives_up: ObjectiveSet,
}

impl Achievements {
    /// Adds a run, with the objectives achieved in its start state.
    fn add(&mut self, trace: &Trace, end: Ending) {
        let later =
            (1..).zip(&trace.turns).flat_map(|(step, turn)| turn.achieved.iter().map(move |o| (step, o)));
        for (step, objective) in trace.achieved.iter().map(|objective| (0, objective)).chain(later) {
            self.waits.entry(objective).or_default().add(step);
        }
        self.runs += u64::from(end == Ending::Achieved);
        self.kept += u64::from(end == Ending::Kept);
    }
}

/// The number of steps until an event of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(into = "Waited")]
#[schemars(with = "Waited")]
pub struct Wait {
    /// The number of runs with this event.
    pub runs: u64,
    /// The smallest number of steps.
    pub least: u64,
    /// The largest number of steps.
    pub most: u64,
    /// The sum of the steps over these runs.
    pub total: u64,
}

impl Default for Wait {
    fn default() -> Self {
        Wait { runs: 0, least: u64::MAX, most: 0, total: 0 }
    }
}

impl Wait {
    fn add(&mut self, steps: u64) {
        self.runs += 1;
        self.least = self.least.min(steps);
        self.most = self.most.max(steps);
        self.total += steps;
    }

    /// Returns the mean number of steps.
    pub fn mean(&self) -> f64 {
        self.total as f64 / self.runs as f64
    }
}

/// The number of steps until an event in JSON.
#[derive(Serialize, JsonSchema)]
struct Waited {
    /// The number of paths with this event.
    plays: u64,
    /// The fewest steps.
    least: u64,
    /// The mean number of steps over these paths.
    mean: f64,
    /// The most steps.
    most: u64,
}

impl From<Wait> for Waited {
    fn from(wait: Wait) -> Self {
        Waited { plays: wait.runs, least: wait.least, mean: wait.mean(), most: wait.most }
    }
}

/// A complete run.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trace {
    /// The number of the run, from 1.
    pub run: u64,
    /// The objectives that are achieved in its start state.
    pub achieved: ObjectiveSet,
    /// The steps.
    pub turns: Vec<Turn>,
}

impl Trace {
    /// Returns the number of improvements.
    pub fn improvements(&self) -> usize {
        self.turns.iter().filter(|turn| turn.improves).count()
    }

    /// Returns the cost until the k-th improvement; `None` if there are fewer.
    pub(crate) fn cost_until(&self, k: usize) -> Option<f64> {
        let (mut left, mut cost) = (k, 0.0);
        let mut turns = self.turns.iter();
        while left > 0 {
            let turn = turns.next()?;
            cost += turn.cost;
            left -= usize::from(turn.improves);
        }
        Some(cost)
    }

    /// Returns the objectives that some state of the run gains over its start.
    fn gained_over_start(&self) -> ObjectiveSet {
        let mut gained = ObjectiveSet::new();
        for turn in &self.turns {
            gained.extend_with(&turn.gained_over_start);
        }
        gained
    }

    /// Returns the commitments of the run, in their order.
    pub fn commitments(&self) -> Vec<Commitment> {
        let mut all: Vec<Commitment> = Vec::new();
        for turn in &self.turns {
            if let Some(objective) = turn.commits {
                all.push(Commitment { objective, gives_up: ObjectiveSet::new() });
            }
            if let Some(last) = all.last_mut() {
                last.gives_up.extend_with(&turn.gives_up);
            }
        }
        all
    }

    pub(crate) fn weakens(&self) -> bool {
        self.turns.iter().any(|turn| turn.weakens_step || turn.weakens_start)
    }
}

/// The state of a run's pursuit at its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ending {
    /// It was achieved.
    Achieved,
    /// It was kept.
    Kept,
    /// Neither, or none was pursued.
    Open,
}

/// The end of a run, compared with the rank of its start state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RunEnd {
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
    /// The player who chose the action; `None` if the model is not a game, and in deadlocks.
    pub owner: Option<Owner>,
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
    /// True if the state entered is unsafe.
    pub is_unsafe: bool,
    /// True if the step weakens the state before, and the run has not committed.
    pub weakens_step: bool,
    /// True if the step weakens the start state of the run, and the run has not committed.
    pub weakens_start: bool,
    /// The objectives gained, compared with the start state; empty if the state entered does not improve on
    /// it.
    pub gained_over_start: ObjectiveSet,
    /// True if the run has committed to an objective, with this step or earlier.
    pub committed: bool,
    /// The objective to which the run commits before this step.
    pub commits: Option<usize>,
    /// The objectives that the step gives up, for the first time since the commitment.
    pub gives_up: ObjectiveSet,
    /// The objectives that are achieved for the first time in the state entered.
    pub achieved: ObjectiveSet,
    /// The cost of the step under a decision rule; 0 without one.
    pub cost: f64,
}

impl Tally {
    pub(crate) fn new(start: &[i64], rank: Rank) -> Self {
        Tally {
            start: start.to_vec(),
            first: ObjectiveSet::new(),
            is_unsafe: false,
            rank,
            runs: 0,
            improvements: BTreeMap::new(),
            waits: Vec::new(),
            steps_of: BTreeMap::new(),
            settled: 0,
            given_up: 0,
            undecided: 0,
            weakened_step: 0,
            weakened_reference: 0,
            weakened_start: 0,
            better_than_start: 0,
            gained: BTreeMap::new(),
            entered_unsafe: 0,
            achieved: None,
            commitments: BTreeMap::new(),
            sample: None,
            trace: Trace::default(),
        }
    }

    /// Returns whether the runs have no step and achieve nothing: the strategy does nothing in their start.
    pub fn is_idle(&self) -> bool {
        let nothing = self.achieved.as_ref().is_some_and(|achieved| achieved.runs + achieved.kept == 0);
        nothing && self.trace.turns.is_empty()
    }

    /// Returns the number of runs with fewer than `times` improvements.
    pub fn fewer_than(&self, times: usize) -> u64 {
        self.improvements.range(..times).map(|(_, runs)| runs).sum()
    }

    /// Returns the number of runs with fewer improvements than the rank says; `None` if the rank is
    /// unbounded.
    pub fn fewer_than_rank(&self) -> Option<u64> {
        match self.rank {
            Rank::Finite(k) | Rank::AtLeast(k) => Some(self.fewer_than(k)),
            Rank::Unbounded => None,
        }
    }

    /// Adds a run: true if it ended before the limit, and the state of its pursuit.
    pub(crate) fn add(&mut self, trace: Trace, settled: bool, end: Ending) {
        self.runs += 1;
        if let Some(achieved) = &mut self.achieved {
            achieved.add(&trace, end);
        }
        for commitment in trace.commitments() {
            *self.commitments.entry(commitment).or_default() += 1;
        }
        for owner in trace.turns.iter().filter_map(|turn| turn.owner) {
            *self.steps_of.entry(owner.player).or_default() += 1;
        }
        let mut improved = 0;
        for (step, turn) in (1..).zip(&trace.turns) {
            if !turn.improves {
                continue;
            }
            if improved == self.waits.len() {
                self.waits.push(Wait::default());
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
        let reference = trace.turns.iter().any(|t| t.change == Change::Weakening && !t.committed);
        self.weakened_reference += u64::from(reference);
        self.weakened_start += u64::from(start);
        let gained = trace.gained_over_start();
        self.better_than_start += u64::from(!gained.is_empty());
        for objective in gained.iter() {
            *self.gained.entry(objective).or_default() += 1;
        }
        self.entered_unsafe += u64::from(trace.turns.iter().any(|t| t.is_unsafe));
        if first_to_weaken || self.runs == 1 {
            self.trace = trace;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wait_has_its_extremes_and_its_average() {
        let mut wait = Wait::default();
        [4, 2, 9].into_iter().for_each(|steps| wait.add(steps));
        assert_eq!(wait, Wait { runs: 3, least: 2, most: 9, total: 15 });
        assert_eq!(wait.mean(), 5.0);
    }

    fn trace(run: u64, weakens_step: bool, weakens_start: bool) -> Trace {
        let turn = Turn {
            owner: None,
            action: String::new(),
            state: Vec::new(),
            probability: 1.0,
            most_preferred: ObjectiveSet::new(),
            rank: Rank::Finite(0),
            improves: false,
            gained: ObjectiveSet::new(),
            change: Change::Lateral,
            lost: ObjectiveSet::new(),
            is_unsafe: false,
            weakens_step,
            weakens_start,
            gained_over_start: ObjectiveSet::new(),
            committed: false,
            commits: None,
            gives_up: ObjectiveSet::new(),
            achieved: ObjectiveSet::new(),
            cost: 0.0,
        };
        Trace { run, achieved: ObjectiveSet::new(), turns: vec![turn] }
    }

    #[test]
    fn a_tally_shows_the_first_run_that_weakens() {
        let mut tally = Tally::new(&[], Rank::Finite(0));
        tally.add(trace(1, false, false), true, Ending::Open);
        assert_eq!(tally.trace.run, 1);
        tally.add(trace(2, true, false), false, Ending::Open);
        tally.add(trace(3, false, true), false, Ending::Open);
        let mut last = trace(4, true, true);
        last.turns[0].change = Change::Weakening;
        last.turns[0].is_unsafe = true;
        tally.add(last, true, Ending::Open);
        assert_eq!(tally.trace.run, 2);
        assert_eq!((tally.runs, tally.settled, tally.given_up), (4, 2, 2));
        assert_eq!((tally.weakened_step, tally.weakened_start, tally.weakened_reference), (2, 2, 1));
        assert_eq!(tally.entered_unsafe, 1);
    }
}
