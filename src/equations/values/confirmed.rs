//! Bounds of all levels of a graph that one step confirms.

use bitvec::vec::BitVec;
use meliora_base::error::{Error, Result};
use meliora_base::interval::Interval;

use crate::graphs::game_graph::opposite;
use crate::graphs::graph::{Graph, NONE};
use crate::graphs::meter::Meter;
use crate::solvers::inductive::{Inductive, Side, Wanted};
use crate::solvers::solution::Solution;
use crate::solvers::solved::Solved;
use crate::solvers::system::{Fixed, Quantity};

/// Bounds of P_k and C_k that one step confirms.
#[derive(Debug)]
pub struct Confirmed {
    /// The lower and upper bounds of P_1, P_2, …
    pub probabilities: Vec<[Inductive; 2]>,
    /// The lower and upper bounds of C_1, C_2, …
    pub costs: Vec<[Inductive; 2]>,
}

/// Widens the bounds of P_k and C_k where one step does not confirm them. Cost: that of the solver, and one exact step per
/// choice and bound.
///
/// # Errors
/// A limit is reached.
pub(crate) fn confirmed(
    solved: &Solved<Interval>,
    graph: &Graph,
    shows_ones: bool,
    meter: &mut Meter<'_>,
) -> Result<Confirmed> {
    let mut all = |quantity: fn(u32) -> Quantity, solutions: &[Solution<Interval>]| {
        let mut found: Vec<[Inductive; 2]> = Vec::new();
        for (k, solution) in (1..).zip(solutions) {
            let mut side = |side: Side| {
                let below =
                    found.last().map(|[lower, upper]| if side == Side::Lower { lower } else { upper });
                let (quantity, fractions) = (quantity(k), &*solved.fractions);
                let fixed = fixed(graph, (quantity, side), solution, meter)?;
                let fixed = fixed.as_ref();
                let wanted = Wanted { graph, quantity, side, below, fractions, shows_ones, fixed };
                let found = wanted.find(meter);
                meter.release(fixed.map_or(0, |fixed| fixed.choices.len() / 8));
                found
            };
            let pair = [side(Side::Lower)?, side(Side::Upper)?];
            found.push(pair);
        }
        Ok::<_, Error>(found)
    };
    let [probability, cost] = solved.by_level();
    Ok(Confirmed {
        probabilities: all(Quantity::Probability, probability)?,
        costs: all(Quantity::Cost, cost)?,
    })
}

/// Fixes the choices of one side of a game to those that attain its values: ours for the bounds that need ranks, else the
/// opponent's. Returns `None` without an opponent.
fn fixed(
    graph: &Graph,
    (quantity, side): (Quantity, Side),
    solution: &Solution<Interval>,
    meter: &mut Meter<'_>,
) -> Result<Option<Fixed>> {
    if graph.theirs.is_none() {
        return Ok(None);
    }
    meter.take(graph.choices_in_all() / 8)?;
    let is_ours = side == Side::ranked(quantity);
    let mut choices = BitVec::repeat(true, graph.choices_in_all());
    for node in (0..graph.nodes() as u32).filter(|&node| graph.is_theirs(node) != is_ours) {
        let pick = solution.pick(node);
        if pick != NONE {
            graph.choices(node).for_each(|choice| choices.set(choice as usize, choice == pick));
        }
    }
    let leader = quantity.leader();
    Ok(Some(Fixed { choices, optimum: if is_ours { opposite(leader) } else { leader } }))
}
