//! Selection of expression nodes that are computed once and then looked up.
//!
//! A node over few variables with few valuations becomes a table that is filled on use: models of
//! grids test again and again whether a cell is blocked, by long formulas over two coordinates. A
//! larger node with several uses is computed at most once per state.

use ahash::{AHashMap, AHashSet};

use meliora_base::error::Result;
use meliora_base::progress::Poll;
use meliora_base::value::Type;
use meliora_model::Program;
use meliora_model::expr::{ExprId, ExprPool, Node};

/// Minimum number of operators below a node that is shared.
const WORTH_SHARING: u32 = 3;
/// Maximum number of cells of a table, which then fits the second-level cache.
const MOST_CELLS: u64 = 1 << 14;
/// Maximum number of variables of a table.
const MOST_KEYS: usize = 4;

/// A variable that indexes a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Key {
    pub(super) variable: u32,
    pub(super) low: i64,
    /// The distance in cells between two consecutive values.
    pub(super) stride: u32,
}

impl Key {
    /// Returns the variable's contribution to the cell number.
    #[inline]
    pub(super) fn offset(&self, values: &[i64]) -> usize {
        let above = values[self.variable as usize].wrapping_sub(self.low) as usize;
        above.wrapping_mul(self.stride as usize)
    }
}

/// The way a node's value is kept.
#[derive(Debug, Clone)]
pub(super) enum Keep {
    /// In a register, for the present state.
    Register,
    /// In a table, by the values of some variables.
    Table { keys: Vec<Key>, cells: u32 },
}

/// The properties of a node.
struct Fact {
    uses: u32,
    /// The number of its operators, counted once per occurrence in the tree.
    work: u32,
    /// The variables in it, if they have few valuations.
    support: Option<Vec<u32>>,
}

/// Selects the nodes below `roots` to keep, operands before the nodes that use them.
///
/// # Errors
/// The work is cancelled.
pub(super) fn plan(
    program: &Program,
    pool: &ExprPool,
    roots: &[ExprId],
    poll: &mut Poll<'_>,
) -> Result<Vec<(ExprId, Keep)>> {
    let facts = facts(program, pool, roots, poll)?;
    let mut order: Vec<ExprId> = facts.keys().copied().collect();
    order.sort_unstable();
    let tables = tables(pool, roots, &facts, &order);
    let mut sizes: AHashMap<ExprId, u32> = AHashMap::new();
    let mut kept = Vec::new();
    for e in order {
        poll.step()?;
        let below = operands(pool.node(e)).filter_map(|a| sizes.get(&a).copied());
        let size = below.fold(own_work(pool, e), u32::saturating_add);
        let keep = match tables.contains(&e) {
            true => {
                let (keys, cells) = table(program, facts[&e].support.as_deref().unwrap_or(&[]));
                Some(Keep::Table { keys, cells })
            }
            false => (size >= WORTH_SHARING && facts[&e].uses > 1).then_some(Keep::Register),
        };
        // A kept node costs one instruction per use.
        sizes.insert(e, if keep.is_some() { 1 } else { size });
        kept.extend(keep.map(|keep| (e, keep)));
    }
    Ok(kept)
}

/// Returns the operands of a node, in the order of evaluation.
pub(super) fn operands(node: Node) -> impl Iterator<Item = ExprId> {
    let (a, b, c) = match node {
        Node::Literal(_) | Node::Var(_) => (None, None, None),
        Node::Unary(_, a) => (Some(a), None, None),
        Node::Binary(_, a, b) => (Some(a), Some(b), None),
        Node::Ite(c, a, b) => (Some(c), Some(a), Some(b)),
    };
    [a, b, c].into_iter().flatten()
}

fn own_work(pool: &ExprPool, e: ExprId) -> u32 {
    u32::from(!matches!(pool.node(e), Node::Literal(_) | Node::Var(_)))
}

fn facts(
    program: &Program,
    pool: &ExprPool,
    roots: &[ExprId],
    poll: &mut Poll<'_>,
) -> Result<AHashMap<ExprId, Fact>> {
    let mut uses: AHashMap<ExprId, u32> = AHashMap::new();
    let mut stack = roots.to_vec();
    while let Some(e) = stack.pop() {
        poll.step()?;
        let count = uses.entry(e).or_insert(0);
        *count += 1;
        if *count == 1 {
            stack.extend(operands(pool.node(e)));
        }
    }
    let mut order: Vec<ExprId> = uses.keys().copied().collect();
    order.sort_unstable();
    let mut facts: AHashMap<ExprId, Fact> = AHashMap::new();
    for e in order {
        poll.step()?;
        let (mut work, mut support) = (own_work(pool, e), Some(Vec::new()));
        if let Node::Var(v) = pool.node(e) {
            support = Some(vec![v.0]);
        }
        for fact in operands(pool.node(e)).filter_map(|a| facts.get(&a)) {
            work = work.saturating_add(fact.work);
            support = support.zip(fact.support.as_ref()).map(|(x, y)| merged(x, y));
        }
        let fits = |s: &Vec<u32>| cells(program, s).is_some_and(|n| n <= MOST_CELLS);
        let support = support.filter(|s| s.len() <= MOST_KEYS && fits(s));
        facts.insert(e, Fact { uses: uses[&e], work, support });
    }
    Ok(facts)
}

/// Returns the largest nodes that fit a table and have enough operators to profit from one.
fn tables(
    pool: &ExprPool,
    roots: &[ExprId],
    facts: &AHashMap<ExprId, Fact>,
    order: &[ExprId],
) -> AHashSet<ExprId> {
    // Nodes that occur outside of all tables.
    let mut open: AHashSet<ExprId> = roots.iter().copied().collect();
    let mut found = AHashSet::new();
    for &e in order.iter().rev() {
        if !open.contains(&e) {
            continue;
        }
        let keys = facts[&e].support.as_ref().map(Vec::len).filter(|&n| n > 0);
        let fits = keys.is_some_and(|n| facts[&e].work >= 3 + n as u32);
        if fits && pool.ty(e) != Type::Real {
            found.insert(e);
        } else {
            open.extend(operands(pool.node(e)));
        }
    }
    found
}

/// Returns the union of two sets of variables, sorted.
pub(super) fn merged(mut x: Vec<u32>, y: &[u32]) -> Vec<u32> {
    x.extend(y.iter().filter(|v| !x.contains(v)).copied().collect::<Vec<_>>());
    x.sort_unstable();
    x
}

/// Returns the number of valuations of some variables; `None` if it overflows.
pub(super) fn cells(program: &Program, support: &[u32]) -> Option<u64> {
    let size = |v: &u32| {
        let declared = &program.variables[*v as usize];
        (declared.high.wrapping_sub(declared.low) as u64).checked_add(1)
    };
    support.iter().try_fold(1u64, |n, v| n.checked_mul(size(v)?))
}

/// Returns the keys of a table over some variables and its number of cells. The number must fit 32
/// bits.
pub(super) fn table(program: &Program, support: &[u32]) -> (Vec<Key>, u32) {
    let (mut keys, mut stride) = (Vec::new(), 1u32);
    for &variable in support.iter().rev() {
        let declared = &program.variables[variable as usize];
        keys.push(Key { variable, low: declared.low, stride });
        stride *= declared.high.wrapping_sub(declared.low) as u32 + 1;
    }
    (keys, stride)
}
