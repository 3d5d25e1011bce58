//! Decision diagrams as plain data: shared, reduced, with complemented else arcs.

use num_bigint::BigUint;

use crate::error::{Limit, Result};

/// An arc: the number of a node (from 1, the terminal), negative where the function is complemented.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Edge(i32);

impl Edge {
    /// The function that is true everywhere: the terminal.
    pub const TRUE: Edge = Edge(1);
    /// The function that is true nowhere.
    pub const FALSE: Edge = Edge(-1);

    /// The arc with the number that files have for it; none for 0 and what does not fit.
    pub fn new(number: i64) -> Option<Self> {
        i32::try_from(number).ok().filter(|&n| n != 0 && n != i32::MIN).map(Edge)
    }

    /// The number that files have for it.
    pub fn number(self) -> i32 {
        self.0
    }

    /// The number of the node it leads to.
    pub fn id(self) -> usize {
        self.0.unsigned_abs() as usize
    }

    /// Whether it complements the function of its node.
    pub fn is_complemented(self) -> bool {
        self.0 < 0
    }

    /// Whether it leads to the terminal.
    pub fn is_constant(self) -> bool {
        self.id() == 1
    }

    /// ¬f
    #[must_use]
    pub fn complement(self) -> Self {
        Edge(-self.0)
    }

    /// f, or ¬f where `complemented`.
    #[must_use]
    pub fn complement_if(self, complemented: bool) -> Self {
        if complemented { self.complement() } else { self }
    }
}

/// An inner node: if the variable of its level then `then` else `otherwise`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Node {
    /// The position of its variable in the order, from 0 at the root.
    pub level: u32,
    /// Where the variable is true; never complemented.
    pub then: Edge,
    /// Where it is false.
    pub otherwise: Edge,
}

/// Several functions as one shared diagram.
///
/// The node numbered n + 2 stands at position n; arcs lead to smaller numbers and deeper levels.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Diagram {
    /// The names of the variables from the root down.
    pub variables: Vec<String>,
    /// The inner nodes.
    pub nodes: Vec<Node>,
    /// The functions.
    pub roots: Vec<Edge>,
}

impl Diagram {
    /// The node that an arc leads to; none for the terminal.
    pub fn node(&self, edge: Edge) -> Option<&Node> {
        self.nodes.get(edge.id().checked_sub(2)?)
    }

    /// The level of an arc's node; one past the last for the terminal.
    pub fn level(&self, edge: Edge) -> u32 {
        self.node(edge).map_or(self.variables.len() as u32, |n| n.level)
    }

    /// Both cofactors of a function by the variable of a level at or above its root.
    pub fn cofactors(&self, edge: Edge, level: u32) -> (Edge, Edge) {
        match self.node(edge) {
            Some(node) if node.level == level => {
                let flip = edge.is_complemented();
                (node.then.complement_if(flip), node.otherwise.complement_if(flip))
            }
            _ => (edge, edge),
        }
    }

    /// Returns true if all arcs lead to nodes of the diagram, and those of a node to earlier nodes on deeper levels.
    pub fn is_ordered(&self) -> bool {
        let nodes = self.nodes.iter().enumerate();
        let inner = nodes.flat_map(|(index, node)| [(index, node, node.then), (index, node, node.otherwise)]);
        inner.into_iter().all(|(index, node, arc)| arc.id() < index + 2 && self.level(arc) > node.level)
            && self.roots.iter().all(|root| root.id() < self.nodes.len() + 2)
    }

    /// Adds a node on a level above all nodes so far, or on the deepest one of these, and returns
    /// its function. Does not look for an equal one.
    ///
    /// # Errors
    /// The format numbers nodes by 31 bits.
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

    /// The value of a function where `bit` tells the value of a level's variable.
    pub fn eval(&self, edge: Edge, bit: impl Fn(u32) -> bool) -> bool {
        let mut at = edge;
        while let Some(node) = self.node(at) {
            let (then, otherwise) = self.cofactors(at, node.level);
            at = if bit(node.level) { then } else { otherwise };
        }
        at == Edge::TRUE
    }

    /// How many inner nodes the function has.
    pub fn size(&self, edge: Edge) -> usize {
        self.sizes(&[edge])[0]
    }

    /// How many inner nodes each of these functions has. Cost: linear in the sum.
    pub fn sizes(&self, edges: &[Edge]) -> Vec<usize> {
        // For each node the last function that it was seen in, from 1.
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

    /// For each node whether it is part of one of these functions.
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

    /// The number of assignments to the variables from `top` down that satisfy a function which
    /// depends on no variable above.
    pub fn count(&self, edge: Edge, top: u32) -> BigUint {
        self.over(&self.counts(edge), edge, top)
    }

    /// For each node of a function the number of assignments to the variables from its own level down
    /// that satisfy it.
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

    /// The count of an arc over the variables from `top` down, given those of the nodes.
    pub(super) fn over(&self, counts: &[BigUint], edge: Edge, top: u32) -> BigUint {
        let level = self.level(edge);
        let positive = match edge.id() {
            1 => BigUint::from(1u8),
            id => counts.get(id - 2).cloned().unwrap_or_default(),
        };
        let own = if edge.is_complemented() {
            (BigUint::from(1u8) << (self.variables.len() as u32 - level)) - positive
        } else {
            positive
        };
        own << level.saturating_sub(top)
    }
}
