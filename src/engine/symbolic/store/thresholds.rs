//! The thresholds by which the symbolic engine chooses between methods with the same result, and
//! counters of the methods used.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// The sizes at which the engine changes from one method to another. Results do not depend on them.
///
/// A *step* is a result that was not in the operation cache, of a recursion or of any operation
/// inside it, or a node that was made without such a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Thresholds {
    /// Relations with the same support are united while they have fewer nodes than this.
    pub small_relation: usize,
    /// Relations with the same first bit are united, whatever their support, if the union is small:
    /// at most this many nodes, or at most twice as many as the two together.
    pub small_union: usize,
    /// Maximum number of relation lists that are remembered. Then all are forgotten except those in
    /// use.
    pub most_lists: usize,
    /// Minimum number of nodes of a set whose predecessors are computed within the allowed states.
    /// A smaller set has few predecessors, and a bound adds cases to the recursion.
    pub large_set: usize,
    /// Maximum number of steps of one method for backward reachability before the other one is
    /// tried.
    pub trial_steps: u64,
    /// Maximum number of these steps per node of the bound, if that allows more.
    pub trial_steps_per_node: u64,
    /// Maximum number of steps of one method for forward reachability before the other one is
    /// tried. It is larger, because recursion was faster wherever both methods ran to the end.
    pub forward_trial_steps: u64,
    /// Limit for recursions over groups of choices (losing states, reachability by allowed choices):
    /// the maximum number of different cases per bit of a state. A case is a combination of the
    /// relation lists that remain below bits that keep their values. With more cases, the engine
    /// does not use these recursions.
    pub relations_per_bit: usize,
    /// Nodes of the operands per intermediate result that such a recursion may find …
    pub nodes_per_case: usize,
    /// … with this many additional results.
    pub free_cases: usize,
    /// Steps that such a recursion may take per node of its operands …
    pub steps_per_node: u64,
    /// … with this many additional steps.
    pub free_steps: u64,
    /// Maximum number of steps of the recursion over the lists of all groups for losing states before
    /// layers are tried, which may take four times as many. Both continue in turns with 16 times
    /// more steps.
    pub lose_steps: u64,
    /// Maximum number of these steps of the recursion per node of the candidates, if that allows more.
    ///
    /// Measured: `csma4_4` has 429,000 nodes and needs 138 steps for each; to give up after 20 million and
    /// take layers costs 1.2 times as much. `csma3_6` needs 53 for each.
    pub lose_steps_per_node: u64,
    /// Layers of states come first if there are bits that at least this percentage of the groups write, …
    pub shared_by_percent: usize,
    /// … these are at most this percentage of all bits, …
    pub most_shared_percent: usize,
    /// … and the set of all states has fewer nodes than this per bit.
    ///
    /// Measured: `coin`, in which each process moves one counter, takes 0.4 to 0.8 times the steps; it has
    /// at most 16 nodes per bit. Where no bits are shared, as in `leader` and `wlan`, layers take up to 10
    /// times the steps. `phil_lss4` has 1,400 nodes per bit and takes 1.3 times the steps; `rabin8` has 140
    /// and takes 0.9 times, but `rabin10` more than with sets of choices.
    pub nodes_per_bit: usize,
    /// Number of its steps after which that recursion is given up at once, if the lost states found so
    /// far need many more nodes than all candidates together.
    ///
    /// Measured: after 8 million steps `rabin10` has 7 times as many nodes, and layers are more than twice as
    /// fast as the recursion; `rabin8`, `wlan6`, `leader8` and `leader10` stay below 6. `rabin8` ends soon after
    /// 8 million: to stop it there and begin again costs half of its time.
    pub lose_trial_steps: u64,
    /// The least number of times as many.
    pub lose_growth: usize,
    /// Initial number of entries of the operation cache, if the memory suffices. Translating a
    /// model takes many small operations, whose lookups are faster in a small cache.
    pub first_cache: u64,
    /// Maximum number of steps of the exploration with the first operation cache.
    pub first_steps: u64,
    /// Number of steps of the exploration after which the explicit engine takes turns, if the engine is
    /// selected by the states.
    pub steps_before_trial: u64,
    /// Work of the explicit engine, in states and their successors, before the exploration begins, if a
    /// question lists the states.
    pub work_before_diagrams: u64,
    /// Number of entries of the operation cache once the exploration took too many steps, or the
    /// states are known and the model is not small. Larger models get more.
    pub main_cache: u64,
    /// Minimum number of nodes at which garbage is collected.
    pub first_collection: usize,
    /// Minimum number of nodes of the states and the relations for work on several threads. In a
    /// smaller model, copying the sets takes longer than it saves. Also the number of states from which
    /// several threads list the choices of quantities.
    pub nodes_for_threads: usize,
}

impl Default for Thresholds {
    fn default() -> Self {
        Thresholds {
            small_relation: 400,
            small_union: 2_000,
            most_lists: 1 << 18,
            large_set: 2_000,
            trial_steps: 2_000_000,
            trial_steps_per_node: 200,
            forward_trial_steps: 32_000_000,
            relations_per_bit: 4,
            nodes_per_case: 40,
            free_cases: 300,
            steps_per_node: 200,
            free_steps: 40_000,
            lose_steps: 20_000_000,
            lose_steps_per_node: 200,
            shared_by_percent: 75,
            most_shared_percent: 50,
            nodes_per_bit: 64,
            lose_trial_steps: 12_000_000,
            lose_growth: 6,
            first_cache: 1 << 17,
            first_steps: 1 << 19,
            steps_before_trial: 1 << 14,
            work_before_diagrams: 1 << 18,
            main_cache: 1 << 20,
            first_collection: 16_000_000,
            nodes_for_threads: 10_000,
        }
    }
}

/// Counters of the methods used.
#[derive(Debug, Default)]
pub(in crate::symbolic) struct Work {
    /// Steps of all recursions: results that were not in the operation cache, and nodes made for no
    /// such result.
    pub(in crate::symbolic) steps: AtomicU64,
    /// Collections of garbage.
    pub(in crate::symbolic) collections: AtomicU64,
    /// Fixpoints by recursion over the relations, by saturation, and by layers.
    pub(in crate::symbolic) reached: [AtomicU64; 3],
    /// Recursions for reachability by allowed choices: given up, and completed.
    pub(in crate::symbolic) confined: [AtomicU64; 2],
    /// Removals of losing states by layers, and by recursion.
    pub(in crate::symbolic) lost: [AtomicU64; 2],
    /// Removals of losing states by recursion over the lists of all groups.
    pub(in crate::symbolic) lost_by_lists: AtomicU64,
    /// Removals of losing states by layers of states alone.
    pub(in crate::symbolic) lost_by_state_layers: AtomicU64,
    /// Recursions for losing states that were given up.
    pub(in crate::symbolic) given_up: AtomicU64,
}

/// The number of times that the symbolic engine used each of the methods with the same result, and its
/// work.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Ways {
    /// Fixpoints of reachability by recursion over the relations.
    pub by_recursion: u64,
    /// Fixpoints of reachability by saturation.
    pub by_saturation: u64,
    /// Fixpoints of reachability layer by layer.
    pub by_layers: u64,
    /// Fixpoints of reachability by allowed choices, by recursion over the groups of choices.
    pub confined_by_recursion: u64,
    /// Recursions for reachability by allowed choices that were given up. One of the first three
    /// methods completed these fixpoints.
    pub confined_given_up: u64,
    /// Removals of losing states by recursion over the groups of choices with their bounds.
    pub lost_by_recursion: u64,
    /// Removals of losing states by recursion over the lists of all groups.
    pub lost_by_lists: u64,
    /// Removals of losing states layer by layer, with sets of choices.
    pub lost_by_layers: u64,
    /// Removals of losing states by layers of states alone.
    pub lost_by_state_layers: u64,
    /// Recursions with bounds that were given up. One of the two methods above and below completed
    /// these removals.
    pub given_up: u64,
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
        let several = self.reached.iter().chain(&self.confined).chain(&self.lost);
        several.chain([&self.lost_by_lists, &self.lost_by_state_layers, &self.given_up])
    }

    pub(in crate::symbolic) fn ways(&self) -> Ways {
        Ways {
            by_recursion: self.reached[0].load(Relaxed),
            by_saturation: self.reached[1].load(Relaxed),
            by_layers: self.reached[2].load(Relaxed),
            confined_by_recursion: self.confined[1].load(Relaxed),
            confined_given_up: self.confined[0].load(Relaxed),
            lost_by_recursion: self.lost[1].load(Relaxed),
            lost_by_lists: self.lost_by_lists.load(Relaxed),
            lost_by_layers: self.lost[0].load(Relaxed),
            lost_by_state_layers: self.lost_by_state_layers.load(Relaxed),
            given_up: self.given_up.load(Relaxed),
            steps: self.steps.load(Relaxed),
        }
    }
}
