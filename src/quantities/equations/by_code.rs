//! Exploration of states that the engine has not numbered, by their codes.

use crate::equations::graph::{Edge, Graph, LOST};
use crate::equations::reached::{Coded, END, Growing, Part};
use meliora_base::error::Result;
use meliora_engine::explicit::weighted::{Code, Codec, Steps, Walk};
use meliora_engine::membership::Membership;
use meliora_model::State;

/// The end of a step.
#[derive(Debug, Clone, Copy)]
enum Target {
    /// To a state that was found: its node, [`END`] or [`LOST`].
    Found(u32),
    /// To another state of this part of the engine.
    New(Part),
}

/// The exploration of states by code.
pub(crate) struct ByCode<'a, 'm> {
    /// Tells the [`Part`] of a state.
    pub(crate) parts: &'a dyn Membership,
    pub(crate) codec: &'a Codec,
    pub(crate) growing: Growing<'a, 'm>,
    pub(crate) found: Coded,
}

impl ByCode<'_, '_> {
    /// Explores the states that some states of the engine reach, breadth first. Returns the graph, the nodes of
    /// those states, and that of each state by code.
    ///
    /// # Errors
    /// A limit is reached; a reward has no meaning in some state.
    pub(crate) fn run(mut self, states: &[State], walk: &mut dyn Walk) -> Result<(Graph, Vec<u32>, Coded)> {
        let mut starts = Vec::with_capacity(states.len());
        for state in states {
            let code = self.codec.known(state)?;
            starts.push(match self.target(&code)? {
                Some(target) => self.enter(target, &code)?,
                // Not remembered as found: a choice that leads to it leaves the states of the engine.
                None => self.growing.enter(Part::Lost)?,
            });
        }
        let (mut steps, mut targets, mut next) = (Steps::default(), Vec::new(), 0);
        while let Some(&node) = self.found.nodes.get(next) {
            let code = self.found.codes.code(next as u32);
            next += 1;
            if node == END || node == LOST {
                continue;
            }
            self.growing.step(next)?;
            walk.steps(&code, &mut self.growing.graph.known, &mut steps)?;
            self.growing.graph.begin(node, self.growing.meter)?;
            for position in 0..steps.choices() {
                if self.stays(&steps, position, &mut targets)? {
                    self.choice((&code, position), (walk, &steps), &targets)?;
                }
            }
            self.growing.graph.end(node, self.growing.meter)?;
        }
        Ok((self.growing.graph, starts, self.found))
    }

    /// Finds the targets of a choice; returns whether all are states of the engine.
    fn stays(&self, steps: &Steps, position: usize, targets: &mut Vec<Target>) -> Result<bool> {
        targets.clear();
        for (code, _) in steps.of(position) {
            match self.target(code)? {
                Some(target) => targets.push(target),
                None => return Ok(false),
            }
        }
        Ok(true)
    }

    /// Adds a choice of a state.
    fn choice(
        &mut self,
        (code, position): (&Code, usize),
        (walk, steps): (&dyn Walk, &Steps),
        targets: &[Target],
    ) -> Result<()> {
        let cost = match self.growing.cost {
            Some(_) => self.growing.cost(&self.codec.decode(code), &walk.taken(position).combinations)?,
            None => self.growing.free,
        };
        self.growing.graph.add_choice(position as u32, cost);
        for ((code, probability), &target) in steps.of(position).zip(targets) {
            let to = self.enter(target, code)?;
            self.growing.graph.add_edge(Edge::new(to, probability, to == END));
        }
        Ok(())
    }

    /// Finds a state; `None` if it is not one of the engine.
    fn target(&self, code: &[u64]) -> Result<Option<Target>> {
        Ok(match self.found.node(code) {
            Some(node) => Some(Target::Found(node)),
            None => Part::of(self.parts.of(&self.codec.decode(code))?).map(Target::New),
        })
    }

    /// Returns the node of a target, which is added if it is new.
    fn enter(&mut self, target: Target, code: &[u64]) -> Result<u32> {
        match target {
            Target::Found(node) => Ok(node),
            Target::New(part) => {
                let node = self.growing.enter(part)?;
                self.found.add(code, node, self.growing.meter)?;
                Ok(node)
            }
        }
    }
}
