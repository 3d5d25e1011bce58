//! The lists that change the state together, as the splits of a recursion meet them.

use std::cell::Cell;
use std::sync::Arc;

use ahash::AHashSet;

use super::chain::{self, Known, Link, Links};
use super::lists::RelationList;
use crate::symbolic::store::Store;
use meliora_base::error::Result;

/// Lists that may change the state. Equal combinations exist once and have a number.
struct Combination {
    number: usize,
    /// The first bit that a list reads or writes; `u32::MAX` if there is none.
    top: u32,
    /// The lists that depend on the first bit.
    here: Arc<[Arc<RelationList>]>,
    /// The others.
    below: Option<Arc<Combination>>,
}

impl Link for Combination {
    type Operand = Arc<RelationList>;

    fn top(&self) -> u32 {
        self.top
    }

    fn here(&self) -> &Arc<[Arc<RelationList>]> {
        &self.here
    }

    fn below(&self) -> Option<&Arc<Self>> {
        self.below.as_ref()
    }
}

impl Drop for Combination {
    /// Drops the combinations below in a loop: as a recursion this would be as deep as a state has bits.
    fn drop(&mut self) {
        let mut next = self.below.take();
        while let Some(mut last) = next.and_then(Arc::into_inner) {
            next = last.below.take();
        }
    }
}

/// The combinations, by the numbers of their first lists and of the combination of the others.
struct Combinations<'a> {
    store: &'a Store,
    known: Known<(Vec<u32>, Option<usize>), Combination>,
    made: Cell<usize>,
}

impl Links<Combination> for Combinations<'_> {
    fn top_of(&self, list: &Arc<RelationList>) -> u32 {
        list.top
    }

    fn simplified(&self, mut lists: Vec<Arc<RelationList>>) -> Result<Vec<Arc<RelationList>>> {
        lists.sort_unstable_by_key(|list| list.number);
        lists.dedup_by_key(|list| list.number);
        Ok(lists)
    }

    fn link(
        &self,
        here: Arc<[Arc<RelationList>]>,
        below: Option<Arc<Combination>>,
    ) -> Result<Arc<Combination>> {
        let name = (here.iter().map(|list| list.number).collect(), below.as_ref().map(|rest| rest.number));
        self.known.get(self.store, name, || {
            let number = self.made.replace(self.made.get() + 1);
            let top = here.first().map_or(u32::MAX, |list| list.top);
            Ok(Combination { number, top, here, below })
        })
    }
}

impl Combinations<'_> {
    /// Returns the combination of those of some lists that change the state, and of a combination.
    fn inserted(
        &self,
        mut lists: Vec<Arc<RelationList>>,
        all: Option<Arc<Combination>>,
    ) -> Result<Arc<Combination>> {
        lists.retain(|list| list.changes_state());
        chain::inserted(self, lists, all)
    }

    /// Returns the steps that keep a value of the first bit of a combination.
    fn kept(&self, all: &Combination, value: bool) -> Result<Arc<Combination>> {
        let kept = all.here.iter().map(|list| list.cofactor(self.store, all.top, value, value));
        self.inserted(kept.collect::<Result<_>>()?, all.below.clone())
    }
}

/// Returns true if at most `most` different combinations of lists that change the state remain when the lists are
/// split by bits that keep their values.
///
/// # Errors
/// A limit: the memory, or the numbers of lists.
pub(in crate::symbolic) fn stay_few(store: &Store, lists: &[Arc<RelationList>], most: usize) -> Result<bool> {
    let combinations = Combinations { store, known: Known::default(), made: 0.into() };
    let mut seen = AHashSet::new();
    let mut open = vec![combinations.inserted(lists.to_vec(), None)?];
    while let Some(all) = open.pop() {
        if all.here.is_empty() || !seen.insert(all.number) {
            continue;
        }
        if seen.len() > most {
            return Ok(false);
        }
        for value in [false, true] {
            open.push(combinations.kept(&all, value)?);
        }
    }
    Ok(true)
}
