//! Real numbers of the machine, each in the word of a register.
//!
//! The word of a short fraction contains the fraction itself, so that its arithmetic is that of the
//! processor. All other numbers are stored once, and their word is their position. Every operation
//! on them is computed once and then looked up, so that exact arithmetic costs a few nanoseconds,
//! however long the numbers are.

use ahash::AHashMap;

use meliora_base::exact::{self, Exact, Real};
use meliora_base::rounding::{Sum, is_weight};
use meliora_base::short::Short;
use meliora_base::value::EvalError;
use meliora_model::expr::{Binary, Unary};

/// Maximum number of results that are kept from one state to the next.
const MOST_RESULTS: usize = 1 << 16;

/// An operation with the words of its operands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Operation {
    Integer(i64),
    Unary(Unary, i64),
    Binary(Binary, i64, i64),
}

/// The numbers that are not short, by position, and the results of operations on them.
#[derive(Debug, Clone, Default)]
pub(crate) struct Numbers {
    list: Vec<Real>,
    places: AHashMap<Real, i64>,
    results: AHashMap<Operation, Result<i64, EvalError>>,
    /// The number of constants, which come first.
    constants: usize,
}

/// Returns the word of a short fraction: a negative one, unlike positions. Its upper half contains
/// the denominator, which has 31 bits.
fn word(x: Short) -> i64 {
    let (numerator, denominator) = x.parts();
    i64::MIN | i64::from(denominator) << 32 | i64::from(numerator as u32)
}

/// Returns the short fraction in a word; `None` for a position.
fn short(word: i64) -> Option<Short> {
    let denominator = word >> 32 & i64::from(i32::MAX);
    if word < 0 { Short::from_parts((i64::from(word as i32), denominator)) } else { None }
}

/// Computes an operation on short fractions: a word, or a truth value. `None` if the result is not
/// short, or not a number.
fn brief(op: Binary, x: Short, y: Short) -> Option<i64> {
    let order = || x.compare(y);
    match op {
        Binary::Eq => Some(i64::from(x == y)),
        Binary::Lt => Some(i64::from(order().is_lt())),
        Binary::Le => Some(i64::from(order().is_le())),
        Binary::Min => Some(word(if order().is_lt() { x } else { y })),
        Binary::Max => Some(word(if order().is_gt() { x } else { y })),
        _ => Short::combine(op, x, y).and_then(Short::from_parts).map(word),
    }
}

impl Numbers {
    /// Returns the word of a constant of the code.
    pub(crate) fn constant(&mut self, number: Real) -> i64 {
        let place = self.place(number);
        self.constants = self.list.len();
        place
    }

    /// Returns the number in a word.
    pub(crate) fn at(&self, word: i64) -> Real {
        short(word).map_or_else(|| self.stored(word).clone(), |x| Real::Finite(x.into()))
    }

    /// Returns the number at a position.
    fn stored(&self, place: i64) -> &Real {
        const NONE: &Real = &Real::Undefined;
        usize::try_from(place).ok().and_then(|place| self.list.get(place)).unwrap_or(NONE)
    }

    /// Returns whether the word contains 0.
    pub(crate) fn is_zero(word: i64) -> bool {
        short(word) == Some(Short::ZERO)
    }

    /// Returns whether the number may stand at a branch; see [`is_weight`].
    fn is_weight(&self, word: i64) -> bool {
        match short(word) {
            Some(short) => short.is_probability() || is_weight(&self.at(word)),
            None => is_weight(self.stored(word)),
        }
    }

    /// Forgets all results if they are many. Registers must not contain positions of results then.
    pub(crate) fn next_state(&mut self) {
        if self.results.len() > MOST_RESULTS {
            self.results.clear();
            for number in self.list.drain(self.constants..) {
                self.places.remove(&number);
            }
        }
    }

    /// Returns the word of an integer.
    pub(crate) fn integer(&mut self, i: i64) -> i64 {
        if let Some(x) = Short::whole(i) {
            return word(x);
        }
        let result = self.known(Operation::Integer(i), |_| Ok(Exact::Real(Real::from(i))));
        result.unwrap_or_default()
    }

    /// Computes an operation on the number in a word: a word, or another value.
    ///
    /// # Errors
    /// The operation has no value.
    pub(crate) fn unary(&mut self, op: Unary, a: i64) -> Result<i64, EvalError> {
        let quick =
            |x: Short| if op == Unary::Neg { brief(Binary::Sub, Short::ZERO, x) } else { x.rounded(op) };
        if let Some(result) = short(a).and_then(quick) {
            return Ok(result);
        }
        self.known(Operation::Unary(op, a), |own| exact::unary(op, Exact::Real(own.at(a))))
    }

    /// Computes an operation on the numbers in two words: a word, or a truth value.
    ///
    /// # Errors
    /// The operation has no value.
    pub(crate) fn binary(&mut self, op: Binary, a: i64, b: i64) -> Result<i64, EvalError> {
        if let Some(result) = short(a).zip(short(b)).and_then(|(x, y)| brief(op, x, y)) {
            return Ok(result);
        }
        self.known(Operation::Binary(op, a, b), |own| exact::reals(op, &own.at(a), &own.at(b)))
    }

    /// Judges a list of probabilities, which are given by their words.
    ///
    /// # Errors
    /// A sum has no value.
    pub(crate) fn judge(&mut self, probabilities: impl IntoIterator<Item = i64>) -> Result<Sum, EvalError> {
        let mut sum = self.integer(0);
        for p in probabilities {
            if !self.is_weight(p) {
                return Ok(Sum::Wrong);
            }
            sum = self.binary(Binary::Add, sum, p)?;
        }
        Ok(if short(sum) == Some(Short::ONE) { Sum::One } else { Sum::judge(&self.at(sum)) })
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

    /// Returns the word of a number.
    pub(crate) fn place(&mut self, number: Real) -> i64 {
        if let Some(x) = number.finite().and_then(Short::new) {
            return word(x);
        }
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
        let tiny = numbers.constant(Real::from(0.5f64.powi(40)));
        for i in 0..3 * MOST_RESULTS as i64 {
            numbers.next_state();
            let place = numbers.integer(i);
            let product = numbers.binary(Binary::Mul, tiny, place).unwrap();
            assert_eq!(numbers.at(product), Real::from(i as f64 * 0.5f64.powi(40)));
            assert!(numbers.list.len() <= 2 * MOST_RESULTS + 3);
        }
        assert_eq!(numbers.at(tiny), Real::from(0.5f64.powi(40)));
    }

    #[test]
    fn short_numbers_are_not_stored() {
        let mut numbers = Numbers::default();
        for i in 1..1000 {
            let [n, d] = [i, i + 1].map(|i| numbers.integer(i));
            let part = numbers.binary(Binary::Div, n, d).unwrap();
            let one = numbers.integer(1);
            let rest = numbers.binary(Binary::Sub, one, part).unwrap();
            assert_eq!(numbers.judge([part, rest]), Ok(Sum::One));
        }
        assert!(numbers.list.is_empty() && numbers.results.is_empty());
    }

    #[test]
    fn words_contain_all_numbers_around_the_longest_short_ones() {
        let parts =
            [0, 1, -1, 3, i32::MAX.into(), i32::MIN.into(), 1 << 31, -(1 << 31) - 1, 1 << 33, i64::MAX];
        let mut numbers = Numbers::default();
        let real = |n: i64, d: i64| exact::reals(Binary::Div, &Real::from(n), &Real::from(d));
        for (n, d) in parts.into_iter().flat_map(|n| parts.map(|d| (n, d))) {
            let Ok(Exact::Real(number)) = real(n, d) else { panic!("{n}/{d}") };
            let (a, b) = (numbers.integer(n), numbers.integer(d));
            let quotient = numbers.binary(Binary::Div, a, b).unwrap();
            assert_eq!(quotient, numbers.place(number.clone()), "{n}/{d}");
            assert_eq!(numbers.at(quotient), number);
            assert_eq!(Numbers::is_zero(quotient), number.is_zero());
            assert_eq!(numbers.is_weight(quotient), is_weight(&number));
            for other in [numbers.integer(0), numbers.integer(i64::MAX), a, b, quotient] {
                for op in
                    [Binary::Eq, Binary::Lt, Binary::Le, Binary::Min, Binary::Max, Binary::Add, Binary::Sub]
                {
                    let expected = exact::reals(op, &number, &numbers.at(other)).unwrap();
                    let found = numbers.binary(op, quotient, other).unwrap();
                    match expected {
                        Exact::Bool(b) => assert_eq!(found, i64::from(b)),
                        expected => assert_eq!(numbers.at(found), expected.into_real()),
                    }
                }
            }
            for op in [Unary::Neg, Unary::Floor, Unary::Ceil, Unary::Round] {
                let expected = exact::unary(op, Exact::Real(number.clone()));
                match (expected, numbers.unary(op, quotient)) {
                    (Ok(Exact::Int(i)), found) => assert_eq!(found, Ok(i), "{op:?} {number}"),
                    (Ok(expected), found) => {
                        assert_eq!(numbers.at(found.unwrap()), expected.into_real(), "{op:?} {number}");
                    }
                    (Err(reason), found) => assert_eq!(found, Err(reason), "{op:?} {number}"),
                }
            }
        }
    }
}
