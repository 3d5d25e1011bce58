//! Strongly connected components and end components, without recursion.
//!
//! `petgraph` needs a graph of its own and visits it by a trait; the solver asks for components of
//! many small subgraphs of one array, so Tarjan's algorithm is written here on slices.

use std::ops::Range;

/// A graph by its lists of successors.
pub(super) trait Successors {
    /// Returns the number of nodes.
    fn nodes(&self) -> usize;
    /// Returns the successor at a position of a node's list; `None` after the last one. A list may
    /// skip positions by [`Successor::None`].
    fn successor(&self, node: u32, position: u32) -> Option<Successor>;
}

/// An entry of a list of successors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Successor {
    /// A node.
    Node(u32),
    /// No node.
    None,
}

const NEW: u32 = u32::MAX;

/// Strongly connected components, one after the other.
#[derive(Debug, Default)]
pub(super) struct Components {
    nodes: Vec<u32>,
    /// The end of each component in `nodes`.
    ends: Vec<u32>,
}

impl Components {
    /// Returns the number of components.
    pub(super) fn count(&self) -> usize {
        self.ends.len()
    }

    /// Returns the nodes of a component.
    pub(super) fn get(&self, number: usize) -> &[u32] {
        &self.nodes[self.start(number)..self.ends[number] as usize]
    }

    /// Returns the nodes of a component and of all after it.
    pub(super) fn from(&self, number: usize) -> &[u32] {
        &self.nodes[self.start(number)..]
    }

    /// Returns the components in their order.
    pub(super) fn iter(&self) -> impl Iterator<Item = &[u32]> {
        (0..self.count()).map(|number| self.get(number))
    }

    fn start(&self, number: usize) -> usize {
        number.checked_sub(1).map_or(0, |before| self.ends[before] as usize)
    }
}

/// Computes the strongly connected components that contain the nodes in `roots` or are reachable
/// from them; each component comes after all components that it can reach. Within a component, the
/// nodes are in postorder: most come after those that they reach.
///
/// R. Tarjan, "Depth-first search and linear graph algorithms", SIAM J. Comput. 1972, with an
/// explicit stack. Time: linear in nodes and edges.
pub(super) fn components(graph: &impl Successors, roots: impl Iterator<Item = u32>) -> Components {
    let n = graph.nodes();
    let mut search =
        Search { index: vec![NEW; n], low: vec![0; n], done: vec![false; n], ..Search::default() };
    for root in roots {
        if search.index[root as usize] == NEW {
            search.run(graph, root);
        }
    }
    search.found
}

#[derive(Default)]
struct Search {
    index: Vec<u32>,
    low: Vec<u32>,
    /// True for the nodes of complete components.
    done: Vec<bool>,
    /// The nodes left for good whose component is not complete.
    finished: Vec<u32>,
    calls: Vec<(u32, u32)>,
    next: u32,
    found: Components,
}

impl Search {
    fn enter(&mut self, node: u32) {
        self.index[node as usize] = self.next;
        self.low[node as usize] = self.next;
        self.next += 1;
        self.calls.push((node, 0));
    }

    fn run(&mut self, graph: &impl Successors, root: u32) {
        self.enter(root);
        while let Some((node, position)) = self.calls.pop() {
            match graph.successor(node, position) {
                Some(Successor::None) => self.calls.push((node, position + 1)),
                Some(Successor::Node(to)) => {
                    self.calls.push((node, position + 1));
                    if self.index[to as usize] == NEW {
                        self.enter(to);
                    } else if !self.done[to as usize] {
                        self.low[node as usize] = self.low[node as usize].min(self.index[to as usize]);
                    }
                }
                None => self.leave(node),
            }
        }
    }

    fn leave(&mut self, node: u32) {
        self.finished.push(node);
        let (low, own) = (self.low[node as usize], self.index[node as usize]);
        if let Some(&(caller, _)) = self.calls.last() {
            self.low[caller as usize] = self.low[caller as usize].min(low);
        }
        if low != own {
            return;
        }
        // The members were entered after this node; what finished before it was not.
        let before = self.finished.iter().rposition(|&other| self.index[other as usize] < own);
        let members = self.finished.drain(before.map_or(0, |position| position + 1)..);
        let Components { nodes, ends } = &mut self.found;
        nodes.extend(members.inspect(|&member| self.done[member as usize] = true));
        ends.push(nodes.len() as u32);
    }
}

/// Choices of numbered nodes, in compressed rows.
#[derive(Debug, Default)]
pub(super) struct Choices {
    /// The choices of node n are `first[n]..first[n+1]`.
    pub(super) first: Vec<u32>,
    /// The successors of choice c are `to[start[c]..start[c+1]]`.
    pub(super) start: Vec<u32>,
    pub(super) to: Vec<u32>,
}

impl Choices {
    /// Returns the choices of a node.
    pub(super) fn of(&self, node: u32) -> Range<usize> {
        self.first[node as usize] as usize..self.first[node as usize + 1] as usize
    }

    /// Returns the successors of a choice.
    pub(super) fn successors(&self, choice: usize) -> &[u32] {
        &self.to[self.start[choice] as usize..self.start[choice + 1] as usize]
    }

    /// Returns the bytes of the rows.
    pub(super) fn bytes(&self) -> usize {
        4 * (self.first.len() + self.start.len() + self.to.len())
    }

    /// Returns the choices that enter each node, as rows, and the node of each choice.
    pub(super) fn reversed(&self) -> (Vec<u32>, Vec<u32>, Vec<u32>) {
        let nodes = self.first.len() - 1;
        let mut rows = vec![0; nodes + 1];
        self.to.iter().for_each(|&to| rows[to as usize] += 1);
        let mut end = 0;
        for row in &mut rows {
            end += *row;
            *row = end;
        }
        let (mut into, mut owner) = (vec![0; self.to.len()], vec![0; self.start.len() - 1]);
        for node in 0..nodes as u32 {
            for choice in self.of(node) {
                owner[choice] = node;
                for &to in self.successors(choice) {
                    rows[to as usize] -= 1;
                    into[rows[to as usize] as usize] = choice as u32;
                }
            }
        }
        (rows, into, owner)
    }
}

/// The maximal end components that some choices form.
#[derive(Debug)]
pub(super) struct EndComponents {
    /// The group of each node: nodes of one end component have the same group, every other node has
    /// a group of its own. The last node of a group in the order of nodes numbers it.
    pub(super) group: Vec<u32>,
    /// The number of groups.
    pub(super) count: usize,
    /// True for each choice inside of an end component.
    pub(super) inside: Vec<bool>,
}

/// Computes the maximal end components of the given choices.
///
/// Removes the choices that leave their strongly connected component, then the nodes without a
/// choice and all choices into them, until nothing changes. Time: linear for each round.
pub(super) fn end_components(choices: &Choices) -> EndComponents {
    let nodes = choices.first.len() - 1;
    let mut inside = vec![true; choices.start.len() - 1];
    let mut left: Vec<u32> = (0..nodes as u32).map(|node| choices.of(node).len() as u32).collect();
    let reversed = choices.reversed();
    let mut lost: Vec<u32> = (0..nodes as u32).filter(|&node| left[node as usize] == 0).collect();
    loop {
        cascade(&reversed, &mut inside, &mut left, lost);
        let graph = Kept { choices, inside: &inside };
        let alive = (0..nodes as u32).filter(|&node| left[node as usize] > 0);
        let found = components(&graph, alive);
        let mut component = vec![NEW; nodes];
        for (number, members) in (0..).zip(found.iter()) {
            members.iter().for_each(|&member| component[member as usize] = number);
        }
        lost = Vec::new();
        let mut changed = false;
        for node in (0..nodes as u32).filter(|&node| component[node as usize] != NEW) {
            let own = component[node as usize];
            for choice in choices.of(node) {
                let leaves = |&to: &u32| component[to as usize] != own;
                if inside[choice] && choices.successors(choice).iter().any(leaves) {
                    inside[choice] = false;
                    left[node as usize] -= 1;
                    changed = true;
                }
            }
            if left[node as usize] == 0 {
                lost.push(node);
            }
        }
        if !changed {
            let (group, count) = numbered(&component, found.count());
            return EndComponents { group, count, inside };
        }
    }
}

/// Removes the choices into lost nodes, and the nodes that have no other.
fn cascade(
    (rows, into, owner): &(Vec<u32>, Vec<u32>, Vec<u32>),
    inside: &mut [bool],
    left: &mut [u32],
    mut lost: Vec<u32>,
) {
    while let Some(node) = lost.pop() {
        for &choice in &into[rows[node as usize] as usize..rows[node as usize + 1] as usize] {
            if std::mem::replace(&mut inside[choice as usize], false) {
                let owner = owner[choice as usize];
                left[owner as usize] -= 1;
                if left[owner as usize] == 0 {
                    lost.push(owner);
                }
            }
        }
    }
}

/// Numbers the groups by their last nodes.
fn numbered(component: &[u32], count: usize) -> (Vec<u32>, usize) {
    let mut last = vec![0; count];
    for (node, &own) in component.iter().enumerate() {
        if own != NEW {
            last[own as usize] = node;
        }
    }
    let (mut group, mut number) = (vec![0; component.len()], vec![0; count]);
    let mut next = 0;
    for (node, &own) in component.iter().enumerate() {
        if own == NEW || last[own as usize] == node {
            group[node] = next;
            if own != NEW {
                number[own as usize] = next;
            }
            next += 1;
        }
    }
    for (node, &own) in component.iter().enumerate() {
        if own != NEW {
            group[node] = number[own as usize];
        }
    }
    (group, next as usize)
}

struct Kept<'a> {
    choices: &'a Choices,
    inside: &'a [bool],
}

impl Successors for Kept<'_> {
    fn nodes(&self) -> usize {
        self.choices.first.len() - 1
    }

    fn successor(&self, node: u32, position: u32) -> Option<Successor> {
        let Choices { first, start, to } = self.choices;
        let (choice, end) = (first[node as usize] as usize, first[node as usize + 1] as usize);
        let index = start[choice] + position;
        if index >= start[end] {
            return None;
        }
        let choice = choice + start[choice..=end].partition_point(|&start| start <= index) - 1;
        Some(if self.inside[choice] { Successor::Node(to[index as usize]) } else { Successor::None })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Lists(Vec<Vec<u32>>);

    impl Successors for Lists {
        fn nodes(&self) -> usize {
            self.0.len()
        }

        fn successor(&self, node: u32, position: u32) -> Option<Successor> {
            self.0[node as usize].get(position as usize).map(|&to| Successor::Node(to))
        }
    }

    #[test]
    fn components_come_after_those_they_reach() {
        let graph = Lists(vec![vec![1], vec![2, 3], vec![1], vec![4], vec![3], vec![0]]);
        let found = components(&graph, 0..6);
        let sorted = |component: &[u32]| {
            let mut nodes = component.to_vec();
            nodes.sort_unstable();
            nodes
        };
        let sorted: Vec<_> = found.iter().map(sorted).collect();
        assert_eq!(sorted, [vec![3, 4], vec![1, 2], vec![0], vec![5]]);
        assert_eq!((found.get(2), found.from(2).len()), (&[0][..], 2));
    }

    #[test]
    fn a_long_chain_needs_no_stack() {
        let n = 300_000;
        let graph = Lists((0..n).map(|i| if i + 1 < n { vec![i + 1] } else { vec![0] }).collect());
        assert_eq!(components(&graph, 0..1).count(), 1);
    }

    fn choices(rows: &[&[&[u32]]]) -> Choices {
        let mut choices = Choices { first: vec![0], start: vec![0], to: Vec::new() };
        for row in rows {
            for to in *row {
                choices.to.extend_from_slice(to);
                choices.start.push(choices.to.len() as u32);
            }
            choices.first.push(choices.start.len() as u32 - 1);
        }
        choices
    }

    #[test]
    fn a_choice_that_may_leave_is_in_no_end_component() {
        // 0 and 1 form one; 2 may leave to 3, which has no choice.
        let choices = choices(&[&[&[1]], &[&[0, 1]], &[&[0, 2]], &[]]);
        let found = end_components(&choices);
        assert_eq!(found.group, [0, 0, 1, 2]);
        assert_eq!((found.count, found.inside), (3, vec![true, true, false]));
    }

    #[test]
    fn what_leads_to_a_dead_end_is_in_no_end_component() {
        // 0 -> 1 -> 0 or 2; 2 -> 3, which has no choice.
        let choices = choices(&[&[&[1]], &[&[0, 2]], &[&[3]], &[]]);
        assert_eq!(end_components(&choices).count, 4);
    }
}
