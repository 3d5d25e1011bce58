//! Limits on the size of models: a short text with many copies of modules can be a large model.

use super::collect::{Instance, Parts};
use super::lower::Lowerer;
use crate::lang::ast::Span;

/// Maximum depth of copies of copies; each name is looked up in all renamings of the chain.
pub(super) const MOST_RENAMINGS: usize = 100;
/// Maximum number of modules, including copies.
const MOST_MODULES: usize = 10_000;
/// Maximum number of variables, including those of copies.
const MOST_VARIABLES: usize = 100_000;
/// Maximum number of commands, including those of copies.
const MOST_COMMANDS: usize = 1_000_000;
/// Maximum number of nodes of all expressions; equal ones count once.
const MOST_NODES: usize = 1 << 22;
/// Maximum number of operators and operands read; those of copies, and of formulas under each
/// renaming, are included.
const MOST_WORK: usize = 1 << 27;
/// Maximum number of objectives of a preference file.
pub(super) const MOST_OBJECTIVES: usize = 1_000;
/// Maximum number of pairs of objectives that the statements of a preference file relate.
pub(super) const MOST_PAIRS: usize = 1_000_000;
/// Maximum number of errors reported.
pub(in crate::lang) const MAX_ERRORS: usize = 20;

impl<'a> Lowerer<'a> {
    /// Counts one more part of an expression; fails above the limit.
    pub(in crate::lang) fn count_work(&mut self, span: Span) -> Option<()> {
        self.work += 1;
        if self.poll.should_stop() {
            return None;
        }
        let (what, most) = match () {
            () if self.work > MOST_WORK => ("operators and operands", MOST_WORK),
            () if self.pool.len() > MOST_NODES => ("different expressions", MOST_NODES),
            () => return Some(()),
        };
        // Reported once: every expression that follows fails as well.
        if !self.is_full {
            self.is_full = true;
            let message =
                format!("the model is too large: more than {most} {what}, those of copies included");
            self.fail::<()>(span, message);
        }
        None
    }

    /// Returns true if the modules so far, including this one, are within the limits.
    pub(super) fn fits(&mut self, parts: &Parts<'a>, instance: &Instance<'a>) -> bool {
        let commands = parts.commands + instance.module.commands.len();
        let variables = parts.variables.len() + instance.module.variables.len();
        let (what, most) = match () {
            () if parts.modules.len() >= MOST_MODULES => ("modules", MOST_MODULES),
            () if variables > MOST_VARIABLES => ("variables", MOST_VARIABLES),
            () if commands > MOST_COMMANDS => ("commands", MOST_COMMANDS),
            () => return true,
        };
        if !self.is_full {
            self.is_full = true;
            let message =
                format!("the model is too large: more than {most} {what}, those of copies included");
            self.fail::<()>(instance.name.span, message);
        }
        false
    }
}
