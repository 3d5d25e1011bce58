//! `meliora reach`: the four qualitative regions of a target, or of a temporal formula.

use std::path::{Path, PathBuf};

use clap::Args;
use meliora::reach::{Asking, Target, Under};
use meliora_engine::{Count, Engine, Scope};
use meliora_model::error::Error;
use meliora_quantities::answer::{Answer, PRECISION};
use meliora_report::reach::Share;
use meliora_report::{Number, ReachReport};

use super::engines;
use super::exit::Status;
use super::load::{self, Asked, Stated};
use super::options::{EngineArgs, ModelArgs, ShownArgs};
use super::progress::TerminalSink;
use super::properties::{self, Several};
use super::regions::{self, Regions};
use super::supervise::{Job, supervise};
use super::sweep::{self, SweepArgs};

/// Compute from which states a target is reached, or a temporal formula satisfied, surely or
/// possibly
#[derive(Debug, Clone, Args)]
#[command(group = clap::ArgGroup::new("question"))]
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
    engine: EngineArgs,
    #[command(flatten)]
    sweep: SweepArgs,
    #[command(flatten)]
    shown: ShownArgs,
}

impl ReachArgs {
    /// Returns what the rows of a sweep contain, given the constants of the first and the last instance.
    fn rows(&self, ends: [&str; 2]) -> Result<sweep::Job, Error> {
        if self.out.is_some() {
            let message = "`--out` writes the regions of one instance; a sweep has several";
            return Err(Error::Usage(message.to_owned()));
        }
        let properties = match &self.properties {
            Some(file) => properties::titles(file, self.only.as_deref(), ends[0])?,
            None if self.all_properties => load::names(&self.model, ends[0])?,
            None => self.property.clone(),
        };
        load::check_each(&self.model, ends, |loaded| match &self.properties {
            Some(file) => properties::check(file, loaded.program),
            // The model names them, and each has its own reason if it is not answered.
            None if self.all_properties => Ok(()),
            None => loaded.questions(self.target.as_deref(), (&self.property, &self.require)).map(drop),
        })?;
        Ok(sweep::Job::Reach { regions: self.target.is_some() || self.property.len() == 1, properties })
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

    /// Reads the model and the question.
    fn asked(&self, sink: &TerminalSink) -> Result<Asked, Error> {
        let target = self.target.as_deref();
        match self.stop_at_target {
            true => load::stopping(&self.model, (target, self.property.first().map(String::as_str)), sink),
            false => load::asked(&self.model, target, (&self.property, &self.require), sink),
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
    args.check_stop()?;
    let inputs: Vec<&Path> = args.properties.iter().map(PathBuf::as_path).collect();
    args.regions()?;
    if let Some(status) = args.sweep.run(&args.model, &inputs, |first| args.rows(first), &args.shown)? {
        return Ok(status);
    }
    if let Some(file) = args.properties {
        let ReachArgs { model, engine, only, require, precision, out, shown, .. } = args;
        let questions = properties::Questions { model, engine, file, only, require, precision, out };
        return properties::run(questions, &shown);
    }
    if args.property.len() > 1 || args.all_properties {
        let ReachArgs { model, engine, property, all_properties, require, precision, out, shown, .. } = args;
        let asked = if all_properties { Several::Named } else { Several::Texts(property) };
        return properties::several((model, engine, out), (asked, require, precision), &shown);
    }
    let asked = args.target.as_ref().or(args.property.first()).cloned().unwrap_or_default();
    let header = args.engine.header(args.model.header());
    let mut report = ReachReport::of_expression(header, &asked);
    report.stops_at_target = args.stop_at_target;
    let (limits, shown) = (args.model.limits(), args.shown.of(&args.model));
    supervise(report, limits, &shown, move |job| work(job, &args))
}

fn work(job: &Job<ReachReport>, args: &ReachArgs) -> Result<(), Error> {
    let asked = job.timed("parse", || args.asked(&job.sink), |r, s| r.time.add("parse", s))?;
    let Some(Stated { asking, text }) = asked.questions.first() else { return Ok(()) };
    let program = asking.goal.program(&asked.program);
    let out = args.regions()?;
    let mut selected = match out {
        Some(_) => args.engine.diagrams("`--out` writes diagrams"),
        None => args.engine.select([&**program], &args.model),
    };
    job.update(|r| {
        r.header.read(&asked.program);
        r.header.select(&selected);
    });
    let Some(out) = out else {
        let build =
            || engines::engine_for(program, &args.model, &mut selected, asking.asks_for_number(), &job.sink);
        let engine = job.timed("build", build, |r, s| r.time.add("build", s))?;
        job.update(|r| r.header.select(&selected));
        refuse_open(&*engine, &asked, asking)?;
        return answer(job, &*engine, &asked, asking, args.precision).map(drop);
    };
    let build = || engines::symbolic(program, &args.model, &job.sink);
    let engine = job.timed("build", build, |r, s| r.time.add("build", s))?;
    refuse_open(&*engine, &asked, asking)?;
    let (found, unsafe_states) = answer(job, &*engine, &asked, asking, args.precision)?;
    let questions = [(asking, None, text.clone())];
    let write = || out.write((&engine, &asked), &questions, &found, unsafe_states.as_ref(), &job.sink);
    let written = job.timed("write", write, |_, _| ())?;
    job.update(|r| r.written = Some(written));
    Ok(())
}

/// Refuses a question that has no meaning for the initial states of the model.
///
/// # Errors
/// The question has no meaning; a limit is hit.
fn refuse_open<E: Engine>(engine: &E, asked: &Asked, asking: &Asking) -> Result<(), Error> {
    match asking.refused(engine)? {
        Some(reason) => Err(load::not_answered(&asked.questions[0].text, &reason)),
        None => Ok(()),
    }
}

/// Computes the regions that the question needs. Each is added to the report as soon as it is known. Returns
/// them within the states that are judged, and the unsafe states under requirements.
fn answer<E: Engine>(
    job: &Job<ReachReport>,
    engine: &E,
    asked: &Asked,
    asking: &Asking,
    precision: f64,
) -> Result<regions::WithUnsafe<E::States>, Error> {
    let played = asking.played(engine)?;
    let engine = played.as_ref().unwrap_or(engine);
    let under = Under::new(engine, &asked.program, &asking.goal)?;
    // Counting is a part of building.
    let count = || under.counts(&asking.goal);
    let counts = job.timed("count", count, |r, s| r.time.add("build", s))?;
    engines::warn_of_states(&job.sink, engine, &asked.program, &counts.deadlocks, asked.overlap.as_ref())?;
    job.update(|r| (r.counts, r.escape) = (Some(counts), under.escape.clone()));
    let engine = under.engine();
    let (mut search, judged) = (asking.goal.search(engine)?, asking.goal.judged(engine)?);
    if matches!(asking.goal.target, Target::States(_)) {
        // The goal has states with monitors that are not fresh, which stand for the same model state.
        let own = engine.intersection(&engine.all_states(), &judged)?;
        let size = engine.count(&engine.intersection(&search.goal()?, &own)?)?;
        if size == Count::ZERO {
            job.sink.warn("no state satisfies the target");
        }
        job.update(|r| r.target = Some(size.into()));
    }
    if asking.question.is_some() {
        job.update(|r| r.answer(&Answer::of(None)));
    }
    let mut kept = Vec::new();
    for which in search.order(&asking.needed(&asked.program)) {
        let start = job.begin(which.formula());
        let states = search.region(which)?;
        job.end(which.formula(), start, |r, s| r.time.add(which.name(), s));
        let inside = engine.intersection(&states, &judged)?;
        let found = Found::of(engine, &inside)?;
        kept.push((0, which, inside));
        let decided = under.decided(asking, &asked.program, search.known())?;
        job.update(|r| {
            *r.sizes.get_mut(which) = Some(found.size);
            *r.initial.get_mut(which) = Some(found.share);
            r.memory.peak_nodes = engine.usage().peak_nodes;
            if asking.question.is_some() {
                r.answer(&decided);
            }
        });
    }
    let found = (kept, under.unsafe_states().cloned());
    if asking.question.is_none() {
        return Ok(found);
    }
    let answered = || under.answer(asking, &asked.program, search.known(), precision);
    let answer = job.timed("value", answered, |r, s| r.time.add("value", s))?;
    job.update(|r| r.answer(&answer));
    answer.end.map(|()| found)
}

/// The size of a region, and its share of the initial states.
struct Found {
    size: Number,
    share: Share,
}

impl Found {
    fn of<E: Engine>(engine: &E, states: &E::States) -> Result<Self, Error> {
        let size = engine.count(states)?.into();
        let share = Share::of_initial(engine, states)?;
        Ok(Found { size, share })
    }
}
