//! Finite graphs with choices, and textbook fixpoints over them. They serve the states of a model and the nodes of a
//! policy alike, and share no code with the engines.

use std::ops::Range;

use meliora_base::error::Limit;
use meliora_base::progress::{Poll, ProgressSink};

/// A set of nodes.
pub(super) type Set = Vec<bool>;

/// Nodes with choices, each of which leads to one or more nodes. In some nodes, the opponent chooses.
pub(super) struct Graph<'s> {
    sink: &'s dyn ProgressSink,
    theirs: Vec<bool>,
    /// The end of the choices of each node.
    choices: Vec<usize>,
    /// The end of the successors of each choice.
    ends: Vec<usize>,
    to: Vec<usize>,
    /// The choices that are left.
    live: Vec<bool>,
}

fn range(ends: &[usize], at: usize) -> Range<usize> {
    at.checked_sub(1).map_or(0, |before| ends[before])..ends[at]
}

impl<'s> Graph<'s> {
    pub(super) fn new(sink: &'s dyn ProgressSink) -> Self {
        let (theirs, choices, ends, to, live) = Default::default();
        Graph { sink, theirs, choices, ends, to, live }
    }

    /// Adds the next node with the successors of each of its choices.
    pub(super) fn add(&mut self, theirs: bool, choices: impl IntoIterator<Item = Vec<usize>>) {
        for choice in choices {
            self.to.extend(choice);
            self.ends.push(self.to.len());
            self.live.push(true);
        }
        self.theirs.push(theirs);
        self.choices.push(self.ends.len());
    }

    pub(super) fn len(&self) -> usize {
        self.theirs.len()
    }

    /// Returns whether the opponent chooses in some node.
    pub(super) fn is_game(&self) -> bool {
        self.theirs.contains(&true)
    }

    /// Returns the successors of each choice that is left to a node.
    pub(super) fn choices(&self, node: usize) -> impl Iterator<Item = &[usize]> {
        let live = range(&self.choices, node).filter(|&choice| self.live[choice]);
        live.map(|choice| &self.to[range(&self.ends, choice)])
    }

    pub(super) fn successors(&self, node: usize) -> impl Iterator<Item = usize> {
        self.choices(node).flatten().copied()
    }

    /// Leaves only the choices of a set that stay in it.
    pub(super) fn restrict(&mut self, set: &[bool]) {
        for node in 0..self.len() {
            for choice in range(&self.choices, node) {
                let stays = self.to[range(&self.ends, choice)].iter().all(|&to| set[to]);
                self.live[choice] &= set[node] && stays;
            }
        }
    }

    /// Returns whether we can choose successors that pass a test or, in a node of the opponent, whether all that it can
    /// choose do.
    pub(super) fn can_choose(&self, node: usize, test: impl Fn(&[usize]) -> bool) -> bool {
        let mut choices = self.choices(node).peekable();
        choices.peek().is_some() && if self.theirs[node] { choices.all(test) } else { choices.any(test) }
    }

    /// Adds nodes to a set, or removes them, as long as a test asks for it.
    fn change(&self, mut set: Set, from: bool, test: impl Fn(usize, &[bool]) -> bool) -> Result<Set, Limit> {
        let (mut poll, mut backward, mut changed) = (Poll::new(self.sink), true, true);
        while changed {
            changed = false;
            for at in 0..self.len() {
                poll.step()?;
                let node = if backward { self.len() - 1 - at } else { at };
                if set[node] == from && test(node, &set) {
                    (set[node], changed) = (!from, true);
                }
            }
            backward = !backward;
        }
        Ok(set)
    }

    /// Computes μX. set ∪ { v : grows(v, X) }.
    pub(super) fn least(&self, set: Set, grows: impl Fn(usize, &[bool]) -> bool) -> Result<Set, Limit> {
        self.change(set, false, grows)
    }

    /// Computes νX. set ∩ { v : keeps(v, X) }.
    pub(super) fn greatest(&self, set: Set, keeps: impl Fn(usize, &[bool]) -> bool) -> Result<Set, Limit> {
        self.change(set, true, |node, set| !keeps(node, set))
    }

    /// Computes νZ. set ∩ can_choose(all successors in Z).
    pub(super) fn staying(&self, set: Set) -> Result<Set, Limit> {
        self.greatest(set, |node, z| self.can_choose(node, |to| all_in(z, to)))
    }

    /// Computes νY. μX. goal ∪ can_choose(all successors in Y and some in X).
    pub(super) fn almost_surely(&self, goal: &[bool]) -> Result<Set, Limit> {
        let mut y = vec![true; self.len()];
        loop {
            let x = self.least(goal.to_vec(), |node, x| {
                y[node] && self.can_choose(node, |to| all_in(&y, to) && some_in(x, to))
            })?;
            if x == y {
                return Ok(y);
            }
            y = x;
        }
    }

    /// Computes νY. μX. νZ. can_choose(C) for the choices C with all successors in Y of nodes in `again`, those with also
    /// some successor in X, and those with also all successors in Z of nodes in `settled`: paths are again and again in
    /// the first set, or finally always in the second one.
    pub(super) fn again_or_settled(&self, again: &[bool], settled: &[bool]) -> Result<Set, Limit> {
        let mut y = vec![true; self.len()];
        loop {
            let mut x = vec![false; self.len()];
            loop {
                let z = self.greatest(y.clone(), |node, z| {
                    self.can_choose(node, |to| {
                        let leads = again[node] || some_in(&x, to) || settled[node] && all_in(z, to);
                        all_in(&y, to) && leads
                    })
                })?;
                if z == x {
                    break;
                }
                x = z;
            }
            if x == y {
                return Ok(y);
            }
            y = x;
        }
    }

    /// Returns the maximal end components within a set, whoever chooses: sets of nodes with choices that stay in the set
    /// and lead from each of its nodes to each other one.
    pub(super) fn end_components(&self, within: &[bool]) -> Result<Vec<Vec<usize>>, Limit> {
        let mut of: Vec<Option<usize>> = within.iter().map(|is_in| is_in.then_some(0)).collect();
        loop {
            let next = self.strongly_connected(&of)?;
            if next == of {
                break;
            }
            of = next;
        }
        let mut all = std::collections::BTreeMap::<usize, Vec<usize>>::new();
        for (node, component) in of.iter().enumerate() {
            component.iter().for_each(|&component| all.entry(component).or_default().push(node));
        }
        Ok(all.into_values().collect())
    }

    /// Divides each part into its strongly connected parts, with the choices that stay in the part; a node without such a
    /// choice is in none. A part is named by its least node.
    fn strongly_connected(&self, part: &[Option<usize>]) -> Result<Vec<Option<usize>>, Limit> {
        let mut poll = Poll::new(self.sink);
        let next = |node: usize| -> Vec<usize> {
            let stays = |to: &&[usize]| to.iter().all(|&to| part[to].is_some() && part[to] == part[node]);
            self.choices(node).filter(stays).flatten().copied().collect()
        };
        let mut found = Tarjan {
            order: vec![0; part.len()],
            low: vec![0; part.len()],
            stack: Vec::new(),
            of: vec![None; part.len()],
        };
        let mut count = 0;
        for root in (0..part.len()).filter(|&root| part[root].is_some()) {
            if found.order[root] > 0 {
                continue;
            }
            let mut calls = vec![(root, next(root), 0)];
            found.enter(root, &mut count);
            while let Some((node, to, at)) = calls.last_mut() {
                poll.step()?;
                let node = *node;
                if let Some(&child) = to.get(*at) {
                    *at += 1;
                    if found.order[child] == 0 {
                        found.enter(child, &mut count);
                        calls.push((child, next(child), 0));
                    } else if found.of[child].is_none() {
                        found.low[node] = found.low[node].min(found.order[child]);
                    }
                    continue;
                }
                let is_alone = to.is_empty();
                calls.pop();
                if let Some((parent, ..)) = calls.last() {
                    found.low[*parent] = found.low[*parent].min(found.low[node]);
                }
                found.leave(node);
                if is_alone {
                    found.of[node] = Some(usize::MAX);
                }
            }
        }
        Ok(found.of.into_iter().map(|of| of.filter(|&of| of != usize::MAX)).collect())
    }
}

/// The state of Tarjan's algorithm.
struct Tarjan {
    /// The number of each node in the order of visits, from 1; 0 before its visit.
    order: Vec<usize>,
    low: Vec<usize>,
    stack: Vec<usize>,
    /// The component of each node, once it is known.
    of: Vec<Option<usize>>,
}

impl Tarjan {
    fn enter(&mut self, node: usize, count: &mut usize) {
        *count += 1;
        (self.order[node], self.low[node]) = (*count, *count);
        self.stack.push(node);
    }

    /// Takes the component of a node from the stack if the node is its first one.
    fn leave(&mut self, node: usize) {
        if self.low[node] < self.order[node] {
            return;
        }
        let start = self.stack.iter().rposition(|&other| other == node).unwrap_or_default();
        let own = self.stack.split_off(start);
        let name = own.iter().copied().min();
        own.into_iter().for_each(|other| self.of[other] = name);
    }
}

pub(super) fn all_in(set: &[bool], nodes: &[usize]) -> bool {
    nodes.iter().all(|&node| set[node])
}

pub(super) fn some_in(set: &[bool], nodes: &[usize]) -> bool {
    nodes.iter().any(|&node| set[node])
}

#[cfg(test)]
mod tests {
    use super::*;
    use meliora_base::progress::NoProgress;

    fn graph(nodes: &[(bool, &[&[usize]])]) -> Graph<'static> {
        let mut graph = Graph::new(&NoProgress);
        nodes.iter().for_each(|(theirs, choices)| graph.add(*theirs, choices.iter().map(|to| to.to_vec())));
        graph
    }

    fn members(set: &[bool]) -> Vec<usize> {
        (0..set.len()).filter(|&node| set[node]).collect()
    }

    #[test]
    fn end_components_have_a_choice_that_stays_in_each_node() {
        let found = graph(&[
            (false, &[&[1], &[2]]),
            (false, &[&[0, 3], &[2]]),
            (false, &[&[2]]),
            (false, &[&[3, 0], &[4]]),
            (false, &[]),
        ]);
        let all = found.end_components(&[true; 5]).unwrap();
        assert_eq!(all, [vec![0, 1, 3], vec![2]]);
        // Without node 3, no choice of node 1 but that into node 2 is left.
        assert_eq!(found.end_components(&[true, true, true, false, true]).unwrap(), [vec![2]]);
    }

    #[test]
    fn the_opponent_keeps_from_the_goal_where_it_can_choose() {
        let nodes: [(bool, &[&[usize]]); 4] =
            [(false, &[&[1]]), (true, &[&[2], &[0]]), (false, &[&[2]]), (false, &[&[1, 2]])];
        let goal = [false, false, true, false];
        let found = graph(&nodes);
        assert_eq!(members(&found.almost_surely(&goal).unwrap()), [2]);
        let mut alone = nodes;
        alone[1].0 = false;
        assert_eq!(members(&graph(&alone).almost_surely(&goal).unwrap()), [0, 1, 2, 3]);
        assert!(found.is_game() && !graph(&alone).is_game());
    }

    #[test]
    fn paths_are_again_and_again_in_one_set_or_finally_always_in_the_other() {
        let found = graph(&[(true, &[&[0], &[1]]), (false, &[&[0], &[2]]), (false, &[&[2]])]);
        let [none, first, second, third] =
            [[false; 3], [true, false, false], [false, true, false], [false, false, true]];
        assert_eq!(members(&found.again_or_settled(&first, &none).unwrap()), [0, 1]);
        assert_eq!(members(&found.again_or_settled(&second, &none).unwrap()), [] as [usize; 0]);
        assert_eq!(members(&found.again_or_settled(&second, &first).unwrap()), [0, 1]);
        assert_eq!(members(&found.again_or_settled(&none, &third).unwrap()), [1, 2]);
    }
}
