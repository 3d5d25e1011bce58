//! Lists of partial relations and their cofactors.
//!
//! The recursions of this engine split the diagrams of sets and, at the same time, all relations
//! that act on them. The cofactors of the relations by a bit are a list again. Equal lists exist
//! once and have a number, so that the operation cache can store results per set and list.

use std::iter;
use std::sync::{Arc, OnceLock};

use super::chain::{self, Known, Link, Links};
use super::partial_relation::PartialRelation;
use crate::symbolic::store::charge::Charge;
use crate::symbolic::store::diagram::Bdd;
use crate::symbolic::store::{Forgets, Store};
use meliora_base::error::Result;

/// Bytes of a list without its entries: the list, its reference counts, its name and the overhead
/// of the allocations.
const BYTES_PER_LIST: usize = size_of::<RelationList>() + 64;

/// A union of relations: each step is a step of one of them.
pub(in crate::symbolic) struct RelationList {
    /// The key of this list in the operation cache. Numbers are even; the odd number after it is
    /// the key of the same list in the other direction.
    pub(in crate::symbolic) number: u32,
    /// The first bit that an entry reads or writes; `u32::MAX` if there is none.
    pub(in crate::symbolic) top: u32,
    /// True if the entries of the first link depend on no bit.
    is_constant: bool,
    pub(in crate::symbolic) kind: ListKind,
    cofactors: OnceLock<Cofactors>,
    // Boxed, because few lists need it, and smaller lists lie closer together in memory.
    layers: OnceLock<Box<Layers>>,
    /// The entries that depend on no bit; if there are none, those that depend on the first bit.
    here: Arc<[PartialRelation]>,
    /// The others.
    below: Option<Arc<RelationList>>,
    /// The table of all lists of the store.
    lists: Arc<Lists>,
    _charge: Charge,
}

/// The possible effects of the steps of a list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::symbolic) enum ListKind {
    /// There are no steps.
    Empty,
    /// All steps keep the state; one relation allows them.
    Keeps,
    /// All steps keep the state; several relations allow them.
    KeepsSeverally,
    /// Some steps may change the state.
    Changing,
}

impl ListKind {
    fn new(here: &[PartialRelation], below: Option<&Arc<RelationList>>) -> Self {
        let below = below.map_or(ListKind::Empty, |list| list.kind);
        match (here, below) {
            ([], _) => below,
            _ if below == ListKind::Changing => ListKind::Changing,
            _ if here.iter().any(|e| !e.support.is_empty()) => ListKind::Changing,
            ([_], ListKind::Empty) => ListKind::Keeps,
            _ => ListKind::KeepsSeverally,
        }
    }
}

/// The cofactors of a list by its first bit, indexed by the value of the bit before and after a
/// step.
pub(in crate::symbolic) struct Cofactors([[Arc<RelationList>; 2]; 2]);

impl RelationList {
    fn new(
        store: &Store,
        lists: &Arc<Lists>,
        here: Arc<[PartialRelation]>,
        below: Option<Arc<RelationList>>,
    ) -> Result<Self> {
        let mut charge = store.charge();
        charge.add(BYTES_PER_LIST + size_of_val(&*here));
        let top = here.first().map_or(u32::MAX, |first| store.shared(|m| first.top(m)));
        let is_constant = top == u32::MAX;
        let top = below.as_ref().filter(|_| is_constant).map_or(top, |below| below.top);
        Ok(RelationList {
            is_constant,
            number: store.new_key()?,
            top,
            kind: ListKind::new(&here, below.as_ref()),
            cofactors: OnceLock::new(),
            layers: OnceLock::new(),
            here,
            below,
            lists: Arc::clone(lists),
            _charge: charge,
        })
    }

    /// Returns true if the list has no steps.
    pub(in crate::symbolic) fn is_empty(&self) -> bool {
        self.kind == ListKind::Empty
    }

    /// Returns true if a step may change the state.
    pub(in crate::symbolic) fn changes_state(&self) -> bool {
        self.kind == ListKind::Changing
    }

    /// Returns the cofactors of this list by its first bit.
    pub(in crate::symbolic) fn cofactors(&self, store: &Store) -> Result<&Cofactors> {
        if let Some(found) = self.cofactors.get() {
            return Ok(found);
        }
        let cofactor = |from, to| match &self.below {
            Some(below) if self.is_constant => {
                let here = self.here.iter().filter(|_| from == to).cloned().collect();
                self.lists.inserted(store, here, Some(below.cofactors(store)?.step(from, to).clone()))
            }
            below => {
                let cofactor = |e: &PartialRelation| store.shared(|m| e.below(m, self.top, from, to));
                let rest = below.clone().filter(|_| from == to);
                self.lists.inserted(store, self.here.iter().filter_map(cofactor).collect(), rest)
            }
        };
        let clear = [cofactor(false, false)?, cofactor(false, true)?];
        let set = [cofactor(true, false)?, cofactor(true, true)?];
        Ok(self.cofactors.get_or_init(|| Cofactors([clear, set])))
    }

    /// Returns the number of cofactors of single relations that [`RelationList::cofactors`] has still to make.
    pub(in crate::symbolic) fn missing(&self) -> usize {
        if self.cofactors.get().is_some() {
            return 0;
        }
        let below = self.below.as_ref().filter(|_| self.is_constant);
        4 * self.here.len() + below.map_or(0, |below| below.missing())
    }

    /// Returns the steps of this list on which `bit` has the value `from` before and `to` after. The
    /// list depends on no earlier bit.
    pub(in crate::symbolic) fn cofactor(
        self: &Arc<Self>,
        store: &Store,
        bit: u32,
        from: bool,
        to: bool,
    ) -> Result<Arc<RelationList>> {
        match (self.top == bit, from == to) {
            (true, _) => Ok(self.cofactors(store)?.step(from, to).clone()),
            (false, true) => Ok(self.clone()),
            (false, false) => self.lists.of(store, Vec::new()),
        }
    }

    /// Returns the relations of this list, split by their dependence on its first bit.
    pub(in crate::symbolic) fn layers(&self, store: &Store) -> Result<&Layers> {
        if let Some(found) = self.layers.get() {
            return Ok(found);
        }
        let (constant, first) = match &self.below {
            Some(below) if self.is_constant => (self.here.to_vec(), &**below),
            _ => (Vec::new(), self),
        };
        let below = self.lists.inserted(store, constant, first.below.clone())?;
        let here = first.here.iter().map(|e| self.lists.of(store, vec![e.clone()])).collect::<Result<_>>()?;
        Ok(self.layers.get_or_init(|| Box::new(Layers { below, here })))
    }

    /// Returns the states with a step.
    pub(in crate::symbolic) fn sources(&self, store: &Store) -> Result<Bdd> {
        store.any(self.entries().map(|e| e.sources(store)).collect::<Result<Vec<_>>>()?)
    }

    /// Returns the relations: those that depend on no bit, then the others in the order of the first bits that they
    /// depend on.
    pub(in crate::symbolic) fn entries(&self) -> impl Iterator<Item = &PartialRelation> {
        let links = iter::successors(Some(self), |list| list.below.as_deref());
        links.flat_map(|list| list.here.iter())
    }

    /// Moves the lists that this one keeps alive to `lists`.
    fn take_lists_below(&mut self, lists: &mut Vec<Arc<RelationList>>) {
        lists.extend(self.cofactors.take().into_iter().flat_map(|all| all.0).flatten());
        if let Some(layers) = self.layers.take() {
            lists.extend(layers.here);
            lists.push(layers.below);
        }
        lists.extend(self.below.take());
    }

    /// Returns the states that allow a step, if the list has one relation and all steps keep the
    /// state.
    pub(in crate::symbolic) fn kept(&self) -> Option<&Bdd> {
        self.here.first().filter(|_| self.kind == ListKind::Keeps).map(|e| &e.relation)
    }
}

impl Drop for RelationList {
    /// Drops the lists below in a loop: as a recursion this would be as deep as a state has bits.
    fn drop(&mut self) {
        let mut open = Vec::new();
        self.take_lists_below(&mut open);
        while let Some(list) = open.pop() {
            if let Some(mut last) = Arc::into_inner(list) {
                last.take_lists_below(&mut open);
            }
        }
    }
}

impl Link for RelationList {
    type Operand = PartialRelation;

    fn top(&self) -> u32 {
        if self.is_constant { u32::MAX } else { self.top }
    }

    fn here(&self) -> &Arc<[PartialRelation]> {
        &self.here
    }

    fn below(&self) -> Option<&Arc<Self>> {
        self.below.as_ref()
    }
}

impl Cofactors {
    /// Returns the steps from one value of the bit to another.
    pub(in crate::symbolic) fn step(&self, from: bool, to: bool) -> &Arc<RelationList> {
        &self.0[usize::from(from)][usize::from(to)]
    }
}

/// The relations of a list, split by their dependence on the first bit of the list.
pub(in crate::symbolic) struct Layers {
    /// The relations that depend on later bits only.
    pub(in crate::symbolic) below: Arc<RelationList>,
    /// The relations that read or write the first bit, as one list each.
    pub(in crate::symbolic) here: Vec<Arc<RelationList>>,
}

/// The lists of one store, by their first entries and the number of the list of the others.
#[derive(Default)]
pub(in crate::symbolic) struct Lists {
    known: Known<Name, RelationList>,
}

type Name = (Arc<[PartialRelation]>, Option<u32>);

/// The lists as the links of chains.
struct Linked<'a>(&'a Store, &'a Arc<Lists>);

impl Links<RelationList> for Linked<'_> {
    fn top_of(&self, entry: &PartialRelation) -> u32 {
        self.0.shared(|m| entry.top(m))
    }

    fn simplified(&self, mut entries: Vec<PartialRelation>) -> Result<Vec<PartialRelation>> {
        entries.retain(|entry| !self.0.is_zero(&entry.relation));
        entries.sort_unstable();
        entries.dedup();
        Ok(entries)
    }

    fn link(
        &self,
        here: Arc<[PartialRelation]>,
        below: Option<Arc<RelationList>>,
    ) -> Result<Arc<RelationList>> {
        let &Linked(store, lists) = self;
        let name = (here.clone(), below.as_ref().map(|list| list.number));
        lists.known.get(name, || RelationList::new(store, lists, here, below))
    }
}

impl Lists {
    /// Creates the empty table of lists of a store.
    pub(in crate::symbolic) fn new(store: &Store) -> Arc<Self> {
        let lists = Arc::new(Lists::default());
        store.keep(lists.clone());
        lists
    }

    /// Returns the list of some relations.
    ///
    /// # Errors
    /// A limit: the memory, or the numbers of lists.
    pub(in crate::symbolic) fn of(
        self: &Arc<Self>,
        store: &Store,
        entries: Vec<PartialRelation>,
    ) -> Result<Arc<RelationList>> {
        self.inserted(store, entries, None)
    }

    /// Returns the list of some relations and those of a list.
    fn inserted(
        self: &Arc<Self>,
        store: &Store,
        entries: Vec<PartialRelation>,
        list: Option<Arc<RelationList>>,
    ) -> Result<Arc<RelationList>> {
        chain::inserted(&Linked(store, self), entries, list)
    }
}

impl Forgets for Lists {
    /// Forgets the names of all lists. This frees the lists that are not in use.
    fn forget(&self) {
        self.known.forget();
    }
}
