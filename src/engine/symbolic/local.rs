//! Local relations: over the bits that something moves, and no next copies of the others.

use oxidd::Function;

use super::diagram::{Bdd, Diagram, ManagerOf};
use super::store::Store;
use super::touched::Touched;
use crate::error::Result;

/// A local relation: the bits that it does not touch keep their value and have no next copy in it.
#[derive(Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct Local {
    pub(super) touched: Touched,
    pub(super) relation: Bdd,
}

impl Local {
    /// The same steps over more touched bits: those that are new keep their value.
    pub(super) fn over(&self, store: &Store, touched: &Touched) -> Result<Local> {
        let new = touched.bits().iter().filter(|b| self.touched.bits().binary_search(b).is_err());
        let mut same = store.one();
        // From the far end up, so that each conjunction only puts nodes on top.
        for &bit in new.rev() {
            let kept = store.iff(&store.literal(2 * bit, true)?, &store.literal(2 * bit + 1, true)?)?;
            same = store.and(&kept, &same)?;
        }
        Ok(Local { touched: touched.clone(), relation: store.and(&self.relation, &same)? })
    }

    /// The steps of any of some relations.
    pub(super) fn union(store: &Store, all: &[&Local]) -> Result<Local> {
        let touched = all.iter().fold(Touched::new([]), |touched, one| touched.union(&one.touched));
        let over = all.iter().map(|one| Ok(one.over(store, &touched)?.relation));
        Ok(Local { relation: store.any(over.collect::<Result<Vec<_>>>()?)?, touched })
    }

    /// The steps that both take at once, each moving its own bits.
    pub(super) fn beside(&self, store: &Store, other: &Local) -> Result<Local> {
        let relation = store.and(&self.relation, &other.relation)?;
        Ok(Local { relation, touched: self.touched.union(&other.touched) })
    }

    /// The first bit that the relation reads or touches; `u32::MAX` for none.
    pub(super) fn top(&self, m: &ManagerOf<'_>) -> u32 {
        (m.level_of(self.relation.as_edge(m)) / 2).min(self.touched.top())
    }

    /// What is left below `bit` of the steps on which it has the value `from` before and `to` after;
    /// none where the relation does not touch it and the values differ. No earlier bit may matter.
    pub(super) fn below(&self, m: &ManagerOf<'_>, bit: u32, from: bool, to: bool) -> Option<Local> {
        let touches = self.touched.top() == bit;
        if !touches && from != to {
            return None;
        }
        let side = |f, level, value: bool| {
            let (set, clear) = m.children(f, level);
            if value { set } else { clear }
        };
        let mut relation = side(self.relation.as_edge(m), 2 * bit, from);
        if touches {
            relation = side(relation, 2 * bit + 1, to);
        }
        Some(Local { relation: m.handle(relation), touched: self.touched.below(bit) })
    }
}
