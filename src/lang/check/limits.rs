//! Sizes up to which models are taken: copies of modules make much of little text.

use super::collect::{Instance, Parts};
use super::lower::Lowerer;
use crate::lang::ast::Span;

/// Copies of copies: each name is looked up in as many renamings.
pub(super) const MOST_RENAMINGS: usize = 100;
/// Modules, copies among them.
const MOST_MODULES: usize = 10_000;
/// Variables, those of copies among them.
const MOST_VARIABLES: usize = 100_000;
/// Commands, those of copies among them.
const MOST_COMMANDS: usize = 1_000_000;
/// Nodes of all expressions, equal ones counted once.
const MOST_NODES: usize = 1 << 22;
/// Operators and operands read, those of copies and of formulas under each renaming among them.
const MOST_WORK: usize = 1 << 27;
/// Objectives of a preference file.
pub(super) const MOST_OBJECTIVES: usize = 1_000;
/// Pairs of objectives that the statements of a preference file speak of.
pub(super) const MOST_PAIRS: usize = 1_000_000;
/// After this many errors the rest is not reported.
pub(in crate::lang) const MAX_ERRORS: usize = 20;

impl<'a> Lowerer<'a> {
    /// Counts one more part of an expression; fails where that is too many.
    pub(in crate::lang) fn count_work(&mut self, span: Span) -> Option<()> {
        self.work += 1;
        if self.poll.is_over() {
            return None;
        }
        let (what, most) = match () {
            () if self.work > MOST_WORK => ("operators and operands", MOST_WORK),
            () if self.pool.len() > MOST_NODES => ("different expressions", MOST_NODES),
            () => return Some(()),
        };
        // Told once: every expression that follows fails as well.
        if !self.is_full {
            self.is_full = true;
            let message =
                format!("the model is too large: more than {most} {what}, those of copies included");
            self.fail::<()>(span, message);
        }
        None
    }

    /// Whether the modules up to and with this one are not too many or too large.
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
