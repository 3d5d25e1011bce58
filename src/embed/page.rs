//! The run that a page shows.

use std::slice;
use std::sync::Arc;

use super::results::strategy_of;
use super::strategies::opponent;
use meliora_base::error::{Error, Result};
use meliora_engine::Engine;
use meliora_model::{Program, State};
use meliora_planning::{Analysis, Kind, Opponent, Rank, Scheduler, Setup, Simulation, StrategyKind};
use meliora_quantities::all_states::MOST_STATES;
use meliora_quantities::outlook::Outlook;
use meliora_quantities::{Achiever, Choose};
use meliora_report::page::ShownRun;
use meliora_report::simulate::TraceReport;

/// Maximum number of steps of the run.
const STEPS: u64 = 500;
/// Number of runs tried until one makes all guaranteed or possible improvements.
const RUNS: u64 = 100;

/// The run that is asked for.
#[derive(Debug, Clone)]
pub struct PageRun {
    /// The kind of its strategy; `None` for a plan.
    pub kind: Option<StrategyKind>,
    /// The objective that it achieves or pursues.
    pub objective: Option<String>,
    /// The permitted actions that it takes.
    pub scheduler: Scheduler,
    /// Its action among the permitted ones; `None` for one by value, where values are known.
    pub choose: Option<Choose>,
    /// The choices of the opponent of a game.
    pub opponent: Option<Opponent>,
    /// The seed of the random numbers.
    pub seed: u64,
}

impl Default for PageRun {
    /// The run of a plan, with the first seed.
    fn default() -> Self {
        let (kind, objective, choose, opponent) = Default::default();
        PageRun { kind, objective, scheduler: Scheduler::Progress, choose, opponent, seed: 1 }
    }
}

impl PageRun {
    /// Simulates the run from a state; `None` if the strategy does nothing there. Cost: that of at most 100 runs of at most
    /// 500 steps.
    ///
    /// # Errors
    /// The objective or the choices do not fit; a command has no meaning in a state; a limit is reached.
    pub fn shown<E: Engine>(
        &self,
        analysis: &Analysis<E>,
        program: &Arc<Program>,
        start: &State,
        outlook: Option<&Outlook>,
    ) -> Result<Option<ShownRun>> {
        let (kind, levels) = self.kinds(analysis, start)?;
        let by_value = self.choose.is_some_and(|choose| choose != Choose::First);
        if kind != StrategyKind::Achieve && !outlook.is_some_and(Outlook::has_values) && by_value {
            let message = format!(
                "`--choose` needs values, which a page has for complete levels of at most {MOST_STATES} states"
            );
            return Err(Error::Usage(message));
        }
        let objectives = kind.objectives(analysis.preferences(), self.objective.as_deref())?;
        let mut strategy = strategy_of(analysis, program, kind, levels, &objectives)?;
        let is_likely = kind == StrategyKind::Achieve && self.choose == Some(Choose::Likely);
        if is_likely {
            let (starts, objectives) = (slice::from_ref(start), strategy.objectives());
            let rule = Achiever::compute(analysis, program, starts, objectives)?;
            strategy.choose_by(Arc::new(rule));
        }
        let improves = strategy.rank(start)? != Rank::Finite(0) && kind != StrategyKind::Achieve;
        if !improves && strategy.pursued(strategy.start(start)?).is_empty() {
            return Ok(None);
        }
        let by_value = self.choose != Some(Choose::First) && self.scheduler == Scheduler::Progress;
        let choose = match outlook.filter(|_| by_value && improves) {
            Some(outlook) => outlook.attach(&mut strategy),
            None if is_likely => Choose::Likely,
            None => Choose::First,
        };
        let (scheduler, seed) = (self.scheduler, self.seed);
        let setup = Setup { scheduler, runs: RUNS, steps: STEPS, seed };
        let opponent = opponent(program, self.opponent)?;
        let mut simulation = Simulation::new(&mut strategy, setup).against(opponent.unwrap_or_default());
        let (told, end) = simulation.telling(start)?;
        let trace = TraceReport::new(program, analysis.preferences(), start, &told);
        let visited = told.turns.iter().map(|turn| turn.state.clone());
        let states = std::iter::once(start.clone()).chain(visited).collect();
        Ok(Some(ShownRun { kind, scheduler, choose, opponent, seed, tried: RUNS, trace, states, end }))
    }

    /// Returns the kind of strategy of the run, and of its improvements: the possible ones where none is
    /// guaranteed.
    fn kinds<E: Engine>(&self, analysis: &Analysis<E>, start: &State) -> Result<(StrategyKind, Kind)> {
        let engine = analysis.engine();
        let improves = |kind| Ok::<_, Error>(analysis.levels(kind).rank(engine, start)? != Rank::Finite(0));
        let kind = self.kind.unwrap_or(StrategyKind::Plan);
        let levels = match self.choose.filter(|choose| choose.kind().is_some()) {
            Some(choose) => choose.levels(kind),
            None if kind == StrategyKind::Plan && !improves(Kind::Sasi)? && improves(Kind::Spi)? => Kind::Spi,
            None => kind.levels(),
        };
        Ok((kind, levels))
    }
}
