//! Linear equations of a Markov chain, by elimination of states.
//!
//! Solves x_i · d_i = b_i + Σ p_ij x_j, where d_i = e_i + Σ p_ij is the probability to leave node i:
//! to other nodes j of the chain, or out of it (e_i). The diagonal is never computed as 1 - p_ii but
//! as this sum, so no subtraction occurs and the relative error stays small, however rarely the
//! chain is left. W. Grassmann, M. Taksar, D. Heyman, "Regenerative analysis and steady state
//! distributions for Markov chains", Operations Research 1985.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::graphs::meter::{Meter, Stop, Turn, spend};
use meliora_base::error::Result;
use meliora_base::number::Weight;

/// The row of a node: its edges to other nodes, sorted, and the probability to leave the chain.
#[derive(Debug, Clone)]
pub(crate) struct Row<N> {
    pub(crate) edges: Vec<(u32, N)>,
    pub(crate) escape: N,
}

impl<N: Weight> Row<N> {
    /// Returns d, the probability to leave the node.
    pub(crate) fn leaving(&self) -> N {
        self.edges.iter().fold(self.escape.clone(), |sum, (_, p)| sum.plus(p))
    }
}

/// Solves the equations for the constants b: one of each row, or as many of each, one row after the other; the solutions
/// have the same form. `left` is the work that may be done, and then the rest of it.
///
/// # Errors
/// Some node cannot leave the chain: never; more work is needed than is left: later; a limit is reached.
pub(crate) fn solve<N: Weight>(
    rows: Vec<Row<N>>,
    constants: Vec<N>,
    left: &mut usize,
    meter: &mut Meter<'_>,
) -> Turn<Vec<N>> {
    let before = meter.bytes();
    let end = Elimination::new(rows, constants, meter)
        .map_err(Stop::from)
        .and_then(|mut work| work.run(left, meter));
    meter.release_to(before);
    end
}

/// The elimination of the nodes of a chain, those with few neighbours first. Memory and time depend on the entries that
/// fill in.
struct Elimination<N> {
    rows: Vec<Row<N>>,
    /// The constants of the rows, and at the end the solution.
    constants: Vec<N>,
    /// The number of constants of each row.
    per_row: usize,
    /// The nodes that have an edge to a node, with some that had one.
    sources: Vec<Vec<u32>>,
    done: Vec<bool>,
    /// The nodes that are left, by the entries that their elimination touches. Among nodes of equal cost the last one is
    /// first: components are in postorder, and on a chain that is left at its first node, elimination from there lets
    /// the widths of intervals grow with every step.
    queue: BinaryHeap<Reverse<(usize, Reverse<u32>)>>,
    /// The nodes that are eliminated, in their order.
    order: Vec<u32>,
    /// The probability to leave each node when it was eliminated.
    leaving: Vec<N>,
    /// An empty list, in which the edges of a row are put together.
    spare: Vec<(u32, N)>,
}

impl<N: Weight> Elimination<N> {
    /// Starts with the rows of all nodes.
    ///
    /// # Errors
    /// A limit is reached.
    fn new(rows: Vec<Row<N>>, constants: Vec<N>, meter: &mut Meter<'_>) -> Result<Self> {
        let mut sources = vec![Vec::new(); rows.len()];
        for (node, row) in (0..).zip(&rows) {
            row.edges.iter().for_each(|&(to, _)| sources[to as usize].push(node));
        }
        let n = rows.len();
        let entries: usize = rows.iter().map(|row| row.edges.len()).sum();
        let bytes = entries * (N::BYTES + 12)
            + n * (size_of::<Row<N>>() + N::BYTES + 64)
            + constants.len() * N::BYTES;
        meter.take(bytes)?;
        let mut work = Elimination {
            per_row: constants.len() / n.max(1),
            rows,
            constants,
            sources,
            done: vec![false; n],
            queue: BinaryHeap::new(),
            order: Vec::with_capacity(n),
            leaving: vec![N::zero(); n],
            spare: Vec::new(),
        };
        work.queue = (0..n as u32).map(|node| Reverse((work.cost(node), Reverse(node)))).collect();
        Ok(work)
    }

    /// Returns the number of entries that the elimination of a node touches.
    fn cost(&self, node: u32) -> usize {
        self.sources[node as usize].len() * self.rows[node as usize].edges.len()
    }

    /// Eliminates the nodes that are left, and returns the solution. `left` is the work that may be done, and then what
    /// is left of it.
    ///
    /// # Errors
    /// Some node cannot leave the chain: never; more work is needed than is left: later; a limit
    /// is reached.
    fn run(&mut self, left: &mut usize, meter: &mut Meter<'_>) -> Turn<Vec<N>> {
        while let Some(Reverse((_, Reverse(node)))) = self.queue.pop() {
            let cost = self.cost(node);
            // The cost may have grown since the node was queued.
            if self.queue.peek().is_some_and(|&Reverse((next, _))| cost > next) {
                self.queue.push(Reverse((cost, Reverse(node))));
                meter.step()?;
                continue;
            }
            let leaving = self.rows[node as usize].leaving();
            if leaving.is_zero() {
                return Err(Stop::Never);
            }
            spend(left, cost.saturating_mul(leaving.work()))?;
            self.eliminate(node, leaving, meter)?;
            self.order.push(node);
        }
        Ok(self.substitute())
    }

    /// Replaces the edges into a node by its own edges.
    fn eliminate(&mut self, node: u32, leaving: N, meter: &mut Meter<'_>) -> Result<()> {
        let row =
            std::mem::replace(&mut self.rows[node as usize], Row { edges: Vec::new(), escape: N::zero() });
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
        Ok(())
    }

    fn redirect(
        &mut self,
        source: u32,
        node: u32,
        row: &Row<N>,
        leaving: &N,
        meter: &mut Meter<'_>,
    ) -> Result<()> {
        let Ok(position) = self.rows[source as usize].edges.binary_search_by_key(&node, |edge| edge.0) else {
            return Ok(());
        };
        let factor = self.rows[source as usize].edges.remove(position).1.over(leaving);
        self.add_constants(source, &factor, node);
        let own = &mut self.rows[source as usize];
        own.escape = own.escape.plus(&factor.times(&row.escape));
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
        meter.take(grown)
    }

    /// Adds a multiple of the constants of a row to those of another one.
    fn add_constants(&mut self, to: u32, factor: &N, from: u32) {
        let [to, from] = [to, from].map(|row| row as usize * self.per_row);
        for at in 0..self.per_row {
            self.constants[to + at] = self.constants[to + at].plus(&factor.times(&self.constants[from + at]));
        }
    }

    /// Computes the solution from the last eliminated node to the first.
    fn substitute(&mut self) -> Vec<N> {
        for node in std::mem::take(&mut self.order).into_iter().rev() {
            let row = std::mem::take(&mut self.rows[node as usize].edges);
            row.iter().for_each(|(to, p)| self.add_constants(node, p, *to));
            let own = node as usize * self.per_row;
            for x in &mut self.constants[own..own + self.per_row] {
                *x = x.over(&self.leaving[node as usize]);
            }
        }
        std::mem::take(&mut self.constants)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meliora_engine::NoProgress;

    /// Each of three nodes leads to the others and out of the chain, with the value 1.
    fn rows() -> Vec<Row<f64>> {
        let row =
            |i: u32| Row { edges: (0..3).filter(|&j| j != i).map(|j| (j, 0.25)).collect(), escape: 0.5 };
        (0..3).map(row).collect()
    }

    #[test]
    fn elimination_ends_where_its_work_is_used_up() {
        let meter = &mut Meter::unlimited(&NoProgress);
        assert!(matches!(solve(rows(), vec![0.5; 3], &mut 3, meter), Err(Stop::Later)));
        let x = solve(rows(), vec![0.5; 3], &mut 100, meter).unwrap();
        assert!(x.iter().all(|x| (x - 1.0).abs() < 1e-12), "{x:?}");
    }
}
