//! The methods for a component, in turns.
//!
//! Nobody knows beforehand whether value iteration settles soon or elimination fills in little. So both take turns with
//! budgets that double, counted in the entries of rows that are read or written. Each continues from where it was, so
//! that the work is at most a fixed multiple of that of the faster one. Fractions come in where elimination shows that
//! doubles have too few digits.

use crate::equations::meter::{Meter, Stop, Turn};
use crate::equations::system::Method;
use crate::solvers::doubles::{Elimination, ROUNDS};
use crate::solvers::iterate::Iteration;
use crate::solvers::sparse::{Found, Sparse};
use meliora_base::error::{Error, Limit, Result};

/// The number of groups up to which elimination has the first turn: it has narrower bounds. Of more groups, it needs
/// much more memory than iteration.
const SMALL: usize = 1000;

/// Returns bounds of the groups, which are at most `top` if it is given, and an error if a limit was reached. They are
/// narrow, except if a limit was reached or no method finds narrow ones. `exactly` solves the component with fractions
/// within a budget, from a policy on. `only` names the method to use, for tests.
pub(crate) fn solve(
    sparse: &Sparse,
    top: Option<f64>,
    only: Option<Method>,
    exactly: impl FnMut(&[u32], usize, &mut Meter<'_>) -> Turn<Found>,
    meter: &mut Meter<'_>,
) -> (Found, Result<()>) {
    if let Some(([low, high], action)) = sparse.alone() {
        let found = Found { low: vec![low], high: vec![high], picks: vec![sparse.choices[action]] };
        return (found, Ok(()));
    }
    let before = meter.bytes();
    let found = in_turns(sparse, top, only, exactly, meter);
    meter.release_to(before);
    found
}

fn in_turns(
    sparse: &Sparse,
    top: Option<f64>,
    only: Option<Method>,
    mut exactly: impl FnMut(&[u32], usize, &mut Meter<'_>) -> Turn<Found>,
    meter: &mut Meter<'_>,
) -> (Found, Result<()>) {
    let (mut iteration, mut elimination) = (Iteration::new(sparse, top), Elimination::new(sparse));
    let (mut known, mut is_hard, mut was_hard) = (Found::nothing(sparse.groups()), false, false);
    let mut left = match only {
        Some(method) => vec![method],
        None if sparse.groups() <= SMALL => vec![Method::Eliminate, Method::Iterate],
        None => vec![Method::Iterate, Method::Eliminate],
    };
    let mut budget = ROUNDS * sparse.entries();
    while !left.is_empty() {
        for method in std::mem::take(&mut left) {
            let end = match method {
                Method::Iterate => iteration.turn(budget, meter).map(|()| iteration.found()),
                Method::Eliminate => elimination.turn(iteration.policy(), budget, meter),
                Method::Exact => exactly(&elimination.picks(), budget, meter),
            };
            let is_done =
                |found: &Found| method == Method::Exact || sparse.is_narrow(&found.low, &found.high);
            match end {
                Ok(found) if is_done(&found) => return (found, Ok(())),
                Err(Stop::Later) => left.push(method),
                // Iteration needs no more memory.
                Err(Stop::Limit(Error::Limit(Limit::Memory { .. }))) => {}
                Err(Stop::Limit(error)) => {
                    known.narrow(&iteration.found());
                    return (known, Err(error));
                }
                Ok(_) | Err(Stop::Never) if method == Method::Eliminate => {
                    end.iter().for_each(|wide| known.narrow(wide));
                    is_hard = true;
                    left.push(Method::Exact);
                }
                Ok(_) | Err(Stop::Never) => {}
            }
        }
        // What elimination does not find, iteration may approach without an end, and large fractions take long.
        if is_hard && left == [Method::Iterate] || was_hard && sparse.groups() > SMALL {
            break;
        }
        was_hard = is_hard;
        budget *= 2;
    }
    known.narrow(&iteration.found());
    (known, Ok(()))
}
