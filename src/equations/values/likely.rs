//! The greatest probabilities of an objective, with the choices that attain them.

use crate::graphs::codes::Codes;
use crate::graphs::game_graph::LOST;
use crate::graphs::graph::NONE;
use crate::graphs::meter::Meter;
use crate::graphs::reached::{END, Growing, Reached};
use crate::graphs::source::{Walked, numbers_of};
use crate::solvers::solution::Solution;
use crate::solvers::solve::solved;
use crate::solvers::system::Quantity;
use crate::solvers::ties::{self, Solutions, Ties};
use meliora_base::error::Result;
use meliora_base::interval::{Bounds, Interval};
use meliora_base::number::Number;
use meliora_engine::Engine;
use meliora_model::{Program, State};
use meliora_space::weighted::{Codec, Walker};

/// The greatest probabilities with which some states achieve an objective, and the choices that attain
/// them.
#[derive(Debug)]
pub struct Likely {
    found: Reached,
    codec: Codec,
    /// The states that were seen, by their numbers.
    codes: Codes,
    solution: Solution<Interval>,
    /// The choices that attain the values in the fewest steps, where they are known.
    ties: Option<Ties>,
}

impl Likely {
    /// Computes the values of some states and of those that they reach until the objective is almost
    /// sure, or impossible: the regions `sure` and `possible`. Cost: one evaluation of the commands for each of these states,
    /// and the equations.
    ///
    /// # Errors
    /// A limit is reached; a command has no meaning in some state.
    pub fn compute<E: Engine>(
        engine: &E,
        program: &Program,
        (sure, possible): (&E::States, &E::States),
        states: &[State],
    ) -> Result<Self> {
        let mut meter = Meter::new(engine);
        let (all, theirs) = (engine.all_states(), engine.theirs());
        let sets = [Some(sure), Some(possible), Some(&all), theirs.as_ref()];
        let sets = engine.membership(&Vec::from_iter(sets.into_iter().flatten()))?;
        let walker = Walker::new(program, &*engine.settings().sink)?;
        let mut walked = Walked::new(&*sets, &walker);
        let numbers = numbers_of(&mut walked, states, &mut meter)?;
        let growing = Growing::new(&walked, (true, engine.is_game()), &mut meter)?;
        let mut found = growing.run(&mut walked, &numbers)?;
        let (costs, codec, codes) =
            (ties::costs(&mut found.graph), walker.codec().clone(), walked.into_codes());
        let graph = &found.graph;
        let fractions: Vec<Interval> = graph.fractions().iter().map(Interval::of).collect();
        let (solution, end) = solved(graph, Quantity::Probability(1), (None, &fractions), &mut meter)?;
        end?;
        if graph.theirs.is_some() {
            return Ok(Likely { found, codec, codes, solution, ties: None });
        }
        let probability = std::slice::from_ref(&solution);
        let solutions = Solutions { graph, fractions: &fractions, costs, probability, cost: &[] };
        let ties = solutions.decide(&mut meter)?;
        Ok(Likely { found, codec, codes, solution, ties })
    }

    /// Returns the node of a state; `None` if it was not explored.
    fn node(&self, state: &[i64]) -> Option<u32> {
        self.found.node(self.codes.find(0, &self.codec.encode(state)?)?)
    }

    /// Returns the probability that the choices attain, which is the greatest one up to the precision; `None`
    /// if the state was not explored.
    pub fn probability(&self, state: &[i64]) -> Option<Bounds> {
        let node = match self.node(state)? {
            END => return Some(Bounds::point(1)),
            LOST => return Some(Bounds::point(0)),
            node => node,
        };
        let known = self.solution.get(node).map(|x| Bounds::of(x).at_most(1.0));
        let mut bounds = known.unwrap_or_else(|| Bounds::any(1.0));
        let [loss, _] = self.ties.as_ref().map_or([0.0; 2], |ties| ties.loss(node, 0));
        bounds.lose(loss);
        Some(bounds)
    }

    /// Returns the choice that attains the probability, of several the one with the least expected number of
    /// steps until the objective is sure or impossible, by its position in the order of the program;
    /// `None` where the objective is almost sure or impossible.
    pub fn pick(&self, state: &[i64]) -> Option<usize> {
        let node = self.node(state).filter(|node| *node != END && *node != LOST)?;
        Some(self.ties.as_ref().map_or_else(|| self.solution.pick(node), |ties| ties.pick(node, 0)))
            .filter(|choice| *choice != NONE)
            .map(|choice| self.found.graph.position(choice))
    }
}
