//! Questions whose paths stop where they are decided.

use std::sync::Arc;

use super::asking::{Form, simple};
use super::{Asking, Goal};
use meliora_base::error::{Result, SourceFile};
use meliora_lang::ltl::{self, Formula, Stopped};
use meliora_lang::named;
use meliora_lang::parse_expression;
use meliora_lang::property::{Over, Simple};
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
        Stopping::formula(program, source, &Formula::reaching(parse_expression(source)?))
    }

    fn formula(program: &Program, source: &Arc<SourceFile>, formula: &Formula) -> Result<Self> {
        let Stopped { program, formula } = Stopped::new(program, source, formula)?;
        let goal = Goal::of(&program, source, &formula, &[])?;
        Ok(Stopping {
            program,
            asking: Asking { goal, question: None, wrong: None, coalition: None, over: Over::All },
        })
    }

    /// Reads a target `x = 3`, a formula `F x = 3`, or a property `P>=1 [ F x = 3 ]`.
    ///
    /// # Errors
    /// The text is none of these, or no state decides the formula; each error has its place.
    pub fn parse(program: &Program, source: &Arc<SourceFile>) -> Result<Self> {
        match Form::of(source) {
            Form::Target => Stopping::target(program, source),
            Form::Property => Stopping::property(program, source),
            Form::Formula => Stopping::formula(program, source, &ltl::parse_formula(source)?),
        }
    }

    /// Reads a property such as `P>=1 [ F x = 3 ]`.
    ///
    /// # Errors
    /// The text is wrong, or no state decides the formula; each error has its place.
    pub fn property(program: &Program, source: &Arc<SourceFile>) -> Result<Self> {
        let simple = simple(program, source)?;
        let Stopped { program, formula } = Stopped::new(program, source, &simple.formula)?;
        let asking = Asking::of_simple(&program, source, &Simple { formula, ..simple }, &[])?;
        Ok(Stopping { program, asking })
    }

    /// Takes a property that the model names.
    ///
    /// # Errors
    /// The formula is not decided by a state.
    pub fn named(program: &Program, asked: named::Asked) -> Result<Self> {
        let source = Arc::clone(&program.source);
        let Stopped { program, formula } = Stopped::new(program, &source, &asked.formula)?;
        let asking = Asking::named(&program, named::Asked { formula, ..asked }, &[])?;
        Ok(Stopping { program, asking })
    }
}
