//! Temporal formulas: linear temporal logic as PRISM writes it, and the observers that judge it.
//!
//! A formula is read ([`parse_formula`]), brought into negation normal form (`normal`) and divided into
//! leaves under `&` and `|` (`leaves`), each co-safe, safe, a recurrence or a persistence. Each leaf has a
//! deterministic observer (`progress`, `observer`, `minimal`), which becomes a variable of the flat
//! program (`install`); what the formula asks is then a [`crate::model::temporal::Condition`] on states.

mod functions;
mod install;
mod leaves;
mod minimal;
mod normal;
mod observer;
mod parse;
mod progress;
mod wording;
#[cfg(test)]
mod words;

use super::ast::{Expr, Span};

pub use install::Watching;
pub use parse::parse_formula;

/// A temporal formula at a place.
#[derive(Debug, Clone, PartialEq)]
pub struct Formula {
    /// What it is.
    pub kind: FormulaKind,
    /// Where it stands, without enclosing brackets.
    pub span: Span,
}

/// The forms of formulas.
#[derive(Debug, Clone, PartialEq)]
pub enum FormulaKind {
    /// What holds in the present state.
    State(Expr),
    /// `!φ`
    Not(Box<Formula>),
    /// `φ & ψ & …`
    And(Vec<Formula>),
    /// `φ | ψ | …`
    Or(Vec<Formula>),
    /// `φ => ψ`
    Implies(Box<Formula>, Box<Formula>),
    /// `φ <=> ψ`
    Iff(Box<Formula>, Box<Formula>),
    /// `X φ`
    Next(Box<Formula>),
    /// `F φ`
    Eventually(Steps, Box<Formula>),
    /// `G φ`
    Always(Steps, Box<Formula>),
    /// `φ U ψ`
    Until(Steps, Box<Formula>, Box<Formula>),
    /// `φ W ψ`
    Weak(Box<Formula>, Box<Formula>),
    /// `φ R ψ`
    Release(Box<Formula>, Box<Formula>),
}

/// Bounds on the number of steps, `<=10` or `[2,5]`: constants that are not evaluated yet.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Steps {
    /// The least number of steps; whether the bound itself is excluded.
    pub least: Option<(Expr, bool)>,
    /// The greatest number of steps; whether the bound itself is excluded.
    pub most: Option<(Expr, bool)>,
}

impl Formula {
    /// The target, where the formula is the reachability `F e` of a state formula.
    pub fn reachability(&self) -> Option<&Expr> {
        match &self.kind {
            FormulaKind::Eventually(steps, inner) if *steps == Steps::default() => match &inner.kind {
                FormulaKind::State(e) => Some(e),
                _ => None,
            },
            _ => None,
        }
    }

    /// The operands.
    fn operands(&self) -> Vec<&Formula> {
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
