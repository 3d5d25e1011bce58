//! Formulas on paths, whose conditions on states may contain operators.

use super::check::Checker;
use super::term::{Path, Single, Step, Term, TermKind};
use crate::ast::{BinaryOp, Expr, NodeKind, Span};
use crate::check::lower_condition;
use crate::ltl::{Formula, FormulaKind, Steps};
use meliora_base::error::Result;
use meliora_base::value::{Type, Value};

/// Returns whether a formula is one temporal operator with bounds on the number of steps.
pub(super) fn is_bounded(formula: &Formula) -> bool {
    use FormulaKind::{Always, Eventually, Not, Release, Until, Weak};
    match &formula.kind {
        Not(a) => is_bounded(a),
        Eventually(steps, a) | Always(steps, a) => *steps != Steps::default() && is_condition(a),
        Until(steps, a, b) | Weak(steps, a, b) | Release(steps, a, b) => {
            *steps != Steps::default() && is_condition(a) && is_condition(b)
        }
        _ => false,
    }
}

/// Returns whether a formula has no temporal operators.
fn is_condition(formula: &Formula) -> bool {
    match &formula.kind {
        FormulaKind::State(_) | FormulaKind::Known(_) => true,
        FormulaKind::Not(_)
        | FormulaKind::And(_)
        | FormulaKind::Or(_)
        | FormulaKind::Implies(..)
        | FormulaKind::Iff(..) => formula.operands().into_iter().all(is_condition),
        _ => false,
    }
}

impl Checker<'_> {
    /// Checks a formula.
    pub(super) fn path(&mut self, formula: &Formula) -> Result<Path> {
        let (single, recurring) = (self.single(formula)?, self.recurring(formula)?);
        let (mut formula, mut nested) = (formula.clone(), Vec::new());
        self.known(&mut formula, &mut nested)?;
        Ok(Path { single, recurring, formula, predicates: self.predicates.clone(), nested })
    }

    /// Replaces the conditions and the bounds of a formula.
    fn known(&mut self, formula: &mut Formula, nested: &mut Vec<Term>) -> Result<()> {
        if let FormulaKind::State(e) = &formula.kind {
            formula.kind = if self.has_operators(e) {
                nested.push(self.condition(e)?);
                FormulaKind::Nested(nested.len() - 1)
            } else {
                let pool = self.predicates.pool();
                FormulaKind::Known(lower_condition(self.program, pool, self.source, e)?)
            };
            return Ok(());
        }
        for bound in formula.bounds_mut() {
            let span = bound.span();
            let steps = i64::try_from(self.steps(bound)?).unwrap_or(i64::MAX);
            *bound = Expr::new(NodeKind::Literal(Value::Int(steps)), span);
        }
        formula.operands_mut().into_iter().try_for_each(|part| self.known(part, nested))
    }

    /// Returns a formula with at most one temporal operator; `None` for others.
    fn single(&mut self, formula: &Formula) -> Result<Option<Single>> {
        use FormulaKind::{Always, Eventually, Next, Not, Release, Strong, Until, Weak};
        if is_condition(formula) {
            let step = Step::Now(self.conjoined(formula)?);
            return Ok(Some(Single { negated: false, step }));
        }
        let own = !matches!(formula.kind, Not(_));
        if own && !formula.operands().into_iter().all(is_condition) {
            return Ok(None);
        }
        let (negated, step) = match &formula.kind {
            Not(a) => {
                let single = self.single(a)?;
                return Ok(single.map(|single| Single { negated: !single.negated, ..single }));
            }
            Next(a) => (false, Step::Next(self.conjoined(a)?)),
            Eventually(steps, a) => {
                let right = self.conjoined(a)?;
                (false, self.until(None, right, steps, formula)?)
            }
            Always(steps, a) => {
                let right = not(self.conjoined(a)?);
                (true, self.until(None, right, steps, formula)?)
            }
            Until(steps, a, b) => {
                let (left, right) = (self.conjoined(a)?, self.conjoined(b)?);
                (false, self.until(Some(left), right, steps, formula)?)
            }
            // a W b = !((a & !b) U (!a & !b))
            Weak(steps, a, b) => {
                let (a, b) = (self.conjoined(a)?, self.conjoined(b)?);
                let (left, right) = (both(a.clone(), not(b.clone())), both(not(a), not(b)));
                (true, self.until(Some(left), right, steps, formula)?)
            }
            // a R b = !(!a U !b)
            Release(steps, a, b) => {
                let (left, right) = (not(self.conjoined(a)?), not(self.conjoined(b)?));
                (true, self.until(Some(left), right, steps, formula)?)
            }
            // a M b = b U (a & b)
            Strong(a, b) => {
                let (a, b) = (self.conjoined(a)?, self.conjoined(b)?);
                (false, self.until(Some(b.clone()), both(a, b), &Steps::default(), formula)?)
            }
            _ => return Ok(None),
        };
        Ok(Some(Single { negated, step }))
    }

    /// Returns the condition of `G F φ`, or of its negation; `None` for other formulas.
    fn recurring(&mut self, formula: &Formula) -> Result<Option<(Term, bool)>> {
        use FormulaKind::{Always, Eventually, Not};
        let unbounded = |steps: &Steps| *steps == Steps::default();
        Ok(match &formula.kind {
            Not(a) => self.recurring(a)?.map(|(term, negated)| (term, !negated)),
            Always(steps, a) if unbounded(steps) => match &a.kind {
                Eventually(steps, a) if unbounded(steps) && is_condition(a) => {
                    Some((self.conjoined(a)?, false))
                }
                _ => None,
            },
            Eventually(steps, a) if unbounded(steps) => match &a.kind {
                Always(steps, a) if unbounded(steps) && is_condition(a) => {
                    Some((not(self.conjoined(a)?), true))
                }
                _ => None,
            },
            _ => None,
        })
    }

    fn until(&mut self, left: Option<Term>, right: Term, steps: &Steps, formula: &Formula) -> Result<Step> {
        let mut read = |bound: &Option<(Expr, bool)>| match bound {
            Some((e, strict)) => Ok(Some((self.steps(e)?, *strict))),
            None => Ok::<_, meliora_base::error::Error>(None),
        };
        let least = read(&steps.least)?.map_or(0, |(n, strict)| n + u64::from(strict));
        let most = read(&steps.most)?;
        let is_empty = most.is_some_and(|(most, strict)| most < least + u64::from(strict));
        if is_empty {
            let message = "no number of steps is within these bounds";
            return Err(self.wrong(formula.span, message).into());
        }
        Ok(Step::Until { left, right, least, most: most.map(|(n, strict)| n - u64::from(strict)) })
    }

    /// Checks a formula without temporal operators.
    fn conjoined(&mut self, formula: &Formula) -> Result<Term> {
        let mut parts = Vec::new();
        for part in formula.operands() {
            parts.push(self.conjoined(part)?);
        }
        let kind = match (&formula.kind, <[Term; 2]>::try_from(parts)) {
            (FormulaKind::State(e), _) => return self.condition(e),
            (FormulaKind::Known(id), _) => TermKind::State(self.predicates.get(*id)),
            (FormulaKind::Implies(..), Ok(two)) => TermKind::Binary(BinaryOp::Implies, Box::new(two)),
            (FormulaKind::Iff(..), Ok(two)) => TermKind::Binary(BinaryOp::Iff, Box::new(two)),
            (FormulaKind::Not(_), Err(one)) => return Ok(not(Term { span: formula.span, ..all_of(one) })),
            (FormulaKind::Or(_), Ok(two)) => TermKind::Join(false, two.into()),
            (FormulaKind::Or(_), Err(parts)) => TermKind::Join(false, parts),
            (_, Ok(two)) => TermKind::Join(true, two.into()),
            (_, Err(parts)) => TermKind::Join(true, parts),
        };
        Ok(Term { kind, ty: Type::Bool, span: formula.span })
    }
}

/// Returns the conjunction of some conditions.
fn all_of(mut parts: Vec<Term>) -> Term {
    match parts.pop() {
        Some(one) if parts.is_empty() => one,
        last => {
            parts.extend(last);
            Term { kind: TermKind::Join(true, parts), ty: Type::Bool, span: Span::default() }
        }
    }
}

fn not(term: Term) -> Term {
    let span = term.span;
    match term.kind {
        TermKind::Not(inner) => *inner,
        kind => Term { kind: TermKind::Not(Box::new(Term { kind, ..term })), ty: Type::Bool, span },
    }
}

fn both(a: Term, b: Term) -> Term {
    let span = a.span.to(b.span);
    Term { kind: TermKind::Join(true, vec![a, b]), ty: Type::Bool, span }
}
