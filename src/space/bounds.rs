//! Bounds of expressions, and a sufficient test that they have a value.

use ahash::AHashMap;

use super::needs::interval;
use super::values::{self, Values};
use meliora_base::stack;
use meliora_base::value::EvalError;
use meliora_model::Program;
use meliora_model::expr::{ExprId, ExprPool, Node, Unary};
use meliora_model::predicate::Predicate;

/// Returns whether a condition is false for all values in the ranges of the variables. Only intervals are
/// compared, so false conditions may remain unknown.
pub fn is_never_true(program: &Program, condition: &Predicate) -> bool {
    let values = Bounds::new(program, condition.pool()).of(condition.id());
    !values.fails && values.range() == (0, 0)
}

/// The values of expressions in the states where some conditions are true.
pub(crate) struct Bounds<'p> {
    pool: &'p ExprPool,
    /// The ranges of the variables.
    ranges: Vec<(i64, i64)>,
    known: AHashMap<ExprId, Values>,
}

impl<'p> Bounds<'p> {
    /// Takes the declared ranges of the variables; the pool is that of the program, or rests on it.
    pub(crate) fn new(program: &Program, pool: &'p ExprPool) -> Self {
        let ranges = program.variables.iter().map(|v| (v.low, v.high)).collect();
        Bounds { pool, ranges, known: AHashMap::new() }
    }

    /// Takes the ranges that variables have where all of some conditions are true.
    pub(crate) fn under(program: &Program, pool: &'p ExprPool, conditions: &[ExprId]) -> Self {
        let mut bounds = Bounds::new(program, pool);
        conditions.iter().for_each(|&e| bounds.assume(e));
        bounds
    }

    /// Returns whether `e` is known to have a value in every state.
    pub(crate) fn is_total(&mut self, e: ExprId) -> bool {
        !self.of(e).fails
    }

    /// Returns the values that `e` may have.
    pub(crate) fn of(&mut self, e: ExprId) -> Values {
        if let Some(known) = self.known.get(&e) {
            return known.clone();
        }
        let found = stack::level(|| self.compute(e));
        self.known.insert(e, found.clone());
        found
    }

    fn compute(&mut self, e: ExprId) -> Values {
        match self.pool.node(e) {
            Node::Literal(_) => Values::of(self.pool.exact_literal(e).ok_or(EvalError::NotFinite)),
            Node::Var(v) => match self.ranges.get(v.index()) {
                Some(&(low, high)) => Values::whole(low, high),
                // A formula that was refused leaves the variable of a monitor that is not installed.
                None => Values::of(Err(EvalError::NotFinite)),
            },
            Node::Unary(op, a) => values::unary(op, self.pool.ty(a), &self.of(a)),
            Node::Binary(op, a, b) => values::binary(op, self.pool.ty(a), &self.of(a), &self.of(b)),
            Node::Ite(c, a, b) => values::choice(&self.of(c), &self.of(a), &self.of(b)),
        }
    }

    /// Narrows the range of the variable that a condition compares with a number.
    fn assume(&mut self, e: ExprId) {
        if let Some((variable, [low, high])) = interval(self.pool, e, true) {
            let range = &mut self.ranges[variable.index()];
            *range = (range.0.max(low), range.1.min(high));
        } else if let Node::Unary(Unary::Not, a) = self.pool.node(e)
            && let Some((variable, [value, _])) = interval(self.pool, a, true)
        {
            // An equation: the value is left out where it is one of the ends.
            let (low, high) = &mut self.ranges[variable.index()];
            *low = low.saturating_add(i64::from(*low == value));
            *high = high.saturating_sub(i64::from(*high == value));
        }
    }
}
