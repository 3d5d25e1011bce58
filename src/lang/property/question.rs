//! The questions of operators: which strategies count, and whether numbers are needed. A property that is one
//! operator about the paths from the initial states is a [`Query`].

use std::sync::Arc;

use num_traits::{One, Zero};

use super::operators::Extreme;
use super::term::{self, Accumulated, Filter, FilterFunction, Measured, Path, Term, TermKind};
use super::{Bound, Inequality, Measure, Optimum, Over, PropertyKind, Quantity, Strategies};
use crate::ltl::Stopped;
use meliora_base::error::{Result, SourceFile};
use meliora_base::exact::Ratio;
use meliora_model::Program;
use meliora_model::predicate::Predicates;

/// One operator over a formula without other operators: the probability of the formula, or a reward until a set of
/// states is reached.
#[derive(Debug, Clone)]
pub struct Query<'t> {
    /// The question about the formula.
    pub question: PropertyKind,
    /// The formula.
    pub path: &'t Path,
    /// The players of a game who choose to make the property true, as an entry per player.
    pub coalition: Option<&'t Vec<bool>>,
    /// The part of the initial states that it is about.
    pub over: Over,
}

impl Query<'_> {
    /// Returns whether the answer is a number, or depends on one.
    pub fn asks_for_number(&self) -> bool {
        matches!(self.question, PropertyKind::Quantity(_))
    }
}

impl Term {
    /// Returns the program in which the states that decide the formula of this property are not left, and the property
    /// over it; `None` if it asks for more than one formula, or in other states than the initial ones.
    ///
    /// # Errors
    /// The formula is one that no state decides.
    pub fn stopped(mut self, program: &Program, source: &Arc<SourceFile>) -> Result<Option<(Program, Self)>> {
        if let TermKind::Filter(mut filter) = self.kind {
            let Some(states) = filter.states.as_mut().filter(|states| states.is_initial(program)) else {
                return Ok(None);
            };
            let Some((program, of)) = filter.of.stopped(program, source)? else { return Ok(None) };
            states.kind = TermKind::State(program.predicate(program.initial));
            let kind = TermKind::Filter(Box::new(Filter { of, ..*filter }));
            return Ok(Some((program, Term { kind, ..self })));
        }
        let TermKind::Operator(measured) = &mut self.kind else { return Ok(None) };
        let (true, Some(path)) = (measured.query(program).is_some(), measured.path_mut()) else {
            return Ok(None);
        };
        let Stopped { program, formula } = Stopped::new(&path.over(program), source, &path.formula)?;
        (path.formula, path.predicates) = (formula, Predicates::over(&program));
        Ok(Some((program, self)))
    }

    /// Returns the query that the property is in the initial states; `None` for other properties.
    pub fn query(&self, program: &Program) -> Option<Query<'_>> {
        match &self.kind {
            TermKind::Filter(filter) => {
                let states = filter.states.as_ref()?;
                let query = filter.of.query(program).filter(|query| query.over == Over::All)?;
                let over = match filter.function {
                    FilterFunction::Forall | FilterFunction::Range => Over::All,
                    FilterFunction::Min => Over::Least,
                    FilterFunction::Max => Over::Greatest,
                    _ => return None,
                };
                states.is_initial(program).then_some(Query { over, ..query })
            }
            TermKind::Operator(measured) => measured.query(program),
            _ => None,
        }
    }

    /// Returns whether the condition is that of the initial states.
    pub fn is_initial(&self, program: &Program) -> bool {
        matches!(&self.kind, TermKind::State(states) if states.is_same(&program.predicate(program.initial)))
    }
}

/// Returns the strategies of an operator; `None` if it does not say. A bound without a name must hold for
/// every strategy, or for some: a lower bound for the minimum, or the maximum.
pub(super) fn optimum(extreme: Extreme, bound: Option<Inequality>, some: bool) -> Option<Optimum> {
    match (extreme, bound) {
        (Extreme::Min, _) => Some(Optimum::Min),
        (Extreme::Max, _) => Some(Optimum::Max),
        (Extreme::Unnamed, None) => None,
        (Extreme::Unnamed, Some(Inequality::Ge | Inequality::Gt)) if some => Some(Optimum::Max),
        (Extreme::Unnamed, Some(Inequality::Ge | Inequality::Gt)) => Some(Optimum::Min),
        (Extreme::Unnamed, Some(_)) if some => Some(Optimum::Min),
        (Extreme::Unnamed, Some(_)) => Some(Optimum::Max),
    }
}

/// Returns the question of an operator: one without numbers if the bound is 0 or 1.
pub(super) fn question(
    measure: Measure,
    optimum: Optimum,
    bound: Option<(Inequality, Ratio)>,
) -> PropertyKind {
    let (Measure::Probability, Some((comparison, value))) = (&measure, &bound) else {
        return PropertyKind::Quantity(Quantity { measure, optimum, bound });
    };
    let qualitative = match comparison {
        Inequality::Ge if value.is_one() => Bound::One,
        Inequality::Gt if value.is_zero() => Bound::Positive,
        Inequality::Lt if value.is_one() => Bound::BelowOne,
        Inequality::Le if value.is_zero() => Bound::Zero,
        _ => return PropertyKind::Quantity(Quantity { measure, optimum, bound }),
    };
    // The minimum is at least b if the probability of every strategy is; the maximum, if that of
    // some strategy is.
    let from_below = matches!(qualitative, Bound::One | Bound::Positive);
    let strategies = match optimum {
        Optimum::Max if from_below => Strategies::Some,
        Optimum::Min if !from_below => Strategies::Some,
        _ => Strategies::All,
    };
    PropertyKind::Qualitative(strategies, qualitative)
}

impl Measured {
    fn query(&self, program: &Program) -> Option<Query<'_>> {
        let (measure, path) = match &self.measure {
            term::Measure::Probability(path) if path.nested.is_empty() => (Measure::Probability, path),
            term::Measure::Reward(rewards, Accumulated::Until(path))
                if program.players.is_none() && path.target().is_some() =>
            {
                (Measure::Reward(rewards.clone()), path)
            }
            _ => return None,
        };
        let question = question(measure, self.optimum, self.bound.clone());
        Some(Query { question, path, coalition: self.coalition.as_ref(), over: Over::All })
    }

    fn path_mut(&mut self) -> Option<&mut Path> {
        match &mut self.measure {
            term::Measure::Probability(path) | term::Measure::Reward(_, Accumulated::Until(path)) => {
                Some(path)
            }
            _ => None,
        }
    }

    /// Returns the truth of a bound that all probabilities satisfy, or none.
    pub fn trivial(&self) -> Option<bool> {
        let (comparison, bound) = self.bound.as_ref()?;
        match comparison {
            Inequality::Ge if bound.is_zero() => Some(true),
            Inequality::Le if bound.is_one() => Some(true),
            Inequality::Lt if bound.is_zero() => Some(false),
            Inequality::Gt if bound.is_one() => Some(false),
            _ => None,
        }
    }

    /// Returns the question of a bound on a probability that is decided without numbers.
    pub fn qualitative(&self) -> Option<(Strategies, Bound)> {
        match question(Measure::Probability, self.optimum, self.bound.clone()) {
            PropertyKind::Qualitative(strategies, bound) => Some((strategies, bound)),
            PropertyKind::Quantity(_) => None,
        }
    }
}
