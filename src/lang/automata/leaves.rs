//! Division of a normal form into leaves under `&` and `|`: co-safe, safe, recurrence, persistence.
//!
//! Equivalences that move operators, each also in its dual form:
//! - `G (φ & ψ)` is `G φ & G ψ`; `G F (φ | ψ)` is `G F φ | G F ψ`.
//! - `G G φ` is `G φ`, and `F G F φ` is `G F φ`.
//! - X moves inwards, and vanishes before `G F φ`.

use super::normal::{Form, Normal, Window};
use meliora_model::span::Span;
use meliora_model::temporal::Asks;

/// Leaves under `&` and `|`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Tree {
    Constant(bool),
    /// The kind of condition, with the co-safe formula that its monitor evaluates.
    Leaf(Asks, Normal),
    All(Vec<Tree>),
    Any(Vec<Tree>),
}

/// A part outside of the four kinds of leaves.
#[derive(Debug)]
pub(crate) struct Refused {
    pub(crate) span: Span,
    pub(crate) why: &'static str,
}

/// Divides a normal form into leaves.
///
/// # Errors
/// Returns the first part outside of the supported fragment.
pub(crate) fn leaves(n: &Normal) -> Result<Tree, Refused> {
    let divided = match &n.form {
        Form::Constant(value) => return Ok(Tree::Constant(*value)),
        // A disjunction of co-safe parts, or a conjunction of safe ones, gets a single monitor,
        // which is at most as large as several.
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

/// Returns the leaves of `G φ`, where φ is not safe.
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

/// Returns the leaves of `G F φ`, where φ is not co-safe and `eventually` is `F φ`.
fn again(n: &Normal, eventually: &Normal, span: Span) -> Result<Tree, Refused> {
    let f = |inner: &Normal| Normal::until(Window::ALWAYS, Normal::constant(true, span), inner.clone(), span);
    match &n.form {
        Form::Or(parts) => {
            Ok(Tree::Any(parts.iter().map(|p| always(&f(p), span)).collect::<Result<_, _>>()?))
        }
        Form::Next(inner) => always(&f(inner), span),
        // G F G φ is F G φ, and G F F φ is G F φ.
        Form::Release(Window::ALWAYS, left, _) if left.form == Form::Constant(false) => leaves(eventually),
        Form::Until(Window::ALWAYS, left, _) if left.form == Form::Constant(true) => always(n, span),
        _ => Err(Refused { span, why: "G F over a formula that is not co-safe" }),
    }
}

/// Puts X before each leaf.
fn after_a_step(tree: Tree) -> Tree {
    match tree {
        // `G F φ` and `F G φ` do not depend on any single step; `G φ` with another co-safe φ does:
        // X G φ is G X φ.
        Tree::Leaf(asks, n) if matches!(asks, Asks::Accept | Asks::Avoid) || !n.is_eventually() => {
            let span = n.span;
            Tree::Leaf(asks, n.next(span))
        }
        Tree::All(parts) => Tree::All(parts.into_iter().map(after_a_step).collect()),
        Tree::Any(parts) => Tree::Any(parts.into_iter().map(after_a_step).collect()),
        tree => tree,
    }
}

/// Returns the negation.
fn opposite(tree: Tree) -> Tree {
    match tree {
        Tree::Constant(value) => Tree::Constant(!value),
        Tree::Leaf(asks, n) => Tree::Leaf(asks.opposite(), n),
        Tree::All(parts) => Tree::Any(parts.into_iter().map(opposite).collect()),
        Tree::Any(parts) => Tree::All(parts.into_iter().map(opposite).collect()),
    }
}
