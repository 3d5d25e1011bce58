//! Negation normal form: `!` only at state formulas, and X, U and R as the only temporal operators.

use meliora_model::expr::ExprId;
use meliora_model::span::Span;

/// A formula in negation normal form, with the place that it comes from.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct Normal {
    pub(crate) form: Form,
    pub(crate) span: Span,
}

/// The forms of a formula in negation normal form.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) enum Form {
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
pub(crate) struct Window {
    pub(crate) least: u64,
    pub(crate) most: Option<u64>,
}

impl Window {
    /// The interval of all steps.
    pub(crate) const ALWAYS: Window = Window { least: 0, most: None };
}

impl Normal {
    pub(crate) fn constant(value: bool, span: Span) -> Self {
        Normal { form: Form::Constant(value), span }
    }

    /// Returns `X φ`.
    pub(crate) fn next(self, span: Span) -> Self {
        match self.form {
            Form::Constant(_) => self,
            _ => Normal { form: Form::Next(Box::new(self)), span },
        }
    }

    /// Returns `left U[window] right`.
    pub(crate) fn until(window: Window, left: Normal, right: Normal, span: Span) -> Self {
        match right.form {
            Form::Constant(false) => right,
            Form::Constant(true) if window.least == 0 => right,
            _ => Normal { form: Form::Until(window, Box::new(left), Box::new(right)), span },
        }
    }

    /// Returns `left R[window] right`.
    pub(crate) fn release(window: Window, left: Normal, right: Normal, span: Span) -> Self {
        match right.form {
            Form::Constant(true) => right,
            Form::Constant(false) if window.least == 0 => right,
            _ => Normal { form: Form::Release(window, Box::new(left), Box::new(right)), span },
        }
    }

    /// Returns the conjunction (or the disjunction), flattened and without constants.
    pub(crate) fn join(conjunction: bool, parts: Vec<Normal>, span: Span) -> Self {
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
    pub(crate) fn negated(&self) -> Normal {
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
    pub(crate) fn is_eventually(&self) -> bool {
        matches!(&self.form, Form::Until(Window::ALWAYS, left, _) if left.form == Form::Constant(true))
    }

    /// Returns true for a syntactically co-safe formula (no unbounded R): every path that satisfies
    /// it has a prefix all of whose continuations satisfy it.
    pub(crate) fn is_cosafe(&self) -> bool {
        self.all(&|form| !matches!(form, Form::Release(Window { most: None, .. }, ..)))
    }

    /// Returns true for a syntactically safe formula (no unbounded U): every path that violates it
    /// has a prefix all of whose continuations violate it.
    pub(crate) fn is_safe(&self) -> bool {
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
