//! The order for copies of one module whose clocks advance together.

use ahash::AHashSet;

use super::counts;
use crate::model::value::Type;
use crate::model::{Command, Program, Synchronisation, VarId};

/// Fewer copies are as well off in the order of declaration.
const FEWEST: usize = 3;

/// What every copy has before its clock, copy by copy; then all that is not the copies'; then the
/// clocks of all copies, and what comes after them, role by role. None without such copies.
///
/// Their clocks depend on each other at every tick, and each on its own module through what stands
/// before the clock only, which is mostly the mode the copy is in.
pub(super) fn by_roles(program: &Program) -> Option<Vec<VarId>> {
    let (copies, clock) = clocked(program)?;
    let taken: AHashSet<VarId> = copies.iter().flatten().copied().collect();
    let all = (0..program.variables.len() as u32).map(VarId);
    let mut order: Vec<VarId> = copies.iter().flat_map(|copy| &copy[..clock]).copied().collect();
    order.extend(all.filter(|v| !taken.contains(v)));
    for role in clock..copies[0].len() {
        order.extend(copies.iter().map(|copy| copy[role]));
    }
    Some(order)
}

/// The variables of each copy, and which of them is the clock: the first one, where several advance.
fn clocked(program: &Program) -> Option<(Vec<Vec<VarId>>, usize)> {
    let together = program.synchronisations.iter().filter_map(|s| advancing_together(program, s));
    together.min_by_key(|(_, clock)| *clock)
}

/// The same for the clocks that one synchronisation advances.
fn advancing_together(program: &Program, by: &Synchronisation) -> Option<(Vec<Vec<VarId>>, usize)> {
    let mut found: Vec<(Vec<VarId>, usize)> = Vec::new();
    for factor in &by.factors {
        let mut commands = factor.iter().map(|c| &program.commands[c.index()]);
        found.extend(commands.find_map(|c| advanced(program, c)));
    }
    let alike = |a: &(Vec<VarId>, usize), b: &(Vec<VarId>, usize)| {
        a.1 == b.1 && shape(program, &a.0) == shape(program, &b.0)
    };
    let copies = |of| found.iter().filter(move |&other| alike(of, other));
    let one = found.iter().find(|&of| copies(of).count() >= FEWEST)?;
    Some((copies(one).map(|(own, _)| own.clone()).collect(), one.1))
}

/// The variables of the module of a command, and which of them the command advances, if any.
fn advanced(program: &Program, command: &Command) -> Option<(Vec<VarId>, usize)> {
    let own: Vec<VarId> = (0..program.variables.len() as u32)
        .map(VarId)
        .filter(|v| program.variables[v.index()].module == Some(command.module))
        .collect();
    let mut updates = command.branches.iter().flat_map(|b| &b.updates);
    let (clock, _) = updates.find(|(variable, e)| counts(program, *variable, *e))?;
    let at = own.iter().position(|v| v == clock)?;
    Some((own, at))
}

/// Copies of a module have variables of the same types and ranges.
fn shape(program: &Program, variables: &[VarId]) -> Vec<(Type, i64, i64)> {
    let of = |v: &VarId| {
        let variable = &program.variables[v.index()];
        (variable.ty, variable.low, variable.high)
    };
    variables.iter().map(of).collect()
}
