//! The diagram store: OxiDD's manager, with limits, garbage collection and cancellation.
//!
//! Every operation goes through the store. At its start, and then once in 1,024 steps, it asks the
//! progress sink for cancellation, collects garbage if enough has gathered, and ends if the memory
//! does not suffice (`limits`).
//!
//! `walk` is a recursion over diagrams, `apply` has the Boolean operations as recursions, and
//! `operations` runs them. `diagram` is the one place that reads OxiDD's nodes for recursions.

mod adopt;
mod apply;
pub(in crate::symbolic) mod charge;
pub(in crate::symbolic) mod diagram;
mod limits;
mod operations;
pub(in crate::symbolic) mod tables;
pub(crate) mod thresholds;
pub(in crate::symbolic) mod walk;

use std::sync::atomic::{AtomicU32, AtomicU64, AtomicUsize, Ordering::Relaxed};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use ahash::AHashSet;
use oxidd::bdd::BDDManagerRef;
use oxidd::{BooleanFunction, Function, HasLevel, InnerNode, LevelNo, Manager, ManagerRef, Node};

use crate::settings::{Settings, Usage};
use charge::{Charge, Charges};
use diagram::{Bdd, Diagram, ManagerOf};
use meliora_base::error::{Limit, Result};
use meliora_base::progress::Poll;
use meliora_base::progress::ProgressSink;
use tables::{BYTES_PER_ENTRY, BYTES_PER_NODE, cache_entries, cache_for_bits, manager};
use thresholds::{Leaders, Thresholds, Work};

/// Bytes of stack per bit of a state that a recursion needs, with the recursions of OxiDD inside
/// it.
const STACK_PER_BIT: usize = 4 << 10;
/// Maximum number of nodes, well below the 2^31 at which OxiDD aborts the process.
const MOST_NODES: u64 = 1 << 30;

/// A table of results outside of OxiDD's tables that can be found again.
pub(in crate::symbolic) trait Forgets: Send + Sync {
    /// Empties the table, except for entries in use.
    fn forget(&self);
}

/// The manager of all diagrams of one engine.
pub(in crate::symbolic) struct Store {
    manager: BDDManagerRef,
    sink: Arc<dyn ProgressSink>,
    /// The bytes for nodes and charges.
    memory: AtomicU64,
    /// Maximum number of nodes, if nothing is charged.
    capacity: u64,
    cache_entries: u64,
    collect_at: AtomicUsize,
    /// The number of collections in a row that were futile; locked during a collection.
    futile: Mutex<u32>,
    peak: AtomicUsize,
    /// The largest number of nodes in the stores that this one replaced.
    replaced_peak: usize,
    /// The memory outside of OxiDD's tables.
    pub(in crate::symbolic) charges: Arc<Charges>,
    /// The next key of a table's entry in the operation cache.
    pub(in crate::symbolic) next_key: AtomicU32,
    /// The tables that are emptied when memory is short.
    tables: Mutex<Vec<Arc<dyn Forgets>>>,
    pub(in crate::symbolic) work: Work,
    /// The methods that lead each kind of fixpoint.
    pub(in crate::symbolic) leaders: Leaders,
    thresholds: Thresholds,
    /// The bytes of stack that a recursion needs.
    stack: usize,
    zero: Bdd,
    one: Bdd,
}

impl Store {
    /// Creates a store for `width` bits; the two copies of each are on adjacent levels.
    ///
    /// # Errors
    /// The memory of the settings is too small for an empty table, or the system does not grant the
    /// memory or the threads.
    pub(in crate::symbolic) fn new(width: usize, settings: &Settings) -> Result<Self> {
        let entries = settings.thresholds.cache.min(cache_for_bits(width));
        Store::sized(width, settings, entries)
    }

    /// Creates a store whose operation cache has `entries` entries, or fewer if the memory is
    /// small.
    fn sized(width: usize, settings: &Settings, entries: u64) -> Result<Self> {
        let Settings { memory, thresholds, .. } = *settings;
        let cache_entries = cache_entries(memory, entries);
        let memory = memory.saturating_sub(cache_entries * BYTES_PER_ENTRY);
        let capacity = (memory / BYTES_PER_NODE).min(MOST_NODES);
        if capacity < 2 * width as u64 + 16 {
            let what = format!("{} bytes are too few for a node table over {width} bits", settings.memory);
            return Err(Limit::Memory { what }.into());
        }
        let manager = manager(capacity, cache_entries)?;
        let (zero, one) = manager.with_manager_exclusive(|m| {
            m.add_vars(2 * width as u32);
            (Bdd::f(m), Bdd::t(m))
        });
        let collect_at = thresholds.first_collection.min(capacity as usize / 2);
        Ok(Store {
            work: Work::default(),
            leaders: Leaders::default(),
            manager,
            sink: settings.sink.clone(),
            memory: memory.into(),
            capacity,
            cache_entries,
            collect_at: AtomicUsize::new(collect_at),
            futile: Mutex::default(),
            peak: AtomicUsize::new(0),
            replaced_peak: 0,
            charges: Arc::default(),
            next_key: AtomicU32::new(0),
            tables: Mutex::default(),
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
    pub(in crate::symbolic) fn zero(&self) -> Bdd {
        self.zero.clone()
    }

    /// Returns true.
    pub(in crate::symbolic) fn one(&self) -> Bdd {
        self.one.clone()
    }

    /// Keeps a table until this store is dropped, and empties it when memory is short.
    pub(in crate::symbolic) fn keep(&self, table: Arc<dyn Forgets>) {
        self.tables().push(table);
    }

    /// Returns an even number by which results are stored in the operation cache, different from all
    /// before.
    ///
    /// # Errors
    /// All numbers are used. The cache and values in use would confuse two with the same number.
    pub(in crate::symbolic) fn new_key(&self) -> Result<u32> {
        let next = |key: u32| key.checked_add(2);
        self.next_key.fetch_update(Relaxed, Relaxed, next).map_err(|_| {
            let what = format!("the work needs more than {} relation lists", u32::MAX / 2);
            Limit::Size { what }.into()
        })
    }

    fn tables(&self) -> MutexGuard<'_, Vec<Arc<dyn Forgets>>> {
        self.tables.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Empties the tables.
    fn forget(&self) {
        self.tables().iter().for_each(|table| table.forget());
    }

    /// Runs `work` on the manager itself.
    pub(in crate::symbolic) fn shared<T>(&self, work: impl for<'id> FnOnce(&ManagerOf<'id>) -> T) -> T {
        self.manager.with_manager_shared(work)
    }

    /// Runs a recursion whose depth is the number of bits of a state, with enough stack for it. A
    /// nested call costs nothing, so loops over many operations run inside one call.
    pub(in crate::symbolic) fn deep<T>(&self, recursion: impl FnOnce() -> T) -> T {
        stacker::maybe_grow(self.stack, 2 * self.stack, recursion)
    }

    /// Returns the thresholds by which the engine chooses between methods.
    pub(in crate::symbolic) fn thresholds(&self) -> &Thresholds {
        &self.thresholds
    }

    /// Returns true if f has at least `many` nodes, constants included. Visits at most `many`
    /// nodes.
    pub(in crate::symbolic) fn has_nodes(&self, f: &Bdd, many: usize) -> Result<bool> {
        Ok(self.visit(f, many)? >= many)
    }

    /// Returns true if f has fewer nodes than g.
    pub(in crate::symbolic) fn is_smaller(&self, f: &Bdd, g: &Bdd) -> Result<bool> {
        Ok(!self.has_nodes(f, self.visit(g, usize::MAX)?)?)
    }

    /// Returns the value of f for the bits of a state by level. Cost: the length of one path.
    pub(in crate::symbolic) fn holds(&self, f: &Bdd, bit: impl Fn(LevelNo) -> bool) -> bool {
        self.shared(|m| {
            let mut e = f.as_edge(m);
            while let Node::Inner(n) = m.get_node(e) {
                e = n.child(usize::from(!bit(n.level())));
            }
            m.value_of(e) == Some(true)
        })
    }

    /// Calls `each` for the assignments of the present bits that satisfy f, until it returns false; bit i
    /// has level 2i. The first level varies slowest. Cost: one step per assignment and bit.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(in crate::symbolic) fn each_assignment(
        &self,
        f: &Bdd,
        bits: usize,
        mut each: impl FnMut(&[bool]) -> bool,
    ) -> Result<()> {
        self.shared(|m| {
            let mut poll = Poll::new(&*self.sink);
            let mut values = vec![false; bits];
            // Entries are cofactors with the number of decided bits and the value of the last one.
            let mut stack = vec![(f.as_edge(m), 0, false)];
            while let Some((e, decided, value)) = stack.pop() {
                poll.step()?;
                if decided > 0 {
                    values[decided - 1] = value;
                }
                let [high, low] = match m.get_node(e) {
                    Node::Inner(n) if n.level() as usize == 2 * decided => [n.child(0), n.child(1)],
                    Node::Terminal(_) if m.value_of(e) == Some(false) => continue,
                    _ => [e, e],
                };
                if decided == bits {
                    if !each(&values) {
                        break;
                    }
                } else {
                    stack.extend([(high, decided + 1, true), (low, decided + 1, false)]);
                }
            }
            Ok(())
        })
    }

    /// Visits the nodes of f, constants included, until `most` have been met. Returns their number.
    fn visit(&self, f: &Bdd, most: usize) -> Result<usize> {
        self.shared(|m| {
            let (mut seen, mut stack) = (AHashSet::new(), vec![f.as_edge(m)]);
            let mut poll = Poll::new(&*self.sink);
            while let Some(e) = stack.pop() {
                if seen.len() >= most {
                    break;
                }
                if let (true, Node::Inner(n)) = (seen.insert(e.node_id()), m.get_node(e)) {
                    poll.step()?;
                    stack.extend([n.child(0), n.child(1)]);
                }
            }
            Ok(seen.len())
        })
    }

    /// Returns true if f is a diagram of this store.
    pub(in crate::symbolic) fn owns(&self, f: &Bdd) -> bool {
        f.manager_ref() == self.manager
    }

    /// Returns true if f is the constant false.
    pub(in crate::symbolic) fn is_zero(&self, f: &Bdd) -> bool {
        *f == self.zero
    }

    /// Returns the number of nodes of f, constants not included.
    pub(in crate::symbolic) fn size(&self, f: &Bdd) -> Result<usize> {
        let constants = if *f == self.zero || *f == self.one { 1 } else { 2 };
        Ok(self.visit(f, usize::MAX)? - constants)
    }

    /// Returns the resources used so far.
    pub(in crate::symbolic) fn usage(&self) -> Usage {
        self.note_peak(self.nodes());
        let peak = self.peak.load(Relaxed).max(self.replaced_peak) as u64;
        // The largest numbers of nodes and of charged bytes may be of different times.
        let used = (peak * BYTES_PER_NODE + self.charges.peak()).min(self.memory.load(Relaxed));
        let bytes = used + self.cache_entries * BYTES_PER_ENTRY;
        Usage { peak_nodes: peak, bytes, steps: self.work.steps.load(Relaxed) }
    }

    /// Returns a charge for memory outside of OxiDD's tables.
    pub(in crate::symbolic) fn charge(&self) -> Charge {
        Charge::new(&self.charges)
    }

    /// Tells the progress sink of some steps.
    fn advance(&self, steps: u64) {
        self.sink.advance(steps);
    }

    /// Reports the current phase to the progress sink.
    pub(in crate::symbolic) fn progress(&self, phase: &'static str) {
        self.sink.progress(phase, &|| format!("{} nodes in the table", self.nodes()));
    }

    fn nodes(&self) -> usize {
        self.shared(|m| m.approx_num_inner_nodes())
    }
}

impl Drop for Store {
    /// Entries of a table may refer to the table, so it is emptied.
    fn drop(&mut self) {
        self.forget();
    }
}
