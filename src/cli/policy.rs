//! Plans for one target, as planners ask for them: `--strong` and `--policy`.

use std::path::{Path, PathBuf};

use clap::Args;
use meliora_base::error::Error;
use meliora_question::WantedStrategies;

use super::files::Target;

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
    pub(super) fn wanted(&self) -> WantedStrategies {
        WantedStrategies { strong: self.strong, policy: self.policy.is_some() }
    }
}
