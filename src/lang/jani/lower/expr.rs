//! Expressions: resolves names, substitutes functions and checks types.

use ahash::AHashMap;

use super::arrays::{Parts, Read};
use super::scope::{Known, Meaning, Place, Slot};
use super::state::Lowering;
use crate::ast::{Expr, Ident, Node, NodeKind, Span};
use crate::check::Lowered;
use meliora_base::exact::Exact;
use meliora_base::slip::is_slip;
use meliora_base::value::{Type, Value};
use meliora_model::expr::ExprId;

/// Maximum nesting of calls of functions and of values of transient variables.
const MOST_CALLS: usize = 100;

impl<'a> Lowering<'a> {
    /// Lowers a whole expression of a given type; an integer is converted if a real is wanted.
    pub(super) fn typed(&mut self, e: &Expr, place: Place<'_>, ty: Type, what: &str) -> Option<ExprId> {
        let read = self.value(e, place);
        let lowered = self.scalar(read);
        self.lowerer.finished(lowered, ty, what)
    }

    /// Lowers an expression, which may be an array. All operands are lowered before an operator gives up.
    pub(super) fn value(&mut self, e: &Expr, place: Place<'_>) -> Read {
        let mut stack: Vec<Read> = Vec::new();
        for node in &e.nodes {
            let operands = stack.split_off(stack.len().saturating_sub(node.kind.operands()));
            stack.push((self.value_of_node(node, operands, place), node.span));
        }
        stack.pop().unwrap_or_default()
    }

    fn value_of_node(&mut self, node: &Node, operands: Vec<Read>, place: Place<'_>) -> Option<Parts> {
        let span = node.span;
        self.lowerer.count_work(span)?;
        match &node.kind {
            NodeKind::Literal(value) => Some(Parts::One(self.lowerer.literal_at(*value, span))),
            NodeKind::Name(name) => self.name(name, span, place),
            NodeKind::Call(function, _) => self.call(function, &operands, place, span),
            NodeKind::Comprehension(made) => self.comprehension(made, place, span),
            NodeKind::Array(_) => {
                let parts: Option<Vec<Parts>> = operands.into_iter().map(|(part, _)| part).collect();
                self.uniform(parts?, span)
            }
            NodeKind::Element => {
                let [array, index] = operands.try_into().ok()?;
                let (index, at) = self.scalar(index);
                self.selected(array.0?, (index?, at), span)
            }
            NodeKind::Ite if operands[1..].iter().any(|own| matches!(own.0, Some(Parts::Many(_)))) => {
                let [condition, then, otherwise] = operands.try_into().ok()?;
                let (condition, at) = self.scalar(condition);
                let condition =
                    self.lowerer.expect_type(condition?, Type::Bool, at, "the condition of \"ite\"")?;
                self.either((condition, at), then.0?, otherwise.0?, span)
            }
            kind => {
                let scalars: Vec<Lowered> = operands.into_iter().map(|read| self.scalar(read)).collect();
                let scalars = scalars.into_iter().map(|(id, at)| Some((id?, at))).collect::<Option<_>>()?;
                self.lowerer.operation(kind, scalars, span, "\"ite\"").map(Parts::One)
            }
        }
    }

    /// Returns the value of an expression without variables.
    pub(super) fn constant(&mut self, e: &Expr, place: Place<'_>, ty: Type, what: &str) -> Option<Value> {
        Some(self.constant_literal(e, place, ty, what)?.1.rounded())
    }

    /// Returns the literal of an expression without variables, and its exact value.
    pub(super) fn constant_literal(
        &mut self,
        e: &Expr,
        place: Place<'_>,
        ty: Type,
        what: &str,
    ) -> Option<(ExprId, Exact)> {
        let id = self.typed(e, place, ty, what)?;
        self.lowerer.constant_value(id, e.span(), what)?;
        Some((id, self.lowerer.pool.exact_literal(id)?))
    }

    fn name(&mut self, name: &str, span: Span, place: Place<'_>) -> Option<Parts> {
        if let Some(given) = place.parameters.and_then(|p| p.get(name)) {
            return Some(given.clone());
        }
        if let Some(Meaning::Array(array)) = self.meaning(name, place.instance) {
            return self.elements_of(array, place);
        }
        self.scalar_named(name, span, place).map(Parts::One)
    }

    fn scalar_named(&mut self, name: &str, span: Span, place: Place<'_>) -> Option<ExprId> {
        match self.meaning(name, place.instance) {
            Some(Meaning::Constant(id)) => Some(id),
            Some(Meaning::Variable(variable, ty)) => {
                let given = place.current.and_then(|c| c.get(&Slot::Variable(variable)));
                Some(given.copied().unwrap_or_else(|| self.lowerer.pool.var(variable, ty)))
            }
            Some(Meaning::Transient(index)) => {
                match place.current.and_then(|c| c.get(&Slot::Transient(index))) {
                    Some(&id) => Some(id),
                    None => self.transient(index, span),
                }
            }
            Some(Meaning::Array(_)) | None => {
                let mut diagnostic = self.lowerer.wrong(span, format!("unknown name `{name}`"));
                let pending = self.pending.get(name).copied();
                if pending == Some(true) {
                    return None;
                }
                if pending == Some(false) {
                    diagnostic = diagnostic.label(
                        "declared below; a constant can only use constants that are declared before it",
                    );
                } else if let Some(similar) = self.similar(name, place.instance) {
                    diagnostic = diagnostic.help(format!("did you mean `{similar}`?"));
                }
                self.lowerer.report(diagnostic);
                None
            }
        }
    }

    /// Returns the meaning of a name inside an element of the system, or globally.
    pub(super) fn meaning(&self, name: &str, instance: Option<usize>) -> Option<Meaning> {
        let own = instance.and_then(|i| self.instances[i].level.names.get(name));
        own.or_else(|| self.globals.names.get(name)).map(|m| m.0)
    }

    /// Returns the function of this name inside an element of the system, or globally.
    pub(super) fn function_named(&self, name: &str, instance: Option<usize>) -> Option<usize> {
        let own = instance.and_then(|i| self.instances[i].level.functions.get(name));
        own.or_else(|| self.globals.functions.get(name)).copied()
    }

    fn similar(&self, name: &str, instance: Option<usize>) -> Option<&'a str> {
        let own = instance.into_iter().flat_map(|i| self.instances[i].level.names.keys());
        let known = own.chain(self.globals.names.keys()).copied();
        known.filter(|k| is_slip(k, name)).min()
    }

    /// Returns the value of a transient variable in a state: given by the locations, or else its
    /// initial value.
    pub(super) fn transient(&mut self, index: usize, span: Span) -> Option<ExprId> {
        match self.transients[index].state {
            Known::Done(id) => return id,
            Known::Open => {
                let name = &self.transients[index].variable.name.name;
                return self.lowerer.fail(span, format!("the value of `{name}` depends on itself"));
            }
            Known::New => {}
        }
        self.transients[index].state = Known::Open;
        let id = self.nested(span, |this| this.transient_value(index, span));
        self.transients[index].state = Known::Done(id);
        id
    }

    fn transient_value(&mut self, index: usize, span: Span) -> Option<ExprId> {
        let variable = self.transients[index].variable;
        let given = self.transients[index].given.clone();
        if let Some(&(second, location, value)) = given.iter().find(|g| g.0 != given[0].0) {
            let name = &variable.name.name;
            let message = format!(
                "`{name}` gets values by the locations of `{}` and of `{}`",
                self.instances[given[0].0].name, self.instances[second].name
            );
            let diagnostic =
                self.lowerer.wrong(value.span(), message).label(format!("in {}", location.name.name));
            self.lowerer.report(diagnostic.related(given[0].2.span().range(), "the other one"));
            return None;
        }
        let mut result = self.initial_of_transient(index, span)?;
        for (instance, location, value) in given.into_iter().rev() {
            let what = format!("the value of `{}`", variable.name.name);
            let then = self.typed(value, Place::new(instance), variable.ty.ty, &what)?;
            result = match self.at(instance, &location.name)? {
                Some(here) => self.lowerer.ite(here, (then, value.span()), (result, span))?,
                None => then,
            };
        }
        Some(result)
    }

    pub(super) fn initial_of_transient(&mut self, index: usize, span: Span) -> Option<ExprId> {
        let transient = &self.transients[index];
        let (variable, instance) = (transient.variable, transient.instance);
        let what = format!("the initial value of `{}`", variable.name.name);
        match &variable.initial {
            Some(e) => {
                let value =
                    self.constant(e, Place { instance, ..Place::default() }, variable.ty.ty, &what)?;
                self.lowerer.literal(value)
            }
            None => self.lowerer.fail(span, format!("`{}` has no initial value", variable.name.name)),
        }
    }

    pub(super) fn call(
        &mut self,
        name: &Ident,
        arguments: &[Read],
        place: Place<'_>,
        span: Span,
    ) -> Option<Parts> {
        let Some(index) = self.function_named(&name.name, place.instance) else {
            return self.lowerer.fail(name.span, format!("unknown function `{}`", name.name));
        };
        let (function, instance) = (self.functions[index].function, self.functions[index].instance);
        if arguments.len() != function.parameters.len() {
            let (takes, has) = (function.parameters.len(), arguments.len());
            return self.lowerer.fail(span, format!("`{}` needs {takes} arguments, not {has}", name.name));
        }
        let mut given = Vec::new();
        for (argument, parameter) in arguments.iter().zip(&function.parameters) {
            let what = format!("the argument `{}` of `{}`", parameter.name.name, name.name);
            given.push(self.expect(argument.clone(), &parameter.ty, &what)?);
        }
        let key = (self.stage, index, given);
        if let Some(known) = self.called.get(&key) {
            return known.clone();
        }
        if std::mem::replace(&mut self.functions[index].is_open, true) {
            return self.lowerer.fail(name.span, format!("the function `{}` calls itself", name.name));
        }
        let names = function.parameters.iter().map(|p| p.name.name.as_str());
        let parameters: AHashMap<&str, Parts> = names.zip(key.2.iter().cloned()).collect();
        let inside = Place { instance, parameters: Some(&parameters), current: place.current };
        let what = format!("the value of the function `{}`", name.name);
        let body = self.nested(span, |this| {
            let read = this.value(&function.body, inside);
            this.expect(read, &function.ty, &what)
        });
        self.functions[index].is_open = false;
        self.called.insert(key, body.clone());
        body
    }

    /// Reads a definition inside another one, unless they are nested too deeply.
    fn nested<T>(&mut self, span: Span, read: impl FnOnce(&mut Self) -> Option<T>) -> Option<T> {
        if self.depth >= MOST_CALLS {
            return self.lowerer.fail(span, format!("definitions nest more than {MOST_CALLS} levels deep"));
        }
        self.depth += 1;
        let read = read(self);
        self.depth -= 1;
        read
    }
}
