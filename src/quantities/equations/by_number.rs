//! Exploration of states that the engine has numbered: their successors are known, so that states are
//! entered only for probabilities and rewards.

use crate::equations::graph::{Edge, Graph};
use crate::equations::number::Number;
use crate::equations::reached::{END, Growing, Part, UNSEEN};
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_engine::explicit::weighted::{Codec, Steps, Walk};
use meliora_engine::membership::Numbers;
use meliora_model::State;
use meliora_model::rewards::Earner;

/// The position of the states in which some choice earns, among the sets of the engine.
const EARNING: u32 = 3;

/// The exploration of numbered states.
pub(crate) struct ByNumber<'a, 'm> {
    numbers: &'a dyn Numbers,
    codec: &'a Codec,
    growing: Growing<'a, 'm>,
    /// The node of each state of the engine, or [`UNSEEN`].
    nodes: Vec<u32>,
    /// The state of each node after [`END`].
    states: Vec<u32>,
    /// The number of the probability 1.
    sure: u32,
    /// True if rewards depend on the state alone.
    by_state: bool,
}

impl<'a, 'm> ByNumber<'a, 'm> {
    /// Prepares the exploration.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub(crate) fn new(
        numbers: &'a dyn Numbers,
        codec: &'a Codec,
        mut growing: Growing<'a, 'm>,
    ) -> Result<Self> {
        growing.meter.take(numbers.states() * size_of::<u32>())?;
        let nodes = vec![UNSEEN; numbers.states()];
        let sure = growing.graph.fraction(Ratio::one());
        let by_state = growing
            .cost
            .is_none_or(|cost| cost.structure.items.iter().all(|item| matches!(item.earner, Earner::State)));
        Ok(ByNumber { numbers, codec, growing, nodes, states: Vec::new(), sure, by_state })
    }

    /// Explores the states that some states of the engine reach, breadth first. Returns the graph, the nodes of
    /// those states, and that of each state by number.
    ///
    /// # Errors
    /// A limit is reached; a reward has no meaning in some state.
    pub(crate) fn run(
        mut self,
        states: &[State],
        walk: &mut dyn Walk,
    ) -> Result<(Graph, Vec<u32>, Vec<u32>)> {
        let mut starts = Vec::with_capacity(states.len());
        for state in states {
            let number = self.numbers.number(&self.codec.known(state)?);
            starts.push(match number.and_then(|number| Some((number, self.part(number)?))) {
                Some((number, part)) => self.enter(number, part)?,
                None => self.growing.enter(Part::Lost)?,
            });
        }
        let (mut steps, mut successors, mut next) = (Steps::default(), Vec::new(), 0);
        while let Some(&number) = self.states.get(next) {
            next += 1;
            self.growing.step(next)?;
            self.explore((next as u32, number), walk, &mut steps, &mut successors)?;
        }
        Ok((self.growing.graph, starts, self.nodes))
    }

    /// Adds the choices of a node, which is that of a state.
    fn explore(
        &mut self,
        (node, number): (u32, u32),
        walk: &mut dyn Walk,
        steps: &mut Steps,
        successors: &mut Vec<u32>,
    ) -> Result<()> {
        let is_certain = self.numbers.is_certain(number);
        let earns = self.growing.cost.is_some() && self.numbers.marks(number) >> EARNING & 1 == 1;
        if !is_certain || earns && !self.by_state {
            walk.steps(self.numbers.code(number), &mut self.growing.graph.known, steps)?;
        }
        let state = if earns { self.codec.decode(self.numbers.code(number)) } else { State::new() };
        let free = self.growing.free;
        let of_state = if earns && self.by_state { self.growing.cost(&state, &[])? } else { free };
        self.growing.graph.begin(node, self.growing.meter)?;
        for position in 0..self.numbers.choices(number) {
            self.numbers.successors(number, position, successors);
            if !successors.iter().all(|&to| self.part(to).is_some()) {
                continue;
            }
            let cost = match earns && !self.by_state {
                true => self.growing.cost(&state, &walk.taken(position).combinations)?,
                false => of_state,
            };
            self.growing.graph.add_choice(position as u32, cost);
            for (at, &to) in successors.iter().enumerate() {
                let probability = if is_certain { self.sure } else { steps.weights(position)[at] };
                self.edge(to, probability)?;
            }
        }
        self.growing.graph.end(node, self.growing.meter)
    }

    /// Adds an edge to the last choice.
    fn edge(&mut self, to: u32, probability: u32) -> Result<()> {
        let node = match self.nodes[to as usize] {
            UNSEEN => self.enter(to, self.part(to).unwrap_or(Part::Lost))?,
            node => node,
        };
        self.growing.graph.add_edge(Edge::new(node, probability, node == END));
        Ok(())
    }

    /// Returns the part of a state that was not found yet; that of others does not matter.
    fn part(&self, number: u32) -> Option<Part> {
        match self.nodes[number as usize] {
            UNSEEN => Part::of(self.numbers.marks(number)),
            _ => Some(Part::Inside),
        }
    }

    /// Returns the node of a state, which is added if it is new.
    fn enter(&mut self, number: u32, part: Part) -> Result<u32> {
        if self.nodes[number as usize] == UNSEEN {
            self.nodes[number as usize] = self.growing.enter(part)?;
            if let Part::Inside = part {
                self.growing.meter.take(size_of::<u32>())?;
                self.states.push(number);
            }
        }
        Ok(self.nodes[number as usize])
    }
}
