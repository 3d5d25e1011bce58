//! Saturation: a reachability fixpoint that goes down the diagram and closes the lower parts first.
//!
//! A relation that depends on no bit above some level acts on every subdiagram below that level by
//! itself. So the fixpoint goes down to the parts that the lowest relations move, closes each of
//! them once and for all (the operation cache remembers it), and fires a higher relation only on
//! what is closed below (Ciardo, Lüttgen and Siminiescu, Saturation, TACAS 2001). All sets stay
//! within a bound that goes down with them (Zhao and Ciardo, Symbolic CTL model checking with
//! constrained saturation, ATVA 2009), so that relations need not be confined to the reachable
//! states, which would make every one depend on every bit.

use super::clusters::Cluster;
use super::store::{Bdd, Store};
use crate::error::Result;

/// Which end of its edges a relation is fired from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Direction {
    /// From sources to successors.
    Forward,
    /// From successors to sources.
    Backward,
}

/// One fixpoint: its relations, sorted by the first bit that each depends on.
pub(super) struct Saturation<'a> {
    pub(super) store: &'a Store,
    pub(super) clusters: &'a [Cluster],
    /// What the clusters from each index on, fired this way, are called in the operation cache.
    pub(super) numbers: &'a [u32],
    pub(super) direction: Direction,
    pub(super) tell: &'a dyn Fn(&Bdd),
}

impl Saturation<'_> {
    /// μY. X ∪ { s ∈ B : one step of a cluster from `index` on joins s and Y }
    pub(super) fn close(&self, x: &Bdd, bound: &Bdd, index: usize) -> Result<Bdd> {
        let store = self.store;
        let Some(cluster) = self.clusters.get(index) else { return Ok(x.clone()) };
        if store.is_zero(x) || x == bound {
            return Ok(x.clone());
        }
        let number = self.numbers[index];
        if let Some(closed) = store.recall(x, bound, number) {
            return Ok(closed);
        }
        let bit = store.top(x).min(store.top(bound));
        let closed = if bit < cluster.top {
            let ((x1, x0), (b1, b0)) = (store.split(x, bit), store.split(bound, bit));
            store.node(bit, &self.close(&x1, &b1, index)?, &self.close(&x0, &b0, index)?)?
        } else {
            self.fire(x, bound, index)?
        };
        store.remember(x, bound, number, &closed);
        Ok(closed)
    }

    /// The same where the cluster at `index` acts on the first bit: fires all that do, each on
    /// what is new to it, and closes the lower parts in between.
    fn fire(&self, x: &Bdd, bound: &Bdd, index: usize) -> Result<Bdd> {
        let top = self.clusters[index].top;
        let here = self.clusters[index..].iter().take_while(|c| c.top == top).count();
        let mut fired = vec![self.store.zero(); here];
        let mut closed = x.clone();
        loop {
            let before = closed.clone();
            closed = self.close(&closed, bound, index + here)?;
            for (cluster, fired) in self.clusters[index..].iter().zip(&mut fired) {
                let new = self.store.minus(&closed, fired)?;
                fired.clone_from(&closed);
                closed = self.store.or(&closed, &self.step(cluster, &new, bound)?)?;
            }
            if index == 0 {
                (self.tell)(&closed);
            }
            if closed == before {
                return Ok(closed);
            }
        }
    }

    fn step(&self, cluster: &Cluster, from: &Bdd, bound: &Bdd) -> Result<Bdd> {
        let (relation, touched) = (&cluster.relation, &cluster.touched);
        match self.direction {
            Direction::Forward => self.store.and(&self.store.image(relation, touched, from)?, bound),
            Direction::Backward if cluster.confined => self.store.pre(relation, touched, from),
            Direction::Backward => self.store.pre_within(relation, touched, from, bound),
        }
    }
}
