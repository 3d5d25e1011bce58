//! Plans for one target, as planners ask for them: `--strong` and `--policy`.

use std::path::{Path, PathBuf};

use clap::Args;
use meliora_base::error::Error;
use meliora_base::progress::ProgressSink;
use meliora_certify::policy::rules::{Rules, Taken};
use meliora_model::Program;
use meliora_model::predicate::Predicate;
use meliora_planning::policy::{Policy, PolicyEntry};
use meliora_question::Target::States;
use meliora_question::{Goal, Wanted};
use meliora_report::{Number, ReachReport, policy};

use super::files::Target;
use super::supervise::Job;

/// The options about plans.
#[derive(Debug, Clone, Args)]
pub(super) struct PlanArgs {
    /// Compute, too, from which states a strong plan exists: every path reaches the target within a bound
    #[arg(long)]
    pub(super) strong: bool,

    /// Write a policy that reaches the target from the initial states almost surely: for each state that it
    /// visits the facts and the action, as planners do, or as JSON if FILE ends with .json; `-` is standard
    /// output. Of a property `multi(…)`: the strategies of which one is drawn at the start, as JSON
    #[arg(long, value_name = "FILE")]
    pub(super) policy: Option<PathBuf>,
}

impl PlanArgs {
    /// Returns whether plans are asked for.
    pub(super) fn is_given(&self) -> bool {
        self.strong || self.policy.is_some()
    }

    /// Checks that the question has plans: one target, without requirements and players.
    ///
    /// # Errors
    /// [`Error::Usage`]; the file of the policy cannot be written.
    pub(super) fn checked(&self, is_one: bool, inputs: &[&Path]) -> Result<Option<Target>, Error> {
        if self.is_given() && !is_one {
            let message = "`--strong` and `--policy` need one `--target`, or one property `Pmax>=1 [ F … ]`, \
                           without `--require`, `--out` and sweeps";
            return Err(Error::Usage(message.to_owned()));
        }
        Target::maybe(self.policy.as_deref(), inputs)
    }

    /// Returns whether the policy is written as JSON.
    pub(super) fn is_json(&self) -> bool {
        self.policy.as_ref().is_some_and(|path| path.extension().is_some_and(|e| e == "json"))
    }

    /// Returns the strategies that are asked for.
    pub(super) fn wanted(&self) -> Wanted {
        Wanted { strong: self.strong, policy: self.policy.is_some() }
    }

    /// Checks and writes a policy for a goal, or says that there is none.
    ///
    /// # Errors
    /// The policy is wrong; a limit; the file cannot be written.
    pub(super) fn finish(
        &self,
        job: &Job<ReachReport>,
        found: Option<Policy>,
        program: &Program,
        goal: &Goal,
        out: &Target,
    ) -> Result<(), Error> {
        let (Some(found), States(target)) = (found, &goal.target) else {
            job.sink.warn("no policy is written: no strong cyclic plan exists");
            return Ok(());
        };
        let check = || checked(found, program, target, &*job.sink);
        let found = job.timed("policy", check, |r, s| r.time.add("policy", s))?;
        let text = match self.is_json() {
            true => policy::json(&found, program)? + "\n",
            false => policy::text(&found, program)?,
        };
        out.write(&text)?;
        job.update(|r| {
            if let Some(one) = &mut r.one {
                let states = Number::from(found.entries.len() as u64);
                one.plan.get_or_insert_default().policy_states = Some(states);
            }
        });
        Ok(())
    }
}

/// Checks a policy state by state, from the initial states.
fn checked(
    found: Policy,
    program: &Program,
    goal: &Predicate,
    sink: &dyn ProgressSink,
) -> Result<Policy, Error> {
    let mut rules = Rules::default();
    for PolicyEntry { state, action, position, .. } in &found.entries {
        rules.add_state(state, Taken { action: action.clone(), position: *position });
    }
    match rules.check(program, goal, &found.initial, false, sink)? {
        Ok(_) => Ok(found),
        Err(fault) => Err(Error::Usage(format!("{}: {}", fault.kind, program.show_state(&fault.state)))),
    }
}
