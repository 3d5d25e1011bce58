//! Expressions: resolves names, substitutes functions and checks types.

use ahash::AHashMap;

use super::super::ast::{Expr, ExprKind, Op};
use super::Lowering;
use super::scope::{Known, Meaning, Place, Slot};
use crate::lang::ast::{BinaryOp, Ident, Span};
use crate::lang::check::Operand;
use crate::model::expr::ExprId;
use crate::model::value::{Type, Value};

/// Maximum nesting of calls of functions and of values of transient variables.
const MOST_CALLS: usize = 100;

impl<'a> Lowering<'a> {
    /// Lowers a whole expression of a given type; an integer is converted if a real is wanted.
    pub(super) fn typed(&mut self, e: &Expr, place: Place<'_>, ty: Type, what: &str) -> Option<ExprId> {
        let id = self.expr(e, place)?;
        let id = self.lowerer.expect_type(id, ty, e.span, what)?;
        self.lowerer.whole(id, e.span)
    }

    /// Returns the value of an expression without variables.
    pub(super) fn constant(&mut self, e: &Expr, place: Place<'_>, ty: Type, what: &str) -> Option<Value> {
        let id = self.typed(e, place, ty, what)?;
        self.lowerer.constant_value(id, e.span, what)
    }

    pub(super) fn expr(&mut self, e: &Expr, place: Place<'_>) -> Option<ExprId> {
        self.lowerer.count_work(e.span)?;
        match &e.kind {
            ExprKind::Literal(value) => self.lowerer.literal(*value),
            ExprKind::Name(name) => self.name(name, e.span, place),
            ExprKind::Op(op, operands) => {
                // All operands are read before giving up, so several errors are found in a run.
                let operands: Vec<_> = operands.iter().map(|o| (self.expr(o, place), o.span)).collect();
                let operands: Option<Vec<Operand>> =
                    operands.into_iter().map(|(id, span)| Some((id?, span))).collect();
                self.operation(*op, &operands?, e.span)
            }
            ExprKind::Call(function, arguments) => self.call(function, arguments, place, e.span),
        }
    }

    fn operation(&mut self, op: Op, operands: &[Operand], span: Span) -> Option<ExprId> {
        match (op, operands) {
            (Op::Binary(op @ (BinaryOp::And | BinaryOp::Or)), all) => self.lowerer.balanced(op, all.to_vec()),
            (Op::Binary(op), &[a, b]) => self.lowerer.binary(op, a, b, span),
            (Op::Not, &[(a, at)]) => self.lowerer.not(a, at),
            (Op::Ite, &[(condition, at), a, b]) => {
                let what = "the condition of \"ite\"";
                let condition = self.lowerer.expect_type(condition, Type::Bool, at, what)?;
                self.lowerer.ite(condition, a, b)
            }
            (Op::Function(name), all) => self.lowerer.call(name, span, all, span),
            (Op::Abs, &[a]) => {
                let minus = self.lowerer.neg(a.0, a.1, span)?;
                let negative = self.compared(a, BinaryOp::Lt)?;
                self.lowerer.ite(negative, (minus, span), a)
            }
            (Op::Sgn, &[a]) => {
                let (negative, positive) = (self.compared(a, BinaryOp::Lt)?, self.compared(a, BinaryOp::Gt)?);
                let [minus, zero, plus] = [-1, 0, 1].map(|i| self.lowerer.literal(Value::Int(i)));
                let rest = self.lowerer.ite(positive, (plus?, span), (zero?, span))?;
                self.lowerer.ite(negative, (minus?, span), (rest, span))
            }
            (Op::Trc, &[a]) => {
                let negative = self.compared(a, BinaryOp::Lt)?;
                let up = self.lowerer.call("ceil", span, &[a], span)?;
                let down = self.lowerer.call("floor", span, &[a], span)?;
                self.lowerer.ite(negative, (up, span), (down, span))
            }
            _ => self.lowerer.fail(span, "wrong number of operands"),
        }
    }

    /// Returns `a op 0`.
    fn compared(&mut self, a: Operand, op: BinaryOp) -> Option<ExprId> {
        let zero = self.lowerer.literal(Value::Int(0))?;
        self.lowerer.binary(op, a, (zero, a.1), a.1)
    }

    fn name(&mut self, name: &str, span: Span, place: Place<'_>) -> Option<ExprId> {
        if let Some(id) = place.parameters.and_then(|p| p.get(name)) {
            return Some(*id);
        }
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
            None => {
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

    fn similar(&self, name: &str, instance: Option<usize>) -> Option<&'a str> {
        let own = instance.into_iter().flat_map(|i| self.instances[i].level.names.keys());
        let known = own.chain(self.globals.names.keys()).copied();
        known.filter(|k| crate::lang::check::is_slip(k, name)).min()
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
                self.lowerer.wrong(value.span, message).label(format!("in {}", location.name.name));
            self.lowerer.report(diagnostic.related(given[0].2.span.range(), "the other one"));
            return None;
        }
        let mut result = self.initial_of_transient(index, span)?;
        for (instance, location, value) in given.into_iter().rev() {
            let what = format!("the value of `{}`", variable.name.name);
            let then = self.typed(value, Place::of(instance), variable.ty.ty, &what)?;
            result = match self.at(instance, &location.name)? {
                Some(here) => self.lowerer.ite(here, (then, value.span), (result, span))?,
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

    fn call(&mut self, name: &Ident, arguments: &[Expr], place: Place<'_>, span: Span) -> Option<ExprId> {
        let arguments: Vec<_> = arguments.iter().map(|a| (self.expr(a, place), a.span)).collect();
        let own = place.instance.and_then(|i| self.instances[i].level.functions.get(name.name.as_str()));
        let Some(&index) = own.or_else(|| self.globals.functions.get(name.name.as_str())) else {
            return self.lowerer.fail(name.span, format!("unknown function `{}`", name.name));
        };
        let (function, instance) = (self.functions[index].function, self.functions[index].instance);
        if arguments.len() != function.parameters.len() {
            let (takes, has) = (function.parameters.len(), arguments.len());
            return self.lowerer.fail(span, format!("`{}` needs {takes} arguments, not {has}", name.name));
        }
        let mut given = Vec::new();
        for ((id, at), (parameter, ty)) in arguments.into_iter().zip(&function.parameters) {
            let what = format!("the argument `{}` of `{}`", parameter.name, name.name);
            given.push(self.lowerer.expect_type(id?, ty.ty, at, &what)?);
        }
        let key = (self.stage, index, given);
        if let Some(&known) = self.called.get(&key) {
            return known;
        }
        if std::mem::replace(&mut self.functions[index].is_open, true) {
            return self.lowerer.fail(name.span, format!("the function `{}` calls itself", name.name));
        }
        let names = function.parameters.iter().map(|(name, _)| name.name.as_str());
        let parameters: AHashMap<&str, ExprId> = names.zip(key.2.iter().copied()).collect();
        let inside = Place { instance, parameters: Some(&parameters), current: place.current };
        let what = format!("the value of the function `{}`", name.name);
        let body = self.nested(span, |this| {
            let id = this.expr(&function.body, inside)?;
            this.lowerer.expect_type(id, function.ty.ty, function.body.span, &what)
        });
        self.functions[index].is_open = false;
        self.called.insert(key, body);
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
