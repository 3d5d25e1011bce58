//! Runs as numbers, for arrays.

use std::collections::BTreeMap;

use meliora_base::error::Result;
use meliora_planning::tally::{Tally, Trace};
use meliora_planning::{FiniteMemoryStrategy, Opponent, Setup, Simulation};

/// The record of simulated runs.
#[derive(Debug, Clone)]
pub struct Record {
    /// The values of the start state.
    pub start: Vec<i64>,
    /// The runs.
    pub runs: Vec<RecordedRun>,
    /// The names of the actions, by their numbers.
    pub actions: Vec<String>,
}

/// The steps of one run.
#[derive(Debug, Clone, Default)]
pub struct RecordedRun {
    /// The values of the states entered, one state after the other.
    pub states: Vec<i64>,
    /// The actions, by their numbers.
    pub actions: Vec<i64>,
    /// For each step, true if it is an improvement.
    pub improves: Vec<bool>,
    /// The objectives that the run achieves, each with the number of steps until then.
    pub achieved: BTreeMap<usize, i64>,
}

impl Record {
    /// Simulates runs from a state, and records them.
    ///
    /// # Errors
    /// A command has no meaning in some state; a limit is reached.
    pub fn simulate(
        strategy: &mut FiniteMemoryStrategy,
        (setup, opponent): (Setup, Opponent),
        start: &[i64],
    ) -> Result<(Tally, Record)> {
        let mut numbers: BTreeMap<String, i64> = BTreeMap::new();
        let (mut actions, mut runs) = (Vec::new(), Vec::new());
        let mut each = |trace: &Trace| {
            let mut run = RecordedRun::default();
            run.achieved.extend(trace.achieved.iter().map(|objective| (objective, 0)));
            for (step, turn) in (1..).zip(&trace.turns) {
                run.achieved.extend(turn.achieved.iter().map(|objective| (objective, step)));
                run.states.extend(&turn.state);
                run.improves.push(turn.improves);
                let number = numbers.entry(turn.action.clone()).or_insert_with(|| {
                    actions.push(turn.action.clone());
                    actions.len() as i64 - 1
                });
                run.actions.push(*number);
            }
            runs.push(run);
        };
        let tally = Simulation::new(strategy, setup).against(opponent).run_each(start, &mut each)?;
        Ok((tally, Record { start: start.to_vec(), runs, actions }))
    }

    /// Returns the number of steps of the longest run.
    pub fn longest(&self) -> usize {
        self.runs.iter().map(|run| run.actions.len()).max().unwrap_or(0)
    }

    /// Returns the states of all runs, one after the other, each with its start and as many states as the longest one: a
    /// run that has ended stays in its last state.
    pub fn states(&self) -> Vec<i64> {
        let (width, longest) = (self.start.len(), self.longest());
        let mut all = Vec::with_capacity(self.runs.len() * (longest + 1) * width);
        for run in &self.runs {
            all.extend(&self.start);
            all.extend(&run.states);
            for _ in run.actions.len()..longest {
                all.extend_from_within(all.len() - width..);
            }
        }
        all
    }

    /// Returns an entry per step of all runs, one run after the other; steps after the end of a run have `end`.
    pub fn steps<T: Copy>(&self, of: impl Fn(&RecordedRun) -> &[T], end: T) -> Vec<T> {
        let longest = self.longest();
        let padded = |run| of(run).iter().copied().chain(std::iter::repeat(end)).take(longest);
        self.runs.iter().flat_map(padded).collect()
    }
}
