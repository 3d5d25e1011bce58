//! Expressions of PRISM's language: from their nodes into the pool, with names resolved and types checked.

use ahash::AHashSet;

use super::lowerer::{Lowered, Lowerer, Operand};
use super::scope::{DefId, Env, Symbol};
use crate::ast::{Command, Expr, Node, NodeKind, Span};
use crate::parse::{command_at, expression_at};
use meliora_base::error::Error;
use meliora_base::slip;
use meliora_base::value::Type;
use meliora_model::expr::ExprId;

/// Returns the operands if none of them is wrong.
fn known(operands: &[Lowered]) -> Option<Vec<Operand>> {
    operands.iter().map(|&(id, span)| Some((id?, span))).collect()
}

/// A form of expression that can be lowered into the pool.
pub(super) trait Body {
    /// Lowers the expression into the pool under a renaming.
    fn lowered(&self, lowerer: &mut Lowerer<'_>, env: Env) -> Lowered;
}

/// All operands are lowered before an operator gives up, so that several errors are found in one run.
impl Body for Expr {
    fn lowered(&self, lowerer: &mut Lowerer<'_>, env: Env) -> Lowered {
        let mut stack: Vec<Lowered> = Vec::new();
        for node in &self.nodes {
            let from = stack.len().saturating_sub(node.kind.operands());
            let id = lowerer.lowered_node(node, &stack[from..], env);
            stack.truncate(from);
            stack.push((id, node.span));
        }
        stack.pop().unwrap_or_default()
    }
}

/// The place of an expression whose syntax was checked before.
impl Body for Span {
    fn lowered(&self, lowerer: &mut Lowerer<'_>, env: Env) -> Lowered {
        let read = expression_at(&lowerer.source, *self, lowerer.poll.sink());
        let read = read.map_err(|error| lowerer.unread(error));
        read.map_or((None, *self), |e| e.lowered(lowerer, env))
    }
}

impl Lowerer<'_> {
    fn lowered_node(&mut self, node: &Node, operands: &[Lowered], env: Env) -> Option<ExprId> {
        let span = node.span;
        self.count_work(span)?;
        match &node.kind {
            NodeKind::Literal(value) => Some(self.literal_at(*value, span)),
            NodeKind::Name(name) => self.name(name, span, env),
            NodeKind::Label(name) => self.label(name, span),
            NodeKind::Call(function, _) => {
                let arguments = known(operands)?;
                let name = self.scope.rename(&function.name, env).0.to_owned();
                self.call(&name, function.span, &arguments, span)
            }
            NodeKind::Known(id) => Some(*id),
            NodeKind::Operator(_) => self.fail(span, "an operator of properties is not a constant"),
            kind => self.operation(kind, known(operands)?, span, "`?`"),
        }
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
        let lowered = e.lowered(self, env);
        self.finished(lowered, ty, what)
    }

    /// Reads the command at a place.
    pub(super) fn read_command(&mut self, place: Span) -> Option<Command> {
        let read = command_at(&self.source, place, self.poll.sink());
        read.map_err(|error| self.unread(error)).ok()
    }

    /// Handles a failure to read a text again, which means cancellation.
    fn unread(&mut self, error: Error) {
        match error {
            Error::Limit(limit) => self.poll.end(limit),
            Error::Input(diagnostics) => diagnostics.into_iter().for_each(|d| self.report(d)),
            _ => {}
        }
    }

    pub(super) fn name(&mut self, name: &str, span: Span, env: Env) -> Option<ExprId> {
        let (name, inside) = self.scope.rename(name, env);
        match self.scope.symbol(name) {
            Some(Symbol::Definition(definition)) => self.definition(definition, inside),
            Some(Symbol::Variable(variable, ty)) => Some(self.pool.var(variable, ty)),
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
        let help = match slip::meant(labels.keys().map(String::as_str), name) {
            Some(meant) => format!("did you mean `\"{meant}\"`?"),
            None => format!("the labels are {}", known.join(", ")),
        };
        self.report(diagnostic.help(help));
        None
    }

    /// Lowers a constant or a formula. Its dependencies are lowered first, in an order found
    /// without recursion, so long chains of definitions are safe. There are no cycles; that was
    /// checked before.
    pub(super) fn definition(&mut self, definition: DefId, env: Env) -> Option<ExprId> {
        let mut pending = vec![(definition, env, false)];
        while let Some((d, e, ready)) = pending.pop() {
            let e = self.scope.inside(d, e);
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
        let env = self.scope.inside(definition, env);
        self.lowered.get(&(definition, env)).copied().flatten()
    }

    /// Returns the definitions named in the body of a definition under a renaming, each with the
    /// renaming that applies to it.
    pub(super) fn dependencies(&self, definition: DefId, env: Env) -> Vec<(DefId, Env)> {
        let Some(body) = self.scope.definitions[definition as usize].body else { return Vec::new() };
        // A text that cannot be read again is reported when it is lowered.
        let body = expression_at(&self.source, body, self.poll.sink()).unwrap_or_default();
        let mut known: AHashSet<&str> = AHashSet::new();
        let mut found = Vec::new();
        for node in &body.nodes {
            let NodeKind::Name(name) = &node.kind else { continue };
            let (new, inside) = self.scope.rename(name, env);
            if let (true, Some(Symbol::Definition(d))) = (known.insert(name), self.scope.symbol(new)) {
                found.push((d, inside));
            }
        }
        found
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
}
