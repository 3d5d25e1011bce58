//! Where the symbolic engine takes one way or another to the same result.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Sizes at which one way of doing the same becomes better than another. Results do not depend on them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Thresholds {
    /// Relations that touch the same bits are united while they have fewer nodes.
    pub small_relation: usize,
    /// Relations of one level are united, whatever they touch, while the union has no more nodes.
    pub small_union: usize,
    /// So many lists of relations are remembered, then all are forgotten but those in use.
    pub most_lists: usize,
    /// From this many nodes of a set on, its predecessors are found within what is asked for: those of
    /// a smaller one are few, and there are more cases to tell apart within a bound.
    pub large_set: usize,
    /// A way to compute backward reachability may take so many steps before another one is tried.
    pub trial_steps: u64,
    /// The same for forward reachability, where recursion has been the better way wherever both were
    /// taken to the end.
    pub forward_trial_steps: u64,
    /// Losing states, and what is reached by some choices only, are found by a recursion over groups of
    /// choices where the relations leave no more different ones behind by bits that keep their values,
    /// for each bit of a state.
    pub relations_a_bit: usize,
    /// Such a recursion may find one result for so many nodes of its operands, …
    pub nodes_per_case: usize,
    /// … and so many more.
    pub free_cases: usize,
    /// It may take so many steps for each node of its operands, …
    pub steps_per_node: u64,
    /// … and so many more.
    pub free_steps: u64,
    /// So many entries the operation cache has at first, as far as there is memory for it: translating a
    /// model is many small operations, and those look up faster what stands close together.
    pub first_cache: u64,
    /// With the first operation cache, exploring may take so many steps.
    pub first_steps: u64,
    /// So many entries the operation cache has at least once exploring took too many steps, or the states
    /// are known and the model is not small.
    pub main_cache: u64,
    /// Below this many nodes, garbage is not worth collecting.
    pub first_collection: usize,
}

impl Default for Thresholds {
    fn default() -> Self {
        Thresholds {
            small_relation: 400,
            small_union: 2_000,
            most_lists: 1 << 18,
            large_set: 2_000,
            trial_steps: 1_000_000,
            forward_trial_steps: 16_000_000,
            relations_a_bit: 4,
            nodes_per_case: 40,
            free_cases: 300,
            steps_per_node: 100,
            free_steps: 20_000,
            first_cache: 1 << 17,
            first_steps: 1 << 18,
            main_cache: 1 << 20,
            first_collection: 16_000_000,
        }
    }
}

/// How often each way was taken.
#[derive(Debug, Default)]
pub(super) struct Work {
    /// Fixpoints by recursion over the relations, and by saturation.
    pub(super) reached: [AtomicU64; 2],
    /// Recursions for what is reached by some choices that were given up, and that were not.
    pub(super) confined: [AtomicU64; 2],
    /// Losing states by layers, and by recursion.
    pub(super) lost: [AtomicU64; 2],
    /// Recursions for losing states that were given up.
    pub(super) given_up: AtomicU64,
}

/// How often the symbolic engine took each way to the same result.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Ways {
    /// Fixpoints of reachability by recursion over the relations.
    pub by_recursion: u64,
    /// Fixpoints of reachability by saturation.
    pub by_saturation: u64,
    /// Fixpoints of reachability by some choices, by recursion over the groups of choices.
    pub confined_by_recursion: u64,
    /// Those that such a recursion was given up for, before they were found by one of the ways above.
    pub confined_given_up: u64,
    /// Losing states found by recursion.
    pub lost_by_recursion: u64,
    /// Losing states left to be found layer by layer.
    pub lost_by_layers: u64,
    /// Of these, those after a recursion that was given up.
    pub given_up: u64,
}

impl Work {
    /// Goes on from what another has counted.
    pub(super) fn take_over(&self, other: &Work) {
        let [by_recursion, by_saturation] = other.reached.each_ref().map(|n| n.load(Relaxed));
        self.reached[0].store(by_recursion, Relaxed);
        self.reached[1].store(by_saturation, Relaxed);
    }

    pub(super) fn ways(&self) -> Ways {
        Ways {
            by_recursion: self.reached[0].load(Relaxed),
            by_saturation: self.reached[1].load(Relaxed),
            confined_by_recursion: self.confined[1].load(Relaxed),
            confined_given_up: self.confined[0].load(Relaxed),
            lost_by_recursion: self.lost[1].load(Relaxed),
            lost_by_layers: self.lost[0].load(Relaxed),
            given_up: self.given_up.load(Relaxed),
        }
    }
}
