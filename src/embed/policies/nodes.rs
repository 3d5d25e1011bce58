//! Policies with memory: what `strategy --policy` writes.

use std::sync::Arc;

use crate::embed::{Task, Work};
use meliora_base::error::{Error, Result, SourceFile};
use meliora_base::progress::ProgressSink;
use meliora_base::random::Draw;
use meliora_certify::policy::NodePolicy;
use meliora_model::State;
use meliora_question::strategies::MOST_STATES;
use meliora_report::PolicyReport;
use meliora_report::node_file;
use meliora_report::policy_report::PolicyRuns;
use meliora_report::promised::Promised;
use meliora_space::initial::initial_states;

/// A policy with memory, with its model.
pub(super) struct Nodes {
    task: Task,
    policy: NodePolicy,
    initial: Vec<State>,
}

impl Nodes {
    /// Reads a policy.
    ///
    /// # Errors
    /// The text is wrong, or about another model.
    pub(super) fn new(source: &Arc<SourceFile>, task: Task, sink: &dyn ProgressSink) -> Result<Self> {
        let initial = initial_states(&task.program, MOST_STATES, sink)?;
        let policy = node_file::read(source, &task.program, &task.preferences)?;
        Ok(Nodes { task, policy, initial })
    }

    /// Checks the policy.
    ///
    /// # Errors
    /// A limit; a command has no meaning in a state.
    pub(super) fn check(&self, work: &dyn Work<PolicyReport>) -> Result<()> {
        let Task { program, preferences, .. } = &self.task;
        self.promise(work);
        let found = self.policy.check(program, preferences, &self.initial, &*work.sink())?;
        work.update(|r| match found {
            Ok(accepted) => {
                r.accepted = Some(Some(true));
                r.promise.iter_mut().for_each(|promise| promise.accept(&accepted));
            }
            Err(fault) => r.refuse(program, &fault.kind.to_string(), Some(&fault.state)),
        });
        Ok(())
    }

    fn promise(&self, work: &dyn Work<PolicyReport>) {
        let Task { program, preferences, .. } = &self.task;
        work.update(|r| r.promise = Some(Promised::new(&self.policy, program, preferences)));
    }

    /// Runs the policy.
    ///
    /// # Errors
    /// It does not start in each initial state; a limit; a command has no meaning in a state.
    pub(super) fn run(&self, work: &dyn Work<PolicyReport>, runs: &PolicyRuns) -> Result<()> {
        let Task { program, preferences, .. } = &self.task;
        self.promise(work);
        let starts = self.initial.iter().filter_map(|state| self.policy.start(state)).collect::<Vec<_>>();
        let (true, false) = (starts.len() == self.initial.len(), starts.is_empty()) else {
            return Err(Error::Usage(
                "the policy does not start in each initial state of the model".to_owned(),
            ));
        };
        for number in 0..runs.runs {
            work.check()?;
            let mut draw = Draw::numbered(runs.seed, number);
            let start = if starts.len() == 1 { starts[0] } else { starts[draw.below(starts.len())] };
            match self.policy.run(program, preferences, start, runs.limit, &mut draw)? {
                Ok(run) => work.update(|r| r.add_run(program, run)),
                Err(fault) => {
                    work.update(|r| r.refuse(program, &fault.kind.to_string(), Some(&fault.state)));
                    return Ok(());
                }
            }
        }
        Ok(())
    }
}
