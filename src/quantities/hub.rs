//! The order of the nodes of a component all of whose cycles pass through a few nodes: the charger of a robot, the
//! start of a round. Such nodes have far more entries than others.
//!
//! A sweep moves a value along an edge if the edge enters a node before its own. Without the edges into these nodes,
//! the component has no cycle, and the postorder of a depth-first search has this for every edge. So one sweep moves
//! values all the way around; see [`super::feedback`].

use std::cmp::Reverse;
use std::ops::Range;

use super::components::{self, Successors};
use super::feedback::MOST;
use super::graph::{Graph, LOST};
use super::meter::Meter;
use super::solve::NONE;
use meliora_model::error::Result;

/// The entries of a hub, as a multiple of the average.
const HUB: usize = 16;

/// Returns the nodes of a strongly connected component in an order in which only few of them, the hubs, are entered
/// from nodes before them; `None` if none was found. `position` has the position of each node in `nodes`, and
/// [`NONE`] for others. Time: linear in nodes and edges.
///
/// # Errors
/// A limit is reached.
pub(super) fn ordered(
    graph: &Graph,
    nodes: &[u32],
    position: &[u32],
    meter: &mut Meter<'_>,
) -> Result<Option<Vec<u32>>> {
    let bytes = nodes.len() * components::SEARCH;
    meter.take(bytes)?;
    let mut inside = Inside { graph, nodes, position, hubs: Vec::new() };
    inside.hubs = hubs(&inside);
    let found = components::components(&inside, inside.hubs.iter().copied());
    let acyclic = found.count() == nodes.len();
    let ordered = acyclic.then(|| found.from(0).iter().map(|&node| nodes[node as usize]).collect());
    meter.release(bytes);
    Ok(ordered)
}

/// Returns the nodes with the most entries, if these are far more than the average.
fn hubs(inside: &Inside<'_>) -> Vec<u32> {
    let nodes = inside.nodes.len();
    let (mut entries, mut edges) = (vec![0_u32; nodes], 0);
    for position in (0..nodes as u32).flat_map(|node| inside.positions(node)) {
        if let Some(to) = inside.at(position) {
            entries[to as usize] += 1;
            edges += 1;
        }
    }
    let many = |&node: &u32| entries[node as usize] as usize * nodes > HUB * edges;
    let mut hubs: Vec<u32> = (0..nodes as u32).filter(many).collect();
    hubs.sort_by_key(|&node| Reverse(entries[node as usize]));
    hubs.truncate(MOST);
    hubs
}

/// A component with all edges between its nodes but those into hubs, by their positions in the component. There may
/// be more edges than the equations follow: only the order depends on them.
struct Inside<'a> {
    graph: &'a Graph,
    nodes: &'a [u32],
    position: &'a [u32],
    hubs: Vec<u32>,
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
        (to != LOST).then(|| self.position[to as usize]).filter(|&at| at != NONE && !self.hubs.contains(&at))
    }
}
