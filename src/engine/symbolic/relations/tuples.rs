//! The lists of several groups of choices as one operand of a recursion: a chain of links.

use std::sync::{Arc, OnceLock};

use super::chain::{self, Known, Link, Links};
use super::lists::RelationList;
use crate::symbolic::store::charge::Charge;
use crate::symbolic::store::diagram::Bdd;
use crate::symbolic::store::{Forgets, Store};
use meliora_base::error::Result;

/// The lists of several groups. Equal tuples exist once and have a number.
pub(in crate::symbolic) struct ListTuple {
    /// The key of this tuple in the operation cache.
    pub(in crate::symbolic) number: u32,
    /// The first bit that a list reads or writes; `u32::MAX` if there is none.
    pub(in crate::symbolic) top: u32,
    /// True if a group has a step in every state, and all its steps keep the state.
    pub(in crate::symbolic) stays: bool,
    /// The groups with steps that depend on the first bit, each once.
    pub(in crate::symbolic) here: Arc<[Group]>,
    /// The others.
    pub(in crate::symbolic) below: Option<Arc<ListTuple>>,
    /// The states in which some group has a step, once they are known.
    pub(in crate::symbolic) sources: OnceLock<Bdd>,
    halves: OnceLock<[Half; 2]>,
    /// The table of all tuples of the store.
    tuples: Arc<ListTuples>,
    _charge: Charge,
}

/// The steps of one group of choices.
#[derive(Clone)]
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
    /// Returns the groups, in the order of the first bits that their steps depend on.
    pub(in crate::symbolic) fn groups(&self) -> impl Iterator<Item = &Group> {
        let links = std::iter::successors(Some(self), |tuple| tuple.below.as_deref());
        links.flat_map(|tuple| tuple.here.iter())
    }

    /// Returns the lists by the value of the first bit before a step.
    pub(in crate::symbolic) fn halves(&self, store: &Store) -> Result<&[Half; 2]> {
        if let Some(found) = self.halves.get() {
            return Ok(found);
        }
        let half = |value: bool| {
            let (mut below, mut crossing) = (Vec::new(), Vec::new());
            for Group { list, sources } in &*self.here {
                let stays = list.cofactor(store, self.top, value, value)?;
                let crosses = list.cofactor(store, self.top, value, !value)?;
                let sources = store.cofactor(sources, self.top, value);
                if crosses.is_empty() {
                    below.push(Group { list: stays, sources });
                } else {
                    crossing.push(Crossing { stays, crosses, sources });
                }
            }
            let below = self.tuples.inserted(store, below, self.below.clone())?;
            Ok::<_, meliora_base::error::Error>(Half { below, crossing })
        };
        let halves = [half(false)?, half(true)?];
        Ok(self.halves.get_or_init(|| halves))
    }

    fn take_tuples_below(&mut self, tuples: &mut Vec<Arc<ListTuple>>) {
        tuples.extend(self.halves.take().into_iter().flatten().map(|half| half.below));
        tuples.extend(self.below.take());
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

impl Link for ListTuple {
    type Operand = Group;

    fn top(&self) -> u32 {
        self.top
    }

    fn here(&self) -> &Arc<[Group]> {
        &self.here
    }

    fn below(&self) -> Option<&Arc<Self>> {
        self.below.as_ref()
    }
}

impl Group {
    /// Returns whether the group has a step in every state, and all its steps keep the state.
    fn stays(&self, store: &Store) -> bool {
        self.list.kept() == Some(&store.one())
    }
}

/// The tuples of one store, by the numbers of their first lists and of the tuple of the others.
#[derive(Default)]
pub(in crate::symbolic) struct ListTuples {
    known: Known<Name, ListTuple>,
}

type Name = (Vec<u32>, Option<u32>);

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

    fn of(self: &Arc<Self>, store: &Store, groups: Vec<Group>) -> Result<Arc<ListTuple>> {
        self.inserted(store, groups, None)
    }

    /// Returns the tuple of some groups and those of a tuple.
    fn inserted(
        self: &Arc<Self>,
        store: &Store,
        groups: Vec<Group>,
        tuple: Option<Arc<ListTuple>>,
    ) -> Result<Arc<ListTuple>> {
        chain::inserted(&Linked(store, self), groups, tuple)
    }
}

/// The tuples as the links of chains.
struct Linked<'a>(&'a Store, &'a Arc<ListTuples>);

impl Links<ListTuple> for Linked<'_> {
    fn top_of(&self, group: &Group) -> u32 {
        group.list.top
    }

    fn simplified(&self, mut groups: Vec<Group>) -> Result<Vec<Group>> {
        if let Some(stays) = groups.iter().position(|group| group.stays(self.0)) {
            return Ok(vec![groups.swap_remove(stays)]);
        }
        groups.retain(|group| !group.list.is_empty());
        groups.sort_unstable_by_key(|group| group.list.number);
        groups.dedup_by_key(|group| group.list.number);
        Ok(groups)
    }

    /// Returns the link; if a group stays, the link of that group alone.
    fn link(&self, here: Arc<[Group]>, below: Option<Arc<ListTuple>>) -> Result<Arc<ListTuple>> {
        let &Linked(store, tuples) = self;
        if let Some(stays) = below.as_ref().filter(|below| below.stays) {
            return Ok(stays.clone());
        }
        let stays = here.iter().any(|group| group.stays(store));
        let below = below.filter(|_| !stays);
        let numbers = here.iter().map(|group| group.list.number).collect();
        let name = (numbers, below.as_ref().map(|tuple| tuple.number));
        tuples.known.get(name, || {
            let mut charge = store.charge();
            charge.add(BYTES_PER_TUPLE + BYTES_PER_LIST * here.len());
            Ok(ListTuple {
                number: store.new_key()?,
                top: here.first().map_or(u32::MAX, |group| group.list.top),
                stays,
                here,
                below,
                sources: OnceLock::new(),
                halves: OnceLock::new(),
                tuples: Arc::clone(tuples),
                _charge: charge,
            })
        })
    }
}

impl Forgets for ListTuples {
    /// Forgets the names of all tuples. This frees the tuples that are not in use.
    fn forget(&self) {
        self.known.forget();
    }
}
