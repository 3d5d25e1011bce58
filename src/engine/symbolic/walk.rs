//! Recursion over sets and relations at once: its limits, and one step.

use std::cell::Cell;

use ahash::AHashMap;
use oxidd::util::AllocResult;
use oxidd::{Function, NodeID};

use super::diagram::{Bdd, Diagram, Edge, Held, ManagerOf, Memo};
use super::relation_lists::{Cofactors, RelationList};
use super::store::Store;
use super::support::Support;
use crate::error::{Error, Result};

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
    /// An error: a limit of the run.
    Failed(Error),
    /// The recursion took more steps than allowed.
    Spent,
}

impl From<Error> for Halt {
    fn from(error: Error) -> Self {
        Halt::Failed(error)
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

/// Number of steps between two checks of the limits.
const PATIENCE: u64 = 1 << 10;

impl<'m, 'id: 'm> Walk<'m, 'id> {
    /// Creates a recursion that may take `steps` steps.
    pub(super) fn new(
        store: &'m Store,
        m: &'m ManagerOf<'id>,
        direction: Direction,
        phase: Option<&'static str>,
        steps: u64,
    ) -> Self {
        Walk { store, m, direction, phase, left: Cell::new(steps) }
    }

    /// Counts a step: one result that was not in the cache.
    pub(super) fn tick(&self) -> Result<(), Halt> {
        let left = self.left.get();
        if left == 0 {
            return Err(Halt::Spent);
        }
        self.left.set(left - 1);
        if left.is_multiple_of(PATIENCE) {
            self.store.safe_point_in(self.m)?;
            self.phase.inspect(|phase| self.store.progress(phase));
        }
        Ok(())
    }

    /// Runs an operation; if the table is full, collects garbage and tries once more.
    pub(super) fn run(
        &self,
        operation: impl Fn() -> AllocResult<Held<'m, 'id>>,
    ) -> Result<Held<'m, 'id>, Halt> {
        operation().or_else(|_| {
            self.store.collect_in(self.m);
            operation().map_err(|_| self.store.full().into())
        })
    }

    pub(super) fn zero(&self) -> Result<Held<'m, 'id>, Halt> {
        self.run(|| self.m.zero())
    }

    pub(super) fn or(&self, f: Edge<'_, 'id>, g: Edge<'_, 'id>) -> Result<Held<'m, 'id>, Halt> {
        self.run(|| self.m.or(f, g))
    }

    pub(super) fn and(&self, f: Edge<'_, 'id>, g: Edge<'_, 'id>) -> Result<Held<'m, 'id>, Halt> {
        self.run(|| self.m.and(f, g))
    }

    pub(super) fn minus(&self, f: Edge<'_, 'id>, g: Edge<'_, 'id>) -> Result<Held<'m, 'id>, Halt> {
        self.run(|| self.m.minus(f, g))
    }

    /// Computes: if `bit` then `set` else `clear`.
    pub(super) fn node(
        &self,
        bit: u32,
        set: &Held<'m, 'id>,
        clear: &Held<'m, 'id>,
    ) -> Result<Held<'m, 'id>, Halt> {
        self.run(|| self.m.node(2 * bit, self.m.held(set.borrowed()), self.m.held(clear.borrowed())))
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
            return self.zero();
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
        let result = if bit < list.top {
            self.node(bit, &self.step(x1, b1, list)?, &self.step(x0, b0, list)?)?
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
            self.node(bit, &half(true, b1)?, &half(false, b0)?)?
        };
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
        self.prime(x, support, &mut AHashMap::new())
    }

    fn prime(
        &self,
        x: Edge<'_, 'id>,
        support: &Support,
        known: &mut AHashMap<NodeID, Held<'m, 'id>>,
    ) -> Result<Held<'m, 'id>, Halt> {
        let bit = self.top(x);
        let support = support.from(bit);
        if support.is_empty() {
            return Ok(self.m.held(x));
        }
        if let Some(found) = known.get(&x.node_id()) {
            return Ok(self.m.held(found.borrowed()));
        }
        self.tick()?;
        let [clear, set] = self.split(x, bit);
        let (clear, set) = (self.prime(clear, &support, known)?, self.prime(set, &support, known)?);
        let level = 2 * bit + u32::from(support.top() == bit);
        let result =
            self.run(|| self.m.node(level, self.m.held(set.borrowed()), self.m.held(clear.borrowed())))?;
        known.insert(x.node_id(), self.m.held(result.borrowed()));
        Ok(result)
    }
}
