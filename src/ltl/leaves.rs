//! Division of a formula into leaves under `&` and `|`, each of which one monitor decides.
//!
//! Equivalences that move operators, each also in its dual form:
//! - `G (φ & ψ)` is `G φ & G ψ`; `G F (φ | ψ)` is `G F φ | G F ψ`.
//! - `G G φ` is `G φ`, and `F G F φ` is `G F φ`.
//! - X moves inwards, and vanishes before `G F φ`, as do U and R.
//!
//! Formulas that are then neither in Π2 nor in Σ2 are normalised.

use std::collections::BTreeSet;

use super::formulas::{Form, FormulaId, Formulas, Window};
use super::normalisation::normalised;
use meliora_base::error::Error;
use meliora_base::span::Span;
use meliora_base::stack;
use meliora_model::temporal::Asks;

/// Leaves under `&` and `|`.
#[derive(Debug, Clone, PartialEq)]
pub enum Tree {
    /// `true`, `false`
    Constant(bool),
    /// A condition on the marks of one monitor.
    Leaf(Leaf),
    /// A conjunction.
    All(Vec<Tree>),
    /// A disjunction.
    Any(Vec<Tree>),
}

/// A condition on the marks of one monitor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leaf {
    /// The condition on the marks.
    pub asks: Asks,
    /// The formula of the monitor, of the class Π2: the leaf itself or its negation.
    pub watched: FormulaId,
    /// The smallest part of the text that the leaf comes from.
    pub span: Span,
}

/// A part of a formula that exceeds a limit.
#[derive(Debug)]
pub struct TooLarge {
    /// The place of the part.
    pub span: Span,
    /// The limit that it exceeds.
    pub limit: Error,
}

type Result<T> = std::result::Result<T, TooLarge>;

/// Divides a formula into leaves.
///
/// # Errors
/// A normal form is too large.
pub fn leaves(all: &mut Formulas, f: FormulaId) -> Result<Tree> {
    let span = all.place_of(f).unwrap_or_default();
    Division { all, span }.leaves(f)
}

struct Division<'a> {
    all: &'a mut Formulas,
    span: Span,
}

impl Division<'_> {
    fn leaves(&mut self, f: FormulaId) -> Result<Tree> {
        let outer = self.span;
        self.span = self.all.place_of(f).unwrap_or(outer);
        let tree = stack::level(|| self.divided(f));
        self.span = outer;
        tree
    }

    fn divided(&mut self, f: FormulaId) -> Result<Tree> {
        let form = self.all.form(f).clone();
        match form {
            Form::Constant(value) => Ok(Tree::Constant(value)),
            // A disjunction of co-safe parts, or a conjunction of safe ones, gets a single monitor,
            // which is at most as large as several.
            Form::And(parts) if !self.all.is_safe(f) => Ok(Tree::All(self.each(&parts)?)),
            Form::Or(parts) if !self.all.is_cosafe(f) => Ok(Tree::Any(self.each(&parts)?)),
            _ if self.all.is_cosafe(f) => Ok(self.leaf(Asks::Accept, f)),
            _ if self.all.is_safe(f) => Ok(self.leaf(Asks::Avoid, f)),
            // φ U ψ and φ R ψ are ψ if ψ is a limit: it does not depend on the step.
            Form::Until(Window { least: 0, .. }, _, right)
            | Form::Release(Window { least: 0, .. }, _, right)
                if self.all.limit(right).is_some() =>
            {
                self.leaves(right)
            }
            Form::Next(inner) => {
                let tree = self.leaves(inner)?;
                Ok(self.after_a_step(tree))
            }
            _ => match (self.all.is_always(f), self.all.is_eventually(f)) {
                (Some(inner), _) => self.always(f, inner),
                // F φ holds where G !φ does not.
                (_, Some(inner)) => {
                    let (not, never) = (self.all.negated(inner), self.all.negated(f));
                    Ok(self.always(never, not)?.opposite())
                }
                _ => self.other(f),
            },
        }
    }

    fn each(&mut self, parts: &[FormulaId]) -> Result<Vec<Tree>> {
        parts.iter().map(|&p| self.leaves(p)).collect()
    }

    fn leaf(&mut self, asks: Asks, f: FormulaId) -> Tree {
        let watched = match asks {
            Asks::Accept | Asks::Again => f,
            Asks::Avoid | Asks::Settle => self.all.negated(f),
        };
        Tree::Leaf(Leaf { asks, watched, span: self.span })
    }

    /// Returns the leaves of `f`, which is `G φ` and not safe.
    fn always(&mut self, f: FormulaId, inner: FormulaId) -> Result<Tree> {
        if self.all.is_cosafe(inner) {
            return Ok(self.leaf(Asks::Again, f));
        }
        match self.all.form(inner).clone() {
            Form::And(parts) => {
                let parts: Vec<FormulaId> = parts.iter().map(|&p| self.all.always(p)).collect();
                Ok(Tree::All(self.each(&parts)?))
            }
            Form::Next(later) => {
                let always = self.all.always(later);
                let tree = self.leaves(always)?;
                Ok(self.after_a_step(tree))
            }
            _ if self.all.is_always(inner).is_some() => self.leaves(inner),
            _ => match self.all.is_eventually(inner) {
                Some(recurring) => self.again(f, inner, recurring),
                None => self.other(f),
            },
        }
    }

    /// Returns the leaves of `f`, which is `G F φ`, where φ is not co-safe and `eventually` is `F φ`.
    fn again(&mut self, f: FormulaId, eventually: FormulaId, inner: FormulaId) -> Result<Tree> {
        match self.all.form(inner).clone() {
            Form::Or(parts) => {
                let parts: Vec<FormulaId> = parts.iter().map(|&p| self.all.recurring(p)).collect();
                Ok(Tree::Any(self.each(&parts)?))
            }
            Form::Next(later) => {
                let recurring = self.all.recurring(later);
                self.leaves(recurring)
            }
            // G F G φ is F G φ, and G F F φ is G F φ.
            _ if self.all.is_always(inner).is_some() => self.leaves(eventually),
            _ if self.all.is_eventually(inner).is_some() => {
                let always = self.all.always(inner);
                self.leaves(always)
            }
            _ => self.other(f),
        }
    }

    /// Puts X before each leaf.
    fn after_a_step(&mut self, tree: Tree) -> Tree {
        match tree {
            Tree::Leaf(leaf) => Tree::Leaf(Leaf { watched: self.step_before(leaf.watched), ..leaf }),
            Tree::All(parts) => Tree::All(parts.into_iter().map(|p| self.after_a_step(p)).collect()),
            Tree::Any(parts) => Tree::Any(parts.into_iter().map(|p| self.after_a_step(p)).collect()),
            tree => tree,
        }
    }

    /// Returns `X φ`. `X G φ` is `G X φ`, and `G F φ` does not depend on any single step.
    fn step_before(&mut self, f: FormulaId) -> FormulaId {
        match self.all.is_always(f) {
            Some(_) if self.all.limit(f).is_some() => f,
            Some(inner) => {
                let later = self.all.next(inner);
                self.all.always(later)
            }
            None => self.all.next(f),
        }
    }

    /// Returns the leaves of a formula that no equivalence divides.
    fn other(&mut self, f: FormulaId) -> Result<Tree> {
        if self.all.is_pi2(f) {
            return Ok(self.leaf(Asks::Again, f));
        }
        if self.all.is_sigma2(f) {
            return Ok(self.leaf(Asks::Settle, f));
        }
        let not = self.all.negated(f);
        let direct = self.normalised(f);
        let dual = self.normalised(not).map(Tree::opposite);
        match (direct, dual) {
            (Ok(direct), Ok(dual)) if self.cost(&dual) < self.cost(&direct) => Ok(dual),
            (Err(_), Ok(dual)) => Ok(dual),
            (direct, _) => direct,
        }
    }

    fn normalised(&mut self, f: FormulaId) -> Result<Tree> {
        let normal = normalised(self.all, f).map_err(|limit| TooLarge { span: self.span, limit })?;
        self.leaves(normal)
    }

    /// Returns the number of formulas that the leaves consist of.
    fn cost(&self, tree: &Tree) -> usize {
        let (mut open, mut watched) = (vec![tree], BTreeSet::new());
        while let Some(next) = open.pop() {
            match next {
                Tree::Constant(_) => {}
                Tree::Leaf(leaf) => drop(watched.insert(leaf.watched)),
                Tree::All(parts) | Tree::Any(parts) => open.extend(parts),
            }
        }
        watched.iter().map(|&f| self.all.size(f)).sum()
    }
}

impl Tree {
    /// Returns the negation.
    fn opposite(self) -> Tree {
        match self {
            Tree::Constant(value) => Tree::Constant(!value),
            Tree::Leaf(leaf) => Tree::Leaf(Leaf { asks: leaf.asks.opposite(), ..leaf }),
            Tree::All(parts) => Tree::Any(parts.into_iter().map(Tree::opposite).collect()),
            Tree::Any(parts) => Tree::All(parts.into_iter().map(Tree::opposite).collect()),
        }
    }
}
