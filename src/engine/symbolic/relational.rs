//! Image and pre-image in one recursion: conjunction, quantification and renaming fused.
//!
//! The present and the next copy of bit p lie on the levels 2p and 2p+1. A relation is *local*: it
//! says what happens to the bits it touches; the others keep their value and have no next copy in
//! it. The results are kept in the manager's own operation cache, under operators and key shapes
//! (one or two edges and a number, three edges) that no operation in use of OxiDD has, so that the
//! collection of garbage clears them as it must.

use std::borrow::Borrow;
use std::sync::atomic::{AtomicU32, Ordering};

use ahash::AHashSet;
use oxidd::bdd::BDDManagerRef;
use oxidd::util::AllocResult;
use oxidd::{BooleanFunction, Function, HasLevel, InnerNode, LevelNo, Manager, ManagerRef, Node};
use oxidd_core::function::{EdgeOfFunc, OwnEdgeOfFunc};
use oxidd_core::util::{EdgeDropGuard, Own, Ref};
use oxidd_core::{ApplyCache, DiagramRules, HasApplyCache};
use oxidd_rules_bdd::simple::{BDDOp, BDDTerminal};

use super::store::Bdd;

/// Which bits a relation touches.
#[derive(Debug, Clone)]
pub(super) struct Touched {
    bits: Vec<bool>,
    /// One past the last touched bit.
    end: u32,
    /// Distinguishes this set in the operation cache; equal sets may have several numbers.
    id: u32,
}

impl Touched {
    /// The set of the given bits of `width` many.
    pub(super) fn new(width: usize, bits: impl IntoIterator<Item = u32>) -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let mut flags = vec![false; width];
        let mut end = 0;
        for bit in bits {
            flags[bit as usize] = true;
            end = end.max(bit + 1);
        }
        Touched { bits: flags, end, id: NEXT.fetch_add(1, Ordering::Relaxed) }
    }

    /// The number in the operation cache.
    pub(super) fn id(&self) -> u32 {
        self.id
    }

    /// Whether `bit` is touched.
    pub(super) fn contains(&self, bit: u32) -> bool {
        self.bits[bit as usize]
    }

    /// The touched bits in the order of their levels.
    pub(super) fn iter(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.end).filter(|&b| self.contains(b))
    }

    /// The first touched bit; `None` where nothing is touched.
    pub(super) fn top(&self) -> Option<u32> {
        self.iter().next()
    }

    /// How many bits are touched.
    pub(super) fn len(&self) -> usize {
        self.iter().count()
    }
}

/// ∃ x' . R(x, x') ∧ X(x')
pub(super) fn pre(manager: &BDDManagerRef, r: &Bdd, touched: &Touched, x: &Bdd) -> AllocResult<Bdd> {
    manager.with_manager_shared(|m| {
        let edge = product::<_, false>(m, r.as_edge(m), x.as_edge(m), touched)?;
        Ok(Bdd::from_edge(m, edge))
    })
}

/// B(x) ∧ ∃ x' . R(x, x') ∧ X(x')
///
/// No step of the recursion leaves B, so that states outside of it, which are often many and without
/// a pattern, are never built. The operator must be that of the touched set.
pub(super) fn pre_within(
    manager: &BDDManagerRef,
    (r, touched, operator): (&Bdd, &Touched, Operator),
    x: &Bdd,
    bound: &Bdd,
) -> AllocResult<Bdd> {
    manager.with_manager_shared(|m| {
        let edge = bounded(m, (touched, operator.0), r.as_edge(m), x.as_edge(m), bound.as_edge(m))?;
        Ok(Bdd::from_edge(m, edge))
    })
}

/// An operator of the operation cache under which OxiDD keeps no three edges (all but `Ite`, and those
/// for quantified operations, which nothing here uses).
///
/// An entry has room for four words: with three edges and a result there is none for the number of a
/// touched set, so each set has an operator of its own while there are any.
#[derive(Clone, Copy)]
pub(super) struct Operator(BDDOp);

impl Operator {
    /// The operator with this number; there are few.
    pub(super) fn nth(index: usize) -> Option<Self> {
        use BDDOp::*;
        const ALL: [BDDOp; 32] = [
            And,
            Or,
            Nand,
            Nor,
            Xor,
            Equiv,
            Imp,
            ImpStrict,
            ForallAnd,
            ForallOr,
            ForallNand,
            ForallNor,
            ForallXor,
            ForallEquiv,
            ForallImp,
            ForallImpStrict,
            ExistsAnd,
            ExistsOr,
            ExistsNand,
            ExistsNor,
            ExistsXor,
            ExistsEquiv,
            ExistsImp,
            ExistsImpStrict,
            UniqueAnd,
            UniqueOr,
            UniqueNand,
            UniqueNor,
            UniqueXor,
            UniqueEquiv,
            UniqueImp,
            UniqueImpStrict,
        ];
        ALL.get(index).copied().map(Operator)
    }
}

/// ∃ x . R(x, x') ∧ X(x), over x
pub(super) fn image(manager: &BDDManagerRef, r: &Bdd, touched: &Touched, x: &Bdd) -> AllocResult<Bdd> {
    manager.with_manager_shared(|m| {
        let edge = product::<_, true>(m, r.as_edge(m), x.as_edge(m), touched)?;
        Ok(Bdd::from_edge(m, edge))
    })
}

/// X with the touched bits read in their next copy.
pub(super) fn primed(manager: &BDDManagerRef, touched: &Touched, x: &Bdd) -> AllocResult<Bdd> {
    manager.with_manager_shared(|m| Ok(Bdd::from_edge(m, prime(m, x.as_edge(m), touched)?)))
}

/// The first bit that f depends on; `u32::MAX` for a constant.
pub(super) fn top(manager: &BDDManagerRef, f: &Bdd) -> u32 {
    manager.with_manager_shared(|m| m.level_of(f.as_edge(m)) / 2)
}

/// Whether f has at least so many nodes, constants among them; looks at no more of them.
pub(super) fn has_nodes(manager: &BDDManagerRef, f: &Bdd, many: usize) -> bool {
    manager.with_manager_shared(|m| {
        let (mut seen, mut stack) = (AHashSet::new(), vec![f.as_edge(m)]);
        while let Some(e) = stack.pop() {
            if seen.len() >= many {
                break;
            }
            if let (true, Node::Inner(n)) = (seen.insert(e.node_id()), m.get_node(e)) {
                stack.extend([n.child(0), n.child(1)]);
            }
        }
        seen.len() >= many
    })
}

/// f with `bit` set, and f with `bit` clear, where no earlier bit matters to f.
pub(super) fn split(manager: &BDDManagerRef, f: &Bdd, bit: u32) -> (Bdd, Bdd) {
    manager.with_manager_shared(|m| {
        let (t, e) = m.children(f.as_edge(m), 2 * bit);
        (Bdd::from_edge(m, m.clone_edge(t)), Bdd::from_edge(m, m.clone_edge(e)))
    })
}

/// if `bit` then t else e, where t and e depend on later bits only.
pub(super) fn node(manager: &BDDManagerRef, bit: u32, t: &Bdd, e: &Bdd) -> AllocResult<Bdd> {
    manager.with_manager_shared(|m| {
        let (t, e) = (m.clone_edge(t.as_edge(m)), m.clone_edge(e.as_edge(m)));
        Ok(Bdd::from_edge(m, m.make(2 * bit, t, e)?))
    })
}

/// What was remembered for two functions under a number.
pub(super) fn recall(manager: &BDDManagerRef, f: &Bdd, g: &Bdd, number: u32) -> Option<Bdd> {
    manager.with_manager_shared(|m| {
        let found = m.look_up(BDDOp::UniqueOr, &[f.as_edge(m), g.as_edge(m)], &[number])?;
        Some(Bdd::from_edge(m, found))
    })
}

/// Remembers a result for two functions under a number, until garbage is collected or the cache
/// needs the place.
pub(super) fn remember(manager: &BDDManagerRef, f: &Bdd, g: &Bdd, number: u32, result: &Bdd) {
    manager.with_manager_shared(|m| {
        m.remember(BDDOp::UniqueOr, &[f.as_edge(m), g.as_edge(m)], &[number], result.as_edge(m));
    });
}

type ManagerOf<'id> = <Bdd as Function>::Manager<'id>;
type EdgeIn<'id> = EdgeOfFunc<'id, Bdd>;
type OwnEdgeIn<'id> = OwnEdgeOfFunc<'id, Bdd>;

/// The operations that a recursion over two diagrams needs, for the one manager type in use.
trait Diagram: Manager {
    fn level_of(&self, e: Ref<'_, Self::Edge>) -> LevelNo;
    fn children<'a>(
        &'a self,
        e: Ref<'a, Self::Edge>,
        level: LevelNo,
    ) -> (Ref<'a, Self::Edge>, Ref<'a, Self::Edge>);
    fn is(&self, e: Ref<'_, Self::Edge>, value: BDDTerminal) -> bool;
    fn make(&self, level: LevelNo, t: Own<Self::Edge>, e: Own<Self::Edge>) -> AllocResult<Own<Self::Edge>>;
    fn conjunction(&self, f: Ref<'_, Self::Edge>, g: Ref<'_, Self::Edge>) -> AllocResult<Own<Self::Edge>>;
    fn disjunction(&self, f: Ref<'_, Self::Edge>, g: Ref<'_, Self::Edge>) -> AllocResult<Own<Self::Edge>>;
    fn look_up(&self, op: BDDOp, key: &[Ref<'_, Self::Edge>], id: &[u32]) -> Option<Own<Self::Edge>>;
    fn remember(&self, op: BDDOp, key: &[Ref<'_, Self::Edge>], id: &[u32], value: Ref<'_, Self::Edge>);
    fn constant(&self, value: BDDTerminal) -> AllocResult<Own<Self::Edge>>;
}

impl<'id> Diagram for ManagerOf<'id> {
    #[inline]
    fn level_of(&self, e: Ref<'_, EdgeIn<'id>>) -> LevelNo {
        match self.get_node(e) {
            Node::Inner(n) => n.level(),
            Node::Terminal(_) => LevelNo::MAX,
        }
    }

    #[inline]
    fn children<'a>(
        &'a self,
        e: Ref<'a, EdgeIn<'id>>,
        level: LevelNo,
    ) -> (Ref<'a, EdgeIn<'id>>, Ref<'a, EdgeIn<'id>>) {
        match self.get_node(e) {
            Node::Inner(n) if n.level() == level => (n.child(0), n.child(1)),
            _ => (e, e),
        }
    }

    #[inline]
    fn is(&self, e: Ref<'_, EdgeIn<'id>>, value: BDDTerminal) -> bool {
        matches!(self.get_node(e), Node::Terminal(t) if *t.borrow() == value)
    }

    #[inline]
    fn make(&self, level: LevelNo, t: OwnEdgeIn<'id>, e: OwnEdgeIn<'id>) -> AllocResult<OwnEdgeIn<'id>> {
        <Self as Manager>::Rules::reduce(self, level, [t, e]).then_insert(self, level)
    }

    fn conjunction(&self, f: Ref<'_, EdgeIn<'id>>, g: Ref<'_, EdgeIn<'id>>) -> AllocResult<OwnEdgeIn<'id>> {
        Bdd::and_edge(self, f, g)
    }

    fn disjunction(&self, f: Ref<'_, EdgeIn<'id>>, g: Ref<'_, EdgeIn<'id>>) -> AllocResult<OwnEdgeIn<'id>> {
        Bdd::or_edge(self, f, g)
    }

    #[inline]
    fn look_up(&self, op: BDDOp, key: &[Ref<'_, EdgeIn<'id>>], id: &[u32]) -> Option<OwnEdgeIn<'id>> {
        let ([found], []) = self.apply_cache().get_extended::<1, 0>(self, op, (key, id))?;
        Some(found)
    }

    #[inline]
    fn remember(&self, op: BDDOp, key: &[Ref<'_, EdgeIn<'id>>], id: &[u32], value: Ref<'_, EdgeIn<'id>>) {
        self.apply_cache().add_extended(self, op, (key, id), (&[value], &[]));
    }

    fn constant(&self, value: BDDTerminal) -> AllocResult<OwnEdgeIn<'id>> {
        self.get_terminal(value)
    }
}

/// The relational product; `FORWARD` tells image from pre-image.
fn product<M: Diagram, const FORWARD: bool>(
    m: &M,
    r: Ref<'_, M::Edge>,
    x: Ref<'_, M::Edge>,
    touched: &Touched,
) -> AllocResult<Own<M::Edge>> {
    if m.is(r, BDDTerminal::False) || m.is(x, BDDTerminal::False) {
        return m.constant(BDDTerminal::False);
    }
    let bit = m.level_of(r).min(m.level_of(x)) / 2;
    if bit >= touched.end {
        return m.conjunction(r, x);
    }
    let op = if FORWARD { BDDOp::UniqueAnd } else { BDDOp::ExistsAnd };
    if let Some(found) = m.look_up(op, &[r, x], &[touched.id]) {
        return Ok(found);
    }
    let (rt, re) = m.children(r, 2 * bit);
    let (xt, xe) = m.children(x, 2 * bit);
    let (t, e) = if touched.contains(bit) {
        let (rtt, rte) = m.children(rt, 2 * bit + 1);
        let (ret, ree) = m.children(re, 2 * bit + 1);
        if FORWARD {
            let t = either::<M, FORWARD>(m, (rtt, xt), (ret, xe), touched)?;
            (t, either::<M, FORWARD>(m, (rte, xt), (ree, xe), touched)?)
        } else {
            let t = either::<M, FORWARD>(m, (rtt, xt), (rte, xe), touched)?;
            (t, either::<M, FORWARD>(m, (ret, xt), (ree, xe), touched)?)
        }
    } else {
        let t = EdgeDropGuard::new(m, product::<M, FORWARD>(m, rt, xt, touched)?);
        (t, EdgeDropGuard::new(m, product::<M, FORWARD>(m, re, xe, touched)?))
    };
    let result = m.make(2 * bit, t.into_edge(), e.into_edge())?;
    m.remember(op, &[r, x], &[touched.id], result.borrowed());
    Ok(result)
}

/// The disjunction of two relational products.
fn either<'m, M: Diagram, const FORWARD: bool>(
    m: &'m M,
    (r, x): (Ref<'_, M::Edge>, Ref<'_, M::Edge>),
    (s, y): (Ref<'_, M::Edge>, Ref<'_, M::Edge>),
    touched: &Touched,
) -> AllocResult<EdgeDropGuard<'m, M>> {
    let f = EdgeDropGuard::new(m, product::<M, FORWARD>(m, r, x, touched)?);
    if m.is(f.borrowed(), BDDTerminal::True) || (r == s && x == y) {
        return Ok(f);
    }
    let g = EdgeDropGuard::new(m, product::<M, FORWARD>(m, s, y, touched)?);
    Ok(EdgeDropGuard::new(m, m.disjunction(f.borrowed(), g.borrowed())?))
}

/// The pre-image within b.
fn bounded<M: Diagram>(
    m: &M,
    of: (&Touched, BDDOp),
    r: Ref<'_, M::Edge>,
    x: Ref<'_, M::Edge>,
    b: Ref<'_, M::Edge>,
) -> AllocResult<Own<M::Edge>> {
    if [r, x, b].into_iter().any(|f| m.is(f, BDDTerminal::False)) {
        return m.constant(BDDTerminal::False);
    }
    let (touched, op) = of;
    if m.is(b, BDDTerminal::True) {
        return product::<M, false>(m, r, x, touched);
    }
    let bit = m.level_of(r).min(m.level_of(x)).min(m.level_of(b)) / 2;
    if bit >= touched.end {
        let inside = EdgeDropGuard::new(m, m.conjunction(x, b)?);
        return m.conjunction(r, inside.borrowed());
    }
    if let Some(found) = m.look_up(op, &[r, x, b], &[]) {
        return Ok(found);
    }
    let (rt, re) = m.children(r, 2 * bit);
    let (xt, xe) = m.children(x, 2 * bit);
    let (bt, be) = m.children(b, 2 * bit);
    let (t, e) = if touched.contains(bit) {
        let (rtt, rte) = m.children(rt, 2 * bit + 1);
        let (ret, ree) = m.children(re, 2 * bit + 1);
        let t = either_bounded(m, of, (rtt, xt), (rte, xe), bt)?;
        (t, either_bounded(m, of, (ret, xt), (ree, xe), be)?)
    } else {
        let t = EdgeDropGuard::new(m, bounded(m, of, rt, xt, bt)?);
        (t, EdgeDropGuard::new(m, bounded(m, of, re, xe, be)?))
    };
    let result = m.make(2 * bit, t.into_edge(), e.into_edge())?;
    m.remember(op, &[r, x, b], &[], result.borrowed());
    Ok(result)
}

/// The disjunction of two pre-images within b.
fn either_bounded<'m, M: Diagram>(
    m: &'m M,
    of: (&Touched, BDDOp),
    (r, x): (Ref<'_, M::Edge>, Ref<'_, M::Edge>),
    (s, y): (Ref<'_, M::Edge>, Ref<'_, M::Edge>),
    b: Ref<'_, M::Edge>,
) -> AllocResult<EdgeDropGuard<'m, M>> {
    let f = EdgeDropGuard::new(m, bounded(m, of, r, x, b)?);
    if f.borrowed() == b || (r == s && x == y) {
        return Ok(f);
    }
    let g = EdgeDropGuard::new(m, bounded(m, of, s, y, b)?);
    Ok(EdgeDropGuard::new(m, m.disjunction(f.borrowed(), g.borrowed())?))
}

/// Moves the nodes of touched bits one level down.
fn prime<M: Diagram>(m: &M, x: Ref<'_, M::Edge>, touched: &Touched) -> AllocResult<Own<M::Edge>> {
    let level = m.level_of(x);
    if level / 2 >= touched.end {
        return Ok(m.clone_edge(x));
    }
    if let Some(found) = m.look_up(BDDOp::UniqueNand, &[x], &[touched.id]) {
        return Ok(found);
    }
    let (t, e) = m.children(x, level);
    let t = EdgeDropGuard::new(m, prime(m, t, touched)?);
    let e = EdgeDropGuard::new(m, prime(m, e, touched)?);
    let to = level + u32::from(touched.contains(level / 2));
    let result = m.make(to, t.into_edge(), e.into_edge())?;
    m.remember(BDDOp::UniqueNand, &[x], &[touched.id], result.borrowed());
    Ok(result)
}
