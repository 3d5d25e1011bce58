//! Choices of several groups, each with its own bound, as operands of one recursion.
//!
//! A choice set allows different states for each group. Restricting each relation to its allowed
//! states would rebuild all relations for every set. Here the bounds are split bit by bit together
//! with the relations instead.

use std::sync::Arc;

use crate::symbolic::relations::lists::RelationList;
use crate::symbolic::store::Store;
use crate::symbolic::store::charge::{BYTES_OF_TABLE, Charge};
use crate::symbolic::store::diagram::{Bdd, Diagram};
use crate::symbolic::store::walk::{Halt, Walk};
use ahash::AHashMap;
use meliora_base::error::Result;

/// Some choices of one group.
#[derive(Clone)]
pub(in crate::symbolic) struct Part {
    /// The states in which the choices are allowed.
    pub(in crate::symbolic) allowed: Bdd,
    /// The states into which steps do not count.
    pub(in crate::symbolic) except: Bdd,
    /// The steps.
    pub(in crate::symbolic) list: Arc<RelationList>,
}

/// The operands of a recursion over parts, except for its set: for each part its two bounds and the
/// number of its list.
type Operands = Vec<(Bdd, Bdd, u32)>;

/// The results that a recursion over parts has found so far, by set and operands.
pub(in crate::symbolic) struct Known<T> {
    found: AHashMap<(Bdd, Operands), T>,
    charge: Charge,
}

impl<T: Clone> Known<T> {
    /// Creates an empty table.
    pub(in crate::symbolic) fn new(store: &Store) -> Self {
        Known { found: AHashMap::new(), charge: store.charge() }
    }

    /// Returns the result for a set and operands.
    pub(in crate::symbolic) fn get(&self, key: &(Bdd, Operands)) -> Option<T> {
        self.found.get(key).cloned()
    }

    /// Adds a result. For each part it has at most one more diagram than the operands.
    pub(in crate::symbolic) fn insert(&mut self, key: (Bdd, Operands), result: T) {
        let parts = key.1.len() * (size_of::<(Bdd, Bdd, u32)>() + size_of::<Bdd>());
        self.charge.add(BYTES_OF_TABLE * size_of::<((Bdd, Operands), T)>() + parts);
        self.found.insert(key, result);
    }
}

/// Returns the operands of some parts.
pub(in crate::symbolic) fn operands(parts: &[Part]) -> Operands {
    parts.iter().map(|p| (p.allowed.clone(), p.except.clone(), p.list.number)).collect()
}

/// Splits a set of states by pairwise disjoint sets, each with its exceptions: returns (`states` ∩
/// `from`, `except`) for each, and last the rest with ∅.
///
/// The exceptions are the states into which steps do not count. Empty sets are left out.
pub(in crate::symbolic) fn by_exception(
    store: &Store,
    states: &Bdd,
    exceptions: &[(Bdd, Bdd)],
) -> Result<Vec<(Bdd, Bdd)>> {
    let (mut sets, mut rest) = (Vec::with_capacity(exceptions.len() + 1), states.clone());
    for (from, except) in exceptions {
        sets.push((store.and(&rest, from)?, except.clone()));
        rest = store.minus(&rest, from)?;
    }
    sets.push((rest, store.zero()));
    sets.retain(|(states, _)| !store.is_zero(states));
    Ok(sets)
}

impl Part {
    /// Returns true if a step may change the state.
    pub(in crate::symbolic) fn changes_state(&self, store: &Store) -> bool {
        self.list.changes_state() && !store.is_zero(&self.allowed)
    }
}

impl<'m, 'id: 'm> Walk<'m, 'id> {
    /// Counts a new case: a step for each part, since all operands are split and stored.
    pub(in crate::symbolic) fn tick_for(&self, parts: &[Part]) -> Result<(), Halt> {
        parts.iter().try_for_each(|_| self.tick())
    }

    /// Returns the first bit that a set or some parts depend on.
    pub(in crate::symbolic) fn first_bit(&self, x: &Bdd, parts: &[Part]) -> u32 {
        let tops = parts.iter().map(|p| self.bit(&p.allowed).min(self.bit(&p.except)).min(p.list.top));
        tops.min().unwrap_or(u32::MAX).min(self.bit(x))
    }

    /// Returns the cofactors of some parts for steps on which `bit` has and keeps the value
    /// `value`. The parts depend on no earlier bit.
    pub(in crate::symbolic) fn half(&self, bit: u32, value: bool, parts: &[Part]) -> Result<Vec<Part>, Halt> {
        let side = |part: &Part, list: Arc<RelationList>| Part {
            allowed: self.side(&part.allowed, bit, value),
            except: self.side(&part.except, bit, value),
            list,
        };
        let arcs = self.arcs(bit, parts, value, value)?;
        Ok(parts.iter().zip(arcs).map(|(part, list)| side(part, list)).collect())
    }

    /// Returns for each part its steps on which `bit` changes from the value `from` to the value
    /// `to`.
    pub(in crate::symbolic) fn arcs(
        &self,
        bit: u32,
        parts: &[Part],
        from: bool,
        to: bool,
    ) -> Result<Vec<Arc<RelationList>>, Halt> {
        let cofactor = |part: &Part| Ok(part.list.cofactor(self.store, bit, from, to)?);
        parts.iter().map(cofactor).collect()
    }

    /// { s ∈ `allowed` : a step of `cofactor` leads from s into `new` \ `except` }
    ///
    /// `new` and `except` are sets on one side of a bit, `allowed` is a set on the other side;
    /// `cofactor` contains the steps across the bit.
    pub(in crate::symbolic) fn enter(
        &self,
        new: &Bdd,
        except: &Bdd,
        allowed: &Bdd,
        cofactor: &RelationList,
    ) -> Result<Bdd, Halt> {
        let new = self.both(Walk::minus, new, except)?;
        self.own(|w| w.step(w.edge(&new), w.edge(allowed), cofactor))
    }

    /// Computes: if `bit` then `set` else `clear`.
    pub(in crate::symbolic) fn joined(&self, bit: u32, set: &Bdd, clear: &Bdd) -> Result<Bdd, Halt> {
        self.tick()?;
        self.own(|w| w.node(bit, w.m.held(w.edge(set)), w.m.held(w.edge(clear))))
    }

    /// Returns the first bit that a diagram depends on.
    fn bit(&self, f: &Bdd) -> u32 {
        self.top(self.edge(f))
    }

    /// Returns the cofactor of a diagram by a bit. The diagram depends on no earlier bit.
    pub(in crate::symbolic) fn side(&self, f: &Bdd, bit: u32, value: bool) -> Bdd {
        self.m.handle(self.split(self.edge(f), bit)[usize::from(value)])
    }
}
