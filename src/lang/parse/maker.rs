//! What is made of expressions and commands while they are read.
//!
//! A tree takes many times the memory of its text. So a model that is only to be flattened never has one:
//! the places of its parts are kept, and each is read again when its turn comes, straight into the pool.

use crate::lang::ast::{BinaryOp, Command, Expr, ExprKind, Ident, Span};

/// An expression without parts.
pub(crate) enum Atom<'t> {
    Bool(bool),
    Int(i64),
    Real(f64),
    Name(&'t str),
    Label(&'t str),
}

/// Makes something of each part of an expression, from the innermost ones on.
pub(crate) trait Maker {
    /// What an expression becomes.
    type Expr: Clone;
    /// What a command becomes.
    type Command;
    /// Whether rewards are kept, which are checked for syntax and mean nothing here.
    const KEEPS_REWARDS: bool;

    fn atom(&mut self, atom: Atom<'_>, span: Span) -> Self::Expr;

    /// `!e`
    fn not(&mut self, operand: Self::Expr, span: Span) -> Self::Expr;

    /// `-e`
    fn neg(&mut self, operand: Self::Expr, span: Span) -> Self::Expr;

    /// `e op e op e …`, operators of one level; the list is not empty.
    fn chain(&mut self, first: Self::Expr, rest: Vec<(BinaryOp, Self::Expr)>, span: Span) -> Self::Expr;

    /// `c ? e : c ? e : … e`; the list is not empty.
    fn ite(&mut self, cases: Vec<(Self::Expr, Self::Expr)>, otherwise: Self::Expr, span: Span) -> Self::Expr;

    /// `f(e, …)`
    fn call(&mut self, function: Ident, arguments: Vec<Self::Expr>, span: Span) -> Self::Expr;

    fn command(&mut self, command: Command<Self::Expr>) -> Self::Command;
}

/// Makes trees.
pub(crate) struct Trees;

impl Maker for Trees {
    type Expr = Expr;
    type Command = Command;
    const KEEPS_REWARDS: bool = true;

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
        // No room is left for what will not come.
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

/// Keeps only where everything stands.
pub(crate) struct Places;

impl Maker for Places {
    type Expr = Span;
    type Command = Span;
    const KEEPS_REWARDS: bool = false;

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

/// Makes of a tree what would have been made of its text.
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
