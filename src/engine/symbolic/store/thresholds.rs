//! The thresholds and leaders by which the symbolic engine chooses between methods with the same result, and
//! counters of the methods used.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use crate::schedule::Leader;

/// The sizes at which the engine changes from one method to another. Results do not depend on them.
///
/// A *step* is a result that was not in the operation cache, of a recursion or of any operation
/// inside it, a node that was made without such a result, or a relation in new cofactors of a list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Thresholds {
    /// The recursions over groups of choices with their bounds lead at first (losing states, reachability by
    /// allowed choices) if there are at most this many different cases per bit of a state. A case is a combination
    /// of the relation lists that remain below bits that keep their values. With more cases, they take no turn.
    pub relations_per_bit: usize,
    /// Steps of a turn where ways race, and the least steps of the first one where methods take turns.
    pub first_turn: u64,
    /// Work of the explicit engine, in states and their successors, before other ways begin, if several race.
    pub work_before_diagrams: u64,
    /// Steps that the way that leads a race has alone, for each step in which it has found all states.
    pub lead: u64,
    /// Initial number of entries of the operation cache, if the memory suffices. Models with many nodes get more once
    /// their states are known.
    pub cache: u64,
    /// Minimum number of nodes at which garbage is collected.
    pub first_collection: usize,
}

impl Default for Thresholds {
    fn default() -> Self {
        Thresholds {
            relations_per_bit: 4,
            first_turn: 1 << 19,
            work_before_diagrams: 1 << 18,
            lead: 128,
            cache: 1 << 20,
            first_collection: 16_000_000,
        }
    }
}

/// The methods that lead each kind of fixpoint.
#[derive(Debug, Default)]
pub(in crate::symbolic) struct Leaders {
    /// Reachability in the forward and the backward direction.
    pub(in crate::symbolic) reach: [Leader; 2],
    /// Reachability by allowed choices.
    pub(in crate::symbolic) confined: Leader,
    /// Removal of losing states.
    pub(in crate::symbolic) lost: Leader,
    /// Attractors of games.
    pub(in crate::symbolic) attracted: Leader,
}

/// Counters of the methods used.
#[derive(Debug, Default)]
pub(in crate::symbolic) struct Work {
    /// Steps of all recursions: results that were not in the operation cache, and nodes made for no
    /// such result.
    pub(in crate::symbolic) steps: AtomicU64,
    /// Collections of garbage.
    pub(in crate::symbolic) collections: AtomicU64,
    /// Fixpoints by recursion over the relations, and by saturation.
    pub(in crate::symbolic) reached: [AtomicU64; 2],
    /// Fixpoints of reachability by allowed choices, by recursion over the groups of choices.
    pub(in crate::symbolic) confined: AtomicU64,
    /// Removals of losing states by layers, by recursion over the lists of all groups, and over the groups with
    /// their bounds.
    pub(in crate::symbolic) lost: [AtomicU64; 3],
}

/// The number of times that the symbolic engine used each of the methods with the same result, and its
/// work.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Ways {
    /// Fixpoints of reachability by recursion over the relations.
    pub by_recursion: u64,
    /// Fixpoints of reachability by saturation.
    pub by_saturation: u64,
    /// Fixpoints of reachability by allowed choices, by recursion over the groups of choices.
    pub confined_by_recursion: u64,
    /// Removals of losing states by recursion over the groups of choices with their bounds.
    pub lost_by_recursion: u64,
    /// Removals of losing states by recursion over the lists of all groups.
    pub lost_by_lists: u64,
    /// Removals of losing states layer by layer.
    pub lost_by_layers: u64,
    /// Steps of all recursions: a measure of work that does not depend on the machine.
    pub steps: u64,
}

impl Work {
    /// Adds the methods used by another store.
    pub(in crate::symbolic) fn add(&self, other: &Work) {
        for (own, other) in self.methods().zip(other.methods()) {
            own.fetch_add(other.load(Relaxed), Relaxed);
        }
    }

    fn methods(&self) -> impl Iterator<Item = &AtomicU64> {
        self.reached.iter().chain([&self.confined]).chain(&self.lost)
    }

    pub(in crate::symbolic) fn ways(&self) -> Ways {
        let [by_recursion, by_saturation] = &self.reached;
        let [lost_by_layers, lost_by_lists, lost_by_recursion] = &self.lost;
        Ways {
            by_recursion: by_recursion.load(Relaxed),
            by_saturation: by_saturation.load(Relaxed),
            confined_by_recursion: self.confined.load(Relaxed),
            lost_by_recursion: lost_by_recursion.load(Relaxed),
            lost_by_lists: lost_by_lists.load(Relaxed),
            lost_by_layers: lost_by_layers.load(Relaxed),
            steps: self.steps.load(Relaxed),
        }
    }
}
