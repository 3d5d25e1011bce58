//! Names that the modelling language allows, for programs from other formats.

use std::sync::Arc;

use crate::names::Names;
use meliora_model::Program;

/// Replaces the names of variables, actions, modules and reward structures that are not identifiers. Those of
/// other formats may be any text.
pub(super) fn with_identifiers(mut program: Arc<Program>) -> Arc<Program> {
    let actions = Names::identifiers(program.actions.iter());
    if actions != program.actions {
        Arc::make_mut(&mut program).actions = actions;
    }
    let variables = program.variables.iter().map(|variable| &variable.name);
    let names = Names::identifiers(variables.clone());
    if !variables.eq(&names) {
        let all = Arc::make_mut(&mut program).variables.iter_mut();
        all.zip(names).for_each(|(variable, name)| variable.name = name);
    }
    let modules = Names::identifiers(program.modules.iter());
    if modules != program.modules {
        Arc::make_mut(&mut program).modules = modules;
    }
    let titled = || program.rewards.iter().filter_map(|structure| structure.name.as_ref());
    let titles = Names::identifiers(titled());
    if !titled().eq(&titles) {
        let all = Arc::make_mut(&mut program).rewards.iter_mut();
        let named = all.filter_map(|structure| structure.name.as_mut());
        named.zip(titles).for_each(|(name, title)| *name = title);
    }
    program
}
