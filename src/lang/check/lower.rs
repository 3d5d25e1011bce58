//! Lowering of expressions: from their text or syntax tree into the pool, with types checked and
//! names resolved.

use std::sync::Arc;

use ahash::{AHashMap, AHashSet};

use super::limits::MAX_ERRORS;
use super::read::Body;
use super::scope::{DefId, Env, Mentioned, Scope, Symbol};
use crate::error::{Diagnostic, Error, SourceFile};
use crate::lang::ast::Span;
use crate::lang::parse::expression_at;
use crate::model::exact;
use crate::model::expr::{ExprId, ExprPool};
use crate::model::value::{Type, Value};
use crate::progress::{Poll, ProgressSink};

/// State of lowering: the growing pool, the names, and the errors so far.
pub(in crate::lang) struct Lowerer<'a> {
    pub(in crate::lang) source: Arc<SourceFile>,
    pub(super) scope: Scope<'a>,
    pub(in crate::lang) pool: ExprPool,
    /// Definitions lowered under a renaming; `None` for a definition that failed.
    pub(super) lowered: AHashMap<(DefId, Env), Option<ExprId>>,
    /// Labels that may be used; `None` where labels are not permitted.
    pub(super) labels: Option<AHashMap<String, ExprId>>,
    pub(in crate::lang) diagnostics: Vec<Diagnostic>,
    /// Height of each node of the pool, 0 if unknown; see [`super::ops::MAX_HEIGHT`].
    pub(super) heights: Vec<u16>,
    /// Nodes without a value, each with its place; see [`super::faults`].
    pub(super) faults: AHashMap<ExprId, Span>,
    /// Nodes without a fault in any part.
    pub(super) sound: AHashSet<ExprId>,
    /// Cancellation: after it every expression fails, and errors are not reported.
    pub(in crate::lang) poll: Poll<'a>,
    /// Number of parts of expressions read; see [`super::limits`].
    pub(super) work: usize,
    /// True if the model was found to be too large, which has been reported.
    pub(in crate::lang) is_full: bool,
}

impl<'a> Lowerer<'a> {
    pub(in crate::lang) fn new(
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
            work: 0,
            is_full: false,
        }
    }

    /// Returns an error at a place in the text.
    pub(in crate::lang) fn wrong(&self, span: Span, message: impl Into<String>) -> Diagnostic {
        Diagnostic::new(&self.source, span.range(), message)
    }

    /// Records an error, only once: the same place is read again under each renaming.
    pub(in crate::lang) fn report(&mut self, diagnostic: Diagnostic) {
        let known =
            self.diagnostics.iter().any(|d| d.span == diagnostic.span && d.message == diagnostic.message);
        if !known && self.diagnostics.len() < MAX_ERRORS {
            self.diagnostics.push(diagnostic);
        }
    }

    /// Reports an error and gives up the current expression.
    pub(in crate::lang) fn fail<T>(&mut self, span: Span, message: impl Into<String>) -> Option<T> {
        let diagnostic = self.wrong(span, message);
        self.report(diagnostic);
        None
    }

    /// Returns the expression in the pool, or `None` after reporting that it is wrong.
    pub(super) fn expr(&mut self, e: &impl Body, env: Env) -> Option<ExprId> {
        e.lowered(self, env).0
    }

    /// Lowers a whole expression of type `bool`.
    pub(super) fn condition(&mut self, e: &impl Body, env: Env, what: &str) -> Option<ExprId> {
        self.typed(e, env, Type::Bool, what)
    }

    /// Lowers a whole expression of a given type; an integer is converted if a real is wanted.
    pub(super) fn typed(&mut self, e: &impl Body, env: Env, ty: Type, what: &str) -> Option<ExprId> {
        let (id, span) = e.lowered(self, env);
        let id = self.expect_type(id?, ty, span, what)?;
        self.whole(id, span)
    }

    /// Handles a failure to read a text again, which means cancellation.
    pub(super) fn unread(&mut self, error: Error) {
        match error {
            Error::Limit(limit) => self.poll.end(limit),
            Error::Input(diagnostics) => diagnostics.into_iter().for_each(|d| self.report(d)),
            _ => {}
        }
    }

    pub(in crate::lang) fn expect_type(
        &mut self,
        id: ExprId,
        ty: Type,
        span: Span,
        what: &str,
    ) -> Option<ExprId> {
        match (self.pool.ty(id), ty) {
            (found, wanted) if found == wanted => Some(id),
            (Type::Int, Type::Real) => self.made_real(id, span),
            (found, wanted) => {
                let mut diagnostic = self
                    .wrong(span, format!("type error: {what} must be of type `{wanted}`"))
                    .label(format!("of type `{found}`"));
                if (found, wanted) == (Type::Real, Type::Int) {
                    diagnostic =
                        diagnostic.help("`floor`, `ceil` and `round` return integers; `/` never does");
                }
                self.report(diagnostic);
                None
            }
        }
    }

    pub(in crate::lang) fn literal(&mut self, value: Value) -> Option<ExprId> {
        Some(self.pool.value(value))
    }

    /// Returns a real literal with the exact value of its text, which may have more digits than a
    /// double. The text of a literal from another source is not at hand.
    pub(super) fn real(&mut self, x: f64, span: Span) -> ExprId {
        let text = self.source.text.get(span.range()).filter(|text| text.parse() == Ok(x));
        match text.and_then(exact::decimal) {
            Some(exact) => self.pool.exact_value(Value::Real(x), Some(exact)),
            None => self.pool.value(Value::Real(x)),
        }
    }

    pub(super) fn name(&mut self, name: &str, span: Span, env: Env) -> Option<ExprId> {
        let (name, inside) = self.scope.rename(name, env);
        match self.scope.symbol(name) {
            Some(Symbol::Definition(definition)) => self.definition(definition, inside),
            Some(Symbol::Variable(variable, ty)) => Some(self.pool.var(variable, ty)),
            Some(Symbol::Value(value)) => self.literal(value),
            Some(Symbol::Expression(id)) => Some(id),
            None => {
                let mut diagnostic = self
                    .wrong(span, format!("unknown name `{name}`"))
                    .label("not a variable, constant or formula");
                if self.labels.as_ref().is_some_and(|labels| labels.contains_key(name)) {
                    diagnostic =
                        diagnostic.help(format!("there is a label with this name: write `\"{name}\"`"));
                } else if let Some(similar) = self.scope.similar(name) {
                    diagnostic = diagnostic.help(format!("did you mean `{similar}`?"));
                }
                self.report(diagnostic);
                None
            }
        }
    }

    pub(super) fn label(&mut self, name: &str, span: Span) -> Option<ExprId> {
        let Some(labels) = &self.labels else {
            let help = "labels can be used in targets; use a formula here";
            let diagnostic = self.wrong(span, "a label cannot be used inside the model").help(help);
            self.report(diagnostic);
            return None;
        };
        if let Some(&id) = labels.get(name) {
            return Some(id);
        }
        let mut known: Vec<_> =
            labels.keys().filter(|k| !k.contains('=')).map(|k| format!("\"{k}\"")).collect();
        known.sort();
        let diagnostic = self.wrong(span, format!("unknown label \"{name}\""));
        if self.scope.symbol(name).is_some() {
            let help = format!("`{name}` is a name of the model, not a label: write it without quotes");
            self.report(diagnostic.help(help));
            return None;
        }
        self.report(diagnostic.help(format!("the labels are {}", known.join(", "))));
        None
    }

    /// Lowers a constant or a formula. Its dependencies are lowered first, in an order found
    /// without recursion, so long chains of definitions are safe. There are no cycles; that was
    /// checked before.
    pub(super) fn definition(&mut self, definition: DefId, env: Env) -> Option<ExprId> {
        let mut pending = vec![(definition, env, false)];
        while let Some((d, e, ready)) = pending.pop() {
            let e = if self.scope.definitions[d as usize].constant.is_some() {
                super::scope::NO_RENAMING
            } else {
                e
            };
            if self.lowered.contains_key(&(d, e)) {
                continue;
            }
            if ready {
                let id = self.lower_definition(d, e);
                self.lowered.insert((d, e), id);
                continue;
            }
            pending.push((d, e, true));
            pending.extend(self.dependencies(d, e).into_iter().map(|(d, e)| (d, e, false)));
        }
        let env = if self.scope.definitions[definition as usize].constant.is_some() { 0 } else { env };
        self.lowered.get(&(definition, env)).copied().flatten()
    }

    /// Returns the definitions named in the body of a definition under a renaming, each with the
    /// renaming that applies to it.
    pub(super) fn dependencies(&self, definition: DefId, env: Env) -> Vec<(DefId, Env)> {
        let Some(body) = self.scope.definitions[definition as usize].body else { return Vec::new() };
        let mut mentioned = Mentioned::default();
        // A text that cannot be read again is reported when it is lowered.
        let _ = expression_at(&self.source, body, self.poll.sink(), &mut mentioned);
        let resolve = |place: Span| {
            let (name, inside) = self.scope.rename(&self.source.text[place.range()], env);
            match self.scope.symbol(name) {
                Some(Symbol::Definition(d)) => Some((d, inside)),
                _ => None,
            }
        };
        mentioned.places.into_iter().filter_map(resolve).collect()
    }

    fn lower_definition(&mut self, definition: DefId, env: Env) -> Option<ExprId> {
        let body = self.scope.definitions[definition as usize].body?;
        match self.scope.definitions[definition as usize].constant {
            None => self.expr(&body, env),
            Some(ty) => {
                let what = format!("the constant `{}`", self.scope.definitions[definition as usize].name);
                let id = self.typed(&body, env, ty, &what)?;
                self.constant_value(id, body, &what).map(|_| id)
            }
        }
    }

    /// Returns the value of an expression without variables.
    pub(in crate::lang) fn constant_value(&mut self, id: ExprId, span: Span, what: &str) -> Option<Value> {
        match self.pool.literal(id) {
            Some(value) => Some(value),
            None => {
                let diagnostic = self.wrong(span, format!("{what} must not depend on variables"));
                self.report(diagnostic.label("not constant"));
                None
            }
        }
    }
}
