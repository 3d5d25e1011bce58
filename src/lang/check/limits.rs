//! Limits on the size of models: a short text with many copies of modules can be a large model.

use super::lowerer::Lowerer;
use crate::ast::Span;

/// Maximum depth of copies of copies; each name is looked up in all renamings of the chain.
pub(super) const MOST_RENAMINGS: usize = 100;
/// Maximum number of modules, including copies.
pub(super) const MOST_MODULES: usize = 10_000;
/// Maximum number of variables, including those of copies.
pub(super) const MOST_VARIABLES: usize = 100_000;
/// Maximum number of commands, including those of copies.
pub(super) const MOST_COMMANDS: usize = 1_000_000;
/// Maximum number of nodes of all expressions; equal ones count once.
const MOST_NODES: usize = 1 << 22;
/// Maximum number of operators and operands read; those of copies, and of formulas under each
/// renaming, are included.
const MOST_WORK: usize = 1 << 27;

impl Lowerer<'_> {
    /// Counts one more part of an expression; fails above the limit.
    pub(crate) fn count_work(&mut self, span: Span) -> Option<()> {
        self.work += 1;
        if self.poll.should_stop() {
            return None;
        }
        if self.work > MOST_WORK {
            self.too_large("operators and operands", MOST_WORK, span);
            return None;
        }
        if self.pool.len() > MOST_NODES {
            self.too_large("different expressions", MOST_NODES, span);
            return None;
        }
        Some(())
    }

    /// Reports a model above a limit, once: every expression that follows fails as well.
    pub(super) fn too_large(&mut self, what: &str, most: usize, span: Span) {
        if !std::mem::replace(&mut self.is_full, true) {
            let message =
                format!("the model is too large: more than {most} {what}, those of copies included");
            self.fail::<()>(span, message);
        }
    }
}
