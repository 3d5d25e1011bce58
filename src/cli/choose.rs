//! `--kind` and `--choose`: what a strategy does, and the action that it takes among the permitted
//! ones.

use clap::Args;
use meliora::commands::strategies::StrategyOptions;
use meliora::{NamedStates, Task};
use meliora_base::error::{Error, Result};
use meliora_model::Program;
use meliora_planning::{Scheduler, StrategyKind};
use meliora_quantities::cost::Costs;
use meliora_quantities::{Choose, Steps};
use meliora_report::choose::Choosing;
use meliora_report::envelope::{Envelope, Findings, Times};

use super::by_name::by_name;
use super::plan::{self, Arguments};
use super::progress::TerminalSink;
use super::supervise::Job;

/// The options for the kind of a strategy, and for its choice among permitted actions.
#[derive(Debug, Clone, Args)]
pub(super) struct ChooseArgs {
    /// What the strategy does [default: plan for `simulate`, else sasi, or spi with `--choose likely`]
    #[arg(long, value_parser = by_name::<StrategyKind>())]
    kind: Option<StrategyKind>,

    /// Objective to achieve: needed with `--kind achieve`, where `C,D` achieves both in the same path;
    /// with `--kind plan` it is pursued where it is a most preferred one [default: the first of these]
    #[arg(long, value_name = "NAME")]
    objective: Option<String>,

    /// Action to take among the permitted ones
    #[arg(long, value_parser = by_name::<Choose>(), default_value = Choose::default().name())]
    pub(super) choose: Choose,

    /// Reward structure that is the cost of a step, for `--choose cheap` or `likely` [default:
    /// `steps`, each step costs 1]
    #[arg(long, value_name = "NAME")]
    reward: Option<String>,

    /// Greatest number of improvements that `--choose cheap` or `likely` aims at [default: the
    /// certain ones for `cheap`; the possible ones, at most 10, for `likely`]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..))]
    levels: Option<u32>,
}

/// The input of a command about strategies.
pub(super) struct Prepared {
    pub(super) task: Task,
    /// The strategy.
    pub(super) wanted: StrategyOptions,
    /// The states of `--at`.
    pub(super) at: NamedStates,
}

impl ChooseArgs {
    /// Adds the time for values, if the choice needs any.
    pub(super) fn count(&self, times: &mut Times, seconds: f64) {
        if self.choose != Choose::First {
            times.add("values", seconds);
        }
    }

    /// Returns the objective that is named.
    pub(super) fn objective(&self) -> Option<&str> {
        self.objective.as_deref()
    }

    /// Returns whether a list of rules may be the policy that is meant: no kind is given but `achieve`.
    pub(super) fn may_be_rules(&self) -> bool {
        self.kind.is_none_or(|kind| kind == StrategyKind::Achieve)
    }

    /// Returns the kind of a policy with memory: `achieve` if an objective is named.
    ///
    /// # Errors
    /// [`Error::Usage`]: the policy would choose by value.
    pub(super) fn kind_of_policy(&self) -> Result<StrategyKind> {
        if self.choose != Choose::First {
            let message = "`--policy` with `--choose` is not supported: a policy promises what is sure or possible, and no \
                           probability and no cost; `--csv` writes such a strategy as a table";
            return Err(Error::Usage(message.to_owned()));
        }
        let is_named = self.objective.is_some();
        Ok(self.kind.unwrap_or(if is_named { StrategyKind::Achieve } else { StrategyKind::Sasi }))
    }

    /// Refuses options that do not fit together.
    ///
    /// # Errors
    /// [`Error::Usage`] that names them.
    pub(super) fn validate(&self) -> Result<()> {
        let given = [("--reward", self.reward.is_some()), ("--levels", self.levels.is_some())];
        match given.into_iter().find(|(_, given)| *given && self.choose == Choose::First) {
            Some((name, _)) => {
                let message =
                    format!("`{name}` needs computed values: `--choose cheap` or `--choose likely`");
                Err(Error::Usage(message))
            }
            None => Ok(()),
        }
    }

    /// Returns the kind of the strategy: the one that is given, or one that fits the values.
    ///
    /// # Errors
    /// [`Error::Usage`] if the values are about another kind.
    pub(super) fn kind(&self, default: StrategyKind) -> Result<StrategyKind> {
        let kind = match self.kind {
            None if !self.choose.fits(default) => StrategyKind::Spi,
            kind => kind.unwrap_or(default),
        };
        if !self.choose.fits(kind) {
            return Err(Error::Usage(self.choose_with(kind)));
        }
        let given = [("--reward", self.reward.is_some()), ("--levels", self.levels.is_some())];
        match given.into_iter().find(|(_, given)| *given && kind == StrategyKind::Achieve) {
            Some((name, _)) => {
                let message = format!("`{name}` is about improvements; `--kind achieve` aims at none");
                Err(Error::Usage(message))
            }
            None => Ok(kind),
        }
    }

    /// Says which values fit a kind of strategy.
    fn choose_with(&self, kind: StrategyKind) -> String {
        let (choose, name) = (self.choose.name(), kind.name());
        let does = match self.choose {
            Choose::First => "takes the first action that makes progress",
            Choose::Likely => {
                "maximizes the probability of all possible improvements (SPI), or of an objective"
            }
            Choose::Cheap => "minimizes the cost until the last certain improvement (SASI)",
        };
        let advice = match kind {
            StrategyKind::Spi | StrategyKind::Achieve => "use `--choose likely`",
            StrategyKind::Sasi => "use `--choose cheap`",
            StrategyKind::Plan => "leave it out",
        };
        format!("`--choose {choose}` {does}; with `--kind {name}`, {advice}")
    }

    /// Does the same as [`plan::read`] for a strategy of a kind, with the states of `--at` and the
    /// cost of a step. `check` checks other options once the model is known.
    ///
    /// # Errors
    /// The input or an option is wrong, or a limit is hit.
    pub(super) fn prepared<F: Findings>(
        &self,
        job: &Job<Envelope<F>>,
        given: Arguments<'_>,
        at: &[String],
        kind: StrategyKind,
        check: impl FnOnce(&Program) -> Result<()>,
    ) -> Result<Prepared> {
        let read = |task: &mut Task| {
            check(&task.program)?;
            let at = NamedStates::read(&task.program, "--at", at)?;
            Ok((at, self.wanted(kind, task, &job.sink)?))
        };
        let (task, (at, wanted)) = plan::read(job, given, read)?;
        Ok(Prepared { task, wanted, at })
    }

    /// Returns the strategy of a kind.
    ///
    /// # Errors
    /// The objective does not fit, or the model has no such reward structure.
    pub(super) fn wanted(
        &self,
        kind: StrategyKind,
        task: &Task,
        sink: &TerminalSink,
    ) -> Result<StrategyOptions> {
        let objectives = kind.objectives(&task.preferences, self.objective())?;
        let (choose, levels) = (self.choose, self.levels.map(|k| k as usize));
        Ok(StrategyOptions { kind, choose, objectives, costs: self.costs(&task.program, sink)?, levels })
    }

    /// Returns the options as reports show them.
    pub(super) fn shown(&self) -> Choosing {
        let reward = self.choose.aim().map(|_| self.reward().to_owned());
        Choosing { choose: self.choose, reward }
    }

    /// Finds the cost of a step.
    fn costs(&self, program: &Program, sink: &TerminalSink) -> Result<Costs> {
        match self.choose {
            Choose::First => Ok(Costs::Steps),
            Choose::Likely | Choose::Cheap => costs(program, self.reward(), sink),
        }
    }

    fn reward(&self) -> &str {
        self.reward.as_deref().unwrap_or(Steps::NAME)
    }
}

/// Refuses to choose among the actions of a strategy that takes all of them.
///
/// # Errors
/// [`Error::Usage`].
pub(super) fn validate_scheduler(choose: Choose, scheduler: Scheduler) -> Result<()> {
    if choose == Choose::First || scheduler == Scheduler::Progress {
        return Ok(());
    }
    let message = "`--scheduler permissive` takes all permitted actions; `--choose` cannot be used with it";
    Err(Error::Usage(message.to_owned()))
}

/// Finds the cost of a step by its name.
///
/// # Errors
/// [`Error::Usage`] with the known names.
pub(super) fn costs(program: &Program, name: &str, sink: &TerminalSink) -> Result<Costs> {
    if Costs::is_hidden(program, name) {
        sink.warn(&format!(
            "the cost `{name}` is 1 per step, and not the reward structure \"{name}\" of the model; another \
             name of the structure selects it"
        ));
    }
    Costs::named(program, name).ok_or_else(|| {
        let known = Costs::names(program).collect::<Vec<_>>().join(", ");
        Error::Usage(format!("`--reward {name}`: the model has no such reward structure; there are {known}"))
    })
}
