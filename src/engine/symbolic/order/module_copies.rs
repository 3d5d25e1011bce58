//! The variable order heuristic for copies of one module whose clocks advance together.

use ahash::AHashMap;

use super::counters::counts;
use meliora_base::value::Type;
use meliora_model::{CommandId, Program, Synchronisation, VarId};

/// Minimum number of copies. With fewer, the order of declaration is as good.
const FEWEST: usize = 3;

/// Returns the variables of each copy before its clock, copy by copy; then all variables outside
/// the copies; then the clocks of all copies and the variables after them, role by role. Returns
/// `None` without such copies.
///
/// The clocks depend on each other at every tick. Each clock depends on its own module only through
/// the variables before it, mostly the mode of the copy.
pub(super) fn by_roles(program: &Program) -> Option<Vec<VarId>> {
    let modules = Modules::of(program);
    let together = program.synchronisations.iter().filter_map(|s| modules.advancing_together(program, s));
    // The first clock, if several advance.
    let Clocked { modules: copies, clock } = together.min_by_key(|c| c.clock)?;
    let copies: Vec<&[VarId]> = copies.iter().map(|&m| modules.own[m].as_slice()).collect();
    let mut order: Vec<VarId> = copies.iter().flat_map(|copy| &copy[..clock]).copied().collect();
    let mut taken = vec![false; program.variables.len()];
    copies.iter().copied().flatten().for_each(|v| taken[v.index()] = true);
    order.extend(program.variable_ids().filter(|v| !taken[v.index()]));
    for role in clock..copies[0].len() {
        order.extend(copies.iter().map(|copy| copy[role]));
    }
    Some(order)
}

/// Modules with equal variables, and the index of the clock among the variables of each.
struct Clocked {
    modules: Vec<usize>,
    clock: usize,
}

struct Modules {
    /// The variables of each module, as declared.
    own: Vec<Vec<VarId>>,
    /// A number for each module; equal for modules whose variables have the same types and ranges,
    /// as copies have.
    alike: Vec<usize>,
}

impl Modules {
    fn of(program: &Program) -> Self {
        let mut own = vec![Vec::new(); program.modules.len()];
        let mut shapes: Vec<Vec<(Type, i64, i64)>> = vec![Vec::new(); program.modules.len()];
        for (id, variable) in program.variable_ids().zip(&program.variables) {
            if let Some(module) = variable.module {
                own[module].push(id);
                shapes[module].push((variable.ty, variable.low, variable.high));
            }
        }
        let mut numbers = AHashMap::new();
        let mut number = |shape| {
            let next = numbers.len();
            *numbers.entry(shape).or_insert(next)
        };
        Modules { own, alike: shapes.into_iter().map(&mut number).collect() }
    }

    /// Returns the copies whose clocks one synchronisation advances, if there are enough.
    fn advancing_together(&self, program: &Program, by: &Synchronisation) -> Option<Clocked> {
        if by.factors.len() < FEWEST {
            return None;
        }
        let mut groups: AHashMap<(usize, usize), Vec<usize>> = AHashMap::new();
        for factor in &by.factors {
            if let Some((module, clock)) = factor.iter().find_map(|&c| self.advanced(program, c)) {
                groups.entry((self.alike[module], clock)).or_default().push(module);
            }
        }
        let mut groups: Vec<_> = groups.into_iter().filter(|(_, group)| group.len() >= FEWEST).collect();
        groups.sort();
        groups.into_iter().next().map(|((_, clock), modules)| Clocked { modules, clock })
    }

    /// Returns the module of a command and the index of the variable that the command advances, if
    /// any.
    fn advanced(&self, program: &Program, command: CommandId) -> Option<(usize, usize)> {
        let command = &program.commands[command.index()];
        let mut updates = command.branches.iter().flat_map(|b| &b.updates);
        let (clock, _) = updates.find(|(variable, e)| counts(program, *variable, *e))?;
        let at = self.own[command.module].binary_search(clock).ok()?;
        Some((command.module, at))
    }
}
