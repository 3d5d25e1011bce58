//! Decision diagrams as plain data: shared, reduced, with complemented else arcs.

use num_bigint::BigUint;
use serde::{Deserialize, Serialize};

use crate::error::{Limit, Result};

/// An arc: the number of a node (from 1, the terminal), negative if the function is complemented.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "i32", into = "i32")]
pub struct Edge(i32);

impl TryFrom<i32> for Edge {
    type Error = String;

    fn try_from(number: i32) -> Result<Self, String> {
        Edge::new(number.into()).ok_or_else(|| format!("{number} is not the number of a node"))
    }
}

impl From<Edge> for i32 {
    fn from(edge: Edge) -> Self {
        edge.0
    }
}

impl Edge {
    /// The constant true: the terminal.
    pub const TRUE: Edge = Edge(1);
    /// The constant false.
    pub const FALSE: Edge = Edge(-1);

    /// Returns the arc with this number in the file format; none for 0 and for numbers past 31
    /// bits.
    pub fn new(number: i64) -> Option<Self> {
        i32::try_from(number).ok().filter(|&n| n != 0 && n != i32::MIN).map(Edge)
    }

    /// Returns its number in the file format.
    pub fn number(self) -> i32 {
        self.0
    }

    /// Returns the number of the node that it points to.
    pub fn id(self) -> usize {
        self.0.unsigned_abs() as usize
    }

    /// Returns true if it complements the function of its node.
    pub fn is_complemented(self) -> bool {
        self.0 < 0
    }

    /// Returns true if it points to the terminal.
    pub fn is_constant(self) -> bool {
        self.id() == 1
    }

    /// Returns ¬f.
    #[must_use]
    pub fn complement(self) -> Self {
        Edge(-self.0)
    }

    /// Returns ¬f if `complemented` is true, else f.
    #[must_use]
    pub fn complement_if(self, complemented: bool) -> Self {
        if complemented { self.complement() } else { self }
    }
}

/// An inner node: if the variable of its level, then `then`, else `otherwise`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Node {
    /// The index of its variable in the order; 0 is the top level.
    pub level: u32,
    /// The cofactor for true; never complemented.
    pub then: Edge,
    /// The cofactor for false.
    pub otherwise: Edge,
}

/// Several functions as one shared diagram.
///
/// The node with number n + 2 has index n; arcs point to smaller numbers and deeper levels.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Diagram {
    /// The names of the variables, from the root down.
    pub variables: Vec<String>,
    /// The inner nodes.
    pub nodes: Vec<Node>,
    /// The functions.
    pub roots: Vec<Edge>,
}

impl Diagram {
    /// Returns the node that an arc points to; none for the terminal.
    pub fn node(&self, edge: Edge) -> Option<&Node> {
        self.nodes.get(edge.id().checked_sub(2)?)
    }

    /// Returns the level of an arc's node; the number of variables for the terminal.
    pub fn level(&self, edge: Edge) -> u32 {
        self.node(edge).map_or(self.variables.len() as u32, |n| n.level)
    }

    /// Returns both cofactors of a function by the variable of a level at or above its root.
    pub fn cofactors(&self, edge: Edge, level: u32) -> (Edge, Edge) {
        match self.node(edge) {
            Some(node) if node.level == level => {
                let flip = edge.is_complemented();
                (node.then.complement_if(flip), node.otherwise.complement_if(flip))
            }
            _ => (edge, edge),
        }
    }

    /// Returns whether all arcs lead to existing nodes, and those of each node to earlier nodes on deeper levels.
    pub fn is_ordered(&self) -> bool {
        let nodes = self.nodes.iter().enumerate();
        let inner = nodes.flat_map(|(index, node)| [(index, node, node.then), (index, node, node.otherwise)]);
        inner.into_iter().all(|(index, node, arc)| arc.id() < index + 2 && self.level(arc) > node.level)
            && self.roots.iter().all(|root| root.id() < self.nodes.len() + 2)
    }

    /// Adds a node and returns its function. The level must be at or above the level of every node
    /// so far. Does not look for an equal node.
    ///
    /// # Errors
    /// The diagram has 2³¹ - 3 nodes: the format numbers nodes by 31 bits.
    pub fn push(&mut self, level: u32, then: Edge, otherwise: Edge) -> Result<Edge> {
        let flip = then.is_complemented();
        let (then, otherwise) = (then.complement_if(flip), otherwise.complement_if(flip));
        let Some(edge) = Edge::new(self.nodes.len() as i64 + 2) else {
            let what = format!("a dump of more than {} nodes", i32::MAX - 2);
            return Err(Limit::Size { what }.into());
        };
        self.nodes.push(Node { level, then, otherwise });
        Ok(edge.complement_if(flip))
    }

    /// Evaluates a function; `bit` gives the value of the variable of a level.
    pub fn eval(&self, edge: Edge, bit: impl Fn(u32) -> bool) -> bool {
        let mut at = edge;
        while let Some(node) = self.node(at) {
            let (then, otherwise) = self.cofactors(at, node.level);
            at = if bit(node.level) { then } else { otherwise };
        }
        at == Edge::TRUE
    }

    /// Returns the number of inner nodes of the function.
    pub fn size(&self, edge: Edge) -> usize {
        self.sizes(&[edge])[0]
    }

    /// Returns the number of inner nodes of each function. Cost: linear in the sum.
    pub fn sizes(&self, edges: &[Edge]) -> Vec<usize> {
        // For each node the last function that contains it, numbered from 1.
        let mut seen = vec![0usize; self.nodes.len()];
        let mut open = Vec::new();
        let size = |(position, &edge): (usize, &Edge)| {
            let mut size = 0;
            open.push(edge);
            while let Some(edge) = open.pop() {
                let Some(index) = edge.id().checked_sub(2) else { continue };
                if let Some(node) = self.nodes.get(index).filter(|_| seen[index] != position + 1) {
                    seen[index] = position + 1;
                    size += 1;
                    open.extend([node.then, node.otherwise]);
                }
            }
            size
        };
        edges.iter().enumerate().map(size).collect()
    }

    /// Marks the nodes that are part of one of these functions.
    pub fn below(&self, edges: &[Edge]) -> Vec<bool> {
        let mut seen = vec![false; self.nodes.len()];
        let mark = |edge: &Edge, seen: &mut Vec<bool>| {
            if let Some(flag) = edge.id().checked_sub(2).and_then(|n| seen.get_mut(n)) {
                *flag = true;
            }
        };
        edges.iter().for_each(|e| mark(e, &mut seen));
        for (index, node) in self.nodes.iter().enumerate().rev() {
            if seen[index] {
                mark(&node.then, &mut seen);
                mark(&node.otherwise, &mut seen);
            }
        }
        seen
    }

    /// Counts the assignments to the variables from level `top` down that satisfy a function. The
    /// function must not depend on variables above `top`.
    pub fn count(&self, edge: Edge, top: u32) -> BigUint {
        self.over(&self.counts(edge), edge, top)
    }

    /// Counts, for each node of a function, the satisfying assignments to the variables from its
    /// own level down.
    pub(super) fn counts(&self, edge: Edge) -> Vec<BigUint> {
        let seen = self.below(&[edge]);
        let mut counts: Vec<BigUint> = Vec::with_capacity(self.nodes.len());
        for (index, node) in self.nodes.iter().enumerate() {
            let count = if seen[index] {
                self.over(&counts, node.then, node.level + 1)
                    + self.over(&counts, node.otherwise, node.level + 1)
            } else {
                BigUint::ZERO
            };
            counts.push(count);
        }
        counts
    }

    /// Returns the count of an arc over the variables from level `top` down, given the counts of
    /// the nodes.
    pub(super) fn over(&self, counts: &[BigUint], edge: Edge, top: u32) -> BigUint {
        let level = self.level(edge);
        let positive = match edge.id() {
            1 => BigUint::from(1u8),
            id => counts[id - 2].clone(),
        };
        let own = if edge.is_complemented() {
            (BigUint::from(1u8) << (self.variables.len() as u32 - level)) - positive
        } else {
            positive
        };
        own << level.saturating_sub(top)
    }
}
