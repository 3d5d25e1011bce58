//! Reachability, and removal of the attractor of lost states where all edges are plain, layer by layer.

use std::sync::atomic::Ordering::Relaxed;

use crate::symbolic::relations::lists::RelationList;
use crate::symbolic::relations::tuples::{Group, ListTuple};
use crate::symbolic::store::Store;
use crate::symbolic::store::diagram::Bdd;
use crate::symbolic::store::walk::{Direction, Walk};
use meliora_model::error::Result;

/// A removal in progress.
pub(in crate::symbolic) struct Layers {
    /// The states that are lost or outside.
    pub(in crate::symbolic) lost: Bdd,
    /// The last layer: all states of which a step may have made others lost.
    new: Bdd,
    /// The other states that may be lost.
    candidates: Bdd,
    /// The numbers of the groups; first those that kept a state last time.
    order: Vec<usize>,
}

impl Layers {
    /// Starts a removal: `new` are the states of `lost` from which it continues.
    pub(in crate::symbolic) fn new(new: &Bdd, lost: &Bdd, candidates: &Bdd, groups: &ListTuple) -> Self {
        let (new, lost, candidates) = (new.clone(), lost.clone(), candidates.clone());
        Layers { lost, new, candidates, order: (0..groups.groups().count()).collect() }
    }

    /// Finds the next layer: the candidates with a step into the last one of which every list with a step
    /// has one into a lost state. Returns false if there is none.
    ///
    /// The states that some group keeps are taken out of those with a step into the last layer, so no
    /// result on the way has other states. Cost: one pre-image of the last layer, and one per group.
    pub(in crate::symbolic) fn next(
        &mut self,
        store: &Store,
        united: &RelationList,
        groups: &ListTuple,
    ) -> Result<bool> {
        if groups.stays {
            return Ok(false);
        }
        let all = Vec::from_iter(groups.groups());
        let mut open = store.step(Direction::Backward, united, &self.new, &self.candidates)?;
        let (mut keeping, mut others) = (Vec::new(), Vec::new());
        for &index in &self.order {
            let before = open.clone();
            if !store.is_zero(&open) {
                open = store.minus(&open, &all[index].kept(store, &self.lost, &open)?)?;
            }
            if open == before { &mut others } else { &mut keeping }.push(index);
        }
        keeping.append(&mut others);
        self.order = keeping;
        self.lost = store.or(&self.lost, &open)?;
        self.candidates = store.minus(&self.candidates, &open)?;
        self.new = open;
        Ok(!store.is_zero(&self.new))
    }
}

/// Returns the states of X of which every list with a step has one into L.
///
/// Cost: one pre-image per group.
pub(in crate::symbolic) fn stuck(store: &Store, l: &Bdd, x: Bdd, groups: &ListTuple) -> Result<Bdd> {
    if groups.stays {
        return Ok(store.zero());
    }
    let mut open = x;
    for group in groups.groups() {
        open = store.minus(&open, &group.kept(store, l, &open)?)?;
    }
    Ok(open)
}

impl Group {
    /// Returns the states of X with a step of the group and none into L.
    fn kept(&self, store: &Store, l: &Bdd, x: &Bdd) -> Result<Bdd> {
        store.spare(l, &store.and(x, &self.sources)?, &self.list)
    }
}

impl Store {
    /// Computes [`Store::reach`] layer by layer: the states that one step adds, then those that a step from
    /// these adds, and so on. `None` if it takes more than `steps` steps.
    pub(in crate::symbolic) fn reach_by_layers(
        &self,
        how: (Direction, Option<&'static str>),
        steps: u64,
        list: &RelationList,
        (x, bound): (&Bdd, &Bdd),
    ) -> Result<Option<Bdd>> {
        let until = self.work.steps.load(Relaxed).saturating_add(steps);
        let (mut new, mut open) = (x.clone(), self.minus(bound, x)?);
        while !self.is_zero(&new) {
            let left = until.saturating_sub(self.work.steps.load(Relaxed));
            let step = |walk: &Walk<'_, '_>| walk.own(|w| w.step(w.edge(&new), w.edge(&open), list));
            match self.walk(how, left, step)? {
                Some(found) => new = found,
                None => return Ok(None),
            }
            open = self.minus(&open, &new)?;
        }
        self.minus(bound, &open).map(Some)
    }

    /// Computes [`Walk::spare`].
    fn spare(&self, x: &Bdd, bound: &Bdd, list: &RelationList) -> Result<Bdd> {
        let how = (Direction::Backward, None);
        self.walk_to_the_end(how, |walk| walk.own(|w: &Walk<'_, '_>| w.spare(w.edge(x), w.edge(bound), list)))
    }
}
