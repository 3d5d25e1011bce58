//! The graph of the states that some states reach, until their paths end or fail.

use crate::equations::codes::Codes;
use crate::equations::cost::{Cost, Earned};
use crate::equations::graph::{EVERY, Graph, LOST, Rank};
use crate::equations::meter::Meter;
use crate::equations::number::Weight;
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_engine::explicit::weighted::Codec;
use meliora_engine::membership::Membership;
use meliora_model::State;
use meliora_model::step::Combination;

/// The node of all states where the path ends.
pub(crate) const END: u32 = 0;

/// The node of a state that was not found.
pub(crate) const UNSEEN: u32 = LOST - 1;

/// The key of all codes.
const KEY: u32 = 0;

/// A part of the states of the engine.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Part {
    /// The path ends: with the probability 1, or without further reward.
    End,
    /// The path continues.
    Inside,
    /// The path has failed.
    Lost,
}

impl Part {
    /// Returns the part of a state that is in some of these sets: the ends, the states in which the path goes
    /// on, and all states of the engine.
    pub(crate) fn of(marks: u64) -> Option<Self> {
        match marks.trailing_zeros() {
            0 => Some(Part::End),
            1 => Some(Part::Inside),
            2 => Some(Part::Lost),
            _ => None,
        }
    }
}

/// The states that some states reach.
pub(crate) struct Reached<'e> {
    /// Their graph.
    pub(crate) graph: Graph,
    /// The nodes of the states asked for.
    pub(crate) starts: Vec<u32>,
    /// The nodes of all states.
    pub(crate) nodes: Nodes<'e>,
}

/// The nodes of the states that were found.
pub(crate) enum Nodes<'e> {
    /// By code.
    Coded(Box<Coded>),
    /// The node of each state of the engine, by its number, or [`UNSEEN`].
    Numbered(Box<dyn Membership + 'e>, Vec<u32>),
}

impl Nodes<'_> {
    /// Returns the nodes by code. Cost: linear, if they are known by number.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub(crate) fn coded(self, codec: &Codec, meter: &mut Meter<'_>) -> Result<Coded> {
        let (parts, nodes) = match self {
            Nodes::Coded(coded) => return Ok(*coded),
            Nodes::Numbered(parts, nodes) => (parts, nodes),
        };
        let mut coded = Coded::new(codec);
        let Some(numbers) = parts.numbers() else { return Ok(coded) };
        for (number, &node) in nodes.iter().enumerate().filter(|(_, node)| **node != UNSEEN) {
            coded.codes.push(KEY, numbers.code(number as u32), meter)?;
            coded.nodes.push(node);
        }
        Ok(coded)
    }
}

/// The nodes of the states that were found, by code.
#[derive(Debug)]
pub(crate) struct Coded {
    pub(crate) codes: Codes,
    /// The node of each state, [`END`] or [`LOST`].
    pub(crate) nodes: Vec<u32>,
}

impl Coded {
    pub(crate) fn new(codec: &Codec) -> Self {
        Coded { codes: Codes::new(codec), nodes: Vec::new() }
    }

    /// Returns the node of a state that was found.
    pub(crate) fn node(&self, code: &[u64]) -> Option<u32> {
        self.codes.find(KEY, code).map(|number| self.nodes[number as usize])
    }

    /// Adds a state that was not found yet.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub(crate) fn add(&mut self, code: &[u64], node: u32, meter: &mut Meter<'_>) -> Result<()> {
        meter.take(size_of::<u32>())?;
        self.codes.add(KEY, code, meter)?;
        self.nodes.push(node);
        Ok(())
    }
}

/// The graph as it grows.
pub(crate) struct Growing<'a, 'm> {
    pub(crate) graph: Graph,
    pub(crate) cost: Option<Earned<'a>>,
    pub(crate) meter: &'a mut Meter<'m>,
    /// The number of the cost 0.
    pub(crate) free: u32,
}

impl<'a, 'm> Growing<'a, 'm> {
    /// Creates the graph of the node [`END`] alone.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub(crate) fn new(cost: Option<Earned<'a>>, meter: &'a mut Meter<'m>) -> Result<Self> {
        let mut graph = Graph::default();
        let free = graph.fraction(Ratio::zero());
        graph.add_node(Rank::default(), false, meter)?;
        Ok(Growing { graph, cost, meter, free })
    }

    /// Returns the node of a new state.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub(crate) fn enter(&mut self, part: Part) -> Result<u32> {
        match part {
            Part::End => Ok(END),
            Part::Lost => Ok(LOST),
            Part::Inside => {
                let sure = if self.cost.is_some() { EVERY } else { 0 };
                self.graph.add_node(Rank { positive: EVERY, sure }, false, self.meter)
            }
        }
    }

    /// Returns the number of the cost of a choice, which draws from these combinations.
    ///
    /// # Errors
    /// A reward has no meaning in the state.
    pub(crate) fn cost(&mut self, state: &State, combinations: &[Combination]) -> Result<u32> {
        Ok(match &self.cost {
            Some(cost) => self.graph.fraction(cost.of(state, combinations)?),
            None => self.free,
        })
    }

    /// Counts one state that is explored next; `explored` are before it.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(crate) fn step(&mut self, explored: usize) -> Result<()> {
        self.meter.step()?;
        self.meter.progress_at(explored, &|| format!("{} states", self.graph.nodes()));
        Ok(())
    }
}
