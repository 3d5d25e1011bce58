//! From the tree to the flat program: names, types, locations, assignments, synchronisation.
//!
//! Locations become variables, edges become commands, and vectors become synchronisations. A
//! transient variable becomes the expression of its values in the locations. Edges of one vector
//! that depend on each other are multiplied out: they assign the same variable, or one reads a
//! variable that the other has assigned with a smaller index.

mod arrays;
mod declare;
mod edges;
mod expr;
mod labels;
mod properties;
mod rewards;
mod scope;
mod state;
mod system;

use std::sync::Arc;

use ahash::{AHashMap, AHashSet};

use super::read::model::Model;
use crate::ast::Ident;
use crate::check::{self, Checked};
use crate::named::Property;
use crate::names::renamed;
use crate::property::{self, Named};
use crate::refusal::Refusal;
use crate::valuation::Binding;
use meliora_base::error::{Error, Result};
use meliora_base::progress::ProgressSink;
use meliora_model::expr::ExprId;
use meliora_model::rewards::RewardStructure;
use meliora_model::{Command, Program, Synchronisation, VarId};
use scope::Place;
pub(super) use state::Inputs;
use state::Lowering;

/// The reason against a property that has no better one.
const NO_MEANING: &str = "it has no meaning in this model";

/// A property by its name, over the pool of the program, or the reason against it.
type Lowered = (String, Result<property::Property, Refusal>);

/// Flattens a model.
///
/// # Errors
/// Returns as many errors of meaning as can be distinguished; a limit.
pub(super) fn program<'a>(
    model: &'a Model,
    inputs: &Inputs<'a>,
    bindings: &[Binding],
    bounds: Vec<(String, i64, i64)>,
    sink: &'a dyn ProgressSink,
) -> Result<Checked> {
    let mut lowering = Lowering::new(model, inputs, bounds, sink);
    lowering.keep_names();
    let mut foreign = lowering.constants(inputs, bindings);
    if foreign.is_empty() && lowering.lowerer.diagnostics.is_empty() {
        let elements = lowering.elements();
        lowering.declarations(&elements);
        foreign = lowering.unused_bounds(inputs);
    }
    lowering.lowerer.poll.check()?;
    if !foreign.is_empty() || !lowering.lowerer.diagnostics.is_empty() {
        // Errors in names and constants come first: without these, later errors would be noise.
        foreign.append(&mut lowering.lowerer.diagnostics);
        return Err(Error::Input(foreign));
    }
    lowering.finish(bindings)
}

impl Lowering<'_> {
    fn finish(mut self, bindings: &[Binding]) -> Result<Checked> {
        let initial = self.initial();
        let moves = self.moves();
        let mut rewards = self.reward_structures();
        let (properties, targets) = self.properties(&mut rewards);
        let formulas = self.formulas();
        self.lowerer.poll.check()?;
        let (Some(initial), Some((commands, synchronisations)), true) =
            (initial, moves, self.lowerer.diagnostics.is_empty())
        else {
            return Err(Error::Input(self.lowerer.diagnostics));
        };
        self.own(&commands, &synchronisations);
        self.warn();
        let labels = self.labels(targets);
        self.warnings
            .extend(check::reward_warnings(&rewards).into_iter().chain(self.lowerer.inexact.clone()));
        let joint = self.joint_modules.into_iter().map(|(_, name)| name);
        let program = Program {
            source: Arc::clone(&self.lowerer.source),
            kind: self.model.kind,
            constants: self.constant_values,
            given_constants: bindings.iter().map(|b| b.name.name.clone()).collect(),
            pool: self.lowerer.pool.into(),
            variables: self.variables,
            modules: self.instances.into_iter().map(|i| i.name).chain(joint).collect(),
            initial,
            actions: self.actions.names,
            commands,
            synchronisations,
            labels,
            formulas,
            rewards,
            inexact: self.lowerer.inexact,
            monitors: None,
            planning: None,
            stop: None,
            players: None,
        };
        let checked = |(name, lowered): Lowered| {
            let term = lowered.and_then(|property| {
                property.term(&program, &program.source, &Named::default()).map_err(|e| Refusal::new(&e))
            });
            Property { name, term }
        };
        let properties = properties.into_iter().map(checked).collect();
        Ok(Checked { program, warnings: self.warnings, properties })
    }

    /// Lowers the properties. Returns them with the labels that they give: the targets of those that ask
    /// about reaching one.
    fn properties(&mut self, rewards: &mut Vec<RewardStructure>) -> (Vec<Lowered>, Vec<(String, ExprId)>) {
        let (mut properties, mut targets) = (Vec::new(), Vec::new());
        let model = self.model;
        let mut met = AHashSet::new();
        let doubled: AHashSet<&str> =
            model.properties.iter().map(|p| p.name.as_str()).filter(|name| !met.insert(*name)).collect();
        for property in model.properties.iter() {
            let name = &property.name;
            let lowered = match &property.asks {
                _ if doubled.contains(name.as_str()) => {
                    Err(Refusal::without_place(format!("several properties have the name \"{name}\"")))
                }
                Err(refusal) => Err(refusal.clone()),
                Ok(expressed) => {
                    targets.extend(self.target(name, expressed).map(|target| (name.clone(), target)));
                    self.expressed(name, expressed, rewards)
                }
            };
            properties.push((name.clone(), lowered));
        }
        (properties, targets)
    }

    /// Takes back the errors after the first `told`, and returns the first as a reason.
    pub(super) fn refused(&mut self, told: usize) -> Option<Refusal> {
        self.lowerer.diagnostics.split_off(told).first().map(Refusal::at)
    }

    /// Returns the global functions without parameters, for targets that use them.
    fn formulas(&mut self) -> Vec<(String, ExprId)> {
        let mut formulas = Vec::new();
        for function in &self.model.functions {
            if function.parameters.is_empty() && !self.globals.names.contains_key(function.name.name.as_str())
            {
                let Ident { span, .. } = function.name;
                if let Some(arrays::Parts::One(id)) = self.call(&function.name, &[], Place::default(), span) {
                    formulas.push((self.names.add(&function.name.name), id));
                }
            }
        }
        formulas
    }

    /// Assigns a global variable to its only writer, which matters for variable orders.
    fn own(&mut self, commands: &[Command], synchronisations: &[Synchronisation]) {
        let mut writers: AHashMap<VarId, AHashSet<usize>> = AHashMap::new();
        for id in synchronisations.iter().flat_map(|s| s.factors.iter().flatten()) {
            let command = &commands[id.index()];
            for (variable, _) in command.branches.iter().flat_map(|b| &b.updates) {
                writers.entry(*variable).or_default().insert(command.module);
            }
        }
        for (index, variable) in self.variables.iter_mut().enumerate() {
            let id = VarId(u32::try_from(index).unwrap_or(u32::MAX));
            let by: Vec<usize> = writers.get(&id).into_iter().flatten().copied().collect();
            if let [one] = by.as_slice()
                && variable.module.is_none()
                && *one < self.instances.len()
            {
                variable.module = Some(*one);
            }
        }
    }

    fn warn(&mut self) {
        let source = &self.lowerer.source;
        self.warnings.extend(self.names.changed.iter().map(|changed| renamed(source, changed)));
    }
}
