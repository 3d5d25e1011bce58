//! Lists of rules.

use std::sync::Arc;

use crate::embed::Work;
use meliora_base::error::{Error, Result, SourceFile};
use meliora_base::progress::ProgressSink;
use meliora_base::random::Draw;
use meliora_certify::policy::rules::Rules as List;
use meliora_model::predicate::Predicate;
use meliora_model::{Program, State};
use meliora_question::strategies::MOST_STATES;
use meliora_report::policy_report::PolicyRuns;
use meliora_report::{PolicyReport, policy_file};
use meliora_space::initial::initial_states;

/// A list of rules, with its model and its goal.
pub(super) struct Rules {
    program: Program,
    goal: Predicate,
    /// Each path reaches the goal within a bound.
    is_strong: bool,
    rules: List,
    initial: Vec<State>,
}

impl Rules {
    /// Reads a list.
    ///
    /// # Errors
    /// The text is wrong, or about another model; the model has no initial state.
    pub(super) fn new(
        source: &Arc<SourceFile>,
        program: Program,
        (goal, is_strong): (Predicate, bool),
        sink: &dyn ProgressSink,
    ) -> Result<Self> {
        let initial = initial_states(&program, MOST_STATES, sink)?;
        if initial.is_empty() {
            return Err(Error::Usage("the model has no initial state to follow a policy from".to_owned()));
        }
        let rules = policy_file::read(source, &program)?;
        Ok(Rules { program, goal, is_strong, rules, initial })
    }

    /// Checks the rules.
    ///
    /// # Errors
    /// A limit.
    pub(super) fn check(&self, work: &dyn Work<PolicyReport>) -> Result<()> {
        let Rules { program, goal, rules, initial, .. } = self;
        let found = rules.check(program, goal, initial, self.is_strong, &*work.sink())?;
        work.update(|r| r.set(program, found));
        Ok(())
    }

    /// Runs the rules.
    ///
    /// # Errors
    /// A limit.
    pub(super) fn run(&self, work: &dyn Work<PolicyReport>, runs: &PolicyRuns) -> Result<()> {
        for number in 0..runs.runs {
            work.check()?;
            let mut draw = Draw::numbered(runs.seed, number);
            let start = match self.initial.as_slice() {
                [start] => start,
                several => &several[draw.below(several.len())],
            };
            let run = self.rules.run(&self.program, &self.goal, start, runs.limit, &mut draw);
            work.update(|r| r.add(&self.program, run));
        }
        Ok(())
    }
}
