//! `meliora reach`: the four qualitative regions of a target, or of a temporal formula.

use std::path::{Path, PathBuf};

use clap::Args;
use meliora::Terms;
use meliora_base::error::Error;
use meliora_quantities::PRECISION;
use meliora_question::answers::OneQuestion;
use meliora_report::ReachReport;

use super::asked::Texts;
use super::exit::Status;
use super::load;
use super::options::{EngineArgs, ModelArgs, ShownArgs};
use super::policy::{PlanArgs, PolicyTargets};
use super::questions::{self, Given};
use super::regions::Regions;
use super::supervise::{Job, supervise};
use super::sweep::{self, SweepArgs};

/// Compute from which states a target is reached, or a temporal formula satisfied, surely or
/// possibly
#[derive(Debug, Clone, Args)]
#[command(group = clap::ArgGroup::new("question"))]
#[command(after_help = "Examples:
  meliora reach models/robot5x5.prism --target 'r=4 & c=4 & e'
  meliora reach models/robot5x5.prism --property 'P>0 [ F b=0 ]'")]
pub(super) struct ReachArgs {
    #[command(flatten)]
    model: ModelArgs,

    /// Target: an expression over the model's variables, such as 'x = 3 & "goal"'; see --property
    /// for other questions
    #[arg(long, value_name = "EXPR", group = "question", allow_hyphen_values = true)]
    target: Option<String>,

    /// Property to check in the initial states, such as 'P>=1 [ F "goal" ]', 'Pmax=? [ G F a ]' or
    /// 'R{"cost"}min=? [ F "goal" ]' (repeatable)
    #[arg(long, value_name = "PROPERTY", group = "question")]
    property: Vec<String>,

    /// PRISM property file: answers the supported properties, and gives a reason for the others
    #[arg(long, value_name = "FILE", group = "question")]
    properties: Option<PathBuf>,

    /// Answer all properties that a JANI model names
    #[arg(long, group = "question")]
    all_properties: bool,

    /// Check only the property with this name
    #[arg(long, value_name = "NAME")]
    only: Option<String>,

    /// Formula G p that no path may violate; only strategies that surely keep it count (repeatable)
    #[arg(long, value_name = "FORMULA", allow_hyphen_values = true)]
    require: Vec<String>,

    /// Do not explore the states behind those that decide the question, one target or property: the
    /// answer in the initial states is the same, and the counts are those of the part explored
    #[arg(long)]
    stop_at_target: bool,

    /// Largest width of a value, absolute for probabilities, relative above 1 for rewards
    #[arg(long, value_name = "X", default_value_t = PRECISION, value_parser = super::options::precision)]
    precision: f64,

    /// Write the computed regions to this directory as decision diagrams, which `query` reads. The
    /// regions are not certified: `verify` refuses such a dump
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    #[command(flatten)]
    plan: PlanArgs,

    #[command(flatten)]
    engine: EngineArgs,
    #[command(flatten)]
    sweep: SweepArgs,
    #[command(flatten)]
    shown: ShownArgs,
}

impl ReachArgs {
    /// Returns what the rows of a sweep contain, given the constants of the first and the last instance.
    fn rows(&self, report: &ReachReport, ends: [&str; 2]) -> Result<sweep::Columns, Error> {
        self.plan.checked(false, &[])?;
        if self.out.is_some() {
            let message = "`--out` writes the regions of one instance; a sweep has several";
            return Err(Error::Usage(message.to_owned()));
        }
        let (texts, columns) = (self.texts(), self.texts().titles(&self.model, ends[0])?);
        load::check_each(&self.model, ends, |model| texts.check(model))?;
        Ok(sweep::Columns::new("reach", report, &columns))
    }

    /// Checks that `--only` has properties to choose from. The parser does not: it takes one question only.
    fn check_only(&self) -> Result<(), Error> {
        if self.only.is_none() || self.properties.is_some() {
            return Ok(());
        }
        Err(Error::Usage(
            "`--only NAME` needs `--properties FILE`, whose property NAME it answers".to_owned(),
        ))
    }

    /// Checks that `--out` has a meaning with the other options, and returns the directory.
    fn regions(&self) -> Result<Option<Regions<'_>>, Error> {
        if self.out.is_some() && self.stop_at_target {
            let message = "`--out` cannot be used with `--stop-at-target`, which leaves out states; leave out one of the two";
            return Err(Error::Usage(message.to_owned()));
        }
        self.out.as_deref().map(|out| Regions::new(out, &self.model, self.engine)).transpose()
    }

    fn texts(&self) -> Texts<'_> {
        let (require, stops_at_target) = (&self.require, self.stop_at_target);
        Texts {
            target: self.target.as_deref(),
            properties: &self.property,
            file: self.properties.as_deref(),
            only: self.only.as_deref(),
            all_named: self.all_properties,
            terms: Terms { require, stops_at_target, regions: self.out.is_some(), prefix: "--" },
        }
    }
}

/// Runs the command.
///
/// # Errors
/// The input is wrong, or a limit is hit.
pub(super) fn run(args: ReachArgs) -> Result<Status, Error> {
    args.engine.validate(&args.model)?;
    args.check_only()?;
    let is_one = args.texts().is_one();
    args.texts().terms.check_stop(is_one, args.model.scope)?;
    let inputs: Vec<&Path> = args.properties.iter().map(PathBuf::as_path).collect();
    args.regions()?;
    let mut report = ReachReport::new(args.engine.header(args.model.header()));
    report.header.file = args.properties.as_ref().map(|file| file.display().to_string());
    report.stops_at_target = args.stop_at_target;
    report.one = is_one.then(|| OneQuestion { is_target: args.target.is_some(), ..Default::default() });
    let rows = |ends: [&str; 2]| args.rows(&report, ends);
    if let Some(status) = args.sweep.run(&args.model, &inputs, rows, &args.shown)? {
        return Ok(status);
    }
    let (limits, shown) = (args.model.limits(), args.shown.of(&args.model));
    let has_plan = is_one && args.require.is_empty() && args.out.is_none() && !args.stop_at_target;
    let policy = args.plan.checked(has_plan, &Vec::from_iter(args.model.model.paths()))?;
    supervise(report, limits, &shown, move |job| work(job, &args, &policy))
}

fn work(job: &Job<ReachReport>, args: &ReachArgs, policy: &PolicyTargets) -> Result<(), Error> {
    let (asked, entries) =
        job.timed("parse", || args.texts().read(&args.model, &job.sink), |r, s| r.time.add("parse", s))?;
    if asked.plan.asks_for_numbers() {
        load::note_assumed(&asked.program, &job.sink);
    }
    if entries.iter().all(|entry| entry.reason.is_some()) && !entries.is_empty() {
        job.sink.warn("none of the properties can be answered: see the reasons");
    }
    job.update(|r| r.properties = entries);
    let (model, engine, out) = (&args.model, args.engine, args.regions()?);
    let plan = args.plan.is_given().then_some((&args.plan, policy));
    let given = Given { model, engine, out, precision: args.precision, is_one: args.texts().is_one(), plan };
    questions::work(job, &given, &asked)
}
