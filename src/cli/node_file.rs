//! Files of policies with memory: `verify` and `simulate --policy` of what `strategy --policy` writes.

use std::sync::Arc;

use meliora_base::error::{Error, SourceFile};
use meliora_base::random::Draw;
use meliora_certify::policy::NodePolicy;
use meliora_model::State;
use meliora_report::PolicyReport;
use meliora_report::node_file;
use meliora_report::policy_report::PolicyRuns;
use meliora_report::promised::Promised;

use super::load::Question;
use super::supervise::Job;

/// A policy with memory, with its model.
pub(super) struct NodeFile {
    question: Question,
    policy: NodePolicy,
    initial: Vec<State>,
}

impl NodeFile {
    /// Reads a policy.
    ///
    /// # Errors
    /// The text is wrong, or about another model.
    pub(super) fn new(
        source: &Arc<SourceFile>,
        question: Question,
        initial: Vec<State>,
    ) -> Result<Self, Error> {
        let policy = node_file::read(source, &question.program, &question.preferences)?;
        Ok(NodeFile { question, policy, initial })
    }

    /// Checks the policy, or runs it.
    ///
    /// # Errors
    /// A limit; a command has no meaning in a state.
    pub(super) fn work(&self, job: &Job<PolicyReport>, runs: Option<&PolicyRuns>) -> Result<(), Error> {
        let Question { program, preferences, .. } = &self.question;
        job.update(|r| r.promise = Some(Promised::new(&self.policy, program, preferences)));
        if let Some(runs) = runs {
            return self.simulate(job, runs);
        }
        let found = self.policy.check(program, preferences, &self.initial, job.sink.as_ref())?;
        job.update(|r| match found {
            Ok(accepted) => {
                r.accepted = Some(Some(true));
                r.promise.iter_mut().for_each(|promise| promise.accept(&accepted));
            }
            Err(fault) => r.refuse(program, &fault.kind.to_string(), Some(&fault.state)),
        });
        Ok(())
    }

    fn simulate(&self, job: &Job<PolicyReport>, runs: &PolicyRuns) -> Result<(), Error> {
        let Question { program, preferences, .. } = &self.question;
        let starts = self.initial.iter().filter_map(|state| self.policy.start(state)).collect::<Vec<_>>();
        let (true, false) = (starts.len() == self.initial.len(), starts.is_empty()) else {
            return Err(Error::Usage(
                "the policy does not start in each initial state of the model".to_owned(),
            ));
        };
        for number in 0..runs.runs {
            job.sink.check()?;
            let mut draw = Draw::numbered(runs.seed, number);
            let start = if starts.len() == 1 { starts[0] } else { starts[draw.below(starts.len())] };
            match self.policy.run(program, preferences, start, runs.limit, &mut draw)? {
                Ok(run) => job.update(|r| r.add_run(program, run)),
                Err(fault) => {
                    job.update(|r| r.refuse(program, &fault.kind.to_string(), Some(&fault.state)));
                    return Ok(());
                }
            }
        }
        Ok(())
    }
}
