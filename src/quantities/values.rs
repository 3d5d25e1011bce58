//! The quantities of a finished analysis: probabilities, costs and expected numbers of improvements.

use crate::cost::Cost;
use crate::exploration::Exploration;
use crate::places::{Place, Places};
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_base::interval::{Bounds, Interval};
use meliora_base::number::Weight;
use meliora_engine::Engine;
use meliora_equations::{Edge, Graph, LOST, Meter, Quantities, Quantity};
use meliora_model::{Program, State};
use meliora_planning::{Analysis, Kind};

/// The options of [`Values`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ValueOptions {
    /// The greatest k for which P_k and C_k are computed.
    pub levels: usize,
    /// Computes with fractions instead of intervals. Fractions can become very long: this is for
    /// small models.
    pub exact: bool,
    /// The greatest number of steps of the success curves; `None` for no curves.
    pub within: Option<usize>,
}

/// The values of a choice at one level.
#[derive(Debug, Clone, PartialEq)]
pub struct ChoiceValues {
    /// The position among the choices of the state, as in [`Program::choices`].
    pub position: usize,
    /// The probability to make k improvements if this choice is taken now.
    pub probability: Bounds,
    /// The expected cost; `None` if the choice does not keep the improvements certain.
    pub cost: Option<Bounds>,
}

/// The quantity for which a choice is to be best.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Aim {
    /// The greatest probability of k improvements; where it is 1, also the least cost.
    Likely,
    /// The least expected cost until the k-th improvement, where it is certain.
    Cheap,
}

/// A state in an arena of the improvement MDP, as a node of the solver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Node(u32);

/// The quantities of the states that some states reach.
#[derive(Debug)]
pub struct Values {
    options: ValueOptions,
    pub(crate) graph: Graph,
    pub(crate) places: Places,
    /// The nodes of the states asked for.
    pub(crate) starts: Vec<u32>,
    pub(crate) found: Quantities,
}

impl Values {
    /// Creates quantities without results.
    pub fn new(options: ValueOptions) -> Self {
        Values {
            options,
            graph: Graph::default(),
            places: Places::default(),
            starts: Vec::new(),
            found: Quantities::new(options.levels, options.exact),
        }
    }

    /// Computes the quantities of some states of the scope. Cost: see [`Exploration::run`] and
    /// [`Values::solve`].
    ///
    /// # Errors
    /// The errors of both.
    pub fn compute<E: Engine>(
        options: ValueOptions,
        analysis: &Analysis<E>,
        program: &Program,
        states: &[State],
        costs: &dyn Cost,
    ) -> Result<Self> {
        let mut values = Values::new(options);
        Exploration::new(options, analysis, program, costs)?.run(&mut values, states)?;
        values.solve(analysis.engine())?;
        Ok(values)
    }

    /// Returns the options.
    pub fn options(&self) -> ValueOptions {
        self.options
    }

    /// Returns the number of levels for which an analysis suffices: at most `limit` and at most the
    /// SPI levels found, which are all with P_k > 0 unless some states are in the fixpoint.
    pub fn levels_found<E: Engine>(analysis: &Analysis<E>, limit: usize) -> usize {
        limit.min(analysis.levels(Kind::Spi).found.len())
    }

    /// Computes all quantities; after [`Exploration::run_part`], bounds of them. The results before an error are kept.
    pub fn solve<E: Engine>(&mut self, engine: &E) -> Result<()> {
        let mut meter = Meter::settled(engine);
        meter.take(self.graph.bytes() + self.places.bytes())?;
        self.found.solve(&self.graph, &self.starts, self.options.within, &mut meter)
    }

    /// Returns the number of states found, each in its arenas.
    pub fn nodes(&self) -> usize {
        self.graph.nodes()
    }

    /// Returns whether the values of the states asked for are known: all states that they reach were explored, or enough.
    pub fn is_settled(&self) -> bool {
        self.found.is_settled(&self.graph)
    }

    /// Decides ties between choices that attain P_k or C_k by the least expected number of steps until the
    /// k-th improvement, or until fewer than k are possible. To be called after [`Values::solve`]; fractions
    /// and games keep the choices of the solver. Cost: at most three times that of costs with [`Values::solve`].
    ///
    /// # Errors
    /// A limit is reached.
    pub fn decide_ties<E: Engine>(&mut self, engine: &E) -> Result<()> {
        let mut meter = Meter::settled(engine);
        meter.take(self.graph.bytes() + self.places.bytes())?;
        self.found.decide_ties(&mut self.graph, &mut meter)
    }

    /// Returns the value that the choices attain at level k, as [`Values::probability`].
    pub fn attained_probability(&self, node: Node, k: usize) -> Bounds {
        let mut bounds = self.probability(node, k);
        if (self.graph.rank(node.0).sure as usize) < k {
            bounds.lose(self.found.loss(node.0, k)[0]);
        }
        bounds
    }

    /// Returns the value that the choices attain at level k, as [`Values::cost`].
    pub fn attained_cost(&self, node: Node, k: usize) -> Option<Bounds> {
        let mut bounds = self.cost(node, k)?;
        let loss = Interval { lower: 0.0, upper: self.found.loss(node.0, k)[1] };
        bounds.interval = bounds.interval.plus(&loss);
        Some(bounds)
    }

    /// Returns the node of a state in an arena, by its position in
    /// [`Improvement::arenas`](meliora_planning::Improvement::arenas); `None` if it was not explored.
    pub fn node(&self, arena: Option<usize>, state: &[i64]) -> Option<Node> {
        let arena = match arena {
            Some(arena) => Some(u32::try_from(arena).ok()?),
            None => None,
        };
        self.places.find(Place::of(arena), state).map(Node)
    }

    /// Returns the node of a state with which planning starts there; `None` if it was not explored, and
    /// for unsafe states.
    pub fn start(&self, state: &[i64]) -> Option<Node> {
        let own = |arena: Option<u32>| {
            self.places.find(Place::of(arena), state).filter(|&node| self.places.own[node as usize])
        };
        (0..self.places.arenas).map(Some).chain([None]).find_map(own).map(Node)
    }

    /// Returns the state of a node.
    pub fn state(&self, node: Node) -> State {
        self.places.state(node.0)
    }

    /// Returns P_k, the greatest probability of k improvements.
    pub fn probability(&self, node: Node, k: usize) -> Bounds {
        let rank = self.graph.rank(node.0);
        if (rank.positive as usize) < k {
            return Bounds::point(0);
        }
        if rank.sure as usize >= k {
            return Bounds::point(1);
        }
        let known = self.found.value(node.0, Quantity::Probability(k as u32));
        let known = known.filter(|_| self.found.is_solved(&self.graph, node.0));
        known.map_or_else(|| Bounds::any(1.0), |bounds| bounds.at_most(1.0))
    }

    /// Returns C_k, the least expected cost until the k-th improvement; `None` where P_k < 1.
    pub fn cost(&self, node: Node, k: usize) -> Option<Bounds> {
        if k == 0 {
            return Some(Bounds::point(0));
        }
        let known = || self.found.value(node.0, Quantity::Cost(k as u32));
        let is_sure = self.graph.rank(node.0).sure as usize >= k;
        is_sure.then(|| known().unwrap_or_else(|| Bounds::any(f64::INFINITY)))
    }

    /// Returns N, the largest expected number of improvements.
    pub fn number(&self, node: Node) -> Bounds {
        let is_game = self.graph.is_game();
        if self.graph.rank(node.0).positive <= u32::from(!is_game) && self.options.levels > 0 {
            return self.probability(node, 1);
        }
        let known = self.found.value(node.0, Quantity::Number);
        let known = known.filter(|_| self.found.is_solved(&self.graph, node.0));
        known.unwrap_or_else(|| Bounds::any(f64::INFINITY))
    }

    /// Returns P_k^0, P_k^1, …, the greatest probabilities of k improvements within 0, 1, … steps, as
    /// far as they are known; lower bounds with an error of some 1e-16 per step.
    pub fn within(&self, node: Node, k: usize) -> Option<&[f64]> {
        self.found.curve(node.0, k)
    }

    /// Returns the values of the kept choices of a state at level k, those that are best first: the
    /// [`Values::best_choice`], then by probability or cost, then in the order of the program.
    pub fn choices(&self, node: Node, k: usize, aim: Aim) -> Vec<ChoiceValues> {
        if k == 0 {
            return Vec::new();
        }
        let probability = |choice: u32| {
            let known = self.found.of_choice(&self.graph, Quantity::Probability(k as u32), choice);
            known.map_or_else(|| Bounds::any(1.0), |bounds| bounds.at_most(1.0))
        };
        let value = |choice: u32| {
            let cost = self.found.of_choice(&self.graph, Quantity::Cost(k as u32), choice);
            // A choice that keeps the improvements certain has the probability 1 without rounding.
            let probability = if cost.is_some() { Bounds::point(1) } else { probability(choice) };
            let position = self.graph.position(choice);
            ChoiceValues { position, probability, cost }
        };
        let best = self.best_choice(node, k, aim);
        let mut values: Vec<ChoiceValues> = self.graph.choices(node.0).map(value).collect();
        let key = |v: &ChoiceValues| {
            let cost = v.cost.as_ref().map_or(f64::INFINITY, |cost| cost.interval.lower);
            let loss = -v.probability.interval.lower;
            let (first, second) = if aim == Aim::Likely { (loss, cost) } else { (cost, loss) };
            // The opponent's are those that are worst for us.
            let sign = if self.graph.is_theirs(node.0) { -1.0 } else { 1.0 };
            let (first, second) = (sign * first, sign * second);
            (Some(v.position) != best, first, second, v.position)
        };
        values.sort_by(|a, b| key(a).partial_cmp(&key(b)).unwrap_or(std::cmp::Ordering::Equal));
        values
    }

    /// Returns the choice that a strategy takes to attain P_k or C_k, by its position among the
    /// choices of the state; `None` where P_k = 0 (for [`Aim::Cheap`]: where P_k < 1), or if it is
    /// not known.
    ///
    /// The choices of all nodes together attain the values, up to the precision. Among equally good choices
    /// this is one that comes closer to an improvement and, after [`Values::decide_ties`], one with which the
    /// expected number of steps is least. After a step, go on with [`Values::successor`].
    pub fn best_choice(&self, node: Node, k: usize, aim: Aim) -> Option<usize> {
        let choice = self.pick(node.0, k, aim)?;
        Some(self.graph.position(choice))
    }

    fn pick(&self, node: u32, k: usize, aim: Aim) -> Option<u32> {
        let quantity = match aim {
            Aim::Likely => Quantity::Probability(k as u32),
            Aim::Cheap => Quantity::Cost(k as u32),
        };
        self.found.pick(&self.graph, quantity, node)
    }

    /// Returns the number of improvements that a strategy aims at from a node: the greatest k, at most
    /// that of [`ValueOptions::levels`], with P_k > 0 (for [`Aim::Cheap`]: with P_k = 1).
    pub fn aimed(&self, node: Node, aim: Aim) -> usize {
        let rank = self.graph.rank(node.0);
        let k = match aim {
            Aim::Likely => rank.positive,
            Aim::Cheap => rank.sure,
        };
        self.options.levels.min(k as usize)
    }

    /// Returns the cost of the [`Values::best_choice`].
    pub fn best_choice_cost(&self, node: Node, k: usize, aim: Aim) -> Option<&Ratio> {
        let cost = self.graph.cost(self.pick(node.0, k, aim)?);
        self.graph.fractions().get(cost as usize)
    }

    /// Returns the node and the number of improvements still wanted after a step to a state; `None` if
    /// the step is lost, or not by a kept choice.
    pub fn successor(&self, node: Node, k: usize, aim: Aim, to: &[i64]) -> Option<(Node, usize)> {
        let is_there = |edge: &Edge| edge.to != LOST && self.places.is_at(edge.to, to);
        // The choice does not matter: the states decide whether a step improves.
        let mut edges = self.graph.choices(node.0).flat_map(|choice| self.graph.edges(choice));
        let edge = edges.find(is_there)?;
        let (mut node, mut left) = (edge.to, k.checked_sub(usize::from(edge.counts()))?);
        if self.graph.is_junction(node) {
            // If nothing can follow either way, the improvement is counted.
            let choice = self.pick(node, left, aim).or_else(|| self.graph.choices(node).next())?;
            let edge = self.graph.edges(choice).next()?;
            (node, left) = (edge.to, left.checked_sub(usize::from(edge.counts()))?);
        }
        Some((Node(node), left))
    }
}
