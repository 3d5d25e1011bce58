//! Strategies as policies with memory, for other programs.

use meliora_base::error::{Error, Limit, Result};
use meliora_engine::Engine;
use meliora_model::{Program, State};
use meliora_planning::induced_model::Unfolding;
use meliora_planning::{Analysis, FiniteMemoryStrategy, Rank, Safety, Scheduler, StrategyKind};
use meliora_report::node_file::NodeWords;

/// A strategy that is written as a policy with memory.
#[derive(Debug, Clone, Copy)]
pub struct PolicyNodes<'a> {
    /// The model.
    pub program: &'a Program,
    /// The objective as its user names it, for a strategy that achieves one.
    pub objective: Option<&'a str>,
    /// The permitted actions that it takes.
    pub scheduler: Scheduler,
    /// True if paths may start in all states of the scope.
    pub all: bool,
    /// Maximum number of nodes.
    pub limit: usize,
}

/// The size of a policy.
#[derive(Debug, Clone, Copy)]
pub struct PolicySize {
    /// The number of nodes where paths may start.
    pub starts: usize,
    /// The number of nodes: states with memory.
    pub nodes: usize,
    /// True if it promises something in one of its starts.
    pub promises: bool,
}

impl PolicyNodes<'_> {
    /// Checks that strategies promise something in a safety mode.
    ///
    /// # Errors
    /// The actions of a strategy may weaken.
    pub fn check_safety(safety: Safety) -> Result<()> {
        if safety.drops_successors() {
            let message = "under `--safety transition`, actions of the strategy may weaken, so no policy is written: \
                           choose `prefix` or `action`";
            return Err(Error::Usage(message.to_owned()));
        }
        Ok(())
    }

    /// Writes the policy, piece by piece. Cost: that of [`FiniteMemoryStrategy::explain`] per node.
    ///
    /// # Errors
    /// See [`PolicyNodes::check_safety`]; the promise of the kind of the strategy is kept by no policy; there are more nodes than the limit; another limit; the
    /// errors of `push`.
    pub fn write<E: Engine>(
        &self,
        analysis: &Analysis<E>,
        strategy: &mut FiniteMemoryStrategy<E>,
        push: &mut dyn FnMut(&str) -> Result<()>,
    ) -> Result<PolicySize> {
        let (program, preferences) = (self.program, analysis.preferences());
        PolicyNodes::check_safety(analysis.options().safety)?;
        let starts = self.starts(analysis, program, strategy)?;
        let words = NodeWords { program, preferences };
        let safety = analysis.options().safety.name();
        push(&words.head(strategy.kind(), safety, strategy.objectives(), starts.len()))?;
        let (mut nodes, mut idle) = (0, 0);
        let mut unfolding = Unfolding::new(strategy, &starts, self.scheduler, self.limit)?;
        while let Some(node) = unfolding.next_node()? {
            if !unfolding.complete {
                return Err(Limit::Listed(self.limit as u64).into());
            }
            let is_idle = node.at.memory.level == Rank::Finite(0) && node.at.aims.is_empty();
            idle += usize::from(nodes < starts.len() && is_idle);
            push(&words.node(&node, nodes == 0))?;
            nodes += 1;
        }
        push(words.tail())?;
        Ok(PolicySize { starts: starts.len(), nodes, promises: idle < starts.len() })
    }

    /// Returns the states in which paths may start: the initial states, which must be among those from which the
    /// strategy does something sure, or all of these.
    ///
    /// # Errors
    /// The requirements cannot be kept from an initial state, or the objective is not sure there; a limit.
    fn starts<E: Engine>(
        &self,
        analysis: &Analysis<E>,
        program: &Program,
        strategy: &FiniteMemoryStrategy<E>,
    ) -> Result<Vec<State>> {
        let (whole, engine) = (analysis.whole_engine(), analysis.engine());
        let none = |state: &State, why: &str| {
            let state = program.show_state(state);
            Error::Usage(format!("no policy is written: {why} from the initial state {state}"))
        };
        let initial = whole.initial_states();
        if let Some(state) = whole.list_states(&whole.difference(&initial, &engine.all_states())?, 1)?.first()
        {
            return Err(none(state, "no strategy keeps the requirements"));
        }
        let starts = if self.all { engine.all_states() } else { initial.clone() };
        let starts = engine.list_states(&starts, self.limit)?;
        if strategy.kind() != StrategyKind::Achieve {
            return Ok(starts);
        }
        let mut sure = Vec::with_capacity(starts.len());
        for state in starts {
            if strategy.start(&state)?.pursuit.is_some() {
                sure.push(state);
            } else if whole.contains(&initial, &state)? {
                let aim = self.objective.unwrap_or_default();
                return Err(none(&state, &format!("`{aim}` is not sure")));
            }
        }
        Ok(sure)
    }
}
