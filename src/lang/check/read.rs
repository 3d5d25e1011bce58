//! Lowering of expressions from their text into the pool, without an intermediate tree.

use std::sync::Arc;

use super::lower::Lowerer;
use super::ops::Operand;
use super::scope::Env;
use crate::lang::ast::{BinaryOp, Command, Expr, Ident, Span};
use crate::lang::parse::{Atom, Maker, command_at, expression_at, remade};
use crate::model::expr::ExprId;
use crate::model::value::{Type, Value};

/// An expression in the pool, or `None` after reporting that it is wrong; and its place.
pub(super) type Lowered = (Option<ExprId>, Span);

/// A form of expression that can be lowered into the pool.
pub(super) trait Body {
    /// Lowers the expression into the pool under a renaming.
    fn lowered(&self, lowerer: &mut Lowerer<'_>, env: Env) -> Lowered;
}

impl Body for Expr {
    fn lowered(&self, lowerer: &mut Lowerer<'_>, env: Env) -> Lowered {
        remade(self, &mut Reading { lowerer, env })
    }
}

/// The place of an expression whose syntax was checked before.
impl Body for Span {
    fn lowered(&self, lowerer: &mut Lowerer<'_>, env: Env) -> Lowered {
        let (source, sink) = (Arc::clone(&lowerer.source), lowerer.poll.sink());
        match expression_at(&source, *self, sink, Reading { lowerer, env }) {
            Ok(lowered) => lowered,
            Err(error) => {
                lowerer.unread(error);
                (None, *self)
            }
        }
    }
}

/// An expression that is already lowered.
impl Body for Lowered {
    fn lowered(&self, _: &mut Lowerer<'_>, _: Env) -> Lowered {
        *self
    }
}

impl Lowerer<'_> {
    /// Reads the command at a place, with its expressions in the pool.
    pub(super) fn read_command(&mut self, place: Span, env: Env) -> Option<Command<Lowered>> {
        let (source, sink) = (Arc::clone(&self.source), self.poll.sink());
        let read = command_at(&source, place, sink, Reading { lowerer: self, env });
        read.map_err(|error| self.unread(error)).ok()
    }

    fn chain(&mut self, first: Lowered, rest: Vec<(BinaryOp, Lowered)>) -> Option<ExprId> {
        let (mut left, start) = (first.0?, first.1);
        let op = rest.first()?.0;
        if matches!(op, BinaryOp::And | BinaryOp::Or) {
            let row = rest.into_iter().map(|(_, (id, span))| Some((id?, span)));
            let mut row: Vec<Operand> = row.collect::<Option<_>>()?;
            row.insert(0, (left, start));
            return self.balanced(op, row);
        }
        if rest.iter().any(|(_, (id, _))| id.is_none()) {
            return None;
        }
        let mut span = start;
        for (op, (right, right_span)) in rest {
            let whole = start.to(right_span);
            left = self.binary(op, (left, span), (right?, right_span), whole)?;
            span = whole;
        }
        Some(left)
    }

    fn conditional(&mut self, cases: Vec<(Lowered, Lowered)>, otherwise: Lowered) -> Option<ExprId> {
        let what = "the condition of `?`";
        let check = |((c, span), then): (Lowered, Lowered)| {
            (c.and_then(|c| self.expect_type(c, Type::Bool, span, what)), then)
        };
        let checked: Vec<_> = cases.into_iter().map(check).collect();
        let (mut result, mut span) = otherwise;
        for (condition, (then, then_span)) in checked.into_iter().rev() {
            result = match (condition, then, result) {
                (Some(c), Some(a), Some(b)) => self.ite(c, (a, then_span), (b, span)),
                _ => None,
            };
            span = then_span.to(span);
        }
        result
    }
}

/// Lowers expressions into the pool while they are parsed, under a renaming.
struct Reading<'l, 'a> {
    lowerer: &'l mut Lowerer<'a>,
    env: Env,
}

impl<'a> Reading<'_, 'a> {
    /// Makes one more part of an expression.
    fn part(&mut self, span: Span, make: impl FnOnce(&mut Lowerer<'a>) -> Option<ExprId>) -> Lowered {
        (self.lowerer.count_work(span).and_then(|()| make(self.lowerer)), span)
    }
}

impl Maker for Reading<'_, '_> {
    type Expr = Lowered;
    type Command = Command<Lowered>;

    fn atom(&mut self, atom: Atom<'_>, span: Span) -> Lowered {
        let env = self.env;
        self.part(span, |lowerer| match atom {
            Atom::Bool(b) => lowerer.literal(Value::Bool(b)),
            Atom::Int(i) => lowerer.literal(Value::Int(i)),
            Atom::Real(x) => Some(lowerer.real(x, span)),
            Atom::Name(name) => lowerer.name(name, span, env),
            Atom::Label(name) => lowerer.label(name, span),
        })
    }

    fn not(&mut self, (operand, place): Lowered, span: Span) -> Lowered {
        self.part(span, |lowerer| lowerer.not(operand?, place))
    }

    fn neg(&mut self, (operand, place): Lowered, span: Span) -> Lowered {
        self.part(span, |lowerer| lowerer.neg(operand?, place, span))
    }

    fn chain(&mut self, first: Lowered, rest: Vec<(BinaryOp, Lowered)>, span: Span) -> Lowered {
        self.part(span, |lowerer| lowerer.chain(first, rest))
    }

    fn ite(&mut self, cases: Vec<(Lowered, Lowered)>, otherwise: Lowered, span: Span) -> Lowered {
        self.part(span, |lowerer| lowerer.conditional(cases, otherwise))
    }

    fn call(&mut self, function: Ident, arguments: Vec<Lowered>, span: Span) -> Lowered {
        let env = self.env;
        self.part(span, |lowerer| {
            let operands = arguments.into_iter().map(|(e, s)| Some((e?, s)));
            let operands: Vec<Operand> = operands.collect::<Option<_>>()?;
            let name = lowerer.scope.rename(&function.name, env).0.to_owned();
            lowerer.call(&name, function.span, &operands, span)
        })
    }

    fn command(&mut self, command: Command<Lowered>) -> Command<Lowered> {
        command
    }
}
