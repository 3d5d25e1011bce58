//! `meliora strategy --policy`: a policy for one objective.

use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use meliora::supervise::lock;
use meliora::{Task, Terms};
use meliora_base::error::Error;
use meliora_model::preference::Objective;
use meliora_quantities::PRECISION;
use meliora_question::answers::{OneQuestion, PropertyAnswer};
use meliora_question::plan::Plan;
use meliora_question::{Asking, Questions};
use meliora_report::ReachReport;

use super::asked::Texts;
use super::exit::Status;
use super::load;
use super::options::{EngineArgs, ModelArgs, PreferenceArgs, ShownArgs};
use super::policy::PlanArgs;
use super::questions::{self, Given};
use super::supervise::{Job, supervise};

/// The objective that a policy achieves: `meliora strategy --policy`.
pub(super) struct OfObjective {
    pub(super) model: ModelArgs,
    pub(super) preferences: PreferenceArgs,
    pub(super) objective: Option<String>,
    pub(super) engine: EngineArgs,
    /// Receives the input if no list of rules achieves the objective: a policy needs memory, or is about a game, or
    /// none is named.
    pub(super) left: Arc<Mutex<Option<Task>>>,
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
    let plan = PlanArgs { policy: Some(policy), ..PlanArgs::default() };
    let out = plan.checked(true, &inputs)?;
    let (limits, shown) = (args.model.limits(), shown.of(&args.model));
    supervise(report, limits, &shown, move |job| {
        let asked = job.timed("parse", || args.asked(job), |r, s| r.time.add("parse", s))?;
        let (model, engine) = (&args.model, args.engine);
        let plan = Some((&plan, &out));
        let given = Given { model, engine, out: None, precision: PRECISION, is_one: true, plan };
        questions::work(job, &given, &asked)
    })
}

impl OfObjective {
    /// Reads the model, and the objective as a question.
    fn asked(&self, job: &Job<ReachReport>) -> Result<Questions, Error> {
        let name = self.objective.as_deref().unwrap_or("goal");
        let sink = &job.sink;
        let asked = if self.preferences.preferences.as_os_str().is_empty() {
            let label = format!("\"{name}\"");
            let target = self.objective.as_ref().map(|_| label.as_str());
            Texts { target, terms: Terms { prefix: "--", ..Terms::default() }, ..Texts::default() }
                .read(&self.model, sink)?
                .0
        } else {
            let task = load::task(&self.model, &self.preferences, sink)?;
            let preferences = &task.preferences;
            let objective = preferences.objectives.iter().find(|objective| objective.name == name);
            if objective.is_none() && self.objective.is_some() {
                return Err(Error::Usage(format!(
                    "unknown objective `{name}`: `--objective NAME` names one"
                )));
            }
            let is_simple = preferences.requirements.is_empty() && task.program.players.is_none();
            let Some(target) = objective.and_then(Objective::target).filter(|_| is_simple).cloned() else {
                *lock(&self.left) = Some(task);
                return Err(Error::Usage(format!("no list of rules achieves `{name}`")));
            };
            let Task { program, .. } = task;
            let asking = Asking::states(&program, target, &[])?;
            Questions::new(Arc::unwrap_or_clone(program), Plan::of(asking, name), Vec::new(), false)
        };
        job.update(|r| r.properties = vec![PropertyAnswer::open(None, name.to_owned(), None)]);
        Ok(asked)
    }
}
