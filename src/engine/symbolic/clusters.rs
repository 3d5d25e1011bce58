//! Relations united for reachability, and the order in which they fire.
//!
//! For reachability it does not matter whose choice a step is: pieces of all groups with the same
//! top-most touched bit are united into one *cluster*, as long as the union stays small. Clusters
//! fire deepest first, each on the states it has not fired from yet, and again from the deepest when
//! a higher one has found something new: the lower parts of the diagram are saturated before the
//! upper ones move.

use std::rc::Rc;

use super::encoding::Encoding;
use super::relational::Touched;
use super::store::{Bdd, Store};
use super::transitions::{Piece, frame};
use crate::engine::Dropped;
use crate::error::Result;

/// A union may have this many nodes whatever its parts have.
const SMALL: usize = 2_000;

/// Some pieces as one relation.
#[derive(Clone)]
pub(super) struct Cluster {
    /// The parts, each over the touched bits of the cluster.
    parts: Vec<Part>,
    relation: Bdd,
    touched: Rc<Touched>,
}

#[derive(Clone)]
struct Part {
    group: usize,
    relation: Bdd,
}

/// All clusters, deepest first.
#[derive(Clone)]
pub(super) struct Clusters {
    clusters: Vec<Cluster>,
}

impl Clusters {
    /// Unites the pieces.
    pub(super) fn new(store: &Store, encoding: &Encoding, pieces: &[Piece]) -> Result<Self> {
        let mut building: Vec<(Vec<crate::model::VarId>, Cluster)> = Vec::new();
        for piece in pieces {
            let mut joined = false;
            for (writes, cluster) in &mut building {
                if cluster.touched.top() == piece.touched.top()
                    && join(store, encoding, writes, cluster, piece)?
                {
                    joined = true;
                    break;
                }
            }
            if !joined {
                let part = Part { group: piece.group, relation: piece.relation.clone() };
                let (relation, touched) = (piece.relation.clone(), piece.touched.clone());
                building.push((piece.writes.clone(), Cluster { parts: vec![part], relation, touched }));
            }
        }
        let mut clusters: Vec<Cluster> = building.into_iter().map(|(_, c)| c).collect();
        clusters.sort_by_key(|c| std::cmp::Reverse(c.touched.top()));
        Ok(Clusters { clusters })
    }

    /// The same with the steps of each group confined to its allowed states; `None` allows all.
    pub(super) fn confined(&self, store: &Store, allowed: &[Option<Bdd>]) -> Result<Self> {
        let mut clusters = Vec::new();
        for cluster in &self.clusters {
            if cluster.parts.iter().all(|p| allowed[p.group].is_none()) {
                clusters.push(cluster.clone());
                continue;
            }
            let mut relations = Vec::new();
            for part in &cluster.parts {
                relations.push(match &allowed[part.group] {
                    None => part.relation.clone(),
                    Some(states) => store.and(&part.relation, states)?,
                });
            }
            let relation = store.any(relations)?;
            if !store.is_zero(&relation) {
                clusters.push(Cluster {
                    parts: cluster.parts.clone(),
                    relation,
                    touched: cluster.touched.clone(),
                });
            }
        }
        Ok(Clusters { clusters })
    }

    /// The same with the sources of all steps confined to a set of states.
    pub(super) fn confined_to(&self, store: &Store, states: &Bdd) -> Result<Self> {
        let mut clusters = self.clusters.clone();
        for cluster in &mut clusters {
            cluster.relation = store.and(&cluster.relation, states)?;
            for part in &mut cluster.parts {
                part.relation = store.and(&part.relation, states)?;
            }
        }
        Ok(Clusters { clusters })
    }

    /// μX. start ∪ { s' : s → s' for some s ∈ X }
    pub(super) fn forward(&self, store: &Store, start: &Bdd, tell: &dyn Fn(usize, &Bdd)) -> Result<Bdd> {
        self.saturate(store, start, tell, |cluster, new| {
            store.image(&cluster.relation, &cluster.touched, new)
        })
    }

    /// μX. target ∪ { s : s → s' for some s' ∈ X by an edge that is not dropped }
    pub(super) fn backward(
        &self,
        store: &Store,
        target: &Bdd,
        dropped: &Dropped<Bdd>,
        tell: &dyn Fn(usize, &Bdd),
    ) -> Result<Bdd> {
        self.saturate(store, target, tell, |cluster, new| {
            let pre = |x: &Bdd| store.pre(&cluster.relation, &cluster.touched, x);
            let mut sources = pre(new)?;
            for (from, to) in dropped {
                let allowed = store.minus(new, to)?;
                if allowed != *new && !store.is_zero(&store.and(&sources, from)?) {
                    sources = store.ite(from, &pre(&allowed)?, &sources)?;
                }
            }
            Ok(sources)
        })
    }

    /// Adds what fires from the states that are new to a cluster, always at the deepest cluster
    /// that has any.
    fn saturate(
        &self,
        store: &Store,
        start: &Bdd,
        tell: &dyn Fn(usize, &Bdd),
        fire: impl Fn(&Cluster, &Bdd) -> Result<Bdd>,
    ) -> Result<Bdd> {
        let mut x = start.clone();
        let mut seen = vec![store.zero(); self.clusters.len()];
        let (mut index, mut firings) = (0, 0);
        while let Some(cluster) = self.clusters.get(index) {
            let new = store.minus(&x, &seen[index])?;
            if store.is_zero(&new) {
                index += 1;
                continue;
            }
            seen[index] = x.clone();
            let next = store.or(&x, &fire(cluster, &new)?)?;
            firings += 1;
            tell(firings, &next);
            index = if next == x { index + 1 } else { 0 };
            x = next;
        }
        Ok(x)
    }

    /// How many relations fire.
    pub(super) fn len(&self) -> usize {
        self.clusters.len()
    }
}

/// Puts the piece into the cluster unless that makes the relation much larger than the two.
fn join(
    store: &Store,
    encoding: &Encoding,
    writes: &mut Vec<crate::model::VarId>,
    cluster: &mut Cluster,
    piece: &Piece,
) -> Result<bool> {
    let mut all = writes.clone();
    all.extend(&piece.writes);
    all.sort_unstable();
    all.dedup();
    let own = frame(store, encoding, &piece.relation, &piece.writes, &all)?;
    let theirs = frame(store, encoding, &cluster.relation, writes, &all)?;
    let union = store.or(&own, &theirs)?;
    let bound = SMALL.max(2 * (store.size(&piece.relation) + store.size(&cluster.relation)));
    if store.size(&union) > bound {
        return Ok(false);
    }
    for part in &mut cluster.parts {
        part.relation = frame(store, encoding, &part.relation, writes, &all)?;
    }
    cluster.parts.push(Part { group: piece.group, relation: own });
    if all != *writes {
        cluster.touched = Rc::new(encoding.touch(&all));
        *writes = all;
    }
    cluster.relation = union;
    Ok(true)
}
