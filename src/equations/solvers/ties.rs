//! Ties between choices that attain P_k or C_k: the least expected number of steps decides.
//!
//! Let T_k(s) be the expected number of steps until the k-th improvement, or until fewer than k are
//! possible. Bounds of values do not tell which choices attain them exactly. A *candidate* is a choice
//! that may attain the value, as far as the bounds tell. It loses at most d: Σ p · L(s') ≥ L(s) - d for the
//! lower bounds L of P_k, and cost + Σ p · U(s') ≤ U(s) + d for the upper bounds U of C_k. T_k is minimised
//! over the candidates.
//!
//! The strategy that attains T_k makes k improvements with a probability of at least L(s) - d · T_k(s): up to
//! step n, L of the present state plus n · d does not fall in the mean, and L ends at 1 or 0. So the strategy
//! attains P_k up to the precision if L(s) - d · T_k(s) is close enough to the upper bound. For costs, the same
//! holds with U(s) + d · T_k(s). If the strategy is too far away, only candidates that lose less are taken, and
//! in the end the choices of the solver, which attain the bounds themselves.

use bitvec::vec::BitVec;
use num_traits::{One, Zero};

use crate::graphs::graph::{Graph, NONE};
use crate::graphs::meter::Meter;
use crate::solvers::solution::Solution;
use crate::solvers::system::{Candidates, Quantity, System};
use meliora_base::error::Result;
use meliora_base::interval::{Interval, PRECISION};
use meliora_base::number::{Number, Weight};

/// Attempts with candidates that lose less.
const ATTEMPTS: usize = 3;

/// The choices that attain the values in the least expected number of steps.
#[derive(Debug)]
pub(crate) struct Ties {
    /// T_1, T_2, …
    steps: Vec<Solution<Interval>>,
    /// The most that a step loses of a probability, and of a cost, at each level and those below.
    losses: Vec<[f64; 2]>,
}

impl Ties {
    /// Returns the choice that a node takes at level `index` + 1, or [`NONE`].
    pub(crate) fn pick(&self, node: u32, index: usize) -> u32 {
        self.steps.get(index).map_or(NONE, |steps| steps.pick(node))
    }

    /// Returns the most that the strategy loses of P_k, and of C_k, at level `index` + 1.
    pub(crate) fn loss(&self, node: u32, index: usize) -> [f64; 2] {
        let steps =
            self.steps.get(index).and_then(|steps| steps.get(node)).map_or(Interval::ZERO, Number::high);
        let losses = self.losses.get(index).copied().unwrap_or_default();
        losses.map(|loss| Interval::point(loss).times(&steps).upper)
    }
}

/// The solutions of a graph of which ties are to be decided.
pub(crate) struct Solutions<'a> {
    pub(crate) graph: &'a Graph,
    pub(crate) fractions: &'a [Interval],
    /// The numbers of the costs 0 and 1 among the fractions.
    pub(crate) costs: [u32; 2],
    /// P_1, P_2, …
    pub(crate) probability: &'a [Solution<Interval>],
    /// C_1, C_2, …; empty if no improvement is certain.
    pub(crate) cost: &'a [Solution<Interval>],
}

/// Returns the numbers of the costs 0 and 1 among the fractions of a graph.
pub(crate) fn costs(graph: &mut Graph) -> [u32; 2] {
    [graph.fraction(Zero::zero()), graph.fraction(One::one())]
}

impl Solutions<'_> {
    /// Decides the ties of all levels; `None` if there are none, or if they cannot be told from losses.
    /// Cost: at most that of costs with [`Solved::run`](crate::solvers::solved::Solved::run), for each attempt.
    ///
    /// # Errors
    /// A limit is reached.
    pub(crate) fn decide(&self, meter: &mut Meter<'_>) -> Result<Option<Ties>> {
        let before = meter.bytes();
        let mut most = f64::INFINITY;
        for _ in 0..ATTEMPTS {
            let Some(ties) = self.attempt(most, meter)? else { break };
            match self.next_loss(&ties) {
                None => return Ok(Some(ties)),
                Some(less) if less < most => most = less,
                Some(_) => break,
            }
        }
        meter.release_to(before);
        Ok(None)
    }

    /// Minimises the numbers of steps over the candidates that lose at most `most` per step; `None` if no node has
    /// two of them, or if the solver's choice is not known somewhere.
    fn attempt(&self, most: f64, meter: &mut Meter<'_>) -> Result<Option<Ties>> {
        let levels = 1..=self.probability.len() as u32;
        let mut found = Vec::new();
        for k in levels.clone() {
            let Some(level) = self.candidates(k, most, meter)? else { return Ok(None) };
            found.push(level);
        }
        if found.iter().all(|level| !level.is_open) {
            return Ok(None);
        }
        let mut ties = Ties { steps: Vec::new(), losses: Vec::new() };
        let mut losses = [0.0; 2];
        for (k, level) in levels.zip(&found) {
            let below = ties.steps.last();
            let system = System::new(self.graph, Quantity::Steps(k), below, self.fractions);
            let system = System { candidates: Some(&level.candidates), ..system };
            let mut steps = system.start(meter)?;
            system.solve(&mut steps, meter)?;
            // A step enters at most one junction.
            let both = |[step, junction]: [f64; 2]| Interval::point(step).plus(&Interval::point(junction));
            let own = level.losses.map(|losses| both(losses).upper);
            losses = [f64::max(losses[0], own[0]), f64::max(losses[1], own[1])];
            ties.steps.push(steps);
            ties.losses.push(losses);
        }
        Ok(Some(ties))
    }

    /// Returns `None` if all values are attained up to the precision; else a smaller loss per step, with which
    /// they may be.
    fn next_loss(&self, ties: &Ties) -> Option<f64> {
        let (mut fails, mut less) = (false, f64::INFINITY);
        for (index, k) in (0..self.probability.len()).zip(1u32..) {
            for node in (0..self.graph.nodes() as u32).filter(|&node| self.graph.rank(node).positive >= k) {
                let is_sure = self.graph.rank(node).sure >= k;
                let solutions = if is_sure { self.cost } else { self.probability };
                let Some(value) = solutions.get(index).and_then(|solution| solution.get(node)) else {
                    continue;
                };
                let spare = PRECISION * value.lower.max(1.0) - value.width();
                let steps = ties.steps[index].get(node).map_or(f64::INFINITY, |steps| steps.upper);
                let unknown = steps.is_infinite() || ties.pick(node, index) == NONE;
                fails |= unknown || spare < ties.loss(node, index)[usize::from(is_sure)];
                less = less.min(spare / (2.0 * steps));
            }
        }
        fails.then_some(less)
    }

    /// Returns the candidates of level k that lose at most `most`; `None` if the solver's choice of some node is
    /// not known.
    fn candidates(&self, k: u32, most: f64, meter: &mut Meter<'_>) -> Result<Option<Level>> {
        let (graph, all) = (self.graph, self.graph.choices_in_all());
        meter.take(all / 4)?;
        let [choices, free] = [(); 2].map(|()| BitVec::repeat(false, all));
        let candidates = Candidates { choices, free, costs: self.costs };
        let mut level = Level { candidates, losses: [[0.0; 2]; 2], is_open: false };
        let steps = self.costs_are_steps();
        for node in (0..graph.nodes() as u32).filter(|&node| graph.rank(node).positive >= k) {
            meter.step()?;
            let (is_sure, junction) = (graph.rank(node).sure >= k, graph.is_junction(node));
            let of = if is_sure { Of::Cost } else { Of::Probability };
            let Some(tied) = self.tied(of, k) else { return Ok(None) };
            let pick = tied.solution.pick(node);
            if pick == NONE {
                return Ok(None);
            }
            let mut count = 0;
            for choice in graph.choices(node) {
                let loss = tied.loss(node, choice);
                let is_candidate = !(is_sure && steps) && loss.is_some_and(|loss| loss <= most);
                if choice == pick || is_candidate {
                    count += 1;
                    level.candidates.choices.set(choice as usize, true);
                    let greatest = &mut level.losses[usize::from(is_sure)][usize::from(junction)];
                    *greatest = greatest.max(loss.unwrap_or(f64::INFINITY));
                }
                level.candidates.free.set(choice as usize, junction);
            }
            level.is_open |= count > 1;
        }
        Ok(Some(level))
    }

    /// Returns whether every step has the same positive cost, so that the least costs need the fewest steps.
    fn costs_are_steps(&self) -> bool {
        let nodes = (0..self.graph.nodes() as u32).filter(|&node| !self.graph.is_junction(node));
        let mut costs = nodes.flat_map(|node| self.graph.choices(node)).map(|choice| self.graph.cost(choice));
        let Some(first) = costs.next() else { return true };
        first != self.costs[0] && costs.all(|cost| cost == first)
    }

    fn tied(&self, of: Of, k: u32) -> Option<Tied<'_>> {
        let (solutions, quantity) = match of {
            Of::Probability => (self.probability, Quantity::Probability(k)),
            Of::Cost => (self.cost, Quantity::Cost(k)),
        };
        let index = k as usize - 1;
        let below = index.checked_sub(1).and_then(|below| solutions.get(below));
        let system = System::new(self.graph, quantity, below, self.fractions);
        Some(Tied { system, solution: solutions.get(index)? })
    }
}

/// Returns an upper bound of the amount by which a number exceeds another one.
fn excess(a: f64, b: f64) -> f64 {
    if a <= b { 0.0 } else { (a - b).next_up() }
}

/// The value that choices attain.
enum Of {
    Probability,
    Cost,
}

/// The candidates of a level.
struct Level {
    candidates: Candidates,
    /// The most that a choice loses of a probability, and of a cost: first of those that take a step, then of
    /// those of junctions.
    losses: [[f64; 2]; 2],
    /// True if some node has two of them.
    is_open: bool,
}

/// A quantity with its solution.
struct Tied<'a> {
    system: System<'a, Interval>,
    solution: &'a Solution<Interval>,
}

impl Tied<'_> {
    /// Returns the most that a choice loses; `None` if it certainly does not attain the value.
    fn loss(&self, node: u32, choice: u32) -> Option<f64> {
        let (own, value) = (self.solution.get(node)?, self.system.value(choice, self.solution)?);
        match self.system.quantity {
            Quantity::Cost(_) if value.exceeds(own) => None,
            Quantity::Cost(_) => Some(excess(value.upper, own.upper)),
            _ if own.exceeds(&value) => None,
            _ => Some(excess(own.lower, value.lower)),
        }
    }
}
