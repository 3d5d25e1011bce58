//! Expressions of a program as text, written from its pool without building trees.

use std::fmt::{self, Display, Formatter, Write as _};

use num_bigint::BigUint;
use num_traits::Signed;

use crate::ast::{ATOM_LEVEL, BinaryOp, NEG_LEVEL, NOT_LEVEL};
use meliora_base::decimal::scaled;
use meliora_base::exact::{Exact, Ratio, Real};
use meliora_model::Program;
use meliora_model::expr::{Binary, ExprId, Node, Unary};
use meliora_model::valuation::long;

/// Maximum number of digits of an integer in a literal.
const MOST_DIGITS: usize = 300;
/// An expression that occurs twice gets a name if it has at least this many nodes.
const LARGE: u8 = 40;
/// Expressions whose height is a multiple of this number get names too, which bounds the nesting.
const TALL: u16 = 64;

/// Writes expressions, with names for those that occur repeatedly.
pub(super) struct Expressions<'a> {
    program: &'a Program,
    /// Prefix of the names.
    prefix: String,
    /// The number in the name of each node of the pool, from 1 on; 0 for a node without a name.
    names: Vec<u32>,
}

impl<'a> Expressions<'a> {
    pub(super) fn new(program: &'a Program) -> Self {
        let mut prefix = "e".to_owned();
        let taken = |p: &str| {
            let names =
                program.variables.iter().map(|v| &v.name).chain(program.constants.iter().map(|c| &c.0));
            names.into_iter().any(|n| n.starts_with(p))
        };
        while taken(&format!("{prefix}_")) {
            prefix.push('e');
        }
        Expressions { program, prefix, names: names(program) }
    }

    /// Writes the definitions of all names, in an order in which each uses only earlier ones.
    pub(super) fn definitions(&self, f: &mut Formatter<'_>) -> fmt::Result {
        for id in self.program.pool.ids().filter(|id| self.names[id.index()] > 0) {
            f.write_str("\nformula ")?;
            self.name(f, id)?;
            f.write_str(" = ")?;
            self.body(f, id)?;
            f.write_char(';')?;
        }
        f.write_char('\n')
    }

    /// Returns an expression as text, by its name if it has one.
    pub(super) fn of(&self, id: ExprId) -> Expression<'_> {
        Expression { all: self, id }
    }

    fn is_named(&self, id: ExprId) -> bool {
        self.names[id.index()] > 0
    }

    fn name(&self, f: &mut Formatter<'_>, id: ExprId) -> fmt::Result {
        write!(f, "{}_{}", self.prefix, self.names[id.index()] - 1)
    }

    fn expr(&self, f: &mut Formatter<'_>, id: ExprId) -> fmt::Result {
        if self.is_named(id) { self.name(f, id) } else { self.body(f, id) }
    }

    /// Writes an expression, with brackets unless it binds at least as tightly as `least`.
    fn operand(&self, f: &mut Formatter<'_>, id: ExprId, least: u8) -> fmt::Result {
        if self.level(id).is_some_and(|level| level >= least) {
            return self.expr(f, id);
        }
        f.write_char('(')?;
        self.expr(f, id)?;
        f.write_char(')')
    }

    /// Returns the precedence level of the outermost operator, `None` for `?:`, which binds least.
    fn level(&self, id: ExprId) -> Option<u8> {
        Some(match self.program.pool.node(id) {
            _ if self.is_named(id) => ATOM_LEVEL,
            Node::Literal(_) => self.literal(id)?.level(),
            Node::Unary(Unary::Not, _) => NOT_LEVEL,
            Node::Unary(Unary::Neg, _) => NEG_LEVEL,
            Node::Unary(Unary::ToReal, a) => return self.level(a),
            Node::Binary(op, ..) => infix(op).map_or(ATOM_LEVEL, BinaryOp::level),
            Node::Var(_) | Node::Unary(..) => ATOM_LEVEL,
            Node::Ite(..) => return None,
        })
    }

    fn literal(&self, id: ExprId) -> Option<Literal> {
        self.program.pool.exact_literal(id).map(Literal)
    }

    fn body(&self, f: &mut Formatter<'_>, id: ExprId) -> fmt::Result {
        match self.program.pool.node(id) {
            Node::Literal(_) => self.literal(id).map_or(Ok(()), |literal| write!(f, "{literal}")),
            Node::Var(v) => f.write_str(&self.program.variables[v.index()].name),
            Node::Unary(op, a) => self.unary(f, op, a),
            // A power with a negative exponent has no value, either.
            Node::Binary(Binary::Index, a, n) => {
                let [a, n] = [a, n].map(|id| Expression { all: self, id });
                write!(f, "pow({a}, (0 <= ({a}) & ({a}) < {n}) ? 1 : -1)")
            }
            Node::Binary(op, a, b) => match infix(op) {
                Some(infix) => self.chain(f, op, infix, [a, b]),
                None => self.call(f, function(op), &[a, b]),
            },
            Node::Ite(c, a, b) => {
                self.operand(f, c, 0)?;
                f.write_str(" ? ")?;
                self.operand(f, a, 0)?;
                f.write_str(" : ")?;
                self.operand(f, b, 0)
            }
        }
    }

    fn unary(&self, f: &mut Formatter<'_>, op: Unary, a: ExprId) -> fmt::Result {
        match op {
            Unary::Not => {
                f.write_char('!')?;
                self.operand(f, a, NOT_LEVEL)
            }
            Unary::Neg => {
                f.write_char('-')?;
                self.operand(f, a, NEG_LEVEL)
            }
            // PRISM converts integers to reals implicitly.
            Unary::ToReal => self.expr(f, a),
            Unary::Floor => self.call(f, "floor", &[a]),
            Unary::Ceil => self.call(f, "ceil", &[a]),
            Unary::Round => self.call(f, "round", &[a]),
        }
    }

    /// Writes `a op b`; nested conjunctions, and nested disjunctions, need no brackets.
    fn chain(
        &self,
        f: &mut Formatter<'_>,
        op: Binary,
        infix: BinaryOp,
        operands: [ExprId; 2],
    ) -> fmt::Result {
        for (position, id) in operands.into_iter().enumerate() {
            if position > 0 {
                write!(f, " {} ", infix.symbol())?;
            }
            let goes_on = matches!(self.program.pool.node(id), Node::Binary(inner, ..) if inner == op)
                && matches!(op, Binary::And | Binary::Or);
            self.operand(f, id, infix.level() + u8::from(!goes_on))?;
        }
        Ok(())
    }

    fn call(&self, f: &mut Formatter<'_>, function: &str, arguments: &[ExprId]) -> fmt::Result {
        write!(f, "{function}(")?;
        for (position, &id) in arguments.iter().enumerate() {
            f.write_str(if position > 0 { ", " } else { "" })?;
            self.expr(f, id)?;
        }
        f.write_char(')')
    }
}

/// A displayable expression of [`Expressions`].
pub(super) struct Expression<'e> {
    all: &'e Expressions<'e>,
    id: ExprId,
}

impl Display for Expression<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.all.expr(f, self.id)
    }
}

/// Returns the infix operator, `None` if the operator is written as a function.
fn infix(op: Binary) -> Option<BinaryOp> {
    Some(match op {
        Binary::And => BinaryOp::And,
        Binary::Or => BinaryOp::Or,
        Binary::Eq => BinaryOp::Eq,
        Binary::Lt => BinaryOp::Lt,
        Binary::Le => BinaryOp::Le,
        Binary::Add => BinaryOp::Add,
        Binary::Sub => BinaryOp::Sub,
        Binary::Mul => BinaryOp::Mul,
        Binary::Div => BinaryOp::Div,
        Binary::Min | Binary::Max | Binary::Pow | Binary::Mod | Binary::Log | Binary::Index => return None,
    })
}

fn function(op: Binary) -> &'static str {
    match op {
        Binary::Min => "min",
        Binary::Max => "max",
        Binary::Pow => "pow",
        Binary::Mod => "mod",
        _ => "log",
    }
}

/// A value written as an expression.
pub(super) struct Literal(pub(super) Exact);

impl Literal {
    fn level(&self) -> u8 {
        match &self.0 {
            Exact::Int(i) if *i < 0 && *i > i64::MIN => NEG_LEVEL,
            Exact::Real(Real::Finite(x)) if is_decimal(x) => {
                if x.is_negative() {
                    NEG_LEVEL
                } else {
                    ATOM_LEVEL
                }
            }
            Exact::Real(_) => BinaryOp::Div.level(),
            _ => ATOM_LEVEL,
        }
    }
}

impl Display for Literal {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match &self.0 {
            // Values without a literal.
            Exact::Int(i64::MIN) => write!(f, "(-{} - 1)", i64::MAX),
            Exact::Real(Real::Undefined) => f.write_str("0 / 0"),
            Exact::Real(Real::Infinite(true)) => f.write_str("-(1 / 0)"),
            Exact::Real(Real::Infinite(false)) => f.write_str("1 / 0"),
            Exact::Real(Real::Finite(x)) if !is_decimal(x) => {
                let sign = if x.is_negative() { "-" } else { "" };
                let [numerator, denominator] = [x.numer(), x.denom()].map(|n| product(n.magnitude()));
                write!(f, "{sign}({numerator}) / ({denominator})")
            }
            value => match long(value) {
                Some(decimal) => f.write_str(&decimal),
                None => write!(f, "{}", value.rounded()),
            },
        }
    }
}

/// Returns whether a fraction can be written as one literal, which is not larger than a double.
fn is_decimal(x: &Ratio) -> bool {
    scaled(x).is_some() && Real::Finite(x.clone()).to_f64().is_finite()
}

/// Writes an integer as a product of literals, each of which is not larger than a double.
fn product(n: &BigUint) -> String {
    let digits = n.to_string();
    if u32::try_from(n).is_ok() {
        return digits;
    }
    let mut rest = digits.len().saturating_sub(MOST_DIGITS);
    let mut text = format!("{digits}e-{rest}");
    while rest > 0 {
        let step = rest.min(MOST_DIGITS);
        text += &format!(" * 1e{step}");
        rest -= step;
    }
    text
}

/// Returns all expressions that the text contains.
fn roots(program: &Program) -> impl Iterator<Item = ExprId> + '_ {
    let branches = program.commands.iter().flat_map(|c| &c.branches);
    let shown = branches.flat_map(|b| b.updates.iter().map(|u| u.1).chain([b.probability]));
    let guards = program.commands.iter().map(|c| c.guard);
    guards.chain(shown).chain(program.labels.iter().map(|l| l.1)).chain([program.initial])
}

/// Returns the number of uses of each node in the text, saturating at 255.
fn uses(program: &Program) -> Vec<u8> {
    let mut uses = vec![0_u8; program.pool.len()];
    let mut pending = Vec::new();
    for root in roots(program) {
        pending.push(root);
        while let Some(id) = pending.pop() {
            let count = &mut uses[id.index()];
            let is_new = *count == 0;
            *count = count.saturating_add(1);
            if is_new {
                pending.extend(program.pool.operands(id));
            }
        }
    }
    uses
}

/// Numbers the expressions that get names: large ones that occur more than once, and some tall
/// ones.
fn names(program: &Program) -> Vec<u32> {
    let uses = uses(program);
    let (mut names, mut named) = (vec![0; uses.len()], 0);
    let mut sizes = vec![(0_u8, 0_u16); uses.len()];
    // Operands come before the nodes that use them.
    for id in program.pool.ids().filter(|id| uses[id.index()] > 0) {
        let (mut size, mut height) = (1_u8, 0_u16);
        for operand in program.pool.operands(id) {
            let (s, h) = sizes[operand.index()];
            (size, height) = (size.saturating_add(s), height.max(h.saturating_add(1)));
        }
        let tall = height > 0 && height.is_multiple_of(TALL);
        if tall || (uses[id.index()] > 1 && size >= LARGE) {
            named += 1;
            names[id.index()] = named;
            size = 1;
        }
        sizes[id.index()] = (size, height);
    }
    names
}
