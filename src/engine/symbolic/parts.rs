//! Choices of several groups, each with its own bound, as operands of one recursion.
//!
//! A choice set allows different states for each group. Restricting each relation to its allowed
//! states would rebuild all relations for every set. Here the bounds are split bit by bit together
//! with the relations instead.

use std::sync::Arc;

use ahash::AHashMap;
use oxidd::Function;

use super::SymbolicEngine;
use super::charge::{BYTES_OF_TABLE, Charge};
use super::diagram::{Bdd, Diagram};
use super::relation_lists::RelationList;
use super::store::Store;
use super::walk::{Halt, Walk};
use meliora_model::error::Result;

/// Some choices of one group.
#[derive(Clone)]
pub(super) struct Part {
    /// The states in which the choices are allowed.
    pub(super) allowed: Bdd,
    /// The states into which steps do not count.
    pub(super) except: Bdd,
    /// The steps.
    pub(super) list: Arc<RelationList>,
}

/// The operands of a recursion over parts, except for its set: for each part its two bounds and the
/// number of its list.
type Operands = Vec<(Bdd, Bdd, u32)>;

/// The results that a recursion over parts has found so far, by set and operands.
pub(super) struct Known<T> {
    found: AHashMap<(Bdd, Operands), T>,
    most: usize,
    charge: Charge,
}

impl<T: Clone> Known<T> {
    /// Creates an empty table; the recursion gives up when the table has `most` results.
    pub(super) fn new(store: &Store, most: usize) -> Self {
        Known { found: AHashMap::new(), most, charge: store.charge() }
    }

    /// Returns the result for a set and operands.
    pub(super) fn get(&self, key: &(Bdd, Operands)) -> Option<T> {
        self.found.get(key).cloned()
    }

    /// Adds a result. For each part it has at most one more diagram than the operands.
    pub(super) fn insert(&mut self, key: (Bdd, Operands), result: T) {
        let parts = key.1.len() * (size_of::<(Bdd, Bdd, u32)>() + size_of::<Bdd>());
        self.charge.add(BYTES_OF_TABLE * size_of::<((Bdd, Operands), T)>() + parts);
        self.found.insert(key, result);
    }

    /// Fails if the table is full.
    pub(super) fn check(&self) -> Result<(), Halt> {
        if self.found.len() >= self.most { Err(Halt::Spent) } else { Ok(()) }
    }
}

/// Returns the operands of some parts.
pub(super) fn operands(parts: &[Part]) -> Operands {
    parts.iter().map(|p| (p.allowed.clone(), p.except.clone(), p.list.number)).collect()
}

/// Splits a set of states by pairwise disjoint sets, each with its exceptions: returns (`states` ∩
/// `from`, `except`) for each, and last the rest with ∅.
///
/// The exceptions are the states into which steps do not count. Empty sets are left out.
pub(super) fn by_exception(
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

/// Returns true if a recursion over parts is expected to pay off.
///
/// It does not if the steps that keep the first bits leave many different relations behind, as in
/// products of modules: there are too many cases to distinguish. The answer depends on the
/// relations alone, so it is computed once.
pub(super) fn are_few(engine: &SymbolicEngine) -> Result<bool> {
    if let Some(&few) = engine.few_parts.get() {
        return Ok(few);
    }
    let most = engine.store.thresholds().relations_per_bit * engine.encoding.width();
    let few = engine.store.lists.stay_few(&engine.store, &engine.groups, most)?;
    Ok(*engine.few_parts.get_or_init(|| few))
}

/// The limits of a recursion over parts, which gives up at either.
pub(super) struct Budget {
    /// Maximum number of intermediate results of its own.
    pub(super) cases: usize,
    /// Maximum number of steps in all, steps across a bit included.
    pub(super) steps: u64,
}

impl Budget {
    #[cfg(test)]
    pub(super) const ENDLESS: Budget = Budget { cases: usize::MAX, steps: u64::MAX };
    #[cfg(test)]
    pub(super) const NONE: Budget = Budget { cases: 0, steps: u64::MAX };

    /// Computes the limits from the size of the operands.
    ///
    /// # Errors
    /// A limit.
    pub(super) fn of(store: &Store, parts: &[Part]) -> Result<Self> {
        let nodes: usize = parts.iter().map(|p| store.size(&p.allowed)).sum::<Result<_>>()?;
        let thresholds = store.thresholds();
        Ok(Budget {
            cases: nodes / thresholds.nodes_per_case.max(1) + thresholds.free_cases,
            steps: nodes as u64 * thresholds.steps_per_node + thresholds.free_steps,
        })
    }
}

impl Part {
    /// Returns true if a step may change the state.
    pub(super) fn changes_state(&self, store: &Store) -> bool {
        self.list.changes_state() && !store.is_zero(&self.allowed)
    }
}

impl<'m, 'id: 'm> Walk<'m, 'id> {
    /// Returns the first bit that a set or some parts depend on.
    pub(super) fn first_bit(&self, x: &Bdd, parts: &[Part]) -> u32 {
        let tops = parts.iter().map(|p| self.bit(&p.allowed).min(self.bit(&p.except)).min(p.list.top));
        tops.min().unwrap_or(u32::MAX).min(self.bit(x))
    }

    /// Returns the cofactors of some parts for steps on which `bit` has and keeps the value
    /// `value`. The parts depend on no earlier bit.
    pub(super) fn half(&self, bit: u32, value: bool, parts: &[Part]) -> Result<Vec<Part>, Halt> {
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
    pub(super) fn arcs(
        &self,
        bit: u32,
        parts: &[Part],
        from: bool,
        to: bool,
    ) -> Result<Vec<Arc<RelationList>>, Halt> {
        let cofactor = |part: &Part| Ok(self.store.lists.cofactor(self.store, &part.list, bit, from, to)?);
        parts.iter().map(cofactor).collect()
    }

    /// { s ∈ `allowed` : a step of `cofactor` leads from s into `new` \ `except` }
    ///
    /// `new` and `except` are sets on one side of a bit, `allowed` is a set on the other side;
    /// `cofactor` contains the steps across the bit.
    pub(super) fn enter(
        &self,
        new: &Bdd,
        except: &Bdd,
        allowed: &Bdd,
        cofactor: &RelationList,
    ) -> Result<Bdd, Halt> {
        let new = self.own(|w| w.minus(new.as_edge(w.m), except.as_edge(w.m)))?;
        self.own(|w| w.step(new.as_edge(w.m), allowed.as_edge(w.m), cofactor))
    }

    /// Computes: if `bit` then `set` else `clear`.
    pub(super) fn joined(&self, bit: u32, set: &Bdd, clear: &Bdd) -> Result<Bdd, Halt> {
        self.tick()?;
        self.own(|w| w.node(bit, w.m.held(set.as_edge(w.m)), w.m.held(clear.as_edge(w.m))))
    }

    /// Returns the first bit that a diagram depends on.
    fn bit(&self, f: &Bdd) -> u32 {
        self.top(f.as_edge(self.m))
    }

    /// Returns the cofactor of a diagram by a bit. The diagram depends on no earlier bit.
    pub(super) fn side(&self, f: &Bdd, bit: u32, value: bool) -> Bdd {
        self.m.handle(self.split(f.as_edge(self.m), bit)[usize::from(value)])
    }
}
