//! A sufficient test that every command has a meaning in every valuation where it is enabled.
//!
//! A guided search leaves states out. So it is for programs whose states need not be checked one by one.

use ahash::AHashMap;

use super::super::bounds::{Bounds, Interval, whole};
use super::super::guards::conjuncts;
use super::super::program::{Chances, Prepared};
use meliora_base::value::{Binary, Type, Value};
use meliora_model::expr::{ExprId, ExprPool, Node, Unary};
use meliora_model::predicate::Predicate;
use meliora_model::{Command, Program};

/// Returns whether guards, updates and the target have a value in every state, and probabilities are constant.
pub(super) fn is_total(program: &Program, prepared: &Prepared, target: &Predicate) -> bool {
    let bounds = Bounds::over(program, target.pool());
    let has_meaning =
        |command: &Command| bounds.is_total(command.guard) && updates(program, &bounds, command);
    prepared.commands.iter().all(|command| command.chances == Chances::Sound)
        && bounds.is_total(target.id())
        && !prepared.initial_is_partial
        && program.commands.iter().all(has_meaning)
}

/// Returns whether all new values of a command are in the ranges of their variables where its guard is true.
fn updates(program: &Program, bounds: &Bounds, command: &Command) -> bool {
    let mut narrow = None;
    command.branches.iter().flat_map(|branch| &branch.updates).all(|&(variable, new)| {
        let declared = &program.variables[variable.index()];
        let is_inside =
            |(low, high): Interval| low >= i128::from(declared.low) && high <= i128::from(declared.high);
        let is_known = match declared.ty {
            Type::Bool => bounds.is_total(new),
            _ => bounds.get(new).is_some_and(is_inside),
        };
        is_known || {
            let narrow = narrow.get_or_insert_with(|| Narrow::new(program, command.guard));
            narrow.of(new).is_some_and(is_inside)
        }
    })
}

/// Bounds under a guard.
struct Narrow<'p> {
    pool: &'p ExprPool,
    /// The ranges of the variables.
    ranges: Vec<Interval>,
    known: AHashMap<ExprId, Option<Interval>>,
}

impl<'p> Narrow<'p> {
    fn new(program: &'p Program, guard: ExprId) -> Self {
        let ranges = program.variables.iter().map(|v| (v.low.into(), v.high.into())).collect();
        let mut narrow = Narrow { pool: &program.pool, ranges, known: AHashMap::new() };
        conjuncts(program, guard).into_iter().for_each(|e| narrow.assume(e, true));
        narrow
    }

    /// Narrows the range of the variable that a condition compares with a number.
    fn assume(&mut self, e: ExprId, holds: bool) {
        match (self.pool.node(e), holds) {
            (Node::Unary(Unary::Not, a), _) => self.assume(a, !holds),
            (Node::Binary(Binary::Eq, a, b), true) => {
                self.at_most(a, b, 0);
                self.at_most(b, a, 0);
            }
            (Node::Binary(Binary::Eq, a, b), false) => {
                self.differ(a, b);
                self.differ(b, a);
            }
            (Node::Binary(Binary::Le, a, b), true) => self.at_most(a, b, 0),
            (Node::Binary(Binary::Lt, a, b), true) => self.at_most(a, b, 1),
            (Node::Binary(Binary::Le, a, b), false) => self.at_most(b, a, 1),
            (Node::Binary(Binary::Lt, a, b), false) => self.at_most(b, a, 0),
            _ => {}
        }
    }

    /// Assumes a + less <= b, where one is a variable and the other a number.
    fn at_most(&mut self, a: ExprId, b: ExprId, less: i128) {
        match (self.pool.node(a), self.pool.node(b)) {
            (Node::Var(v), Node::Literal(Value::Int(number))) => {
                let high = &mut self.ranges[v.index()].1;
                *high = (*high).min(i128::from(number) - less);
            }
            (Node::Literal(Value::Int(number)), Node::Var(v)) => {
                let low = &mut self.ranges[v.index()].0;
                *low = (*low).max(i128::from(number) + less);
            }
            _ => {}
        }
    }

    /// Assumes a != b, where a is a variable and b one of the ends of its range.
    fn differ(&mut self, a: ExprId, b: ExprId) {
        if let (Node::Var(v), Node::Literal(Value::Int(number))) = (self.pool.node(a), self.pool.node(b)) {
            let (low, high) = &mut self.ranges[v.index()];
            *low += i128::from(*low == i128::from(number));
            *high -= i128::from(*high == i128::from(number));
        }
    }

    /// Returns the bounds of an integer expression.
    fn of(&mut self, e: ExprId) -> Option<Interval> {
        if let Some(&known) = self.known.get(&e) {
            return known;
        }
        let found = match self.pool.node(e) {
            Node::Literal(Value::Int(i)) => Some((i.into(), i.into())),
            Node::Var(v) => Some(self.ranges[v.index()]),
            Node::Unary(Unary::Neg, a) if self.pool.ty(a) == Type::Int => {
                self.of(a).map(|(low, high)| (-high, -low))
            }
            Node::Binary(op, a, b) if self.pool.ty(a) == Type::Int => match (self.of(a), self.of(b)) {
                (Some(a), Some(b)) => whole(op, a, b),
                _ => None,
            },
            _ => None,
        };
        // Values that do not fit 64 bits are faults of their own.
        let found = found.filter(|&(low, high)| i64::try_from(low).is_ok() && i64::try_from(high).is_ok());
        self.known.insert(e, found);
        found
    }
}
