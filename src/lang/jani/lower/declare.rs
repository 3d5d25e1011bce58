//! Declarations: constants, variables with ranges and initial values, locations.

use std::cmp::Ordering;
use std::sync::Arc;

use ahash::{AHashMap, AHashSet};

use super::super::read::model::{Automaton, Constant, Function, Variable as Declaration};
use super::super::read::types::Bounds;
use super::scope::{Declared, Instance, Known, Level, Meaning, Place, Transient};
use super::state::{Inputs, Lowering};
use crate::ast::{BinaryOp, Expr, Ident, Span};
use crate::check::{Wanted, given_values};
use crate::valuation::Binding;
use meliora_base::error::{Diagnostic, Severity};
use meliora_base::exact::Exact;
use meliora_base::value::{Type, Value};
use meliora_model::expr::{Binary, ExprId};
use meliora_model::{VarId, Variable};

impl<'a> Lowering<'a> {
    /// Lowers the constants in the order of the text: each may use earlier ones. Returns the errors
    /// in the values that the user gives.
    pub(super) fn constants(&mut self, inputs: &Inputs<'_>, bindings: &[Binding]) -> Vec<Diagnostic> {
        let names: Vec<String> =
            self.model.constants.iter().map(|c| self.names.add_of_model(&c.name.name, c.name.span)).collect();
        let all: Vec<Wanted<'_>> =
            self.model.constants.iter().zip(&names).map(|(c, name)| wanted(c, name)).collect();
        let (given, wrong) = given_values(&all, inputs.constants, bindings);
        self.lowerer.report_missing(&all, inputs.constants, bindings);
        let given: AHashMap<usize, Exact> = given.into_iter().collect();
        self.pending = self.model.constants.iter().map(|c| (c.name.name.as_str(), false)).collect();
        for (index, constant) in self.model.constants.iter().enumerate() {
            let what = format!("the constant `{}`", constant.name.name);
            if constant.ty.dimensions > 0 {
                self.lowerer.fail::<()>(constant.ty.span, "a constant cannot be an array");
            }
            let value = match (&constant.value, given.get(&index)) {
                (Some(e), _) => self.constant_literal(e, Place::default(), constant.ty.ty, &what),
                (None, given) => {
                    given.map(|value| (self.lowerer.pool.exact_value(value.clone()), value.clone()))
                }
            };
            let Some((id, value)) = value else {
                self.pending.insert(&constant.name.name, true);
                continue;
            };
            self.within(&value, &constant.ty, constant.name.span, &what);
            self.pending.remove(constant.name.name.as_str());
            self.declare_global(&constant.name, Meaning::Constant(id));
            self.constant_values.push((names[index].clone(), value));
        }
        wrong
    }

    /// Reports a constant outside of the bounds of its type.
    fn within(&mut self, value: &Exact, ty: &Bounds, span: Span, what: &str) {
        for (bound, op) in [(&ty.low, BinaryOp::Lt), (&ty.high, BinaryOp::Gt)] {
            let Some(bound) = bound else { continue };
            let limit = self.constant_literal(bound, Place::default(), ty.ty, "a bound");
            let Some((_, limit)) = limit else { continue };
            let order = value.clone().into_real().compare(&limit.into_real());
            if order == Some(if op == BinaryOp::Lt { Ordering::Less } else { Ordering::Greater }) {
                let value = value.rounded();
                let message = format!("{what} is {value}, outside of the bounds of its type");
                self.lowerer.fail::<()>(span, message);
            }
        }
    }

    fn declare_global(&mut self, name: &'a Ident, meaning: Meaning) {
        if let Some((_, first)) = self.globals.names.get(name.name.as_str()) {
            let first = first.span;
            self.lowerer.declared_twice(&name.name, name.span, first);
            return;
        }
        self.globals.names.insert(&name.name, (meaning, name));
    }

    /// Declares the global variables and functions, then those of each element of the system.
    pub(super) fn declarations(&mut self, elements: &[&'a Automaton]) {
        let model = self.model;
        for variable in &model.variables {
            let name = self.name_of(variable, &variable.name.name);
            let meaning = self.variable(variable, name, None);
            self.declare_global(&variable.name, meaning);
        }
        for function in &model.functions {
            let index = self.function(function, None);
            if self.globals.functions.insert(&function.name.name, index).is_some() {
                let message = format!("the function `{}` is declared twice", function.name.name);
                self.lowerer.fail::<()>(function.name.span, message);
            }
        }
        let shared = shared_names(elements);
        for automaton in elements {
            self.element(automaton, &shared);
        }
        self.transient_values();
    }

    /// Returns the name of a variable in formulas. A transient variable has none there: labels and reward
    /// structures have its own.
    fn name_of(&mut self, variable: &Declaration, wanted: &str) -> String {
        match variable.transient {
            true => self.names.add(wanted),
            false => self.names.add_of_model(wanted, variable.name.span),
        }
    }

    /// Keeps the names of constants and variables that formulas can use.
    pub(super) fn keep_names(&mut self) {
        let model = self.model;
        let constants = model.constants.iter().map(|constant| &constant.name);
        let local = model.automata.iter().flat_map(|automaton| &automaton.variables);
        let variables = model.variables.iter().chain(local).map(|variable| &variable.name);
        self.names.keep(constants.chain(variables).map(|ident| ident.name.as_str()));
    }

    fn function(&mut self, function: &'a Function, instance: Option<usize>) -> usize {
        self.functions.push(Declared { function, instance, is_open: false });
        self.functions.len() - 1
    }

    /// Declares an element of the system: its location, variables and functions.
    fn element(&mut self, automaton: &'a Automaton, shared: &AHashSet<&str>) {
        let index = self.instances.len();
        let name = self.modules.distinct(&automaton.name.name);
        let mut locations: AHashMap<&'a str, usize> = AHashMap::new();
        for (position, location) in automaton.locations.iter().enumerate() {
            if let Some(first) = locations.insert(&location.name.name, position) {
                let first = automaton.locations[first].name.span;
                self.lowerer.declared_twice(&location.name.name, location.name.span, first);
            }
        }
        let level = Level::default();
        self.instances.push(Instance { automaton, name: name.clone(), level, location: None, locations });
        self.instances[index].location = self.location(automaton, &name, index);
        for variable in &automaton.variables {
            let own = variable.name.name.as_str();
            let taken = shared.contains(own) || self.globals.names.contains_key(own);
            let wanted = if taken { format!("{name}_{own}") } else { own.to_owned() };
            let unique = if taken { self.names.add(&wanted) } else { self.name_of(variable, &wanted) };
            let meaning = self.variable(variable, unique, Some(index));
            let before = self.instances[index].level.names.insert(own, (meaning, &variable.name));
            if let Some((_, first)) = before {
                self.lowerer.declared_twice(own, variable.name.span, first.span);
            }
        }
        for function in &automaton.functions {
            let position = self.function(function, Some(index));
            self.instances[index].level.functions.insert(&function.name.name, position);
        }
    }

    /// Adds the variable for the location of an automaton that has several.
    fn location(&mut self, automaton: &Automaton, name: &str, module: usize) -> Option<VarId> {
        let count = i64::try_from(automaton.locations.len()).ok()?;
        let first = automaton.locations.iter().position(|l| l.name.name == automaton.initial[0].name);
        for initial in automaton.initial.iter() {
            if !automaton.locations.iter().any(|l| l.name.name == initial.name) {
                self.lowerer.fail::<()>(initial.span, format!("unknown location `{}`", initial.name));
            }
        }
        if count == 1 {
            return None;
        }
        let initial = first.filter(|_| automaton.initial.len() == 1);
        let name = self.names.add(&format!("{name}_loc"));
        Some(self.add(Variable {
            name,
            ty: Type::Int,
            low: 0,
            high: count - 1,
            module: Some(module),
            initial: initial.and_then(|i| i64::try_from(i).ok()),
            values: automaton.locations.iter().map(|l| l.name.name.clone()).collect(),
            span: automaton.name.span.range(),
        }))
    }

    pub(super) fn add(&mut self, variable: Variable) -> VarId {
        self.variables.push(variable);
        VarId(u32::try_from(self.variables.len() - 1).unwrap_or(u32::MAX))
    }

    fn variable(&mut self, declared: &'a Declaration, name: String, instance: Option<usize>) -> Meaning {
        if declared.ty.dimensions > 0 {
            return self.array(declared, &name, instance);
        }
        if declared.transient {
            self.transients.push(Transient {
                variable: declared,
                instance,
                given: Vec::new(),
                state: Known::New,
                element: None,
            });
            return Meaning::Transient(self.transients.len() - 1);
        }
        let range = self.range(declared, &name, instance);
        // An error has been reported; a range prevents further errors.
        let (low, high) = range.unwrap_or((0, 1));
        let initial = range.and_then(|r| self.initial_value(declared, r, instance));
        let (ty, span) = (declared.ty.ty, declared.name.span.range());
        let ty = if ty == Type::Real { Type::Int } else { ty };
        let values = Vec::new();
        let id = self.add(Variable { name, ty, low, high, module: instance, initial, values, span });
        Meaning::Variable(id, ty)
    }

    pub(super) fn range(
        &mut self,
        declared: &Declaration,
        name: &str,
        instance: Option<usize>,
    ) -> Option<(i64, i64)> {
        let ty = &declared.ty;
        match ty.ty {
            Type::Bool => return Some((0, 1)),
            Type::Int => {}
            Type::Real => {
                let message = format!("the variable `{name}` is real: reals in the state are not supported");
                let diagnostic = self.lowerer.wrong(ty.span, message).severity(Severity::Unsupported);
                self.lowerer.report(diagnostic.label("not supported"));
                return None;
            }
        }
        let place = Place { instance, ..Place::default() };
        let given = self.bounds.get(name).map(|&(low, high, _)| (low, high));
        let mut bound = |e: &Option<Expr>, given: Option<i64>, what: &str| match e {
            Some(e) => match self.constant(e, place, Type::Int, what)? {
                Value::Int(i) => Some(Some(i)),
                _ => None,
            },
            None => Some(given),
        };
        let low = bound(&ty.low, given.map(|g| g.0), "the lower bound");
        let high = bound(&ty.high, given.map(|g| g.1), "the upper bound");
        let (Some(low), Some(high)) = (low?, high?) else {
            let message = format!("the variable `{name}` has no bounds");
            let diagnostic = self.lowerer.wrong(ty.span, message).severity(Severity::Unsupported);
            let by = self.bounds_by;
            let help =
                format!("give bounds, for example `{by} {name}=0..7`; values outside of them are errors");
            self.lowerer.report(diagnostic.label("unbounded integers are not supported").help(help));
            return None;
        };
        if ty.low.is_none() || ty.high.is_none() {
            self.bounds.entry(name.to_owned()).and_modify(|b| b.2 = true);
        }
        self.lowerer.check_range(low, high, ty.span, name)?;
        Some((low, high))
    }

    fn initial_value(
        &mut self,
        declared: &Declaration,
        range: (i64, i64),
        instance: Option<usize>,
    ) -> Option<i64> {
        let e = declared.initial.as_ref()?;
        let what = format!("the initial value of `{}`", declared.name.name);
        let place = Place { instance, ..Place::default() };
        let id = self.typed(e, place, declared.ty.ty, &what)?;
        self.lowerer.value_in_range(id, e.span(), &what, range)
    }

    /// Records the values that locations give to transient variables.
    fn transient_values(&mut self) {
        for index in 0..self.instances.len() {
            let automaton = self.instances[index].automaton;
            for location in automaton.locations.iter() {
                for given in &location.values {
                    let (name, value) = (&given.variable, &given.value);
                    match self.meaning(&name.name, Some(index)) {
                        Some(Meaning::Transient(t)) => {
                            self.transients[t].given.push((index, location, value));
                        }
                        Some(Meaning::Array(array)) if self.arrays[array].transients.is_some() => {
                            let message = "values that locations give to transient arrays are not supported";
                            let wrong = self.lowerer.wrong(name.span, message);
                            self.lowerer.report(wrong.severity(Severity::Unsupported).label("not supported"));
                        }
                        Some(_) => {
                            let message =
                                format!("`{}` is not transient: a location gives it no value", name.name);
                            self.lowerer.fail::<()>(name.span, message);
                        }
                        None => {
                            self.lowerer.fail::<()>(name.span, format!("unknown variable `{}`", name.name));
                        }
                    }
                }
            }
        }
    }

    /// Returns the condition that holds exactly in the initial states.
    pub(super) fn initial(&mut self) -> Option<ExprId> {
        let mut conditions = self.lowerer.initial_values(&self.variables);
        for index in 0..self.instances.len() {
            let automaton = self.instances[index].automaton;
            let mut begins = Vec::new();
            for initial in automaton.initial.iter() {
                if let Some(here) = self.at(index, initial)? {
                    begins.push((here, initial.span));
                }
            }
            if begins.len() > 1 {
                let some = self.lowerer.balanced(BinaryOp::Or, begins)?;
                conditions.push((some, automaton.name.span));
            }
        }
        let own = (0..self.instances.len()).map(|i| (Some(i), self.instances[i].automaton.restrict.as_ref()));
        let restrictions: Vec<_> = own.chain([(None, self.model.restrict.as_ref())]).collect();
        let mut is_restricted = false;
        for (instance, e) in restrictions {
            let Some(e) = e else { continue };
            let place = Place { instance, ..Place::default() };
            let condition = self.typed(&e.exp, place, Type::Bool, "the restriction of the initial states")?;
            is_restricted |= self.lowerer.pool.literal(condition) != Some(Value::Bool(true));
            conditions.push((condition, e.exp.span()));
        }
        // If one variable has no initial value, the condition defines the initial values of all.
        if is_restricted || self.variables.iter().any(|v| v.initial.is_none()) {
            self.variables.iter_mut().for_each(|v| v.initial = None);
        }
        self.lowerer.balanced(BinaryOp::And, conditions)
    }

    /// Returns the condition that an element is in a location; `Some(None)` if it has only one.
    #[allow(clippy::option_option)]
    pub(super) fn at(&mut self, instance: usize, location: &Ident) -> Option<Option<ExprId>> {
        let Some(position) = self.position(instance, location) else {
            let name = self.instances[instance].automaton.name.name.clone();
            let message = format!("unknown location `{}` in `{name}`", location.name);
            return self.lowerer.fail(location.span, message);
        };
        let Some(variable) = self.instances[instance].location else { return Some(None) };
        let variable = self.lowerer.pool.var(variable, Type::Int);
        let value = self.lowerer.pool.value(Value::Int(position));
        Some(Some(self.lowerer.pool.binary(Binary::Eq, variable, value)))
    }

    pub(super) fn position(&self, instance: usize, location: &Ident) -> Option<i64> {
        let position = self.instances[instance].locations.get(location.name.as_str())?;
        i64::try_from(*position).ok()
    }

    /// Reports bounds given to variables that are not unbounded; [`Lowering::range`] marks the used
    /// ones.
    pub(super) fn unused_bounds(&mut self, inputs: &Inputs<'_>) -> Vec<Diagnostic> {
        let mut unused: Vec<_> =
            self.bounds.iter().filter(|(_, b)| !b.2).map(|(name, _)| name.clone()).collect();
        unused.sort();
        let wrong = |name: String| {
            let at = inputs.bounds.text.find(&name).unwrap_or(0);
            let message = format!("the model has no unbounded variable `{name}`");
            Diagnostic::new(&Arc::clone(inputs.bounds), at..at + name.len(), message)
        };
        unused.into_iter().map(wrong).collect()
    }
}

fn wanted<'c>(constant: &Constant, name: &'c str) -> Wanted<'c> {
    let (ty, span) = (constant.ty.ty, constant.name.span);
    Wanted { name, ty, is_defined: constant.value.is_some(), span }
}

/// Returns the names of variables that several elements declare.
fn shared_names<'a>(elements: &[&'a Automaton]) -> AHashSet<&'a str> {
    let mut met = AHashSet::new();
    let mut shared = AHashSet::new();
    for variable in elements.iter().flat_map(|a| &a.variables) {
        if !met.insert(variable.name.name.as_str()) {
            shared.insert(variable.name.name.as_str());
        }
    }
    shared
}
