//! Questions as texts, and their goals.

use std::sync::Arc;

use super::{Goal, Required, Target};
use meliora_base::error::{Diagnostic, Result, Severity, SourceFile};
use meliora_engine::Engine;
use meliora_engine::regions::Which;
use meliora_lang::ltl::{self, Formula};
use meliora_lang::named;
use meliora_lang::property::{Measure, Named, Over, Question, Simple};
use meliora_lang::{lower_target, parse_expression, parse_property};
use meliora_model::Program;
use meliora_model::predicate::Predicate;
use meliora_quantities::answer;

/// The operators with which a property begins, also those that are not supported.
const OPERATORS: [&str; 12] =
    ["P", "Pmin", "Pmax", "R", "Rmin", "Rmax", "S", "Smin", "Smax", "E", "A", "multi"];

/// A question about the paths of a model.
pub struct Asking {
    /// The goal of the paths.
    pub goal: Goal,
    /// The question of a property, for the initial states.
    pub question: Option<Question>,
    /// The states in which the rewards that the question names are wrong.
    pub wrong: Option<Predicate>,
    /// For a property of a game, whether each player chooses to make it true.
    pub coalition: Option<Vec<bool>>,
    /// The part of the initial states that the question is about.
    pub over: Over,
}

impl Asking {
    /// Reads a target such as `x = 3`.
    ///
    /// # Errors
    /// The text or a requirement is wrong; each error has its place.
    pub fn target(program: &Program, source: &Arc<SourceFile>, required: &[Required]) -> Result<Self> {
        Asking::states(program, lower_target(program, source, &parse_expression(source)?)?, required)
    }

    /// Asks for reaching some states.
    ///
    /// # Errors
    /// A requirement is wrong; each error has its place.
    pub fn states(program: &Program, target: Predicate, required: &[Required]) -> Result<Self> {
        Ok(Asking {
            goal: Goal::reach(program, target, required)?,
            question: None,
            wrong: None,
            coalition: None,
            over: Over::All,
        })
    }

    /// Reads a property such as `P>=1 [ F x = 3 ]`.
    ///
    /// # Errors
    /// The text or a requirement is wrong, or not supported; each error has its place.
    pub fn property(program: &Program, source: &Arc<SourceFile>, required: &[Required]) -> Result<Self> {
        Asking::of_simple(program, source, &simple(program, source)?, required)
    }

    /// Returns the question of a property.
    ///
    /// # Errors
    /// The errors of [`Asking::of`].
    pub fn of_simple(
        program: &Program,
        source: &Arc<SourceFile>,
        simple: &Simple,
        required: &[Required],
    ) -> Result<Self> {
        let coalition = simple.coalition.clone();
        Ok(Asking {
            coalition,
            ..Asking::of(program, source, &simple.formula, simple.question.clone(), required)?
        })
    }

    /// Returns the engine of a game in which the coalition of the question is ours; `None` if that is the
    /// coalition of the engine.
    ///
    /// # Errors
    /// A limit is reached.
    pub fn played<E: Engine>(&self, engine: &E) -> Result<Option<E>> {
        let other = self.coalition.as_ref().filter(|coalition| **coalition != engine.coalition());
        other.map(|coalition| engine.with_coalition(coalition)).transpose()
    }

    /// Combines a formula and a question about it.
    ///
    /// # Errors
    /// The formula or a requirement is wrong, or not supported.
    pub fn of(
        program: &Program,
        source: &Arc<SourceFile>,
        formula: &Formula,
        question: Question,
        required: &[Required],
    ) -> Result<Self> {
        let wrong = wrong_rewards(program, &question);
        let (goal, question) = (Goal::of(program, source, formula, required)?, Some(question));
        Ok(Asking { goal, question, wrong, coalition: None, over: Over::All })
    }

    /// Returns the question of a property that the model names.
    ///
    /// # Errors
    /// The errors of [`Asking::of`].
    pub fn named(program: &Program, asked: named::Asked, required: &[Required]) -> Result<Self> {
        let source = Arc::clone(&program.source);
        let asking = Asking::of(program, &source, &asked.formula, asked.question, required)?;
        Ok(Asking { over: asked.over, ..asking })
    }

    /// Returns whether the answer is a number, or depends on one.
    pub fn asks_for_number(&self) -> bool {
        matches!(self.question, Some(Question::Quantity(_)))
    }

    /// Returns the regions that the question needs, for a program of the goal.
    pub fn needed(&self, model: &Arc<Program>) -> Vec<Which> {
        answer::needed(self.question.as_ref(), self.goal.program(model))
    }

    /// Returns the question over the program of the goal.
    pub(super) fn asked<'a>(&'a self, model: &'a Arc<Program>) -> answer::Asked<'a> {
        let (target, condition) = match &self.goal.target {
            Target::States(target) => (Some(target), None),
            Target::Formula(condition) => (None, Some(condition)),
        };
        let program = &**self.goal.program(model);
        let (question, wrong) = (self.question.as_ref(), self.wrong.as_ref());
        answer::Asked { program, question, over: self.over, target, condition, wrong }
    }

    /// Reads a target `x = 3`, a formula `F x = 3`, or a property `P>=1 [ F x = 3 ]`.
    ///
    /// # Errors
    /// The text is none of these, or not supported; each error has its place.
    pub fn parse(program: &Program, source: &Arc<SourceFile>) -> Result<Self> {
        match Form::of(source) {
            Form::Target => Asking::target(program, source, &[]),
            Form::Property => Asking::property(program, source, &[]),
            Form::Formula => {
                let goal = Goal::of(program, source, &ltl::parse_formula(source)?, &[])?;
                Ok(Asking { goal, question: None, wrong: None, coalition: None, over: Over::All })
            }
        }
    }
}

/// Reads a property that is one operator over a formula without other operators.
///
/// # Errors
/// The text is wrong, or another property.
pub(super) fn simple(program: &Program, source: &Arc<SourceFile>) -> Result<Simple> {
    let property = parse_property(source)?;
    if let Some(simple) = property.simple(program, source)? {
        return Ok(simple);
    }
    property.term(program, source, &Named::default())?;
    let message = "only one operator over a formula without other operators is supported here";
    let diagnostic = Diagnostic::new(source, 0..source.text.len(), message).severity(Severity::Unsupported);
    Err(diagnostic.help("`meliora reach --property` answers all properties").into())
}

/// The form of a question.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    /// `x = 3`
    Target,
    /// `P>=1 [ F x = 3 ]`
    Property,
    /// `F x = 3`
    Formula,
}

impl Form {
    pub(super) fn of(source: &Arc<SourceFile>) -> Self {
        if parse_expression(source).is_ok() {
            return Form::Target;
        }
        let text = source.text.trim_start();
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        let first = text.split(|c| !is_word(c)).next().unwrap_or_default();
        let is_filter = first == "filter" && text[first.len()..].trim_start().starts_with('(');
        if is_filter || text.starts_with("<<") || OPERATORS.contains(&first) {
            Form::Property
        } else {
            Form::Formula
        }
    }
}

/// Returns the states in which the rewards that a question names are wrong.
fn wrong_rewards(program: &Program, question: &Question) -> Option<Predicate> {
    let Question::Quantity(quantity) = question else { return None };
    let Measure::Reward(rewards) = &quantity.measure else { return None };
    let structure = rewards.find(program)?;
    Some(program.wrong_rewards(structure))
}
