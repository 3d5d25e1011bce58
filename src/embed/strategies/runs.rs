//! Random runs of a strategy, as a report.

use std::sync::Arc;

use crate::embed::{Task, Work};
use meliora_base::error::{Error, Result};
use meliora_engine::Engine;
use meliora_model::{Program, State};
use meliora_planning::tally::Trace;
use meliora_planning::{Analysis, FiniteMemoryStrategy, Kind, Opponent, Rank, Setup, Simulation, improvable};
use meliora_quantities::ValuedRule;
use meliora_report::SimulateReport;
use meliora_report::simulate::RunsReport;
use meliora_report::simulate_csv::RunStart;

/// The runs that are asked for.
pub struct Runs<'a, E: Engine> {
    /// The model and the preferences.
    pub task: &'a Task,
    /// The analysis, with the levels of the strategy.
    pub analysis: &'a Analysis<E>,
    /// The decision rule of the strategy, if it depends on values.
    pub chooser: Option<Arc<dyn ValuedRule>>,
    /// The number of runs, their length and their seed.
    pub setup: Setup,
    /// The choices of the opponent of a game.
    pub opponent: Opponent,
    /// True if the report tells whether improvements are possible where none is guaranteed.
    pub advises: bool,
}

impl<E: Engine> Runs<'_, E> {
    /// Simulates the runs from some states, and adds the findings of each to the report. `each` gets the runs one by one,
    /// and may end the work after those from a state. Cost: one step of the model per step.
    ///
    /// # Errors
    /// A command has no meaning in some state; a limit is reached; the errors of `each`.
    pub fn run(
        &self,
        work: &dyn Work<SimulateReport>,
        strategy: &mut FiniteMemoryStrategy<E>,
        starts: &[State],
        each: &mut dyn FnMut(&RunStart<'_>, &Trace) -> Result<()>,
    ) -> Result<()> {
        let Runs { task, analysis, setup, opponent, .. } = self;
        let (kind, levels) = (strategy.kind(), strategy.levels());
        let mut simulation = Simulation::new(strategy, *setup).against(*opponent);
        // The set of the states from which an improvement is possible, once it is needed.
        let mut known = None;
        for (number, start) in (1..).zip(starts) {
            let (most_preferred, rank) = (analysis.most_preferred(start)?, analysis.rank(levels, start)?);
            let from = RunStart { number, state: start, most_preferred, rank };
            // A simulation does not stop at an error of the listener.
            let mut wrong = Ok(());
            let tally = simulation.run_each(start, &mut |trace| {
                if wrong.is_ok() {
                    wrong = each(&from, trace);
                }
            })?;
            wrong?;
            let is_hopeless = self.advises
                && levels == Kind::Sasi
                && tally.rank == Rank::Finite(0)
                && !self.is_improvable(&mut known, start)?;
            let report = RunsReport::new(&task.program, &task.preferences, kind, tally)
                .compared(self.chooser.as_ref().and_then(|rule| rule.attained(start)))
                .hopeless(is_hopeless);
            work.update(|r| r.starts.push(report));
        }
        Ok(())
    }

    fn is_improvable(&self, known: &mut Option<E::States>, state: &State) -> Result<bool> {
        if known.is_none() {
            *known = improvable(self.analysis)?;
        }
        known.as_ref().map_or(Ok(false), |states| self.analysis.engine().contains(states, state))
    }
}

/// Returns the choices of the opponent; `None` if the model is not a game.
///
/// # Errors
/// Choices are given, and the model is not a game.
pub fn opponent(program: &Program, given: Option<Opponent>) -> Result<Option<Opponent>> {
    match (&program.players, given) {
        (Some(_), given) => Ok(Some(given.unwrap_or_default())),
        (None, None) => Ok(None),
        (None, Some(_)) => Err(Error::Usage("`--opponent`: only a game (`smg`) has an opponent".to_owned())),
    }
}
