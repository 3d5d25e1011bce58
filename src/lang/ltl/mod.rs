//! Temporal formulas: linear temporal logic in PRISM's syntax, and the monitors that evaluate it.
//!
//! A formula is read ([`parse_formula`]), brought into negation normal form (`normaliser`) and divided
//! into leaves, each with a deterministic monitor (`crate::automata`). The monitor becomes a variable
//! of the flat program (`install`), and the formula becomes a [`crate::model::temporal::Condition`]
//! on states.

#[cfg(test)]
mod enumeration;
mod install;
mod normaliser;
mod parse;
mod wording;
#[cfg(test)]
mod words;

use super::ast::{Expr, Span};

pub use install::Monitoring;
pub use parse::parse_formula;

/// A temporal formula with its place. `E` is a state formula: a tree, or only its place in the
/// text.
#[derive(Debug, Clone, PartialEq)]
pub struct Formula<E = Expr> {
    /// Form of the formula.
    pub kind: FormulaKind<E>,
    /// Place in the text, without enclosing brackets.
    pub span: Span,
}

/// The forms of formulas.
#[derive(Debug, Clone, PartialEq)]
pub enum FormulaKind<E = Expr> {
    /// A condition on the present state.
    State(E),
    /// `!φ`
    Not(Box<Formula<E>>),
    /// `φ & ψ & …`
    And(Vec<Formula<E>>),
    /// `φ | ψ | …`
    Or(Vec<Formula<E>>),
    /// `φ => ψ`
    Implies(Box<Formula<E>>, Box<Formula<E>>),
    /// `φ <=> ψ`
    Iff(Box<Formula<E>>, Box<Formula<E>>),
    /// `X φ`
    Next(Box<Formula<E>>),
    /// `F φ`
    Eventually(Steps<E>, Box<Formula<E>>),
    /// `G φ`
    Always(Steps<E>, Box<Formula<E>>),
    /// `φ U ψ`
    Until(Steps<E>, Box<Formula<E>>, Box<Formula<E>>),
    /// `φ W ψ`
    Weak(Box<Formula<E>>, Box<Formula<E>>),
    /// `φ R ψ`
    Release(Box<Formula<E>>, Box<Formula<E>>),
}

/// Bounds on the number of steps, `<=10` or `[2,5]`, as constant expressions not yet evaluated.
#[derive(Debug, Clone, PartialEq)]
pub struct Steps<E = Expr> {
    /// Lower bound; the flag says that the bound itself is excluded.
    pub least: Option<(E, bool)>,
    /// Upper bound; the flag says that the bound itself is excluded.
    pub most: Option<(E, bool)>,
}

impl<E> Default for Steps<E> {
    fn default() -> Self {
        Steps { least: None, most: None }
    }
}

impl<E> Formula<E> {
    /// Returns the target `e` if the formula is the reachability `F e` of a state formula.
    pub fn reachability(&self) -> Option<&E> {
        match &self.kind {
            FormulaKind::Eventually(Steps { least: None, most: None }, inner) => match &inner.kind {
                FormulaKind::State(e) => Some(e),
                _ => None,
            },
            _ => None,
        }
    }

    /// Returns the operands.
    fn operands(&self) -> Vec<&Formula<E>> {
        match &self.kind {
            FormulaKind::State(_) => Vec::new(),
            FormulaKind::And(all) | FormulaKind::Or(all) => all.iter().collect(),
            FormulaKind::Not(a)
            | FormulaKind::Next(a)
            | FormulaKind::Eventually(_, a)
            | FormulaKind::Always(_, a) => vec![a],
            FormulaKind::Implies(a, b)
            | FormulaKind::Iff(a, b)
            | FormulaKind::Until(_, a, b)
            | FormulaKind::Weak(a, b)
            | FormulaKind::Release(a, b) => vec![a, b],
        }
    }
}
