//! Linear equations of a Markov chain, component by component.
//!
//! Solves x_i · d_i = b_i + Σ p_ij x_j, where d_i = e_i + Σ p_ij is the probability to leave node i: to other nodes j of the
//! chain, or out of it (e_i). A strongly connected component is solved after all those that it reaches: a node alone by its
//! equation, several nodes by [elimination](crate::solvers::eliminate). If few nodes reach themselves, this is one pass over
//! the edges.

use std::ops::Range;

use crate::graphs::graph::NONE;
use crate::graphs::meter::{Meter, Stop, Turn, spend};
use crate::solvers::components::{self, Successors};
use crate::solvers::eliminate::{self, Row};
use meliora_base::number::Weight;

/// The edges of a Markov chain. Those of a node are in the order of the nodes that they enter, which it is not one of.
pub(crate) trait Chain<N> {
    /// Returns the number of nodes.
    fn nodes(&self) -> usize;
    /// Returns the positions of the edges of a node.
    fn positions(&self, node: u32) -> Range<u32>;
    /// Returns the node that the edge at a position enters, and its probability.
    fn edge(&self, position: u32) -> (u32, &N);
    /// Returns the probability to leave the chain from a node.
    fn escape(&self, node: u32) -> &N;
}

/// A chain whose nodes are added in their order.
#[derive(Debug)]
pub(crate) struct Listed<N> {
    edges: Vec<(u32, N)>,
    /// The edges of node i are `start[i]..start[i+1]`.
    start: Vec<u32>,
    escapes: Vec<N>,
}

impl<N> Listed<N> {
    /// Creates a chain without nodes.
    pub(crate) fn empty() -> Self {
        Listed { edges: Vec::new(), start: vec![0], escapes: Vec::new() }
    }

    /// Adds a node.
    pub(crate) fn push(&mut self, edges: impl IntoIterator<Item = (u32, N)>, escape: N) {
        self.edges.extend(edges);
        self.start.push(self.edges.len() as u32);
        self.escapes.push(escape);
    }
}

impl<N> Chain<N> for Listed<N> {
    fn nodes(&self) -> usize {
        self.escapes.len()
    }

    fn positions(&self, node: u32) -> Range<u32> {
        self.start[node as usize]..self.start[node as usize + 1]
    }

    fn edge(&self, position: u32) -> (u32, &N) {
        let (to, p) = &self.edges[position as usize];
        (*to, p)
    }

    fn escape(&self, node: u32) -> &N {
        &self.escapes[node as usize]
    }
}

/// Solves the equations for the constants b: one of each node, or as many of each, one node after the other; the solutions
/// have the same form. `left` is the work that may be done, and then the rest of it. Cost: linear, and that of the
/// elimination of the components of several nodes.
///
/// # Errors
/// Some node cannot leave the chain: never; more work is needed than is left: later; a limit is reached.
pub(crate) fn solve<N: Weight>(
    chain: &impl Chain<N>,
    constants: Vec<N>,
    left: &mut usize,
    meter: &mut Meter<'_>,
) -> Turn<Vec<N>> {
    let (nodes, before) = (chain.nodes(), meter.bytes());
    meter.take(nodes * (components::SEARCH + size_of::<u32>()))?;
    let positions = |node: u32| chain.positions(node);
    let successors = Successors { nodes, positions, at: |position: u32| Some(chain.edge(position).0) };
    let found = components::components(&successors, 0..nodes as u32);
    let (per_node, place) = (constants.len() / nodes.max(1), vec![NONE; nodes]);
    let mut part = Part { chain, values: constants, per_node, place };
    let end = found.iter().try_for_each(|component| match *component {
        [node] => part.single(node, left, meter),
        _ => part.several(component, left, meter),
    });
    meter.release_to(before);
    end.map(|()| part.values)
}

/// The solution of some components.
struct Part<'c, C, N> {
    chain: &'c C,
    /// The values of the nodes of these components, and the constants of all others.
    values: Vec<N>,
    per_node: usize,
    /// The places of the nodes of the component that is solved.
    place: Vec<u32>,
}

impl<C: Chain<N>, N: Weight> Part<'_, C, N> {
    /// Solves the equation of a node that is a component of its own.
    fn single(&mut self, node: u32, left: &mut usize, meter: &mut Meter<'_>) -> Turn<()> {
        meter.step()?;
        let Row { escape, .. } = self.row(node);
        if escape.is_zero() {
            return Err(Stop::Never);
        }
        let own = self.own(node);
        for x in &mut self.values[own.clone()] {
            *x = x.over(&escape);
        }
        let entries = self.chain.positions(node).len() + 1;
        let work: usize = self.values[own].iter().map(Weight::work).max().unwrap_or(1);
        spend(left, entries.saturating_mul(work))
    }

    /// Solves the equations of a component of several nodes. Their order is kept, since elimination depends on it.
    fn several(&mut self, component: &[u32], left: &mut usize, meter: &mut Meter<'_>) -> Turn<()> {
        let mut nodes = component.to_vec();
        nodes.sort_unstable();
        (0..).zip(&nodes).for_each(|(at, &node)| self.place[node as usize] = at);
        let rows: Vec<Row<N>> = nodes.iter().map(|&node| self.row(node)).collect();
        let constants = nodes.iter().flat_map(|&node| self.values[self.own(node)].to_vec()).collect();
        let solution = eliminate::solve(rows, constants, left, meter)?;
        for (at, &node) in nodes.iter().enumerate() {
            let own = self.own(node);
            self.values[own].clone_from_slice(&solution[at * self.per_node..(at + 1) * self.per_node]);
            self.place[node as usize] = NONE;
        }
        Ok(())
    }

    /// Returns the places of the values of a node.
    fn own(&self, node: u32) -> Range<usize> {
        let start = node as usize * self.per_node;
        start..start + self.per_node
    }

    /// Returns the row of a node inside of its component. Values at the ends of other edges are added to its constants.
    fn row(&mut self, node: u32) -> Row<N> {
        let chain = self.chain;
        let mut row = Row { edges: Vec::new(), escape: chain.escape(node).clone() };
        let own = self.own(node);
        for (to, p) in chain.positions(node).map(|position| chain.edge(position)) {
            let place = self.place[to as usize];
            if place != NONE {
                row.edges.push((place, p.clone()));
                continue;
            }
            row.escape = row.escape.plus(p);
            for (at, known) in own.clone().zip(self.own(to)) {
                self.values[at] = self.values[at].plus(&p.times(&self.values[known]));
            }
        }
        row
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meliora_base::exact::Ratio;
    use meliora_base::random::Draw;
    use meliora_engine::NoProgress;

    /// Draws a chain that goes down, except that some edges lead back by a few nodes; each node may leave it.
    fn drawn(draw: &mut Draw, nodes: u32, back: u32) -> Listed<Ratio> {
        let mut chain = Listed::empty();
        for node in 0..nodes {
            let mut to: Vec<u32> = (0..draw.below(4)).map(|_| draw.below(node as usize + 1) as u32).collect();
            to.push(node + draw.below(back as usize + 1) as u32);
            to.retain(|&to| to != node && to < nodes);
            to.sort_unstable();
            to.dedup();
            chain.push(
                to.into_iter().map(|to| (to, Ratio::new(1.into(), 8.into()))),
                Ratio::new(1.into(), 8.into()),
            );
        }
        chain
    }

    #[test]
    fn components_have_the_values_of_the_elimination_of_all_nodes() {
        let meter = &mut Meter::unlimited(&NoProgress);
        let mut several = 0;
        for seed in 0..200 {
            let draw = &mut Draw::new(seed);
            let nodes = 1 + draw.below(12) as u32;
            let chain = drawn(draw, nodes, seed as u32 % 3);
            let constants: Vec<Ratio> =
                (0..2 * nodes).map(|_| Ratio::from_integer(draw.below(5).into())).collect();
            let row = |node: u32| Row {
                edges: chain.positions(node).map(|at| chain.edges[at as usize].clone()).collect(),
                escape: chain.escape(node).clone(),
            };
            let rows = (0..nodes).map(row).collect();
            let whole = eliminate::solve(rows, constants.clone(), &mut usize::MAX.clone(), meter).unwrap();
            let parts = solve(&chain, constants, &mut usize::MAX.clone(), meter).unwrap();
            assert_eq!(parts, whole, "seed {seed}");
            let leads_back = |node: u32| chain.positions(node).any(|at| chain.edge(at).0 > node);
            several += usize::from((0..nodes).any(leads_back));
        }
        assert!((50..150).contains(&several), "{several}");
    }

    #[test]
    fn a_long_line_takes_one_pass_and_a_node_that_cannot_leave_none() {
        let meter = &mut Meter::unlimited(&NoProgress);
        let mut line = Listed::empty();
        line.push([], 1.0);
        (1..10_000).for_each(|node| line.push([(node - 1, 1.0)], 0.0));
        let mut left = 20_000;
        let x = solve(&line, vec![1.0; 10_000], &mut left, meter).unwrap();
        assert_eq!((x[9_999], left), (10_000.0, 1));
        assert!(matches!(solve(&line, vec![1.0; 10_000], &mut 19_000, meter), Err(Stop::Later)));
        line.push([], 0.0);
        assert!(matches!(solve(&line, vec![1.0; 10_001], &mut 30_000, meter), Err(Stop::Never)));
    }
}
