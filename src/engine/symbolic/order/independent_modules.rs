//! The variable order heuristic for grid modules: one module that moves, or several independent
//! modules that never move together.
//!
//! A counter that every step changes (a battery, a clock) divides the states into slices, each of
//! which leads only into the next one. At the top, it lets the recursions proceed slice by slice. So
//! does the counter of an outer loop, whose steps set the counters of an inner one back.
//! Flags come next, because they only remember. Positions follow; those that guards test together
//! are interleaved bit by bit, because neighbouring states are close in each of them. A counter
//! that is only compared with bounds comes last.

use std::fmt::Write;

use ahash::{AHashMap, AHashSet};

use super::Bit;
use super::counters::{counters, is_one_way, is_stage, operands, support, thresholds};
use super::{Ordered, by_variables};
use meliora_model::expr::{ExprId, Node};
use meliora_model::{Command, Program, VarId};

/// Minimum percentage, among the branches that change more than flags, of branches that change a
/// counter of every step. It is below 100 because some modules have a place where nothing is
/// consumed.
const MOST_STEPS: usize = 75;

/// Returns the flags that no module owns, then the variables of one module after the other, each
/// module ordered on its own. Returns `None` if one module depends on another.
pub(super) fn by_positions(program: &Program) -> Option<Ordered> {
    let is_flag = |v: &VarId| program.variables[v.index()].bits() <= 1;
    let owner = |v: &VarId| program.variables[v.index()].module;
    let mut shared: Vec<VarId> = program.variable_ids().filter(|v| owner(v).is_none()).collect();
    let mut modules: Vec<IndependentModule<'_>> =
        (0..program.modules.len()).map(|m| IndependentModule::of(program, m)).collect();
    modules.retain(|w| !w.commands.is_empty() || !w.variables.is_empty());
    match modules.as_mut_slice() {
        [] => return None,
        [only] => only.variables.splice(0..0, shared.drain(..)).for_each(drop),
        several => {
            let apart = |w: &IndependentModule<'_>| {
                let foreign = |v: &VarId| owner(v) != Some(w.module) && !(owner(v).is_none() && is_flag(v));
                !w.known(program).iter().any(foreign)
            };
            let together = program.synchronisations.iter().any(|s| s.factors.len() > 1);
            if together || !shared.iter().all(is_flag) || !several.iter().all(apart) {
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

/// Returns, for a game of several modules, the counters that every step of their module changes in one
/// direction, then the other variables as declared. Returns `None` without such counters.
///
/// They divide the states into slices as in a single module: the steps of the other modules stay in a
/// slice.
pub(super) fn ticking_first(program: &Program) -> Option<Ordered> {
    program.players.as_ref()?;
    let modules = (0..program.modules.len()).map(|m| IndependentModule::of(program, m));
    let ticking = |module: IndependentModule<'_>| {
        let all = module.ticks(program, &counters(program, &module.commands));
        let one_way = |v: &VarId| all.contains(v) && is_one_way(program, &module.commands, *v);
        module.variables.into_iter().filter(one_way).collect::<Vec<_>>()
    };
    let mut order: Vec<VarId> = modules.flat_map(ticking).collect();
    if order.is_empty() {
        return None;
    }
    let why = format!("{} on top, since every step of the module changes it", names(program, &order));
    let ticking: AHashSet<VarId> = order.iter().copied().collect();
    order.extend(program.variable_ids().filter(|v| !ticking.contains(v)));
    Some(Ordered { bits: by_variables(program, &order), why })
}

/// Returns the names of some variables.
fn names(program: &Program, list: &[VarId]) -> String {
    list.iter().map(|v| program.variables[v.index()].name.as_str()).collect::<Vec<_>>().join(" and ")
}

/// The variables by their role in a module.
#[derive(Default)]
struct Roles {
    /// Counters that every step changes.
    ticking: Vec<VarId>,
    /// Other counters that count the rounds of an outer loop.
    stages: Vec<VarId>,
    /// Variables of one bit.
    flags: Vec<VarId>,
    /// Variables that are assigned, not counted.
    modes: Vec<VarId>,
    /// Counters that some steps change, and that guards test for single values.
    positions: Vec<VarId>,
    /// Counters that some steps change, and that guards only compare with bounds.
    bounded: Vec<VarId>,
}

/// One module alone.
struct IndependentModule<'p> {
    module: usize,
    variables: Vec<VarId>,
    commands: Vec<&'p Command>,
}

impl<'p> IndependentModule<'p> {
    fn of(program: &'p Program, module: usize) -> Self {
        let owned = |v: &VarId| program.variables[v.index()].module == Some(module);
        IndependentModule {
            module,
            variables: program.variable_ids().filter(owned).collect(),
            commands: program.commands.iter().filter(|c| c.module == module).collect(),
        }
    }

    /// Returns the variables that the commands of the module read or write.
    fn known(&self, program: &Program) -> AHashSet<VarId> {
        let updates = || self.commands.iter().flat_map(|c| &c.branches).flat_map(|b| &b.updates);
        let guards = self.commands.iter().map(|c| c.guard);
        let weights = self.commands.iter().flat_map(|c| &c.branches).map(|b| b.probability);
        let mut known: AHashSet<VarId> = updates().map(|(v, _)| *v).collect();
        let (mut stack, mut seen) =
            (Vec::from_iter(guards.chain(weights).chain(updates().map(|(_, e)| *e))), AHashSet::new());
        while let Some(e) = stack.pop() {
            if seen.insert(e) {
                match program.pool.node(e) {
                    Node::Var(v) => drop(known.insert(v)),
                    node => stack.extend(operands(node)),
                }
            }
        }
        known
    }

    fn ordered(&self, program: &Program) -> Ordered {
        let roles = self.roles(program);
        let groups = self.guard_groups(program, &roles.positions);
        let names = |list: &[VarId]| names(program, list);
        let mut why = Vec::new();
        if !roles.ticking.is_empty() {
            why.push(format!("{} on top, since every step changes it", names(&roles.ticking)));
        }
        if !roles.stages.is_empty() {
            why.push(format!("{} on top, since its steps begin other counts anew", names(&roles.stages)));
        }
        for group in groups.iter().filter(|g| g.len() > 1) {
            why.push(format!("{} bit by bit, since guards test them together", names(group)));
        }
        if !roles.bounded.is_empty() {
            why.push(format!("{} last, since guards compare it with bounds only", names(&roles.bounded)));
        }
        let mut bits =
            by_variables(program, &[roles.ticking, roles.stages, roles.flags, roles.modes].concat());
        bits.extend(groups.iter().flat_map(|group| interleaved(program, group)));
        bits.extend(by_variables(program, &roles.bounded));
        Ordered { bits, why: why.join("; ") }
    }

    /// Returns the role of each variable in the module.
    fn roles(&self, program: &Program) -> Roles {
        let counters = counters(program, &self.commands);
        let bounds = thresholds(program, &self.commands, &counters);
        let mut ticks = self.ticks(program, &counters);
        if ticks.iter().any(|v| bounds.contains(v)) {
            // The others are positions, even if every step changes them.
            ticks.retain(|v| bounds.contains(v));
        }
        let mut roles = Roles::default();
        for &v in &self.variables {
            let role = match program.variables[v.index()].bits() {
                0 | 1 => &mut roles.flags,
                _ if ticks.contains(&v) => &mut roles.ticking,
                _ if !counters.contains(&v) => &mut roles.modes,
                _ if is_stage(program, &self.commands, &counters, v) => &mut roles.stages,
                _ if bounds.contains(&v) => &mut roles.bounded,
                _ => &mut roles.positions,
            };
            role.push(v);
        }
        if roles.positions.is_empty() {
            // Counters that are only compared with bounds may still be positions.
            roles.positions = std::mem::take(&mut roles.bounded);
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
