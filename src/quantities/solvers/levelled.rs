//! The quantities of all levels against an opponent.
//!
//! The equations of all levels are one game: its states are nodes, each with the number of improvements that are still
//! wanted there. P_k is the probability to make the last of them, C_k the cost until then. N is the total reward of a game
//! on the nodes in which an improvement earns 1; it may be infinite.

use bitvec::vec::BitVec;
use num_traits::Zero;

use crate::equations::game_graph::{GameGraph, Goal, Rewards};
use crate::equations::graph::{Edge, Graph, LOST, NONE};
use crate::equations::meter::Meter;
use crate::equations::number::{Number, PRECISION};
use crate::equations::solution::Solution;
use crate::equations::system::{Quantity, Sense, System};
use crate::solvers::groups::Entry;
use crate::solvers::reaching::{Collected, Led, Reaching};
use crate::solvers::solved::Solved;
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_model::Optimum;

/// The state in which the path has failed.
const FAILED: u32 = 0;
/// The state in which the last improvement has been made.
const MADE: u32 = 1;

impl<N: Number> Solved<N> {
    /// Does the same as [`Solved::run`] for a game: we maximise P_k and N and minimise C_k, the opponent does the contrary.
    ///
    /// # Errors
    /// A limit is reached; the solutions before it are kept.
    pub(crate) fn run_game<E: Entry<Read = N>>(
        &mut self,
        graph: &Graph,
        levels: usize,
        meter: &mut Meter<'_>,
    ) -> Result<()> {
        meter.take(graph.fractions().len() * N::BYTES)?;
        self.fractions = graph.fractions().iter().map(N::of).collect();
        let (found, end) = by_level::<E>(graph, &Quantity::Probability, levels, meter)?;
        self.probability = found;
        end?;
        let (found, end) = by_level::<E>(graph, &Quantity::Cost, levels, meter)?;
        self.cost = found;
        end?;
        self.run_number::<E>(graph, meter)
    }

    /// Solves the equations of the expected numbers of improvements.
    fn run_number<E: Entry<Read = N>>(&mut self, graph: &Graph, meter: &mut Meter<'_>) -> Result<()> {
        let unfolded = Unfolded::new(graph, &|_| Quantity::Number, 1, meter)?;
        let found = unfolded.solve::<E>(Quantity::Number, meter)?;
        let system = System::new(graph, Quantity::Number, None, &self.fractions);
        let mut solution = system.start(meter)?;
        unfolded.store(&system, &found, &mut solution);
        let is_endless = |node: u32| system.is_open(node) && !solution.knows(node);
        self.endless = (0..graph.nodes() as u32).map(is_endless).collect();
        self.number = Some(solution);
        found.values.end
    }
}

/// The solutions of the levels from 1 on, and the error that ended the work.
type Levels<N> = (Vec<Solution<N>>, Result<()>);

/// Returns the solutions of a quantity of a game at the levels 1, …, `levels`, and an error if a limit was reached.
///
/// # Errors
/// A limit is reached before anything is known.
pub(crate) fn by_level<E: Entry>(
    graph: &Graph,
    of: &dyn Fn(u32) -> Quantity,
    levels: usize,
    meter: &mut Meter<'_>,
) -> Result<Levels<E::Read>> {
    let fractions: Vec<E::Read> = graph.fractions().iter().map(Number::of).collect();
    let (mut solutions, levels): (Vec<Solution<E::Read>>, _) = (Vec::new(), levels as u32);
    let (unfolded, before) = (Unfolded::new(graph, of, levels, meter)?, meter.bytes());
    let found = unfolded.solve::<E>(of(1), meter)?;
    meter.release_to(before);
    for k in 1..=levels {
        let system = System::new(graph, of(k), solutions.last(), &fractions);
        let mut solution = system.start(meter)?;
        unfolded.store(&system, &found, &mut solution);
        solutions.push(solution);
    }
    Ok((solutions, found.values.end))
}

/// The game of all levels of a quantity.
struct Unfolded<'g> {
    graph: &'g Graph,
    quantity: Quantity,
    game: GameGraph,
    rewards: Rewards,
    /// The state of each node at each level, or [`NONE`].
    states: Vec<u32>,
    /// The choice in the graph of each choice of the game.
    choices: Vec<u32>,
}

impl<'g> Unfolded<'g> {
    /// Creates the game of the levels 1, …, `levels` of a quantity. Cost: linear for each level.
    ///
    /// # Errors
    /// The memory limit is reached.
    fn new(
        graph: &'g Graph,
        of: &dyn Fn(u32) -> Quantity,
        levels: u32,
        meter: &mut Meter<'_>,
    ) -> Result<Self> {
        let system = |k: u32| System::<Ratio>::new(graph, of(k), None, &[]);
        let nodes = || 0..graph.nodes() as u32;
        let mut new = Unfolded {
            graph,
            quantity: of(1),
            game: GameGraph { fractions: graph.known.clone(), ..GameGraph::default() },
            rewards: Rewards { fractions: graph.known.clone(), ..Rewards::default() },
            states: Vec::new(),
            choices: Vec::new(),
        };
        meter.take(levels as usize * graph.nodes() * size_of::<u32>())?;
        let mut last = MADE;
        for k in 1..=levels {
            let system = system(k);
            new.states.extend(nodes().map(|node| {
                last += u32::from(system.is_open(node));
                if system.is_open(node) { last } else { NONE }
            }));
        }
        // The state of a failure is the opponent's, so that a game is solved as one.
        let mut theirs = BitVec::new();
        for (end, owner) in [(FAILED, true), (MADE, false)] {
            new.rest(end);
            new.game.choices.first.push(new.choices.len() as u32);
            theirs.push(owner);
        }
        for k in 1..=levels {
            let system = system(k);
            for node in nodes().filter(|&node| system.is_open(node)) {
                meter.step()?;
                new.add(&system, node, meter)?;
                theirs.push(graph.is_theirs(node));
            }
        }
        new.game.theirs = Some(theirs);
        Ok(new)
    }

    /// Adds a choice that enters one state for certain and earns nothing.
    fn rest(&mut self, state: u32) {
        let sure = self.game.fractions.number(Ratio::from_integer(1.into()));
        let free = self.rewards.fractions.number(Ratio::zero());
        self.game.choices.to.push(state);
        self.game.weights.push(2 * sure);
        self.game.choices.start.push(self.game.choices.to.len() as u32);
        self.rewards.of_choice.push(free);
        self.choices.push(NONE);
    }

    /// Adds the state of a node at a level.
    fn add(&mut self, system: &System<'_, Ratio>, node: u32, meter: &mut Meter<'_>) -> Result<()> {
        let (first, k) = (self.choices.len(), system.quantity.level());
        for choice in self.graph.choices(node).filter(|&choice| system.permits(choice)) {
            let mut improving = Ratio::zero();
            for edge in self.graph.edges(choice) {
                self.game.choices.to.push(self.entered(edge, k));
                self.game.weights.push(2 * edge.probability());
                if system.bonus(edge) {
                    improving += &self.graph.fractions()[edge.probability() as usize];
                }
            }
            meter.take(10 * self.graph.edges(choice).count() + 12)?;
            self.game.choices.start.push(self.game.choices.to.len() as u32);
            let earned = system.cost(choice).unwrap_or_else(|| self.rewards.fractions.number(improving));
            self.rewards.of_choice.push(earned);
            self.choices.push(choice);
        }
        if self.choices.len() == first {
            self.rest(FAILED);
        }
        self.game.choices.first.push(self.choices.len() as u32);
        Ok(())
    }

    /// Returns the state that an edge enters from a level.
    fn entered(&self, edge: Edge, k: u32) -> u32 {
        if edge.to == LOST {
            return FAILED;
        }
        let is_number = self.quantity == Quantity::Number;
        let left = if is_number { 1 } else { k - u32::from(edge.counts()) };
        if left == 0 {
            return MADE;
        }
        match self.state(edge.to, left) {
            NONE if !is_number && self.graph.rank(edge.to).sure >= left => MADE,
            NONE => FAILED,
            state => state,
        }
    }

    /// Returns the state of a node at a level, or [`NONE`].
    fn state(&self, node: u32, k: u32) -> u32 {
        self.states[(k as usize - 1) * self.graph.nodes() + node as usize]
    }

    /// Solves the game. Fractions take the place of bounds that are too wide.
    ///
    /// # Errors
    /// A limit is reached before anything is known.
    fn solve<E: Entry>(&self, quantity: Quantity, meter: &mut Meter<'_>) -> Result<Led<E::Read>> {
        let game = &self.game;
        let (left, mut target) = (BitVec::repeat(true, game.states()), BitVec::repeat(false, game.states()));
        target.set(MADE as usize, true);
        let (collected, ours) = match quantity {
            Quantity::Probability(_) => (Collected::Target, Optimum::Max),
            Quantity::Number => (Collected::Always(&self.rewards), Optimum::Max),
            _ => (Collected::Until(&self.rewards), Optimum::Min),
        };
        let goal = Goal::against(ours);
        let reaching = Reaching { game, target: &target, left: &left, collected, goal };
        let mut found = reaching.led::<E>(meter)?;
        let is_wide = |value: &E::Read| {
            let bounds = value.bounds();
            bounds.width() > PRECISION * bounds.lower.max(1.0)
        };
        if !E::EXACT && found.values.end.is_ok() && found.values.values.iter().flatten().any(is_wide) {
            match reaching.led::<Ratio>(meter) {
                Ok(Led { values, choices }) => {
                    found.values.values = values.values.iter().map(|x| x.as_ref().map(Number::of)).collect();
                    found.choices = choices;
                }
                Err(error) => found.values.end = Err(error),
            }
        }
        Ok(found)
    }

    /// Stores the values of a level, with the choices of both sides that attain them.
    fn store<N: Number>(&self, system: &System<'_, N>, found: &Led<N>, solution: &mut Solution<N>) {
        let k = system.quantity.level();
        let open = || (0..self.graph.nodes() as u32).filter(|&node| system.is_open(node));
        for node in open() {
            if let Some(value) = &found.values.values[self.state(node, k) as usize] {
                solution.set(node, value.clone());
            }
        }
        for node in open() {
            let pick = match self.graph.is_theirs(node) {
                true => worst(system, node, solution),
                false => {
                    let mut own = self.game.choices.of(self.state(node, k));
                    own.find(|&choice| found.choices[choice]).map(|choice| self.choices[choice])
                }
            };
            solution.set_pick(node, pick.unwrap_or(NONE));
        }
    }
}

/// Returns the choice that is worst for us.
fn worst<N: Number>(system: &System<'_, N>, node: u32, solution: &Solution<N>) -> Option<u32> {
    let values =
        system.graph.choices(node).filter_map(|choice| Some((system.value(choice, solution)?, choice)));
    let is_worse = |a: &N, b: &N| match system.sense() {
        Sense::Max => b.low().exceeds(&a.low()),
        Sense::Min => a.high().exceeds(&b.high()),
    };
    let worst = values.reduce(|worst, other| if is_worse(&other.0, &worst.0) { other } else { worst });
    worst.map(|(_, choice)| choice)
}
