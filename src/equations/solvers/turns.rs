//! The methods for a component, in turns.
//!
//! Nobody knows beforehand whether value iteration settles soon or elimination fills in little. So both take turns with
//! budgets that double, counted in the entries of rows that are read or written. Each continues from where it was, so
//! that the work is at most a fixed multiple of that of the faster one. While elimination may succeed, iteration gives up a
//! turn that its changes shrink too slowly for. Fractions come in where elimination shows that doubles have too few digits.

use crate::graphs::meter::{Meter, Stop};
use crate::solvers::groups::Groups;
use crate::solvers::iterate::Iteration;
use crate::solvers::policies::{Policies, ROUNDS};
use crate::solvers::rows::{GroupBounds, Rows};
use crate::solvers::solution::Solution;
use crate::solvers::system::{Method, Quantity, System};
use meliora_base::error::{Error, Limit, Result};
use meliora_base::number::Number;

/// The number of groups up to which elimination has the first turn: it has narrower bounds. Of more groups, it needs
/// much more memory than iteration.
const SMALL: usize = 1000;

impl<N: Number> System<'_, N> {
    /// Returns bounds of the groups, and an error if a limit was reached. They are narrow, except if a limit was reached or
    /// no method finds narrow ones.
    pub(crate) fn in_turns(
        &self,
        groups: &Groups<'_>,
        rows: &Rows<f64>,
        solution: &Solution<N>,
        meter: &mut Meter<'_>,
    ) -> (GroupBounds, Result<()>) {
        let top = matches!(self.quantity, Quantity::Probability(_)).then_some(1.0);
        let (mut iteration, mut policies) = (Iteration::new(rows, top), Policies::new(rows));
        let (mut wide, mut is_hard, mut was_hard) = (None, false, false);
        let mut left = match self.only {
            Some(method) => vec![method],
            None if rows.groups() <= SMALL => vec![Method::Eliminate, Method::Iterate],
            None => vec![Method::Iterate, Method::Eliminate],
        };
        let mut budget = ROUNDS * rows.entries();
        while !left.is_empty() {
            for method in std::mem::take(&mut left) {
                let end = match method {
                    Method::Iterate => iteration.turn(budget, !is_hard, meter).map(|()| iteration.found()),
                    Method::Eliminate => policies.bounds(&iteration.picks(), budget, meter),
                    Method::Exact => {
                        let found = self.fractions_of(groups, solution, &policies.picks(), budget, meter);
                        found.map(GroupBounds::rounded)
                    }
                };
                let is_done =
                    |found: &GroupBounds| method == Method::Exact || rows.is_narrow(&found.low, &found.high);
                match end {
                    Ok(found) if is_done(&found) => return (found, Ok(())),
                    Err(Stop::Later) => left.push(method),
                    // Iteration needs no more memory.
                    Err(Stop::Limit(Error::Limit(Limit::Memory { .. }))) => {}
                    Err(Stop::Limit(error)) => return (iteration.found().and(wide), Err(error)),
                    Ok(_) | Err(Stop::Never) if method == Method::Eliminate => {
                        (wide, is_hard) = (end.ok(), true);
                        left.push(Method::Exact);
                    }
                    Ok(_) | Err(Stop::Never) => {}
                }
            }
            // What elimination does not find, iteration may approach without an end, and large fractions take long.
            if is_hard && left == [Method::Iterate] || was_hard && rows.groups() > SMALL {
                break;
            }
            was_hard = is_hard;
            budget = budget.saturating_mul(2);
        }
        (iteration.found().and(wide), Ok(()))
    }
}
