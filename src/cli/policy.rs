//! `meliora reach --strong --policy` and `meliora strategy --policy`: plans for one target, as planners ask
//! for them.

use std::path::{Path, PathBuf};

use clap::Args;
use meliora::reach::{Asking, Target as Goal};
use meliora_base::error::Error;
use meliora_engine::Engine;
use meliora_model::Program;
use meliora_planning::policy::{Policy, strong_region};
use meliora_planning::rules::Rules;
use meliora_quantities::answer::PRECISION;
use meliora_report::properties::PropertyAnswer;
use meliora_report::reach::OneQuestion;
use meliora_report::{Number, ReachReport, policy};

use super::exit::Status;
use super::files::Target;
use super::given::Given;
use super::load::{self, Asked, Question, Stated};
use super::options::{EngineArgs, ModelArgs, PreferenceArgs, ShownArgs};
use super::questions;
use super::supervise::{Job, supervise};

/// Maximum number of states of a policy: each takes about as much memory as a line of its text.
const MOST_STATES: usize = 1_000_000;

/// The options about plans.
#[derive(Debug, Clone, Args)]
pub(super) struct PlanArgs {
    /// Compute, too, from which states a strong plan exists: every path reaches the target within a bound
    #[arg(long)]
    pub(super) strong: bool,

    /// Write a policy that reaches the target from the initial states almost surely: for each state that it
    /// visits the facts and the action, as planners do, or as JSON if FILE ends with .json; `-` is standard
    /// output
    #[arg(long, value_name = "FILE")]
    pub(super) policy: Option<PathBuf>,
}

/// The objective that a policy achieves: `meliora strategy --policy`.
pub(super) struct OfObjective {
    pub(super) model: ModelArgs,
    pub(super) preferences: PreferenceArgs,
    pub(super) objective: Option<String>,
    pub(super) engine: EngineArgs,
}

/// Writes a policy that achieves an objective.
///
/// # Errors
/// The input is wrong, or a limit is hit.
pub(super) fn policy_of(args: OfObjective, policy: PathBuf, shown: &ShownArgs) -> Result<Status, Error> {
    args.engine.validate(&args.model)?;
    let mut report = ReachReport::new(args.engine.header(args.model.header()));
    let preferences = args.preferences.preferences.as_path();
    let is_target = args.objective.is_some() || !preferences.as_os_str().is_empty();
    report.one = Some(OneQuestion { is_target, ..Default::default() });
    let inputs = args.preferences.inputs(&args.model);
    let plan = PlanArgs { strong: false, policy: Some(policy) };
    let out = plan.checked(true, &inputs)?;
    let (limits, shown) = (args.model.limits(), shown.of(&args.model));
    supervise(report, limits, &shown, move |job| {
        let asked = job.timed("parse", || args.asked(job), |r, s| r.time.add("parse", s))?;
        let (model, engine) = (&args.model, args.engine);
        let plan = Some((&plan, out.as_ref()));
        let given = Given { model, engine, out: None, precision: PRECISION, is_one: true, plan };
        questions::work(job, &given, &asked)
    })
}

impl OfObjective {
    /// Reads the model, and the objective as a question.
    fn asked(&self, job: &Job<ReachReport>) -> Result<Asked, Error> {
        let name = self.objective.as_deref().unwrap_or("goal");
        let sink = &job.sink;
        let asked = if self.preferences.preferences.as_os_str().is_empty() {
            let label = format!("\"{name}\"");
            let target = self.objective.as_ref().map(|_| label.as_str());
            load::asked(&self.model, target, &[], &[], false, sink)?
        } else {
            let Question { program, preferences, overlap, .. } =
                load::question(&self.model, &self.preferences, sink)?;
            let objective = preferences.objectives.iter().find(|objective| objective.name == name);
            let wrong = |message: String| Error::Usage(message);
            let objective = objective
                .ok_or_else(|| wrong(format!("unknown objective `{name}`: `--objective NAME` names one")))?;
            let Some(target) = objective.target().filter(|_| preferences.requirements.is_empty()) else {
                let message = "`--policy` is for objectives `F condition` without requirements; `--all --csv FILE` writes the strategies of others";
                return Err(wrong(message.to_owned()));
            };
            let asking = Asking::states(&program, target.clone(), &[])?;
            let questions = vec![Stated { position: 0, text: name.to_owned(), asking }];
            Asked { program, questions, terms: Vec::new(), is_list: false, overlap }
        };
        job.update(|r| r.properties = vec![PropertyAnswer::open(None, name.to_owned(), None)]);
        Ok(asked)
    }
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
    fn is_json(&self) -> bool {
        self.policy.as_ref().is_some_and(|path| path.extension().is_some_and(|e| e == "json"))
    }

    /// Computes the plans for a question, and writes the policy.
    ///
    /// # Errors
    /// The question has no plans; a limit; the file cannot be written.
    pub(super) fn work<E: Engine>(
        &self,
        job: &Job<ReachReport>,
        engine: &E,
        program: &Program,
        asking: &Asking,
        out: Option<&Target>,
    ) -> Result<(), Error> {
        let Goal::States(target) = &asking.goal.target else {
            let message = "`--strong` and `--policy` are about reaching a target, not about other formulas";
            return Err(Error::Usage(message.to_owned()));
        };
        if engine.is_game() {
            let message =
                "`--strong` and `--policy` are about models with one player; `strategy` is for games";
            return Err(Error::Usage(message.to_owned()));
        }
        let goal = engine.states_where(target)?;
        if self.strong {
            let find = || strong_region(engine, &goal);
            let region = job.timed("strong", find, |r, s| r.time.add("strong", s))?;
            let outside = engine.difference(&engine.initial_states(), &region)?;
            let (exists, count) = (engine.is_empty(&outside)?, engine.count(&region)?);
            update(job, |plan| (plan.strong, plan.strong_states) = (Some(exists), Some(Number::from(count))));
        }
        let Some(out) = out else { return Ok(()) };
        let find = || self.find(engine, program, &goal, target);
        let found = job.timed("policy", find, |r, s| r.time.add("policy", s))?;
        update(job, |plan| plan.strong_cyclic = Some(found.is_some()));
        let Some(found) = found else {
            job.sink.warn("no policy is written: no strong cyclic plan exists");
            return Ok(());
        };
        let text = if self.is_json() {
            policy::json(&found, program).map_err(|e| Error::Usage(e.to_string()))? + "\n"
        } else {
            policy::text(&found, program)
        };
        out.write(&text)?;
        update(job, |plan| plan.policy_states = Some(Number::from(found.entries.len() as u64)));
        Ok(())
    }

    /// Finds a policy, and checks it state by state.
    fn find<E: Engine>(
        &self,
        engine: &E,
        program: &Program,
        goal: &E::States,
        target: &meliora_model::predicate::Predicate,
    ) -> Result<Option<Policy>, Error> {
        let Some(found) = Policy::find(engine, program, goal, MOST_STATES)? else { return Ok(None) };
        let initial = engine.list_states(&engine.initial_states(), MOST_STATES)?;
        let sink = &*engine.settings().sink;
        match Rules::from(&found).check((program, target), &initial, false, sink)? {
            Ok(_) => Ok(Some(found)),
            Err(fault) => Err(Error::Usage(format!("{}: {}", fault.kind, program.show_state(&fault.state)))),
        }
    }
}

fn update(job: &Job<ReachReport>, change: impl FnOnce(&mut meliora_report::reach::Plan)) {
    job.update(|r| {
        if let Some(one) = &mut r.one {
            change(one.plan.get_or_insert_default());
        }
    });
}
