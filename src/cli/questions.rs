//! Answers the questions of `meliora reach`, and writes regions and strategies.

use meliora::commands::region_dump;
use meliora_base::error::Error;
use meliora_question::evaluate::PropertyPolicy;
use meliora_question::{Options, PolicyKind, Questions, Strategies, pipeline, regions};
use meliora_report::{ReachReport, mix, policy, property_policy};

use super::engines;
use super::files::Target;
use super::options::{EngineArgs, ModelArgs};
use super::policy::PlanArgs;
use super::regions::Regions;
use super::supervise::Job;

/// The options of the answers, and the directory of the regions.
pub(super) struct Given<'a> {
    pub(super) model: &'a ModelArgs,
    pub(super) engine: EngineArgs,
    pub(super) out: Option<Regions<'a>>,
    pub(super) precision: f64,
    /// True for one question, whose fields the report has.
    pub(super) is_one: bool,
    /// The plans that are asked for, and where the policy is written.
    pub(super) plan: Option<(&'a PlanArgs, &'a [Option<Target>; 2])>,
}

/// Answers all questions.
///
/// # Errors
/// A limit is hit, or a question has no meaning for the initial states.
pub(super) fn work(job: &Job<ReachReport>, given: &Given<'_>, asked: &Questions) -> Result<(), Error> {
    let selected = match given.out {
        Some(_) => given.engine.diagrams("`--out` writes diagrams"),
        None => given.engine.select(given.model),
    };
    job.update(|r| {
        r.header.read(&asked.program);
        r.header.select(&selected);
    });
    given.check(asked)?;
    let options = Options {
        settings: engines::settings(given.model, selected.storage, &job.sink)?,
        selected,
        precision: given.precision,
        is_one: given.is_one,
        regions: given.out.is_some(),
        strategies: given.plan.map(|(plan, _)| plan.wanted()).unwrap_or_default(),
    };
    let Some(out) = &given.out else {
        let found = pipeline::answer(job, &options, asked)?;
        return given.write(job, asked, &found);
    };
    region_dump::check(asked)?;
    let computed = regions::compute(job, &options, asked)?;
    let write = || region_dump::write(job, asked, computed, out.model.path(), out.directory);
    let written = job.timed("write", write, |_, _| ())?;
    job.update(|r| r.written = Some(written));
    job.sink.ended_share().map_or(Ok(()), |limit| Err(limit.into()))
}

impl Given<'_> {
    /// Checks that the strategies that are asked for exist, and can be written.
    ///
    /// # Errors
    /// [`Error::Usage`].
    fn check(&self, asked: &Questions) -> Result<(), Error> {
        let Some((plan, targets)) = self.plan else { return Ok(()) };
        asked.check(plan.wanted())?;
        let what = match asked.policy_kind() {
            PolicyKind::Rules => return Ok(()),
            PolicyKind::Mix => "the strategies of `multi` are",
            PolicyKind::Optimal => "the strategy of a property is",
        };
        let is_json =
            |target: &Target| target.is_stdout() || target.path().extension().is_some_and(|e| e == "json");
        if !targets.iter().flatten().all(is_json) {
            let message = format!("{what} written as JSON: give the file a name that ends with .json");
            return Err(Error::Usage(message));
        }
        Ok(())
    }

    /// Writes the strategies that are asked for.
    fn write(&self, job: &Job<ReachReport>, asked: &Questions, found: &Strategies) -> Result<(), Error> {
        let Some((plan, [own, opponent])) = self.plan else { return Ok(()) };
        let write = |out: &Option<Target>, text: Option<String>| match (out, text) {
            (Some(out), Some(text)) => out.write(&text),
            (Some(_), None) => {
                let missing = match asked.policy_kind() {
                    PolicyKind::Rules => "no policy is written: no strong cyclic plan exists",
                    PolicyKind::Mix => "no strategies are written: none satisfies the bounds",
                    PolicyKind::Optimal => "no strategy is written: none satisfies the property",
                };
                job.sink.warn(missing);
                Ok(())
            }
            (None, _) => Ok(()),
        };
        let program = &asked.program;
        let optimal = |found: &PropertyPolicy| property_policy::json(&asked.text(), found, program);
        let text = match found {
            Strategies { policy: Some(found), .. } if plan.is_json() => {
                Some(policy::json(found, program)? + "\n")
            }
            Strategies { policy: Some(found), .. } => Some(policy::text(found, program)?),
            Strategies { mix: Some(found), .. } if !found.strategies.is_empty() => {
                Some(mix::json(&asked.text(), found, program)? + "\n")
            }
            Strategies { optimal: Some(found), .. } => Some(optimal(found)?),
            _ => None,
        };
        write(own, text)?;
        write(opponent, found.opponent.as_ref().map(optimal).transpose()?)
    }
}
