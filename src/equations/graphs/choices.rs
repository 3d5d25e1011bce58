//! The choices of nodes and their successors, in both directions.

use std::ops::Range;

/// Choices of numbered nodes, in compressed rows.
#[derive(Debug, Clone)]
pub struct Choices {
    /// The choices of node n are `first[n]..first[n+1]`.
    pub(crate) first: Vec<u32>,
    /// The successors of choice c are `to[start[c]..start[c+1]]`.
    pub(crate) start: Vec<u32>,
    pub(crate) to: Vec<u32>,
}

impl Default for Choices {
    fn default() -> Self {
        Choices { first: vec![0], start: vec![0], to: Vec::new() }
    }
}

impl Choices {
    /// Returns the choices of a node.
    #[inline]
    pub fn of(&self, node: u32) -> Range<usize> {
        self.first[node as usize] as usize..self.first[node as usize + 1] as usize
    }

    /// Returns the successors of a choice.
    #[inline]
    pub fn successors(&self, choice: usize) -> &[u32] {
        &self.to[self.start[choice] as usize..self.start[choice + 1] as usize]
    }

    /// Ends the choice whose successors were added.
    pub(crate) fn end_choice(&mut self) {
        self.start.push(self.to.len() as u32);
    }

    /// Ends the node whose choices were added.
    pub(crate) fn end_node(&mut self) {
        self.first.push(self.start.len() as u32 - 1);
    }

    /// Returns the bytes of the rows.
    pub(crate) fn bytes(&self) -> usize {
        4 * (self.first.len() + self.start.len() + self.to.len())
    }

    /// Returns the node of each choice. Cost: linear.
    pub fn owners(&self) -> Vec<u32> {
        (0..self.first.len() as u32 - 1).flat_map(|node| self.of(node).map(move |_| node)).collect()
    }

    /// Returns the choices that enter each node, and the node of each choice. Cost: linear.
    pub(crate) fn reversed(&self) -> Reversed {
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
        Reversed { first: rows, choices: into, owner }
    }
}

/// The choices that enter each node.
#[derive(Debug)]
pub(crate) struct Reversed {
    first: Vec<u32>,
    choices: Vec<u32>,
    /// The node of each choice.
    pub(crate) owner: Vec<u32>,
}

impl Reversed {
    /// Returns the choices that enter a node.
    pub(crate) fn entering(&self, node: u32) -> &[u32] {
        &self.choices[self.first[node as usize] as usize..self.first[node as usize + 1] as usize]
    }
}
