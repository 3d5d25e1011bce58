//! The values of a certificate: bounds that one step confirms.

use crate::values::Values;
use meliora_base::bound::Bound;
use meliora_base::error::{Limit, Result};
use meliora_base::interval::Interval;
use meliora_dump::bounds::{Bounds, Row};
use meliora_engine::Engine;
pub use meliora_equations::Confirmed;
use meliora_equations::{Inductive, Meter};

impl Values {
    /// Widens the bounds where one step does not confirm them. `shows_ones` says that the levels do not show where
    /// probabilities are 1. To be called after [`Values::solve`]. Cost: that of [`Values::solve`], and
    /// one exact step per choice and bound.
    ///
    /// # Errors
    /// A limit is reached; the values were computed as fractions.
    pub fn confirmed<E: Engine>(&self, engine: &E, shows_ones: bool) -> Result<Confirmed> {
        let mut meter = Meter::new(engine);
        meter.take(self.graph.bytes() + self.places.bytes())?;
        self.found.confirmed(&self.graph, shows_ones, &mut meter)
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
            let unclear = |(k, p): (u32, &Bounds)| rank.sure < k && p.upper == Bound::Double(1.0);
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

/// Returns the greatest width of bounds: absolute for probabilities, relative above 1 for costs.
pub fn widest(rows: &[Row]) -> f64 {
    let width = |bounds: &Bounds| {
        let [lower, upper] = [&bounds.lower, &bounds.upper].map(|x| x.around().upper);
        if upper.is_infinite() { f64::INFINITY } else { Interval { lower, upper }.relative_width() }
    };
    let all = rows.iter().flat_map(|row| row.probabilities.iter().chain(row.costs.iter().flatten()));
    all.map(width).fold(0.0, f64::max)
}
