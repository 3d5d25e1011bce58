//! An order of the nodes of a graph all of whose cycles pass through a few nodes, the *hubs*: the charger of a robot
//! whose battery decreases, the start of a round. Hubs have far more entries than other nodes.
//!
//! Without the edges into hubs, the graph has no cycle, and each node has a height: the length of the longest path
//! from there. Nodes are ordered by height, so that every other edge enters a node before its own. Then a sweep moves
//! a value all the way around; see [`super::feedback`]. Nodes of one height keep the order of their numbers, in
//! which nodes that are found together have successors near to each other. In the order of a depth-first search, each
//! step would wait for memory.
//!
//! Heights are found by sweeps over all nodes. Numbers of a breadth-first search are nearly an order themselves, so
//! three or four sweeps suffice. Where more would be needed, or other cycles exist, no order is found.

use std::cmp::Reverse;
use std::ops::Range;

use super::components::{Components, Successors};
use super::graph::{Graph, LOST};
use super::meter::Meter;
use super::solve::NONE;
use meliora_model::error::Result;

/// The number of nodes up to which an order saves no time.
pub(super) const SMALL: usize = 1000;
/// The entries of a hub, as a multiple of the average.
const HUB: usize = 16;
/// The greatest number of hubs: one bit each.
const MOST: usize = 64;

/// The nodes of a graph in an order in which only hubs are entered from nodes before them or at them, except for
/// self-loops.
#[derive(Debug)]
pub(super) struct Order {
    nodes: Vec<u32>,
    /// The hubs in this order.
    hubs: Vec<u32>,
}

impl Order {
    /// Finds an order; `None` if none is found. It takes 4 bytes per node, which the caller counts. Time: linear in
    /// nodes and edges for each sweep.
    ///
    /// # Errors
    /// A limit is reached.
    pub(super) fn new(graph: &impl Successors, meter: &mut Meter<'_>) -> Result<Option<Self>> {
        let bytes = 2 * graph.nodes() * size_of::<u32>();
        meter.take(bytes)?;
        let mut hubs = hubs(graph, meter)?;
        let heights = heights(graph, &hubs, meter)?;
        meter.release(bytes);
        Ok(heights.map(|heights| {
            hubs.sort_unstable_by_key(|&hub| (heights[hub as usize], hub));
            Order { nodes: sorted(&heights), hubs }
        }))
    }

    /// Returns the order of the numbers of the nodes; `None` if there are too many hubs. Cost: one pass over the edges.
    pub(super) fn as_numbered(graph: &impl Successors) -> Option<Self> {
        let (nodes, mut hubs) = (0..graph.nodes() as u32, Vec::new());
        for (node, to) in nodes.clone().flat_map(|node| graph.of(node).map(move |to| (node, to))) {
            if to > node && !hubs.contains(&to) {
                hubs.push(to);
                if hubs.len() > MOST {
                    return None;
                }
            }
        }
        hubs.sort_unstable();
        Some(Order { nodes: nodes.collect(), hubs })
    }

    /// Returns the nodes of a component in an order; `None` if none is found. `position` is overwritten: it gets a
    /// place for each node of the component, and has [`NONE`] for others. Cost: see [`Order::new`].
    ///
    /// # Errors
    /// A limit is reached.
    pub(super) fn within(
        graph: &Graph,
        component: &[u32],
        position: &mut [u32],
        meter: &mut Meter<'_>,
    ) -> Result<Option<Vec<u32>>> {
        let mut nodes = component.to_vec();
        nodes.sort_unstable();
        (0..).zip(&nodes).for_each(|(at, &node)| position[node as usize] = at);
        let found = Order::new(&Inside { graph, nodes: &nodes, position }, meter)?;
        Ok(found.map(|order| order.nodes.iter().map(|&at| nodes[at as usize]).collect()))
    }

    /// Returns the strongly connected components of the nodes that are open, as
    /// [`components`](super::components::components) does, but with the nodes of each in this order. `graph` has some
    /// of the edges, none of which enters another node. Time: two passes over the edges.
    ///
    /// # Errors
    /// A limit is reached.
    pub(super) fn components(
        &self,
        graph: &impl Successors,
        is_open: impl Fn(u32) -> bool,
        meter: &mut Meter<'_>,
    ) -> Result<Components> {
        let reach = Reach::new(self, graph, meter)?;
        let parts = reach.parts(self, graph, meter)?;
        let mut sizes = vec![0; 2 * MOST + 1];
        for &node in self.nodes.iter().filter(|&&node| is_open(node)) {
            sizes[usize::from(parts[node as usize])] += 1;
        }
        let mut ends = Vec::new();
        let mut next: Vec<u32> = Vec::with_capacity(sizes.len());
        let mut end = 0;
        for (part, size) in sizes.into_iter().enumerate() {
            next.push(end);
            match is_cyclic(part as u8) {
                true => ends.extend((size > 0).then_some(end + size)),
                false => ends.extend(end + 1..=end + size),
            }
            end += size;
        }
        let mut nodes = vec![0; end as usize];
        for &node in self.nodes.iter().filter(|&&node| is_open(node)) {
            let place = &mut next[usize::from(parts[node as usize])];
            nodes[*place as usize] = node;
            *place += 1;
        }
        Ok(Components::new(nodes, ends))
    }
}

/// Returns the nodes with the most entries, if these are far more than the average.
fn hubs(graph: &impl Successors, meter: &mut Meter<'_>) -> Result<Vec<u32>> {
    let nodes = graph.nodes();
    let (mut entries, mut edges) = (vec![0_u32; nodes], 0);
    for node in 0..nodes as u32 {
        meter.step()?;
        for to in graph.of(node) {
            entries[to as usize] += 1;
            edges += 1;
        }
    }
    let many = |&node: &u32| entries[node as usize] as usize * nodes > HUB * edges;
    let mut hubs: Vec<u32> = (0..nodes as u32).filter(many).collect();
    hubs.sort_by_key(|&node| Reverse(entries[node as usize]));
    hubs.truncate(MOST);
    Ok(hubs)
}

/// Returns the heights of all nodes plus 1; `None` if these are not found by few sweeps.
fn heights(graph: &impl Successors, hubs: &[u32], meter: &mut Meter<'_>) -> Result<Option<Vec<u32>>> {
    let nodes = graph.nodes() as u32;
    // Hubs have the height -1 where they are entered.
    let mut heights = vec![1_u32; graph.nodes()];
    hubs.iter().for_each(|&hub| heights[hub as usize] = 0);
    let above = |node: u32, heights: &[u32]| {
        let others = graph.of(node).filter(|&to| to != node);
        1 + others.map(|to| heights[to as usize]).max().unwrap_or(0)
    };
    // Sweeps in both directions, by turns; each pair must halve the number of changes.
    let mut changed = [usize::MAX; 2];
    for sweep in 0.. {
        let mut changes = 0;
        for at in 0..nodes {
            meter.step()?;
            let node = if sweep % 2 == 0 { nodes - 1 - at } else { at };
            if heights[node as usize] > 0 {
                let height = above(node, &heights);
                changes += usize::from(height != heights[node as usize]);
                heights[node as usize] = height;
            }
        }
        if changes == 0 {
            break;
        }
        if changes > changed[sweep % 2] / 2 {
            return Ok(None);
        }
        changed[sweep % 2] = changes;
    }
    let of_hubs: Vec<u32> = hubs.iter().map(|&hub| above(hub, &heights)).collect();
    hubs.iter().zip(of_hubs).for_each(|(&hub, height)| heights[hub as usize] = height);
    Ok(Some(heights))
}

/// Returns all nodes by height, then by number.
fn sorted(heights: &[u32]) -> Vec<u32> {
    let most = heights.iter().copied().max().unwrap_or(0) as usize;
    let mut next = vec![0_u32; most + 2];
    heights.iter().for_each(|&height| next[height as usize + 1] += 1);
    let mut end = 0;
    for start in &mut next {
        end += *start;
        *start = end;
    }
    let mut nodes = vec![0; heights.len()];
    for (node, &height) in (0..).zip(heights) {
        let place = &mut next[height as usize];
        nodes[*place as usize] = node;
        *place += 1;
    }
    nodes
}

/// The hubs that nodes reach. Bit i stands for hub i of the order.
struct Reach {
    /// The hubs that each node reaches without passing through another one; for a hub, itself.
    first: Vec<u64>,
    /// The position of the class of each hub: hubs that reach each other have the same, and it is greater than those of
    /// others that they reach.
    class: Vec<u8>,
    /// The hubs of each class that reach themselves.
    cyclic: Vec<u64>,
}

impl Reach {
    fn new(order: &Order, graph: &impl Successors, meter: &mut Meter<'_>) -> Result<Self> {
        let mut first = vec![0; graph.nodes()];
        (0..).zip(&order.hubs).for_each(|(number, &hub)| first[hub as usize] = 1_u64 << number);
        let mut all = Vec::with_capacity(order.hubs.len());
        for &node in &order.nodes {
            meter.step()?;
            let found = graph.of(node).fold(0, |found, to| found | first[to as usize]);
            match order.hubs.get(all.len()) == Some(&node) {
                true => all.push(found),
                false => first[node as usize] = found,
            }
        }
        for middle in 0..all.len() {
            let more = all[middle];
            all.iter_mut()
                .filter(|reached| **reached >> middle & 1 == 1)
                .for_each(|reached| *reached |= more);
        }
        // A hub reaches at least as many as those that it reaches, and more than those that do not reach it.
        let with = |number: usize| all[number] | 1 << number;
        let mut classes: Vec<u64> = (0..all.len()).map(with).collect();
        classes.sort_unstable_by_key(|class| (class.count_ones(), *class));
        classes.dedup();
        let (mut class, mut cyclic) = (Vec::with_capacity(all.len()), vec![0; classes.len()]);
        for (number, reached) in all.iter().enumerate() {
            let own = classes.iter().position(|&other| other == with(number)).unwrap_or_default();
            class.push(own as u8);
            cyclic[own] |= reached & 1 << number;
        }
        Ok(Reach { first, class, cyclic })
    }

    /// Returns the part of each node: 2i + 1 for the component of class i, 2i for a node of no such component, which
    /// reaches no class from i on. So parts are ordered, and all other components have one node.
    fn parts(&self, order: &Order, graph: &impl Successors, meter: &mut Meter<'_>) -> Result<Vec<u8>> {
        let part = |&reached: &u64| {
            let hubs = (0..self.class.len()).filter(|number| reached >> number & 1 == 1);
            hubs.map(|number| 2 * self.class[number] + 2).max().unwrap_or(0)
        };
        let mut parts: Vec<u8> = self.first.iter().map(part).collect();
        order.hubs.iter().zip(&self.class).for_each(|(&hub, class)| parts[hub as usize] = 2 * class + 1);
        for &node in order.nodes.iter().rev() {
            meter.step()?;
            let own = parts[node as usize];
            if is_cyclic(own) {
                let class = self.cyclic[usize::from(own / 2)];
                for to in graph.of(node).filter(|&to| self.first[to as usize] & class != 0) {
                    parts[to as usize] = own;
                }
            }
        }
        Ok(parts)
    }
}

/// Returns whether a part is a component.
fn is_cyclic(part: u8) -> bool {
    part % 2 == 1
}

impl Successors for Graph {
    fn nodes(&self) -> usize {
        self.nodes()
    }

    fn positions(&self, node: u32) -> Range<u32> {
        self.edges_of(node)
    }

    fn at(&self, position: u32) -> Option<u32> {
        Some(self.target(position)).filter(|&to| to != LOST)
    }
}

/// A component with all edges between its nodes, by their places. There may be more edges than the equations follow:
/// only the order depends on them.
struct Inside<'a> {
    graph: &'a Graph,
    nodes: &'a [u32],
    position: &'a [u32],
}

impl Successors for Inside<'_> {
    fn nodes(&self) -> usize {
        self.nodes.len()
    }

    fn positions(&self, node: u32) -> Range<u32> {
        self.graph.edges_of(self.nodes[node as usize])
    }

    fn at(&self, position: u32) -> Option<u32> {
        let to = self.graph.target(position);
        (to != LOST).then(|| self.position[to as usize]).filter(|&at| at != NONE)
    }
}

#[cfg(test)]
mod tests {
    use super::super::components;
    use super::*;
    use meliora_engine::NoProgress;
    use meliora_model::random::Draw;

    /// The successors of each node.
    struct Lists(Vec<Vec<u32>>);

    impl Successors for Lists {
        fn nodes(&self) -> usize {
            self.0.len()
        }

        fn positions(&self, node: u32) -> Range<u32> {
            8 * node..8 * node + self.0[node as usize].len() as u32
        }

        fn at(&self, position: u32) -> Option<u32> {
            Some(self.0[position as usize / 8][position as usize % 8])
        }
    }

    /// Draws a graph whose nodes lead to later ones, and, in parts of the numbers, back to a hub of the part or to that
    /// of a later part.
    fn around_hubs(draw: &mut Draw, parts: usize) -> Lists {
        const SIZE: usize = 300;
        let hubs: Vec<usize> = (0..parts).map(|part| part * SIZE + draw.below(SIZE / 2)).collect();
        let nodes = parts * SIZE;
        let list = |node: usize| {
            let part = node / SIZE;
            let later = |draw: &mut Draw| (node + 1 + draw.below(40)).min(nodes - 1) as u32;
            let mut list: Vec<u32> = (0..=draw.below(3)).map(|_| later(draw)).collect();
            list.retain(|&to| to as usize != node);
            // A third of the parts has no cycle.
            let first = if part.is_multiple_of(3) { part + 1 } else { part };
            let hub = first + if draw.below(4) == 0 { draw.below(parts) } else { 0 };
            list.extend(hubs.get(hub).filter(|_| draw.below(2) == 0).map(|&hub| hub as u32));
            list
        };
        Lists((0..nodes).map(list).collect())
    }

    /// Keeps the edges between some nodes.
    fn within(Lists(lists): &Lists, is_open: &[bool]) -> Lists {
        let open = |&&to: &&u32| is_open[to as usize];
        let kept =
            |(list, own): (&Vec<u32>, &bool)| list.iter().filter(|to| *own && open(to)).copied().collect();
        Lists(lists.iter().zip(is_open).map(kept).collect())
    }

    #[test]
    fn components_in_order_are_those_of_a_search() {
        let meter = &mut Meter::unlimited(&NoProgress);
        let (mut cyclic, mut several) = (0, 0);
        for seed in 0..60 {
            let draw = &mut Draw::new(seed);
            let graph = around_hubs(draw, 1 + seed as usize % 9);
            let nodes = graph.nodes() as u32;
            let order = Order::new(&graph, meter).unwrap().unwrap_or_else(|| panic!("seed {seed}: no order"));
            let is_open: Vec<bool> = (0..nodes).map(|_| draw.below(8) > 0).collect();
            let part = within(&graph, &is_open);
            let found = order.components(&part, |node| is_open[node as usize], meter).unwrap();
            let open = (0..nodes).filter(|&node| is_open[node as usize]);
            let expected = components::components(&part, open);
            let mut place = vec![(0, 0); nodes as usize];
            for (number, component) in found.iter().enumerate() {
                (0..).zip(component).for_each(|(at, &node)| place[node as usize] = (number, at));
                cyclic += usize::from(component.len() > 100);
            }
            for (node, to) in (0..nodes).flat_map(|node| part.of(node).map(move |to| (node, to))) {
                let (from, to_place) = (place[node as usize], place[to as usize]);
                assert!(to_place.0 <= from.0, "seed {seed}");
                let earlier = to_place.0 < from.0 || to_place.1 < from.1;
                assert!(earlier || order.hubs.contains(&to), "seed {seed}: {node} {to}");
            }
            let sets = |all: &Components| {
                let sorted = |component: &[u32]| {
                    let mut nodes = component.to_vec();
                    nodes.sort_unstable();
                    nodes
                };
                let mut sets: Vec<Vec<u32>> = all.iter().map(sorted).collect();
                sets.sort_unstable();
                sets
            };
            let large = |all: &Components| all.iter().filter(|component| component.len() > 1).count();
            several += usize::from(large(&expected) > 1);
            assert_eq!(sets(&found), sets(&expected), "seed {seed}");
        }
        assert!(cyclic > 20 && several > 25, "{cyclic} {several}");
    }

    #[test]
    fn a_graph_with_other_cycles_has_no_order() {
        let mut graph = around_hubs(&mut Draw::new(1), 2);
        graph.0[500].push(499);
        graph.0[499] = vec![500];
        assert!(Order::new(&graph, &mut Meter::unlimited(&NoProgress)).unwrap().is_none());
    }
}
