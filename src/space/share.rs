//! Selection of expression nodes that are computed once per state, and then read from a register.

use ahash::{AHashMap, AHashSet};
use smallvec::SmallVec;

use meliora_base::error::Result;
use meliora_base::progress::Poll;
use meliora_base::value::Type;
use meliora_model::expr::{ExprId, ExprPool, Node};
use meliora_model::{Program, VarId};

/// Minimum number of operators below a node that is shared.
pub(crate) const WORTH_SHARING: u32 = 3;

/// Maximum number of results of conditions that are kept for all states, a byte each: 16 MiB.
const MOST_RESULTS: u64 = 1 << 24;

/// A node whose value is kept in a register.
pub(crate) struct Kept {
    pub(crate) node: ExprId,
    /// The variables of a condition whose results are kept for all states; else `None`: the value is kept for one
    /// state.
    pub(crate) memo: Option<Support>,
}

/// The variables of a node, with the number of their valuations.
pub(crate) struct Support {
    pub(crate) variables: SmallVec<[VarId; 4]>,
    valuations: u64,
}

impl Support {
    /// Returns the variables of a node, given those of its operands; `None` if they have too many valuations.
    fn of(
        program: &Program,
        pool: &ExprPool,
        e: ExprId,
        known: &AHashMap<ExprId, Support>,
    ) -> Option<Support> {
        let mut variables = SmallVec::new();
        if let Node::Var(v) = pool.node(e) {
            variables.push(v);
        }
        for operand in pool.operands(e) {
            variables.extend_from_slice(&known.get(&operand)?.variables);
        }
        variables.sort_unstable();
        variables.dedup();
        let count = |v: &VarId| {
            let declared = program.variables.get(v.index())?;
            declared.high.abs_diff(declared.low).checked_add(1)
        };
        let valuations = variables.iter().try_fold(1u64, |all, v| all.checked_mul(count(v)?))?;
        (valuations <= MOST_RESULTS).then_some(Support { variables, valuations })
    }
}

/// Selects the nodes below `roots` to keep, operands before the nodes that use them: those with several uses, and
/// conditions over few values.
///
/// # Errors
/// The work is cancelled.
pub(crate) fn plan(
    program: &Program,
    pool: &ExprPool,
    roots: &[ExprId],
    poll: &mut Poll<'_>,
) -> Result<Vec<Kept>> {
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
    let mut memos = conditions(program, pool, (roots, &order), poll)?;
    let mut sizes: AHashMap<ExprId, u32> = AHashMap::new();
    let mut kept = Vec::new();
    for e in order {
        poll.step()?;
        let size = size(pool, e, &sizes);
        let memo = memos.remove(&e);
        let is_kept = memo.is_some() || size >= WORTH_SHARING && uses[&e] > 1;
        // A kept node costs one instruction per use.
        sizes.insert(e, if is_kept { 1 } else { size });
        kept.extend(is_kept.then_some(Kept { node: e, memo }));
    }
    Ok(kept)
}

/// Returns the number of operators of a node, given that of its operands.
fn size(pool: &ExprPool, e: ExprId, sizes: &AHashMap<ExprId, u32>) -> u32 {
    let own = u32::from(!matches!(pool.node(e), Node::Literal(_) | Node::Var(_)));
    let below = pool.operands(e).filter_map(|a| sizes.get(&a).copied());
    below.fold(own, u32::saturating_add)
}

/// Selects the largest conditions among the nodes below `roots`, which are in order, that have many operators over few
/// valuations: a result of each costs a byte, so at most the square of their number.
fn conditions(
    program: &Program,
    pool: &ExprPool,
    (roots, order): (&[ExprId], &[ExprId]),
    poll: &mut Poll<'_>,
) -> Result<AHashMap<ExprId, Support>> {
    let (mut sizes, mut supports) = (AHashMap::new(), AHashMap::new());
    for &e in order {
        poll.step()?;
        sizes.insert(e, size(pool, e, &sizes));
        let support = Support::of(program, pool, e, &supports);
        supports.extend(support.map(|support| (e, support)));
    }
    // The nodes that are used by others than parts of the conditions.
    let mut open: AHashSet<ExprId> = roots.iter().copied().collect();
    let (mut found, mut left) = (AHashMap::new(), MOST_RESULTS);
    for &e in order.iter().rev() {
        if !open.contains(&e) {
            continue;
        }
        let size = sizes[&e];
        let is_long = pool.ty(e) == Type::Bool && size > 4 * WORTH_SHARING;
        let is_worth = |support: &Support| is_long && support.valuations <= u64::from(size).pow(2).min(left);
        match supports.remove(&e).filter(is_worth) {
            Some(support) => {
                left -= support.valuations;
                found.insert(e, support);
            }
            None => open.extend(pool.operands(e)),
        }
    }
    Ok(found)
}
