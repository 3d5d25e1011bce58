//! Plans for one target, as planners ask for them: `--strong` and `--policy`.

use std::path::{Path, PathBuf};

use clap::Args;
use meliora_base::error::Error;
use meliora_base::progress::ProgressSink;
use meliora_certify::policy::rules::{Rules, Taken};
use meliora_engine::{Engine, Guided};
use meliora_model::Program;
use meliora_model::predicate::Predicate;
use meliora_planning::policy::{Policy, PolicyEntry, strong_region};
use meliora_question::{Asking, Target as Goal};
use meliora_report::{Number, ReachReport, policy};

use super::files::Target;
use super::supervise::Job;

/// Maximum number of states of a policy: each takes about as much memory as a line of its text.
pub(super) const MOST_STATES: usize = 1_000_000;

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
            let message = "`--strong` and `--policy` are about models with one player; in a game, `strategy` without \
                 `--policy` lists the actions";
            return Err(Error::Usage(message.to_owned()));
        }
        if self.strong {
            let goal = engine.states_where(target)?;
            let find = || strong_region(engine, &goal);
            let region = job.timed("strong", find, |r, s| r.time.add("strong", s))?;
            let outside = engine.difference(&engine.initial_states(), &region)?;
            let (exists, count) = (engine.is_empty(&outside)?, engine.count(&region)?);
            update(job, |plan| (plan.strong, plan.strong_states) = (Some(exists), Some(Number::from(count))));
        }
        let Some(out) = out else { return Ok(()) };
        let find = || found(engine, program, target);
        let found = job.timed("policy", find, |r, s| r.time.add("policy", s))?;
        self.finish(job, found, program, out)
    }

    /// Writes the policy of a guided search.
    ///
    /// # Errors
    /// A limit; the file cannot be written.
    pub(super) fn of_search(
        &self,
        job: &Job<ReachReport>,
        search: &Guided,
        program: &Program,
        asking: &Asking,
        out: &Target,
    ) -> Result<(), Error> {
        let find = || match &asking.goal.target {
            Goal::States(target) if search.answer() == Some(true) => {
                checked(Policy::of_search(search, program, MOST_STATES)?, program, target, &*job.sink)
                    .map(Some)
            }
            _ => Ok(None),
        };
        let found = job.timed("policy", find, |r, s| r.time.add("policy", s))?;
        self.finish(job, found, program, out)
    }

    /// Writes a policy, or says that there is none.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(super) fn finish(
        &self,
        job: &Job<ReachReport>,
        found: Option<Policy>,
        program: &Program,
        out: &Target,
    ) -> Result<(), Error> {
        update(job, |plan| plan.strong_cyclic = Some(found.is_some()));
        let Some(found) = found else {
            job.sink.warn("no policy is written: no strong cyclic plan exists");
            return Ok(());
        };
        let text = match self.is_json() {
            true => policy::json(&found, program)? + "\n",
            false => policy::text(&found, program)?,
        };
        out.write(&text)?;
        update(job, |plan| plan.policy_states = Some(Number::from(found.entries.len() as u64)));
        Ok(())
    }
}

/// Returns a checked policy; `None` if there is none. The engine may know states that are not reachable.
///
/// # Errors
/// A limit.
pub(super) fn found<E: Engine>(
    engine: &E,
    program: &Program,
    target: &Predicate,
) -> Result<Option<Policy>, Error> {
    let found = Policy::find(engine, program, &engine.states_where(target)?, MOST_STATES)?;
    found.map(|found| checked(found, program, target, &*engine.settings().sink)).transpose()
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

fn update(job: &Job<ReachReport>, change: impl FnOnce(&mut meliora_report::reach::Plan)) {
    job.update(|r| {
        if let Some(one) = &mut r.one {
            change(one.plan.get_or_insert_default());
        }
    });
}
