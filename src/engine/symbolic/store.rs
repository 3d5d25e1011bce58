//! The diagram store: OxiDD's manager, with limits, collection of garbage and interruption.
//!
//! Every operation goes through here. It first gives the observer the chance to stop the work and
//! collects garbage when enough has gathered; when the node table is full it collects and tries
//! once more.

use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::sync::{Arc, Mutex, PoisonError};

use num_bigint::BigUint;
use oxidd::bdd::{BDDFunction, BDDManagerRef};
use oxidd::util::num::Natural;
use oxidd::util::{AllocResult, FxHasher, SatCountCache};
use oxidd::{BooleanFunction, BooleanFunctionQuant, Function, Manager, ManagerRef};

use super::relational::{self, Operator, Touched};
use crate::engine::{Count, Observer, Usage};
use crate::error::{Limit, Result};

/// A Boolean function of the bits of the present and the next state.
pub(super) type Bdd = BDDFunction;

/// What a node takes in the table and in its index.
const BYTES_PER_NODE: u64 = 32;
/// What an entry of the operation cache takes.
const BYTES_PER_ENTRY: u64 = 20;
/// OxiDD aborts the process at 2^31 nodes: stay well below.
const MOST_NODES: u64 = 1 << 30;
/// OxiDD hands nodes to its threads in blocks of 2^16, and what one thread holds no other can use:
/// a thread is worth having where it gets four blocks.
const NODES_PER_THREAD: u64 = 4 << 16;
/// Below this many nodes, garbage is not worth collecting.
const FIRST_COLLECTION: usize = 4_000_000;

/// The manager of all diagrams of one engine.
pub(super) struct Store {
    manager: BDDManagerRef,
    observer: Arc<dyn Observer>,
    capacity: u64,
    cache_entries: u64,
    collect_at: AtomicUsize,
    peak: AtomicUsize,
    /// The touched sets that have an operator of the operation cache, by their numbers.
    operators: Mutex<Vec<u32>>,
    zero: Bdd,
    one: Bdd,
}

impl Store {
    /// A store for `width` bits: each and its next copy on adjacent levels. A small table is worked
    /// on by fewer threads than `threads`.
    ///
    /// # Errors
    /// `memory` bytes are too few for an empty table, or the system does not give them or the threads.
    pub(super) fn new(width: usize, memory: u64, threads: u32, observer: Arc<dyn Observer>) -> Result<Self> {
        let cache_entries = cache_entries(memory);
        let left = memory.saturating_sub(cache_entries * BYTES_PER_ENTRY);
        let capacity = (left / BYTES_PER_NODE).min(MOST_NODES);
        if capacity < 2 * width as u64 + 16 {
            let what = format!("{memory} bytes hold no node table for {width} bits");
            return Err(Limit::Memory { what }.into());
        }
        let threads = u64::from(threads).min(capacity / NODES_PER_THREAD).max(1) as u32;
        let manager = manager(capacity, cache_entries, threads)?;
        let (zero, one) = manager.with_manager_exclusive(|m| {
            m.add_vars(2 * width as u32);
            (Bdd::f(m), Bdd::t(m))
        });
        let collect_at = FIRST_COLLECTION.min(capacity as usize / 2);
        let (collect_at, peak) = (AtomicUsize::new(collect_at), AtomicUsize::new(0));
        let operators = Mutex::default();
        Ok(Store { manager, observer, capacity, cache_entries, collect_at, peak, operators, zero, one })
    }

    /// false
    pub(super) fn zero(&self) -> Bdd {
        self.zero.clone()
    }

    /// true
    pub(super) fn one(&self) -> Bdd {
        self.one.clone()
    }

    /// The literal of the variable on `level`, positive or negative.
    pub(super) fn literal(&self, level: u32, positive: bool) -> Result<Bdd> {
        self.run(|| {
            self.manager
                .with_manager_shared(|m| if positive { Bdd::var(m, level) } else { Bdd::not_var(m, level) })
        })
    }

    /// f ∧ g
    pub(super) fn and(&self, f: &Bdd, g: &Bdd) -> Result<Bdd> {
        self.run(|| f.and(g))
    }

    /// f ∨ g
    pub(super) fn or(&self, f: &Bdd, g: &Bdd) -> Result<Bdd> {
        self.run(|| f.or(g))
    }

    /// ¬f
    pub(super) fn not(&self, f: &Bdd) -> Result<Bdd> {
        self.run(|| f.not())
    }

    /// f ⊕ g
    pub(super) fn xor(&self, f: &Bdd, g: &Bdd) -> Result<Bdd> {
        self.run(|| f.xor(g))
    }

    /// f ↔ g
    pub(super) fn iff(&self, f: &Bdd, g: &Bdd) -> Result<Bdd> {
        self.run(|| f.equiv(g))
    }

    /// f ∧ ¬g
    pub(super) fn minus(&self, f: &Bdd, g: &Bdd) -> Result<Bdd> {
        self.run(|| g.imp_strict(f))
    }

    /// if c then f else g
    pub(super) fn ite(&self, c: &Bdd, f: &Bdd, g: &Bdd) -> Result<Bdd> {
        self.run(|| c.ite(f, g))
    }

    /// The disjunction of many functions, pairwise, so that intermediate results stay small.
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

    /// ∃ the variables of a conjunction . f
    pub(super) fn exists(&self, f: &Bdd, variables: &Bdd) -> Result<Bdd> {
        self.run(|| f.exists(variables))
    }

    /// ∃ x' . R(x, x') ∧ X(x'), where the variables outside `touched` do not change.
    pub(super) fn pre(&self, relation: &Bdd, touched: &Touched, x: &Bdd) -> Result<Bdd> {
        self.run(|| relational::pre(&self.manager, relation, touched, x))
    }

    /// B(x) ∧ ∃ x' . R(x, x') ∧ X(x'), where the variables outside `touched` do not change.
    pub(super) fn pre_within(&self, relation: &Bdd, touched: &Touched, x: &Bdd, bound: &Bdd) -> Result<Bdd> {
        let Some(operator) = self.operator(touched) else {
            return self.and(&self.pre(relation, touched, x)?, bound);
        };
        self.run(|| relational::pre_within(&self.manager, (relation, touched, operator), x, bound))
    }

    /// ∃ x . R(x, x') ∧ X(x), read over x, where the variables outside `touched` do not change.
    pub(super) fn image(&self, relation: &Bdd, touched: &Touched, x: &Bdd) -> Result<Bdd> {
        self.run(|| relational::image(&self.manager, relation, touched, x))
    }

    /// X over the next state: the touched variables primed.
    pub(super) fn primed(&self, touched: &Touched, x: &Bdd) -> Result<Bdd> {
        self.run(|| relational::primed(&self.manager, touched, x))
    }

    /// The first bit that f depends on; `u32::MAX` for a constant.
    pub(super) fn top(&self, f: &Bdd) -> u32 {
        relational::top(&self.manager, f)
    }

    /// Whether f has at least so many nodes.
    pub(super) fn has_nodes(&self, f: &Bdd, many: usize) -> bool {
        relational::has_nodes(&self.manager, f, many)
    }

    /// Whether f has fewer nodes than g.
    pub(super) fn is_smaller(&self, f: &Bdd, g: &Bdd) -> bool {
        !self.has_nodes(f, g.node_count())
    }

    /// f with `bit` set and with `bit` clear, where f depends on no earlier bit.
    pub(super) fn split(&self, f: &Bdd, bit: u32) -> (Bdd, Bdd) {
        relational::split(&self.manager, f, bit)
    }

    /// if `bit` then t else e, where t and e depend on later bits only.
    pub(super) fn node(&self, bit: u32, t: &Bdd, e: &Bdd) -> Result<Bdd> {
        self.run(|| relational::node(&self.manager, bit, t, e))
    }

    /// What was remembered for two functions under a number.
    pub(super) fn recall(&self, f: &Bdd, g: &Bdd, number: u32) -> Option<Bdd> {
        relational::recall(&self.manager, f, g, number)
    }

    /// Remembers a result for two functions under a number, for a while.
    pub(super) fn remember(&self, f: &Bdd, g: &Bdd, number: u32, result: &Bdd) {
        relational::remember(&self.manager, f, g, number, result);
    }

    /// f = false
    pub(super) fn is_zero(&self, f: &Bdd) -> bool {
        *f == self.zero
    }

    /// The number of assignments to all variables but `unused` of them, on which f does not depend.
    pub(super) fn count(&self, f: &Bdd, unused: u32) -> Result<Count> {
        self.safe_point()?;
        let variables = self.manager.with_manager_shared(|m| m.num_levels());
        let mut cache: SatCountCache<Natural, std::hash::BuildHasherDefault<FxHasher>> =
            SatCountCache::default();
        let all = f.sat_count(variables, &mut cache);
        Ok(to_biguint(&all) >> unused)
    }

    /// How many inner nodes f has.
    pub(super) fn size(&self, f: &Bdd) -> usize {
        f.node_count().saturating_sub(2)
    }

    /// What was used so far.
    pub(super) fn usage(&self) -> Usage {
        self.note_peak();
        let peak = self.peak.load(Relaxed) as u64;
        Usage { peak_nodes: peak, bytes: peak * BYTES_PER_NODE + self.cache_entries * BYTES_PER_ENTRY }
    }

    /// Which operator of the operation cache stands for a touched set; `None` when all are given away.
    fn operator(&self, touched: &Touched) -> Option<Operator> {
        let mut known = self.operators.lock().unwrap_or_else(PoisonError::into_inner);
        let index = known.iter().position(|&id| id == touched.id()).unwrap_or(known.len());
        let operator = Operator::nth(index)?;
        if index == known.len() {
            known.push(touched.id());
        }
        Some(operator)
    }

    /// Runs an operation that may find the node table full.
    fn run(&self, operation: impl Fn() -> AllocResult<Bdd>) -> Result<Bdd> {
        self.safe_point()?;
        if let Ok(f) = operation() {
            return Ok(f);
        }
        self.collect();
        operation().map_err(|_| {
            let what = format!("the node table of {} nodes is full", self.capacity);
            Limit::Memory { what }.into()
        })
    }

    /// Lets the observer stop the work and collects garbage when there is much of it.
    fn safe_point(&self) -> Result<()> {
        if let Some(limit) = self.observer.stop() {
            return Err(limit.into());
        }
        let nodes = self.nodes();
        if nodes >= self.collect_at.load(Relaxed) {
            self.collect();
        }
        Ok(())
    }

    fn collect(&self) {
        self.note_peak();
        let live = self.manager.with_manager_shared(|m| {
            m.gc();
            m.num_inner_nodes()
        });
        // Collect again when as much has gathered as is alive now, but while there is still room.
        let next = (2 * live).max(FIRST_COLLECTION);
        let room = live + (self.capacity as usize).saturating_sub(live) / 2;
        self.collect_at.store(next.min(room.max(1)), Relaxed);
    }

    fn nodes(&self) -> usize {
        self.manager.with_manager_shared(|m| m.approx_num_inner_nodes())
    }

    fn note_peak(&self) {
        self.peak.fetch_max(self.nodes(), Relaxed);
    }
}

/// A manager, if the system gives its memory and its threads.
///
/// OxiDD takes both for granted: without the memory it aborts the process, without the threads, each
/// with a stack of 1 GiB, it panics. So the memory is asked for and given back first, and that panic,
/// which comes before there are any diagrams, is caught.
fn manager(capacity: u64, cache_entries: u64, threads: u32) -> Result<BDDManagerRef> {
    let bytes = capacity * BYTES_PER_NODE + cache_entries * BYTES_PER_ENTRY;
    if Vec::<u8>::new().try_reserve_exact(usize::try_from(bytes).unwrap_or(usize::MAX)).is_err() {
        let mib = bytes.div_ceil(1 << 20);
        let what = format!("a node table of {mib} MiB: a smaller `--memory`, or a larger `ulimit -v`, helps");
        return Err(Limit::System { what }.into());
    }
    let make = || oxidd::bdd::new_manager(capacity as usize, cache_entries as usize, threads);
    std::panic::catch_unwind(make).map_err(|_| {
        let what = format!(
            "the threads of the node table ({threads}, with a stack of 1 GiB each): a larger `ulimit -v` helps"
        );
        Limit::System { what }.into()
    })
}

/// An eighth of the memory, between 2^10 and 2^20 entries.
fn cache_entries(memory: u64) -> u64 {
    let wanted = (memory / 8 / BYTES_PER_ENTRY).max(1);
    (1u64 << wanted.ilog2()).clamp(1 << 10, 1 << 20)
}

/// `mantissa · 2^exp`
fn to_biguint(n: &Natural) -> BigUint {
    let mut digits = Vec::new();
    for &d in n.mantissa() {
        digits.extend([d as u32, (d >> 32) as u32]);
    }
    BigUint::new(digits) << n.exp()
}
