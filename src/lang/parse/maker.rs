//! Representation of expressions and commands, chosen by the caller of the parser.
//!
//! A tree needs many times the memory of its text. A model that is only flattened therefore never
//! becomes a tree. The places of its parts are kept, and each part is parsed again when it is
//! needed, directly into the pool.

use crate::lang::ast::{BinaryOp, Command, Expr, ExprKind, Ident, Span};

/// An expression without parts.
pub(crate) enum Atom<'t> {
    Bool(bool),
    Int(i64),
    Real(f64),
    Name(&'t str),
    Label(&'t str),
}

/// Makes the representation of each part of an expression, from the innermost parts on.
pub(crate) trait Maker {
    /// Representation of an expression.
    type Expr: Clone;
    /// Representation of a command.
    type Command;

    fn atom(&mut self, atom: Atom<'_>, span: Span) -> Self::Expr;

    /// Makes `!e`.
    fn not(&mut self, operand: Self::Expr, span: Span) -> Self::Expr;

    /// Makes `-e`.
    fn neg(&mut self, operand: Self::Expr, span: Span) -> Self::Expr;

    /// Makes `e op e op e …`, operators of one level; the list is not empty.
    fn chain(&mut self, first: Self::Expr, rest: Vec<(BinaryOp, Self::Expr)>, span: Span) -> Self::Expr;

    /// Makes `c ? e : c ? e : … e`; the list is not empty.
    fn ite(&mut self, cases: Vec<(Self::Expr, Self::Expr)>, otherwise: Self::Expr, span: Span) -> Self::Expr;

    /// Makes `f(e, …)`.
    fn call(&mut self, function: Ident, arguments: Vec<Self::Expr>, span: Span) -> Self::Expr;

    fn command(&mut self, command: Command<Self::Expr>) -> Self::Command;
}

/// Makes syntax trees.
pub(crate) struct Trees;

impl Maker for Trees {
    type Expr = Expr;
    type Command = Command;

    fn atom(&mut self, atom: Atom<'_>, span: Span) -> Expr {
        let kind = match atom {
            Atom::Bool(b) => ExprKind::Bool(b),
            Atom::Int(i) => ExprKind::Int(i),
            Atom::Real(x) => ExprKind::Real(x),
            Atom::Name(name) => ExprKind::Name(name.to_owned()),
            Atom::Label(name) => ExprKind::Label(name.to_owned()),
        };
        Expr { kind, span }
    }

    fn not(&mut self, operand: Expr, span: Span) -> Expr {
        Expr { kind: ExprKind::Not(Box::new(operand)), span }
    }

    fn neg(&mut self, operand: Expr, span: Span) -> Expr {
        Expr { kind: ExprKind::Neg(Box::new(operand)), span }
    }

    fn chain(&mut self, first: Expr, mut rest: Vec<(BinaryOp, Expr)>, span: Span) -> Expr {
        // Frees unused capacity.
        rest.shrink_to_fit();
        Expr { kind: ExprKind::Chain(Box::new(first), rest), span }
    }

    fn ite(&mut self, cases: Vec<(Expr, Expr)>, otherwise: Expr, span: Span) -> Expr {
        Expr { kind: ExprKind::Ite(cases, Box::new(otherwise)), span }
    }

    fn call(&mut self, function: Ident, arguments: Vec<Expr>, span: Span) -> Expr {
        Expr { kind: ExprKind::Call(Box::new(function), arguments), span }
    }

    fn command(&mut self, command: Command) -> Command {
        command
    }
}

/// Keeps only the places.
pub(crate) struct Places;

impl Maker for Places {
    type Expr = Span;
    type Command = Span;

    fn atom(&mut self, _: Atom<'_>, span: Span) -> Span {
        span
    }

    fn not(&mut self, _: Span, span: Span) -> Span {
        span
    }

    fn neg(&mut self, _: Span, span: Span) -> Span {
        span
    }

    fn chain(&mut self, _: Span, _: Vec<(BinaryOp, Span)>, span: Span) -> Span {
        span
    }

    fn ite(&mut self, _: Vec<(Span, Span)>, _: Span, span: Span) -> Span {
        span
    }

    fn call(&mut self, _: Ident, _: Vec<Span>, span: Span) -> Span {
        span
    }

    fn command(&mut self, command: Command<Span>) -> Span {
        command.span
    }
}

/// Makes from a tree the same result as from its text.
pub(crate) fn remade<M: Maker>(e: &Expr, maker: &mut M) -> M::Expr {
    let span = e.span;
    match &e.kind {
        ExprKind::Bool(b) => maker.atom(Atom::Bool(*b), span),
        ExprKind::Int(i) => maker.atom(Atom::Int(*i), span),
        ExprKind::Real(x) => maker.atom(Atom::Real(*x), span),
        ExprKind::Name(name) => maker.atom(Atom::Name(name), span),
        ExprKind::Label(name) => maker.atom(Atom::Label(name), span),
        ExprKind::Not(operand) => {
            let operand = remade(operand, maker);
            maker.not(operand, span)
        }
        ExprKind::Neg(operand) => {
            let operand = remade(operand, maker);
            maker.neg(operand, span)
        }
        ExprKind::Chain(first, rest) => {
            let first = remade(first, maker);
            let rest = rest.iter().map(|(op, e)| (*op, remade(e, maker))).collect();
            maker.chain(first, rest, span)
        }
        ExprKind::Ite(cases, otherwise) => {
            let cases = cases.iter().map(|(c, e)| (remade(c, maker), remade(e, maker))).collect();
            let otherwise = remade(otherwise, maker);
            maker.ite(cases, otherwise, span)
        }
        ExprKind::Call(function, arguments) => {
            let arguments = arguments.iter().map(|e| remade(e, maker)).collect();
            maker.call(Ident::clone(function), arguments, span)
        }
    }
}
