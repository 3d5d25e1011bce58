//! Requirements: safe formulas, as the states in which they are not violated.

use std::sync::Arc;

use super::formula::Formula;
use super::install::Monitoring;
use crate::automata::{Form, Monitor, Normal, Window};
use crate::error::{Diagnostic, Result, Severity, SourceFile};
use crate::model::expr::{Binary, ExprId, ExprPool, Unary};
use crate::model::preference::Requirement;
use crate::model::temporal::Asks;
use crate::model::value::Value;

impl Monitoring<'_> {
    /// Returns a safe formula as a requirement: the states in which it is not violated. `G p` with a state formula p
    /// needs no monitor. Every other safe formula gets a monitor called `name`, whose mark means
    /// that the formula is violated.
    ///
    /// # Errors
    /// Unknown names and wrong types; the formula is not safe; a limit on the size of monitors.
    pub(crate) fn require(
        &mut self,
        source: &Arc<SourceFile>,
        formula: &Formula,
        name: &str,
    ) -> Result<Requirement> {
        let normal = self.normal(source, formula)?;
        let text = source.on_one_line(formula.span.range());
        if let Some(kept) = invariant(&mut self.program.pool, &normal) {
            return Ok(Requirement { text, kept, monitor: None });
        }
        if !normal.is_safe() {
            return Err(not_safe(source, formula));
        }
        let monitor = Monitor::of_cosafe(&normal.negated())?;
        let states = monitor.states.len() as u64;
        let violated = self.mark(monitor, Asks::Avoid, name)?;
        let kept = self.program.pool.unary(Unary::Not, violated);
        Ok(Requirement { text, kept, monitor: Some(states) })
    }
}

/// Returns p if the formula is `G p`, or the conjunction for several such formulas under `&`.
fn invariant(pool: &mut ExprPool, n: &Normal) -> Option<ExprId> {
    match &n.form {
        Form::Constant(value) => Some(pool.value(Value::Bool(*value))),
        Form::And(parts) => conjunction(pool, parts, invariant),
        Form::Release(Window::ALWAYS, left, right) if left.form == Form::Constant(false) => body(pool, right),
        _ => None,
    }
}

/// Returns p for the formula φ if `G φ` is `G p`.
fn body(pool: &mut ExprPool, n: &Normal) -> Option<ExprId> {
    match &n.form {
        Form::Literal(e, true) => Some(*e),
        Form::Literal(e, false) => Some(pool.unary(Unary::Not, *e)),
        Form::And(parts) => conjunction(pool, parts, body),
        _ => invariant(pool, n),
    }
}

fn conjunction(
    pool: &mut ExprPool,
    parts: &[Normal],
    each: impl Fn(&mut ExprPool, &Normal) -> Option<ExprId>,
) -> Option<ExprId> {
    let mut all = pool.value(Value::Bool(true));
    for part in parts {
        let part = each(pool, part)?;
        all = pool.binary(Binary::And, all, part);
    }
    Some(all)
}

fn not_safe(source: &Arc<SourceFile>, formula: &Formula) -> crate::error::Error {
    let text = source.on_one_line(formula.span.range());
    let message = format!("`{text}` cannot be required: it is not a safe formula");
    let diagnostic = Diagnostic::new(source, formula.span.range(), message).severity(Severity::Unsupported);
    diagnostic
        .label("no finite path violates it")
        .help("requirements consist of G, W, R, X, `F<=k`, `&` and `|`; what must happen is an objective")
        .into()
}
