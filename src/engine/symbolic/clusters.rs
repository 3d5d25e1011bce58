//! Relations united for reachability.
//!
//! For reachability it does not matter whose choice a step is: pieces of all groups that depend on
//! the same bit first are united into one *cluster*, as long as the union stays small.

use std::sync::Arc;

use oxidd::Function;

use super::diagram::Diagram;
use super::encoding::Encoding;
use super::lists::{Entry, List};
use super::store::{Bdd, Store};
use super::touched::Touched;
use super::transitions::{Piece, frame};
use super::walk::Direction;
use crate::engine::Dropped;
use crate::error::Result;
use crate::model::VarId;

/// Some pieces as one relation.
struct Cluster {
    /// The parts, each over the touched bits of the cluster.
    parts: Vec<Part>,
    entry: Entry,
    /// The first bit that the relation depends on or touches.
    top: u32,
    /// The variables that are touched, sorted.
    writes: Vec<VarId>,
}

struct Part {
    group: usize,
    relation: Bdd,
}

/// All clusters.
pub(super) struct Clusters {
    clusters: Vec<Cluster>,
    /// All of them as one list.
    list: Arc<List>,
}

impl Clusters {
    /// Unites the pieces.
    pub(super) fn new(store: &Store, encoding: &Encoding, pieces: &[Piece]) -> Result<Self> {
        let mut clusters: Vec<Cluster> = Vec::new();
        for piece in pieces {
            let top = first_bit(store, &piece.relation, &piece.touched);
            let mut joined = false;
            for cluster in &mut clusters {
                if cluster.top == top && join(store, encoding, cluster, piece)? {
                    joined = true;
                    break;
                }
            }
            if !joined {
                let parts = vec![Part { group: piece.group, relation: piece.relation.clone() }];
                clusters.push(Cluster { parts, entry: piece.entry(), top, writes: piece.writes.clone() });
            }
        }
        let mut all = Clusters { clusters, list: store.lists.of(store, Vec::new())? };
        all.relist(store)?;
        Ok(all)
    }

    /// All diagrams; once they are others, the list is to be made anew.
    pub(super) fn diagrams(&mut self) -> impl Iterator<Item = &mut Bdd> {
        fn of(c: &mut Cluster) -> Vec<&mut Bdd> {
            let parts = c.parts.iter_mut().map(|p| &mut p.relation);
            parts.chain([&mut c.entry.relation]).collect()
        }
        self.clusters.iter_mut().flat_map(of)
    }

    /// Makes the list of all clusters.
    pub(super) fn relist(&mut self, store: &Store) -> Result<()> {
        self.list = store.lists.of(store, self.clusters.iter().map(|c| c.entry.clone()).collect())?;
        Ok(())
    }

    /// The relations with the steps of each group confined to its allowed states (`None` allows all)
    /// and without the dropped edges.
    pub(super) fn confined(
        &self,
        store: &Store,
        allowed: &[Option<Bdd>],
        dropped: &Dropped<Bdd>,
    ) -> Result<Arc<List>> {
        let free = |c: &Cluster| c.parts.iter().all(|p| allowed[p.group].is_none());
        if dropped.is_empty() && self.clusters.iter().all(free) {
            return Ok(self.list.clone());
        }
        let mut entries = Vec::new();
        for cluster in &self.clusters {
            let touched = &cluster.entry.touched;
            let relation = if free(cluster) {
                cluster.entry.relation.clone()
            } else {
                let confined = cluster.parts.iter().map(|part| match &allowed[part.group] {
                    None => Ok(part.relation.clone()),
                    Some(states) => store.and(&part.relation, states),
                });
                store.any(confined.collect::<Result<Vec<_>>>()?)?
            };
            let relation = without(store, relation, touched, dropped)?;
            entries.push(Entry { relation, touched: touched.clone() });
        }
        store.lists.of(store, entries)
    }

    /// μX. start ∪ { s' ∈ bound : s → s' for some s ∈ X }
    pub(super) fn forward(&self, store: &Store, start: &Bdd, bound: &Bdd) -> Result<Bdd> {
        store.reach((Direction::Forward, "reachable states"), &self.list, start, bound)
    }

    /// How many relations there are.
    pub(super) fn len(&self) -> usize {
        self.clusters.len()
    }
}

/// A relation without the dropped edges.
fn without(store: &Store, mut relation: Bdd, touched: &Touched, dropped: &Dropped<Bdd>) -> Result<Bdd> {
    for (from, to) in dropped {
        let sources = store.and(&relation, from)?;
        if !store.is_zero(&sources) {
            let lost = store.and(&sources, &store.primed(touched, to)?)?;
            relation = store.minus(&relation, &lost)?;
        }
    }
    Ok(relation)
}

/// The first bit that a relation depends on or touches.
fn first_bit(store: &Store, relation: &Bdd, touched: &Touched) -> u32 {
    store.shared(|m| m.level_of(relation.as_edge(m)) / 2).min(touched.top())
}

/// Puts the piece into the cluster unless that makes the relation much larger than the two.
fn join(store: &Store, encoding: &Encoding, cluster: &mut Cluster, piece: &Piece) -> Result<bool> {
    let mut all = cluster.writes.clone();
    all.extend(&piece.writes);
    all.sort_unstable();
    all.dedup();
    let own = frame(store, encoding, &piece.relation, &piece.writes, &all)?;
    let theirs = frame(store, encoding, &cluster.entry.relation, &cluster.writes, &all)?;
    let union = store.or(&own, &theirs)?;
    let bound = store
        .thresholds()
        .small_union
        .max(2 * (store.size(&piece.relation) + store.size(&cluster.entry.relation)));
    if store.size(&union) > bound {
        return Ok(false);
    }
    for part in &mut cluster.parts {
        part.relation = frame(store, encoding, &part.relation, &cluster.writes, &all)?;
    }
    cluster.parts.push(Part { group: piece.group, relation: own });
    if all != cluster.writes {
        cluster.entry.touched = encoding.touch(&all);
        cluster.writes = all;
    }
    cluster.entry.relation = union;
    Ok(true)
}
