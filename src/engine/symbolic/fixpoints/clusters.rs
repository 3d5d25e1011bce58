//! Relations united for reachability.
//!
//! For reachability it is irrelevant which choice a step belongs to. Pieces of all groups with the
//! same first bit are united into one *cluster*, as long as the union stays small.

use std::sync::Arc;

use crate::symbolic::encoding::transitions::Piece;
use crate::symbolic::relations::lists::{Lists, RelationList};
use crate::symbolic::relations::partial_relation::PartialRelation;
use crate::symbolic::relations::support::Support;
use crate::symbolic::store::Store;
use crate::symbolic::store::diagram::Bdd;
use crate::symbolic::store::walk::Direction;
use meliora_base::error::Result;

/// Some pieces as one relation.
#[derive(Clone)]
struct Cluster {
    /// The pieces, each extended to the support of the cluster.
    pieces: Vec<Piece>,
    /// The union of their steps.
    steps: PartialRelation,
    /// The first bit that the relation reads or writes.
    top: u32,
}

/// All clusters.
#[derive(Clone)]
pub(in crate::symbolic) struct Clusters {
    clusters: Vec<Cluster>,
    /// The relations of all clusters as one list.
    list: Arc<RelationList>,
}

impl Clusters {
    /// Unites the pieces.
    pub(in crate::symbolic) fn new(store: &Store, lists: &Arc<Lists>, pieces: &[Piece]) -> Result<Self> {
        let mut clusters: Vec<Cluster> = Vec::new();
        for piece in pieces {
            let top = store.shared(|m| piece.steps.top(m));
            let mut joined = false;
            for cluster in clusters.iter_mut().filter(|c| c.top == top) {
                if join(store, cluster, piece)? {
                    joined = true;
                    break;
                }
            }
            if !joined {
                clusters.push(Cluster { pieces: vec![piece.clone()], steps: piece.steps.clone(), top });
            }
        }
        let mut all = Clusters { clusters, list: lists.of(store, Vec::new())? };
        all.relist(store, lists)?;
        Ok(all)
    }

    /// Returns all diagrams. After they are replaced, [`Clusters::relist`] must be called.
    pub(in crate::symbolic) fn diagrams<'a>(&'a mut self) -> impl Iterator<Item = &'a mut Bdd> {
        let of = |c: &'a mut Cluster| {
            c.pieces.iter_mut().map(|p| &mut p.steps.relation).chain([&mut c.steps.relation])
        };
        self.clusters.iter_mut().flat_map(of)
    }

    /// Builds the list of all clusters.
    pub(in crate::symbolic) fn relist(&mut self, store: &Store, lists: &Arc<Lists>) -> Result<()> {
        self.list = lists.of(store, self.clusters.iter().map(|c| c.steps.clone()).collect())?;
        Ok(())
    }

    /// Returns the relations with the steps of each group restricted to its allowed states (`None`
    /// allows all) and without the dropped edges.
    pub(in crate::symbolic) fn confined(
        &self,
        store: &Store,
        allowed: &[Option<Bdd>],
        dropped: &[(Bdd, Bdd)],
    ) -> Result<Arc<RelationList>> {
        let free = |c: &Cluster| c.pieces.iter().all(|p| allowed[p.group].is_none());
        if dropped.is_empty() && self.clusters.iter().all(free) {
            return Ok(self.list.clone());
        }
        let mut entries = Vec::new();
        for cluster in &self.clusters {
            let PartialRelation { support, relation } = cluster.steps.clone();
            let relation = if free(cluster) {
                relation
            } else {
                let confined = cluster.pieces.iter().map(|piece| match &allowed[piece.group] {
                    None => Ok(piece.steps.relation.clone()),
                    Some(states) => store.and(&piece.steps.relation, states),
                });
                store.any(confined.collect::<Result<Vec<_>>>()?)?
            };
            entries.push(PartialRelation { relation: without(store, relation, &support, dropped)?, support });
        }
        self.list.all().of(store, entries)
    }

    /// Computes μX. start ∪ { s' ∈ bound : s → s' for some s ∈ X }; `None` if that takes more than `steps` steps.
    ///
    /// Variable orders take turns in an exploration, so methods do not: the recursion was faster wherever both
    /// methods ended.
    pub(in crate::symbolic) fn forward(
        &self,
        store: &Store,
        start: &Bdd,
        bound: &Bdd,
        steps: u64,
    ) -> Result<Option<Bdd>> {
        let phase = "reachable states";
        store.progress(phase);
        store.fixpoint(false, (Direction::Forward, Some(phase)), steps, &self.list, (start, bound))
    }

    /// Returns the relations of all clusters.
    pub(in crate::symbolic) fn list(&self) -> &Arc<RelationList> {
        &self.list
    }

    /// Returns the number of clusters.
    pub(in crate::symbolic) fn len(&self) -> usize {
        self.clusters.len()
    }
}

/// Returns a relation without the dropped edges.
fn without(store: &Store, mut relation: Bdd, support: &Support, dropped: &[(Bdd, Bdd)]) -> Result<Bdd> {
    for (from, to) in dropped {
        let sources = store.and(&relation, from)?;
        if !store.is_zero(&sources) {
            let lost = store.and(&sources, &store.primed(support, to)?)?;
            relation = store.minus(&relation, &lost)?;
        }
    }
    Ok(relation)
}

/// Adds the piece to the cluster, unless the union is large and has more than twice the nodes of
/// the two relations. Returns true if the piece was added.
fn join(store: &Store, cluster: &mut Cluster, piece: &Piece) -> Result<bool> {
    let steps = PartialRelation::union(store, &[&piece.steps, &cluster.steps])?;
    let sizes = store.size(&piece.steps.relation)? + store.size(&cluster.steps.relation)?;
    if store.size(&steps.relation)? > store.thresholds().small_relation.max(2 * sizes) {
        return Ok(false);
    }
    cluster.pieces.push(piece.clone());
    for own in &mut cluster.pieces {
        own.steps = own.steps.over(store, &steps.support)?;
    }
    cluster.steps = steps;
    Ok(true)
}
