//! `meliora reach --out`: the regions of questions as a dump.

use std::path::Path;

use meliora_base::error::Error;
use meliora_dump::directory::{check_directory, sha256, write_directory};
use meliora_engine::symbolic::{StateSet, SymbolicEngine};
use meliora_engine::{Algebra, Engine};
use meliora_export::questions::{Answered, Kept, export_regions};
use meliora_model::Program;
use meliora_question::regions::{Computed, Part};
use meliora_question::{Goal, Questions, Target};
use meliora_report::{ReachReport, WrittenRegions};

use super::options::{EngineArgs, EngineChoice, ModelArgs};
use super::supervise::Job;

/// The directory of the dump, checked before the work begins.
#[derive(Clone, Copy)]
pub(super) struct Regions<'a> {
    directory: &'a Path,
    model: &'a ModelArgs,
}

/// The region of the states that satisfy a condition.
const SATISFIED: &str = "satisfied";

impl<'a> Regions<'a> {
    /// Checks the directory, and that the engine has diagrams.
    ///
    /// # Errors
    /// [`Error::Usage`]; the directory contains something else than a dump.
    pub(super) fn new(directory: &'a Path, model: &'a ModelArgs, engine: EngineArgs) -> Result<Self, Error> {
        let wrong = if directory.as_os_str() == "-" {
            "a dump is a directory; it cannot be written to standard output"
        } else if engine.engine == EngineChoice::Explicit {
            "`--out` writes decision diagrams; it cannot be used with `--engine explicit`, which has none"
        } else {
            check_directory(directory)?;
            return Ok(Regions { directory, model });
        };
        Err(Error::Usage(wrong.to_owned()))
    }

    /// Checks that one model has all questions: a temporal formula has monitors of its own.
    ///
    /// # Errors
    /// [`Error::Usage`] with the text of the first question that needs another model.
    pub(super) fn check(asked: &Questions) -> Result<(), Error> {
        let plan = &asked.plan;
        let own = plan.requests.iter().find(|request| request.asking.goal.watched.is_some());
        let Some(own) = own.filter(|_| plan.properties.len() > 1) else { return Ok(()) };
        let text = &plan.properties[own.properties[0]].text;
        Err(Error::Usage(format!(
            "`--out` writes the regions of several questions only if each is to reach a target; `{text}` has a \
             monitor of its own: ask it alone"
        )))
    }

    /// Writes the regions of the questions that were answered.
    ///
    /// # Errors
    /// A limit is hit, or the directory cannot be written.
    pub(super) fn write(
        &self,
        job: &Job<ReachReport>,
        asked: &Questions,
        computed: Computed,
    ) -> Result<WrittenRegions, Error> {
        let Computed { engine, mut parts, regions: found, unsafe_states } = computed;
        let mut answered = Vec::with_capacity(parts.len());
        parts.sort_by_key(|(property, _)| asked.plan.properties[*property].position);
        for (property, part) in parts {
            let position = asked.plan.properties[property].position;
            let (mut name, mut text) = Default::default();
            job.update(|r| {
                (name, text) = (r.properties[position].name.clone(), r.properties[position].property.clone());
            });
            let (target, regions, coalition) = match part {
                Part::Satisfied(states) => (None, vec![(SATISFIED, states)], None),
                Part::Paths(request) => {
                    let asking = &asked.plan.requests[request].asking;
                    let own = found.iter().filter(|(at, ..)| *at == request);
                    let regions = own.map(|(_, which, states)| (which.name(), states.clone())).collect();
                    (target(&engine, &asking.goal)?, regions, asking.coalition.clone())
                }
            };
            answered.push(Answered { number: position + 1, name, text, target, regions, coalition });
        }
        let first = asked.plan.requests.first().map(|request| &request.asking.goal);
        let requirements = first.map_or(&[][..], |goal| &goal.requirements);
        let path = (self.model.path(), source_hash(&asked.program));
        let kept = Kept { requirements, unsafe_states: unsafe_states.as_ref() };
        let dump = export_regions(&engine, path, &kept, answered)?;
        let manifest = write_directory(dump, self.directory, false, &*job.sink)?;
        Ok(WrittenRegions::new(&self.directory.display().to_string(), &manifest))
    }
}

fn source_hash(program: &Program) -> String {
    sha256(program.source.original().as_bytes())
}

/// Returns the states of a target whose paths are judged; `None` for a temporal formula.
fn target(engine: &SymbolicEngine, goal: &Goal) -> Result<Option<StateSet>, Error> {
    let Target::States(target) = &goal.target else { return Ok(None) };
    let judged = engine.intersection(&engine.all_states(), &goal.judged(engine)?)?;
    Ok(Some(engine.intersection(&engine.states_where(target)?, &judged)?))
}
