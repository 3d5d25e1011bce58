//! Boolean functions of a few variables in canonical form: small reduced decision diagrams.
//!
//! A progressed formula is a Boolean combination of a few obligations. Equal combinations must be
//! one state of a monitor, in whatever form they are written. The diagrams of the engines are made
//! for millions of nodes; their tables alone are larger than everything needed here.

use ahash::AHashMap;

use meliora_base::error::{Limit, Result};
use meliora_base::stack;

/// A function, given by the position of its root in `Functions::nodes`.
pub(crate) type Function = u32;

pub(crate) const FALSE: Function = 0;
pub(crate) const TRUE: Function = 1;

/// Maximum number of nodes.
pub(crate) const MOST_NODES: usize = 1 << 20;

/// A test of a variable, with its cofactors where the variable is false and where it is true.
type Node = (u32, Function, Function);

/// All functions made so far, each stored once.
pub(crate) struct Functions {
    nodes: Vec<Node>,
    known: AHashMap<Node, Function>,
    combined: AHashMap<(Function, Function, Function), Function>,
}

impl Functions {
    pub(crate) fn new() -> Self {
        let end = (u32::MAX, 0, 0);
        Functions { nodes: vec![end, end], known: AHashMap::new(), combined: AHashMap::new() }
    }

    /// Returns the first variable of a function, `u32::MAX` for a constant.
    pub(crate) fn top(&self, f: Function) -> u32 {
        self.nodes[f as usize].0
    }

    /// Returns the cofactors f|¬v and f|v; `variable` must not lie below the first variable of `f`.
    pub(crate) fn halves(&self, f: Function, variable: u32) -> (Function, Function) {
        let (top, low, high) = self.nodes[f as usize];
        if top == variable { (low, high) } else { (f, f) }
    }

    /// Returns the function of one variable, or of its negation.
    ///
    /// # Errors
    /// More than `MOST_NODES` nodes, as for every operation that makes functions.
    pub(crate) fn variable(&mut self, variable: u32, positive: bool) -> Result<Function> {
        if positive { self.node(variable, FALSE, TRUE) } else { self.node(variable, TRUE, FALSE) }
    }

    pub(crate) fn node(&mut self, variable: u32, low: Function, high: Function) -> Result<Function> {
        if low == high {
            return Ok(low);
        }
        let node = (variable, low, high);
        if let Some(&known) = self.known.get(&node) {
            return Ok(known);
        }
        if self.nodes.len() >= MOST_NODES {
            let what = format!("a monitor of more than {MOST_NODES} decisions");
            return Err(Limit::Size { what }.into());
        }
        let new = self.nodes.len() as Function;
        self.nodes.push(node);
        self.known.insert(node, new);
        Ok(new)
    }

    /// Computes f ∧ g.
    pub(crate) fn and(&mut self, f: Function, g: Function) -> Result<Function> {
        self.ite(f, g, FALSE)
    }

    /// Computes f ∨ g.
    pub(crate) fn or(&mut self, f: Function, g: Function) -> Result<Function> {
        self.ite(f, TRUE, g)
    }

    /// Computes f ? g : h. The recursion depth is at most the number of variables.
    pub(crate) fn ite(&mut self, f: Function, g: Function, h: Function) -> Result<Function> {
        match (f, g, h) {
            (TRUE, _, _) => return Ok(g),
            (FALSE, _, _) => return Ok(h),
            (_, TRUE, FALSE) => return Ok(f),
            _ if g == h => return Ok(g),
            _ => {}
        }
        if let Some(&known) = self.combined.get(&(f, g, h)) {
            return Ok(known);
        }
        let top = self.top(f).min(self.top(g)).min(self.top(h));
        let ((f0, f1), (g0, g1), (h0, h1)) = (self.halves(f, top), self.halves(g, top), self.halves(h, top));
        let (low, high) = stack::level(|| {
            Ok::<_, meliora_base::error::Error>((self.ite(f0, g0, h0)?, self.ite(f1, g1, h1)?))
        })?;
        let found = self.node(top, low, high)?;
        self.combined.insert((f, g, h), found);
        Ok(found)
    }
}
