//! The combinations of lists that the splits of a recursion meet.

use std::iter;
use std::sync::Arc;

use ahash::{AHashSet, RandomState};

use super::chain::{self, Link, Links};
use super::lists::RelationList;
use crate::symbolic::store::Store;
use meliora_base::error::Result;

/// A list with its place among all lists.
type Placed = (usize, Arc<RelationList>);

/// Lists that a later split may concern.
struct Combination {
    /// The first bit that a list reads or writes.
    top: u32,
    /// The lists that depend on the first bit.
    here: Arc<[Placed]>,
    /// The others.
    below: Option<Arc<Combination>>,
}

impl Link for Combination {
    type Operand = Placed;

    fn top(&self) -> u32 {
        self.top
    }

    fn here(&self) -> &Arc<[Placed]> {
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

/// Makes combinations, and names for all lists of a moment.
struct Splits {
    hash: RandomState,
}

impl Links<Combination> for Splits {
    fn top_of(&self, (_, list): &Placed) -> u32 {
        list.top
    }

    fn simplified(&self, lists: Vec<Placed>) -> Result<Vec<Placed>> {
        Ok(lists)
    }

    fn link(&self, here: Arc<[Placed]>, below: Option<Arc<Combination>>) -> Result<Arc<Combination>> {
        let top = here.first().map_or(u32::MAX, |(_, list)| list.top);
        Ok(Arc::new(Combination { top, here, below }))
    }
}

impl Splits {
    /// Returns the combination of some lists and those of another one.
    fn inserted(&self, mut lists: Vec<Placed>, all: Option<Arc<Combination>>) -> Result<Arc<Combination>> {
        lists.retain(|(_, list)| list.top < u32::MAX);
        chain::inserted(self, lists, all)
    }

    /// Returns the sum of the hashes of some lists, each with its place. It tells all lists of one moment from those of
    /// another one; the sums of different ones are equal with a probability of 2^-64.
    fn name<'l>(&self, lists: impl IntoIterator<Item = &'l Placed>) -> u64 {
        let one = |(place, list): &Placed| self.hash.hash_one((place, list.number));
        lists.into_iter().map(one).fold(0, u64::wrapping_add)
    }
}

/// Returns true if at most `most` different combinations of the lists remain when they are split by bits that keep
/// their values, the first bits first, as long as some list changes the state.
///
/// # Errors
/// A limit: the memory, or the numbers of lists.
pub(in crate::symbolic) fn stay_few(store: &Store, lists: &[Arc<RelationList>], most: usize) -> Result<bool> {
    let splits = Splits { hash: RandomState::with_seeds(1, 2, 3, 4) };
    let placed: Vec<Placed> = lists.iter().cloned().enumerate().collect();
    let name = splits.name(&placed);
    let mut seen = AHashSet::new();
    let mut open = vec![(splits.inserted(placed, None)?, name)];
    while let Some((all, name)) = open.pop() {
        // No later split concerns the lists before the first one that changes the state.
        let mut links = iter::successors(Some(&all), |link| link.below.as_ref());
        let changes = |link: &&Arc<Combination>| link.here.iter().any(|(_, list)| list.changes_state());
        let Some(first) = links.find(changes) else { continue };
        if !seen.insert(name) {
            continue;
        }
        if seen.len() > most {
            return Ok(false);
        }
        for value in [false, true] {
            let kept = |(place, list): &Placed| Ok((*place, list.cofactor(store, first.top, value, value)?));
            let kept: Vec<Placed> = first.here.iter().map(kept).collect::<Result<_>>()?;
            let name = name.wrapping_sub(splits.name(&*first.here)).wrapping_add(splits.name(&kept));
            open.push((splits.inserted(kept, first.below.clone())?, name));
        }
    }
    Ok(true)
}
