//! Operations on constants that have no value, such as an overflow: an error if they may be
//! evaluated.
//!
//! `N=0 ? 0 : mod(x,N)` is valid for every N. The pool removes parts that are never evaluated, and
//! only the rest of an expression is searched.

use super::lowerer::{Lowered, Lowerer};
use crate::ast::Span;
use meliora_base::value::Type;
use meliora_model::expr::ExprId;

impl Lowerer<'_> {
    /// Checks the type of a whole expression, converts an integer if a real is wanted, and reports
    /// a part without a value.
    pub(crate) fn finished(&mut self, (id, span): Lowered, ty: Type, what: &str) -> Option<ExprId> {
        let id = self.expect_type(id?, ty, span, what)?;
        self.whole(id, span)
    }

    /// Accepts a whole expression, unless a part that may be evaluated has no value in any state.
    pub(crate) fn whole(&mut self, root: ExprId, span: Span) -> Option<ExprId> {
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

    /// Returns the first part, in the order of evaluation, that has no value. Parts without faults
    /// are not searched again, since expressions share them.
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
