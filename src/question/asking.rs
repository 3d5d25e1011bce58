//! Questions as texts, and their goals.

use std::sync::Arc;

use crate::goal::{PathGoal, Required, Target};
use meliora_base::error::{Diagnostic, Result, Severity, SourceFile};
use meliora_engine::Engine;
use meliora_engine::regions::{Which, deciding};
use meliora_lang::ltl;
use meliora_lang::property::{Measure, Named, Over, PropertyKind, Query, Term};
use meliora_lang::{lower_target, parse_expression, parse_property};
use meliora_model::Program;
use meliora_model::predicate::Predicate;

/// The operators with which a property begins, also those that are not supported.
const OPERATORS: [&str; 12] =
    ["P", "Pmin", "Pmax", "R", "Rmin", "Rmax", "S", "Smin", "Smax", "E", "A", "multi"];

/// A question about the paths of a model.
pub struct Asking {
    /// The goal of the paths.
    pub goal: PathGoal,
    /// The question of a property, for the initial states.
    pub question: Option<PropertyKind>,
    /// For a property of a game, whether each player chooses to make it true.
    pub coalition: Option<Vec<bool>>,
    /// The part of the initial states that the question is about.
    pub over: Over,
}

impl Asking {
    /// Returns whether a number answers the question, in all initial states and without requirements.
    pub(crate) fn is_number(&self) -> bool {
        let is_qualitative = matches!(self.question, None | Some(PropertyKind::Qualitative(..)));
        !is_qualitative && matches!(self.over, Over::All) && self.goal.requirements.is_empty()
    }

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
        Ok(PathGoal::reach(program, target, required)?.into())
    }

    /// Reads a property such as `P>=1 [ F x = 3 ]`.
    ///
    /// # Errors
    /// The text or a requirement is wrong, or not supported; each error has its place.
    pub fn property(program: &Program, source: &Arc<SourceFile>, required: &[Required]) -> Result<Self> {
        let term = parse_property(source)?.term(program, source, &Named::default())?;
        Asking::query(program, source, &only_query(program, source, &term)?, required)
    }

    /// Returns the question of a query.
    ///
    /// # Errors
    /// The formula or a requirement is wrong, or not supported.
    pub fn query(
        program: &Program,
        source: &Arc<SourceFile>,
        query: &Query<'_>,
        required: &[Required],
    ) -> Result<Self> {
        let goal = match query.path.target() {
            Some(target) => PathGoal::reach(program, target, required)?,
            None => PathGoal::of(&query.path.over(program), source, &query.path.formula, required)?,
        };
        let (question, coalition) = (Some(query.question.clone()), query.coalition.cloned());
        Ok(Asking { goal, question, coalition, over: query.over })
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

    /// Returns whether the answer is a number, or depends on one.
    pub fn asks_for_number(&self) -> bool {
        matches!(self.question, Some(PropertyKind::Quantity(_)))
    }

    /// Returns whether the answer is an expected reward, or depends on one.
    pub fn asks_for_reward(&self) -> bool {
        matches!(&self.question, Some(PropertyKind::Quantity(own)) if matches!(own.measure, Measure::Reward(_)))
    }

    /// Returns the target if the question is whether some strategy reaches it almost surely, or its negation.
    pub fn reached_surely(&self) -> Option<&Predicate> {
        let Some(PropertyKind::Qualitative(strategies, bound)) = &self.question else { return None };
        match &self.goal.target {
            Target::States(target) if deciding(*strategies, *bound).0 == Which::PmaxOne => Some(target),
            _ => None,
        }
    }

    /// Returns whether the question is whether a formula holds almost surely, or its negation.
    pub fn is_about_certainty(&self) -> bool {
        let Some(PropertyKind::Qualitative(strategies, bound)) = &self.question else { return false };
        matches!(deciding(*strategies, *bound).0, Which::PmaxOne | Which::PminOne)
    }

    /// Returns whether the states of the deciding region satisfy the question, and not the others.
    pub fn is_inside(&self) -> bool {
        match &self.question {
            Some(PropertyKind::Qualitative(strategies, bound)) => deciding(*strategies, *bound).1,
            _ => true,
        }
    }

    /// Reads a target `x = 3`, a formula `F x = 3`, or a property `P>=1 [ F x = 3 ]`.
    ///
    /// # Errors
    /// The text is none of these, or not supported; each error has its place.
    pub fn parse(program: &Program, source: &Arc<SourceFile>) -> Result<Self> {
        match Form::of(source) {
            Form::Target => Asking::target(program, source, &[]),
            Form::Property => Asking::property(program, source, &[]),
            Form::Formula => Ok(PathGoal::of(program, source, &ltl::parse_formula(source)?, &[])?.into()),
        }
    }
}

/// Asks for the regions of a goal.
impl From<PathGoal> for Asking {
    fn from(goal: PathGoal) -> Self {
        Asking { goal, question: None, coalition: None, over: Over::All }
    }
}

/// Returns the query that a property is.
///
/// # Errors
/// It is another property.
pub fn only_query<'t>(program: &Program, source: &Arc<SourceFile>, term: &'t Term) -> Result<Query<'t>> {
    term.query(program).ok_or_else(|| {
        let message = "only one operator over a formula without other operators is supported here";
        let diagnostic = Diagnostic::new(source, term.span.range(), message).severity(Severity::Unsupported);
        diagnostic.help("`meliora reach --property` answers all properties").into()
    })
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
