//! Values for constants: those given from outside, and those that follow.

use std::sync::Arc;

use super::collect::Parts;
use super::lower::Lowerer;
use super::scope::{NO_RENAMING, Symbol};
use crate::error::{Diagnostic, SourceFile};
use crate::lang::ast::ConstDef;
use crate::lang::valuation::Binding;
use crate::model::value::{Type, Value};

impl<'a> Lowerer<'a> {
    /// Gives the undefined constants their values. Returns what is wrong with the values given; that
    /// some are missing is recorded as an error of the model.
    pub(super) fn give_constants(
        &mut self,
        parts: &Parts<'a>,
        given: &Arc<SourceFile>,
        bindings: &[Binding],
    ) -> Vec<Diagnostic> {
        let mut wrong = Vec::new();
        for binding in bindings {
            match self.given_value(parts, given, binding) {
                Ok((definition, value)) => {
                    let value = self.pool.value(value);
                    self.lowered.insert((definition, NO_RENAMING), Some(value));
                }
                Err(diagnostic) => wrong.push(*diagnostic),
            }
        }
        let named = |c: &ConstDef| bindings.iter().any(|b| b.name == c.name);
        let missing: Vec<_> =
            parts.constants.iter().copied().filter(|c| c.value.is_none() && !named(c)).collect();
        self.report_missing(&missing);
        wrong
    }

    fn given_value(
        &self,
        parts: &Parts<'a>,
        given: &Arc<SourceFile>,
        binding: &Binding,
    ) -> Result<(usize, Value), Box<Diagnostic>> {
        let name = &binding.name.name;
        let at = |message: String| Diagnostic::new(given, binding.name.span.range(), message);
        let Some(constant) = parts.constants.iter().find(|c| c.name == binding.name) else {
            return Err(Box::new(with_undefined(at(format!("the model has no constant `{name}`")), parts)));
        };
        if constant.value.is_some() {
            let diagnostic = at(format!("the constant `{name}` has its value in the model already"));
            return Err(Box::new(with_undefined(diagnostic, parts)));
        }
        let definition = match self.scope.symbol(name) {
            Some(Symbol::Definition(d)) => d,
            _ => return Err(Box::new(at(format!("`{name}` is no constant")))),
        };
        let ty = self.scope.definitions[definition].constant.unwrap_or(Type::Int);
        let value = match (ty, binding.value) {
            (Type::Real, Value::Int(i)) => Value::Real(i as f64),
            (ty, value) if value.ty() == ty => value,
            (ty, value) => {
                let message =
                    format!("type error: the constant `{name}` is of type `{ty}`, and {value} is not");
                return Err(Box::new(Diagnostic::new(given, binding.span.range(), message)));
            }
        };
        Ok((definition, value))
    }

    fn report_missing(&mut self, missing: &[&ConstDef]) {
        let Some((first, rest)) = missing.split_first() else { return };
        let names: Vec<_> = missing.iter().map(|c| format!("`{}`", c.name.name)).collect();
        let (constants, have) = if rest.is_empty() { ("constant", "has") } else { ("constants", "have") };
        let message = format!("the {constants} {} {have} no value", names.join(", "));
        let example: Vec<_> = missing.iter().map(|c| format!("{}=…", c.name.name)).collect();
        let mut diagnostic = self.wrong(first.name.span, message).label("undefined");
        for constant in rest {
            diagnostic = diagnostic.related(constant.name.span.range(), "undefined");
        }
        self.report(diagnostic.help(format!("give values with `--const {}`", example.join(","))));
    }

    /// All constants with their values in the order of declaration.
    pub(super) fn constant_values(&mut self, parts: &Parts<'a>) -> Option<Vec<(String, Value)>> {
        let value = |c: &&ConstDef| {
            let Some(Symbol::Definition(d)) = self.scope.symbol(&c.name.name) else { return None };
            let id = self.definition(d, NO_RENAMING)?;
            Some((c.name.name.clone(), self.pool.literal(id)?))
        };
        // Collected in two steps, so that every constant is looked at.
        let all: Vec<_> = parts.constants.iter().map(value).collect();
        all.into_iter().collect()
    }
}

/// Adds which constants can be given.
fn with_undefined(diagnostic: Diagnostic, parts: &Parts<'_>) -> Diagnostic {
    let names: Vec<_> =
        parts.constants.iter().filter(|c| c.value.is_none()).map(|c| c.name.name.as_str()).collect();
    match names.as_slice() {
        [] => diagnostic.help("the model has no undefined constant: leave it out"),
        names => diagnostic.help(format!("the undefined constants are {}", names.join(", "))),
    }
}
