//! The quantities of `reach`: the extreme probability of a formula, and the extreme expected reward
//! until a target is reached.
//!
//! Regions come first. A probability is 1 or 0 in the qualitative regions of the formula, and between
//! them it is the probability to reach the first. The least probability is 1 minus the greatest
//! probability of the negation. An expected reward is finite where the target is reached almost
//! surely: by some strategy for the least, by every strategy for the greatest. So only the states
//! between the regions, as far as the given states reach them, have equations.

use std::collections::VecDeque;

use ahash::AHashMap;

use super::cost::{Cost, Earned};
use super::graph::{Closed, EVERY, Edge, Graph, LOST, Rank};
use super::meter::Meter;
use super::number::{Bounds, Interval, Number};
use super::solution::Solution;
use super::solve::{NONE, Quantity, SMALL, System};
use meliora_engine::explicit::weighted::{Code, Codec, Walk, Walker};
use meliora_engine::regions::{Regions, Which};
use meliora_engine::{Engine, position as position_of};
use meliora_model::error::Result;
use meliora_model::exact::Ratio;
use meliora_model::property::Measure;
use meliora_model::{Optimum, Program, State};

/// The node of all states where the path ends.
const END: u32 = 0;

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
}

/// The values of some states.
#[derive(Debug)]
pub struct Answer {
    /// The values, in the order of the states.
    pub values: Vec<Value>,
    /// An error if a limit was reached. The bounds hold then too, but may be wide.
    pub end: Result<()>,
}

/// Returns the regions from which [`values`] computes a quantity.
pub fn needed(measure: &Measure, optimum: Optimum) -> &'static [Which] {
    match (measure, optimum) {
        (Measure::Probability, Optimum::Max) => &[Which::PmaxPositive, Which::PmaxOne],
        (Measure::Probability, Optimum::Min) => &[Which::PminPositive, Which::PminOne],
        (Measure::Reward(_), Optimum::Min) => &[Which::PmaxOne],
        (Measure::Reward(_), Optimum::Max) => &[Which::PminOne],
    }
}

/// Computes a quantity in some states of the scope, from the regions of the formula that [`needed`]
/// names; for a reward, these are the regions of reaching the target. With `exact`, computes with fractions, which can
/// become very long.
///
/// Cost: one evaluation of the commands, and some membership tests, per state between the regions
/// that the given states reach.
///
/// # Errors
/// A limit is reached before bounds are known; a command or a reward has no meaning in some state; a
/// region is missing.
pub fn values<E: Engine>(
    engine: &E,
    program: &Program,
    (wanted, optimum): (&Wanted<'_, E::States>, Optimum),
    regions: &Regions<Option<E::States>>,
    states: &[State],
    exact: bool,
) -> Result<Answer> {
    program.of_one_player("a number")?;
    let all = engine.all_states();
    let region = |which: Which| regions.known(which).cloned();
    let others = |which: Which| engine.difference(&all, regions.known(which)?);
    let search = match (wanted, optimum) {
        (Wanted::Probability, Optimum::Max) => {
            let (end, inside) = (region(Which::PmaxOne)?, region(Which::PmaxPositive)?);
            Search { engine, program, end, inside, quantity: Quantity::Probability(1), cost: None }
        }
        (Wanted::Probability, Optimum::Min) => {
            let (end, inside) = (others(Which::PminPositive)?, others(Which::PminOne)?);
            Search { engine, program, end, inside, quantity: Quantity::Probability(1), cost: None }
        }
        (Wanted::Reward(cost, target), Optimum::Min) => {
            let (end, inside) = ((*target).clone(), region(Which::PmaxOne)?);
            Search { engine, program, end, inside, quantity: Quantity::Cost(1), cost: Some(*cost) }
        }
        (Wanted::Reward(cost, target), Optimum::Max) => {
            let (end, inside) = ((*target).clone(), region(Which::PminOne)?);
            Search { engine, program, end, inside, quantity: Quantity::Reward, cost: Some(*cost) }
        }
    };
    let mut answer = if exact { search.run::<Ratio>(states)? } else { search.run::<Interval>(states)? };
    if search.cost.is_none() && optimum == Optimum::Min {
        answer.values = answer.values.into_iter().map(complemented).collect();
    }
    Ok(answer)
}

/// Returns 1 minus a probability.
fn complemented(value: Value) -> Value {
    let Value::Finite(Bounds { interval, exact }) = value else { return value };
    let rest = |x: f64, round: fn(f64) -> f64| if x == 0.0 || x == 1.0 { 1.0 - x } else { round(1.0 - x) };
    let lower = rest(interval.upper.min(1.0), f64::next_down).max(0.0);
    let upper = rest(interval.lower, f64::next_up).min(1.0);
    Value::Finite(Bounds { interval: Interval { lower, upper }, exact: exact.map(|x| Ratio::one() - x) })
}

/// The greatest probabilities with which some states achieve an objective, and the choices that attain
/// them.
#[derive(Debug)]
pub(super) struct Likely {
    graph: Graph,
    codec: Codec,
    index: AHashMap<Code, u32>,
    solution: Solution<Interval>,
}

impl Likely {
    /// Computes the values of some states and of those that they reach until the objective is almost
    /// sure, or impossible: the regions `sure` and `possible`. Cost: as [`values`].
    ///
    /// # Errors
    /// The errors of [`values`].
    pub(super) fn compute<E: Engine>(
        engine: &E,
        program: &Program,
        (sure, possible): (&E::States, &E::States),
        states: &[State],
    ) -> Result<Self> {
        let (end, inside) = (sure.clone(), possible.clone());
        let search = Search { engine, program, end, inside, quantity: Quantity::Probability(1), cost: None };
        let Solved { graph, codec, index, solution, end, .. } = search.solved(states)?;
        end.map(|()| Likely { graph, codec, index, solution })
    }

    /// Returns the node of a state; `None` if it was not explored.
    fn node(&self, state: &[i64]) -> Option<u32> {
        self.index.get(&self.codec.known(state).ok()?).copied()
    }

    /// Returns the greatest probability; `None` if the state was not explored.
    pub(super) fn probability(&self, state: &[i64]) -> Option<Bounds> {
        Some(match self.node(state)? {
            END => Bounds::point(1),
            LOST => Bounds::point(0),
            node => self.solution.get(node).map_or_else(|| Bounds::any(1.0), |x| Bounds::of(x).at_most_one()),
        })
    }

    /// Returns the choice that attains the probability, by its position in the order of the program;
    /// `None` where the objective is almost sure or impossible.
    pub(super) fn pick(&self, state: &[i64]) -> Option<usize> {
        let node = self.node(state).filter(|node| *node != END && *node != LOST)?;
        Some(self.solution.pick(node))
            .filter(|choice| *choice != NONE)
            .map(|choice| self.graph.position(choice))
    }
}

/// A search for the states that have equations.
struct Search<'a, E: Engine> {
    engine: &'a E,
    program: &'a Program,
    /// The states where the path ends: with the probability 1, or without further reward.
    end: E::States,
    /// The states in which the path goes on; it fails where it leaves them.
    inside: E::States,
    quantity: Quantity,
    cost: Option<Earned<'a>>,
}

/// The states found so far.
#[derive(Default)]
struct Found {
    index: AHashMap<Code, u32>,
    queue: VecDeque<(u32, Code)>,
}

/// The states that have equations, with their solution.
struct Solved<N> {
    graph: Graph,
    codec: Codec,
    index: AHashMap<Code, u32>,
    /// The nodes of the states asked for.
    starts: Vec<u32>,
    solution: Solution<N>,
    /// An error if a limit was reached.
    end: Result<()>,
}

impl<E: Engine> Search<'_, E> {
    /// Returns the values of some states.
    fn run<N: Number>(&self, states: &[State]) -> Result<Answer> {
        let Solved { starts, solution, end, .. } = self.solved::<N>(states)?;
        let value = |node: &u32| match *node {
            END => Value::Finite(Bounds::of(&if self.cost.is_some() { N::zero() } else { N::one() })),
            LOST if self.cost.is_some() => Value::Infinite,
            LOST => Value::Finite(Bounds::of(&N::zero())),
            node => Value::Finite(match solution.get(node).map(Bounds::of) {
                None => self.anything(),
                Some(bounds) if self.cost.is_some() => bounds,
                Some(bounds) => bounds.at_most_one(),
            }),
        };
        Ok(Answer { values: starts.iter().map(value).collect(), end })
    }

    /// Finds the states that some states reach, and solves their equations.
    fn solved<N: Number>(&self, states: &[State]) -> Result<Solved<N>> {
        let mut meter = Meter::new(self.engine);
        let (mut graph, mut found) = (Graph::default(), Found::default());
        graph.add_node(Rank::default(), false, &mut meter)?;
        let mut starts = Vec::with_capacity(states.len());
        let mut walker = Walker::new(self.program, &*self.engine.settings().sink)?;
        let codec = walker.codec().clone();
        for state in states {
            let code = codec.known(state)?;
            starts.push(self.node(state, code, &mut graph, &mut found, &mut meter)?);
        }
        let mut walk = walker.walk();
        while let Some((node, code)) = found.queue.pop_front() {
            meter.step()?;
            meter.progress(&|| format!("{} states", graph.nodes()));
            let choices = self.choices((&codec, &code), &mut *walk, &mut graph, &mut found, &mut meter)?;
            graph.close(node, choices, &mut meter)?;
        }
        let fractions: Vec<N> = graph.fractions().iter().map(N::of).collect();
        let system = System {
            graph: &graph,
            quantity: self.quantity,
            below: None,
            fractions: &fractions,
            small: SMALL,
            margin: None,
        };
        let mut solution = system.start(&mut meter)?;
        let end = system.solve(&mut solution, &mut meter);
        Ok(Solved { graph, codec, index: found.index, starts, solution, end })
    }

    /// Returns the bounds of a value of which nothing is known.
    fn anything(&self) -> Bounds {
        let upper = if self.cost.is_some() { f64::INFINITY } else { 1.0 };
        Bounds { interval: Interval { lower: 0.0, upper }, exact: None }
    }

    /// Returns the node of a state, which is new or known, [`END`] or [`LOST`].
    fn node(
        &self,
        state: &State,
        code: Code,
        graph: &mut Graph,
        found: &mut Found,
        meter: &mut Meter<'_>,
    ) -> Result<u32> {
        if let Some(&known) = found.index.get(&code) {
            return Ok(known);
        }
        let node = if self.engine.contains(&self.end, state)? {
            END
        } else if !self.engine.contains(&self.inside, state)? {
            LOST
        } else {
            let sure = if self.cost.is_some() { EVERY } else { 0 };
            let node = graph.add_node(Rank { positive: EVERY, sure }, false, meter)?;
            found.queue.push_back((node, code.clone()));
            node
        };
        meter.take(2 * size_of::<(Code, u32)>() + 16 * code.len())?;
        found.index.insert(code, node);
        Ok(node)
    }

    /// Returns all choices of a state that stay in the states of the engine.
    fn choices(
        &self,
        (codec, code): (&Codec, &Code),
        walk: &mut dyn Walk,
        graph: &mut Graph,
        found: &mut Found,
        meter: &mut Meter<'_>,
    ) -> Result<Vec<Closed>> {
        let state = codec.decode(code);
        let listed = walk.choices(code, &mut graph.known)?;
        let all = self.engine.all_states();
        let mut choices = Vec::with_capacity(listed.len());
        for (position, step) in (0u32..).zip(listed) {
            // Known states are in the engine.
            let leaves = |(next, _): &(Code, u32)| {
                Ok(!found.index.contains_key(next) && !self.engine.contains(&all, &codec.decode(next))?)
            };
            if position_of(&step.successors, leaves)?.is_some() {
                continue;
            }
            let cost = match &self.cost {
                Some(cost) => cost.of(&state, &step.combinations())?,
                None => Ratio::zero(),
            };
            let cost = graph.fraction(cost);
            let mut edges = Vec::with_capacity(step.successors.len());
            for (next, probability) in step.successors {
                let to = match found.index.get(&next) {
                    Some(&known) => known,
                    None => self.node(&codec.decode(&next), next, graph, found, meter)?,
                };
                edges.push(Edge::new(to, probability, to == END));
            }
            choices.push((position, cost, edges));
        }
        Ok(choices)
    }
}
