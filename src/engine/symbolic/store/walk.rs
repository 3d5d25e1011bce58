//! Recursion over diagrams: its limits and results.

use std::cell::Cell;

use ahash::AHashMap;
use oxidd::NodeID;

use super::Store;
use super::charge::{BYTES_OF_TABLE, Charge};
use super::diagram::{Bdd, Diagram, Edge, Held, ManagerOf};
use meliora_base::error::{Error, Result};

/// The direction in which a relation is applied.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::symbolic) enum Direction {
    /// From sources to successors.
    Forward,
    /// From successors to sources.
    Backward,
}

/// The task of a recursion: it applies relations in a direction, in a phase.
#[derive(Debug, Clone, Copy)]
pub(in crate::symbolic) struct Pass {
    pub(in crate::symbolic) direction: Direction,
    /// The name of the phase for progress reports; `None` for short recursions.
    pub(in crate::symbolic) phase: Option<&'static str>,
}

impl Pass {
    /// A pass from sources to successors.
    pub(in crate::symbolic) fn forward(phase: impl Into<Option<&'static str>>) -> Self {
        Pass { direction: Direction::Forward, phase: phase.into() }
    }

    /// A pass from successors to sources.
    pub(in crate::symbolic) fn backward(phase: impl Into<Option<&'static str>>) -> Self {
        Pass { direction: Direction::Backward, phase: phase.into() }
    }
}

/// The reason why a recursion ended early.
#[derive(Debug)]
pub(in crate::symbolic) enum Halt {
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
pub(in crate::symbolic) struct Walk<'m, 'id: 'm> {
    pub(in crate::symbolic) store: &'m Store,
    pub(in crate::symbolic) m: &'m ManagerOf<'id>,
    pub(in crate::symbolic) direction: Direction,
    /// The name of the phase for progress reports; `None` for short recursions.
    phase: Option<&'static str>,
    /// The number of steps left.
    left: Cell<u64>,
}

/// A diagram with its children (set, clear) by the level of an operation.
pub(in crate::symbolic) type WithChildren<'e, 'id> = (Edge<'e, 'id>, (Edge<'e, 'id>, Edge<'e, 'id>));

/// Maximum number of steps between two checks of the limits.
pub(in crate::symbolic) const PATIENCE: u64 = 1 << 10;

impl<'m, 'id: 'm> Walk<'m, 'id> {
    /// Runs a recursion that may take `steps` steps. Returns its result and the steps that it took.
    pub(in crate::symbolic) fn run<T>(
        store: &'m Store,
        m: &'m ManagerOf<'id>,
        Pass { direction, phase }: Pass,
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
    pub(in crate::symbolic) fn tick(&self) -> Result<(), Halt> {
        let left = self.left.get();
        if left.is_multiple_of(PATIENCE) {
            return self.check(left);
        }
        self.left.set(left - 1);
        Ok(())
    }

    /// Returns true if no step is left.
    pub(in crate::symbolic) fn is_spent(&self) -> bool {
        self.left.get() == 0
    }

    #[cold]
    fn check(&self, left: u64) -> Result<(), Halt> {
        self.left.set(left.checked_sub(1).ok_or(Halt::Spent)?);
        self.store.advance(PATIENCE);
        self.store.check_limits(self.m)?;
        self.phase.inspect(|phase| self.store.progress(phase));
        Ok(())
    }

    pub(in crate::symbolic) fn zero(&self) -> Held<'m, 'id> {
        self.m.constant(false)
    }

    /// Computes: if `bit` then `set` else `clear`.
    pub(in crate::symbolic) fn node(
        &self,
        bit: u32,
        set: Held<'m, 'id>,
        clear: Held<'m, 'id>,
    ) -> Result<Held<'m, 'id>, Halt> {
        self.node_on(2 * bit, set, clear)
    }

    /// Computes: if the variable on `level` then `set` else `clear`.
    #[inline]
    pub(in crate::symbolic) fn node_on(
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
    pub(in crate::symbolic) fn node_among<const N: usize>(
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
    pub(in crate::symbolic) fn own(
        &self,
        operation: impl FnOnce(&Self) -> Result<Held<'m, 'id>, Halt>,
    ) -> Result<Bdd, Halt> {
        Ok(self.m.handle(operation(self)?.borrowed()))
    }

    /// Runs an operation on two diagrams and returns its result as an owned handle.
    pub(in crate::symbolic) fn both(
        &self,
        operation: impl for<'e> FnOnce(&Self, Edge<'e, 'id>, Edge<'e, 'id>) -> Result<Held<'m, 'id>, Halt>,
        f: &Bdd,
        g: &Bdd,
    ) -> Result<Bdd, Halt> {
        self.own(|w| operation(w, w.edge(f), w.edge(g)))
    }

    /// Returns a diagram as an operand.
    pub(in crate::symbolic) fn edge<'e>(&self, f: &'e Bdd) -> Edge<'e, 'id> {
        self.m.edge(f)
    }

    /// Returns the first bit that a diagram depends on.
    pub(in crate::symbolic) fn top(&self, f: Edge<'_, 'id>) -> u32 {
        self.m.level_of(f) / 2
    }

    /// Returns the cofactors of f with the bit clear and with it set. f depends on no earlier bit.
    pub(in crate::symbolic) fn split<'a>(&'a self, f: Edge<'a, 'id>, bit: u32) -> [Edge<'a, 'id>; 2] {
        let (set, clear) = self.m.children(f, 2 * bit);
        [clear, set]
    }
}

/// The results of a recursion by the node of its operand.
pub(in crate::symbolic) struct ByNode<'m, 'id: 'm> {
    found: AHashMap<NodeID, Held<'m, 'id>>,
    charge: Charge,
}

impl<'m, 'id: 'm> ByNode<'m, 'id> {
    /// Creates an empty table.
    pub(in crate::symbolic) fn new(store: &Store) -> Self {
        ByNode { found: AHashMap::new(), charge: store.charge() }
    }

    /// Returns the result for a node.
    pub(in crate::symbolic) fn get(&self, m: &'m ManagerOf<'id>, node: NodeID) -> Option<Held<'m, 'id>> {
        self.found.get(&node).map(|found| m.held(found.borrowed()))
    }

    /// Adds the result for a node.
    pub(in crate::symbolic) fn insert(
        &mut self,
        m: &'m ManagerOf<'id>,
        node: NodeID,
        result: &Held<'m, 'id>,
    ) {
        self.charge.add(BYTES_OF_TABLE * size_of::<(NodeID, Held<'_, '_>)>());
        self.found.insert(node, m.held(result.borrowed()));
    }
}
