//! The graph of the states that some states reach, until their paths end or fail.

use crate::equations::codes::{Codes, marks};
use crate::equations::cost::{Cost, Earned};
use crate::equations::game_graph::{Edge, LOST};
use crate::equations::graph::{EVERY, Graph, Rank};
use crate::equations::meter::Meter;
use bitvec::vec::BitVec;
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_engine::membership::Membership;
use meliora_model::State;
use meliora_space::index::Looked;
use meliora_space::weighted::{Code, Codec, Steps, Walk};
use num_traits::Zero;

/// The node of all states where the path ends.
pub(crate) const END: u32 = 0;

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
    /// The number of the set of the opponent's states, after those of the parts.
    const THEIRS: u32 = 3;

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
pub(crate) struct Reached {
    /// Their graph.
    pub(crate) graph: Graph,
    /// The nodes of the states asked for.
    pub(crate) starts: Vec<u32>,
    /// The nodes of all states.
    pub(crate) found: Coded,
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
        Coded { codes: Codes::new(codec, 1), nodes: Vec::new() }
    }

    /// Returns the node of a state that was found.
    pub(crate) fn node(&self, code: &[u64]) -> Option<u32> {
        self.codes.find(0, code).map(|number| self.nodes[number as usize])
    }

    /// Adds a state that was not found yet.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub(crate) fn add(&mut self, code: &[u64], node: u32, meter: &mut Meter<'_>) -> Result<()> {
        meter.take(size_of::<u32>())?;
        self.codes.add(0, code, meter)?;
        self.nodes.push(node);
        Ok(())
    }
}

/// The end of a step.
#[derive(Debug, Clone, Copy)]
enum Target {
    /// To a state that was found: its node, [`END`] or [`LOST`].
    Found(u32),
    /// To another state of this part of the engine.
    New(Part),
}

/// The exploration of states by code.
pub(crate) struct Growing<'a, 'm> {
    /// Tells the [`Part`] of a state and, in a game, its owner.
    parts: &'a dyn Membership,
    codec: &'a Codec,
    graph: Graph,
    found: Coded,
    cost: Option<Earned<'a>>,
    /// The number of the cost 0.
    free: u32,
    /// The successors of a state, looked up.
    looked: Looked,
    meter: &'a mut Meter<'m>,
}

impl<'a, 'm> Growing<'a, 'm> {
    /// Creates the graph of the node [`END`] alone, of a game or an MDP.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub(crate) fn new(
        parts: &'a dyn Membership,
        is_game: bool,
        codec: &'a Codec,
        cost: Option<Earned<'a>>,
        meter: &'a mut Meter<'m>,
    ) -> Result<Self> {
        let mut graph = Graph::default();
        graph.theirs = is_game.then(BitVec::new);
        let free = graph.fraction(Ratio::zero());
        graph.add_node(Rank::default(), false, meter)?;
        Ok(Growing {
            parts,
            codec,
            graph,
            found: Coded::new(codec),
            cost,
            free,
            looked: Looked::default(),
            meter,
        })
    }

    /// Explores the states that some states of the engine reach, breadth first. Returns the graph, the nodes of
    /// those states, and that of each state by code.
    ///
    /// # Errors
    /// A limit is reached; a reward has no meaning in some state.
    pub(crate) fn run(mut self, states: &[State], walk: &mut dyn Walk) -> Result<Reached> {
        let mut starts = Vec::with_capacity(states.len());
        for state in states {
            let code = self.codec.known(state)?;
            starts.push(match self.target(&code, self.found.codes.find(0, &code))? {
                Some(target) => self.enter(target, &code)?,
                // Not remembered as found: a choice that leads to it leaves the states of the engine.
                None => self.add(Part::Lost)?,
            });
        }
        let (mut steps, mut targets, mut next) = (Steps::default(), Vec::new(), 0);
        while let Some(&node) = self.found.nodes.get(next) {
            let code = self.found.codes.code(next as u32);
            next += 1;
            if node == END || node == LOST {
                continue;
            }
            self.meter.step()?;
            let nodes = self.graph.nodes();
            self.meter.progress_at(next, &|| format!("{nodes} states"));
            walk.steps(&code, &mut self.graph.game.fractions, &mut steps)?;
            self.found.codes.look(0, &steps, &mut self.looked);
            self.graph.begin(node, self.meter)?;
            self.own(node, &code)?;
            let mut first = 0;
            for position in 0..steps.choices() {
                let stays = self.stays(&steps, (position, first), &mut targets)?;
                first += steps.weights(position).len();
                if stays {
                    self.choice(&code, position, walk, &steps, &targets)?;
                }
            }
            self.graph.end(node, self.meter)?;
        }
        self.graph.finish();
        Ok(Reached { graph: self.graph, starts, found: self.found })
    }

    /// Finds the targets of a choice, with the number of its first successor; returns whether all are states of the engine.
    fn stays(
        &self,
        steps: &Steps,
        (position, first): (usize, usize),
        targets: &mut Vec<Target>,
    ) -> Result<bool> {
        targets.clear();
        for (at, (code, _)) in (first..).zip(steps.of(position)) {
            let known = self.found.codes.find_looked(0, code, &self.looked, at);
            match self.target(code, known)? {
                Some(target) => targets.push(target),
                None => return Ok(false),
            }
        }
        Ok(true)
    }

    /// Adds a choice of a state.
    fn choice(
        &mut self,
        code: &Code,
        position: usize,
        walk: &dyn Walk,
        steps: &Steps,
        targets: &[Target],
    ) -> Result<()> {
        let cost = match self.cost {
            Some(cost) => {
                let reward = cost.of(&self.codec.decode(code), &walk.taken(position).combinations)?;
                self.graph.fraction(reward)
            }
            None => self.free,
        };
        self.graph.add_choice(position as u32, cost);
        for ((code, probability), &target) in steps.of(position).zip(targets) {
            let to = self.enter(target, code)?;
            self.graph.add_edge(Edge::new(to, probability, to == END));
        }
        Ok(())
    }

    /// Returns the target of a state, which has this number if it was found; `None` if it is not one of the engine.
    fn target(&self, code: &[u64], known: Option<u32>) -> Result<Option<Target>> {
        Ok(match known {
            Some(number) => Some(Target::Found(self.found.nodes[number as usize])),
            None => {
                let marks = self.marks(code)?;
                Part::of(marks).map(Target::New)
            }
        })
    }

    /// Returns the sets that contain a state.
    fn marks(&self, code: &[u64]) -> Result<u64> {
        marks(self.parts, self.codec, code)
    }

    /// Notes the side that chooses in a node of a game.
    fn own(&mut self, node: u32, code: &[u64]) -> Result<()> {
        if self.graph.theirs.is_some() {
            let is_theirs = self.marks(code)? >> Part::THEIRS & 1 == 1;
            self.graph.set_owner(node, is_theirs);
        }
        Ok(())
    }

    /// Returns the node of a target, which is added if it is new.
    fn enter(&mut self, target: Target, code: &[u64]) -> Result<u32> {
        match target {
            Target::Found(node) => Ok(node),
            Target::New(part) => {
                let node = self.add(part)?;
                self.found.add(code, node, self.meter)?;
                Ok(node)
            }
        }
    }

    /// Returns the node of a new state.
    fn add(&mut self, part: Part) -> Result<u32> {
        match part {
            Part::End => Ok(END),
            Part::Lost => Ok(LOST),
            Part::Inside => {
                let sure = if self.cost.is_some() { EVERY } else { 0 };
                self.graph.add_node(Rank { positive: EVERY, sure }, false, self.meter)
            }
        }
    }
}
