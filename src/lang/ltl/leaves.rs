//! A normal form as leaves under `&` and `|`: co-safe, safe, recurrence and persistence.
//!
//! Equivalences that move operators: `G (φ & ψ)` is `G φ & G ψ`, `F (φ | ψ)` is `F φ | F ψ`, `G F (φ | ψ)` is
//! `G F φ | G F ψ`, and dually; `G G φ`, `F F φ`, `G F G φ` and `F G F φ` lose their first operators; X goes
//! inwards and vanishes before `G F φ` and `F G φ`.

use super::normal::{Form, Normal, Window};
use crate::lang::ast::Span;
use crate::model::temporal::Asks;

/// Leaves under `&` and `|`.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Tree {
    Constant(bool),
    /// What is asked of a co-safe formula.
    Leaf(Asks, Normal),
    All(Vec<Tree>),
    Any(Vec<Tree>),
}

/// A part that is none of the four.
#[derive(Debug)]
pub(super) struct Refused {
    pub(super) span: Span,
    pub(super) why: &'static str,
}

/// Divides a normal form into leaves.
///
/// # Errors
/// The first part outside of the fragment.
pub(super) fn leaves(n: &Normal) -> Result<Tree, Refused> {
    let divided = match &n.form {
        Form::Constant(value) => return Ok(Tree::Constant(*value)),
        // What is safe or co-safe as a whole needs one monitor, where that is no larger than several.
        Form::Or(_) if n.is_cosafe() => None,
        Form::And(_) if n.is_safe() => None,
        Form::And(parts) => Some(Tree::All(parts.iter().map(leaves).collect::<Result<_, _>>()?)),
        Form::Or(parts) => Some(Tree::Any(parts.iter().map(leaves).collect::<Result<_, _>>()?)),
        _ => None,
    };
    if let Some(divided) = divided {
        return Ok(divided);
    }
    if n.is_cosafe() {
        return Ok(Tree::Leaf(Asks::Accept, n.clone()));
    }
    if n.is_safe() {
        return Ok(Tree::Leaf(Asks::Avoid, n.negated()));
    }
    match &n.form {
        Form::Next(inner) => Ok(after_a_step(leaves(inner)?)),
        Form::Release(Window::ALWAYS, left, right) if left.form == Form::Constant(false) => {
            always(right, n.span)
        }
        // F φ holds where G !φ does not.
        Form::Until(Window::ALWAYS, left, right) if left.form == Form::Constant(true) => {
            Ok(opposite(always(&right.negated(), n.span)?))
        }
        Form::Until(..) => {
            Err(Refused { span: n.span, why: "an until over a formula that is decided only in the limit" })
        }
        _ => Err(Refused { span: n.span, why: "a release over a formula that is decided only in the limit" }),
    }
}

/// The leaves of `G φ`, where φ is not safe.
fn always(n: &Normal, span: Span) -> Result<Tree, Refused> {
    if n.is_cosafe() {
        return Ok(Tree::Leaf(Asks::Again, n.clone()));
    }
    let g =
        |inner: &Normal| Normal::release(Window::ALWAYS, Normal::constant(false, span), inner.clone(), span);
    match &n.form {
        Form::And(parts) => Ok(Tree::All(parts.iter().map(|p| leaves(&g(p))).collect::<Result<_, _>>()?)),
        Form::Next(inner) => leaves(&g(inner).next(span)),
        Form::Release(Window::ALWAYS, left, _) if left.form == Form::Constant(false) => leaves(n),
        Form::Until(Window::ALWAYS, left, right) if left.form == Form::Constant(true) => {
            again(right, n, span)
        }
        _ => Err(Refused { span, why: "G over a formula that is neither safe nor co-safe" }),
    }
}

/// The leaves of `G F φ`, where φ is not co-safe and `eventually` is `F φ`.
fn again(n: &Normal, eventually: &Normal, span: Span) -> Result<Tree, Refused> {
    let f = |inner: &Normal| Normal::until(Window::ALWAYS, Normal::constant(true, span), inner.clone(), span);
    match &n.form {
        Form::Or(parts) => {
            Ok(Tree::Any(parts.iter().map(|p| always(&f(p), span)).collect::<Result<_, _>>()?))
        }
        Form::Next(inner) => always(&f(inner), span),
        // F G φ, and G F φ: to happen again and again from some step on is to happen again and again.
        Form::Release(Window::ALWAYS, left, _) if left.form == Form::Constant(false) => leaves(eventually),
        Form::Until(Window::ALWAYS, left, _) if left.form == Form::Constant(true) => always(n, span),
        _ => Err(Refused { span, why: "G F over a formula that is not co-safe" }),
    }
}

/// X before each leaf.
fn after_a_step(tree: Tree) -> Tree {
    match tree {
        // `G F φ` and `F G φ` do not depend on any one step; `G φ` with another co-safe φ does: X G φ is G X φ.
        Tree::Leaf(asks, n) if matches!(asks, Asks::Accept | Asks::Avoid) || !n.is_eventually() => {
            let span = n.span;
            Tree::Leaf(asks, n.next(span))
        }
        Tree::All(parts) => Tree::All(parts.into_iter().map(after_a_step).collect()),
        Tree::Any(parts) => Tree::Any(parts.into_iter().map(after_a_step).collect()),
        tree => tree,
    }
}

/// The negation.
fn opposite(tree: Tree) -> Tree {
    match tree {
        Tree::Constant(value) => Tree::Constant(!value),
        Tree::Leaf(asks, n) => Tree::Leaf(asks.opposite(), n),
        Tree::All(parts) => Tree::Any(parts.into_iter().map(opposite).collect()),
        Tree::Any(parts) => Tree::All(parts.into_iter().map(opposite).collect()),
    }
}
