//! The regions of questions as a dump, as `meliora reach --out` writes them.

use std::path::Path;

use super::Work;
use meliora_base::error::{Error, Result};
use meliora_dump::directory::{sha256, write_directory};
use meliora_engine::symbolic::{StateSet, SymbolicEngine};
use meliora_engine::{Algebra, Engine};
use meliora_export::questions::{Answered, Kept, export_regions};
use meliora_question::regions::{Computed, Part};
use meliora_question::{PathGoal, Questions, Target};
use meliora_report::{ReachReport, WrittenRegions};

/// The region of the states that satisfy a condition.
const SATISFIED: &str = "satisfied";

/// Checks that one model has all questions: a temporal formula has monitors of its own.
///
/// # Errors
/// [`Error::Usage`] with the text of the first question that needs another model.
pub fn check(asked: &Questions) -> Result<()> {
    let plan = &asked.plan;
    let own = plan.requests.iter().find(|request| request.asking.goal.watched.is_some());
    let Some(own) = own.filter(|_| plan.properties.len() > 1) else { return Ok(()) };
    let text = &plan.properties[own.properties[0]].text;
    Err(Error::Usage(format!(
        "`--out` writes the regions of several questions only if each is to reach a target; `{text}` has a \
         monitor of its own: ask it alone"
    )))
}

/// Writes the regions of the questions that were answered into a directory; `model` is the name of its file. An older
/// dump there is replaced. Cost: see [`export_regions`].
///
/// # Errors
/// A limit is hit, or the directory cannot be written.
pub fn write(
    work: &dyn Work<ReachReport>,
    asked: &Questions,
    computed: Computed,
    model: String,
    directory: &Path,
) -> Result<WrittenRegions> {
    let Computed { engine, mut parts, regions: found, unsafe_states } = computed;
    let mut answered = Vec::with_capacity(parts.len());
    parts.sort_by_key(|(property, _)| asked.plan.properties[*property].position);
    for (property, part) in parts {
        let position = asked.plan.properties[property].position;
        let (mut name, mut text) = Default::default();
        work.update(|r| {
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
    let hash = sha256(asked.program.source.original().as_bytes());
    let kept = Kept { requirements, unsafe_states: unsafe_states.as_ref() };
    let dump = export_regions(&engine, (model, hash), &kept, answered)?;
    let manifest = write_directory(dump, directory, false, &*work.sink())?;
    Ok(WrittenRegions::new(&directory.display().to_string(), &manifest))
}

/// Returns the states of a target whose paths are judged; `None` for a temporal formula.
fn target(engine: &SymbolicEngine, goal: &PathGoal) -> Result<Option<StateSet>> {
    let Target::States(target) = &goal.target else { return Ok(None) };
    let judged = engine.intersection(&engine.all_states(), &goal.judged(engine)?)?;
    Ok(Some(engine.intersection(&engine.states_where(target)?, &judged)?))
}
