//! The states in which no step changes a monitor, and their steps.
//!
//! A monitor reads each state when the path leaves it, so every group of choices may write it, and a recursion
//! over the lists of all groups would split on its bits before it has closed anything else. In most states the
//! monitors wait. Among these a search needs the steps of the model alone.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::SymbolicEngine;
use super::relations::partial_relation::PartialRelation;
use super::relations::support::Support;
use super::relations::tuples::{ListTuple, ListTuples};
use super::store::diagram::Bdd;
use meliora_base::error::Result;
use meliora_model::VarId;

/// The states in which no step changes a monitor.
pub(super) struct Quiet {
    pub(super) states: Bdd,
    /// All values of the monitors in parts: no step leads from a part into a later one.
    pub(super) order: Vec<Bdd>,
    /// The steps of each group from these states; from others, any steps.
    pub(super) lists: Arc<ListTuple>,
}

impl SymbolicEngine {
    /// Returns the states in which no step changes a monitor. Returns `None` without monitors, and in a game,
    /// where the steps of the opponent are one list. They depend on the relations and the states alone, so they
    /// are computed once.
    ///
    /// # Errors
    /// A limit.
    pub(super) fn quiet(&self) -> Result<Option<&Quiet>> {
        let Some(monitors) = self.program.monitors.as_ref().filter(|_| self.opponent().is_none()) else {
            return Ok(None);
        };
        if let Some(found) = self.quiet.get() {
            return Ok(Some(found));
        }
        let watching = self.encoding.support_of(&monitors.variables);
        let (mut groups, mut loud) = (Vec::with_capacity(self.groups.len()), self.store.zero());
        for list in &self.groups {
            let mut entries = Vec::new();
            for entry in list.entries() {
                let (kept, changing) = self.by_change(entry, watching.bits())?;
                entries.extend((!self.store.is_zero(&kept.relation)).then_some(kept));
                loud = self.store.or(&loud, &changing)?;
            }
            groups.push(self.lists.of(&self.store, entries)?);
        }
        let states = self.store.minus(&self.states.0, &loud)?;
        let lists = ListTuples::new(&self.store).of_lists(&self.store, &groups)?;
        let order = self.monitor_order(&monitors.variables)?;
        Ok(Some(self.quiet.get_or_init(|| Arc::new(Quiet { states, order, lists }))))
    }

    /// Returns all values of some monitors in parts: no step leads from a part into a later one.
    ///
    /// A value of a monitor has a rank, which no step increases. The ranks of all monitors add up, so there are
    /// few parts, however many values the monitors have together.
    fn monitor_order(&self, monitors: &[VarId]) -> Result<Vec<Bdd>> {
        let store = &self.store;
        let mut parts = vec![store.one()];
        for &monitor in monitors {
            let ranks = self.ranks(monitor)?;
            let more = ranks.iter().max().copied().unwrap_or(0);
            let mut next = vec![store.zero(); parts.len() + more];
            for (offset, rank) in ranks.into_iter().enumerate() {
                let value = self.encoding.value(store, monitor, offset as u64)?;
                for (at, part) in parts.iter().enumerate() {
                    next[at + rank] = store.or(&next[at + rank], &store.and(part, &value)?)?;
                }
            }
            parts = next;
        }
        Ok(parts)
    }

    /// Returns for each value of a monitor the number of ranks below its own: of two values, one has the smaller
    /// rank if it leads to fewer values.
    fn ranks(&self, monitor: VarId) -> Result<Vec<usize>> {
        let (store, own) = (&self.store, self.encoding.positions(monitor));
        let mut others = store.one();
        for bit in (0..self.encoding.width() as u32).rev().filter(|bit| !own.contains(bit)) {
            others = store.and(&store.literal(2 * bit + 1, true)?, &others)?;
            others = store.and(&store.literal(2 * bit, true)?, &others)?;
        }
        let entries = self.groups.iter().flat_map(|list| list.entries());
        let moves =
            store.any(entries.map(|e| store.exists(&e.relation, &others)).collect::<Result<Vec<_>>>()?)?;
        let has = |offset: usize, bit: u32| {
            own.iter().position(|own| *own == bit).is_some_and(|index| offset >> index & 1 == 1)
        };
        let declared = &self.program.variables[monitor.index()];
        let values = declared.high.wrapping_sub(declared.low) as usize + 1;
        let leads = |from: usize, to: usize| {
            store.holds(&moves, |level| has(if level % 2 == 0 { from } else { to }, level / 2))
        };
        Ok(ranks(values, leads))
    }

    /// Returns the steps that keep some bits, as a relation that does not write them, and the states with other
    /// steps. From those states, the relation may have any steps.
    fn by_change(&self, steps: &PartialRelation, bits: &[u32]) -> Result<(PartialRelation, Bdd)> {
        let (store, PartialRelation { support, relation }) = (&self.store, steps);
        let (mut same, mut next, mut both) = (store.one(), store.one(), store.one());
        for &bit in support.bits().iter().rev().filter(|bit| bits.contains(bit)) {
            let (before, after) = (store.literal(2 * bit, true)?, store.literal(2 * bit + 1, true)?);
            same = store.and(&store.iff(&before, &after)?, &same)?;
            next = store.and(&after, &next)?;
            both = store.and(&before, &store.and(&after, &both)?)?;
        }
        let other = PartialRelation { support: support.clone(), relation: store.minus(relation, &same)? };
        let others = other.sources(store)?;
        let kept = store.minus(&store.exists(&store.and(relation, &same)?, &next)?, &others)?;
        // A monitor allows every step of the model, so its bits need not be read either, unless the engine has
        // only some of the steps.
        let free = store.exists(relation, &both)?;
        let is_free = store.minus(&free, &others)? == kept;
        let support = Support::new(support.bits().iter().copied().filter(|bit| !bits.contains(bit)));
        Ok((PartialRelation { support, relation: if is_free { free } else { kept } }, others))
    }
}

/// Returns for each node of a graph the number of smaller numbers of nodes that some node can reach. No edge leads
/// to a node with a greater one.
fn ranks(nodes: usize, has_edge: impl Fn(usize, usize) -> bool) -> Vec<usize> {
    let mut reached: Vec<Vec<bool>> =
        (0..nodes).map(|from| (0..nodes).map(|to| from == to || has_edge(from, to)).collect()).collect();
    for through in 0..nodes {
        let further = reached[through].clone();
        for row in reached.iter_mut().filter(|row| row[through]) {
            row.iter_mut().zip(&further).for_each(|(own, more)| *own |= more);
        }
    }
    let sizes = reached.iter().map(|row| row.iter().filter(|reached| **reached).count());
    let sizes = Vec::from_iter(sizes);
    let distinct = BTreeSet::from_iter(sizes.iter().copied());
    sizes.into_iter().map(|size| distinct.range(..size).count()).collect()
}

#[cfg(test)]
mod tests {
    use super::ranks;

    #[test]
    fn no_edge_leads_to_a_greater_rank() {
        let edges = [(0, 3), (3, 1), (1, 3), (3, 2), (0, 4)];
        assert_eq!(ranks(5, |from, to| edges.contains(&(from, to))), [2, 1, 0, 1, 0]);
    }
}
