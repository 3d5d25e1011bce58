//! Recursion over sets and relations at once: its limits, and one step.

use std::cell::Cell;

use ahash::AHashMap;
use oxidd::{Function, NodeID};

use super::charge::{BYTES_OF_TABLE, Charge};
use super::diagram::{Bdd, Diagram, Edge, Held, ManagerOf, Memo};
use super::relation_lists::{Cofactors, RelationList};
use super::store::Store;
use super::support::Support;
use meliora_model::error::{Error, Result};

/// The direction in which a relation is applied.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Direction {
    /// From sources to successors.
    Forward,
    /// From successors to sources.
    Backward,
}

/// The reason why a recursion ended early.
#[derive(Debug)]
pub(super) enum Halt {
    /// An error: a limit of the run. Boxed, so that results fit into registers.
    Failed(Box<Error>),
    /// The recursion took more steps than allowed.
    Spent,
}

impl From<Error> for Halt {
    fn from(error: Error) -> Self {
        Halt::Failed(Box::new(error))
    }
}

/// One recursion over diagrams of a store.
pub(super) struct Walk<'m, 'id: 'm> {
    pub(super) store: &'m Store,
    pub(super) m: &'m ManagerOf<'id>,
    pub(super) direction: Direction,
    /// The name of the phase for progress reports; `None` for short recursions.
    phase: Option<&'static str>,
    /// The number of steps left.
    left: Cell<u64>,
}

/// A diagram with its children (set, clear) by the level of an operation.
pub(super) type WithChildren<'e, 'id> = (Edge<'e, 'id>, (Edge<'e, 'id>, Edge<'e, 'id>));

/// Maximum number of steps between two checks of the limits.
pub(super) const PATIENCE: u64 = 1 << 10;

impl<'m, 'id: 'm> Walk<'m, 'id> {
    /// Runs a recursion that may take `steps` steps. Returns its result and the steps that it took.
    pub(super) fn run<T>(
        (store, m): (&'m Store, &'m ManagerOf<'id>),
        (direction, phase): (Direction, Option<&'static str>),
        steps: u64,
        recursion: impl FnOnce(&Self) -> T,
    ) -> (T, u64) {
        let walk = Walk { store, m, direction, phase, left: Cell::new(steps) };
        let result = recursion(&walk);
        (result, steps - walk.left.get())
    }

    /// Counts a step: a result that was not in the cache, or a node made for no such result. Checks
    /// the limits once in [`PATIENCE`] steps.
    #[inline]
    pub(super) fn tick(&self) -> Result<(), Halt> {
        let left = self.left.get();
        if left.is_multiple_of(PATIENCE) {
            return self.check(left);
        }
        self.left.set(left - 1);
        Ok(())
    }

    #[cold]
    fn check(&self, left: u64) -> Result<(), Halt> {
        self.left.set(left.checked_sub(1).ok_or(Halt::Spent)?);
        self.store.check_limits(self.m)?;
        self.phase.inspect(|phase| self.store.progress(phase));
        Ok(())
    }

    pub(super) fn zero(&self) -> Held<'m, 'id> {
        self.m.constant(false)
    }

    /// Computes: if `bit` then `set` else `clear`.
    pub(super) fn node(
        &self,
        bit: u32,
        set: Held<'m, 'id>,
        clear: Held<'m, 'id>,
    ) -> Result<Held<'m, 'id>, Halt> {
        self.node_on(2 * bit, set, clear)
    }

    /// Computes: if the variable on `level` then `set` else `clear`.
    #[inline]
    pub(super) fn node_on(
        &self,
        level: u32,
        set: Held<'m, 'id>,
        clear: Held<'m, 'id>,
    ) -> Result<Held<'m, 'id>, Halt> {
        self.m.node(level, set, clear).map_err(|_| self.full())
    }

    /// Computes [`Walk::node_on`] for children that are often those of an operand.
    ///
    /// An operand with these children is the result. It is returned without a lookup in the node
    /// table; such lookups take a large part of the time of most operations.
    #[inline]
    pub(super) fn node_among<const N: usize>(
        &self,
        level: u32,
        set: Held<'m, 'id>,
        clear: Held<'m, 'id>,
        operands: [WithChildren<'_, 'id>; N],
    ) -> Result<Held<'m, 'id>, Halt> {
        for (f, (f1, f0)) in operands {
            if set.borrowed() == f1 && clear.borrowed() == f0 {
                return Ok(self.m.held(f));
            }
        }
        self.node_on(level, set, clear)
    }

    #[cold]
    fn full(&self) -> Halt {
        self.store.full().into()
    }

    /// Runs an operation and returns its result as an owned handle.
    pub(super) fn own(
        &self,
        operation: impl FnOnce(&Self) -> Result<Held<'m, 'id>, Halt>,
    ) -> Result<Bdd, Halt> {
        Ok(self.m.handle(operation(self)?.borrowed()))
    }

    /// Returns the cofactors of a list by its first bit.
    pub(super) fn cofactors<'l>(&self, list: &'l RelationList) -> Result<&'l Cofactors, Halt> {
        Ok(self.store.lists.cofactors(self.store, list)?)
    }

    /// Returns the first bit that a diagram depends on.
    pub(super) fn top(&self, f: Edge<'_, 'id>) -> u32 {
        self.m.level_of(f) / 2
    }

    /// Returns the cofactors of f with the bit clear and with it set. f depends on no earlier bit.
    pub(super) fn split<'a>(&'a self, f: Edge<'a, 'id>, bit: u32) -> [Edge<'a, 'id>; 2] {
        let (set, clear) = self.m.children(f, 2 * bit);
        [clear, set]
    }

    /// Computes { s ∈ B : one step of the list joins s and X }.
    ///
    /// The recursion never leaves B. States outside it, which are often many and irregular, are not
    /// built.
    pub(super) fn step(
        &self,
        x: Edge<'_, 'id>,
        b: Edge<'_, 'id>,
        list: &RelationList,
    ) -> Result<Held<'m, 'id>, Halt> {
        if list.is_empty() || self.m.is_zero(x) || self.m.is_zero(b) {
            return Ok(self.zero());
        }
        if let Some(kept) = list.kept() {
            let both = self.and(x, b)?;
            return self.and(kept.as_edge(self.m), both.borrowed());
        }
        if let Some(found) = self.m.recall(Memo::Step, &[x, b], self.number(list)) {
            return Ok(found);
        }
        self.tick()?;
        let bit = self.top(x).min(self.top(b)).min(list.top);
        let ([x0, x1], [b0, b1]) = (self.split(x, bit), self.split(b, bit));
        let (set, clear) = if bit < list.top {
            (self.step(x1, b1, list)?, self.step(x0, b0, list)?)
        } else {
            let cofactors = self.cofactors(list)?;
            let half = |to: bool, b: Edge<'_, 'id>| {
                let stays = self.step(if to { x1 } else { x0 }, b, self.cofactor(cofactors, to, to))?;
                if stays.borrowed() == b {
                    return Ok(stays);
                }
                let crosses = self.step(if to { x0 } else { x1 }, b, self.cofactor(cofactors, !to, to))?;
                self.or(stays.borrowed(), crosses.borrowed())
            };
            (half(true, b1)?, half(false, b0)?)
        };
        let result = self.node_among(2 * bit, set, clear, [(b, (b1, b0))])?;
        self.m.remember(Memo::Step, &[x, b], self.number(list), result.borrowed());
        Ok(result)
    }

    /// Returns the steps that lead, in the direction of this recursion, from one value of the bit
    /// to another.
    pub(super) fn cofactor<'q>(&self, cofactors: &'q Cofactors, from: bool, to: bool) -> &'q RelationList {
        match self.direction {
            Direction::Forward => cofactors.step(from, to),
            Direction::Backward => cofactors.step(to, from),
        }
    }

    /// Returns the key of a list in the operation cache, for the direction of this recursion.
    pub(super) fn number(&self, list: &RelationList) -> u32 {
        list.number + u32::from(self.direction == Direction::Backward)
    }

    /// Returns X with its support bits replaced by their next copies.
    pub(super) fn primed(&self, x: Edge<'_, 'id>, support: &Support) -> Result<Held<'m, 'id>, Halt> {
        self.prime(x, support, &mut ByNode::new(self.store))
    }

    fn prime(
        &self,
        x: Edge<'_, 'id>,
        support: &Support,
        known: &mut ByNode<'m, 'id>,
    ) -> Result<Held<'m, 'id>, Halt> {
        let bit = self.top(x);
        let support = support.from(bit);
        if support.is_empty() {
            return Ok(self.m.held(x));
        }
        if let Some(found) = known.get(self.m, x.node_id()) {
            return Ok(found);
        }
        self.tick()?;
        let [clear, set] = self.split(x, bit);
        let (clear, set) = (self.prime(clear, &support, known)?, self.prime(set, &support, known)?);
        let result = self.node_on(2 * bit + u32::from(support.top() == bit), set, clear)?;
        known.insert(self.m, x.node_id(), &result);
        Ok(result)
    }
}

/// The results of a recursion by the node of its operand.
pub(super) struct ByNode<'m, 'id: 'm> {
    found: AHashMap<NodeID, Held<'m, 'id>>,
    charge: Charge,
}

impl<'m, 'id: 'm> ByNode<'m, 'id> {
    /// Creates an empty table.
    pub(super) fn new(store: &Store) -> Self {
        ByNode { found: AHashMap::new(), charge: store.charge() }
    }

    /// Returns the result for a node.
    pub(super) fn get(&self, m: &'m ManagerOf<'id>, node: NodeID) -> Option<Held<'m, 'id>> {
        self.found.get(&node).map(|found| m.held(found.borrowed()))
    }

    /// Adds the result for a node.
    pub(super) fn insert(&mut self, m: &'m ManagerOf<'id>, node: NodeID, result: &Held<'m, 'id>) {
        self.charge.add(BYTES_OF_TABLE * size_of::<(NodeID, Held<'_, '_>)>());
        self.found.insert(node, m.held(result.borrowed()));
    }
}
