//! The operations of OxiDD that recursions over diagrams need, for the one type of manager in use.
//!
//! The present and the next copy of bit p lie on the levels 2p and 2p+1.

use std::borrow::Borrow;

use oxidd::bdd::BDDFunction;
use oxidd::util::AllocResult;
use oxidd::{BooleanFunction, Function, HasLevel, InnerNode, LevelNo, Manager, Node};
use oxidd_core::function::EdgeOfFunc;
use oxidd_core::util::{EdgeDropGuard, Ref};
use oxidd_core::{ApplyCache, DiagramRules, HasApplyCache};
use oxidd_rules_bdd::simple::{BDDOp, BDDTerminal};

/// A Boolean function of the bits of the present and the next state.
pub(in crate::symbolic) type Bdd = BDDFunction;
pub(in crate::symbolic) type ManagerOf<'id> = <Bdd as Function>::Manager<'id>;
/// A borrowed diagram.
pub(in crate::symbolic) type Edge<'e, 'id> = Ref<'e, EdgeOfFunc<'id, Bdd>>;
/// An owned reference to a diagram, released when dropped.
pub(in crate::symbolic) type Held<'m, 'id> = EdgeDropGuard<'m, ManagerOf<'id>>;

/// The operation of an entry in the operation cache. OxiDD's own entries have no numbers among
/// their operands. The entries here have one, so that the two kinds are never confused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::symbolic) enum Memo {
    /// One step of a list from a set, within a bound.
    Step,
    /// The states of a bound without a step of a list into a set.
    Spare,
    /// The closure of a set under the steps of a list, within a bound.
    Close,
    /// The attractor of lost states.
    Lose,
}

impl Memo {
    /// Returns the operator of OxiDD that stands for this operation in the cache: any two differing
    /// ones.
    fn operator(self) -> BDDOp {
        match self {
            Memo::Step => BDDOp::And,
            Memo::Spare => BDDOp::Equiv,
            Memo::Close => BDDOp::Or,
            Memo::Lose => BDDOp::Xor,
        }
    }
}

/// The operations that a recursion over diagrams needs.
pub(in crate::symbolic) trait Diagram<'id> {
    /// Returns a diagram as an operand.
    fn edge<'e>(&self, f: &'e Bdd) -> Edge<'e, 'id>;
    /// Returns the level of the root; the largest number for a constant.
    fn level_of(&self, e: Edge<'_, 'id>) -> LevelNo;
    /// Returns the children (set, clear) if the root is on `level`, else the diagram twice.
    fn children<'a>(&'a self, e: Edge<'a, 'id>, level: LevelNo) -> (Edge<'a, 'id>, Edge<'a, 'id>);
    /// Returns the value of a constant; `None` for any other function.
    fn value_of(&self, e: Edge<'_, 'id>) -> Option<bool>;
    fn is_zero(&self, e: Edge<'_, 'id>) -> bool;
    fn constant(&self, value: bool) -> Held<'_, 'id>;
    fn held(&self, e: Edge<'_, 'id>) -> Held<'_, 'id>;
    fn node(&self, level: LevelNo, set: Held<'_, 'id>, clear: Held<'_, 'id>) -> AllocResult<Held<'_, 'id>>;
    /// Returns the cached result of an operation of OxiDD.
    fn recall_operation(&self, operation: BDDOp, operands: &[Edge<'_, 'id>]) -> Option<Held<'_, 'id>>;
    fn remember_operation(&self, operation: BDDOp, operands: &[Edge<'_, 'id>], value: Edge<'_, 'id>);
    fn recall(&self, what: Memo, key: &[Edge<'_, 'id>], number: u32) -> Option<Held<'_, 'id>>;
    fn remember(&self, what: Memo, key: &[Edge<'_, 'id>], number: u32, value: Edge<'_, 'id>);
    /// Returns an owned handle of the diagram.
    fn handle(&self, e: Edge<'_, 'id>) -> Bdd;
}

impl<'id> Diagram<'id> for ManagerOf<'id> {
    #[inline]
    fn edge<'e>(&self, f: &'e Bdd) -> Edge<'e, 'id> {
        f.as_edge(self)
    }

    #[inline]
    fn level_of(&self, e: Edge<'_, 'id>) -> LevelNo {
        match self.get_node(e) {
            Node::Inner(n) => n.level(),
            Node::Terminal(_) => LevelNo::MAX,
        }
    }

    #[inline]
    fn children<'a>(&'a self, e: Edge<'a, 'id>, level: LevelNo) -> (Edge<'a, 'id>, Edge<'a, 'id>) {
        match self.get_node(e) {
            Node::Inner(n) if n.level() == level => (n.child(0), n.child(1)),
            _ => (e, e),
        }
    }

    #[inline]
    fn is_zero(&self, e: Edge<'_, 'id>) -> bool {
        matches!(self.get_node(e), Node::Terminal(t) if *t.borrow() == BDDTerminal::False)
    }

    #[inline]
    fn value_of(&self, e: Edge<'_, 'id>) -> Option<bool> {
        match self.get_node(e) {
            Node::Inner(_) => None,
            Node::Terminal(t) => Some(*t.borrow() == BDDTerminal::True),
        }
    }

    #[inline]
    fn constant(&self, value: bool) -> Held<'_, 'id> {
        EdgeDropGuard::new(self, if value { Bdd::t_edge(self) } else { Bdd::f_edge(self) })
    }

    #[inline]
    fn held(&self, e: Edge<'_, 'id>) -> Held<'_, 'id> {
        EdgeDropGuard::new(self, self.clone_edge(e))
    }

    #[inline]
    fn node(&self, level: LevelNo, set: Held<'_, 'id>, clear: Held<'_, 'id>) -> AllocResult<Held<'_, 'id>> {
        let children = [set.into_edge(), clear.into_edge()];
        let made = <Self as Manager>::Rules::reduce(self, level, children).then_insert(self, level)?;
        Ok(EdgeDropGuard::new(self, made))
    }

    #[inline]
    fn recall_operation(&self, operation: BDDOp, operands: &[Edge<'_, 'id>]) -> Option<Held<'_, 'id>> {
        Some(EdgeDropGuard::new(self, self.apply_cache().get(self, operation, operands)?))
    }

    #[inline]
    fn remember_operation(&self, operation: BDDOp, operands: &[Edge<'_, 'id>], value: Edge<'_, 'id>) {
        self.apply_cache().add(self, operation, operands, value);
    }

    #[inline]
    fn recall(&self, what: Memo, key: &[Edge<'_, 'id>], number: u32) -> Option<Held<'_, 'id>> {
        let found = self.apply_cache().get_extended::<1, 0>(self, what.operator(), (key, &[number]))?;
        let ([found], []) = found;
        Some(EdgeDropGuard::new(self, found))
    }

    #[inline]
    fn remember(&self, what: Memo, key: &[Edge<'_, 'id>], number: u32, value: Edge<'_, 'id>) {
        self.apply_cache().add_extended(self, what.operator(), (key, &[number]), (&[value], &[]));
    }

    fn handle(&self, e: Edge<'_, 'id>) -> Bdd {
        Bdd::from_edge(self, self.clone_edge(e))
    }
}
