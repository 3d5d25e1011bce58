//! Constructors that simplify: for formulas that are made by rewriting.
//!
//! Only syntax is compared, so that each step is cheap: an implication between two formulas is found
//! by the shape of both.

use super::formulas::{Form, FormulaId, Formulas, Limit, Window};
use meliora_base::stack;

impl Formulas {
    /// Returns the simplified conjunction (or disjunction): without parts that others imply (or
    /// that imply others), and constant if two parts contradict each other.
    pub(crate) fn simple_join(
        &mut self,
        conjunction: bool,
        parts: impl IntoIterator<Item = FormulaId>,
    ) -> FormulaId {
        let joined = self.join(conjunction, parts);
        let mut parts = match self.form(joined) {
            Form::And(parts) if conjunction => parts.to_vec(),
            Form::Or(parts) if !conjunction => parts.to_vec(),
            _ => return joined,
        };
        parts.sort_unstable();
        parts.dedup();
        let mut kept: Vec<FormulaId> = Vec::with_capacity(parts.len());
        for part in parts {
            let not = self.negated(part);
            if kept.iter().any(|&k| self.orders(conjunction, k, not)) {
                return Self::constant(!conjunction);
            }
            if kept.iter().any(|&k| self.orders(conjunction, k, part)) {
                continue;
            }
            kept.retain(|&k| !self.orders(conjunction, part, k));
            kept.push(part);
        }
        self.join(conjunction, kept)
    }

    /// Returns true if a visibly implies b; if not `forwards`, if b implies a.
    fn orders(&mut self, forwards: bool, a: FormulaId, b: FormulaId) -> bool {
        if forwards { self.implies(a, b) } else { self.implies(b, a) }
    }

    /// Returns φ & ψ, simplified.
    pub(crate) fn both(&mut self, a: FormulaId, b: FormulaId) -> FormulaId {
        self.simple_join(true, [a, b])
    }

    /// Returns φ | ψ, simplified.
    pub(crate) fn either(&mut self, a: FormulaId, b: FormulaId) -> FormulaId {
        self.simple_join(false, [a, b])
    }

    /// Returns `X φ`, simplified: a limit does not depend on a single step.
    pub(crate) fn simple_next(&mut self, f: FormulaId) -> FormulaId {
        if self.limit(f).is_some() { f } else { self.next(f) }
    }

    /// Returns `left U[window] right` if `until`, `left R[window] right` otherwise, simplified. The
    /// rules are those of U; those of R are their duals.
    pub(crate) fn simple_binary(
        &mut self,
        until: bool,
        window: Window,
        left: FormulaId,
        right: FormulaId,
    ) -> FormulaId {
        if window.least > 0 {
            return self.binary(until, window, left, right);
        }
        // If φ implies ψ, then φ U ψ is ψ. φ U (G F ψ) is G F ψ.
        if left == Self::constant(!until) || self.limit(right).is_some() || self.orders(until, left, right) {
            return right;
        }
        if window != Window::ALWAYS {
            return self.binary(until, window, left, right);
        }
        // If !ψ implies φ, then φ U ψ is F ψ.
        let not = self.negated(right);
        let left = if self.orders(until, not, left) { Self::constant(until) } else { left };
        match self.form(right).clone() {
            // If φ implies χ, then φ U (χ U ψ) is χ U ψ.
            Form::Until(Window::ALWAYS, inner, _) if until && self.implies(left, inner) => right,
            Form::Release(Window::ALWAYS, inner, _) if !until && self.implies(inner, left) => right,
            // F (φ U ψ) is F ψ.
            Form::Until(Window::ALWAYS, _, last) if until && left == Self::TRUE => self.eventually(last),
            Form::Release(Window::ALWAYS, _, last) if !until && left == Self::FALSE => self.always(last),
            Form::Release(Window::ALWAYS, Self::FALSE, inner) if until && left == Self::TRUE => {
                self.settled(inner)
            }
            Form::Until(Window::ALWAYS, Self::TRUE, inner) if !until && left == Self::FALSE => {
                self.again(inner)
            }
            _ => self.binary(until, Window::ALWAYS, left, right),
        }
    }

    /// Returns `G F φ`, simplified.
    pub(crate) fn again(&mut self, f: FormulaId) -> FormulaId {
        stack::level(|| match self.form(f).clone() {
            Form::Constant(_) => f,
            _ if self.limit(f).is_some() => f,
            Form::Next(inner) => self.again(inner),
            Form::Until(window, left, right) if window.least == 0 || left == Self::TRUE => self.again(right),
            Form::Release(Window::ALWAYS, Self::FALSE, inner) => self.settled(inner),
            Form::Or(parts) => {
                let parts: Vec<FormulaId> = parts.iter().map(|&p| self.again(p)).collect();
                self.simple_join(false, parts)
            }
            _ => self.recurring(f),
        })
    }

    /// Returns `F G φ`, simplified.
    pub(crate) fn settled(&mut self, f: FormulaId) -> FormulaId {
        let not = self.negated(f);
        let again = self.again(not);
        self.negated(again)
    }

    /// Returns true if f visibly implies g.
    pub(crate) fn implies(&mut self, f: FormulaId, g: FormulaId) -> bool {
        if f == g || f == Self::FALSE || g == Self::TRUE {
            return true;
        }
        if f == Self::TRUE || g == Self::FALSE {
            return false;
        }
        if let Some(&known) = self.implications.get(&(f, g)) {
            return known;
        }
        let found = stack::level(|| self.implies_by_shape(f, g));
        self.implications.insert((f, g), found);
        found
    }

    fn implies_by_shape(&mut self, f: FormulaId, g: FormulaId) -> bool {
        let (left, right) = (self.form(f).clone(), self.form(g).clone());
        match (&left, &right) {
            (_, Form::And(parts)) => return parts.iter().all(|&p| self.implies(f, p)),
            (Form::Or(parts), _) => return parts.iter().all(|&p| self.implies(p, g)),
            (Form::And(parts), _) if parts.iter().any(|&p| self.implies(p, g)) => return true,
            (_, Form::Or(parts)) if parts.iter().any(|&p| self.implies(f, p)) => return true,
            (Form::Next(a), Form::Next(b)) => return self.implies(*a, *b),
            _ => {}
        }
        match (self.limit(f), self.limit(g)) {
            (Some(Limit::Settled(a)), Some(Limit::Again(b))) if self.implies(a, b) => return true,
            (Some(Limit::Again(_)), Some(Limit::Settled(_))) => return false,
            _ => {}
        }
        self.implies_an_operator(f, &right) || self.operator_implies(&left, g) || self.monotone(&left, &right)
    }

    /// f implies φ U ψ if it implies ψ; it implies φ R ψ if it implies both.
    fn implies_an_operator(&mut self, f: FormulaId, g: &Form) -> bool {
        match *g {
            Form::Until(Window { least: 0, .. }, _, b) => self.implies(f, b),
            Form::Release(Window { least: 0, .. }, a, b) => self.implies(f, a) && self.implies(f, b),
            _ => false,
        }
    }

    /// φ R ψ implies ψ; φ U ψ implies what both imply.
    fn operator_implies(&mut self, f: &Form, g: FormulaId) -> bool {
        match *f {
            Form::Until(Window { least: 0, .. }, a, b) => self.implies(a, g) && self.implies(b, g),
            Form::Release(Window { least: 0, .. }, _, b) => self.implies(b, g),
            _ => false,
        }
    }

    /// Operators are monotone, and φ U ψ implies ψ R (φ | ψ).
    fn monotone(&mut self, f: &Form, g: &Form) -> bool {
        match (f, g) {
            (&Form::Until(w, a, b), &Form::Until(v, c, d))
            | (&Form::Release(w, a, b), &Form::Release(v, c, d)) => {
                w == v && self.implies(a, c) && self.implies(b, d)
            }
            (&Form::Until(Window::ALWAYS, a, b), &Form::Release(Window::ALWAYS, c, d)) => {
                self.implies(b, c) && self.implies(b, d) && self.implies(a, d)
            }
            _ => false,
        }
    }
}
