//! The order of the nodes of a component for sweeps: from a hub, if there is one.
//!
//! A sweep moves a value along an edge if the edge enters a node before its own. In the postorder of a
//! depth-first search, these are all edges but those back to a node on the path of the search. Where most
//! cycles pass through one node (the charger of a robot, the start of a round), a search that starts there has
//! hardly any others, so a sweep moves values all the way around. Such a node has far more entries than others.

use std::ops::Range;

use super::components::{self, Successors};
use super::graph::{Graph, LOST};
use super::meter::Meter;
use super::solve::NONE;
use meliora_model::error::Result;

/// The entries of a hub, as a multiple of the average.
const HUB: usize = 16;

/// Returns the nodes of a strongly connected component in the postorder of a search from its hub; `None` if
/// no node is one. `position` has the position of each node in `nodes`, and [`NONE`] for others. Time: linear
/// in nodes and edges.
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
    let inside = Inside { graph, nodes, position };
    let ordered = hub(&inside).map(|hub| {
        let found = components::components(&inside, std::iter::once(hub));
        found.get(0).iter().map(|&node| nodes[node as usize]).collect()
    });
    meter.release(bytes);
    Ok(ordered)
}

/// Returns the node with far more entries than others, if there is one.
fn hub(inside: &Inside<'_>) -> Option<u32> {
    let nodes = inside.nodes.len();
    let (mut entries, mut edges) = (vec![0_u32; nodes], 0);
    for position in (0..nodes as u32).flat_map(|node| inside.positions(node)) {
        if let Some(to) = inside.at(position) {
            entries[to as usize] += 1;
            edges += 1;
        }
    }
    let (hub, most) = entries.into_iter().enumerate().max_by_key(|&(_, entries)| entries)?;
    (most as usize * nodes > HUB * edges).then_some(hub as u32)
}

/// A component with all edges between its nodes, by their positions in the component. There may be more than
/// the equations follow: only the order depends on them.
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
