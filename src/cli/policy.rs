//! Plans for one target, as planners ask for them: `--strong` and `--policy`.

use std::path::{Path, PathBuf};

use clap::Args;
use meliora_base::error::Error;
use meliora_question::WantedStrategies;

use meliora::commands::induced_files::ChainFormat;

use super::by_name::by_name;
use super::files::Target;

/// The options about plans.
#[derive(Debug, Clone, Default, Args)]
pub(super) struct PlanArgs {
    /// Compute, too, from which states a strong plan exists: every path reaches the target within a bound
    #[arg(long)]
    pub(super) strong: bool,

    /// Write the strategy that attains the answer to one property: the states that it visits, with its memory, and
    /// the actions, as JSON, or by the name of FILE as .csv or .dot; `-` is standard output. For a target, and for `Pmax>=1 [ F … ]`: a policy that
    /// reaches it almost surely, for each state the facts and the action, as planners do, or JSON if FILE ends
    /// with .json
    #[arg(long, value_name = "FILE")]
    pub(super) policy: Option<PathBuf>,

    /// Write the strategy of the opponent, of one property of a game, in the same form
    #[arg(long, value_name = "FILE")]
    pub(super) opponent_policy: Option<PathBuf>,

    /// Write the Markov chain that the strategy leaves to this directory (in a game: the mdp of the opponent)
    #[arg(long, value_name = "DIR")]
    pub(super) induced: Option<PathBuf>,

    /// Format of --induced
    #[arg(long, value_name = "FORMAT", requires = "induced", default_value = ChainFormat::default().name(), value_parser = by_name::<ChainFormat>())]
    pub(super) format: ChainFormat,
}

/// The places of the strategies that are asked for.
pub(super) struct PolicyTargets {
    pub(super) own: Option<Target>,
    pub(super) opponent: Option<Target>,
}

impl PlanArgs {
    /// Returns whether plans are asked for.
    pub(super) fn is_given(&self) -> bool {
        self.strong || self.policy.is_some() || self.opponent_policy.is_some() || self.induced.is_some()
    }

    /// Checks that the question has plans: one target, without requirements and players.
    ///
    /// # Errors
    /// [`Error::Usage`]; the file of the policy cannot be written.
    pub(super) fn checked(&self, is_one: bool, inputs: &[&Path]) -> Result<PolicyTargets, Error> {
        if self.is_given() && !is_one {
            let message = "`--strong` and `--policy` need one `--target` or one property, without `--require`, \
                           `--out`, `--stop-at-target` and sweeps";
            return Err(Error::Usage(message.to_owned()));
        }
        let own = Target::maybe(self.policy.as_deref(), inputs)?;
        Ok(PolicyTargets { own, opponent: Target::maybe(self.opponent_policy.as_deref(), inputs)? })
    }

    /// Returns the strategies that are asked for.
    pub(super) fn wanted(&self) -> WantedStrategies {
        WantedStrategies {
            strong: self.strong,
            policy: self.policy.is_some() || self.induced.is_some(),
            opponent: self.opponent_policy.is_some(),
        }
    }
}
