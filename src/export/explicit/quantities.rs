//! The bounds of quantities in the states of a graph.

use super::graph::Graph;
use crate::bounds::Wanted;
use meliora_quantities::{Bounds, Values};

/// A quantity with its bounds in each state.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    /// The name: `p_1`, `c_1`, …, `n`.
    pub name: String,
    /// Its meaning in words.
    pub description: String,
    /// The lower and the upper bound of each state. Both are infinite where the value is.
    pub bounds: Vec<[f64; 2]>,
}

/// The quantities of a graph.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantities {
    /// The greatest number of improvements.
    pub levels: usize,
    /// The name of the cost of a step.
    pub reward: String,
    /// P_1, C_1, P_2, C_2, …, N.
    pub list: Vec<Quantity>,
}

impl Quantities {
    /// Collects P_k, C_k and N of a graph's states, each in the arena in which planning starts there. A
    /// cost is infinite where the improvements are not certain; without `values` of a state, no
    /// improvement is possible from it.
    pub fn of(graph: &Graph, values: &Values, wanted: &Wanted<'_>) -> Self {
        let (levels, reward) = (wanted.levels, wanted.reward.to_owned());
        let pair = |b: Bounds| [b.interval.lower, b.interval.upper];
        let none = [f64::INFINITY; 2];
        let nodes: Vec<_> = graph.states.iter().map(|state| values.start(state)).collect();
        let mut list = Vec::with_capacity(2 * levels + 1);
        let mut add =
            |name: String, description: String, bounds| list.push(Quantity { name, description, bounds });
        for k in 1..=levels {
            let p = nodes.iter().map(|n| n.map_or([0.0; 2], |n| pair(values.probability(n, k))));
            add(format!("p_{k}"), format!("greatest probability of {k} improvements"), p.collect());
            let c = nodes.iter().map(|n| n.and_then(|n| values.cost(n, k)).map_or(none, pair));
            let what = format!("least expected cost ({reward}) until improvement {k}, where it is certain");
            add(format!("c_{k}"), what, c.collect());
        }
        let n = nodes.iter().map(|n| n.map_or([0.0; 2], |n| pair(values.number(n))));
        add("n".to_owned(), "largest expected number of improvements".to_owned(), n.collect());
        Quantities { levels, reward, list }
    }

    /// Returns the greatest width of bounds: absolute up to 1, relative above.
    pub fn widest(&self) -> f64 {
        let width = |[lower, upper]: &[f64; 2]| {
            if lower == upper { 0.0 } else { (upper - lower) / lower.max(1.0) }
        };
        self.list.iter().flat_map(|q| &q.bounds).map(width).fold(0.0, f64::max)
    }
}
