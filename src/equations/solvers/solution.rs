//! The solution of one system of equations. Only the nodes that have an equation take memory.

use crate::graphs::graph::NONE;
use crate::graphs::meter::Meter;
use meliora_base::error::Result;
use meliora_base::number::Number;

/// The solution of one system of equations, as far as it is known.
#[derive(Debug)]
pub(crate) struct Solution<N> {
    /// The nodes that have an equation: the *open* ones.
    open: Members,
    /// The values of all others.
    rest: Rest<N>,
    /// The value of each open node; meaningless unless `known`.
    values: Vec<N>,
    known: Vec<bool>,
    /// The choice that attains the value of each open node, or [`NONE`].
    picks: Vec<u32>,
}

/// The values of the nodes that have no equation.
#[derive(Debug)]
pub(crate) enum Rest<N> {
    /// There are none.
    Unknown,
    /// The values are 0, except that marked nodes have 1.
    Marked { zero: N, one: N, ones: Members },
}

impl<N: Number> Rest<N> {
    /// Returns the value 1 for some nodes, and 0 for all others.
    pub(crate) fn ones(ones: Members) -> Self {
        Rest::Marked { zero: N::zero(), one: N::one(), ones }
    }
}

impl<N: Number> Solution<N> {
    /// Creates a solution of some nodes, with the values of all others.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub(crate) fn new(open: Members, rest: Rest<N>, meter: &mut Meter<'_>) -> Result<Self> {
        let count = open.count();
        meter.take(16 * open.words.len() + count * (N::BYTES + 5))?;
        let (values, known, picks) = (vec![N::zero(); count], vec![false; count], vec![NONE; count]);
        Ok(Solution { open, rest, values, known, picks })
    }

    /// Returns whether any node has an equation.
    pub(crate) fn has_equations(&self) -> bool {
        !self.values.is_empty()
    }

    /// Returns the value of a node; `None` if it is not known or the node has none.
    pub(crate) fn get(&self, node: u32) -> Option<&N> {
        match (self.open.place(node), &self.rest) {
            (Some(place), _) => self.known[place].then(|| &self.values[place]),
            (None, Rest::Unknown) => None,
            (None, Rest::Marked { zero, one, ones }) => {
                Some(if ones.place(node).is_some() { one } else { zero })
            }
        }
    }

    /// Returns whether the value of an open node is known.
    pub(crate) fn knows(&self, node: u32) -> bool {
        self.open.place(node).is_some_and(|place| self.known[place])
    }

    /// Returns the value that was stored last for an open node, known or not.
    pub(crate) fn stored(&self, node: u32) -> &N {
        &self.values[self.at(node)]
    }

    /// Stores a value of an open node, which is then known.
    pub(crate) fn set(&mut self, node: u32, value: N) {
        self.store(node, value);
        self.know(node, true);
    }

    /// Stores a value of an open node without a claim that it is known.
    pub(crate) fn store(&mut self, node: u32, value: N) {
        let place = self.at(node);
        self.values[place] = value;
    }

    /// Says whether the stored value of an open node is known.
    pub(crate) fn know(&mut self, node: u32, known: bool) {
        let place = self.at(node);
        self.known[place] = known;
    }

    /// Replaces the known values.
    pub(crate) fn revise(&mut self, mut revised: impl FnMut(u32, &N) -> N) {
        let Solution { open, values, known, .. } = self;
        for (place, node) in open.iter().enumerate().filter(|(place, _)| known[*place]) {
            values[place] = revised(node, &values[place]);
        }
    }

    /// Returns the choice that attains the value of a node, or [`NONE`].
    pub(crate) fn pick(&self, node: u32) -> u32 {
        self.open.place(node).map_or(NONE, |place| self.picks[place])
    }

    /// Stores the choice that attains the value of an open node.
    pub(crate) fn set_pick(&mut self, node: u32, choice: u32) {
        let place = self.at(node);
        self.picks[place] = choice;
    }

    fn at(&self, node: u32) -> usize {
        let Some(place) = self.open.place(node) else { unreachable!("node {node} has no equation") };
        place
    }
}

/// A set of nodes, and the place of each of them in a list of the set.
#[derive(Debug)]
pub(crate) struct Members {
    words: Vec<u64>,
    /// The number of members before each word.
    before: Vec<u32>,
}

impl Members {
    /// Returns no node of some.
    pub(crate) fn none(nodes: usize) -> Self {
        let words = nodes.div_ceil(64);
        Members { words: vec![0; words], before: vec![0; words] }
    }

    /// Returns some nodes.
    pub(crate) fn new(nodes: usize, is_member: impl Fn(u32) -> bool) -> Self {
        let mut members = Members { words: vec![0; nodes.div_ceil(64)], before: Vec::new() };
        for node in (0..nodes as u32).filter(|&node| is_member(node)) {
            members.words[node as usize / 64] |= 1 << (node % 64);
        }
        let mut sum = 0;
        for word in &members.words {
            members.before.push(sum);
            sum += word.count_ones();
        }
        members
    }

    fn count(&self) -> usize {
        let last = self.words.last().zip(self.before.last());
        last.map_or(0, |(word, before)| (before + word.count_ones()) as usize)
    }

    /// Returns the members in their order.
    fn iter(&self) -> impl Iterator<Item = u32> {
        let of_word = |(at, &word): (usize, &u64)| {
            (0..64).filter(move |bit| word >> bit & 1 == 1).map(move |bit| 64 * at as u32 + bit)
        };
        self.words.iter().enumerate().flat_map(of_word)
    }

    fn place(&self, node: u32) -> Option<usize> {
        // Nodes may be added after the list.
        let (word, bit) = (*self.words.get(node as usize / 64)?, 1 << (node % 64));
        let inside = self.before[node as usize / 64] + (word & (bit - 1)).count_ones();
        (word & bit != 0).then_some(inside as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_have_the_places_of_the_list_of_the_set() {
        let is_member = |node: u32| node.is_multiple_of(3) || node > 190;
        let members = Members::new(200, is_member);
        let list: Vec<u32> = (0..200).filter(|&node| is_member(node)).collect();
        assert_eq!(members.count(), list.len());
        for node in 0..200 {
            assert_eq!(members.place(node), list.iter().position(|&member| member == node));
        }
        assert_eq!(members.iter().collect::<Vec<_>>(), list);
    }
}
