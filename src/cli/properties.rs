//! `meliora reach` with several properties, from a file or from the command line.
//!
//! All reachability properties share one engine. A temporal formula has its own, with its monitors.

use std::path::PathBuf;
use std::sync::Arc;

use meliora::reach::{Asking, Under};
use meliora_engine::{Engine, Selection};
use meliora_lang::{open_constants, parse_properties, split_constants};
use meliora_model::Program;
use meliora_model::error::{Error, SourceFile};
use meliora_planning::result::ModelCounts;
use meliora_report::PropertiesReport;
use meliora_report::properties::{PropertyAnswer, Sizes};

use super::exit::Status;
use super::load::{self, Asked, Stated};
use super::options::{EngineArgs, ModelArgs, ShownArgs};
use super::supervise::{Job, supervise};

/// The arguments for a property file.
pub(super) struct Questions {
    pub(super) model: ModelArgs,
    pub(super) engine: EngineArgs,
    pub(super) file: PathBuf,
    pub(super) only: Option<String>,
    pub(super) require: Vec<String>,
    pub(super) precision: f64,
}

fn report(model: &ModelArgs, engine: EngineArgs) -> PropertiesReport {
    PropertiesReport::new(engine.header(model.header()))
}

/// Runs the command for a property file.
///
/// # Errors
/// The input is wrong, or a limit is hit.
pub(super) fn run(questions: Questions, shown: &ShownArgs) -> Result<Status, Error> {
    let mut report = report(&questions.model, questions.engine);
    report.header.file = Some(questions.file.display().to_string());
    let shown = shown.of(&questions.model);
    supervise(report, questions.model.limits(), &shown, move |job| {
        let (asked, open) = job.timed("parse", || read(job, &questions), |_, _| ())?;
        work(job, (&questions.model, questions.engine), &asked, &open, questions.precision)
    })
}

/// Runs the command for properties of the command line.
///
/// # Errors
/// The input is wrong, or a limit is hit.
pub(super) fn several(
    model: ModelArgs,
    engine: EngineArgs,
    (properties, require, precision): (Vec<String>, Vec<String>, f64),
    shown: &ShownArgs,
) -> Result<Status, Error> {
    let report = report(&model, engine);
    let (shown, limits) = (shown.of(&model), model.limits());
    supervise(report, limits, &shown, move |job| {
        let read = || load::asked(&model, None, (&properties, &require), &job.sink);
        let asked = job.timed("parse", read, |_, _| ())?;
        let open: Vec<usize> = (0..asked.questions.len()).collect();
        job.update(|r| {
            let entry = |q: &Stated| PropertyAnswer::open(None, q.text.clone(), None);
            r.properties = asked.questions.iter().map(entry).collect();
        });
        work(job, (&model, engine), &asked, &open, precision)
    })
}

/// Reads the model with the definitions of the file, the properties that can be answered, and their
/// positions in the report.
fn read(job: &Job<PropertiesReport>, questions: &Questions) -> Result<(Asked, Vec<usize>), Error> {
    let source = load::read(&questions.file)?;
    let given = SourceFile::new("--const", questions.model.constants());
    let [theirs, others] = split_constants(&given, &open_constants(&source)?)?;
    let model = questions.model.with_constants(&others.text);
    let (program, overlap) = load::program("reach", &model, &job.sink)?;
    let mut program = Arc::unwrap_or_clone(program);
    let mut stated = parse_properties(&source, &theirs, &mut program)?;
    let required = load::required(&questions.require)?;
    if let Some(only) = &questions.only {
        stated.retain(|s| s.name.as_ref() == Some(only));
        if stated.is_empty() {
            return Err(Error::Usage(format!("{} has no property with the name `{only}`", source.name)));
        }
    }
    let (mut open, mut asking) = (Vec::new(), Vec::new());
    for (position, stated) in stated.into_iter().enumerate() {
        let reason = stated.property.as_ref().err().cloned();
        let entry = PropertyAnswer::open(stated.name, stated.text.clone(), reason);
        job.update(|r| r.properties.push(entry));
        if let Ok(property) = stated.property {
            let coalition = property.coalition_in(&program, &stated.source)?;
            let asks = (&property.formula, property.question);
            let own = Asking::of(&mut program, &stated.source, asks, &required)?;
            let own = Asking { coalition, ..own };
            asking.push(Stated { text: stated.text, asking: own });
            open.push(position);
        }
    }
    Ok((Asked { program: Arc::new(program), questions: asking, overlap }, open))
}

/// Answers the reachability properties with one engine, then each formula with its own.
fn work(
    job: &Job<PropertiesReport>,
    (model, engine): (&ModelArgs, EngineArgs),
    asked: &Asked,
    open: &[usize],
    precision: f64,
) -> Result<(), Error> {
    let watched = asked.questions.iter().map(|q| q.asking.goal.program(&asked.program));
    let selected = engine.select(watched.chain([&asked.program]).map(|program| &**program), model);
    job.update(|r| {
        r.header.read(&asked.program);
        r.header.select(&selected);
    });
    let args = (model, &selected);
    let all = || asked.questions.iter().map(|q| &q.asking).zip(open.iter().copied());
    let plain: Vec<_> = all().filter(|(q, _)| q.goal.watched.is_none()).collect();
    if !plain.is_empty() || asked.questions.is_empty() {
        run_engine(job, args, asked, &asked.program, &plain, precision)?;
    }
    for question in all() {
        if let Some(watched) = &question.0.goal.watched {
            run_engine(job, args, asked, &watched.program, &[question], precision)?;
        }
    }
    Ok(())
}

fn run_engine(
    job: &Job<PropertiesReport>,
    (model, selected): (&ModelArgs, &Selection),
    asked: &Asked,
    program: &Arc<Program>,
    questions: &[(&Asking, usize)],
    precision: f64,
) -> Result<(), Error> {
    let (mut selected, asking): (_, Vec<&Asking>) =
        (selected.clone(), questions.iter().map(|q| q.0).collect());
    let build = || load::engine_for(&asking, program, model, &mut selected, &job.sink);
    let engine = job.timed("build", build, |_, _| ())?;
    job.update(|r| r.header.select(&selected));
    answer(job, &*engine, asked, questions, precision)
}

fn answer<E: Engine>(
    job: &Job<PropertiesReport>,
    engine: &E,
    asked: &Asked,
    questions: &[(&Asking, usize)],
    precision: f64,
) -> Result<(), Error> {
    let Some((first, _)) = questions.first() else {
        let all = engine.all_states();
        let counts = job.timed("count", || ModelCounts::within(engine, &all), |_, _| ())?;
        job.update(|r| r.counts = Some(counts));
        return Ok(());
    };
    let under = Under::new(engine, &asked.program, &first.goal)?;
    let counts = job.timed("count", || under.counts(&first.goal), |_, _| ())?;
    let mut known = false;
    job.update(|r| known = r.counts.is_some());
    if !known {
        load::warn_of_states(&job.sink, engine, &asked.program, &counts.deadlocks, asked.overlap)?;
        job.update(|r| (r.counts, r.escape) = (Some(counts), under.escape.clone()));
    }
    for &(asking, position) in questions {
        let played = asking.played(engine)?;
        let own =
            played.as_ref().map(|engine| Under::new(engine, &asked.program, &asking.goal)).transpose()?;
        let under = own.as_ref().unwrap_or(&under);
        let engine = under.engine();
        let found = job.timed("regions", || asking.goal.regions(engine), |_, _| ())?;
        let answer = || under.answer(asking, &asked.program, &found, precision);
        let answer = job.timed("value", answer, |_, _| ())?;
        job.update(|r| {
            r.properties[position].answer(answer.holds, answer.value, answer.no_value);
        });
        if answer.no_value.is_none() {
            answer.end?;
        }
        let found = asking.goal.restricted(engine, found)?;
        let size = |x: &E::States| engine.count(x).map(|n| Some(n.into()));
        let sizes = Sizes {
            pmax_one: size(&found.pmax_one)?,
            pmax_positive: size(&found.pmax_positive)?,
            pmin_one: size(&found.pmin_one)?,
            pmin_positive: size(&found.pmin_positive)?,
        };
        job.update(|r| {
            r.properties[position].sizes = sizes;
            r.memory.peak_nodes = r.memory.peak_nodes.max(engine.usage().peak_nodes);
        });
    }
    Ok(())
}
