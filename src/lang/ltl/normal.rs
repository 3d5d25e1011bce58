//! Negation normal form: `!` only at state formulas, and X, U and R as the only temporal operators.

use super::{Formula, FormulaKind, Steps};
use crate::error::{Diagnostic, Error, Result, SourceFile};
use crate::lang::ast::Span;
use crate::model::expr::ExprId;

/// Maximum number of parts of a normal form: each `<=>` between temporal formulas doubles them.
const MOST_PARTS: usize = 20_000;

/// A formula in negation normal form, with the place that it comes from.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Normal {
    pub(super) form: Form,
    pub(super) span: Span,
}

/// The forms of a formula in negation normal form.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) enum Form {
    /// `true`, `false`
    Constant(bool),
    /// A state formula, or its negation.
    Literal(ExprId, bool),
    /// `φ & ψ & …`
    And(Vec<Normal>),
    /// `φ | ψ | …`
    Or(Vec<Normal>),
    /// `X φ`
    Next(Box<Normal>),
    /// `φ U[window] ψ`; `F ψ` is `true U ψ`.
    Until(Window, Box<Normal>, Box<Normal>),
    /// `φ R[window] ψ`; `G ψ` is `false R ψ`.
    Release(Window, Box<Normal>, Box<Normal>),
}

/// An interval of step numbers; `most` is `None` for an unbounded one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Window {
    pub(super) least: u64,
    pub(super) most: Option<u64>,
}

impl Window {
    /// The interval of all steps.
    pub(super) const ALWAYS: Window = Window { least: 0, most: None };
}

impl Normal {
    pub(super) fn constant(value: bool, span: Span) -> Self {
        Normal { form: Form::Constant(value), span }
    }

    /// Returns `X φ`.
    pub(super) fn next(self, span: Span) -> Self {
        match self.form {
            Form::Constant(_) => self,
            _ => Normal { form: Form::Next(Box::new(self)), span },
        }
    }

    /// Returns `left U[window] right`.
    pub(super) fn until(window: Window, left: Normal, right: Normal, span: Span) -> Self {
        match right.form {
            Form::Constant(false) => right,
            Form::Constant(true) if window.least == 0 => right,
            _ => Normal { form: Form::Until(window, Box::new(left), Box::new(right)), span },
        }
    }

    /// Returns `left R[window] right`.
    pub(super) fn release(window: Window, left: Normal, right: Normal, span: Span) -> Self {
        match right.form {
            Form::Constant(true) => right,
            Form::Constant(false) if window.least == 0 => right,
            _ => Normal { form: Form::Release(window, Box::new(left), Box::new(right)), span },
        }
    }

    /// Returns the conjunction (or the disjunction), flattened and without constants.
    pub(super) fn join(conjunction: bool, parts: Vec<Normal>, span: Span) -> Self {
        let mut flat = Vec::new();
        for part in parts {
            match part.form {
                Form::Constant(c) if c == conjunction => {}
                Form::Constant(_) => return part,
                Form::And(inner) if conjunction => flat.extend(inner),
                Form::Or(inner) if !conjunction => flat.extend(inner),
                _ => flat.push(part),
            }
        }
        match flat.len() {
            0 => Normal::constant(conjunction, span),
            1 => flat.swap_remove(0),
            _ if conjunction => Normal { form: Form::And(flat), span },
            _ => Normal { form: Form::Or(flat), span },
        }
    }

    /// Returns the negation.
    pub(super) fn negated(&self) -> Normal {
        let all = |parts: &[Normal]| parts.iter().map(Normal::negated).collect::<Vec<_>>();
        let each = |a: &Normal, b: &Normal| (Box::new(a.negated()), Box::new(b.negated()));
        let form = match &self.form {
            Form::Constant(c) => Form::Constant(!c),
            Form::Literal(e, positive) => Form::Literal(*e, !positive),
            Form::And(parts) => Form::Or(all(parts)),
            Form::Or(parts) => Form::And(all(parts)),
            Form::Next(a) => Form::Next(Box::new(a.negated())),
            Form::Until(w, a, b) => {
                let (a, b) = each(a, b);
                Form::Release(*w, a, b)
            }
            Form::Release(w, a, b) => {
                let (a, b) = each(a, b);
                Form::Until(*w, a, b)
            }
        };
        Normal { form, span: self.span }
    }

    /// Returns true for `F φ`.
    pub(super) fn is_eventually(&self) -> bool {
        matches!(&self.form, Form::Until(Window::ALWAYS, left, _) if left.form == Form::Constant(true))
    }

    /// Returns true for a syntactically co-safe formula (no unbounded R): every path that satisfies
    /// it has a prefix all of whose continuations satisfy it.
    pub(super) fn is_cosafe(&self) -> bool {
        self.all(&|form| !matches!(form, Form::Release(Window { most: None, .. }, ..)))
    }

    /// Returns true for a syntactically safe formula (no unbounded U): every path that violates it
    /// has a prefix all of whose continuations violate it.
    pub(super) fn is_safe(&self) -> bool {
        self.all(&|form| !matches!(form, Form::Until(Window { most: None, .. }, ..)))
    }

    fn all(&self, test: &dyn Fn(&Form) -> bool) -> bool {
        let mut open = vec![self];
        while let Some(next) = open.pop() {
            if !test(&next.form) {
                return false;
            }
            match &next.form {
                Form::Constant(_) | Form::Literal(..) => {}
                Form::And(parts) | Form::Or(parts) => open.extend(parts),
                Form::Next(a) => open.push(a),
                Form::Until(_, a, b) | Form::Release(_, a, b) => open.extend([&**a, &**b]),
            }
        }
        true
    }
}

/// The meaning of state formulas and bounds in a model.
pub(super) trait Meaning {
    /// State formulas and bounds before they are resolved.
    type Leaf;
    /// Returns a state formula as an expression in the pool of the program.
    ///
    /// # Errors
    /// Unknown names and wrong types.
    fn state(&mut self, e: &Self::Leaf) -> Result<ExprId>;
    /// Returns the value of a bound.
    ///
    /// # Errors
    /// The bound is not a constant, or negative.
    fn bound(&mut self, e: &Self::Leaf) -> Result<u64>;
    /// Returns a literal as an atom with its sign, or a constant.
    fn literal(&mut self, e: ExprId, positive: bool, span: Span) -> Normal;
    /// Joins literals of one state into a single one.
    fn fold(&mut self, conjunction: bool, literals: &[(ExprId, bool)], span: Span) -> Normal;
    /// Returns the text that the formula was read from.
    fn source(&self) -> &std::sync::Arc<SourceFile>;
}

/// Brings formulas into negation normal form.
pub(super) struct Normaliser<'a, M: Meaning> {
    meaning: &'a mut M,
    parts: usize,
}

impl<'a, M: Meaning> Normaliser<'a, M> {
    pub(super) fn new(meaning: &'a mut M) -> Self {
        Normaliser { meaning, parts: 0 }
    }

    /// Returns the normal form of a formula, or of its negation if `positive` is false.
    ///
    /// # Errors
    /// A state formula or a bound is wrong; the normal form is too large.
    pub(super) fn build(&mut self, f: &Formula<M::Leaf>, positive: bool) -> Result<Normal> {
        let span = f.span;
        self.count(span)?;
        match &f.kind {
            FormulaKind::State(e) => {
                let e = self.meaning.state(e)?;
                Ok(self.meaning.literal(e, positive, span))
            }
            FormulaKind::Not(a) => self.build(a, !positive),
            FormulaKind::And(all) | FormulaKind::Or(all) => {
                let parts = all.iter().map(|a| self.build(a, positive)).collect::<Result<_>>()?;
                Ok(self.join(matches!(f.kind, FormulaKind::And(_)) == positive, parts, span))
            }
            FormulaKind::Implies(a, b) => {
                let parts = vec![self.build(a, !positive)?, self.build(b, positive)?];
                Ok(self.join(!positive, parts, span))
            }
            FormulaKind::Iff(a, b) => {
                let both = vec![self.build(a, true)?, self.build(b, positive)?];
                let neither = vec![self.build(a, false)?, self.build(b, !positive)?];
                let cases = vec![self.join(true, both, span), self.join(true, neither, span)];
                Ok(self.join(false, cases, span))
            }
            FormulaKind::Next(a) => Ok(self.build(a, positive)?.next(span)),
            FormulaKind::Eventually(steps, a) => {
                let (window, right) = (self.window(steps, span)?, self.build(a, positive)?);
                Ok(until(positive, window, Normal::constant(positive, span), right, span))
            }
            FormulaKind::Always(steps, a) => {
                let (window, right) = (self.window(steps, span)?, self.build(a, positive)?);
                Ok(until(!positive, window, Normal::constant(!positive, span), right, span))
            }
            FormulaKind::Until(steps, a, b) => {
                let (left, right) = (self.build(a, positive)?, self.build(b, positive)?);
                Ok(until(positive, self.window(steps, span)?, left, right, span))
            }
            FormulaKind::Release(a, b) => {
                let (left, right) = (self.build(a, positive)?, self.build(b, positive)?);
                Ok(until(!positive, Window::ALWAYS, left, right, span))
            }
            FormulaKind::Weak(a, b) => {
                // a W b = b R (a | b), and its negation is !b U (!a & !b).
                let (left, first) = (self.build(a, positive)?, self.build(b, positive)?);
                let right = self.join(!positive, vec![left, first.clone()], span);
                Ok(until(!positive, Window::ALWAYS, first, right, span))
            }
        }
    }

    fn count(&mut self, span: Span) -> Result<()> {
        self.parts += 1;
        if self.parts > MOST_PARTS {
            let message = format!("the formula has more than {MOST_PARTS} parts when `<=>` is written out");
            return Err(Diagnostic::new(self.meaning.source(), span.range(), message).into());
        }
        Ok(())
    }

    /// Joins the parts; the literals among them become one.
    fn join(&mut self, conjunction: bool, parts: Vec<Normal>, span: Span) -> Normal {
        let mut literals: Vec<(ExprId, bool)> = Vec::new();
        let mut others = Vec::new();
        let flat = Normal::join(conjunction, parts, span);
        let parts = match flat.form {
            Form::And(parts) if conjunction => parts,
            Form::Or(parts) if !conjunction => parts,
            _ => return flat,
        };
        for part in parts {
            match part.form {
                Form::Literal(e, positive) => literals.push((e, positive)),
                _ => others.push(part),
            }
        }
        if !literals.is_empty() {
            others.insert(0, self.meaning.fold(conjunction, &literals, span));
        }
        Normal::join(conjunction, others, span)
    }

    fn window(&mut self, steps: &Steps<M::Leaf>, span: Span) -> Result<Window> {
        let mut read = |bound: &Option<(M::Leaf, bool)>| {
            let value = |(e, strict): &(M::Leaf, bool)| Ok::<_, Error>((self.meaning.bound(e)?, *strict));
            bound.as_ref().map(value).transpose()
        };
        let least = read(&steps.least)?.map_or(0, |(n, strict)| n + u64::from(strict));
        let most = match read(&steps.most)? {
            Some((0, true)) => return Err(self.empty(span)),
            Some((n, strict)) => Some(n - u64::from(strict)),
            None => None,
        };
        if most.is_some_and(|most| most < least) {
            return Err(self.empty(span));
        }
        Ok(Window { least, most })
    }

    fn empty(&self, span: Span) -> Error {
        let diagnostic =
            Diagnostic::new(self.meaning.source(), span.range(), "no number of steps is within these bounds");
        diagnostic.into()
    }
}

/// Returns `left U[window] right` if `until`, `left R[window] right` otherwise.
fn until(until: bool, window: Window, left: Normal, right: Normal, span: Span) -> Normal {
    if until { Normal::until(window, left, right, span) } else { Normal::release(window, left, right, span) }
}
