//! The diagram store: OxiDD's manager, with limits, garbage collection and cancellation.
//!
//! Every operation goes through the store. At its start, and then once in 1,024 steps, it asks the
//! progress sink for cancellation, collects garbage if enough has gathered, and ends if the memory
//! does not suffice (`limits`).
//!
//! The store owns the lists of relations, because their numbers are keys of its operation cache.
//! Lists consist of partial relations, whose diagrams the store makes. Therefore `store`,
//! `relation_lists` and `partial_relation` import each other.

mod adopt;
mod limits;

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};
use std::sync::{Arc, Mutex};

use ahash::AHashSet;
use num_bigint::BigUint;
use oxidd::bdd::BDDManagerRef;
use oxidd::util::num::Natural;
use oxidd::{BooleanFunction, Function, HasLevel, InnerNode, LevelNo, Manager, ManagerRef, Node};

use super::charge::{Charge, Charges};
use super::diagram::{Bdd, Diagram, ManagerOf};
use super::relation_lists::Lists;
use super::tables::{BYTES_PER_ENTRY, BYTES_PER_NODE, cache_entries, cache_for_bits, manager};
use super::thresholds::{Thresholds, Work};
use super::walk::Direction;
use crate::{Count, ProgressSink, Settings, Usage};
use meliora_model::error::{Limit, Result};
use meliora_model::progress::Poll;

/// Bytes of stack per bit of a state that a recursion needs, with the recursions of OxiDD inside
/// it.
const STACK_PER_BIT: usize = 4 << 10;
/// Maximum number of nodes, well below the 2^31 at which OxiDD aborts the process.
const MOST_NODES: u64 = 1 << 30;

/// The manager of all diagrams of one engine.
pub(super) struct Store {
    manager: BDDManagerRef,
    sink: Arc<dyn ProgressSink>,
    /// The bytes for nodes and charges.
    memory: u64,
    /// Maximum number of nodes, if nothing is charged.
    capacity: u64,
    cache_entries: u64,
    collect_at: AtomicUsize,
    /// The number of collections in a row that were futile; locked during a collection.
    futile: Mutex<u32>,
    peak: AtomicUsize,
    /// The largest number of nodes in the stores that this one replaced.
    replaced_peak: usize,
    /// The memory of this store and, if it has workers or is one, of the others.
    pub(super) charges: Arc<Charges>,
    /// The operation cache, if this is the store of a worker.
    cache: Option<Charge>,
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
    /// Creates a store for `width` bits; the two copies of each are on adjacent levels.
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
            saturates: Default::default(),
            manager,
            sink: settings.sink.clone(),
            memory,
            capacity,
            cache_entries,
            collect_at: AtomicUsize::new(collect_at),
            futile: Mutex::default(),
            peak: AtomicUsize::new(0),
            replaced_peak: 0,
            charges: Arc::default(),
            cache: None,
            lists: Lists::new(u32::MAX),
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
        self.make(|w| {
            w.tick()?;
            w.node_on(level, w.m.constant(positive), w.m.constant(!positive))
        })
    }

    /// Computes f ∧ g.
    pub(super) fn and(&self, f: &Bdd, g: &Bdd) -> Result<Bdd> {
        self.make(|w| w.and(f.as_edge(w.m), g.as_edge(w.m)))
    }

    /// Computes f ∨ g.
    pub(super) fn or(&self, f: &Bdd, g: &Bdd) -> Result<Bdd> {
        self.make(|w| w.or(f.as_edge(w.m), g.as_edge(w.m)))
    }

    /// Computes ¬f.
    pub(super) fn not(&self, f: &Bdd) -> Result<Bdd> {
        self.make(|w| w.not(f.as_edge(w.m)))
    }

    /// Computes f ⊕ g.
    pub(super) fn xor(&self, f: &Bdd, g: &Bdd) -> Result<Bdd> {
        self.make(|w| w.xor(f.as_edge(w.m), g.as_edge(w.m)))
    }

    /// Computes f ↔ g.
    pub(super) fn iff(&self, f: &Bdd, g: &Bdd) -> Result<Bdd> {
        self.make(|w| w.iff(f.as_edge(w.m), g.as_edge(w.m)))
    }

    /// Computes f ∧ ¬g.
    pub(super) fn minus(&self, f: &Bdd, g: &Bdd) -> Result<Bdd> {
        self.make(|w| w.minus(f.as_edge(w.m), g.as_edge(w.m)))
    }

    /// Computes: if c then f else g.
    pub(super) fn ite(&self, c: &Bdd, f: &Bdd, g: &Bdd) -> Result<Bdd> {
        self.make(|w| w.ite(c.as_edge(w.m), f.as_edge(w.m), g.as_edge(w.m)))
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
        self.make(|w| w.exists(f.as_edge(w.m), variables.as_edge(w.m)))
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
    ///
    /// # Errors
    /// A limit.
    pub(super) fn has_nodes(&self, f: &Bdd, many: usize) -> Result<bool> {
        Ok(self.visit(f, many)? >= many)
    }

    /// Returns true if f has fewer nodes than g.
    ///
    /// # Errors
    /// A limit.
    pub(super) fn is_smaller(&self, f: &Bdd, g: &Bdd) -> Result<bool> {
        Ok(!self.has_nodes(f, self.visit(g, usize::MAX)?)?)
    }

    /// Returns the value of f for the bits of a state by level. Cost: the length of one path.
    pub(super) fn holds(&self, f: &Bdd, bit: impl Fn(LevelNo) -> bool) -> bool {
        self.shared(|m| {
            let mut e = f.as_edge(m);
            while let Node::Inner(n) = m.get_node(e) {
                e = n.child(usize::from(!bit(n.level())));
            }
            m.value_of(e) == Some(true)
        })
    }

    /// Calls `each` for the assignments of the present bits that satisfy f; bit i has level 2i. The
    /// first level varies slowest. Cost: one step per assignment and bit.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(super) fn each_assignment(&self, f: &Bdd, bits: usize, mut each: impl FnMut(&[bool])) -> Result<()> {
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
                    each(&values);
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
        self.count_common(f, &self.one, unused)
    }

    /// Returns the number of satisfying assignments of f ∧ g to the variables, without `unused` of
    /// them on which neither depends.
    pub(super) fn count_common(&self, f: &Bdd, g: &Bdd, unused: u32) -> Result<Count> {
        let how = (Direction::Forward, None);
        let all = self.walk_to_the_end(how, |w| w.count_common(f.as_edge(w.m), g.as_edge(w.m)))?;
        Ok(to_biguint(&all) >> unused)
    }

    /// Returns the number of nodes of f, constants not included.
    ///
    /// # Errors
    /// A limit.
    pub(super) fn size(&self, f: &Bdd) -> Result<usize> {
        let constants = if *f == self.zero || *f == self.one { 1 } else { 2 };
        Ok(self.visit(f, usize::MAX)? - constants)
    }

    /// Returns the resources used so far.
    pub(super) fn usage(&self) -> Usage {
        self.note_peak(self.nodes());
        let peak = self.charges.peak_nodes().max(self.replaced_peak as u64);
        // The largest numbers of nodes and of charged bytes may be of different times.
        let used = (peak * BYTES_PER_NODE + self.charges.peak()).min(self.memory);
        Usage { peak_nodes: peak, bytes: used + self.cache_entries * BYTES_PER_ENTRY }
    }

    /// Returns a charge for memory outside of OxiDD's tables.
    pub(super) fn charge(&self) -> Charge {
        Charge::new(&self.charges)
    }

    /// Reports the current phase to the progress sink.
    pub(super) fn progress(&self, phase: &'static str) {
        self.sink.progress(phase, &|| format!("{} nodes in the table", self.nodes()));
    }

    fn nodes(&self) -> usize {
        self.shared(|m| m.approx_num_inner_nodes())
    }
}

impl Drop for Store {
    fn drop(&mut self) {
        self.charges.release_nodes(self.peak.load(Relaxed));
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
