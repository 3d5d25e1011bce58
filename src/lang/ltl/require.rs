//! Requirements: safe formulas, as the states in which they are not violated.

use std::sync::Arc;

use super::formula::Formula;
use super::install::Monitoring;
use meliora_base::error::{Diagnostic, Error, Limit, Result, Severity, SourceFile};
use meliora_base::value::Value;
use meliora_ltl::{Form, FormulaId, Formulas};
use meliora_model::expr::{Binary, ExprId, ExprPool, Unary};
use meliora_model::preference::Requirement;
use meliora_model::temporal::{Asks, Condition};

impl Monitoring<'_> {
    /// Returns the requirements of some safe formulas: for each formula, the states in which it is
    /// not violated. All formulas are one requirement, their conjunction.
    ///
    /// `G p` with a state formula p needs no monitor. If some formula is different, one monitor called
    /// `name` follows the conjunction of all formulas. Its mark means that no continuation satisfies
    /// it: a path can violate several formulas together before it violates one of them.
    ///
    /// # Errors
    /// Unknown names and wrong types; a formula is not safe, each with its place; a limit on the size
    /// of monitors.
    pub fn require<'f>(
        &mut self,
        formulas: impl IntoIterator<Item = (&'f Arc<SourceFile>, &'f Formula)>,
        name: &str,
    ) -> Result<Vec<Requirement<ExprId>>> {
        let (mut lines, mut wrong) = (Vec::new(), Vec::new());
        for (source, formula) in formulas {
            match self.safe(source, formula) {
                Ok(line) => lines.push(line),
                Err(Error::Input(all)) => wrong.extend(all),
                Err(other) => return Err(other),
            }
        }
        if !wrong.is_empty() {
            return Err(Error::Input(wrong));
        }
        let watched = match lines.iter().all(|line| line.invariant.is_some()) {
            true => None,
            false => {
                let all = self.formulas.join(true, lines.iter().map(|line| line.formula));
                Some(self.watched(all, name)?)
            }
        };
        let requirement = |line: Line| match (line.invariant, watched) {
            (None, Some((kept, states))) => {
                Some(Requirement { text: line.text, kept, monitor: Some(states) })
            }
            (kept, _) => Some(Requirement { text: line.text, kept: kept?, monitor: None }),
        };
        Ok(lines.into_iter().filter_map(requirement).collect())
    }

    /// Reads a safe formula.
    fn safe(&mut self, source: &Arc<SourceFile>, formula: &Formula) -> Result<Line> {
        let normal = self.normal(source, formula)?;
        let text = source.on_one_line(formula.span.range());
        let invariant = invariant(self.predicates.pool(), &self.formulas, normal);
        match invariant.is_some() || self.formulas.is_safe(normal) {
            true => Ok(Line { text, formula: normal, invariant }),
            false => Err(not_safe(source, formula)),
        }
    }

    /// Adds the monitor of a safe formula. Returns the states in which it is not violated, and the
    /// number of states of the monitor.
    fn watched(&mut self, formula: FormulaId, name: &str) -> Result<(ExprId, u64)> {
        let not = self.formulas.negated(formula);
        let violated = self.mark(not, Asks::Avoid, name).map_err(|error| match error {
            Error::Limit(Limit::Size { what }) => {
                Limit::Size { what: format!("the required formulas need {what}") }.into()
            }
            other => other,
        })?;
        let states = self.states_of(&Condition::Leaf(Asks::Avoid, violated));
        Ok((self.predicates.pool().unary(Unary::Not, violated), states))
    }
}

/// A required formula.
struct Line {
    text: String,
    formula: FormulaId,
    /// The state formula p if the formula is `G p`.
    invariant: Option<ExprId>,
}

/// Returns p if the formula is `G p`, or the conjunction for several such formulas under `&`.
fn invariant(pool: &mut ExprPool, all: &Formulas, f: FormulaId) -> Option<ExprId> {
    match all.form(f) {
        Form::Constant(value) => Some(pool.value(Value::Bool(*value))),
        Form::And(parts) => conjunction(pool, all, parts, invariant),
        _ => body(pool, all, all.is_always(f)?),
    }
}

/// Returns p for the formula φ if `G φ` is `G p`.
fn body(pool: &mut ExprPool, all: &Formulas, f: FormulaId) -> Option<ExprId> {
    match all.form(f) {
        Form::Literal(e, true) => Some(*e),
        Form::Literal(e, false) => Some(pool.unary(Unary::Not, *e)),
        Form::And(parts) => conjunction(pool, all, parts, body),
        _ => invariant(pool, all, f),
    }
}

fn conjunction(
    pool: &mut ExprPool,
    all: &Formulas,
    parts: &[FormulaId],
    each: impl Fn(&mut ExprPool, &Formulas, FormulaId) -> Option<ExprId>,
) -> Option<ExprId> {
    let mut whole = pool.value(Value::Bool(true));
    for &part in parts {
        let part = each(pool, all, part)?;
        whole = pool.binary(Binary::And, whole, part);
    }
    Some(whole)
}

fn not_safe(source: &Arc<SourceFile>, formula: &Formula) -> Error {
    let text = source.on_one_line(formula.span.range());
    let message = format!("`{text}` cannot be required: it is not a safe formula");
    let diagnostic = Diagnostic::new(source, formula.span.range(), message).severity(Severity::Unsupported);
    diagnostic
        .label("no finite path violates it")
        .help("requirements consist of G, W, R, X, `F<=k`, `&` and `|`; what must happen is an objective")
        .into()
}
