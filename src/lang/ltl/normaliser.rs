//! Brings formulas into negation normal form.

use std::sync::Arc;

use super::formula::{Formula, FormulaKind, Steps};
use crate::ast::Expr;
use meliora_base::error::{Diagnostic, Error, Result, SourceFile};
use meliora_base::span::Span;
use meliora_ltl::{Form, FormulaId, Formulas, Window};
use meliora_model::expr::ExprId;

/// Maximum number of parts of a normal form: each `<=>` between temporal formulas doubles them.
const MOST_PARTS: usize = 20_000;

/// The meaning of state formulas and bounds in a model.
pub(super) trait Meaning {
    /// Returns a state formula as an expression in the pool of the program.
    ///
    /// # Errors
    /// Unknown names and wrong types.
    fn state(&mut self, e: &Expr) -> Result<ExprId>;
    /// Names a state formula by its place in the text.
    fn name(&mut self, _: ExprId, _: Span) {}
    /// Returns the value of a bound.
    ///
    /// # Errors
    /// The bound is not a constant, or negative.
    fn bound(&mut self, e: &Expr) -> Result<u64>;
    /// Returns a literal as an atom with its sign, or a constant.
    fn literal(&mut self, e: ExprId, positive: bool) -> Form;
    /// Joins literals of one state into a single one.
    fn fold(&mut self, conjunction: bool, literals: &[(ExprId, bool)]) -> Form;
    /// Returns the text that the formula was read from.
    fn source(&self) -> &Arc<SourceFile>;
}

/// Brings formulas into negation normal form.
pub(super) struct Normaliser<'a, M: Meaning> {
    meaning: &'a mut M,
    all: &'a mut Formulas,
    parts: usize,
}

impl<'a, M: Meaning> Normaliser<'a, M> {
    pub(super) fn new(meaning: &'a mut M, all: &'a mut Formulas) -> Self {
        Normaliser { meaning, all, parts: 0 }
    }

    /// Returns the normal form of a formula, or of its negation if `positive` is false.
    ///
    /// # Errors
    /// A state formula or a bound is wrong; the normal form is too large.
    pub(super) fn build(&mut self, f: &Formula, positive: bool) -> Result<FormulaId> {
        self.count(f.span)?;
        let built = self.built(f, positive)?;
        self.all.place(built, f.span);
        Ok(built)
    }

    fn built(&mut self, f: &Formula, positive: bool) -> Result<FormulaId> {
        match &f.kind {
            FormulaKind::State(e) => {
                let id = self.meaning.state(e)?;
                Ok(self.named(id, positive, e.span()))
            }
            FormulaKind::Known(id) => Ok(self.named(*id, positive, f.span)),
            FormulaKind::Not(a) => self.build(a, !positive),
            FormulaKind::And(all) | FormulaKind::Or(all) => {
                let parts = all.iter().map(|a| self.build(a, positive)).collect::<Result<_>>()?;
                Ok(self.join(matches!(f.kind, FormulaKind::And(_)) == positive, parts))
            }
            FormulaKind::Implies(a, b) => {
                let parts = vec![self.build(a, !positive)?, self.build(b, positive)?];
                Ok(self.join(!positive, parts))
            }
            FormulaKind::Iff(a, b) => {
                let both = vec![self.build(a, true)?, self.build(b, positive)?];
                let neither = vec![self.build(a, false)?, self.build(b, !positive)?];
                let cases = vec![self.join(true, both), self.join(true, neither)];
                Ok(self.join(false, cases))
            }
            FormulaKind::Next(a) => {
                let a = self.build(a, positive)?;
                Ok(self.all.next(a))
            }
            FormulaKind::Eventually(steps, a) => {
                let (window, right) = (self.window(steps, f.span)?, self.build(a, positive)?);
                Ok(self.all.binary(positive, window, Formulas::constant(positive), right))
            }
            FormulaKind::Always(steps, a) => {
                let (window, right) = (self.window(steps, f.span)?, self.build(a, positive)?);
                Ok(self.all.binary(!positive, window, Formulas::constant(!positive), right))
            }
            FormulaKind::Until(steps, a, b) => {
                let (left, right) = (self.build(a, positive)?, self.build(b, positive)?);
                let window = self.window(steps, f.span)?;
                Ok(self.all.binary(positive, window, left, right))
            }
            FormulaKind::Release(steps, a, b) => {
                let window = self.window(steps, f.span)?;
                let (left, right) = (self.build(a, positive)?, self.build(b, positive)?);
                Ok(self.all.binary(!positive, window, left, right))
            }
            FormulaKind::Weak(steps, a, b) if steps.least.is_some() => {
                self.weak(steps, (a, b), f.span, positive)
            }
            // a W b = b R (a | b), and its negation is !b U (!a & !b).
            FormulaKind::Weak(steps, a, b) => {
                let window = self.window(steps, f.span)?;
                self.shifted(false, window, (a, b), positive)
            }
            // a M b = b U (a & b), and its negation is !b R (!a | !b).
            FormulaKind::Strong(a, b) => self.shifted(true, Window::ALWAYS, (b, a), positive),
            FormulaKind::Nested(_) => {
                let message = "operators of properties are not conditions on one state";
                Err(Diagnostic::new(self.meaning.source(), f.span.range(), message).into())
            }
        }
    }

    /// Returns `b R (a | b)`, or for `until` `a U (a & b)`, or the negation.
    fn shifted(
        &mut self,
        until: bool,
        window: Window,
        (a, b): (&Formula, &Formula),
        positive: bool,
    ) -> Result<FormulaId> {
        let (a, b) = (self.build(a, positive)?, self.build(b, positive)?);
        let right = self.join(until == positive, vec![a, b]);
        let first = if until { a } else { b };
        Ok(self.all.binary(until == positive, window, first, right))
    }

    /// Returns `a W b` with a least number of steps: PRISM's `!((a & !b) U (!a & !b))`, where `a & !b` is
    /// also required before the bounds.
    fn weak(
        &mut self,
        steps: &Steps,
        (a, b): (&Formula, &Formula),
        span: Span,
        positive: bool,
    ) -> Result<FormulaId> {
        let window = self.window(steps, span)?;
        let parts = vec![self.build(a, !positive)?, self.build(b, positive)?];
        let left = self.join(!positive, parts);
        let parts = vec![self.build(a, positive)?, self.build(b, positive)?];
        let right = self.join(!positive, parts);
        Ok(self.all.binary(!positive, window, left, right))
    }

    fn named(&mut self, e: ExprId, positive: bool, span: Span) -> FormulaId {
        self.meaning.name(e, span);
        let literal = self.meaning.literal(e, positive);
        self.all.add(literal)
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
    fn join(&mut self, conjunction: bool, parts: Vec<FormulaId>) -> FormulaId {
        let (mut literals, mut others) = (Vec::new(), Vec::new());
        let flat = self.all.join(conjunction, parts);
        let parts = match self.all.form(flat) {
            Form::And(parts) if conjunction => parts,
            Form::Or(parts) if !conjunction => parts,
            _ => return flat,
        };
        for &part in parts.iter() {
            match *self.all.form(part) {
                Form::Literal(e, positive) => literals.push((e, positive)),
                _ => others.push(part),
            }
        }
        if !literals.is_empty() {
            let literal = self.meaning.fold(conjunction, &literals);
            others.insert(0, self.all.add(literal));
        }
        self.all.join(conjunction, others)
    }

    fn window(&mut self, steps: &Steps, span: Span) -> Result<Window> {
        let mut read = |bound: &Option<(Expr, bool)>| {
            let value = |(e, strict): &(Expr, bool)| Ok::<_, Error>((self.meaning.bound(e)?, *strict));
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
