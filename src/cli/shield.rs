//! `meliora shield`: the actions whose probabilities stay within a threshold.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use meliora::export::write_shield;
use meliora_base::csv::Lines;
use meliora_base::error::{Error, Result};
use meliora_engine::{AnyEngine, Engine};
use meliora_model::Program;
use meliora_planning::Shield;
use meliora_quantities::PRECISION;
use meliora_question::race::{Early, Raced};
use meliora_question::shield::{ShieldQuestion, Threshold};
use meliora_report::ShieldReport;
use meliora_report::shield::{ShieldedState, heading};

use super::exit::Status;
use super::files::Target;
use super::options::{self, EngineArgs, ModelArgs, ShownArgs};
use super::supervise::{Job, supervise};
use super::{engines, load};

/// Compute how safe each action of each state is, and which are safe enough
///
/// Lists the best probability of a formula after each action of each state. The safety of an action is
/// this probability for `Pmax`, and 1 minus it for `Pmin`: an action is permitted if its safety is at
/// least the threshold, or with --relative the threshold times the best safety of the state. Where no
/// action is safe enough, the safest are permitted.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:
  meliora shield models/drone.prism --property 'Pmax=? [ F \"goal\" ]' --threshold 0.9 --relative
  meliora shield models/robot5x5.prism --property 'Pmin=? [ F b=0 ]' --threshold 0.9 --csv shield.csv")]
pub(super) struct ShieldArgs {
    #[command(flatten)]
    model: ModelArgs,

    /// Property `Pmin=? [ … ]` of a bad event or `Pmax=? [ … ]` of a good one, or a shield expression of
    /// tempest, `<name, PreSafety, lambda=0.9> Pmax=? [ G !"crash" ]`, with a threshold of its own
    #[arg(long, value_name = "PROPERTY")]
    property: String,

    /// Least safety of a permitted action, from 0 to 1
    #[arg(long, value_name = "X")]
    threshold: Option<String>,

    /// The threshold is a factor of the best safety of each state
    #[arg(long, requires = "threshold")]
    relative: bool,

    /// Maximum number of states to list; files have all
    #[arg(long, value_name = "N", default_value_t = 100)]
    limit: u32,

    /// Maximum number of states of the shield
    #[arg(long, value_name = "N", default_value_t = 1_000_000)]
    states: u32,

    /// Largest width of a value; fractions decide where the bounds do not
    #[arg(long, value_name = "X", default_value_t = PRECISION, value_parser = options::precision)]
    precision: f64,

    /// Write all values to a file, as comma-separated values
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,

    /// Write the shield to this directory, for `meliora.Shield.load` in Python
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    #[command(flatten)]
    engine: EngineArgs,
    #[command(flatten)]
    shown: ShownArgs,
}

/// Runs the command.
///
/// # Errors
/// The input is wrong, or a limit is hit.
pub(super) fn run(args: ShieldArgs) -> Result<Status> {
    args.engine.validate(&args.model)?;
    let inputs: Vec<&Path> = args.model.model.paths().collect();
    let csv = Target::maybe(args.csv.as_deref(), &inputs)?;
    let report = ShieldReport::new(args.engine.header(args.model.header()));
    let (limits, shown) = (args.model.limits(), args.shown.with_csv(csv.as_ref())?);
    supervise(report, limits, &shown, move |job| work(job, &args, csv.as_ref()))
}

fn work(job: &Job<ShieldReport>, args: &ShieldArgs, csv: Option<&Target>) -> Result<()> {
    let (program, question) = job.timed("parse", || read(job, args), |r, s| r.time.add("parse", s))?;
    load::note_assumed(&program, &job.sink);
    let selected = args.engine.select(&args.model);
    job.update(|r| {
        r.header.read(&program);
        r.header.select(&selected);
        r.property = Some(question.text());
        r.name = question.expression.as_ref().map(|(name, _)| name.clone());
    });
    let settings = &engines::settings(&args.model, selected.storage, &job.sink)?;
    let answer = |job: &Job<ShieldReport>, engine: &Arc<AnyEngine>| {
        let shield = || question.answer(engine, &program, args.precision, args.states as usize);
        let found = job.timed("values", shield, |r, s| r.time.add("values", s));
        job.update(|r| r.used(engine.usage()));
        found
    };
    let early = Early::default();
    let raced = Raced { program: &program, settings, selected, lists_states: true, early, answer: &answer };
    let (shield, own) = raced.run(job)?;
    job.update(|r| r.add(&shield, &own, args.limit as usize));
    job.timed("write", || args.write(job, (&shield, &own), csv), |r, s| r.time.add("write", s))
}

/// Reads the model and the question.
fn read(job: &Job<ShieldReport>, args: &ShieldArgs) -> Result<(Arc<Program>, ShieldQuestion)> {
    let (program, named) = load::parsed(&args.model, &job.sink)?.into_parts();
    let threshold = args.threshold.as_ref().map(|text| Threshold::parse(text, args.relative)).transpose();
    let threshold = threshold.map_err(|wrong| Error::Usage(format!("`--threshold`: {wrong}")))?;
    let question = ShieldQuestion::read((&program, &named), ("--property", &args.property), threshold)?;
    Ok((Arc::new(program), question))
}

impl ShieldArgs {
    /// Writes the files that are asked for.
    fn write(
        &self,
        job: &Job<ShieldReport>,
        (shield, program): (&Shield, &Program),
        csv: Option<&Target>,
    ) -> Result<()> {
        if let Some(target) = csv {
            let mut lines = Lines::default();
            lines.push(heading(program));
            for node in &shield.nodes {
                ShieldedState::of(shield, program, node).rows().for_each(|row| lines.push(row));
            }
            target.write(&lines.text())?;
        }
        if let Some(directory) = &self.out {
            write_shield(shield, directory)?;
            job.update(|r| r.written = Some(directory.display().to_string()));
        }
        Ok(())
    }
}
