//! A second evaluation of expressions, in fractions. It shares no arithmetic with the model and the
//! engines: every number is one fraction, integers too.
//!
//! It has no value for powers whose exponent is not an integer and for logarithms, which may have
//! no exact value, and for numbers that are longer than those of the model may be.

use ahash::AHashMap;
use num_rational::BigRational;
use num_traits::{One, Pow, Signed, ToPrimitive, Zero};

use meliora_base::exact::{Exact, Real};
use meliora_base::real::MOST_BITS;
use meliora_base::stack;
use meliora_base::value::Type;
use meliora_model::expr::{Binary, ExprId, ExprPool, Node, Unary};

/// A truth value or a number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Value {
    Truth(bool),
    Number(BigRational),
}

/// The evaluation of expressions in one state. Each part is evaluated once.
pub(super) struct Evaluation<'p> {
    pool: &'p ExprPool,
    state: &'p [i64],
    known: AHashMap<ExprId, Option<Value>>,
}

impl<'p> Evaluation<'p> {
    pub(super) fn new(pool: &'p ExprPool, state: &'p [i64]) -> Self {
        Evaluation { pool, state, known: AHashMap::new() }
    }

    /// Returns the value of a condition, if it has one.
    pub(super) fn truth(&mut self, id: ExprId) -> Option<bool> {
        match self.value(id)? {
            Value::Truth(b) => Some(b),
            Value::Number(_) => None,
        }
    }

    /// Returns the value of a number, if it has one; truth values count as 0 and 1.
    pub(super) fn number(&mut self, id: ExprId) -> Option<BigRational> {
        match self.value(id)? {
            Value::Truth(b) => Some(whole(b.into())),
            Value::Number(x) => Some(x),
        }
    }

    /// Returns the value of an expression, if it has one.
    pub(super) fn value(&mut self, id: ExprId) -> Option<Value> {
        if let Some(known) = self.known.get(&id) {
            return known.clone();
        }
        let value = match self.pool.node(id) {
            Node::Literal(_) => self.literal(id),
            Node::Var(v) => {
                let value = *self.state.get(v.index())?;
                let is_truth = self.pool.ty(id) == Type::Bool;
                Some(if is_truth { Value::Truth(value != 0) } else { Value::Number(whole(value)) })
            }
            node => stack::level(|| self.operation(node)),
        };
        self.known.insert(id, value.clone());
        value
    }

    fn literal(&self, id: ExprId) -> Option<Value> {
        match self.pool.exact_literal(id)? {
            Exact::Bool(b) => Some(Value::Truth(b)),
            Exact::Int(i) => Some(Value::Number(whole(i))),
            Exact::Real(Real::Finite(x)) => Some(Value::Number(x)),
            Exact::Real(Real::Infinite(_) | Real::Undefined) => None,
        }
    }

    /// Returns the value of an operation, if it has one.
    pub(super) fn operation(&mut self, node: Node) -> Option<Value> {
        match node {
            Node::Literal(_) | Node::Var(_) => None,
            Node::Unary(Unary::Not, a) => Some(Value::Truth(!self.truth(a)?)),
            Node::Unary(op, a) => Some(Value::Number(rounded(op, self.number(a)?))),
            Node::Binary(op @ (Binary::And | Binary::Or), a, b) => match self.truth(a)? {
                left if left == (op == Binary::Or) => Some(Value::Truth(left)),
                _ => Some(Value::Truth(self.truth(b)?)),
            },
            Node::Binary(op, a, b) => computed(op, self.number(a)?, self.number(b)?),
            Node::Ite(c, a, b) => {
                let branch = if self.truth(c)? { a } else { b };
                self.value(branch)
            }
        }
    }
}

fn whole(i: i64) -> BigRational {
    BigRational::from_integer(i.into())
}

fn rounded(op: Unary, x: BigRational) -> BigRational {
    match op {
        Unary::Neg => -x,
        Unary::Floor => x.floor(),
        Unary::Ceil => x.ceil(),
        Unary::Round => (x + whole(1) / whole(2)).floor(),
        Unary::Not | Unary::ToReal => x,
    }
}

fn computed(op: Binary, x: BigRational, y: BigRational) -> Option<Value> {
    let number = match op {
        Binary::And | Binary::Or | Binary::Log => return None,
        Binary::Eq => return Some(Value::Truth(x == y)),
        Binary::Lt => return Some(Value::Truth(x < y)),
        Binary::Le => return Some(Value::Truth(x <= y)),
        Binary::Add => x + y,
        Binary::Sub => x - y,
        Binary::Mul => x * y,
        Binary::Div if y.is_zero() => return None,
        Binary::Div => x / y,
        Binary::Min => x.min(y),
        Binary::Max => x.max(y),
        Binary::Mod if !y.is_positive() => return None,
        Binary::Mod => &x - &y * (&x / &y).floor(),
        Binary::Index if x.is_negative() || x >= y => return None,
        Binary::Index => x,
        Binary::Pow => power(x, &y)?,
    };
    (length(&number) <= MOST_BITS).then_some(Value::Number(number))
}

fn power(x: BigRational, y: &BigRational) -> Option<BigRational> {
    let exponent = Some(y).filter(|y| y.is_integer())?.to_integer();
    if x.is_one() || exponent.is_zero() {
        return Some(BigRational::one());
    }
    let times = exponent.magnitude().to_u32()?;
    if length(&x).saturating_mul(times.into()) > 2 * MOST_BITS || x.is_zero() && exponent.is_negative() {
        return None;
    }
    let power = Pow::pow(&x, times);
    Some(if exponent.is_negative() { power.recip() } else { power })
}

fn length(x: &BigRational) -> u64 {
    x.numer().bits().max(x.denom().bits())
}

/// Returns whether an operation on literals has the value of a literal, unless it has none here.
pub(super) fn agrees(pool: &ExprPool, operation: Node, literal: ExprId) -> bool {
    let mut evaluation = Evaluation::new(pool, &[]);
    evaluation.operation(operation).is_none_or(|value| evaluation.value(literal) == Some(value))
}
