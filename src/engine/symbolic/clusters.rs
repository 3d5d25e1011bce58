//! Relations united for reachability.
//!
//! For reachability it does not matter whose choice a step is: pieces of all groups that depend on
//! the same bit first are united into one *cluster*, as long as the union stays small. Reachability
//! is by [`Saturation`]; where edges are dropped, which no relation says, clusters fire in turn.

use std::sync::{Arc, Mutex, PoisonError};

use ahash::AHashMap;

use super::encoding::Encoding;
use super::relational::Touched;
use super::saturation::{Direction, Saturation};
use super::store::{Bdd, Store};
use super::transitions::{Piece, frame};
use crate::engine::Dropped;
use crate::error::Result;
use crate::model::VarId;

/// A union may have this many nodes whatever its parts have.
const SMALL: usize = 2_000;

/// Some pieces as one relation.
#[derive(Clone)]
pub(super) struct Cluster {
    /// The parts, each over the touched bits of the cluster.
    parts: Vec<Part>,
    pub(super) relation: Bdd,
    pub(super) touched: Arc<Touched>,
    /// The first bit that the relation depends on or touches.
    pub(super) top: u32,
    /// Whether all sources are allowed states, so that no other bound is needed.
    pub(super) confined: bool,
}

#[derive(Clone)]
struct Part {
    group: usize,
    relation: Bdd,
}

/// All clusters, those that act on the first bits first.
pub(super) struct Clusters {
    clusters: Vec<Cluster>,
    /// For each index what the clusters from there on are called, fired forward and backward.
    numbers: [Vec<u32>; 2],
    names: Arc<Names>,
}

/// Numbers for lists of relations: equal lists get equal numbers, so that the operation cache keeps
/// what it knows of the lower clusters when only a higher one changes.
#[derive(Default)]
struct Names(Mutex<AHashMap<(Bdd, u32, u32), u32>>);

impl Names {
    /// For each index the number of the list from there on; even forward, odd backward.
    fn of(&self, clusters: &[Cluster], backward: u32) -> Vec<u32> {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let (mut rest, mut numbers) = (backward, Vec::with_capacity(clusters.len()));
        for cluster in clusters.iter().rev() {
            let next = 2 * (known.len() as u32 + 1) + backward;
            rest = *known.entry((cluster.relation.clone(), cluster.touched.id(), rest)).or_insert(next);
            numbers.push(rest);
        }
        numbers.reverse();
        numbers
    }
}

impl Clusters {
    /// Unites the pieces.
    pub(super) fn new(store: &Store, encoding: &Encoding, pieces: &[Piece]) -> Result<Self> {
        let mut building: Vec<(Vec<VarId>, Cluster)> = Vec::new();
        for piece in pieces {
            let top = first_bit(store, &piece.relation, &piece.touched);
            let mut joined = false;
            for (writes, cluster) in &mut building {
                if cluster.top == top && join(store, encoding, writes, cluster, piece)? {
                    joined = true;
                    break;
                }
            }
            if !joined {
                let parts = vec![Part { group: piece.group, relation: piece.relation.clone() }];
                let (relation, touched) = (piece.relation.clone(), piece.touched.clone());
                let cluster = Cluster { parts, relation, touched, top, confined: false };
                building.push((piece.writes.clone(), cluster));
            }
        }
        Ok(Clusters::sorted(building.into_iter().map(|(_, c)| c).collect(), Arc::default()))
    }

    fn sorted(mut clusters: Vec<Cluster>, names: Arc<Names>) -> Self {
        clusters.sort_by_key(|c| c.top);
        let numbers = [names.of(&clusters, 0), names.of(&clusters, 1)];
        Clusters { clusters, numbers, names }
    }

    /// The same with the steps of each group confined to its allowed states; `None` allows all.
    pub(super) fn allowing(&self, store: &Store, allowed: &[Option<Bdd>]) -> Result<Self> {
        let mut clusters = Vec::new();
        for cluster in &self.clusters {
            if cluster.parts.iter().all(|p| allowed[p.group].is_none()) {
                clusters.push(cluster.clone());
                continue;
            }
            let (mut free, mut bound) = (Vec::new(), Vec::new());
            for part in &cluster.parts {
                match &allowed[part.group] {
                    None => free.push(part.relation.clone()),
                    Some(states) => bound.push(store.and(&part.relation, states)?),
                }
            }
            for (some, confined) in [(free, false), (bound, true)] {
                let relation = store.any(some)?;
                if !store.is_zero(&relation) {
                    let (parts, touched) = (Vec::new(), cluster.touched.clone());
                    let top = first_bit(store, &relation, &touched);
                    clusters.push(Cluster { parts, relation, touched, top, confined });
                }
            }
        }
        Ok(Clusters::sorted(clusters, self.names.clone()))
    }

    /// μX. start ∪ { s' ∈ bound : s → s' for some s ∈ X }
    pub(super) fn forward(
        &self,
        store: &Store,
        start: &Bdd,
        bound: &Bdd,
        tell: &dyn Fn(&Bdd),
    ) -> Result<Bdd> {
        self.saturation(store, Direction::Forward, tell).close(start, bound, 0)
    }

    /// μX. target ∪ { s of the scope : s → s' for some s' ∈ X by an edge that is not dropped }
    pub(super) fn backward(
        &self,
        store: &Store,
        target: &Bdd,
        states: &Bdd,
        dropped: &Dropped<Bdd>,
        tell: &dyn Fn(&Bdd),
    ) -> Result<Bdd> {
        if dropped.is_empty() {
            return self.saturation(store, Direction::Backward, tell).close(target, states, 0);
        }
        self.in_turn(store, target, tell, |cluster, new| {
            let pre = |x: &Bdd| store.pre_within(&cluster.relation, &cluster.touched, x, states);
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

    fn saturation<'a>(
        &'a self,
        store: &'a Store,
        direction: Direction,
        tell: &'a dyn Fn(&Bdd),
    ) -> Saturation<'a> {
        let numbers = &self.numbers[usize::from(direction == Direction::Backward)];
        Saturation { store, clusters: &self.clusters, numbers, direction, tell }
    }

    /// Adds what fires from the states that are new to a cluster, always at the last cluster that
    /// has any: what it moves lies deepest.
    fn in_turn(
        &self,
        store: &Store,
        start: &Bdd,
        tell: &dyn Fn(&Bdd),
        fire: impl Fn(&Cluster, &Bdd) -> Result<Bdd>,
    ) -> Result<Bdd> {
        let mut x = start.clone();
        let mut fired = vec![store.zero(); self.clusters.len()];
        let mut index = self.clusters.len();
        while index > 0 {
            let new = store.minus(&x, &fired[index - 1])?;
            if store.is_zero(&new) {
                index -= 1;
                continue;
            }
            fired[index - 1] = x.clone();
            let next = store.or(&x, &fire(&self.clusters[index - 1], &new)?)?;
            tell(&next);
            index = if next == x { index - 1 } else { self.clusters.len() };
            x = next;
        }
        Ok(x)
    }

    /// How many relations fire.
    pub(super) fn len(&self) -> usize {
        self.clusters.len()
    }
}

/// The first bit that a relation depends on or touches.
fn first_bit(store: &Store, relation: &Bdd, touched: &Touched) -> u32 {
    store.top(relation).min(touched.top().unwrap_or(u32::MAX))
}

/// Puts the piece into the cluster unless that makes the relation much larger than the two.
fn join(
    store: &Store,
    encoding: &Encoding,
    writes: &mut Vec<VarId>,
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
        cluster.touched = Arc::new(encoding.touch(&all));
        *writes = all;
    }
    cluster.relation = union;
    Ok(true)
}
