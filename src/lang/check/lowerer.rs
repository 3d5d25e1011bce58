//! State of lowering, and the errors found on the way.

use std::sync::Arc;

use ahash::{AHashMap, AHashSet};

use super::scope::{DefId, Env, Scope};
use crate::ast::Span;
use meliora_base::error::{Diagnostic, Severity, SourceFile};
use meliora_base::exact::{self, Exact, Real};
use meliora_base::progress::{Poll, ProgressSink};
use meliora_base::value::Value;
use meliora_model::expr::{ExprId, ExprPool};

/// Maximum number of errors reported.
pub(crate) const MAX_ERRORS: usize = 20;

/// An expression in the pool with its place.
pub(crate) type Operand = (ExprId, Span);

/// Same as [`Operand`], or `None` after reporting that the expression is wrong.
pub(crate) type Lowered = (Option<ExprId>, Span);

/// State of lowering: the growing pool, the names, and the errors so far.
pub(crate) struct Lowerer<'a> {
    pub(crate) source: Arc<SourceFile>,
    pub(super) scope: Scope<'a>,
    pub(crate) pool: ExprPool,
    /// Definitions lowered under a renaming; `None` for a definition that failed.
    pub(super) lowered: AHashMap<(DefId, Env), Option<ExprId>>,
    /// Labels that may be used; `None` where labels are not permitted.
    pub(super) labels: Option<AHashMap<String, ExprId>>,
    pub(crate) diagnostics: Vec<Diagnostic>,
    /// Height of each node of the pool, 0 if unknown; see `ops`.
    pub(super) heights: Vec<u16>,
    /// Nodes without a value, each with its place; see `faults`.
    pub(super) faults: AHashMap<ExprId, Span>,
    /// Nodes without a fault in any part.
    pub(super) sound: AHashSet<ExprId>,
    /// Cancellation: after it every expression fails, and errors are not reported.
    pub(crate) poll: Poll<'a>,
    /// The first expression for whose exact value the nearest double counts; see `ops`.
    pub(crate) inexact: Option<Diagnostic>,
    /// Number of parts of expressions read; see `limits`.
    pub(super) work: usize,
    /// True if the model was found to be too large, which has been reported.
    pub(crate) is_full: bool,
}

impl<'a> Lowerer<'a> {
    pub(crate) fn new(
        source: &Arc<SourceFile>,
        scope: Scope<'a>,
        pool: ExprPool,
        sink: &'a dyn ProgressSink,
    ) -> Self {
        Lowerer {
            source: Arc::clone(source),
            scope,
            pool,
            lowered: AHashMap::new(),
            labels: None,
            diagnostics: Vec::new(),
            heights: Vec::new(),
            faults: AHashMap::new(),
            sound: AHashSet::new(),
            poll: Poll::new(sink),
            inexact: None,
            work: 0,
            is_full: false,
        }
    }

    /// Returns an error at a place in the text.
    pub(crate) fn wrong(&self, span: Span, message: impl Into<String>) -> Diagnostic {
        Diagnostic::new(&self.source, span.range(), message)
    }

    /// Records an error, only once: the same place is read again under each renaming.
    pub(crate) fn report(&mut self, diagnostic: Diagnostic) {
        let known =
            self.diagnostics.iter().any(|d| d.span == diagnostic.span && d.message == diagnostic.message);
        if !known && self.diagnostics.len() < MAX_ERRORS {
            self.diagnostics.push(diagnostic);
        }
    }

    /// Reports an error and gives up the current expression.
    pub(crate) fn fail<T>(&mut self, span: Span, message: impl Into<String>) -> Option<T> {
        let diagnostic = self.wrong(span, message);
        self.report(diagnostic);
        None
    }

    /// Reports something that exists already, with the place of the first one; `labels` are those
    /// of both places.
    pub(crate) fn again(&mut self, span: Span, message: impl Into<String>, first: Span, labels: [&str; 2]) {
        let diagnostic = self.wrong(span, message).label(labels[0]);
        self.report(diagnostic.related(first.range(), labels[1]));
    }

    pub(crate) fn declared_twice(&mut self, name: &str, span: Span, first: Span) {
        let labels = ["declared again", "declared here first"];
        self.again(span, format!("`{name}` is declared twice"), first, labels);
    }

    pub(crate) fn literal(&mut self, value: Value) -> Option<ExprId> {
        Some(self.pool.value(value))
    }

    /// Returns the literal that stands at a place of the text. A real has the exact value of its
    /// text, which may have more digits than a double. The text of a literal from another source is
    /// not at hand.
    pub(crate) fn literal_at(&mut self, value: Value, span: Span) -> ExprId {
        let is_other = |text: &&str| text.parse::<f64>().is_ok_and(|x| Value::Real(x) != value);
        let text = match value {
            Value::Real(_) => self.source.text.get(span.range()).filter(|text| !is_other(text)),
            _ => None,
        };
        match text.map(exact::decimal) {
            Some(Ok(exact)) => self.pool.exact_value(Exact::Real(Real::Finite(exact))),
            // JANI's constants e and π have no decimal text.
            Some(Err(_)) => {
                self.round_at(span);
                self.pool.value(value)
            }
            None => self.pool.value(value),
        }
    }

    /// Records that a double counts for the exact value of an expression.
    pub(super) fn round_at(&mut self, span: Span) {
        if self.inexact.is_none() {
            let message = "a double counts for the value of this expression, which is not exact";
            let help = "a logarithm, a root, or a number with too many digits; all other numbers are exact";
            self.inexact = Some(self.wrong(span, message).severity(Severity::Warning).help(help));
        }
    }

    /// Returns the value of an expression without variables.
    pub(crate) fn constant_value(&mut self, id: ExprId, span: Span, what: &str) -> Option<Value> {
        let value = self.pool.literal(id);
        if value.is_none() {
            let diagnostic = self.wrong(span, format!("{what} must not depend on variables"));
            self.report(diagnostic.label("not constant"));
        }
        value
    }
}
