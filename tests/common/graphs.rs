//! Markov chains that strategies induce, as lists of successors.

use meliora::planning::induced_model::Node;

use crate::common::prelude::*;

pub(crate) type Set = BTreeSet<usize>;

/// For each node the nodes it may lead to, each with whether the step is an improvement.
pub(crate) fn edges(unfolded: &InducedModel) -> Vec<Vec<(usize, bool)>> {
    let of = |node: &Node| {
        let pairs = node.at.actions.iter().zip(&node.next);
        pairs
            .flat_map(|(a, next)| a.successors.iter().zip(next))
            .filter_map(|(s, to)| to.map(|to| (to, s.improves)))
            .collect()
    };
    unfolded.nodes.iter().map(of).collect()
}

/// The chain of the nodes; one where a path ends leads to itself.
pub(crate) fn chain(edges: &[Vec<(usize, bool)>]) -> Vec<Vec<usize>> {
    let to = |(node, to): (usize, &Vec<(usize, bool)>)| match to.is_empty() {
        true => vec![node],
        false => to.iter().map(|(to, _)| *to).collect(),
    };
    edges.iter().enumerate().map(to).collect()
}

/// The states reached from `s` in a chain, `s` among them; none beyond `absorbing`.
pub(crate) fn reached(chain: &[Vec<usize>], s: usize, absorbing: &Set) -> Set {
    let (mut seen, mut stack) = (Set::from([s]), vec![s]);
    while let Some(at) = stack.pop() {
        if !absorbing.contains(&at) {
            stack.extend(chain[at].iter().filter(|&&t| seen.insert(t)));
        }
    }
    seen
}

/// The bottom components reached from `s`: each as its set of states.
pub(crate) fn bottom_components(chain: &[Vec<usize>], s: usize, absorbing: &Set) -> Vec<Set> {
    let mut bottoms = Vec::new();
    for t in reached(chain, s, absorbing) {
        let component = reached(chain, t, absorbing);
        let is_bottom = component.iter().all(|&u| reached(chain, u, absorbing) == component);
        if is_bottom && !bottoms.contains(&component) {
            bottoms.push(component);
        }
    }
    bottoms
}
