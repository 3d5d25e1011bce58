//! `meliora reach --out`: the regions of questions as a dump.

use std::path::Path;

use meliora::reach::{Asking, Goal, Target};
use meliora_base::error::Error;
use meliora_dump::directory::{check_directory, sha256, write_directory};
use meliora_engine::regions::Which;
use meliora_engine::symbolic::{StateSet, SymbolicEngine};
use meliora_engine::{Algebra, Engine};
use meliora_export::questions::{Answered, Kept, export_regions};
use meliora_model::Program;
use meliora_report::WrittenRegions;

use super::asked::Asked;
use super::options::{EngineArgs, EngineChoice, ModelArgs};
use super::progress::TerminalSink;

/// The directory of the dump, checked before the work begins.
#[derive(Clone, Copy)]
pub(super) struct Regions<'a> {
    directory: &'a Path,
    model: &'a ModelArgs,
}

/// The regions that were computed for the questions, by the positions of these.
pub(super) type Found<S> = Vec<(usize, Which, S)>;

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
    pub(super) fn check(questions: &[(&Asking, &str)]) -> Result<(), Error> {
        let own = questions.iter().find(|(asking, _)| asking.goal.watched.is_some());
        let Some((_, text)) = own.filter(|_| questions.len() > 1) else { return Ok(()) };
        Err(Error::Usage(format!(
            "`--out` writes the regions of several questions only if each is to reach a target; `{text}` has a \
             monitor of its own: ask it alone"
        )))
    }

    /// Writes the regions of the questions that were answered, given by their asking, their name and their
    /// text.
    ///
    /// # Errors
    /// A limit is hit, or the directory cannot be written.
    pub(super) fn write(
        &self,
        engine: &SymbolicEngine,
        asked: &Asked,
        questions: &[(&Asking, Option<String>, String)],
        found: &Found<StateSet>,
        unsafe_states: Option<&StateSet>,
        sink: &TerminalSink,
    ) -> Result<WrittenRegions, Error> {
        let mut answered = Vec::with_capacity(questions.len());
        for (position, (asking, name, text)) in questions.iter().enumerate() {
            let own = found.iter().filter(|(at, ..)| *at == position);
            let regions = own.map(|(_, which, states)| (*which, states.clone())).collect();
            let target = target(engine, &asking.goal)?;
            let (name, text, coalition) = (name.clone(), text.clone(), asking.coalition.clone());
            answered.push(Answered { name, text, target, regions, coalition });
        }
        let first = questions.first().map(|(asking, ..)| &asking.goal);
        let requirements = first.map_or(&[][..], |goal| &goal.requirements);
        let path = (self.model.path(), source_hash(&asked.program));
        let kept = Kept { requirements, unsafe_states };
        let dump = export_regions(engine, path, &kept, answered)?;
        let manifest = write_directory(dump, self.directory, false, sink)?;
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
