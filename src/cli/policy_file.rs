//! Files of policies: `meliora verify POLICY MODEL` and `meliora simulate MODEL --policy POLICY`.

use std::path::PathBuf;
use std::sync::Arc;

use clap::builder::{OsStringValueParser, TypedValueParser as _};
use clap::{Arg, Args};
use meliora_base::error::{Error, SourceFile};
use meliora_base::random::Draw;
use meliora_certify::policy::rules::Rules;
use meliora_engine::explicit::initial_states;
use meliora_lang::{Checked, Given};
use meliora_model::predicate::Predicate;
use meliora_model::{Program, State};
use meliora_question::strategies::MOST_STATES;
use meliora_question::{Asking, Target as Goal};
use meliora_report::policy_report::PolicyRuns;
use meliora_report::{Header, PolicyReport, mix, node_file, policy_file};

use super::asked::NO_GOAL;
use super::exit::Status;
use super::load;
use super::mix_file::MixFile;
use super::model_files::ModelFiles;
use super::node_file::NodeFile;
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

/// The contents of the files.
struct Read {
    program: Program,
    goal: Predicate,
    rules: Rules,
    initial: Vec<State>,
}

impl PolicyFile {
    /// Checks the policy.
    ///
    /// # Errors
    /// A file is wrong; a limit.
    pub(super) fn check(self, is_strong: bool, shown: &ShownArgs) -> Result<Status, Error> {
        supervise(self.report(true), self.limits, shown, move |job| {
            let source = load::read(&self.policy)?;
            let Some(read) = self.rules(job, &source, is_strong, None)? else { return Ok(()) };
            let Read { program, goal, rules, initial } = &read;
            let check = || Ok(rules.check(program, goal, initial, is_strong, job.sink.as_ref())?);
            let found = job.timed("answer", check, |r, s| r.time.add("answer", s))?;
            job.update(|r| r.set(&read.program, found));
            Ok(())
        })
    }

    /// Runs the policy.
    ///
    /// # Errors
    /// A file is wrong; a limit.
    pub(super) fn simulate(self, runs: PolicyRuns, shown: &ShownArgs) -> Result<Status, Error> {
        let (count, limit, seed) = (runs.runs, runs.limit, runs.seed);
        let mut report = self.report(false);
        report.runs = Some(runs.clone());
        supervise(report, self.limits, shown, move |job| {
            let source = load::read(&self.policy)?;
            let Some(read) = self.rules(job, &source, false, Some(&runs))? else { return Ok(()) };
            let all = || {
                for number in 0..count {
                    job.sink.check()?;
                    let mut draw = Draw::numbered(seed, number);
                    let start = match read.initial.as_slice() {
                        [start] => start,
                        several => &several[draw.below(several.len())],
                    };
                    let run = read.rules.run(&read.program, &read.goal, start, limit, &mut draw);
                    job.update(|r| r.add(&read.program, run));
                }
                Ok(())
            };
            job.timed("answer", all, |r, s| r.time.add("answer", s))
        })
    }

    fn report(&self, is_check: bool) -> PolicyReport {
        let header = Header::of_model(&self.model.shown());
        PolicyReport::of_file(header, &self.policy.display().to_string(), is_check)
    }

    /// Reads a list of rules. Checks or runs a policy of another form; `None` for these.
    fn rules(
        &self,
        job: &Job<PolicyReport>,
        source: &Arc<SourceFile>,
        is_strong: bool,
        runs: Option<&PolicyRuns>,
    ) -> Result<Option<Read>, Error> {
        if node_file::is_nodes(source) {
            return self.with_memory(job, source, is_strong, runs).map(|()| None);
        }
        self.without_preferences()?;
        if mix::is_mix(source) {
            return self.mixed(job, source, is_strong, runs).map(|()| None);
        }
        job.timed("parse", || self.read(job, source), |r, s| r.time.add("parse", s)).map(Some)
    }

    /// Refuses preferences that would have no meaning.
    fn without_preferences(&self) -> Result<(), Error> {
        match self.preferences {
            None => Ok(()),
            Some(_) => {
                let message = "this policy has a goal of its own, and no preferences: leave out PREFS";
                Err(Error::Usage(message.to_owned()))
            }
        }
    }

    /// Checks or runs a policy with memory.
    fn with_memory(
        &self,
        job: &Job<PolicyReport>,
        source: &Arc<SourceFile>,
        is_strong: bool,
        runs: Option<&PolicyRuns>,
    ) -> Result<(), Error> {
        let wrong = |message: &str| Err(Error::Usage(message.to_owned()));
        if is_strong || self.target.is_some() {
            return wrong("this policy is about preferences: leave out `--target` and `--strong`");
        }
        let Some(preferences) = &self.preferences else {
            return wrong("this policy is about preferences: name the preference file after the model");
        };
        let read = || {
            let coalition = self.coalition.as_deref();
            let question = load::certified(&self.model, coalition, preferences, &self.given(), &job.sink)?;
            job.update(|r| r.header.read(&question.program));
            let initial = initial_states(&question.program, MOST_STATES, job.sink.as_ref())?;
            NodeFile::new(source, question, initial)
        };
        let read = job.timed("parse", read, |r, s| r.time.add("parse", s))?;
        job.timed("answer", || read.work(job, runs), |r, s| r.time.add("answer", s))
    }

    fn given(&self) -> Given {
        Given {
            constants: SourceFile::new("--const", self.constants.as_str()),
            bounds: SourceFile::new("--bounds", self.bounds.as_str()),
        }
    }

    /// Checks or runs the strategies of a property `multi(…)`.
    fn mixed(
        &self,
        job: &Job<PolicyReport>,
        source: &Arc<SourceFile>,
        is_strong: bool,
        runs: Option<&PolicyRuns>,
    ) -> Result<(), Error> {
        if is_strong || self.target.is_some() {
            let message =
                "the strategies of `multi` have objectives of their own: leave out `--target` and `--strong`";
            return Err(Error::Usage(message.to_owned()));
        }
        let read = || MixFile::new(source, self.program(job, false)?, self.limits);
        let read = job.timed("parse", read, |r, s| r.time.add("parse", s))?;
        job.timed("answer", || read.work(job, runs), |r, s| r.time.add("answer", s))
    }

    /// Reads the model.
    fn program(&self, job: &Job<PolicyReport>, for_goals: bool) -> Result<Program, Error> {
        let given = self.given();
        let document = load::document(&self.model)?;
        let document = if for_goals { document.for_goals() } else { document };
        let Checked { program, warnings, .. } = document.load(&given, job.sink.as_ref())?;
        job.sink.warn_at(&warnings);
        job.update(|r| r.header.read(&program));
        Ok(program)
    }

    fn read(&self, job: &Job<PolicyReport>, source: &Arc<SourceFile>) -> Result<Read, Error> {
        let program = self.program(job, self.target.is_none())?;
        let goal = goal(&program, self.target.as_deref())?;
        let initial = initial_states(&program, MOST_STATES, job.sink.as_ref())?;
        if initial.is_empty() {
            return Err(Error::Usage("the model has no initial state to follow a policy from".to_owned()));
        }
        let rules = policy_file::read(source, &program)?;
        Ok(Read { program, goal, rules, initial })
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
