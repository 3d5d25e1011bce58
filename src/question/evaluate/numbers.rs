//! Numbers: the value of a term in each of some states.

use super::{At, Evaluator, Number};
use meliora_base::error::{Error, Result};
use meliora_base::value::EvalError;
use meliora_engine::Engine;
use meliora_lang::ast::BinaryOp;
use meliora_lang::property::term::{Measure, Measured, Term, TermKind};
use meliora_model::State;
use meliora_model::predicate::Predicate;

impl<E: Engine> Evaluator<'_, '_, E> {
    /// Returns the values of a number in listed states, exact ones where bounds are wider than wanted.
    pub(super) fn narrow(&self, term: &Term, at: &At<E::States>) -> Result<Vec<Number>> {
        let found = self.numbers(term, at, false)?;
        if found.iter().all(|x| x.interval.relative_width() <= self.model.precision) {
            return Ok(found);
        }
        self.numbers(term, at, true)
    }

    /// Returns the values of a number in listed states; with `exact`, fractions where they can be computed.
    pub(super) fn numbers(&self, term: &Term, at: &At<E::States>, exact: bool) -> Result<Vec<Number>> {
        match &term.kind {
            TermKind::State(predicate) => at.list.iter().map(|s| self.evaluated(predicate, s)).collect(),
            TermKind::Neg(a) => Ok(self.numbers(a, at, exact)?.iter().map(Number::negated).collect()),
            TermKind::Binary(op, both) => self.arithmetic(term, *op, [&both[0], &both[1]], at, exact),
            TermKind::Apply(function, all) => {
                let all = all.iter().map(|a| self.numbers(a, at, exact)).collect::<Result<Vec<_>>>()?;
                let value = |i: usize| {
                    let arguments: Vec<Number> = all.iter().map(|a| a[i].clone()).collect();
                    Number::apply(*function, &arguments).map_err(|e| self.without_value(term, at, i, e))
                };
                (0..at.list.len()).map(value).collect()
            }
            TermKind::Ite(all) => {
                let [c, a, b] = &**all;
                let then = self.states(c, &at.set)?;
                let (a, b) = (self.numbers(a, at, exact)?, self.numbers(b, at, exact)?);
                let pairs = a.into_iter().zip(b);
                let choose = |(state, (a, b)): (&State, (Number, Number))| {
                    Ok(if self.engine.contains(&then, state)? { a } else { b })
                };
                at.list.iter().zip(pairs).map(choose).collect()
            }
            TermKind::Operator(measured) => self.measured(term, measured, at, exact),
            TermKind::Filter(filter) => self.filtered(term, filter, at, exact),
            TermKind::Multi(all) => self.best(term, all, at, exact),
            TermKind::Not(_) | TermKind::Join(..) | TermKind::Paths(..) => {
                Err(self.wrong(term, "expected a number").into())
            }
        }
    }

    fn arithmetic(
        &self,
        term: &Term,
        op: BinaryOp,
        [a, b]: [&Term; 2],
        at: &At<E::States>,
        exact: bool,
    ) -> Result<Vec<Number>> {
        let (a, b) = (self.numbers(a, at, exact)?, self.numbers(b, at, exact)?);
        let value = |(i, (x, y)): (usize, (&Number, &Number))| {
            x.arithmetic(op, y).map_err(|e| self.without_value(term, at, i, e))
        };
        a.iter().zip(&b).enumerate().map(value).collect()
    }

    fn evaluated(&self, predicate: &Predicate, state: &[i64]) -> Result<Number> {
        let value = predicate.pool().exact(predicate.id(), state);
        let none = |e: EvalError| {
            Error::Usage(format!("an expression has no value in {}: {e}", self.program.show_state(state)))
        };
        value.map(Number::of).map_err(none)
    }

    fn without_value(&self, term: &Term, at: &At<E::States>, state: usize, e: EvalError) -> Error {
        let state = self.program.show_state(&at.list[state]);
        self.wrong(term, format!("the expression has no value in the state {state}: {e}")).into()
    }

    /// Returns the number that an operator asks for in listed states.
    pub(super) fn measured(
        &self,
        term: &Term,
        measured: &Measured,
        at: &At<E::States>,
        exact: bool,
    ) -> Result<Vec<Number>> {
        if let (Some((place, optima)), false) = (&self.model.optima, exact)
            && *place == term.span.range()
            && at.list.len() == optima.len()
        {
            return Ok(optima.to_vec());
        }
        let precision = if exact { 0.0 } else { self.model.precision };
        let asked = Operator { term, measured, at, precision };
        match &measured.measure {
            Measure::Probability(path) => self.probability(&asked, path),
            Measure::LongRun(states) => self.long_run(&asked, states),
            Measure::Reward(rewards, accumulated) => self.reward(&asked, rewards, accumulated),
        }
    }
}

/// An operator whose numbers are asked for.
pub(super) struct Operator<'t, S> {
    pub(super) term: &'t Term,
    pub(super) measured: &'t Measured,
    /// The states.
    pub(super) at: &'t At<S>,
    /// The width of the bounds; 0 asks for fractions.
    pub(super) precision: f64,
}
