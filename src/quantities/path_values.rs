//! The quantities of `reach`: the extreme probability of a formula, and the extreme expected reward
//! until a target is reached.
//!
//! Regions come first. A probability is 1 or 0 in the qualitative regions of the formula, and between
//! them it is the probability to reach the first. The least probability is 1 minus the greatest
//! probability of the negation. An expected reward is finite where the target is reached almost
//! surely: by some strategy for the least, by every strategy for the greatest. So only the states
//! between the regions, as far as the given states reach them, have equations.

use super::codes::Codes;
use super::cost::{Cost, Earned};
use super::graph::{EVERY, Edge, Graph, LOST, Rank};
use super::meter::Meter;
use super::number::{Bounds, Interval, Number, Weight};
use super::solution::Solution;
use super::solve::NONE;
use super::system::{Quantity, System};
use meliora_engine::Engine;
use meliora_engine::explicit::weighted::{Code, Codec, Steps, Walk, Walker};
use meliora_engine::membership::{Membership, Numbers};
use meliora_engine::regions::{Regions, Which};
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
    found: Found,
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
        let Solved { graph, codec, found, solution, end, .. } = search.solved(states)?;
        end.map(|()| Likely { graph, codec, found, solution })
    }

    /// Returns the node of a state; `None` if it was not explored.
    fn node(&self, state: &[i64]) -> Option<u32> {
        self.found.node(&self.codec.known(state).ok()?)
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
            .map(|choice| self.graph.position(node, choice))
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
#[derive(Debug)]
struct Found {
    codes: Codes,
    /// The node of each state, [`END`] or [`LOST`].
    nodes: Vec<u32>,
}

impl Found {
    /// Returns the node of a state that was found.
    fn node(&self, code: &[u64]) -> Option<u32> {
        self.codes.find(KEY, code).map(|number| self.nodes[number as usize])
    }
}

/// The key of all codes.
const KEY: u32 = 0;

/// The end of a step.
#[derive(Debug, Clone, Copy)]
enum Target {
    /// To a state that was found: its node, [`END`] or [`LOST`].
    Found(u32),
    /// To another state of this part of the engine.
    New(Part),
}

/// A part of the states of the engine.
#[derive(Debug, Clone, Copy)]
enum Part {
    End,
    Inside,
    Lost,
}

impl Part {
    /// Returns the part of a state that is in some of these sets: the ends, the states in which the path goes
    /// on, and all states of the engine.
    fn of(marks: u64) -> Option<Self> {
        match marks.trailing_zeros() {
            0 => Some(Part::End),
            1 => Some(Part::Inside),
            2 => Some(Part::Lost),
            _ => None,
        }
    }
}

/// The states that have equations, with their solution.
struct Solved<N> {
    graph: Graph,
    codec: Codec,
    found: Found,
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
        let mut walker = Walker::new(self.program, &*self.engine.settings().sink)?;
        let codec = walker.codec().clone();
        let (graph, found, starts) = self.explored(states, &mut walker, &mut meter)?;
        let fractions: Vec<N> = graph.fractions().iter().map(N::of).collect();
        let system = System {
            graph: &graph,
            quantity: self.quantity,
            below: None,
            fractions: &fractions,
            first: None,
            margin: None,
        };
        let mut solution = system.start(&mut meter)?;
        let end = system.solve(&mut solution, &mut meter);
        Ok(Solved { graph, codec, found, starts, solution, end })
    }

    /// Finds the states that some states reach; returns their graph, and the nodes of those states.
    fn explored(
        &self,
        states: &[State],
        walker: &mut Walker<'_>,
        meter: &mut Meter<'_>,
    ) -> Result<(Graph, Found, Vec<u32>)> {
        let parts = self.engine.membership(&[&self.end, &self.inside, &self.engine.all_states()])?;
        let codec = walker.codec().clone();
        let found = Found { codes: Codes::new(self.program, &codec), nodes: Vec::new() };
        let mut graph = Graph::default();
        let free = graph.fraction(Ratio::zero());
        let known = parts.numbers().map(|numbers| Known::new(numbers, meter)).transpose()?;
        let parts = &*parts;
        let mut explorer = Explorer { search: self, parts, known, codec: &codec, graph, found, free, meter };
        let starts = explorer.run(states, &mut *walker.walk())?;
        Ok((explorer.graph, explorer.found, starts))
    }

    /// Returns the bounds of a value of which nothing is known.
    fn anything(&self) -> Bounds {
        let upper = if self.cost.is_some() { f64::INFINITY } else { 1.0 };
        Bounds { interval: Interval { lower: 0.0, upper }, exact: None }
    }
}

/// The exploration of the graph of a search.
struct Explorer<'a, 'm, E: Engine> {
    search: &'a Search<'a, E>,
    /// Tells the [`Part`] of a state.
    parts: &'a dyn Membership,
    /// The states by their numbers, if the engine has explored them one by one.
    known: Option<Known<'a>>,
    codec: &'a Codec,
    graph: Graph,
    found: Found,
    /// The number of the cost 0.
    free: u32,
    meter: &'a mut Meter<'m>,
}

/// The states that were found, by the numbers of the engine: so none is looked up by its code.
struct Known<'a> {
    numbers: &'a dyn Numbers,
    /// The node of each state of the engine, or [`UNSEEN`].
    nodes: Vec<u32>,
    /// The number of each state found; `None` for those that the engine does not have.
    states: Vec<Option<u32>>,
    /// The successors of a choice.
    successors: Vec<u32>,
}

/// The node of a state that was not found yet.
const UNSEEN: u32 = LOST - 1;

impl<'a> Known<'a> {
    fn new(numbers: &'a dyn Numbers, meter: &mut Meter<'_>) -> Result<Self> {
        meter.take(numbers.states() * (size_of::<u32>() + size_of::<Option<u32>>()))?;
        let nodes = vec![UNSEEN; numbers.states()];
        Ok(Known { numbers, nodes, states: Vec::new(), successors: Vec::new() })
    }

    /// Returns the node of a state that was found.
    fn node(&self, number: u32) -> Option<u32> {
        Some(self.nodes[number as usize]).filter(|&node| node != UNSEEN)
    }

    /// Adds a state.
    fn add(&mut self, number: Option<u32>, node: u32) {
        self.states.push(number);
        if let Some(number) = number {
            self.nodes[number as usize] = node;
        }
    }
}

impl<E: Engine> Explorer<'_, '_, E> {
    /// Explores the states that some states of the engine reach, breadth first; returns their nodes.
    fn run(&mut self, states: &[State], walk: &mut dyn Walk) -> Result<Vec<u32>> {
        self.graph.add_node(Rank::default(), false, self.meter)?;
        let mut starts = Vec::with_capacity(states.len());
        for state in states {
            let code = self.codec.known(state)?;
            let number = self.known.as_ref().and_then(|known| known.numbers.number(&code));
            let target = self.target(&code, number)?.unwrap_or(Target::New(Part::Lost));
            starts.push(self.enter(target, &code, number)?);
        }
        let (mut steps, mut targets, mut next) = (Steps::default(), Vec::new(), 0);
        while let Some(&node) = self.found.nodes.get(next) {
            let code = self.found.codes.code(next as u32);
            let number = self.known.as_ref().and_then(|known| known.states[next]);
            next += 1;
            if node == END || node == LOST {
                continue;
            }
            self.meter.step()?;
            self.meter.progress_at(next, &|| format!("{} states", self.graph.nodes()));
            walk.steps(&code, &mut self.graph.known, &mut steps)?;
            self.graph.begin(node, self.meter)?;
            for position in 0..steps.choices() {
                self.follow(number, position);
                if self.stays(&steps, position, &mut targets)? {
                    self.choice((&code, position), (walk, &steps), &targets)?;
                }
            }
            self.graph.end(node, self.meter)?;
        }
        Ok(starts)
    }

    /// Finds the numbers of the successors of a choice, if the engine has numbers.
    fn follow(&mut self, state: Option<u32>, position: usize) {
        let Some(known) = &mut self.known else { return };
        known.successors.clear();
        if let Some(state) = state {
            known.numbers.successors(state, position, &mut known.successors);
        }
    }

    /// Returns the number of a successor of the choice.
    fn successor(&self, at: usize) -> Option<u32> {
        self.known.as_ref()?.successors.get(at).copied()
    }

    /// Finds the targets of a choice; returns whether all are states of the engine.
    fn stays(&self, steps: &Steps, position: usize, targets: &mut Vec<Target>) -> Result<bool> {
        targets.clear();
        for (at, (code, _)) in steps.of(position).enumerate() {
            match self.target(code, self.successor(at))? {
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
        let cost = match &self.search.cost {
            Some(cost) => {
                let cost = cost.of(&self.codec.decode(code), &walk.taken(position).combinations)?;
                self.graph.fraction(cost)
            }
            None => self.free,
        };
        self.graph.add_choice(position as u32, cost);
        for (at, ((code, probability), &target)) in steps.of(position).zip(targets).enumerate() {
            let to = self.enter(target, code, self.successor(at))?;
            self.graph.add_edge(Edge::new(to, probability, to == END));
        }
        Ok(())
    }

    /// Finds a state, by its number if it has one; `None` if it is not one of the engine.
    fn target(&self, code: &[u64], number: Option<u32>) -> Result<Option<Target>> {
        let (known, marks) = match (&self.known, number) {
            (Some(known), Some(number)) => match known.node(number) {
                Some(node) => (Some(node), 0),
                None => (None, known.numbers.marks(number)),
            },
            (Some(_), None) => (None, 0),
            (None, _) => match self.found.node(code) {
                Some(node) => (Some(node), 0),
                None => (None, self.parts.of(&self.codec.decode(code))?),
            },
        };
        Ok(known.map(Target::Found).or_else(|| Part::of(marks).map(Target::New)))
    }

    /// Returns the node of a target, which is added if it is new.
    fn enter(&mut self, target: Target, code: &[u64], number: Option<u32>) -> Result<u32> {
        let node = match target {
            Target::Found(node) => return Ok(node),
            Target::New(Part::End) => END,
            Target::New(Part::Lost) => LOST,
            Target::New(Part::Inside) => {
                let sure = if self.search.cost.is_some() { EVERY } else { 0 };
                self.graph.add_node(Rank { positive: EVERY, sure }, false, self.meter)?
            }
        };
        self.meter.take(size_of::<u32>())?;
        match &mut self.known {
            Some(known) => {
                known.add(number, node);
                self.found.codes.push(KEY, code, self.meter)?;
            }
            None => self.found.codes.add(KEY, code, self.meter)?,
        }
        self.found.nodes.push(node);
        Ok(node)
    }
}
