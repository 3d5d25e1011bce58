//! Temporal formulas as trees.

use crate::ast::{Expr, Span};
use meliora_model::expr::ExprId;

/// A temporal formula with its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Formula {
    /// Form of the formula.
    pub kind: FormulaKind,
    /// Place in the text, without enclosing brackets.
    pub span: Span,
}

/// The forms of formulas.
#[derive(Debug, Clone, PartialEq)]
pub enum FormulaKind {
    /// A condition on the present state.
    State(Expr),
    /// The same, as an expression in the pool of a program.
    Known(ExprId),
    /// A condition on the present state with operators of properties, by its number in the property.
    Nested(usize),
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
    Weak(Steps, Box<Formula>, Box<Formula>),
    /// `φ R ψ`
    Release(Steps, Box<Formula>, Box<Formula>),
    /// `φ M ψ`: `φ R ψ`, and φ at some point.
    Strong(Box<Formula>, Box<Formula>),
}

/// Bounds on the number of steps, `<=10` or `[2,5]`, as constant expressions not yet evaluated.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Steps {
    /// Lower bound; the flag says that the bound itself is excluded.
    pub least: Option<(Expr, bool)>,
    /// Upper bound; the flag says that the bound itself is excluded.
    pub most: Option<(Expr, bool)>,
}

impl Formula {
    /// Returns the formula `F e`.
    pub fn reaching(e: Expr) -> Self {
        let span = e.span();
        let target = Box::new(Formula { kind: FormulaKind::State(e), span });
        Formula { kind: FormulaKind::Eventually(Steps::default(), target), span }
    }

    /// Returns true for a formula without temporal operators.
    pub fn is_state_formula(&self) -> bool {
        matches!(self.kind, FormulaKind::State(_) | FormulaKind::Known(_) | FormulaKind::Nested(_))
    }

    /// Returns the target `e` if the formula is the reachability `F e` of a state formula.
    pub fn reachability(&self) -> Option<&Expr> {
        match self.eventually()? {
            FormulaKind::State(e) => Some(e),
            _ => None,
        }
    }

    /// Does the same as [`Formula::reachability`] for a target that is in the pool of a program.
    pub fn known_target(&self) -> Option<ExprId> {
        match self.eventually()? {
            FormulaKind::Known(id) => Some(*id),
            _ => None,
        }
    }

    /// Returns φ if the formula is `F φ` without bounds.
    fn eventually(&self) -> Option<&FormulaKind> {
        match &self.kind {
            FormulaKind::Eventually(Steps { least: None, most: None }, inner) => Some(&inner.kind),
            _ => None,
        }
    }

    /// Returns the operands.
    pub(crate) fn operands(&self) -> Vec<&Formula> {
        match &self.kind {
            FormulaKind::State(_) | FormulaKind::Known(_) | FormulaKind::Nested(_) => Vec::new(),
            FormulaKind::And(all) | FormulaKind::Or(all) => all.iter().collect(),
            FormulaKind::Not(a)
            | FormulaKind::Next(a)
            | FormulaKind::Eventually(_, a)
            | FormulaKind::Always(_, a) => vec![a],
            FormulaKind::Implies(a, b)
            | FormulaKind::Iff(a, b)
            | FormulaKind::Until(_, a, b)
            | FormulaKind::Weak(_, a, b)
            | FormulaKind::Release(_, a, b)
            | FormulaKind::Strong(a, b) => vec![a, b],
        }
    }
    /// Returns the operands, to be changed.
    pub fn operands_mut(&mut self) -> Vec<&mut Formula> {
        match &mut self.kind {
            FormulaKind::State(_) | FormulaKind::Known(_) | FormulaKind::Nested(_) => Vec::new(),
            FormulaKind::And(all) | FormulaKind::Or(all) => all.iter_mut().collect(),
            FormulaKind::Not(a)
            | FormulaKind::Next(a)
            | FormulaKind::Eventually(_, a)
            | FormulaKind::Always(_, a) => vec![a],
            FormulaKind::Implies(a, b)
            | FormulaKind::Iff(a, b)
            | FormulaKind::Until(_, a, b)
            | FormulaKind::Weak(_, a, b)
            | FormulaKind::Release(_, a, b)
            | FormulaKind::Strong(a, b) => vec![a, b],
        }
    }

    /// Returns the bounds on the number of steps, to be changed.
    pub(crate) fn bounds_mut(&mut self) -> Vec<&mut Expr> {
        match &mut self.kind {
            FormulaKind::Eventually(steps, _)
            | FormulaKind::Always(steps, _)
            | FormulaKind::Until(steps, _, _)
            | FormulaKind::Weak(steps, _, _)
            | FormulaKind::Release(steps, _, _) => {
                [&mut steps.least, &mut steps.most].into_iter().flatten().map(|(e, _)| e).collect()
            }
            _ => Vec::new(),
        }
    }
}
