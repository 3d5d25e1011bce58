//! Selection of expression nodes that are computed once per state, and then read from a register.

use ahash::AHashMap;

use meliora_base::error::Result;
use meliora_base::progress::Poll;
use meliora_model::expr::{ExprId, ExprPool, Node};

/// Minimum number of operators below a node that is shared.
pub(super) const WORTH_SHARING: u32 = 3;

/// Selects the nodes below `roots` with several uses to keep, operands before the nodes that use them.
///
/// # Errors
/// The work is cancelled.
pub(super) fn plan(pool: &ExprPool, roots: &[ExprId], poll: &mut Poll<'_>) -> Result<Vec<ExprId>> {
    let mut uses: AHashMap<ExprId, u32> = AHashMap::new();
    let mut stack = roots.to_vec();
    while let Some(e) = stack.pop() {
        poll.step()?;
        let count = uses.entry(e).or_insert(0);
        *count += 1;
        if *count == 1 {
            stack.extend(pool.operands(e));
        }
    }
    let mut order: Vec<ExprId> = uses.keys().copied().collect();
    order.sort_unstable();
    let mut sizes: AHashMap<ExprId, u32> = AHashMap::new();
    let mut kept = Vec::new();
    for e in order {
        poll.step()?;
        let own = u32::from(!matches!(pool.node(e), Node::Literal(_) | Node::Var(_)));
        let below = pool.operands(e).filter_map(|a| sizes.get(&a).copied());
        let size = below.fold(own, u32::saturating_add);
        let is_kept = size >= WORTH_SHARING && uses[&e] > 1;
        // A kept node costs one instruction per use.
        sizes.insert(e, if is_kept { 1 } else { size });
        kept.extend(is_kept.then_some(e));
    }
    Ok(kept)
}
