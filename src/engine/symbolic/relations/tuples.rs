//! The lists of several groups of choices as one operand of a recursion.

use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use ahash::AHashMap;

use super::lists::{ListKind, RelationList};
use crate::symbolic::store::charge::Charge;
use crate::symbolic::store::diagram::Bdd;
use crate::symbolic::store::{Forgets, Store};
use meliora_model::error::Result;

/// The lists of several groups. Equal tuples exist once and have a number.
pub(in crate::symbolic) struct ListTuple {
    /// The key of this tuple in the operation cache.
    pub(in crate::symbolic) number: u32,
    /// The first bit that a list reads or writes; `u32::MAX` if there is none.
    pub(in crate::symbolic) top: u32,
    /// True if a group has a step in every state, and all its steps keep the state.
    pub(in crate::symbolic) stays: bool,
    /// The groups with steps, each once; none if `stays`.
    pub(in crate::symbolic) groups: Vec<Group>,
    /// The states in which some group has a step, once they are known.
    pub(in crate::symbolic) sources: OnceLock<Bdd>,
    halves: OnceLock<[Half; 2]>,
    /// The table of all tuples of the store.
    tuples: Arc<ListTuples>,
    _charge: Charge,
}

/// The steps of one group of choices.
pub(in crate::symbolic) struct Group {
    pub(in crate::symbolic) list: Arc<RelationList>,
    /// The states with a step. Below a bit that no step of the group changes, they are a cofactor,
    /// so they are computed from the relations only once.
    pub(in crate::symbolic) sources: Bdd,
}

/// The lists of a tuple where its first bit has one value before a step.
pub(in crate::symbolic) struct Half {
    /// The groups without steps that change the bit.
    pub(in crate::symbolic) below: Arc<ListTuple>,
    /// The other groups.
    pub(in crate::symbolic) crossing: Vec<Crossing>,
}

/// The steps of one group from one value of a bit.
pub(in crate::symbolic) struct Crossing {
    /// The steps that keep the bit.
    pub(in crate::symbolic) stays: Arc<RelationList>,
    /// The steps that change it.
    pub(in crate::symbolic) crosses: Arc<RelationList>,
    /// The states with a step of either.
    pub(in crate::symbolic) sources: Bdd,
}

impl ListTuple {
    /// Returns the lists by the value of the first bit before a step.
    pub(in crate::symbolic) fn halves(&self, store: &Store) -> Result<&[Half; 2]> {
        if let Some(found) = self.halves.get() {
            return Ok(found);
        }
        let half = |value: bool| {
            let (mut below, mut crossing) = (Vec::new(), Vec::new());
            for Group { list, sources } in &self.groups {
                let stays = list.cofactor(store, self.top, value, value)?;
                let crosses = list.cofactor(store, self.top, value, !value)?;
                let sources = store.cofactor(sources, self.top, value);
                if crosses.is_empty() {
                    below.push(Group { list: stays, sources });
                } else {
                    crossing.push(Crossing { stays, crosses, sources });
                }
            }
            Ok::<_, meliora_model::error::Error>(Half { below: self.tuples.of(store, below)?, crossing })
        };
        let halves = [half(false)?, half(true)?];
        Ok(self.halves.get_or_init(|| halves))
    }

    fn take_tuples_below(&mut self, tuples: &mut Vec<Arc<ListTuple>>) {
        tuples.extend(self.halves.take().into_iter().flatten().map(|half| half.below));
    }
}

impl Drop for ListTuple {
    /// Drops the tuples below in a loop: as a recursion this would be as deep as a state has bits.
    fn drop(&mut self) {
        let mut open = Vec::new();
        self.take_tuples_below(&mut open);
        while let Some(tuple) = open.pop() {
            if let Some(mut last) = Arc::into_inner(tuple) {
                last.take_tuples_below(&mut open);
            }
        }
    }
}

/// The tuples of one store, by the numbers of their lists.
#[derive(Default)]
pub(in crate::symbolic) struct ListTuples {
    known: Mutex<AHashMap<Vec<u32>, Arc<ListTuple>>>,
}

/// Bytes of a tuple without its lists.
const BYTES_PER_TUPLE: usize = size_of::<ListTuple>() + 64;
/// Bytes of a tuple per list: in the tuple, in its name, and split by the first bit.
const BYTES_PER_LIST: usize = size_of::<Group>() + size_of::<u32>() + 2 * size_of::<Crossing>();

impl ListTuples {
    /// Creates the empty table of tuples of a store.
    pub(in crate::symbolic) fn new(store: &Store) -> Arc<Self> {
        let tuples = Arc::new(ListTuples::default());
        store.keep(tuples.clone());
        tuples
    }

    /// Returns the tuple of some lists.
    ///
    /// # Errors
    /// A limit: the memory, or the numbers of tuples.
    pub(in crate::symbolic) fn of_lists(
        self: &Arc<Self>,
        store: &Store,
        lists: &[Arc<RelationList>],
    ) -> Result<Arc<ListTuple>> {
        let groups = lists.iter().map(|l| Ok(Group { list: Arc::clone(l), sources: l.sources(store)? }));
        self.of(store, groups.collect::<Result<_>>()?)
    }

    fn of(self: &Arc<Self>, store: &Store, mut groups: Vec<Group>) -> Result<Arc<ListTuple>> {
        let one = store.one();
        let stays = groups.iter().any(|g| g.list.kind == ListKind::Keeps && g.list.kept() == Some(&one));
        groups.retain(|g| !stays && !g.list.is_empty());
        groups.sort_unstable_by_key(|g| g.list.number);
        groups.dedup_by_key(|g| g.list.number);
        // No list has an odd number.
        let name = if stays { vec![u32::MAX] } else { groups.iter().map(|g| g.list.number).collect() };
        let mut known = self.known();
        if let Some(found) = known.get(&name) {
            return Ok(found.clone());
        }
        if known.len() >= store.thresholds().most_lists {
            known.clear();
        }
        let mut charge = store.charge();
        charge.add(BYTES_PER_TUPLE + BYTES_PER_LIST * groups.len());
        let made = Arc::new(ListTuple {
            number: store.new_key()?,
            top: groups.iter().map(|g| g.list.top).min().unwrap_or(u32::MAX),
            stays,
            groups,
            sources: OnceLock::new(),
            halves: OnceLock::new(),
            tuples: Arc::clone(self),
            _charge: charge,
        });
        known.insert(name, made.clone());
        Ok(made)
    }

    fn known(&self) -> MutexGuard<'_, AHashMap<Vec<u32>, Arc<ListTuple>>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Forgets for ListTuples {
    /// Forgets the names of all tuples. This frees the tuples that are not in use.
    fn forget(&self) {
        self.known().clear();
    }
}
