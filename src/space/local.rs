//! The parts of guards over few valuations. Their results are the same in all states with the same values of some
//! variables, so a participant's commands are tested once for these values.
//!
//! Thousands of guards such as `b>0 & (r=1 & c=2 | r=1 & c=5 | …)` differ in the values of few variables. For each
//! valuation of r and c, the commands are listed whose conditions over these variables are true. In a state, only the other
//! conditions of the listed commands are tested. S. Blom, J. van de Pol, and M. Weber, "LTSmin: distributed and symbolic
//! reachability" (CAV 2010), keep the transitions of a group for the values of its variables.

use std::ops::Range;

use ahash::AHashSet;
use smallvec::SmallVec;

use super::share::WORTH_SHARING;
use meliora_base::error::Result;
use meliora_base::progress::Poll;
use meliora_model::expr::{ExprId, ExprPool, Node};
use meliora_model::{Program, VarId};

/// The most valuations whose lists are kept for one participant.
const MOST: u64 = 1 << 16;

/// The most valuations whose lists are kept for all participants of a program: 4 MiB.
pub(crate) const MOST_IN_ALL: u64 = 16 * MOST;

/// A condition with its variables and the number of its operators.
struct Condition {
    variables: SmallVec<[VarId; 4]>,
    operators: u64,
}

impl Condition {
    fn new(pool: &ExprPool, e: ExprId, poll: &mut Poll<'_>) -> Result<Self> {
        let (mut seen, mut stack) = (AHashSet::new(), vec![e]);
        let mut condition = Condition { variables: SmallVec::new(), operators: 0 };
        while let Some(e) = stack.pop() {
            if !seen.insert(e) {
                continue;
            }
            poll.step()?;
            match pool.node(e) {
                Node::Var(v) => condition.variables.push(v),
                Node::Literal(_) => {}
                _ => condition.operators += 1,
            }
            stack.extend(pool.operands(e));
        }
        Ok(condition)
    }

    /// Returns whether it depends on no other variables.
    fn is_over(&self, variables: &[VarId]) -> bool {
        self.variables.iter().all(|v| variables.contains(v))
    }
}

/// Chooses the variables for whose values the true conditions of a participant are listed: those of the longest conditions
/// that have few valuations together. These are at most `most`, and at most the square of the number of operators: a list
/// takes some bytes, and saves operators in each state.
///
/// Returns the variables, and whether each condition depends on these only; `None` if too few of them do.
///
/// # Errors
/// The work is cancelled.
pub(crate) fn chosen(
    program: &Program,
    conditions: &[ExprId],
    most: u64,
    poll: &mut Poll<'_>,
) -> Result<Option<(Vec<VarId>, Vec<bool>)>> {
    let read = |&e: &ExprId| Condition::new(&program.pool, e, poll);
    let conditions: Vec<Condition> = conditions.iter().map(read).collect::<Result<_>>()?;
    let mut longest: Vec<&Condition> = conditions.iter().collect();
    longest.sort_by_key(|condition| std::cmp::Reverse(condition.operators));
    let mut variables: Vec<VarId> = Vec::new();
    for condition in longest {
        let mut all = variables.clone();
        all.extend(condition.variables.iter().filter(|v| !variables.contains(v)));
        if count(program, &all).is_some_and(|count| count <= MOST.min(most)) {
            variables = all;
        }
    }
    variables.sort_unstable();
    let local: Vec<bool> = conditions.iter().map(|condition| condition.is_over(&variables)).collect();
    let own = conditions.iter().zip(&local).filter(|(_, local)| **local);
    let operators: u64 = own.map(|(condition, _)| condition.operators).sum();
    let is_worth = operators > u64::from(4 * WORTH_SHARING)
        && count(program, &variables).is_some_and(|count| count <= operators.saturating_pow(2));
    Ok(is_worth.then_some((variables, local)))
}

/// Returns the number of valuations of some variables.
fn count(program: &Program, variables: &[VarId]) -> Option<u64> {
    let values = |v: &VarId| {
        let declared = program.variables.get(v.index())?;
        declared.high.abs_diff(declared.low).checked_add(1)
    };
    variables.iter().try_fold(1, |all: u64, v| all.checked_mul(values(v)?))
}

/// The candidates that are listed for each valuation so far.
#[derive(Default)]
pub(crate) struct Lists {
    /// For each valuation, the place of its list plus 1; 0 if there is none yet.
    places: Vec<u32>,
    /// The lists, each after its length.
    lists: Vec<u32>,
}

impl Lists {
    /// Returns the places of the list of a valuation.
    #[inline]
    pub(crate) fn of(&self, valuation: usize) -> Option<Range<usize>> {
        let place = self.places.get(valuation).copied().filter(|&place| place > 0)? as usize;
        Some(place..place + self.lists[place - 1] as usize)
    }

    /// Returns the candidate at a place.
    #[inline]
    pub(crate) fn candidate(&self, place: usize) -> u32 {
        self.lists[place]
    }

    /// Adds the list of one of `count` valuations, and returns its places.
    pub(crate) fn add(&mut self, valuation: usize, count: usize, list: &[u32]) -> Range<usize> {
        self.places.resize(count, 0);
        self.lists.push(list.len() as u32);
        let place = self.lists.len();
        self.places[valuation] = place as u32;
        self.lists.extend_from_slice(list);
        place..place + list.len()
    }
}
