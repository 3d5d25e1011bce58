//! Values of constants: given by the user, or derived from other constants.

use std::sync::Arc;

use super::collect::Parts;
use super::lowerer::Lowerer;
use super::scope::{NO_RENAMING, Symbol};
use crate::ast::{ConstDef, Span};
use crate::valuation::Binding;
use meliora_base::error::{Diagnostic, SourceFile};
use meliora_base::exact::{Exact, Real};
use meliora_base::value::Type;

/// The properties of a constant that matter for its value.
pub(crate) struct Wanted<'c> {
    pub(crate) name: &'c str,
    pub(crate) ty: Type,
    /// True if the model defines its value.
    pub(crate) is_defined: bool,
    pub(crate) span: Span,
}

/// Returns the given values, each with the position of its constant, and the errors of the others.
pub(crate) fn given_values(
    constants: &[Wanted<'_>],
    given: &Arc<SourceFile>,
    bindings: &[Binding],
) -> (Vec<(usize, Exact)>, Vec<Diagnostic>) {
    let (mut values, mut wrong) = (Vec::new(), Vec::new());
    for binding in bindings {
        match given_value(constants, given, binding) {
            Ok(value) => values.push(value),
            Err(diagnostic) => wrong.push(*diagnostic),
        }
    }
    (values, wrong)
}

fn given_value(
    constants: &[Wanted<'_>],
    given: &Arc<SourceFile>,
    binding: &Binding,
) -> Result<(usize, Exact), Box<Diagnostic>> {
    let name = &binding.name.name;
    let at = |message: String| Diagnostic::new(given, binding.name.span.range(), message);
    let Some(index) = constants.iter().position(|c| c.name == *name) else {
        return Err(Box::new(with_undefined(at(format!("the model has no constant `{name}`")), constants)));
    };
    let constant = &constants[index];
    if constant.is_defined {
        let diagnostic = at(format!("the constant `{name}` already has a value in the model"));
        let help =
            format!("write `const {} {name};` in the model, and the value can be given here", constant.ty);
        return Err(Box::new(diagnostic.help(help)));
    }
    match (constant.ty, &binding.value) {
        (Type::Real, Exact::Int(i)) => Ok((index, Exact::Real(Real::from(*i)))),
        (ty, value) if value.ty() == ty => Ok((index, value.clone())),
        (ty, value) => {
            let value = value.rounded();
            let message = format!("type error: the constant `{name}` is of type `{ty}`, and {value} is not");
            Err(Box::new(Diagnostic::new(given, binding.span.range(), message)))
        }
    }
}

impl<'a> Lowerer<'a> {
    /// Gives the undefined constants their values, and returns errors in the given values. A
    /// missing value is recorded as an error of the model.
    pub(super) fn give_constants(
        &mut self,
        parts: &Parts<'a>,
        given: &Arc<SourceFile>,
        bindings: &[Binding],
    ) -> Vec<Diagnostic> {
        let wanted: Vec<_> = parts.constants.iter().map(|c| wanted(c)).collect();
        let (values, wrong) = given_values(&wanted, given, bindings);
        for (index, value) in values {
            // A name that is declared twice has been reported.
            if let Some(Symbol::Definition(definition)) = self.scope.symbol(wanted[index].name) {
                let value = self.pool.exact_value(value);
                self.lowered.insert((definition, NO_RENAMING), Some(value));
            }
        }
        self.report_missing(&wanted, given, bindings);
        wrong
    }

    /// Reports the constants without a value; the name of `given` is the option that sets them.
    pub(crate) fn report_missing(
        &mut self,
        constants: &[Wanted<'_>],
        given: &SourceFile,
        bindings: &[Binding],
    ) {
        let named = |c: &Wanted<'_>| bindings.iter().any(|b| b.name.name == c.name);
        let missing: Vec<_> = constants.iter().filter(|c| !c.is_defined && !named(c)).collect();
        let Some((first, rest)) = missing.split_first() else { return };
        let names: Vec<_> = missing.iter().map(|c| format!("`{}`", c.name)).collect();
        let (constants, have) = if rest.is_empty() { ("constant", "has") } else { ("constants", "have") };
        let message = format!("the {constants} {} {have} no value", names.join(", "));
        let example: Vec<_> = missing.iter().map(|c| format!("{}=…", c.name)).collect();
        let mut diagnostic = self.wrong(first.span, message).label("undefined");
        for constant in rest {
            diagnostic = diagnostic.related(constant.span.range(), "undefined");
        }
        self.report(diagnostic.help(format!("give values with `{} {}`", given.name, example.join(","))));
    }

    /// Returns all constants with their values, in the order of declaration.
    pub(super) fn constant_values(&mut self, parts: &Parts<'a>) -> Option<Vec<(String, Exact)>> {
        let value = |c: &&ConstDef| {
            let Some(Symbol::Definition(d)) = self.scope.symbol(&c.name.name) else { return None };
            let id = self.definition(d, NO_RENAMING)?;
            Some((c.name.name.clone(), self.pool.exact_literal(id)?))
        };
        // Collected in two steps, so that every constant is checked.
        let all: Vec<_> = parts.constants.iter().map(value).collect();
        all.into_iter().collect()
    }
}

fn wanted(constant: &ConstDef) -> Wanted<'_> {
    Wanted {
        name: &constant.name.name,
        ty: constant.ty.ty(),
        is_defined: constant.value.is_some(),
        span: constant.name.span,
    }
}

/// Adds a help text that lists the constants without a value.
fn with_undefined(diagnostic: Diagnostic, constants: &[Wanted<'_>]) -> Diagnostic {
    let names: Vec<_> = constants.iter().filter(|c| !c.is_defined).map(|c| c.name).collect();
    match names.as_slice() {
        [] => diagnostic.help("the model has no undefined constants; leave this out"),
        names => diagnostic.help(format!("the undefined constants are {}", names.join(", "))),
    }
}
