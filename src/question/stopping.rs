//! Questions whose paths stop where they are decided.

use std::ops::Range;
use std::sync::Arc;

use crate::asking::{Asking, Form, only_query};
use crate::goal::PathGoal;
use crate::list;
use crate::plan::{Plan, Planner};
use meliora_base::error::{Diagnostic, Result, Severity, SourceFile};
use meliora_lang::ltl::{self, Formula, Stopped};
use meliora_lang::named::Property;
use meliora_lang::property::{Named, Term};
use meliora_lang::{parse_expression, parse_property};
use meliora_model::Program;

/// A question, and the program in which the states that decide it are not left: the states behind these
/// are neither explored nor counted. In the initial states, the answer is that for the whole program.
pub struct Stopping {
    /// The program of the question.
    pub program: Program,
    /// The question.
    pub asking: Asking,
}

impl Stopping {
    /// Reads a target such as `x = 3`.
    ///
    /// # Errors
    /// The text is wrong; each error has its place.
    pub fn target(program: &Program, source: &Arc<SourceFile>) -> Result<Self> {
        Stopping::of(program, source, &Formula::reaching(parse_expression(source)?))
    }

    /// Reads a target `x = 3`, a formula `F x = 3`, or a property `P>=1 [ F x = 3 ]`.
    ///
    /// # Errors
    /// The text is none of these, or no state decides the formula; each error has its place.
    pub fn parse(program: &Program, source: &Arc<SourceFile>) -> Result<Self> {
        match Form::of(source) {
            Form::Target => Stopping::target(program, source),
            Form::Property => {
                let term = parse_property(source)?.term(program, source, &Named::default())?;
                let (program, term) = stopped(program, (source, term.span.range()), term)?;
                let asking = Asking::query(&program, source, &only_query(&program, source, &term)?, &[])?;
                Ok(Stopping { program, asking })
            }
            Form::Formula => Stopping::of(program, source, &ltl::parse_formula(source)?),
        }
    }

    /// Reads a property, or the name of one of those that the model names; errors call a text `name`. Returns the
    /// program and the plan for the property over it.
    ///
    /// # Errors
    /// The text is wrong, the property is not about a single formula in the initial states, or no state decides this.
    pub fn property(
        (program, named): (&Program, &[Property]),
        (name, text): (&str, &str),
    ) -> Result<(Program, Plan)> {
        let (source, term) = list::stated(program, named, (name, text))?;
        let range = if named.iter().any(|own| own.name == text) { 0..0 } else { term.span.range() };
        let (program, term) = stopped(program, (&source, range), term)?;
        // The regions of a formula with bounds are reported, too.
        let mut planner = Planner::new(&program, &[], true)?;
        planner.add(0, text, &source, term)?;
        let plan = planner.finish();
        Ok((program, plan))
    }

    fn of(program: &Program, source: &Arc<SourceFile>, formula: &Formula) -> Result<Self> {
        let Stopped { program, formula } = Stopped::new(program, source, formula)?;
        let asking = PathGoal::of(&program, source, &formula, &[])?.into();
        Ok(Stopping { program, asking })
    }
}

/// Returns the program in which the states that decide a property are not left, and the property over it.
///
/// # Errors
/// The property, at this place of the text, is not about a single formula in the initial states, or no state decides this.
fn stopped(
    program: &Program,
    (source, place): (&Arc<SourceFile>, Range<usize>),
    term: Term,
) -> Result<(Program, Term)> {
    if let Some(stopped) = term.stopped(program, source)? {
        return Ok(stopped);
    }
    let message = "paths stop only for one formula in the initial states, and this property asks for more";
    let wrong = Diagnostic::new(source, place, message).severity(Severity::Unsupported);
    Err(wrong.help("leave out `--stop-at-target`").into())
}
