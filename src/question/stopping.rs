//! Questions whose paths stop where they are decided.

use std::sync::Arc;

use crate::asking::{Asking, Form, only_query};
use crate::goal::PathGoal;
use crate::list;
use meliora_base::error::{Diagnostic, Result, Severity, SourceFile};
use meliora_lang::ltl::{self, Formula, Stopped};
use meliora_lang::named::Property;
use meliora_lang::property::{Named, Query};
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
        Stopping::of(program, source, &Formula::reaching(parse_expression(source)?), None)
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
                Stopping::query(program, source, &only_query(program, source, &term)?)
            }
            Form::Formula => Stopping::of(program, source, &ltl::parse_formula(source)?, None),
        }
    }

    /// Reads a property, or the name of one of those that the model names; errors call a text `name`.
    ///
    /// # Errors
    /// The text is wrong, the property is not about a single formula, or no state decides this.
    pub fn property((program, named): (&Program, &[Property]), (name, text): (&str, &str)) -> Result<Self> {
        let (source, term) = list::stated(program, named, (name, text))?;
        if let Some(query) = term.query(program) {
            return Stopping::query(program, &source, &query);
        }
        let message = "paths stop where the probability or the reward of one formula is decided, and this property \
                       asks for more";
        let range = if named.iter().any(|own| own.name == text) { 0..0 } else { term.span.range() };
        let wrong = Diagnostic::new(&source, range, message).severity(Severity::Unsupported);
        Err(wrong.help("leave out `--stop-at-target`").into())
    }

    /// Returns the question of a query.
    ///
    /// # Errors
    /// No state decides the formula.
    pub fn query(program: &Program, source: &Arc<SourceFile>, query: &Query<'_>) -> Result<Self> {
        Stopping::of(&query.path.over(program), source, &query.path.formula, Some(query))
    }

    fn of(
        program: &Program,
        source: &Arc<SourceFile>,
        formula: &Formula,
        query: Option<&Query<'_>>,
    ) -> Result<Self> {
        let Stopped { program, formula } = Stopped::new(program, source, formula)?;
        let goal = PathGoal::of(&program, source, &formula, &[])?;
        let asking = match query {
            Some(query) => Asking::of(goal, query),
            None => goal.into(),
        };
        Ok(Stopping { program, asking })
    }
}
