//! `meliora reach --properties FILE`: all qualitative properties of a file, with one engine.

use std::path::PathBuf;
use std::sync::Arc;

use meliora::engine::Engine;
use meliora::engine::regions;
use meliora::error::Error;
use meliora::lang::property_file::Stated;
use meliora::lang::{lower_target, parse_properties};
use meliora::model::Program;
use meliora::model::expr::ExprId;
use meliora::output::PropertiesReport;
use meliora::output::properties::PropertyAnswer;
use meliora::output::report::{Counts, ModelSummary};

use super::exit::Status;
use super::load;
use super::options::{EngineArgs, ModelArgs, ShownArgs};
use super::reach::satisfying;
use super::supervise::{Desk, supervise};

/// What is asked of which model.
pub(super) struct Asked {
    pub(super) model: ModelArgs,
    pub(super) engine: EngineArgs,
    pub(super) file: PathBuf,
    pub(super) only: Option<String>,
}

/// Runs the command.
///
/// # Errors
/// The input is wrong.
pub(super) fn run(asked: Asked, shown: &ShownArgs) -> Result<Status, Error> {
    let file = asked.file.display().to_string();
    let (engine, scope) = (asked.engine.engine.name(), asked.model.scope.into());
    let report = PropertiesReport::new(&asked.model.path(), &file, engine, scope);
    let shown = shown.of(&asked.model);
    supervise(report, asked.model.timeout, &shown, move |desk| work(desk, &asked))
}

/// A property that can be answered: its position in the report, and its target.
type Open = (usize, Stated, ExprId);

fn work(desk: &Desk<PropertiesReport>, asked: &Asked) -> Result<(), Error> {
    let read = || read(desk, asked);
    let (program, open, overlap) = desk.timed("parse", read, |_, _| ())?;
    desk.update(|r| r.model = ModelSummary::of(&asked.model.path(), &program));
    let build = || load::engine(&program, &asked.model, asked.engine.engine, &desk.watch);
    let engine = desk.timed("build", build, |_, _| ())?;
    answer(desk, &engine, &program, overlap, &open)
}

/// The model with what the file defines, and the properties that can be answered.
#[allow(clippy::type_complexity, reason = "three results of one reading")]
fn read(
    desk: &Desk<PropertiesReport>,
    asked: &Asked,
) -> Result<(Arc<Program>, Vec<Open>, Option<ExprId>), Error> {
    let (program, overlap) = load::program(&asked.model, &desk.watch)?;
    let mut program = Arc::unwrap_or_clone(program);
    let source = load::read(&asked.file)?;
    let mut stated = parse_properties(&source, &mut program)?;
    if let Some(only) = &asked.only {
        stated.retain(|s| s.name.as_ref() == Some(only));
        if stated.is_empty() {
            return Err(Error::Usage(format!("no property of {} is called `{only}`", source.name)));
        }
    }
    let mut open = Vec::new();
    for (position, stated) in stated.into_iter().enumerate() {
        let reason = stated.property.as_ref().err().cloned();
        let entry = PropertyAnswer::open(stated.name.clone(), stated.text.clone(), reason);
        desk.update(|r| r.properties.push(entry));
        if let Ok(property) = &stated.property {
            let target = lower_target(&mut program, &stated.source, &property.target)?;
            open.push((position, stated, target));
        }
    }
    Ok((Arc::new(program), open, overlap))
}

fn answer<E: Engine>(
    desk: &Desk<PropertiesReport>,
    engine: &E,
    program: &Program,
    overlap: Option<ExprId>,
    open: &[Open],
) -> Result<(), Error> {
    let counts = desk.timed("count", || Counts::of(engine), |_, _| ())?;
    load::warn_of_states(&desk.watch, engine, program, &counts.deadlocks.0, overlap)?;
    desk.update(|r| r.counts = Some(counts));
    let initial = engine.initial_states();
    for (position, stated, target) in open {
        let Ok(property) = &stated.property else { continue };
        let states = engine.states_where(*target)?;
        let found = desk.timed("regions", || regions::regions(engine, &states), |_, _| ())?;
        let size = |x: &E::States| engine.count_states(x).map(|n| Some(n.into()));
        let (pmax_one, pmax_positive) = (size(&found.pmax_one)?, size(&found.pmax_positive)?);
        let (pmin_one, pmin_positive) = (size(&found.pmin_one)?, size(&found.pmin_positive)?);
        let satisfying = satisfying(engine, (property.strategies, property.bound), found)?;
        let holds = engine.is_empty(&engine.difference(&initial, &satisfying)?);
        desk.update(|r| {
            let answer = &mut r.properties[*position];
            (answer.pmax_one, answer.pmax_positive) = (pmax_one, pmax_positive);
            (answer.pmin_one, answer.pmin_positive) = (pmin_one, pmin_positive);
            answer.holds = Some(holds);
            r.memory.peak_nodes = engine.usage().peak_nodes;
        });
    }
    Ok(())
}
