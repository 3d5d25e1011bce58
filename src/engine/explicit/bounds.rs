//! A sufficient test for expressions that have a value in every state.

use meliora_base::value::{self, Type, Value};
use meliora_model::Program;
use meliora_model::expr::{Binary, ExprId, ExprPool, Node, Unary};

/// The smallest and the largest value of an integer expression; without meaning for other types.
pub(super) type Interval = (i128, i128);

/// For each node of the pool its bounds, or `None` if the node may have no value in some state.
pub(super) struct Bounds(Vec<Option<Interval>>);

impl Bounds {
    /// Computes bounds from the ranges of the variables, operands before the nodes that use them.
    ///
    /// The test is sufficient, not necessary: an expression that is not proved total counts as
    /// partial.
    pub(super) fn new(program: &Program) -> Self {
        Bounds::over(program, &program.pool)
    }

    /// Computes the same bounds for a pool that rests on that of the program.
    pub(super) fn over(program: &Program, pool: &ExprPool) -> Self {
        let mut bounds = Bounds(Vec::with_capacity(pool.len()));
        for e in pool.ids() {
            let found = bounds.of(program, pool, e).filter(|&(low, high)| fits(low) && fits(high));
            bounds.0.push(found);
        }
        bounds
    }

    /// Returns whether `e` is known to have a value in every state.
    pub(super) fn is_total(&self, e: ExprId) -> bool {
        self.get(e).is_some()
    }

    /// Returns the bounds of `e`, if it has a value in every state.
    pub(super) fn get(&self, e: ExprId) -> Option<Interval> {
        self.0.get(e.index()).copied().flatten()
    }

    fn of(&self, program: &Program, pool: &ExprPool, e: ExprId) -> Option<Interval> {
        match pool.node(e) {
            Node::Literal(Value::Int(i)) => Some((i.into(), i.into())),
            Node::Literal(_) => Some((0, 1)),
            Node::Var(v) => {
                // A formula that was refused leaves the variable of a monitor that is not installed.
                let declared = program.variables.get(v.index())?;
                Some((declared.low.into(), declared.high.into()))
            }
            Node::Unary(op, a) => {
                let (low, high) = self.get(a)?;
                match op {
                    Unary::Not | Unary::ToReal => Some((0, 1)),
                    Unary::Neg if pool.ty(a) == Type::Int => Some((-high, -low)),
                    Unary::Neg => Some((0, 1)),
                    Unary::Floor | Unary::Ceil | Unary::Round => None,
                }
            }
            Node::Binary(op, a, b) => {
                let (x, y) = (self.get(a)?, self.get(b)?);
                match pool.ty(a) {
                    Type::Bool => Some((0, 1)),
                    Type::Int => whole(op, x, y),
                    // The exact result may be too long.
                    Type::Real => (value::binary_type(op, Type::Real) == Type::Bool).then_some((0, 1)),
                }
            }
            Node::Ite(c, a, b) => {
                let (_, x, y) = (self.get(c)?, self.get(a)?, self.get(b)?);
                Some((x.0.min(y.0), x.1.max(y.1)))
            }
        }
    }
}

/// Computes the bounds of an operation on integers; both operands fit 64 bits.
pub(super) fn whole(op: Binary, x: Interval, y: Interval) -> Option<Interval> {
    match op {
        Binary::Add => Some((x.0 + y.0, x.1 + y.1)),
        Binary::Sub => Some((x.0 - y.1, x.1 - y.0)),
        Binary::Mul => {
            let corners = [x.0 * y.0, x.0 * y.1, x.1 * y.0, x.1 * y.1];
            Some((corners.into_iter().min()?, corners.into_iter().max()?))
        }
        Binary::Min => Some((x.0.min(y.0), x.1.min(y.1))),
        Binary::Max => Some((x.0.max(y.0), x.1.max(y.1))),
        Binary::Mod => (y.0 > 0).then_some((0, y.1 - 1)),
        Binary::Index => (x.0 >= 0 && x.1 < y.0).then_some(x),
        Binary::Pow => None,
        Binary::And | Binary::Or | Binary::Eq | Binary::Lt | Binary::Le => Some((0, 1)),
        Binary::Div | Binary::Log => Some((0, 1)),
    }
}

fn fits(x: i128) -> bool {
    i64::try_from(x).is_ok()
}
