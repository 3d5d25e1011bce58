//! Files of policies: `meliora verify POLICY MODEL` and `meliora simulate MODEL --policy POLICY`.

use std::path::PathBuf;
use std::sync::Arc;

use clap::builder::{OsStringValueParser, TypedValueParser as _};
use clap::{Arg, Args};
use meliora::commands::{GivenPolicy, PolicyAim};
use meliora_base::error::{Error, SourceFile};
use meliora_engine::Settings;
use meliora_report::policy_report::PolicyRuns;
use meliora_report::{Header, PolicyReport};

use super::exit::Status;
use super::load;
use super::model_files::ModelFiles;
use super::options::{Limits, ShownArgs};
use super::supervise::{Job, supervise};

/// The options about the goal of a policy.
#[derive(Debug, Clone, Args)]
pub(super) struct PolicyArgs {
    /// Goal of the policy, the same as for `reach` [default: the goal of the planning problem]
    #[arg(long, value_name = "EXPR", allow_hyphen_values = true)]
    pub(super) target: Option<String>,

    /// Values of undefined constants for a policy, such as K=4,N=3 (repeatable)
    #[arg(short, long = "const", value_name = "NAME=VALUE,…")]
    pub(super) constants: Vec<String>,
}

impl PolicyArgs {
    /// Returns whether an option is given.
    pub(super) fn is_given(&self) -> bool {
        self.target.is_some() || !self.constants.is_empty()
    }
}

/// Lets PREFS be left out if `--policy` is given.
pub(super) fn optional_with_policy(preferences: Arg) -> Arg {
    let any = OsStringValueParser::new().map(PathBuf::from);
    let preferences = preferences.required(false).required_unless_present("policy");
    preferences.value_parser(any).default_value("").hide_default_value(true)
}

/// A policy that is checked or run, with its problem.
pub(super) struct PolicyFile {
    pub(super) policy: PathBuf,
    /// The preferences that a policy with memory is about.
    pub(super) preferences: Option<PathBuf>,
    pub(super) coalition: Option<String>,
    pub(super) model: ModelFiles,
    pub(super) constants: String,
    pub(super) bounds: String,
    pub(super) target: Option<String>,
    pub(super) limits: Limits,
}

impl PolicyFile {
    /// Checks the policy.
    ///
    /// # Errors
    /// A file is wrong; a limit.
    pub(super) fn check(self, is_strong: bool, shown: &ShownArgs) -> Result<Status, Error> {
        supervise(self.report(None), self.limits, shown, move |job| {
            let policy = job.timed("parse", || self.read(job, is_strong), |r, s| r.time.add("parse", s))?;
            job.timed("answer", || policy.check(job), |r, s| r.time.add("answer", s))
        })
    }

    /// Runs the policy.
    ///
    /// # Errors
    /// A file is wrong; a limit.
    pub(super) fn simulate(self, runs: PolicyRuns, shown: &ShownArgs) -> Result<Status, Error> {
        supervise(self.report(Some(runs.clone())), self.limits, shown, move |job| {
            let policy = job.timed("parse", || self.read(job, false), |r, s| r.time.add("parse", s))?;
            job.timed("answer", || policy.run(job, &runs), |r, s| r.time.add("answer", s))
        })
    }

    fn report(&self, runs: Option<PolicyRuns>) -> PolicyReport {
        let header = Header::of_model(&self.model.shown());
        PolicyReport::of_file(header, &self.policy.display().to_string(), runs)
    }

    /// Reads the policy, and the model that it is for.
    fn read(&self, job: &Job<PolicyReport>, is_strong: bool) -> Result<GivenPolicy, Error> {
        let aim = PolicyAim {
            target: self.target.as_deref().map(|text| SourceFile::new("--target", text)),
            preferences: self.preferences.as_deref().map(load::read).transpose()?,
            is_strong,
        };
        let given = load::given("--const", self.constants.as_str(), self.bounds.as_str());
        let coalition = self.coalition.as_deref().filter(|_| self.preferences.is_some());
        let model = |for_goals| load::model(&self.model, coalition, &given, for_goals, &job.sink);
        let settings =
            Settings { memory: self.limits.memory, sink: Arc::clone(&job.sink) as _, ..Default::default() };
        GivenPolicy::read(job, &load::read(&self.policy)?, &aim, model, settings)
    }
}
