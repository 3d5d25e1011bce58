//! `meliora reach`: the four qualitative regions of a target, or of a temporal formula.

use std::path::{Path, PathBuf};

use clap::Args;
use meliora_base::error::Error;
use meliora_engine::Scope;
use meliora_quantities::PRECISION;
use meliora_question::Questions;
use meliora_question::answers::{OneQuestion, PropertyAnswer};
use meliora_report::ReachReport;

use super::asked::{self, Texts};
use super::exit::Status;
use super::load;
use super::options::{EngineArgs, ModelArgs, ShownArgs};
use super::policy::{PlanArgs, PolicyTargets};
use super::progress::TerminalSink;
use super::properties::{self, Chosen};
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
        let properties = match &self.properties {
            Some(file) => properties::titles(file, self.only.as_deref(), ends[0])?,
            None if self.all_properties => asked::names(&self.model, ends[0])?,
            None => self.property.clone(),
        };
        load::check_each(&self.model, ends, |model| match &self.properties {
            Some(file) => properties::check(file, model.into_program()),
            // The model names them, and each has its own reason if it is not answered.
            None if self.all_properties => Ok(()),
            None => {
                let required = load::required(&self.require)?;
                let (program, named) = model.into_parts();
                asked::planned((&program, &named), &self.texts(), &required).map(drop)
            }
        })?;
        Ok(sweep::Columns::new("reach", report, &properties))
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

    /// Checks that `--stop-at-target` has a meaning with the other options.
    fn check_stop(&self) -> Result<(), Error> {
        let problem = if !self.stop_at_target {
            return Ok(());
        } else if self.properties.is_some() || self.all_properties || self.property.len() > 1 {
            "needs one `--target` or one `--property`, since each question is decided in other states"
        } else if !self.require.is_empty() {
            "cannot be used with `--require`, which must be kept behind the target, too; leave out one of the two"
        } else if self.model.scope == Scope::All {
            "cannot be used with `--scope all`, in which every valuation is a state; leave out one of the two"
        } else {
            return Ok(());
        };
        Err(Error::Usage(format!("`--stop-at-target` {problem}")))
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
        let (properties, require) = (&self.property, &self.require);
        Texts { target: self.target.as_deref(), properties, require, regions: self.out.is_some() }
    }

    /// Returns whether the report has the fields of one question: a target or a single property.
    fn is_one(&self) -> bool {
        self.properties.is_none() && !self.all_properties && self.property.len() <= 1
    }

    /// Reads the model and the questions. Returns them, and the properties of the report with the reasons why some
    /// cannot be answered.
    fn read(&self, sink: &TerminalSink) -> Result<(Questions, Vec<PropertyAnswer>), Error> {
        if let Some(file) = &self.properties {
            let regions = self.out.is_some();
            let chosen = Chosen { file, only: self.only.as_deref(), require: &self.require, regions };
            return properties::read(&chosen, &self.model, sink);
        }
        if self.all_properties {
            return asked::named(&self.model, &self.texts(), sink);
        }
        let asked = match self.stop_at_target {
            true => asked::stopping(&self.model, &self.texts(), sink)?,
            false => asked::read(&self.model, &self.texts(), sink)?,
        };
        let texts = asked.plan.properties.iter().map(|property| property.text.clone());
        let entries = texts.map(|text| PropertyAnswer::open(None, text, None)).collect();
        Ok((asked, entries))
    }
}

/// Runs the command.
///
/// # Errors
/// The input is wrong, or a limit is hit.
pub(super) fn run(args: ReachArgs) -> Result<Status, Error> {
    args.engine.validate(&args.model)?;
    args.check_only()?;
    args.check_stop()?;
    let inputs: Vec<&Path> = args.properties.iter().map(PathBuf::as_path).collect();
    args.regions()?;
    let mut report = ReachReport::new(args.engine.header(args.model.header()));
    report.header.file = args.properties.as_ref().map(|file| file.display().to_string());
    report.stops_at_target = args.stop_at_target;
    report.one =
        args.is_one().then(|| OneQuestion { is_target: args.target.is_some(), ..Default::default() });
    let rows = |ends: [&str; 2]| args.rows(&report, ends);
    if let Some(status) = args.sweep.run(&args.model, &inputs, rows, &args.shown)? {
        return Ok(status);
    }
    let (limits, shown) = (args.model.limits(), args.shown.of(&args.model));
    let has_plan = args.is_one() && args.require.is_empty() && args.out.is_none() && !args.stop_at_target;
    let policy = args.plan.checked(has_plan, &Vec::from_iter(args.model.model.paths()))?;
    supervise(report, limits, &shown, move |job| work(job, &args, &policy))
}

fn work(job: &Job<ReachReport>, args: &ReachArgs, policy: &PolicyTargets) -> Result<(), Error> {
    let (asked, entries) = job.timed("parse", || args.read(&job.sink), |r, s| r.time.add("parse", s))?;
    if asked.plan.asks_for_numbers() {
        load::note_assumed(&asked.program, &job.sink);
    }
    if entries.iter().all(|entry| entry.reason.is_some()) && !entries.is_empty() {
        job.sink.warn("none of the properties can be answered: see the reasons");
    }
    job.update(|r| r.properties = entries);
    let (model, engine, out) = (&args.model, args.engine, args.regions()?);
    let plan = args.plan.is_given().then_some((&args.plan, policy));
    let given = Given { model, engine, out, precision: args.precision, is_one: args.is_one(), plan };
    questions::work(job, &given, &asked)
}
