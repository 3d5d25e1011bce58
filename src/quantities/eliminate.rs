//! Linear equations of a Markov chain, by elimination of states.
//!
//! Solves x_i · d_i = b_i + Σ p_ij x_j, where d_i = e_i + Σ p_ij is the probability to leave node i:
//! to other nodes j of the chain, or out of it (e_i). The diagonal is never computed as 1 - p_ii but
//! as this sum, so no subtraction occurs and the relative error stays small, however rarely the
//! chain is left. W. Grassmann, M. Taksar, D. Heyman, "Regenerative analysis and steady state
//! distributions for Markov chains", Operations Research 1985.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::meter::Meter;
use super::number::Weight;
use meliora_model::error::Result;

/// The constant b_i of a row, or several of them: then the equations are solved for each.
pub(super) trait Constant<N>: Clone {
    fn zero() -> Self;
    /// Returns this constant plus a multiple of another one.
    fn plus_times(&self, factor: &N, other: &Self) -> Self;
    fn over(&self, divisor: &N) -> Self;
}

impl<N: Weight> Constant<N> for N {
    fn zero() -> Self {
        N::zero()
    }

    fn plus_times(&self, factor: &N, other: &Self) -> Self {
        self.plus(&factor.times(other))
    }

    fn over(&self, divisor: &N) -> Self {
        Weight::over(self, divisor)
    }
}

impl<const K: usize> Constant<f64> for [f64; K] {
    fn zero() -> Self {
        [0.0; K]
    }

    fn plus_times(&self, factor: &f64, other: &Self) -> Self {
        std::array::from_fn(|at| self[at] + factor * other[at])
    }

    fn over(&self, divisor: &f64) -> Self {
        self.map(|x| x / divisor)
    }
}

/// The row of a node: its edges to other nodes, sorted, and the probability to leave the chain.
#[derive(Debug, Clone)]
pub(super) struct Row<N, C = N> {
    pub(super) edges: Vec<(u32, N)>,
    pub(super) escape: N,
    pub(super) constant: C,
}

impl<N: Weight, C> Row<N, C> {
    /// Returns d, the probability to leave the node.
    pub(super) fn leaving(&self) -> N {
        self.edges.iter().fold(self.escape.clone(), |sum, (_, p)| sum.plus(p))
    }
}

/// Solves the equations; `None` if some node cannot leave the chain, or if elimination would touch more than `most`
/// entries. Memory and time depend on the entries that fill in; nodes with few neighbours are eliminated first.
pub(super) fn solve<N: Weight, C: Constant<N>>(
    rows: Vec<Row<N, C>>,
    most: usize,
    meter: &mut Meter<'_>,
) -> Result<Option<Vec<C>>> {
    let mut work = Elimination::new(rows);
    let taken = work.run(most, meter);
    meter.release(work.bytes);
    Ok(taken?.map(|order| work.substitute(&order)))
}

struct Elimination<N, C> {
    rows: Vec<Row<N, C>>,
    /// The nodes that have an edge to a node, with some that had one.
    sources: Vec<Vec<u32>>,
    done: Vec<bool>,
    /// The probability to leave each node when it was eliminated.
    leaving: Vec<N>,
    /// An empty list, in which the edges of a row are put together.
    spare: Vec<(u32, N)>,
    bytes: usize,
}

impl<N: Weight, C: Constant<N>> Elimination<N, C> {
    fn new(rows: Vec<Row<N, C>>) -> Self {
        let mut sources = vec![Vec::new(); rows.len()];
        for (node, row) in (0..).zip(&rows) {
            row.edges.iter().for_each(|&(to, _)| sources[to as usize].push(node));
        }
        let n = rows.len();
        let (done, leaving) = (vec![false; n], vec![N::zero(); n]);
        Elimination { rows, sources, done, leaving, spare: Vec::new(), bytes: 0 }
    }

    /// Returns the number of entries that the elimination of a node touches.
    fn cost(&self, node: u32) -> usize {
        self.sources[node as usize].len() * self.rows[node as usize].edges.len()
    }

    /// Eliminates all nodes; returns their order. Among nodes of equal cost the last one is first:
    /// components are in postorder, and on a chain that is left at its first node, elimination from
    /// there lets the widths of intervals grow with every step.
    fn run(&mut self, most: usize, meter: &mut Meter<'_>) -> Result<Option<Vec<u32>>> {
        let mut queue: BinaryHeap<_> =
            (0..self.rows.len() as u32).map(|node| Reverse((self.cost(node), Reverse(node)))).collect();
        let (mut order, mut left) = (Vec::with_capacity(self.rows.len()), most);
        while let Some(Reverse((_, Reverse(node)))) = queue.pop() {
            let cost = self.cost(node);
            // The cost may have grown since the node was queued.
            if queue.peek().is_some_and(|&Reverse((next, _))| cost > next) {
                queue.push(Reverse((cost, Reverse(node))));
                meter.step()?;
                continue;
            }
            let Some(less) = left.checked_sub(cost) else { return Ok(None) };
            left = less;
            if !self.eliminate(node, meter)? {
                return Ok(None);
            }
            order.push(node);
        }
        Ok(Some(order))
    }

    /// Replaces the edges into a node by its own edges; returns false if the node cannot be left.
    fn eliminate(&mut self, node: u32, meter: &mut Meter<'_>) -> Result<bool> {
        let row = std::mem::replace(
            &mut self.rows[node as usize],
            Row { edges: Vec::new(), escape: N::zero(), constant: C::zero() },
        );
        let leaving = row.leaving();
        if leaving.is_zero() {
            return Ok(false);
        }
        let mut sources = std::mem::take(&mut self.sources[node as usize]);
        sources.sort_unstable();
        sources.dedup();
        for source in sources {
            meter.step()?;
            if !self.done[source as usize] {
                self.redirect(source, node, &row, &leaving, meter)?;
            }
        }
        self.done[node as usize] = true;
        self.leaving[node as usize] = leaving;
        self.rows[node as usize] = row;
        Ok(true)
    }

    fn redirect(
        &mut self,
        source: u32,
        node: u32,
        row: &Row<N, C>,
        leaving: &N,
        meter: &mut Meter<'_>,
    ) -> Result<()> {
        let Ok(position) = self.rows[source as usize].edges.binary_search_by_key(&node, |edge| edge.0) else {
            return Ok(());
        };
        let own = &mut self.rows[source as usize];
        let factor = own.edges.remove(position).1.over(leaving);
        own.escape = own.escape.plus(&factor.times(&row.escape));
        own.constant = own.constant.plus_times(&factor, &row.constant);
        let before = own.edges.len();
        let edges = &mut self.spare;
        let mut old = own.edges.drain(..).peekable();
        for (to, p) in row.edges.iter().filter(|edge| edge.0 != source) {
            while let Some(edge) = old.next_if(|edge| edge.0 < *to) {
                edges.push(edge);
            }
            let moved = factor.times(p);
            match old.next_if(|edge| edge.0 == *to) {
                Some((_, q)) => edges.push((*to, q.plus(&moved))),
                None => {
                    edges.push((*to, moved));
                    self.sources[*to as usize].push(source);
                }
            }
        }
        edges.extend(old);
        own.edges.extend_from_slice(edges);
        edges.clear();
        let grown = own.edges.len().saturating_sub(before) * (N::BYTES + 12);
        self.bytes += grown;
        meter.take(grown)
    }

    /// Computes the solution from the last eliminated node to the first.
    fn substitute(&self, order: &[u32]) -> Vec<C> {
        let mut x = vec![C::zero(); self.rows.len()];
        for &node in order.iter().rev() {
            let row = &self.rows[node as usize];
            let sum = row
                .edges
                .iter()
                .fold(row.constant.clone(), |sum, (to, p)| sum.plus_times(p, &x[*to as usize]));
            x[node as usize] = sum.over(&self.leaving[node as usize]);
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meliora_engine::NoProgress;

    /// Each of three nodes leads to the others and out of the chain, with the value 1.
    fn rows() -> Vec<Row<f64>> {
        let row = |i: u32| Row {
            edges: (0..3).filter(|&j| j != i).map(|j| (j, 0.25)).collect(),
            escape: 0.5,
            constant: 0.5,
        };
        (0..3).map(row).collect()
    }

    #[test]
    fn elimination_is_given_up_where_it_touches_too_many_entries() {
        let mut meter = Meter::unlimited(&NoProgress);
        assert_eq!(solve(rows(), 3, &mut meter).unwrap(), None);
        let x = solve(rows(), 12, &mut meter).unwrap().unwrap();
        assert!(x.iter().all(|x| (x - 1.0).abs() < 1e-12), "{x:?}");
    }
}
