//! `meliora report`: the results of `check` as an interactive page or a picture.

use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use meliora::NamedStates;
use meliora::Task;
use meliora::commands::strategies::opponent;
use meliora::commands::{PageRun, check};
use meliora::supervise::memory;
use meliora_base::error::Error;
use meliora_engine::{Engine, SymbolicEngine};
use meliora_export::projections::{self, Plane, Projections};
use meliora_model::State;
use meliora_planning::{Analysis, Opponent, Scheduler, StrategyKind};
use meliora_quantities::Choose;
use meliora_quantities::outlook::Outlook;
use meliora_report::page::{Content, Picture, ShownRun, Written};
use meliora_report::report::Report;
use meliora_report::{CheckReport, PageReport};
use strum::{Display, IntoStaticStr};

use super::by_name::by_name;
use super::choose::validate_scheduler;
use super::engines;
use super::exit::Status;
use super::files::Target;
use super::load;
use super::options::{EngineArgs, EngineChoice, ModelArgs, PreferenceArgs, ShownArgs};
use super::supervise::{Job, supervise};

/// Write an interactive page: verdict, maps, preference order, levels, and a run step by step
///
/// The page is one file that loads nothing else. Its maps show SASI rank, SPI rank and class over
/// two variables; sliders set the other variables. Without --out the page goes to stdout, and on a
/// terminal to a new file with the name of the model.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:
  meliora report models/robot5x5.prism models/robot5x5.pref --out robot.html
  meliora report models/fleet.prism models/fleet.pref -c L=3 --grid p1,p2 --out fleet.html")]
pub(super) struct ReportArgs {
    #[command(flatten)]
    model: ModelArgs,
    #[command(flatten)]
    preferences: PreferenceArgs,

    /// File to write; - is stdout
    #[arg(short, long, value_name = "FILE", required_if_eq("json", "true"))]
    out: Option<PathBuf>,

    /// html: the page; svg: one picture; dot: the preference order
    #[arg(long, value_enum, default_value_t)]
    format: Format,

    /// Picture that `--format svg` draws [default: sasi, or hasse for models without a map]
    #[arg(long, value_parser = by_name::<Picture>())]
    picture: Option<Picture>,

    /// Variables of the maps [default: variables with names such as r and c, row and col, y
    /// and x, else the first two]
    #[arg(long, value_name = "ROW,COLUMN")]
    grid: Option<String>,

    /// State that the page shows first and where the run starts, such as r=2,c=2; variables left
    /// out have their initial value [default: the first initial state]
    #[arg(long, value_name = "STATE", allow_hyphen_values = true)]
    at: Option<String>,

    /// What the strategy of the run does; where no improvement is guaranteed, a plan makes possible ones
    /// [default: plan]
    #[arg(long, value_parser = by_name::<StrategyKind>())]
    kind: Option<StrategyKind>,

    /// Objective that `--kind achieve` achieves (`C,D`: both in one path), and that `--kind plan` pursues
    /// where it is a most preferred one
    #[arg(long, value_name = "NAME")]
    objective: Option<String>,

    /// Permitted actions that the run takes
    #[arg(long, value_parser = by_name::<Scheduler>(), default_value = Scheduler::Progress.name())]
    scheduler: Scheduler,

    /// Action of the run among the permitted ones [default: by value, likely for spi and cheap for
    /// sasi, if the model is small enough for values; else first]
    #[arg(long, value_parser = by_name::<Choose>())]
    choose: Option<Choose>,

    /// Choices of the opponent of a game in the run [default: random]
    #[arg(long, value_parser = by_name::<Opponent>())]
    opponent: Option<Opponent>,

    /// Seed of the random numbers: the same seed gives the same run
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    /// Maximum number of decision diagram nodes in the page (about 20 bytes each); a page with
    /// larger diagrams has no arrows, and if that is not enough, no sliders
    #[arg(long, value_name = "N", default_value_t = 500_000)]
    nodes: u32,

    #[command(flatten)]
    engine: EngineArgs,
    #[command(flatten)]
    shown: ShownArgs,
}

/// `--format`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum, Display, IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
enum Format {
    #[default]
    Html,
    Svg,
    Dot,
}

/// Runs the command.
///
/// # Errors
/// The input is wrong, a limit is hit, or the file cannot be written.
pub(super) fn run(args: ReportArgs) -> Result<Status, Error> {
    args.validate()?;
    let header = args.engine.header(args.preferences.header(&args.model));
    let mut report = PageReport::new(CheckReport::new(header));
    report.check.header.select(&args.engine.diagrams("maps are diagrams"));
    let (limits, shown) = (args.model.limits(), args.shown.clone());
    supervise(report, limits, &shown, move |job| work(job, &args))
}

impl ReportArgs {
    /// Returns the run that is asked for.
    fn run(&self) -> PageRun {
        let (kind, objective, scheduler) = (self.kind, self.objective.clone(), self.scheduler);
        PageRun { kind, objective, scheduler, choose: self.choose, opponent: self.opponent, seed: self.seed }
    }

    /// Returns the file of a page for which none was named; `None` where the page can go to stdout, which is
    /// not a terminal.
    fn named_after_the_model(&self) -> Option<PathBuf> {
        let stem = self.model.model.paths().last()?.file_stem()?;
        let name = format!("{}.{}", stem.to_string_lossy(), self.format);
        io::stdout().is_terminal().then(|| PathBuf::from(name))
    }

    fn validate(&self) -> Result<(), Error> {
        self.engine.validate(&self.model)?;
        if self.engine.engine == EngineChoice::Explicit {
            let message = "`report` draws its maps from decision diagrams; \
                           it cannot be used with `--engine explicit`, which has none";
            return Err(Error::Usage(message.to_owned()));
        }
        if let (Some(choose), Some(kind)) = (self.choose, self.kind)
            && !choose.fits(kind)
        {
            let (choose, kind) = (choose.name(), kind.name());
            return Err(Error::Usage(format!("`--choose {choose}` cannot be used with `--kind {kind}`")));
        }
        validate_scheduler(self.choose.unwrap_or_default(), self.scheduler)?;
        match (self.format, self.picture) {
            (Format::Svg, _) | (_, None) | (Format::Dot, Some(Picture::Hasse)) => Ok(()),
            (Format::Dot, Some(_)) => Err(Error::Usage(
                "`--format dot` draws only the preference order; use `--format svg` for maps".to_owned(),
            )),
            (format, Some(_)) => Err(Error::Usage(format!(
                "`--picture` needs `--format svg`; `--format {format}` contains all pictures"
            ))),
        }
    }
}

fn work(job: &Job<PageReport>, args: &ReportArgs) -> Result<(), Error> {
    let mut inputs = args.preferences.inputs(&args.model);
    inputs.push(Path::new(&args.model.order));
    let out = args.out.clone().or_else(|| args.named_after_the_model());
    let target = out.as_ref().map(|out| Target::new(out, &inputs)).transpose()?;
    if let Some(out) = out.as_ref().filter(|out| args.out.is_none() && out.exists()) {
        let message = format!("`{}` exists; name the file to write (`--out FILE`)", out.display());
        return Err(Error::Usage(message));
    }
    if args.shown.json && target.as_ref().is_some_and(Target::is_stdout) {
        let message = "`--json` writes to standard output; write the page to a file (`--out FILE`)";
        return Err(Error::Usage(message.to_owned()));
    }
    let read = || {
        let task = load::task(&args.model, &args.preferences, &job.sink)?;
        opponent(&task.program, args.opponent)?;
        let plane = match &args.grid {
            Some(names) => Some(Plane::named(&task.program, names)?),
            None => Plane::guess(&task.program),
        };
        let at: Vec<String> = args.at.iter().cloned().collect();
        let at = NamedStates::read(&task.program, "--at", &at)?;
        Ok((task, plane, at))
    };
    let (task, plane, at) = job.timed("parse", read, |r, s| r.check.time.add("parse", s))?;
    job.update(|r| r.check.read(&task.program, task.preferences.empty, task.preferences.history));
    let build = || engines::symbolic(&task.program, &args.model, &job.sink);
    let engine = job.timed("build", build, |r, s| r.check.time.add("build", s))?;
    let start = at.states(&*engine, &task.program, 1, &|text| job.sink.warn(text))?.pop();
    let analysis = check::analyse(job, &engine, &task, args.preferences.options())?;
    check::cycles(job, &analysis, &task.program, 1)?;
    check::by_step(job, &analysis, meliora_quantities::outlook::LISTED)?;
    let start = match start {
        Some(start) => Some(start),
        None => engine.list_states(&engine.initial_states(), 1)?.pop(),
    };
    PageWriter { job, task: &task, args, target, analysis: &analysis }.write(plane, start)
}

/// A finished analysis with the report that receives its results.
struct PageWriter<'a> {
    job: &'a Job<PageReport>,
    task: &'a Task,
    args: &'a ReportArgs,
    target: Option<Target>,
    analysis: &'a Analysis<SymbolicEngine>,
}

impl PageWriter<'_> {
    /// Draws the maps and the run, and writes the file.
    fn write(&self, plane: Option<Plane>, start: Option<State>) -> Result<(), Error> {
        let draw = || {
            let outlook = self.outlook()?;
            let plane = plane.zip(start.as_ref());
            let projections = plane.map(|(plane, start)| {
                projections::build(self.analysis, plane, start, self.args.nodes as usize)
            });
            Ok((projections.transpose()?, self.run(start.as_ref(), outlook.as_ref())?, outlook))
        };
        let (projections, run, outlook) = self.job.timed("draw", draw, |_, _| ())?;
        let text = self.text(projections.as_ref(), run.as_ref(), outlook.as_ref())?;
        let Some(target) = self.target.as_ref().filter(|t| !t.is_stdout()) else {
            self.job.update(|r| r.drawing = Some(text));
            return Ok(());
        };
        target.write(&text)?;
        let grid = projections.as_ref().map_or_else(Vec::new, |a| a.names());
        let written = Written {
            path: target.path().display().to_string(),
            format: self.args.format.into(),
            bytes: text.len() as u64,
            grid,
            nodes: projections.as_ref().map_or(0, |a| a.diagram.nodes.len() as u64),
            projected: projections.as_ref().is_some_and(|a| a.projected),
        };
        self.job.update(|r| r.written = Some(written));
        Ok(())
    }

    /// Returns the contents of the file.
    fn text(
        &self,
        projections: Option<&Projections>,
        run: Option<&ShownRun>,
        outlook: Option<&Outlook>,
    ) -> Result<String, Error> {
        let mut report = None;
        self.job.update(|r| report = Some(r.check.clone()));
        let Some(mut check) = report else { return Ok(String::new()) };
        check.finish(self.job.sink.supervisor.elapsed().as_secs_f64(), memory::peak_rss());
        let preferences = &self.task.preferences;
        let content = Content { check: &check, preferences, projections, run, outlook };
        match self.args.format {
            Format::Html => Ok(content.html()),
            Format::Dot => Ok(content.dot()),
            Format::Svg => {
                let without = if projections.is_some() { Picture::Sasi } else { Picture::Hasse };
                let picture = self.args.picture.unwrap_or(without);
                content.svg(picture).ok_or_else(|| {
                    let message = "no map can be drawn: the model needs one or two variables of suitable range; `--grid ROW,COLUMN` selects them";
                    Error::Usage(message.to_owned())
                })
            }
        }
    }

    /// Computes the outlook for a page, if all levels are known.
    fn outlook(&self) -> Result<Option<Outlook>, Error> {
        let cut = self.args.preferences.options().max_level.is_some();
        match self.args.format {
            Format::Html if !cut => Outlook::of(self.analysis, &self.task.program).map(Some),
            _ => Ok(None),
        }
    }

    /// Returns the run that a page shows. Pictures have none, and compute one to check its options only.
    fn run(&self, start: Option<&State>, outlook: Option<&Outlook>) -> Result<Option<ShownRun>, Error> {
        let args = self.args;
        let asked = args.kind.is_some() || args.objective.is_some() || args.choose.is_some();
        match start.filter(|_| asked || args.format == Format::Html) {
            Some(start) => args.run().shown(self.analysis, &self.task.program, start, outlook),
            None => Ok(None),
        }
    }
}
