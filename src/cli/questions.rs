//! Answers the questions of `meliora reach`, and writes regions and strategies.

use meliora_base::error::Error;
use meliora_question::evaluate::Mix;
use meliora_question::{Asking, Options, Questions, Strategies, Target as Goal, pipeline, regions};
use meliora_report::ReachReport;
use meliora_report::mix::{self, Mixed};

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
    pub(super) plan: Option<(&'a PlanArgs, Option<&'a Target>)>,
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
        return given.write(job, asked, found);
    };
    Regions::check(asked)?;
    let computed = regions::compute(job, &options, asked)?;
    let written = job.timed("write", || out.write(job, asked, computed), |_, _| ())?;
    job.update(|r| r.written = Some(written));
    job.sink.ended_share().map_or(Ok(()), |limit| Err(limit.into()))
}

impl Given<'_> {
    /// Checks that the strategies that are asked for exist.
    ///
    /// # Errors
    /// [`Error::Usage`].
    fn check(&self, asked: &Questions) -> Result<(), Error> {
        let Some((plan, target)) = self.plan else { return Ok(()) };
        let wrong = |message: &str| Err(Error::Usage(message.to_owned()));
        if asked.is_multi() && !plan.strong {
            return match plan.is_json() || target.is_some_and(Target::is_stdout) {
                true => Ok(()),
                false => wrong(
                    "the strategies of `multi` are written as JSON: give `--policy` a name that ends with .json",
                ),
            };
        }
        let of_target = asked.plan.properties.first().and_then(|only| only.request());
        let of_target = of_target.map(|request| &asked.plan.requests[request].asking);
        if !of_target.is_some_and(|asking| matches!(asking.goal.target, Goal::States(_))) {
            return wrong("`--strong` and `--policy` are about reaching a target, not about other formulas");
        }
        if asked.program.players.is_some() {
            return wrong(
                "`--strong` and `--policy` are about models with one player; in a game, `strategy` without \
                 `--policy` lists the actions",
            );
        }
        Ok(())
    }

    /// Writes the strategies that are asked for.
    fn write(&self, job: &Job<ReachReport>, asked: &Questions, found: Strategies) -> Result<(), Error> {
        let Some((plan, Some(out))) = self.plan else { return Ok(()) };
        let asking = asked.plan.requests.first().map(|request| &request.asking);
        match (asking, found.mix) {
            (Some(Asking { goal, .. }), _) => {
                let program = goal.program(&asked.program);
                plan.finish(job, found.policy, program, goal, out)
            }
            (None, Some(Mix { strategies, great })) if !strategies.is_empty() => {
                let all = strategies.iter().map(|own| Mixed {
                    share: own.share.as_ref(),
                    values: &own.values,
                    nodes: &own.nodes,
                    great: &great,
                });
                let stated = asked.plan.properties.first().and_then(|only| only.stated.as_ref());
                let text = stated.map(|(source, term)| source.on_one_line(term.span.range()));
                let text = text.unwrap_or_default();
                out.write(&(mix::json(&text, &Vec::from_iter(all), &asked.program)? + "\n"))
            }
            (None, _) => {
                job.sink.warn("no strategies are written: none satisfies the bounds");
                Ok(())
            }
        }
    }
}
