//! The quantities of `reach`: the extreme probability of a formula, and the extreme expected reward
//! until a target is reached.
//!
//! Regions come first. A probability is 1 or 0 in the qualitative regions of the formula, and between
//! them it is the probability to reach the first. The least probability is 1 minus the greatest
//! probability of the negation. An expected reward is finite where the target is reached almost
//! surely: by some strategy for the least, by every strategy for the greatest. So only the states
//! between the regions, as far as the given states reach them, have equations.

use crate::answers::ties::{self, Solutions, Ties};
use crate::equations::codes::Codes;
use crate::equations::cost::Earned;
use crate::equations::game_graph::LOST;
use crate::equations::graph::{Graph, NONE};
use crate::equations::meter::Meter;
use crate::equations::number::{Bounds, Interval, Number};
use crate::equations::reached::{END, Reached};
use crate::equations::search::Search;
use crate::equations::solution::Solution;
use crate::equations::system::Quantity;
use crate::solvers::reaching::{Vector, value_at};
use crate::solvers::solve::solved;
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_engine::Engine;
use meliora_engine::regions::{Regions, Which};
use meliora_model::{Optimum, Program, State};
use meliora_space::weighted::Codec;

/// The quantity that is wanted.
#[derive(Debug)]
pub enum Wanted<'p, S> {
    /// The probability of the formula that the regions belong to.
    Probability,
    /// The expected reward until a state of the target is reached.
    Reward(Earned<'p>, &'p S),
}

/// A value of a state.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A number.
    Finite(Bounds),
    /// Infinity: the target is not reached almost surely.
    Infinite,
}

impl Value {
    /// Returns the bounds, which may be infinite.
    pub fn interval(&self) -> Interval {
        match self {
            Value::Finite(bounds) => bounds.interval,
            Value::Infinite => Interval::point(f64::INFINITY),
        }
    }

    /// Replaces a probability by 1 minus it.
    pub fn complement(&mut self) {
        if let Value::Finite(bounds) = self {
            *bounds = bounds.clone().complement();
        }
    }
}

/// The values of some states.
#[derive(Debug)]
pub struct Answer {
    /// The values, in the order of the states.
    pub values: Vec<Value>,
    /// An error if a limit was reached. The bounds hold then too, but may be wide.
    pub end: Result<()>,
}

impl Answer {
    /// Returns the values at some positions.
    #[must_use]
    pub fn selected(self, positions: &[usize]) -> Self {
        Answer { values: positions.iter().map(|&at| self.values[at].clone()).collect(), end: self.end }
    }
}

/// Computes a quantity in some states of the scope, from the regions of the formula that
/// [`needed`](super::sought::needed) names; for a reward, these are the regions of reaching the target. With `exact`, computes with fractions, which can
/// become very long.
///
/// Cost: that of [`Paths::explore`] and [`Paths::values`].
///
/// # Errors
/// The errors of [`Paths::explore`].
pub fn values<E: Engine>(
    engine: &E,
    program: &Program,
    wanted: (&Wanted<'_, E::States>, Optimum),
    regions: &Regions<Option<E::States>>,
    states: &[State],
    exact: bool,
) -> Result<Answer> {
    Paths::explore(engine, program, wanted, regions, states)?.values(exact)
}

/// The states between the regions that some states reach, with the equations of a quantity.
pub struct Paths<'e> {
    graph: Graph,
    /// The nodes of the states asked for.
    starts: Vec<u32>,
    quantity: Quantity,
    /// True if the probability of the negation is computed.
    is_negated: bool,
    meter: Meter<'e>,
}

impl<'e> Paths<'e> {
    /// Finds the states that have equations, for a quantity in some states of the scope; see [`values`].
    ///
    /// Cost: some membership tests per state between the regions that the given states reach, and one
    /// evaluation of the commands, unless the engine keeps the probabilities of its choices.
    ///
    /// # Errors
    /// A limit is reached; a command or a reward has no meaning in some state; a region is missing.
    pub fn explore<E: Engine>(
        engine: &'e E,
        program: &Program,
        (wanted, optimum): (&Wanted<'_, E::States>, Optimum),
        regions: &Regions<Option<E::States>>,
        states: &[State],
    ) -> Result<Self> {
        program.of_one_player("a number")?;
        let all = engine.all_states();
        let region = |which: Which| regions.known(which).cloned();
        let others = |which: Which| engine.difference(&all, regions.known(which)?);
        let (end, inside, quantity, cost) = match (wanted, optimum) {
            (Wanted::Probability, Optimum::Max) => {
                let (end, inside) = (region(Which::PmaxOne)?, region(Which::PmaxPositive)?);
                (end, inside, Quantity::Probability(1), None)
            }
            (Wanted::Probability, Optimum::Min) => {
                let (end, inside) = (others(Which::PminPositive)?, others(Which::PminOne)?);
                (end, inside, Quantity::Probability(1), None)
            }
            (Wanted::Reward(cost, target), Optimum::Min) => {
                ((*target).clone(), region(Which::PmaxOne)?, Quantity::Cost(1), Some(*cost))
            }
            (Wanted::Reward(cost, target), Optimum::Max) => {
                ((*target).clone(), region(Which::PminOne)?, Quantity::Reward, Some(*cost))
            }
        };
        let mut meter = Meter::new(engine);
        let search = Search { engine, program, end, inside, cost };
        let before = meter.bytes();
        let Reached { graph, starts, .. } = search.explored(states, &mut meter)?;
        // The graph alone is needed from now on.
        meter.release_to(before + graph.bytes());
        let is_negated = cost.is_none() && optimum == Optimum::Min;
        Ok(Paths { graph, starts, quantity, is_negated, meter })
    }

    /// Computes the values of the states asked for. With `exact`, computes with fractions.
    ///
    /// # Errors
    /// A limit is reached before bounds are known.
    pub fn values(&mut self, exact: bool) -> Result<Answer> {
        let before = self.meter.bytes();
        let answer = if exact { self.computed::<Ratio>() } else { self.computed::<Interval>() };
        self.meter.release_to(before);
        answer
    }

    fn computed<N: Number>(&mut self) -> Result<Answer> {
        let (graph, is_probability) = (&self.graph, self.quantity.is_probability());
        let fractions: Vec<N> = graph.fractions().iter().map(N::of).collect();
        let (solution, end) = solved(graph, self.quantity, (None, &fractions), &mut self.meter)?;
        let (end, most) =
            (if N::EXACT { Ok(end?) } else { end }, if is_probability { 1.0 } else { f64::INFINITY });
        let value = |&node: &u32| match node {
            END => Some(if is_probability { N::one() } else { N::zero() }),
            LOST => is_probability.then(N::zero),
            node => value_at(&solution, node, most),
        };
        let found = Vector { values: self.starts.iter().map(value).collect(), end };
        Ok(if self.is_negated { found.complemented() } else { found }.answer(most))
    }
}

/// The greatest probabilities with which some states achieve an objective, and the choices that attain
/// them.
#[derive(Debug)]
pub(crate) struct Likely {
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
    /// sure, or impossible: the regions `sure` and `possible`. Cost: as [`values`].
    ///
    /// # Errors
    /// The errors of [`values`].
    pub(crate) fn compute<E: Engine>(
        engine: &E,
        program: &Program,
        (sure, possible): (&E::States, &E::States),
        states: &[State],
    ) -> Result<Self> {
        let mut meter = Meter::new(engine);
        let search = Search { engine, program, end: sure.clone(), inside: possible.clone(), cost: None };
        let (mut found, codes) = search.walked(states, &mut meter)?;
        let (costs, codec) = (ties::costs(&mut found.graph), Codec::new(program)?);
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
    pub(crate) fn probability(&self, state: &[i64]) -> Option<Bounds> {
        let node = match self.node(state)? {
            END => return Some(Bounds::point(1)),
            LOST => return Some(Bounds::point(0)),
            node => node,
        };
        let known = self.solution.get(node).map(|x| Bounds::of(x).at_most_one());
        let mut bounds = known.unwrap_or_else(|| Bounds::any(1.0));
        let [loss, _] = self.ties.as_ref().map_or([0.0; 2], |ties| ties.loss(node, 0));
        bounds.lose(loss);
        Some(bounds)
    }

    /// Returns the choice that attains the probability, of several the one with the least expected number of
    /// steps until the objective is sure or impossible, by its position in the order of the program;
    /// `None` where the objective is almost sure or impossible.
    pub(crate) fn pick(&self, state: &[i64]) -> Option<usize> {
        let node = self.node(state).filter(|node| *node != END && *node != LOST)?;
        Some(self.ties.as_ref().map_or_else(|| self.solution.pick(node), |ties| ties.pick(node, 0)))
            .filter(|choice| *choice != NONE)
            .map(|choice| self.found.graph.position(choice))
    }
}
