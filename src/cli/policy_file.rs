//! Files of policies: `meliora verify POLICY MODEL` and `meliora simulate MODEL --policy POLICY`.

use std::path::PathBuf;
use std::sync::Arc;

use clap::builder::{OsStringValueParser, TypedValueParser as _};
use clap::{Arg, Args};
use meliora::Model;
use meliora::commands::{GivenPolicy, PolicyForm};
use meliora_base::error::{Error, SourceFile};
use meliora_engine::Settings;
use meliora_model::Program;
use meliora_model::predicate::Predicate;
use meliora_question::{Asking, Target as Goal};
use meliora_report::policy_report::PolicyRuns;
use meliora_report::{Header, PolicyReport};

use super::asked::NO_GOAL;
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
        supervise(self.report(true), self.limits, shown, move |job| {
            let policy = job.timed("parse", || self.read(job, is_strong), |r, s| r.time.add("parse", s))?;
            job.timed("answer", || policy.check(job, is_strong), |r, s| r.time.add("answer", s))
        })
    }

    /// Runs the policy.
    ///
    /// # Errors
    /// A file is wrong; a limit.
    pub(super) fn simulate(self, runs: PolicyRuns, shown: &ShownArgs) -> Result<Status, Error> {
        let mut report = self.report(false);
        report.runs = Some(runs.clone());
        supervise(report, self.limits, shown, move |job| {
            let policy = job.timed("parse", || self.read(job, false), |r, s| r.time.add("parse", s))?;
            job.timed("answer", || policy.run(job, &runs), |r, s| r.time.add("answer", s))
        })
    }

    fn report(&self, is_check: bool) -> PolicyReport {
        let header = Header::of_model(&self.model.shown());
        PolicyReport::of_file(header, &self.policy.display().to_string(), is_check)
    }

    /// Reads the policy, and the model that it is for.
    fn read(&self, job: &Job<PolicyReport>, is_strong: bool) -> Result<GivenPolicy, Error> {
        let source = &load::read(&self.policy)?;
        let form = PolicyForm::of(source);
        let has_goal = is_strong || self.target.is_some();
        let wrong = match (form, &self.preferences) {
            (PolicyForm::Nodes, _) if has_goal => {
                "this policy is about preferences: leave out `--target` and `--strong`"
            }
            (PolicyForm::Nodes, None) => {
                "this policy is about preferences: name the preference file after the model"
            }
            (PolicyForm::Nodes, Some(preferences)) => {
                let task = load::preferring(self.model(job, false)?, preferences, &job.sink)?;
                job.update(|r| r.header.read(&task.program));
                return GivenPolicy::nodes(source, task, job.sink.as_ref());
            }
            (_, Some(_)) => "this policy has a goal of its own, and no preferences: leave out PREFS",
            (PolicyForm::Mix, None) if has_goal => {
                "the strategies of `multi` have objectives of their own: leave out `--target` and `--strong`"
            }
            (PolicyForm::Mix, None) => {
                let (memory, sink) = (self.limits.memory, Arc::clone(&job.sink) as _);
                let settings = Settings { memory, sink, ..Default::default() };
                return GivenPolicy::mix(source, self.program(job, false)?, settings);
            }
            (PolicyForm::Rules, None) => {
                let program = self.program(job, self.target.is_none())?;
                let goal = goal(&program, self.target.as_deref())?;
                return GivenPolicy::rules(source, program, goal, job.sink.as_ref());
            }
        };
        Err(Error::Usage(wrong.to_owned()))
    }

    fn model(&self, job: &Job<PolicyReport>, for_goals: bool) -> Result<Model, Error> {
        let given = load::given("--const", self.constants.as_str(), self.bounds.as_str());
        let coalition = self.coalition.as_deref().filter(|_| self.preferences.is_some());
        load::model(&self.model, coalition, &given, for_goals, &job.sink)
    }

    /// Reads the model of a policy with a goal of its own.
    fn program(&self, job: &Job<PolicyReport>, for_goals: bool) -> Result<Program, Error> {
        let program = self.model(job, for_goals)?.into_program();
        job.update(|r| r.header.read(&program));
        Ok(program)
    }
}

/// Returns the states that a target means, or the goal of the planning problem.
///
/// # Errors
/// There is neither; the target is wrong; the model is a game.
fn goal(program: &Program, target: Option<&str>) -> Result<Predicate, Error> {
    let wrong = |message: &str| Err(Error::Usage(message.to_owned()));
    if program.players.is_some() {
        return wrong("this checks policies of models with one player, and this model is a game");
    }
    let text = match (target, &program.planning) {
        (Some(text), _) => text,
        (None, Some(planning)) if planning.has_goal() => "\"goal\"",
        (None, Some(_)) => return wrong(NO_GOAL),
        (None, None) => return wrong("this model has no goal of its own: `--target EXPR` gives one"),
    };
    match Asking::target(program, &SourceFile::new("--target", text), &[])?.goal.target {
        Goal::States(goal) => Ok(goal),
        Goal::Formula(_) => wrong("`--target` is a condition on states"),
    }
}
