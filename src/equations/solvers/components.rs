//! Strongly connected components and end components, without recursion.
//!
//! `petgraph` needs a graph of its own and visits it by a trait; the solver asks for components of
//! many small subgraphs of one array, so Tarjan's algorithm is written here on slices.

use std::ops::Range;

use bitvec::vec::BitVec;

use crate::graphs::choices::{Choices, Reversed};
use crate::graphs::graph::NONE;
use crate::graphs::meter::Meter;
use meliora_base::error::Result;

/// A graph: the number of its nodes, the range of the positions of each node's successors, and the node at a position, if
/// there is one.
pub(crate) struct Successors<P, A> {
    pub(crate) nodes: usize,
    pub(crate) positions: P,
    pub(crate) at: A,
}

/// The number of a node whose component is complete; that of one that was not visited is 0.
const DONE: u32 = u32::MAX;

/// Strongly connected components, one after the other.
#[derive(Debug, Default)]
pub(crate) struct Components {
    nodes: Vec<u32>,
    /// The end of each component in `nodes`.
    ends: Vec<u32>,
}

impl Components {
    /// Returns the number of components.
    pub(crate) fn count(&self) -> usize {
        self.ends.len()
    }

    /// Returns the nodes of a component.
    pub(crate) fn get(&self, number: usize) -> &[u32] {
        &self.nodes[self.start(number)..self.ends[number] as usize]
    }

    /// Returns the components in their order.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &[u32]> {
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
/// R. Tarjan, "Depth-first search and linear graph algorithms", SIAM J. Comput. 1972, with one number per
/// node (D. Pearce, "A space-efficient algorithm for finding strongly connected components", 2016) and an
/// explicit stack. Time: linear in nodes and edges.
pub(crate) fn components<P: Fn(u32) -> Range<u32>, A: Fn(u32) -> Option<u32>>(
    graph: &Successors<P, A>,
    roots: impl Iterator<Item = u32>,
) -> Components {
    let mut search = Search { number: vec![0; graph.nodes], next: 1, ..Search::default() };
    for root in roots {
        if search.number[root as usize] == 0 {
            search.run(graph, root);
        }
    }
    search.found
}

/// The bytes of a search per node: its number, its places in the result, and those in the stacks, which
/// contain a part of the nodes.
pub(crate) const SEARCH: usize = 20;

/// A node that is visited.
struct Call {
    node: u32,
    /// The number that it got first.
    own: u32,
    /// The positions of the successors that were not looked at.
    left: Range<u32>,
}

#[derive(Default)]
struct Search {
    /// The smallest number among the nodes that a node was seen to reach, except for those of complete
    /// components: these have [`DONE`], which is greater.
    number: Vec<u32>,
    /// The nodes left for good whose component is not complete.
    finished: Vec<u32>,
    calls: Vec<Call>,
    next: u32,
    found: Components,
}

impl Search {
    fn enter(&mut self, positions: &impl Fn(u32) -> Range<u32>, node: u32) {
        self.number[node as usize] = self.next;
        self.calls.push(Call { node, own: self.next, left: positions(node) });
        self.next += 1;
    }

    fn run<P: Fn(u32) -> Range<u32>, A: Fn(u32) -> Option<u32>>(
        &mut self,
        Successors { positions, at, .. }: &Successors<P, A>,
        root: u32,
    ) {
        self.enter(positions, root);
        while let Some(call) = self.calls.last_mut() {
            let node = call.node as usize;
            match call.left.next() {
                Some(position) => {
                    let Some(to) = at(position) else { continue };
                    match self.number[to as usize] {
                        0 => self.enter(positions, to),
                        number => self.number[node] = self.number[node].min(number),
                    }
                }
                None => self.leave(),
            }
        }
    }

    fn leave(&mut self) {
        let Some(Call { node, own, .. }) = self.calls.pop() else { return };
        let number = self.number[node as usize];
        if let Some(caller) = self.calls.last() {
            let caller = &mut self.number[caller.node as usize];
            *caller = (*caller).min(number);
        }
        self.finished.push(node);
        if number != own {
            return;
        }
        // The members were entered after this node; what finished before it was not.
        let before = self.finished.iter().rposition(|&other| self.number[other as usize] < own);
        let members = self.finished.drain(before.map_or(0, |position| position + 1)..);
        let Components { nodes, ends } = &mut self.found;
        nodes.extend(members.inspect(|&member| self.number[member as usize] = DONE));
        ends.push(nodes.len() as u32);
    }
}

impl Choices {
    /// Returns the strongly connected components of the nodes and choices for which `keeps` holds.
    pub(crate) fn components(
        &self,
        roots: impl Iterator<Item = u32>,
        keeps: impl Fn(u32) -> bool,
    ) -> Components {
        let positions = |node: u32| {
            let choices = self.of(node);
            self.start[choices.start]..self.start[choices.end]
        };
        let at = |position: u32| keeps(position).then(|| self.to[position as usize]);
        components(&Successors { nodes: self.first.len() - 1, positions, at }, roots)
    }

    /// Returns the strongly connected components that no choice of their nodes leaves. Cost: linear.
    pub fn bottoms(&self) -> Vec<Vec<u32>> {
        let nodes = self.first.len() - 1;
        let found = self.components(0..nodes as u32, |_| true);
        let mut own = vec![NONE; nodes];
        for (number, members) in (0..).zip(found.iter()) {
            members.iter().for_each(|&member| own[member as usize] = number);
        }
        let is_left = |&node: &u32| {
            let mut ends = self.of(node).flat_map(|choice| self.successors(choice));
            ends.any(|&to| own[to as usize] != own[node as usize])
        };
        found.iter().filter(|members| !members.iter().any(is_left)).map(<[u32]>::to_vec).collect()
    }
}

/// Returns the sets of nodes that reach each other, and no others, by the successors of each node. Cost: linear.
pub fn bottoms(successors: impl Iterator<Item = impl IntoIterator<Item = u32>>) -> Vec<Vec<u32>> {
    let mut chain = Choices::default();
    for own in successors {
        chain.to.extend(own);
        chain.end_choice();
        chain.end_node();
    }
    chain.bottoms()
}

/// The maximal end components that some choices form.
#[derive(Debug)]
pub struct EndComponents {
    /// The group of each node: nodes of one end component have the same group, every other node has
    /// a group of its own. The last node of a group in the order of nodes numbers it.
    pub group: Vec<u32>,
    /// The number of groups.
    pub count: usize,
    /// True for each choice inside of an end component.
    pub inside: Vec<bool>,
}

impl EndComponents {
    /// Returns the nodes of each end component of some choices.
    pub fn members(&self, choices: &Choices) -> Vec<Vec<u32>> {
        let mut members: Vec<Vec<u32>> = vec![Vec::new(); self.count];
        for (node, &group) in (0..).zip(&self.group) {
            if choices.of(node).any(|choice| self.inside[choice]) {
                members[group as usize].push(node);
            }
        }
        members.retain(|members| !members.is_empty());
        members
    }
}

impl Choices {
    /// Computes the maximal end components.
    ///
    /// # Errors
    /// The work is cancelled.
    pub fn end_components(&self, meter: &mut Meter<'_>) -> Result<EndComponents> {
        self.end_components_among(vec![true; self.start.len() - 1], meter)
    }

    /// Computes the maximal end components of the choices that are `inside`.
    ///
    /// Removes the choices that leave their strongly connected component, then the nodes without a
    /// choice and all choices into them, until nothing changes. Time: linear for each round.
    ///
    /// # Errors
    /// The work is cancelled.
    pub fn end_components_among(
        &self,
        mut inside: Vec<bool>,
        meter: &mut Meter<'_>,
    ) -> Result<EndComponents> {
        let nodes = self.first.len() - 1;
        let among = |node: u32| self.of(node).filter(|&choice| inside[choice]).count() as u32;
        let mut left: Vec<u32> = (0..nodes as u32).map(among).collect();
        let mut lost: Vec<u32> = (0..nodes as u32).filter(|&node| left[node as usize] == 0).collect();
        let mut reversed = None;
        loop {
            let enters_lost = |choice| self.successors(choice).iter().any(|&to| left[to as usize] == 0);
            if (0..inside.len()).any(|choice| inside[choice] && enters_lost(choice)) {
                let reversed = reversed.get_or_insert_with(|| self.reversed());
                cascade(reversed, &mut inside, &mut left, lost);
            }
            let mut kept = BitVec::<usize>::repeat(false, self.to.len());
            for choice in (0..inside.len()).filter(|&choice| inside[choice]) {
                kept[self.start[choice] as usize..self.start[choice + 1] as usize].fill(true);
            }
            let is_alive = |node: u32| left[node as usize] > 0;
            meter.step()?;
            let alive = (0..nodes as u32).filter(|&node| is_alive(node));
            let found = self.components(alive, |position| kept[position as usize]);
            let mut component = vec![NONE; nodes];
            for (number, members) in (0..).zip(found.iter()) {
                members.iter().for_each(|&member| component[member as usize] = number);
            }
            lost = Vec::new();
            let mut changed = false;
            for node in (0..nodes as u32).filter(|&node| component[node as usize] != NONE) {
                let own = component[node as usize];
                for choice in self.of(node) {
                    let leaves = |&to: &u32| component[to as usize] != own;
                    if inside[choice] && self.successors(choice).iter().any(leaves) {
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
                return Ok(EndComponents { group, count, inside });
            }
        }
    }
}

/// Removes the choices into lost nodes, and the nodes that have no other.
fn cascade(reversed: &Reversed, inside: &mut [bool], left: &mut [u32], mut lost: Vec<u32>) {
    while let Some(node) = lost.pop() {
        for &choice in reversed.entering(node) {
            if std::mem::replace(&mut inside[choice as usize], false) {
                let owner = reversed.owner[choice as usize];
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
    let (mut number, mut group) = (vec![NONE; count], vec![0; component.len()]);
    let mut next = 0;
    // From the last node on, and then the other way round.
    for (node, &own) in component.iter().enumerate().rev() {
        if own == NONE || number[own as usize] == NONE {
            group[node] = next;
            next += 1;
        }
        if own != NONE {
            number[own as usize] =
                if number[own as usize] == NONE { group[node] } else { number[own as usize] };
            group[node] = number[own as usize];
        }
    }
    group.iter_mut().for_each(|group| *group = next - 1 - *group);
    (group, next as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use meliora_base::random::Draw;
    use meliora_engine::NoProgress;

    /// A graph in which each node has one choice.
    fn found(rows: &[&[u32]], roots: Range<u32>) -> Components {
        let choices: Vec<&[&[u32]]> = rows.iter().map(std::slice::from_ref).collect();
        let choices = choices_of(&choices);
        choices.components(roots, |_| true)
    }

    #[test]
    fn components_come_after_those_they_reach() {
        let found = found(&[&[1], &[2, 3], &[1], &[4], &[3], &[0]], 0..6);
        let sorted = |component: &[u32]| {
            let mut nodes = component.to_vec();
            nodes.sort_unstable();
            nodes
        };
        let sorted: Vec<_> = found.iter().map(sorted).collect();
        assert_eq!(sorted, [vec![3, 4], vec![1, 2], vec![0], vec![5]]);
        assert_eq!(found.get(2), [0]);
    }

    #[test]
    fn a_long_chain_needs_no_stack() {
        let n = 300_000;
        let next: Vec<u32> = (0..n).map(|i| (i + 1) % n).collect();
        let rows: Vec<&[u32]> = next.chunks(1).collect();
        assert_eq!(found(&rows, 0..1).count(), 1);
    }

    fn choices_of(rows: &[&[&[u32]]]) -> Choices {
        let mut choices = Choices::default();
        for row in rows {
            for to in *row {
                choices.to.extend_from_slice(to);
                choices.end_choice();
            }
            choices.end_node();
        }
        choices
    }

    #[test]
    fn a_choice_that_may_leave_is_in_no_end_component() {
        // 0 and 1 form one; 2 may leave to 3, which has no choice.
        let choices = choices_of(&[&[&[1]], &[&[0, 1]], &[&[0, 2]], &[]]);
        let found = choices.end_components(&mut Meter::unlimited(&NoProgress)).unwrap();
        assert_eq!(found.group, [0, 0, 1, 2]);
        assert_eq!((found.count, found.inside), (3, vec![true, true, false]));
    }

    #[test]
    fn end_components_do_not_depend_on_the_numbers() {
        const NODES: usize = 2000;
        let (mut united, mut alone) = (0, 0);
        for seed in 0..20 {
            let draw = &mut Draw::new(seed);
            // Choices lead to earlier nodes or to a hub at the end; the first nodes have few that stay.
            let hub = |draw: &mut Draw| (NODES - 1 - draw.below(1 + seed as usize % 4)) as u32;
            let choice = |draw: &mut Draw, node: usize| {
                let earlier = (node - 1 - draw.below(node.min(30))) as u32;
                if draw.below(6) == 0 { vec![earlier, hub(draw)] } else { vec![earlier] }
            };
            let mut row = |node: usize| match node {
                ..40 if draw.below(2) == 0 => Vec::new(),
                ..40 => vec![vec![hub(draw)]],
                _ => (0..=draw.below(2)).map(|_| choice(draw, node)).collect(),
            };
            let rows: Vec<Vec<Vec<u32>>> = (0..NODES).map(&mut row).collect();
            let mut place: Vec<u32> = (0..NODES as u32).collect();
            (1..NODES).for_each(|last| place.swap(last, draw.below(last + 1)));
            let mut moved = vec![Vec::new(); NODES];
            for (row, &at) in rows.iter().zip(&place) {
                let to = |to: &Vec<u32>| to.iter().map(|&to| place[to as usize]).collect::<Vec<u32>>();
                moved[at as usize] = row.iter().map(to).collect();
            }
            let find = |rows: &[Vec<Vec<u32>>]| {
                let rows: Vec<Vec<&[u32]>> =
                    rows.iter().map(|row| row.iter().map(Vec::as_slice).collect()).collect();
                let rows: Vec<&[&[u32]]> = rows.iter().map(Vec::as_slice).collect();
                let choices = choices_of(&rows);
                let found = choices.end_components(&mut Meter::unlimited(&NoProgress)).unwrap();
                (found, choices)
            };
            let ((one, choices), (other, others)) = (find(&rows), find(&moved));
            assert_eq!(one.count, other.count, "seed {seed}");
            let mut same = vec![NONE; one.count];
            for (node, &at) in place.iter().enumerate() {
                let own = &mut same[one.group[node] as usize];
                assert!(*own == NONE || *own == other.group[at as usize], "seed {seed}: {node}");
                *own = other.group[at as usize];
                let inside = |found: &EndComponents, range: Range<usize>| found.inside[range].to_vec();
                let pair = [inside(&one, choices.of(node as u32)), inside(&other, others.of(at))];
                assert_eq!(pair[0], pair[1], "seed {seed}: {node}");
            }
            (united, alone) = (united + usize::from(one.count < NODES), alone + one.count);
        }
        assert!(united > 10 && alone > 5000, "{united} {alone}");
    }

    #[test]
    fn what_leads_to_a_dead_end_is_in_no_end_component() {
        // 0 -> 1 -> 0 or 2; 2 -> 3, which has no choice.
        let choices = choices_of(&[&[&[1]], &[&[0, 2]], &[&[3]], &[]]);
        assert_eq!(choices.end_components(&mut Meter::unlimited(&NoProgress)).unwrap().count, 4);
    }
}
