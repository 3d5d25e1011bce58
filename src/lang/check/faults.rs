//! Operations on constants that have no value, such as an overflow: wrong where they are evaluated.
//!
//! `N=0 ? 0 : mod(x,N)` is fine for every N: the pool folds what is never evaluated away, and only
//! what is left of an expression is looked through.

use super::lower::Lowerer;
use crate::lang::ast::Span;
use crate::model::expr::ExprId;

impl Lowerer<'_> {
    /// A whole expression, unless some part of it that may be evaluated has no value in any state.
    pub(in crate::lang) fn whole(&mut self, root: ExprId, span: Span) -> Option<ExprId> {
        match self.first_fault(root) {
            None => Some(root),
            Some(fault) => {
                let place = self.faults.get(&fault).copied().unwrap_or(span);
                let reason = self.pool.fault(fault).map(|e| e.to_string()).unwrap_or_default();
                let diagnostic = self.wrong(place, "this expression has no value");
                self.report(diagnostic.label(reason));
                None
            }
        }
    }

    /// The first part in the order of evaluation that has no value. What has been looked through in
    /// vain is not looked at again: expressions share their parts.
    fn first_fault(&mut self, root: ExprId) -> Option<ExprId> {
        if self.faults.is_empty() {
            return None;
        }
        let mut stack = vec![root];
        while let Some(e) = stack.pop() {
            if self.pool.fault(e).is_some() {
                self.sound.clear();
                return Some(e);
            }
            if self.sound.insert(e) {
                let from = stack.len();
                stack.extend(self.pool.needed(e));
                stack[from..].reverse();
            }
        }
        None
    }
}
