//! Temporal formulas: linear temporal logic as PRISM writes it, and the monitors that judge it.
//!
//! A formula is read ([`parse_formula`]), brought into negation normal form (`normal`) and divided into
//! leaves under `&` and `|` (`leaves`), each co-safe, safe, a recurrence or a persistence. Each leaf has a
//! deterministic monitor (`progress`, `monitor`, `minimal`), which becomes a variable of the flat
//! program (`install`); what the formula asks is then a [`crate::model::temporal::Condition`] on states.

#[cfg(test)]
mod enumeration;
mod functions;
mod install;
mod leaves;
mod minimal;
mod monitor;
mod normal;
mod parse;
mod progress;
mod wording;
#[cfg(test)]
mod words;

use super::ast::{Expr, Span};

pub use install::Watching;
pub use parse::parse_formula;

/// A temporal formula at a place. Its state formulas are trees, or only their places in the text.
#[derive(Debug, Clone, PartialEq)]
pub struct Formula<E = Expr> {
    /// What it is.
    pub kind: FormulaKind<E>,
    /// Where it stands, without enclosing brackets.
    pub span: Span,
}

/// The forms of formulas.
#[derive(Debug, Clone, PartialEq)]
pub enum FormulaKind<E = Expr> {
    /// What holds in the present state.
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

/// Bounds on the number of steps, `<=10` or `[2,5]`: constants that are not evaluated yet.
#[derive(Debug, Clone, PartialEq)]
pub struct Steps<E = Expr> {
    /// The least number of steps; whether the bound itself is excluded.
    pub least: Option<(E, bool)>,
    /// The greatest number of steps; whether the bound itself is excluded.
    pub most: Option<(E, bool)>,
}

impl<E> Default for Steps<E> {
    fn default() -> Self {
        Steps { least: None, most: None }
    }
}

impl<E> Formula<E> {
    /// The target, where the formula is the reachability `F e` of a state formula.
    pub fn reachability(&self) -> Option<&E> {
        match &self.kind {
            FormulaKind::Eventually(Steps { least: None, most: None }, inner) => match &inner.kind {
                FormulaKind::State(e) => Some(e),
                _ => None,
            },
            _ => None,
        }
    }

    /// The operands.
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
