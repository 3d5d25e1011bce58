//! Strongly connected components and end components, without recursion.
//!
//! `petgraph` needs a graph of its own and visits it by a trait; the solver asks for components of
//! many small subgraphs of one array, so Tarjan's algorithm is written here on slices.

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

/// Computes the strongly connected components that contain the nodes in `roots` or are reachable
/// from them; each component comes after all components that it can reach.
///
/// R. Tarjan, "Depth-first search and linear graph algorithms", SIAM J. Comput. 1972, with an
/// explicit stack. Time: linear in nodes and edges.
pub(super) fn components(graph: &impl Successors, roots: impl Iterator<Item = u32>) -> Vec<Vec<u32>> {
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
    stack: Vec<u32>,
    calls: Vec<(u32, u32)>,
    next: u32,
    found: Vec<Vec<u32>>,
}

impl Search {
    fn enter(&mut self, node: u32) {
        self.index[node as usize] = self.next;
        self.low[node as usize] = self.next;
        self.next += 1;
        self.stack.push(node);
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
        let low = self.low[node as usize];
        if let Some(&(caller, _)) = self.calls.last() {
            self.low[caller as usize] = self.low[caller as usize].min(low);
        }
        if low != self.index[node as usize] {
            return;
        }
        let start = self.stack.iter().rposition(|&other| other == node).unwrap_or(0);
        let component = self.stack.split_off(start);
        component.iter().for_each(|&member| self.done[member as usize] = true);
        self.found.push(component);
    }
}

/// Computes the group of each node: nodes of one maximal end component have the same group, all
/// others a group of their own. `choices[n]` are the choices of node n by their successors; a choice
/// with `None` may not be part of an end component. Returns the groups, and the number of groups.
///
/// Removes the choices that leave their strongly connected component until nothing changes.
pub(super) fn end_components(choices: &[Vec<Option<Vec<u32>>>]) -> (Vec<u32>, usize) {
    let mut kept: Vec<Vec<Option<&[u32]>>> =
        choices.iter().map(|row| row.iter().map(Option::as_deref).collect()).collect();
    loop {
        let graph = Kept(&kept);
        let found = components(&graph, 0..choices.len() as u32);
        let mut group = vec![0; choices.len()];
        for (number, members) in (0..).zip(&found) {
            members.iter().for_each(|&member| group[member as usize] = number);
        }
        let mut changed = false;
        for (node, row) in kept.iter_mut().enumerate() {
            for choice in row.iter_mut() {
                if choice.is_some_and(|to| to.iter().any(|&to| group[to as usize] != group[node])) {
                    *choice = None;
                    changed = true;
                }
            }
        }
        if !changed {
            return (group, found.len());
        }
    }
}

struct Kept<'a>(&'a [Vec<Option<&'a [u32]>>]);

impl Successors for Kept<'_> {
    fn nodes(&self) -> usize {
        self.0.len()
    }

    fn successor(&self, node: u32, position: u32) -> Option<Successor> {
        let mut left = position as usize;
        for choice in self.0[node as usize].iter().flatten() {
            match choice.get(left) {
                Some(&to) => return Some(Successor::Node(to)),
                None => left -= choice.len(),
            }
        }
        None
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
        let mut found = components(&graph, 0..6);
        found.iter_mut().for_each(|c| c.sort_unstable());
        assert_eq!(found, [vec![3, 4], vec![1, 2], vec![0], vec![5]]);
    }

    #[test]
    fn a_long_chain_needs_no_stack() {
        let n = 300_000;
        let graph = Lists((0..n).map(|i| if i + 1 < n { vec![i + 1] } else { vec![0] }).collect());
        assert_eq!(components(&graph, 0..1).len(), 1);
    }

    #[test]
    fn a_choice_that_may_leave_is_in_no_end_component() {
        // 0 and 1 form one; 2 may leave to 3, which has a choice that is not permitted.
        let choices =
            vec![vec![Some(vec![1]), None], vec![Some(vec![0, 1])], vec![Some(vec![0, 2])], vec![None]];
        let (group, count) = end_components(&choices);
        assert_eq!(count, 3);
        assert_eq!(group[0], group[1]);
        assert!(group[2] != group[0] && group[3] != group[2] && group[3] != group[0]);
    }
}
