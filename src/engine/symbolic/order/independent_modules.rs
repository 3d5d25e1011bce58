//! The variable order heuristic for one module, or several that never move together.
//!
//! A counter that every step changes (a battery, a clock) divides the states into slices, each of
//! which leads only into the next one. At the top, it lets the recursions proceed slice by slice.
//! Variables that are assigned come next: they remember. Other counters follow; those that guards test together
//! are interleaved bit by bit, because neighbouring states are close in each of them.

use std::fmt::Write;

use ahash::{AHashMap, AHashSet};

use super::Bit;
use super::counters::{counters, support};
use super::{Ordered, by_variables};
use meliora_model::expr::{ExprId, Node};
use meliora_model::{Command, Program, VarId};

/// Minimum percentage, among the branches that change more than flags, of branches that change a
/// counter of every step. It is below 100 because some modules have a place where nothing is
/// consumed.
const MOST_STEPS: usize = 75;

/// Returns the flags that no module owns, then the variables of one module after the other, each
/// module ordered on its own. Returns `None` if modules move together or share more than flags.
pub(super) fn by_positions(program: &Program) -> Option<Ordered> {
    let owner = |v: &VarId| program.variables[v.index()].module;
    let mut shared: Vec<VarId> = program.variable_ids().filter(|v| owner(v).is_none()).collect();
    let mut modules: Vec<IndependentModule<'_>> =
        (0..program.modules.len()).map(|m| IndependentModule::new(program, m)).collect();
    modules.retain(|w| !w.commands.is_empty() || !w.variables.is_empty());
    match modules.as_mut_slice() {
        [] => return None,
        [only] => only.variables.splice(0..0, shared.drain(..)).for_each(drop),
        _ => {
            let is_flag = |v: &VarId| program.variables[v.index()].bits() <= 1;
            let together = program.synchronisations.iter().any(|s| s.factors.len() > 1);
            if together || !shared.iter().all(is_flag) {
                return None;
            }
        }
    }
    let mut all = Ordered { bits: by_variables(program, &shared), why: String::new() };
    for module in modules {
        let one = module.ordered(program);
        all.bits.extend(one.bits);
        if !one.why.is_empty() {
            let _ = write!(all.why, "{}{}", if all.why.is_empty() { "" } else { "; " }, one.why);
        }
    }
    Some(all)
}

/// The variables by their role in a module.
#[derive(Default)]
struct Roles {
    /// Counters that every step changes.
    ticking: Vec<VarId>,
    /// Counters that some steps change.
    positions: Vec<VarId>,
    /// Flags, and variables that are assigned, not counted.
    others: Vec<VarId>,
}

/// One module alone.
struct IndependentModule<'p> {
    variables: Vec<VarId>,
    commands: Vec<&'p Command>,
}

impl<'p> IndependentModule<'p> {
    fn new(program: &'p Program, module: usize) -> Self {
        let owned = |v: &VarId| program.variables[v.index()].module == Some(module);
        IndependentModule {
            variables: program.variable_ids().filter(owned).collect(),
            commands: program.commands.iter().filter(|c| c.module == module).collect(),
        }
    }

    fn ordered(&self, program: &Program) -> Ordered {
        let roles = self.roles(program);
        let groups = self.guard_groups(program, &roles.positions);
        let name = |v: &VarId| program.variables[v.index()].name.as_str();
        let names = |list: &[VarId]| list.iter().map(name).collect::<Vec<_>>().join(" and ");
        let mut why = Vec::new();
        if !roles.ticking.is_empty() {
            why.push(format!("{} on top, since every step changes it", names(&roles.ticking)));
        }
        for group in groups.iter().filter(|g| g.len() > 1) {
            why.push(format!("{} bit by bit, since guards test them together", names(group)));
        }
        let mut bits = by_variables(program, &[roles.ticking, roles.others].concat());
        bits.extend(groups.iter().flat_map(|group| interleaved(program, group)));
        Ordered { bits, why: why.join("; ") }
    }

    /// Returns the role of each variable in the module.
    fn roles(&self, program: &Program) -> Roles {
        let counters = counters(program, &self.commands);
        let ticks = self.ticks(program, &counters);
        let mut roles = Roles::default();
        for &v in &self.variables {
            let role = match program.variables[v.index()].bits() > 1 && counters.contains(&v) {
                true if ticks.contains(&v) => &mut roles.ticking,
                true => &mut roles.positions,
                false => &mut roles.others,
            };
            role.push(v);
        }
        roles
    }

    /// Returns the counters that nearly all branches change, of the branches that change more than
    /// flags.
    fn ticks(&self, program: &Program, counters: &AHashSet<VarId>) -> AHashSet<VarId> {
        let (mut moved, mut steps): (AHashMap<VarId, usize>, usize) = (AHashMap::new(), 0);
        for branch in self.commands.iter().flat_map(|c| &c.branches) {
            let changes = |(v, e): &&(VarId, ExprId)| program.pool.node(*e) != Node::Var(*v);
            let changed: Vec<VarId> = branch.updates.iter().filter(changes).map(|(v, _)| *v).collect();
            if changed.iter().any(|v| program.variables[v.index()].bits() > 1) {
                steps += 1;
                changed
                    .into_iter()
                    .filter(|v| counters.contains(v))
                    .for_each(|v| *moved.entry(v).or_default() += 1);
            }
        }
        let often = |n: usize| steps > 0 && n * 100 >= steps * MOST_STEPS;
        moved.into_iter().filter(|(_, n)| often(*n)).map(|(v, _)| v).collect()
    }

    /// Partitions the variables: those that occur in one guard, directly or through others, form a
    /// group.
    fn guard_groups(&self, program: &Program, variables: &[VarId]) -> Vec<Vec<VarId>> {
        let mut groups: Vec<Vec<VarId>> = variables.iter().map(|&v| vec![v]).collect();
        // Shared subexpressions of guards are visited once; the variables found in them are kept.
        let mut found: AHashMap<ExprId, AHashSet<VarId>> = AHashMap::new();
        for command in &self.commands {
            let together = support(program, command.guard, variables, &mut found);
            let (joined, mut apart): (Vec<_>, Vec<_>) =
                groups.into_iter().partition(|g: &Vec<VarId>| g.iter().any(|v| together.contains(v)));
            apart.extend((!joined.is_empty()).then(|| joined.concat()));
            groups = apart;
        }
        let place = |v: &VarId| variables.iter().position(|w| w == v);
        groups.iter_mut().for_each(|g| g.sort_by_key(place));
        groups.sort_by_key(|g| g.first().and_then(place));
        groups
    }
}

/// Returns the bits of some variables from the most significant bit down, bits of equal weight
/// together.
fn interleaved(program: &Program, variables: &[VarId]) -> Vec<Bit> {
    let width = |v: &VarId| program.variables[v.index()].bits();
    let most = variables.iter().map(width).max().unwrap_or(0);
    let row = |index: u32| {
        let has = move |v: &&VarId| index < width(v);
        variables.iter().filter(has).map(move |&variable| Bit { variable, index })
    };
    (0..most).rev().flat_map(row).collect()
}
