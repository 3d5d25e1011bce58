//! The graph of the states that some states reach, until their paths end or fail.

use crate::graphs::game_graph::{Edge, LOST};
use crate::graphs::graph::{EVERY, Graph, Rank};
use crate::graphs::meter::Meter;
use crate::graphs::source::Source;
use bitvec::vec::BitVec;
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use num_traits::{One, Zero};

/// The node of all states where the path ends.
pub(crate) const END: u32 = 0;

/// Not a node: a state whose part of the engine is not known.
const UNKNOWN: u32 = u32::MAX - 1;
/// Not a node: a state in which paths continue, and which has no node yet.
const WAITING: u32 = u32::MAX - 2;
/// Not a node: a state that is none of the engine.
const OUTSIDE: u32 = u32::MAX - 3;
/// Not a node: a state in which paths stay, and which has no node yet.
const STAYING: u32 = u32::MAX - 4;
/// The number of the set of the opponent's states, after those of the parts.
const THEIRS: u32 = 3;

/// Returns the node, or the constant, of a state that is in some of these sets: the ends, the states in which the path
/// continues, and all states of the engine. The path has failed in the others of the engine. `ends` says that all ends are
/// one node.
fn part(marks: u64, ends: bool) -> u32 {
    match marks.trailing_zeros() {
        0 if ends => END,
        0 => STAYING,
        1 => WAITING,
        2 => LOST,
        _ => OUTSIDE,
    }
}

/// The states that some states reach.
#[derive(Debug)]
pub(crate) struct Reached {
    /// Their graph.
    pub(crate) graph: Graph,
    /// The nodes of the states asked for: numbers, [`END`] or [`LOST`].
    pub(crate) starts: Vec<u32>,
    /// The node of each number of the source, or one of the constants.
    nodes: Vec<u32>,
    /// The numbers of the states with nodes of their own, in the order of these.
    pub(crate) numbers: Vec<u32>,
}

impl Reached {
    /// Returns the node of a number of the source: a number, [`END`] or [`LOST`]; `None` if it was not reached.
    pub(crate) fn node(&self, number: u32) -> Option<u32> {
        let node = self.nodes.get(number as usize).copied();
        node.filter(|node| ![UNKNOWN, WAITING, OUTSIDE, STAYING].contains(node))
    }
}

/// The exploration of the states of a source.
pub(crate) struct Growing<'a, 'm> {
    graph: Graph,
    /// True if paths end: the first node is [`END`]. Else each state of the first set has a node, which is never left.
    ends: bool,
    /// The node of each number of the source, or one of the constants.
    nodes: Vec<u32>,
    /// The numbers of the states with nodes of their own, in the order of these.
    numbers: Vec<u32>,
    /// The states with nodes of their own in which paths stay, in the same order.
    staying: BitVec,
    /// The number of the cost 0.
    free: u32,
    meter: &'a mut Meter<'m>,
}

impl<'a, 'm> Growing<'a, 'm> {
    /// Creates a graph without states, of a game or an MDP; `ends` says that paths may end.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub(crate) fn new(
        source: &impl Source,
        (ends, is_game): (bool, bool),
        meter: &'a mut Meter<'m>,
    ) -> Result<Self> {
        let mut graph = Graph::default();
        graph.theirs = is_game.then(BitVec::new);
        graph.game.fractions = source.fractions();
        let free = graph.fraction(Ratio::zero());
        if ends {
            graph.add_node(Rank::default(), false, meter)?;
        }
        Ok(Growing {
            graph,
            ends,
            nodes: Vec::new(),
            numbers: Vec::new(),
            staying: BitVec::new(),
            free,
            meter,
        })
    }

    /// Explores the states that some states reach, breadth first.
    ///
    /// # Errors
    /// A limit is reached; a command has no meaning in some state.
    pub(crate) fn run(mut self, source: &mut impl Source, states: &[u32]) -> Result<Reached> {
        let mut starts = Vec::with_capacity(states.len());
        for &number in states {
            starts.push(match number == LOST || self.learn(number, source)? == OUTSIDE {
                true => LOST,
                false => self.enter(number)?,
            });
        }
        let (first, mut next) = (self.graph.nodes() - self.numbers.len(), 0);
        while let Some(&number) = self.numbers.get(next) {
            let (node, stays) = ((first + next) as u32, self.staying[next]);
            next += 1;
            self.meter.step()?;
            let nodes = self.graph.nodes();
            self.meter.progress_at(next, &|| format!("{nodes} states"));
            self.graph.begin(node, self.meter)?;
            if self.graph.theirs.is_some() {
                self.graph.set_owner(node, source.marks(number)? >> THEIRS & 1 == 1);
            }
            match stays {
                true => self.stay_in(node),
                false => self.choices(number, source)?,
            }
            self.graph.end(node, self.meter)?;
        }
        self.graph.finish();
        Ok(Reached { graph: self.graph, starts, nodes: self.nodes, numbers: self.numbers })
    }

    /// Adds the choice of a node that is never left.
    fn stay_in(&mut self, node: u32) {
        let sure = self.graph.fraction(Ratio::one());
        self.graph.add_choice(0, self.free);
        self.graph.add_edge(Edge::new(node, sure, false));
    }

    /// Adds the choices of a state that lead to states of the engine.
    fn choices(&mut self, number: u32, source: &mut impl Source) -> Result<()> {
        let count = source.expand(number, &mut self.graph.game.fractions, self.meter)?;
        for position in 0..count {
            let (targets, weights) = source.choice(position);
            if !self.are_inside(targets, source)? {
                continue;
            }
            self.graph.add_choice(position as u32, self.free);
            for (&target, &weight) in targets.iter().zip(weights) {
                let to = self.enter(target)?;
                self.graph.add_edge(Edge::new(to, weight, self.ends && to == END));
            }
        }
        Ok(())
    }

    /// Returns whether all of some states are states of the engine.
    fn are_inside(&mut self, targets: &[u32], source: &impl Source) -> Result<bool> {
        for &target in targets {
            if self.learn(target, source)? == OUTSIDE {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Returns the node of a state, or its constant, after finding out its part of the engine.
    #[inline]
    fn learn(&mut self, number: u32, source: &impl Source) -> Result<u32> {
        if self.nodes.len() <= number as usize {
            self.meter.take((source.count() - self.nodes.len()) * size_of::<u32>())?;
            self.nodes.resize(source.count(), UNKNOWN);
        }
        let known = &mut self.nodes[number as usize];
        if *known == UNKNOWN {
            *known = part(source.marks(number)?, self.ends);
        }
        Ok(*known)
    }

    /// Returns the node of a state whose part is known; it is added if it is new.
    #[inline]
    fn enter(&mut self, number: u32) -> Result<u32> {
        match self.nodes[number as usize] {
            part @ (WAITING | STAYING) => self.add(number, part == STAYING),
            known => Ok(known),
        }
    }

    fn add(&mut self, number: u32, stays: bool) -> Result<u32> {
        let node = self.graph.add_node(Rank { positive: EVERY, sure: 0 }, false, self.meter)?;
        // The greatest numbers are constants.
        self.meter.number(node as usize + 4)?;
        self.meter.take(size_of::<u32>())?;
        self.numbers.push(number);
        self.staying.push(stays);
        self.nodes[number as usize] = node;
        Ok(node)
    }
}
