//! The diagram store: OxiDD's manager, with limits, garbage collection and cancellation.
//!
//! Every operation goes through the store. First it asks the progress sink for cancellation, and
//! collects garbage if enough has gathered. If the node table is full, it collects garbage and
//! tries once more.
//!
//! The store owns the lists of relations, because their numbers are keys of its operation cache.
//! Lists consist of partial relations, whose diagrams the store makes. Therefore `store`,
//! `relation_lists` and `partial_relation` import each other.

mod adopt;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};

use ahash::AHashSet;
use num_bigint::BigUint;
use oxidd::bdd::BDDManagerRef;
use oxidd::util::num::Natural;
use oxidd::util::{AllocResult, FxHasher, SatCountCache};
use oxidd::{BooleanFunction, BooleanFunctionQuant, Function, InnerNode, Manager, ManagerRef, Node};

use super::diagram::{Bdd, ManagerOf};
use super::relation_lists::Lists;
use super::tables::{BYTES_PER_ENTRY, BYTES_PER_NODE, cache_entries, cache_for_bits, manager};
use super::thresholds::{Thresholds, Work};
use crate::engine::{Count, ProgressSink, Settings, Usage};
use crate::error::{Error, Limit, Result};

/// Bytes of stack per bit of a state that a recursion needs, with the recursions of OxiDD inside
/// it.
const STACK_PER_BIT: usize = 4 << 10;
/// Maximum number of nodes, well below the 2^31 at which OxiDD aborts the process.
const MOST_NODES: u64 = 1 << 30;
/// Minimum number of nodes per thread: four blocks. OxiDD gives nodes to its threads in blocks of
/// 2^16, and no other thread can use the nodes of a block.
const NODES_PER_THREAD: u64 = 4 << 16;

/// The manager of all diagrams of one engine.
pub(super) struct Store {
    manager: BDDManagerRef,
    sink: Arc<dyn ProgressSink>,
    capacity: u64,
    cache_entries: u64,
    collect_at: AtomicUsize,
    peak: AtomicUsize,
    /// All lists of relations.
    pub(super) lists: Lists,
    pub(super) work: Work,
    /// Flags for the forward and the backward direction: fixpoints try saturation first.
    pub(super) saturates: [AtomicBool; 2],
    thresholds: Thresholds,
    /// The bytes of stack that a recursion needs.
    stack: usize,
    zero: Bdd,
    one: Bdd,
}

impl Store {
    /// Creates a store for `width` bits; the two copies of each are on adjacent levels. A small
    /// table gets fewer threads than the settings allow.
    ///
    /// # Errors
    /// The memory of the settings is too small for an empty table, or the system does not grant the
    /// memory or the threads.
    pub(super) fn new(width: usize, settings: &Settings) -> Result<Self> {
        let entries = settings.thresholds.first_cache.min(cache_for_bits(width));
        Store::sized(width, settings, entries)
    }

    /// Creates a store whose operation cache has `entries` entries, or fewer if the memory is
    /// small.
    fn sized(width: usize, settings: &Settings, entries: u64) -> Result<Self> {
        let Settings { memory, threads, thresholds, .. } = *settings;
        let cache_entries = cache_entries(memory, entries);
        let left = memory.saturating_sub(cache_entries * BYTES_PER_ENTRY);
        let capacity = (left / BYTES_PER_NODE).min(MOST_NODES);
        if capacity < 2 * width as u64 + 16 {
            let what = format!("{memory} bytes are too few for a node table over {width} bits");
            return Err(Limit::Memory { what }.into());
        }
        let threads = u64::from(threads).min(capacity / NODES_PER_THREAD).max(1) as u32;
        let manager = manager(capacity, cache_entries, threads)?;
        let (zero, one) = manager.with_manager_exclusive(|m| {
            m.add_vars(2 * width as u32);
            (Bdd::f(m), Bdd::t(m))
        });
        let collect_at = thresholds.first_collection.min(capacity as usize / 2);
        let (collect_at, peak) = (AtomicUsize::new(collect_at), AtomicUsize::new(0));
        let (lists, sink) = (Lists::default(), settings.sink.clone());
        Ok(Store {
            work: Work::default(),
            saturates: Default::default(),
            manager,
            sink,
            capacity,
            cache_entries,
            collect_at,
            peak,
            lists,
            thresholds,
            stack: (width + 64) * STACK_PER_BIT,
            zero,
            one,
        })
    }

    /// Returns the number of bits of a state.
    fn width(&self) -> usize {
        self.shared(|m| m.num_levels() as usize / 2)
    }

    /// Returns false.
    pub(super) fn zero(&self) -> Bdd {
        self.zero.clone()
    }

    /// Returns true.
    pub(super) fn one(&self) -> Bdd {
        self.one.clone()
    }

    /// Returns the literal of the variable on `level`, positive or negative.
    pub(super) fn literal(&self, level: u32, positive: bool) -> Result<Bdd> {
        self.run(|| {
            self.manager
                .with_manager_shared(|m| if positive { Bdd::var(m, level) } else { Bdd::not_var(m, level) })
        })
    }

    /// Computes f ∧ g.
    pub(super) fn and(&self, f: &Bdd, g: &Bdd) -> Result<Bdd> {
        self.run(|| f.and(g))
    }

    /// Computes f ∨ g.
    pub(super) fn or(&self, f: &Bdd, g: &Bdd) -> Result<Bdd> {
        self.run(|| f.or(g))
    }

    /// Computes ¬f.
    pub(super) fn not(&self, f: &Bdd) -> Result<Bdd> {
        self.run(|| f.not())
    }

    /// Computes f ⊕ g.
    pub(super) fn xor(&self, f: &Bdd, g: &Bdd) -> Result<Bdd> {
        self.run(|| f.xor(g))
    }

    /// Computes f ↔ g.
    pub(super) fn iff(&self, f: &Bdd, g: &Bdd) -> Result<Bdd> {
        self.run(|| f.equiv(g))
    }

    /// Computes f ∧ ¬g.
    pub(super) fn minus(&self, f: &Bdd, g: &Bdd) -> Result<Bdd> {
        self.run(|| g.imp_strict(f))
    }

    /// Computes: if c then f else g.
    pub(super) fn ite(&self, c: &Bdd, f: &Bdd, g: &Bdd) -> Result<Bdd> {
        self.run(|| c.ite(f, g))
    }

    /// Computes the disjunction of many functions in pairs, so that intermediate results stay
    /// small.
    pub(super) fn any(&self, functions: impl IntoIterator<Item = Bdd>) -> Result<Bdd> {
        let mut round: Vec<Bdd> = functions.into_iter().collect();
        while round.len() > 1 {
            let mut next = Vec::with_capacity(round.len().div_ceil(2));
            for pair in round.chunks(2) {
                next.push(if let [f, g] = pair { self.or(f, g)? } else { pair[0].clone() });
            }
            round = next;
        }
        Ok(round.pop().unwrap_or_else(|| self.zero()))
    }

    /// Computes ∃ V . f, where `variables` is the conjunction of the variables V.
    pub(super) fn exists(&self, f: &Bdd, variables: &Bdd) -> Result<Bdd> {
        self.run(|| f.exists(variables))
    }

    /// Runs `work` on the manager itself.
    pub(super) fn shared<T>(&self, work: impl for<'id> FnOnce(&ManagerOf<'id>) -> T) -> T {
        self.manager.with_manager_shared(work)
    }

    /// Runs a recursion whose depth is the number of bits of a state, with enough stack for it. A
    /// nested call costs nothing, so loops over many operations run inside one call.
    pub(super) fn deep<T>(&self, recursion: impl FnOnce() -> T) -> T {
        stacker::maybe_grow(self.stack, 2 * self.stack, recursion)
    }

    /// Returns the thresholds by which the engine chooses between methods.
    pub(super) fn thresholds(&self) -> &Thresholds {
        &self.thresholds
    }

    /// Returns true if f has at least `many` nodes, constants included. Visits at most `many`
    /// nodes.
    pub(super) fn has_nodes(&self, f: &Bdd, many: usize) -> bool {
        self.shared(|m| {
            let (mut seen, mut stack) = (AHashSet::new(), vec![f.as_edge(m)]);
            while let Some(e) = stack.pop() {
                if seen.len() >= many {
                    break;
                }
                if let (true, Node::Inner(n)) = (seen.insert(e.node_id()), m.get_node(e)) {
                    stack.extend([n.child(0), n.child(1)]);
                }
            }
            seen.len() >= many
        })
    }

    /// Returns true if f has fewer nodes than g.
    pub(super) fn is_smaller(&self, f: &Bdd, g: &Bdd) -> bool {
        !self.has_nodes(f, self.size(g) + 2)
    }

    /// Returns true if f is a diagram of this store.
    pub(super) fn owns(&self, f: &Bdd) -> bool {
        f.manager_ref() == self.manager
    }

    /// Returns true if f is the constant false.
    pub(super) fn is_zero(&self, f: &Bdd) -> bool {
        *f == self.zero
    }

    /// Returns the number of satisfying assignments to the variables, without `unused` of them on
    /// which f does not depend.
    pub(super) fn count(&self, f: &Bdd, unused: u32) -> Result<Count> {
        self.safe_point()?;
        let variables = self.manager.with_manager_shared(|m| m.num_levels());
        let mut cache: SatCountCache<Natural, std::hash::BuildHasherDefault<FxHasher>> =
            SatCountCache::default();
        let all = self.deep(|| f.sat_count(variables, &mut cache));
        Ok(to_biguint(&all) >> unused)
    }

    /// Returns the number of inner nodes of f.
    pub(super) fn size(&self, f: &Bdd) -> usize {
        self.deep(|| f.node_count()).saturating_sub(2)
    }

    /// Returns the resources used so far.
    pub(super) fn usage(&self) -> Usage {
        self.note_peak();
        let peak = self.peak.load(Relaxed) as u64;
        Usage { peak_nodes: peak, bytes: peak * BYTES_PER_NODE + self.cache_entries * BYTES_PER_ENTRY }
    }

    /// Runs an operation that may find the node table full.
    fn run(&self, operation: impl Fn() -> AllocResult<Bdd>) -> Result<Bdd> {
        self.safe_point()?;
        if let Ok(f) = self.deep(&operation) {
            return Ok(f);
        }
        self.shared(|m| self.collect_in(m));
        self.deep(operation).map_err(|_| self.full())
    }

    /// Returns the error for a table that is full even after a collection.
    pub(super) fn full(&self) -> Error {
        let what = format!("the node table of {} nodes is full", self.capacity);
        Limit::Memory { what }.into()
    }

    pub(super) fn safe_point(&self) -> Result<()> {
        self.shared(|m| self.safe_point_in(m))
    }

    /// Lets the progress sink cancel the work, and collects garbage if enough has gathered.
    pub(super) fn safe_point_in(&self, m: &ManagerOf<'_>) -> Result<()> {
        if let Some(limit) = self.sink.stop() {
            return Err(limit.into());
        }
        if m.approx_num_inner_nodes() >= self.collect_at.load(Relaxed) {
            self.collect_in(m);
        }
        Ok(())
    }

    /// Reports the current phase to the progress sink.
    pub(super) fn progress(&self, phase: &'static str) {
        self.sink.progress(phase, &|| format!("{} nodes in the table", self.nodes()));
    }

    pub(super) fn collect_in(&self, m: &ManagerOf<'_>) {
        self.note_peak();
        m.gc();
        let live = m.num_inner_nodes();
        // Collect again at twice the live nodes (at least the threshold); earlier if room is short.
        let next = (2 * live).max(self.thresholds.first_collection);
        let room = live + (self.capacity as usize).saturating_sub(live) / 2;
        self.collect_at.store(next.min(room.max(1)), Relaxed);
    }

    fn nodes(&self) -> usize {
        self.shared(|m| m.approx_num_inner_nodes())
    }

    fn note_peak(&self) {
        self.peak.fetch_max(self.nodes(), Relaxed);
    }
}

/// Computes `mantissa · 2^exp`.
fn to_biguint(n: &Natural) -> BigUint {
    let mut digits = Vec::new();
    for &d in n.mantissa() {
        digits.extend([d as u32, (d >> 32) as u32]);
    }
    BigUint::new(digits) << n.exp()
}
