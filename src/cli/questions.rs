//! Answers the questions of `meliora reach`, and writes regions and strategies.

use std::sync::Arc;

use meliora::commands::policy_text::{PolicyForm, write_opponent, write_policy};
use meliora::commands::region_dump;
use meliora_base::error::Error;
use meliora_question::{Options, PolicyKind, Questions, Strategies, pipeline, regions};
use meliora_report::ReachReport;

use super::engines;
use super::files::Target;
use super::folder::Folder;
use super::options::{EngineArgs, ModelArgs};
use super::policy::{PlanArgs, PolicyTargets};
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
    pub(super) plan: Option<(&'a PlanArgs, &'a PolicyTargets)>,
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
        let Some((plan, PolicyTargets { own, opponent })) = self.plan else { return Ok(()) };
        asked.check(plan.wanted())?;
        let kind = asked.policy_kind();
        let (what, extensions): (_, &[&str]) = match kind {
            PolicyKind::Rules => ("", &[]),
            PolicyKind::Mix => ("the strategies of `multi` are written as JSON", &["json"]),
            PolicyKind::Optimal => {
                ("the strategy of a property is written as JSON, CSV or DOT", &["json", "csv", "dot"])
            }
        };
        let fits = |target: &Target| {
            let extension = target.path().extension().and_then(|extension| extension.to_str());
            extensions.is_empty()
                || target.is_stdout()
                || extension.is_some_and(|own| extensions.contains(&own))
        };
        if ![own, opponent].into_iter().flatten().all(fits) {
            let message = format!("{what}: give the file a name that ends with .{}", extensions.join(", ."));
            return Err(Error::Usage(message));
        }
        if let Some(directory) = plan.induced.as_ref().filter(|_| kind == PolicyKind::Optimal) {
            Folder::new(directory, plan.format.names(&asked.program), &[])?;
        } else if plan.induced.is_some() {
            let message =
                "`--induced` is for the strategy of a property of one operator, such as `Pmax=? [ F a ]`";
            return Err(Error::Usage(message.to_owned()));
        }
        Ok(())
    }

    /// Writes the strategies that are asked for.
    fn write(&self, job: &Job<ReachReport>, asked: &Questions, found: &Strategies) -> Result<(), Error> {
        let Some((plan, PolicyTargets { own, opponent })) = self.plan else { return Ok(()) };
        let program = &asked.program;
        let is_missing = found.optimal.is_none() && plan.induced.is_some();
        let missing = || {
            job.sink.warn(match asked.policy_kind() {
                PolicyKind::Rules => "no policy is written: no strong cyclic plan exists",
                PolicyKind::Mix => "no strategies are written: none satisfies the bounds",
                PolicyKind::Optimal => "no strategy is written: none satisfies the property",
            });
        };
        let text = asked.text();
        let (of, form) = ((text.as_str(), found), |out: &Target| PolicyForm::by_ending(out.path()));
        match own {
            Some(out) if out.write_pieces(|write| write_policy(of, program, form(out), write))? => {}
            None if !is_missing => {}
            _ => missing(),
        }
        if let Some(out) = opponent
            && !out.write_pieces(|write| write_opponent(of, program, form(out), write))?
        {
            missing();
        }
        let (Some(directory), Some(found)) = (&plan.induced, &found.optimal) else { return Ok(()) };
        let folder =
            Folder::new(directory, plan.format.names(program), &Vec::from_iter(self.model.model.paths()))?;
        let sink = Arc::clone(&job.sink);
        folder.write(&plan.format.contents(found, program, &*sink)?).map(drop)
    }
}
