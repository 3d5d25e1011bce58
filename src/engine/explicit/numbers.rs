//! Real numbers of the machine: each is stored once, and registers contain its position.
//!
//! Every operation on two positions is computed once and then looked up, so that exact arithmetic
//! costs a few nanoseconds, however long the numbers are.

use ahash::AHashMap;

use meliora_model::exact::{self, Exact, Real};
use meliora_model::expr::{Binary, Unary};
use meliora_model::rounding::Sum;
use meliora_model::value::EvalError;

/// Maximum number of results that are kept from one state to the next.
const MOST_RESULTS: usize = 1 << 16;

/// An operation with the contents of the registers of its operands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Operation {
    Integer(i64),
    Unary(Unary, i64),
    Binary(Binary, i64, i64),
}

/// Numbers by position, and the results of operations on them.
#[derive(Debug, Clone, Default)]
pub(super) struct Numbers {
    list: Vec<Real>,
    places: AHashMap<Real, i64>,
    results: AHashMap<Operation, Result<i64, EvalError>>,
    /// The number of constants, which come first.
    constants: usize,
}

impl Numbers {
    /// Returns the position of a constant of the code.
    pub(super) fn constant(&mut self, number: Real) -> i64 {
        let place = self.place(number);
        self.constants = self.list.len();
        place
    }

    /// Returns the number at a position.
    pub(super) fn at(&self, place: i64) -> &Real {
        const NONE: &Real = &Real::Undefined;
        usize::try_from(place).ok().and_then(|place| self.list.get(place)).unwrap_or(NONE)
    }

    /// Forgets all results if they are many. Registers must not contain positions of results then.
    pub(super) fn next_state(&mut self) {
        if self.results.len() > MOST_RESULTS {
            self.results.clear();
            for number in self.list.drain(self.constants..) {
                self.places.remove(&number);
            }
        }
    }

    /// Returns the position of an integer.
    pub(super) fn integer(&mut self, i: i64) -> i64 {
        let result = self.known(Operation::Integer(i), |_| Ok(Exact::Real(Real::from(i))));
        result.unwrap_or_default()
    }

    /// Computes an operation on the number at a position: a position, or another value.
    ///
    /// # Errors
    /// The operation has no value.
    pub(super) fn unary(&mut self, op: Unary, a: i64) -> Result<i64, EvalError> {
        let compute = |own: &Self| exact::unary(op, Exact::Real(own.at(a).clone()));
        self.known(Operation::Unary(op, a), compute)
    }

    /// Computes an operation on the numbers at two positions: a position, or a truth value.
    ///
    /// # Errors
    /// The operation has no value.
    pub(super) fn binary(&mut self, op: Binary, a: i64, b: i64) -> Result<i64, EvalError> {
        self.known(Operation::Binary(op, a, b), |own| exact::reals(op, own.at(a), own.at(b)))
    }

    /// Judges a list of probabilities, which are given by their positions.
    ///
    /// # Errors
    /// A sum has no value.
    pub(super) fn judge(&mut self, probabilities: impl IntoIterator<Item = i64>) -> Result<Sum, EvalError> {
        let mut sum = self.integer(0);
        for p in probabilities {
            if !self.at(p).is_probability() {
                return Ok(Sum::Wrong);
            }
            sum = self.binary(Binary::Add, sum, p)?;
        }
        Ok(Sum::of(self.at(sum)))
    }

    fn known(
        &mut self,
        operation: Operation,
        compute: impl FnOnce(&Self) -> Result<Exact, EvalError>,
    ) -> Result<i64, EvalError> {
        if let Some(known) = self.results.get(&operation) {
            return *known;
        }
        let result = compute(self).map(|value| match value {
            Exact::Bool(b) => i64::from(b),
            Exact::Int(i) => i,
            Exact::Real(number) => self.place(number),
        });
        self.results.insert(operation, result);
        result
    }

    /// Returns the position of a number.
    pub(super) fn place(&mut self, number: Real) -> i64 {
        let Numbers { list, places, .. } = self;
        *places.entry(number).or_insert_with_key(|number| {
            list.push(number.clone());
            list.len() as i64 - 1
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forgotten_results_are_computed_again() {
        let mut numbers = Numbers::default();
        let half = numbers.constant(Real::from(0.5));
        for i in 0..3 * MOST_RESULTS as i64 {
            numbers.next_state();
            let place = numbers.integer(i);
            let product = numbers.binary(Binary::Mul, half, place).unwrap();
            assert_eq!(numbers.at(product), &Real::from(i as f64 / 2.0));
            assert!(numbers.list.len() <= 2 * MOST_RESULTS + 3);
        }
        assert_eq!(numbers.at(half), &Real::from(0.5));
    }
}
