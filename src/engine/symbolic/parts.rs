//! The choices of several groups, each with its own bound, taken down the bits together.
//!
//! What a choice set allows differs from group to group. To confine each relation to it would build
//! all relations anew for every set; here the bounds go down beside the relations.

use std::sync::Arc;

use ahash::AHashMap;
use oxidd::Function;

use super::SymbolicEngine;
use super::diagram::{Bdd, Diagram};
use super::relation_lists::RelationList;
use super::store::Store;
use super::walk::{Halt, Walk};
use crate::error::Result;

/// Some choices of one group.
#[derive(Clone)]
pub(super) struct Part {
    /// Where they are allowed.
    pub(super) allowed: Bdd,
    /// Steps into these states do not count.
    pub(super) except: Bdd,
    /// The steps.
    pub(super) list: Arc<RelationList>,
}

/// What a recursion is asked of parts, beside a set: their bounds, and the numbers of their lists.
type Operands = Vec<(Bdd, Bdd, u32)>;

/// What a recursion over parts found on the way, of a set and operands.
pub(super) struct Known<T> {
    pub(super) found: AHashMap<(Bdd, Operands), T>,
    most: usize,
}

impl<T> Known<T> {
    /// Nothing yet; the recursion gives up when it has found so much.
    pub(super) fn new(most: usize) -> Self {
        Known { found: AHashMap::new(), most }
    }

    /// Whether there may be more.
    pub(super) fn check(&self) -> Result<(), Halt> {
        if self.found.len() >= self.most { Err(Halt::Spent) } else { Ok(()) }
    }
}

/// The operands of some parts.
pub(super) fn operands(parts: &[Part]) -> Operands {
    parts.iter().map(|p| (p.allowed.clone(), p.except.clone(), p.list.number)).collect()
}

/// Some states by exceptions that disjoint sets have: those of each, and last those of none, with the states
/// into which their steps do not count. None of the sets is empty.
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

/// Whether a recursion over parts is worth beginning: where steps that keep the first bits leave many
/// different relations behind, as in products of modules, there are too many cases to tell apart.
///
/// It depends on the relations alone, so it is asked of them once.
pub(super) fn are_few(engine: &SymbolicEngine) -> Result<bool> {
    if let Some(&few) = engine.few_parts.get() {
        return Ok(few);
    }
    let most = engine.store.thresholds().relations_a_bit * engine.encoding.width();
    let few = engine.store.lists.stay_few(&engine.store, &engine.groups, most)?;
    Ok(*engine.few_parts.get_or_init(|| few))
}

/// What a recursion over parts may take before it gives up.
pub(super) struct Budget {
    /// So many results of its own on the way.
    pub(super) cases: usize,
    /// So many steps in all, those within steps across a bit among them.
    pub(super) steps: u64,
}

impl Budget {
    #[cfg(test)]
    pub(super) const ENDLESS: Budget = Budget { cases: usize::MAX, steps: u64::MAX };
    #[cfg(test)]
    pub(super) const NONE: Budget = Budget { cases: 0, steps: u64::MAX };

    /// By the size of the operands.
    pub(super) fn of(store: &Store, parts: &[Part]) -> Self {
        let nodes: usize = parts.iter().map(|p| store.size(&p.allowed)).sum();
        let thresholds = store.thresholds();
        Budget {
            cases: nodes / thresholds.nodes_per_case.max(1) + thresholds.free_cases,
            steps: nodes as u64 * thresholds.steps_per_node + thresholds.free_steps,
        }
    }
}

impl Part {
    /// Whether a step may change anything.
    pub(super) fn edge_labels(&self, store: &Store) -> bool {
        self.list.edge_labels() && !store.is_zero(&self.allowed)
    }
}

impl<'m, 'id: 'm> Walk<'m, 'id> {
    /// The first bit that matters to a set or to parts.
    pub(super) fn first_bit(&self, x: &Bdd, parts: &[Part]) -> u32 {
        let tops = parts.iter().map(|p| self.bit(&p.allowed).min(self.bit(&p.except)).min(p.list.top));
        tops.min().unwrap_or(u32::MAX).min(self.bit(x))
    }

    /// What is left of parts where `bit`, before which nothing matters, has a value and keeps it.
    pub(super) fn half(&self, bit: u32, value: bool, parts: &[Part]) -> Result<Vec<Part>, Halt> {
        let side = |part: &Part, list: Arc<RelationList>| Part {
            allowed: self.side(&part.allowed, bit, value),
            except: self.side(&part.except, bit, value),
            list,
        };
        let arcs = self.arcs(bit, parts, value, value)?;
        Ok(parts.iter().zip(arcs).map(|(part, list)| side(part, list)).collect())
    }

    /// For each part its steps from one value of `bit` to another.
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

    /// { s allowed by a part : one of its steps on `cofactor` leads from s into `new`, and counts }, where the
    /// states of `new` and those that `part` excepts are on the one side of a bit, `allowed` on the other.
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

    /// if `bit` then `set` else `clear`
    pub(super) fn joined(&self, bit: u32, set: &Bdd, clear: &Bdd) -> Result<Bdd, Halt> {
        self.own(|w| w.node(bit, &w.m.held(set.as_edge(w.m)), &w.m.held(clear.as_edge(w.m))))
    }

    /// The first bit that a diagram depends on.
    fn bit(&self, f: &Bdd) -> u32 {
        self.top(f.as_edge(self.m))
    }

    /// A diagram by a bit that is none after its first.
    pub(super) fn side(&self, f: &Bdd, bit: u32, value: bool) -> Bdd {
        self.m.handle(self.split(f.as_edge(self.m), bit)[usize::from(value)])
    }
}
