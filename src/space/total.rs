//! A sufficient test that every command has a meaning in every valuation where it is enabled.
//!
//! A guided search leaves states out. So it is for programs whose states need not be checked one by one.

use super::bounds::Bounds;
use super::needs::operands;
use super::program::{Chances, Prepared};
use super::values::Values;
use meliora_base::value::Binary;
use meliora_model::predicate::Predicate;
use meliora_model::{Command, Program};

/// Returns whether guards, updates and the target have a value in every state, and probabilities are constant.
pub fn is_total(program: &Program, prepared: &Prepared, target: &Predicate) -> bool {
    let mut bounds = Bounds::new(program, target.pool());
    let target_is_total = bounds.is_total(target.id());
    let mut has_meaning =
        |command: &Command| bounds.is_total(command.guard) && updates(program, &mut bounds, command);
    prepared.commands.iter().all(|command| command.chances == Chances::Sound)
        && target_is_total
        && !prepared.initial_is_partial
        && program.commands.iter().all(&mut has_meaning)
}

/// Returns whether all new values of a command are in the ranges of their variables where its guard is true.
fn updates(program: &Program, bounds: &mut Bounds<'_>, command: &Command) -> bool {
    let mut narrow = None;
    command.branches.iter().flat_map(|branch| &branch.updates).all(|&(variable, new)| {
        let declared = &program.variables[variable.index()];
        let is_inside = |found: Values| {
            let (low, high) = found.range();
            !found.fails && low >= declared.low && high <= declared.high
        };
        is_inside(bounds.of(new)) || {
            let guard = || operands(&program.pool, Binary::And, command.guard);
            let narrow = narrow.get_or_insert_with(|| Bounds::under(program, &program.pool, &guard()));
            is_inside(narrow.of(new))
        }
    })
}
