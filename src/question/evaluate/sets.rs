//! Conditions: the states that satisfy a term.

use std::cell::RefCell;

use super::{At, Evaluator, Number};
use meliora_base::error::Result;
use meliora_engine::Engine;
use meliora_engine::regions::deciding;
use meliora_lang::ast::BinaryOp;
use meliora_lang::property::Inequality;
use meliora_lang::property::term::{FilterFunction, Measure, Measured, Term, TermKind};

impl<E: Engine> Evaluator<'_, '_, E> {
    /// Returns the states of `within` that satisfy a condition.
    pub(super) fn states(&self, term: &Term, within: &E::States) -> Result<E::States> {
        let engine = self.engine;
        match &term.kind {
            TermKind::State(predicate) => engine.intersection(&engine.states_where(predicate)?, within),
            TermKind::Not(a) => engine.difference(within, &self.states(a, within)?),
            TermKind::Join(true, all) => {
                all.iter().try_fold(within.clone(), |left, part| self.states(part, &left))
            }
            TermKind::Join(false, all) => self.any(all, within),
            TermKind::Binary(BinaryOp::Implies, both) => {
                let premise = self.states(&both[0], within)?;
                let wrong = engine.difference(&premise, &self.states(&both[1], &premise)?)?;
                engine.difference(within, &wrong)
            }
            TermKind::Binary(BinaryOp::Iff, both) => {
                let [a, b] = [self.states(&both[0], within)?, self.states(&both[1], within)?];
                let either = engine.union(&engine.difference(&a, &b)?, &engine.difference(&b, &a)?)?;
                engine.difference(within, &either)
            }
            TermKind::Binary(op, both) => self.compared(term, *op, &[&both[0], &both[1]], within),
            TermKind::Ite(all) => {
                let [c, a, b] = &**all;
                let then = self.states(c, within)?;
                let other = engine.difference(within, &then)?;
                engine.union(&self.states(a, &then)?, &self.states(b, &other)?)
            }
            TermKind::Operator(measured) => self.bounded(term, measured, within),
            TermKind::Paths(all, path) => {
                engine.intersection(&self.states_of_paths(term, *all, path)?, within)
            }
            TermKind::Filter(filter) => match filter.function {
                FilterFunction::Argmin | FilterFunction::Argmax => {
                    let states = self.extreme_states(filter, &self.chosen(filter)?)?;
                    engine.intersection(&states, within)
                }
                FilterFunction::Print | FilterFunction::Printall => self.states(&filter.of, within),
                _ => Ok(if self.truth(term, filter)? { within.clone() } else { engine.no_states() }),
            },
            TermKind::Multi(all) => self.achieving(term, all, within),
            TermKind::Neg(_) | TermKind::Apply(..) => Err(self.wrong(term, "expected a condition").into()),
        }
    }

    /// Returns the states that satisfy one of some conditions; each is evaluated where those before it do
    /// not hold.
    fn any(&self, all: &[Term], within: &E::States) -> Result<E::States> {
        let (mut left, mut found) = (within.clone(), self.engine.no_states());
        for part in all {
            let own = self.states(part, &left)?;
            left = self.engine.difference(&left, &own)?;
            found = self.engine.union(&found, &own)?;
        }
        Ok(found)
    }

    /// Returns the states in which a comparison of two numbers is true.
    fn compared(
        &self,
        term: &Term,
        op: BinaryOp,
        both: &[&Term; 2],
        within: &E::States,
    ) -> Result<E::States> {
        let at = self.at(within)?;
        let values = |exact: bool| -> Result<_> {
            Ok((self.numbers(both[0], &at, exact)?, self.numbers(both[1], &at, exact)?))
        };
        self.decided(term, op, &at, values)
    }

    /// Returns the states in which a comparison is true. Where bounds do not decide it, exact numbers do.
    pub(super) fn decided(
        &self,
        term: &Term,
        op: BinaryOp,
        at: &At<E::States>,
        values: impl Fn(bool) -> Result<(Vec<Number>, Vec<Number>)>,
    ) -> Result<E::States> {
        let decide = |(left, right): (Vec<Number>, Vec<Number>)| -> Vec<Option<bool>> {
            left.iter().zip(&right).map(|(x, y)| x.satisfies(op, y)).collect()
        };
        let mut truths = decide(values(false)?);
        if truths.contains(&None) {
            truths = decide(values(true)?);
        }
        if let Some(open) = truths.iter().position(Option::is_none) {
            let state = self.program.show_state(&at.list[open]);
            let message =
                format!("the bounds of the numbers do not decide this comparison in the state {state}");
            return Err(self.wrong(term, message).label("not decided").into());
        }
        let satisfied = at.list.iter().zip(truths).filter(|(_, truth)| *truth == Some(true));
        self.set_of(satisfied.map(|(state, _)| state.clone()).collect(), at)
    }

    /// Returns the set of some listed states.
    fn set_of(&self, states: Vec<meliora_model::State>, at: &At<E::States>) -> Result<E::States> {
        match states.len() {
            0 => Ok(self.engine.no_states()),
            all if all == at.list.len() => Ok(at.set.clone()),
            _ => self.engine.intersection(&self.set_where(&states)?, &at.set),
        }
    }

    /// Returns whether an operator with a bound is true in all listed states, and the range of its numbers.
    pub(super) fn compared_value(
        &self,
        term: &Term,
        measured: &Measured,
        at: &At<E::States>,
    ) -> Result<(bool, Option<Number>)> {
        let Some((comparison, bound)) = &measured.bound else {
            return Err(self.wrong(term, "expected a condition").into());
        };
        let bounds = vec![Number::fraction(bound); at.list.len()];
        let known = RefCell::new(Vec::new());
        let values = |exact: bool| {
            let found = self.measured(term, measured, at, exact)?;
            known.replace(found.clone());
            Ok((found, bounds.clone()))
        };
        let satisfied = self.decided(term, sign(*comparison), at, values)?;
        let holds = self.engine.is_empty(&self.engine.difference(&at.set, &satisfied)?)?;
        Ok((holds, known.into_inner().into_iter().reduce(|all, x| all.range(&x))))
    }

    /// Returns the states in which an operator with a bound is true.
    fn bounded(&self, term: &Term, measured: &Measured, within: &E::States) -> Result<E::States> {
        let Some((comparison, bound)) = &measured.bound else {
            return Err(self.wrong(term, "expected a condition").into());
        };
        if let Measure::Probability(path) = &measured.measure {
            if let Some(all) = measured.trivial() {
                return Ok(if all { within.clone() } else { self.engine.no_states() });
            }
            if let Some((strategies, likely)) = measured.qualitative() {
                let (which, inside) = deciding(strategies, likely);
                let region = self.region(term, measured, which, path)?;
                return match inside {
                    true => self.engine.intersection(within, &region),
                    false => self.engine.difference(within, &region),
                };
            }
        }
        let (op, at) = (sign(*comparison), self.at(within)?);
        let bounds = vec![Number::fraction(bound); at.list.len()];
        let values = |exact: bool| Ok((self.measured(term, measured, &at, exact)?, bounds.clone()));
        self.decided(term, op, &at, values)
    }
}

/// Returns the sign of a comparison.
pub(crate) fn sign(comparison: Inequality) -> BinaryOp {
    match comparison {
        Inequality::Ge => BinaryOp::Ge,
        Inequality::Gt => BinaryOp::Gt,
        Inequality::Le => BinaryOp::Le,
        Inequality::Lt => BinaryOp::Lt,
    }
}
