//! The values of a certificate: bounds that one step confirms.

use crate::answers::values::{Numbers, Values};
use crate::equations::game_graph::opposite;
use crate::equations::graph::{Graph, NONE};
use crate::equations::meter::Meter;
use crate::equations::solution::Solution;
use crate::equations::system::{Fixed, Quantity};
use crate::solvers::inductive::{Inductive, Side, Wanted};
use bitvec::vec::BitVec;
use meliora_base::error::{Error, Limit, Result};
use meliora_base::interval::Interval;
use meliora_dump::bounds::{Bounds, Number, Row};
use meliora_engine::Engine;

/// Bounds of P_k and C_k that one step confirms; see `docs/dumps.md`.
#[derive(Debug)]
pub struct Confirmed {
    /// The lower and upper bounds of P_1, P_2, …
    probabilities: Vec<[Inductive; 2]>,
    /// The lower and upper bounds of C_1, C_2, …
    costs: Vec<[Inductive; 2]>,
}

impl Values {
    /// Widens the bounds where one step does not confirm them. `shows_ones` says that the levels do not show where
    /// probabilities are 1. To be called after [`Values::solve`]. Cost: that of [`Values::solve`], and
    /// one exact step per choice and bound.
    ///
    /// # Errors
    /// A limit is reached; the values were computed as fractions.
    pub fn confirmed<E: Engine>(&self, engine: &E, shows_ones: bool) -> Result<Confirmed> {
        let Numbers::Rounded(solved) = &self.numbers else {
            return Err(Error::Usage("certificates need bounds, not exact values".to_owned()));
        };
        let mut meter = Meter::new(engine);
        meter.take(self.graph.bytes() + self.places.bytes())?;
        let all = |quantity: fn(u32) -> Quantity, solutions: &[Solution<Interval>], meter: &mut Meter<'_>| {
            let mut found: Vec<[Inductive; 2]> = Vec::new();
            for (k, solution) in (1..).zip(solutions) {
                let mut side = |side: Side| {
                    let below =
                        found.last().map(|[lower, upper]| if side == Side::Lower { lower } else { upper });
                    let fractions = &solved.fractions;
                    let quantity = quantity(k);
                    let graph = &self.graph;
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
        let probabilities = all(Quantity::Probability, probability, &mut meter)?;
        let costs = all(Quantity::Cost, cost, &mut meter)?;
        Ok(Confirmed { probabilities, costs })
    }

    /// Returns the rows of the states from which an improvement is possible, in their own arenas and
    /// in those that they reach. `arena` names an arena by its position.
    ///
    /// # Errors
    /// A bound below 1 was not found for a probability below 1, where the levels do not show it.
    pub fn rows(
        &self,
        confirmed: &Confirmed,
        shows_ones: bool,
        arena: &dyn Fn(usize) -> String,
    ) -> Result<Vec<Row>> {
        let mut rows = Vec::new();
        for node in 0..self.graph.nodes() {
            let rank = self.graph.rank(node as u32);
            let Some(number) = self.places.arena(node as u32) else { continue };
            if self.graph.is_junction(node as u32) || rank.positive == 0 {
                continue;
            }
            let bounds = |[lower, upper]: &[Inductive; 2], ranked: usize| Bounds {
                lower: lower.bounds[node].clone(),
                upper: upper.bounds[node].clone(),
                rank: [lower, upper][ranked].ranks[node],
            };
            let mut row = Row {
                arena: arena(number as usize),
                state: self.places.state(node as u32),
                probabilities: confirmed.probabilities.iter().map(|pair| bounds(pair, 0)).collect(),
                costs: Vec::with_capacity(confirmed.costs.len()),
            };
            for (k, pair) in (1..).zip(&confirmed.costs) {
                row.costs.push((rank.sure >= k).then(|| bounds(pair, 1)));
            }
            let unclear = |(k, p): (u32, &Bounds)| rank.sure < k && p.upper == Number::Double(1.0);
            if shows_ones && (1..).zip(&row.probabilities).any(unclear) {
                let what =
                    "no bound below 1 was found for a probability below 1, which the mode `transition` needs";
                return Err(Limit::Size { what: what.to_owned() }.into());
            }
            rows.push(row);
        }
        Ok(rows)
    }
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

/// Returns the greatest width of bounds: absolute for probabilities, relative above 1 for costs.
pub fn widest(rows: &[Row]) -> f64 {
    let width = |bounds: &Bounds| {
        let [lower, upper] = [&bounds.lower, &bounds.upper].map(|x| x.around().upper);
        if upper.is_infinite() { f64::INFINITY } else { Interval { lower, upper }.relative_width() }
    };
    let all = rows.iter().flat_map(|row| row.probabilities.iter().chain(row.costs.iter().flatten()));
    all.map(width).fold(0.0, f64::max)
}
