//! Partial relations: only the bits that may change have a next copy.

use super::support::Support;
use crate::symbolic::store::Store;
use crate::symbolic::store::diagram::{Bdd, Diagram, ManagerOf};
use meliora_base::error::Result;
use oxidd::LevelNo;

/// A partial relation: the bits outside its support keep their value and have no next copy in it.
#[derive(Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(in crate::symbolic) struct PartialRelation {
    pub(in crate::symbolic) support: Support,
    pub(in crate::symbolic) relation: Bdd,
}

impl PartialRelation {
    /// Extends the relation to a larger support: the added bits keep their value.
    pub(in crate::symbolic) fn over(&self, store: &Store, support: &Support) -> Result<PartialRelation> {
        let new = support.bits().iter().filter(|b| self.support.bits().binary_search(b).is_err());
        let mut same = store.one();
        // From the last level up, so that each conjunction only adds nodes on top.
        for &bit in new.rev() {
            let kept = store.iff(&store.literal(2 * bit, true)?, &store.literal(2 * bit + 1, true)?)?;
            same = store.and(&kept, &same)?;
        }
        Ok(PartialRelation { support: support.clone(), relation: store.and(&self.relation, &same)? })
    }

    /// Returns the union of the steps of some relations.
    pub(in crate::symbolic) fn union(store: &Store, all: &[&PartialRelation]) -> Result<PartialRelation> {
        let support = all.iter().fold(Support::new([]), |support, one| support.union(&one.support));
        let over = all.iter().map(|one| Ok(one.over(store, &support)?.relation));
        Ok(PartialRelation { relation: store.any(over.collect::<Result<Vec<_>>>()?)?, support })
    }

    /// Returns the simultaneous steps of two relations, each of which changes only its own bits.
    pub(in crate::symbolic) fn beside(
        &self,
        store: &Store,
        other: &PartialRelation,
    ) -> Result<PartialRelation> {
        let relation = store.and(&self.relation, &other.relation)?;
        Ok(PartialRelation { relation, support: self.support.union(&other.support) })
    }

    /// Returns the first bit that the relation reads or writes; `u32::MAX` if there is none.
    pub(in crate::symbolic) fn top(&self, m: &ManagerOf<'_>) -> u32 {
        let first = match m.level_of(m.edge(&self.relation)) {
            LevelNo::MAX => u32::MAX,
            level => level / 2,
        };
        first.min(self.support.top())
    }

    /// Returns the states with a step.
    pub(in crate::symbolic) fn sources(&self, store: &Store) -> Result<Bdd> {
        let mut next = store.one();
        // From the last level up, so that each conjunction only adds nodes on top.
        for &bit in self.support.bits().iter().rev() {
            next = store.and(&store.literal(2 * bit + 1, true)?, &next)?;
        }
        store.exists(&self.relation, &next)
    }

    /// Returns the cofactor of the relation by a bit that is `from` before and `to` after a step;
    /// `None` if the values differ and the relation does not write the bit. The relation may not
    /// depend on an earlier bit.
    pub(in crate::symbolic) fn below(
        &self,
        m: &ManagerOf<'_>,
        bit: u32,
        from: bool,
        to: bool,
    ) -> Option<PartialRelation> {
        let touches = self.support.top() == bit;
        if !touches && from != to {
            return None;
        }
        let side = |f, level, value: bool| {
            let (set, clear) = m.children(f, level);
            if value { set } else { clear }
        };
        let mut relation = side(m.edge(&self.relation), 2 * bit, from);
        if touches {
            relation = side(relation, 2 * bit + 1, to);
        }
        Some(PartialRelation { relation: m.handle(relation), support: self.support.below(bit) })
    }
}
