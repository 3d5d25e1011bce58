//! The values of all states of a part of an arena, from the solution of its equations.

use super::solve::solved;
use crate::equations::graph::{Graph, LOST};
use crate::equations::meter::Meter;
use crate::equations::number::{Interval, Number};
use crate::equations::part::Part;
use crate::equations::system::Quantity;
use meliora_base::error::Result;

/// The values of all states; infinite ones have none.
pub(crate) struct Vector<N> {
    pub(crate) values: Vec<Option<N>>,
    /// An error if a limit was reached, after which bounds may be wide.
    pub(crate) end: Result<()>,
}

impl Part<'_> {
    /// Returns the values of all states, for a part with one exit.
    ///
    /// # Errors
    /// A limit is reached before anything is known.
    pub(crate) fn values<N: Number>(&self, quantity: Quantity, meter: &mut Meter<'_>) -> Result<Vector<N>> {
        values_at(&self.graph(meter)?, &self.nodes, quantity, meter)
    }
}

/// Returns the values of some nodes of a graph whose first node is the end of paths.
pub(crate) fn values_at<N: Number>(
    graph: &Graph,
    nodes: &[u32],
    quantity: Quantity,
    meter: &mut Meter<'_>,
) -> Result<Vector<N>> {
    let (solution, end) = solved::<N>(graph, quantity, None, meter)?;
    let end = if N::EXACT { Ok(end?) } else { end };
    let is_reward = !matches!(quantity, Quantity::Probability(_));
    let most = if is_reward { f64::INFINITY } else { 1.0 };
    let value = |&node: &u32| match node {
        0 => Some(if is_reward { N::zero() } else { N::one() }),
        LOST if is_reward => None,
        LOST => Some(N::zero()),
        node => solution.get(node).cloned().or_else(|| N::rounded(Interval { lower: 0.0, upper: most })),
    };
    Ok(Vector { values: nodes.iter().map(value).collect(), end })
}
