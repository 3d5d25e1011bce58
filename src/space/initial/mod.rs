//! A search for the initial states that does not enumerate all valuations.
//!
//! A *box* gives each variable a range. A condition that may be true in some of its states splits it in two. So every
//! state is found once, and boxes without one are left out as a whole.

mod net;
#[cfg(test)]
mod tests;

use std::cmp::Reverse;
use std::sync::Arc;

use super::explore::PATIENCE;
use super::values::Values;
use meliora_base::error::{Limit, Result};
use meliora_base::progress::ProgressSink;
use meliora_model::expr::ExprId;
use meliora_model::{Program, State};
use net::{Net, Op};

/// A search for the states in which a condition is true, which can be interrupted and continued.
pub struct Search {
    /// The part of the condition that the box leaves open.
    net: Arc<Net>,
    /// The first and the last value of each variable.
    ranges: Vec<(i64, i64)>,
    /// The ranges that were halved, with their variables, oldest first.
    trail: Vec<(usize, (i64, i64))>,
    /// The boxes that wait.
    waiting: Vec<Waiting>,
    next: Next,
    /// The values of the items of the net.
    values: Vec<Values>,
    /// The number of looks at boxes and of states found.
    work: u64,
    /// The number of operations and states since the last check of the progress sink.
    steps: usize,
}

/// The second half of a box that was split.
struct Waiting {
    net: Arc<Net>,
    /// The length of the trail before the split.
    trail: usize,
    variable: usize,
    range: (i64, i64),
}

/// The next action of a search.
enum Next {
    /// It looks at a box.
    Box,
    /// It lists the states of a box, in all of which the condition is true; contains the next one.
    State(Vec<i64>),
    /// It goes back to the last box that waits.
    Back,
    Nothing,
}

/// The truth of a condition in a box.
enum Truth {
    /// It is true in none of the states, …
    Nowhere,
    /// … in all of them, …
    Everywhere,
    /// … or perhaps in some: the box is split by this variable.
    Perhaps(usize),
}

/// Returns the initial states of a program in their order, at most `limit`. Cost: like an exploration of as many states.
///
/// # Errors
/// There are more; the work is cancelled.
pub fn initial_states(program: &Program, limit: usize, sink: &dyn ProgressSink) -> Result<Vec<State>> {
    let (mut search, mut states) = (Search::new(program, program.initial, sink)?, Vec::new());
    search.run(u64::MAX, sink, &mut |state| {
        if states.len() == limit {
            return Err(Limit::Listed(limit as u64).into());
        }
        states.push(state.to_vec());
        Ok(())
    })?;
    states.sort_unstable();
    Ok(states)
}

impl Search {
    /// Creates a search for the states of a condition, such as that of the initial states.
    ///
    /// # Errors
    /// The work is cancelled.
    pub fn new(program: &Program, condition: ExprId, sink: &dyn ProgressSink) -> Result<Self> {
        Ok(Search {
            net: Arc::new(Net::new(program, condition, sink)?),
            ranges: program.variables.iter().map(|v| (v.low, v.high)).collect(),
            trail: Vec::new(),
            waiting: Vec::new(),
            next: Next::Box,
            values: Vec::new(),
            work: 0,
            steps: 0,
        })
    }

    /// Calls `found` with each state of the condition once, until all are found or the work is `most`.
    /// Returns true if all are found.
    ///
    /// A condition without a value counts as false. It matters only in states of the scope, where it is
    /// evaluated again.
    ///
    /// # Errors
    /// The work is cancelled, or `found` fails.
    pub fn run(
        &mut self,
        most: u64,
        sink: &dyn ProgressSink,
        found: &mut dyn FnMut(&[i64]) -> Result<()>,
    ) -> Result<bool> {
        while self.work < most {
            self.next = match std::mem::replace(&mut self.next, Next::Nothing) {
                Next::Box => match self.look() {
                    Truth::Nowhere => Next::Back,
                    Truth::Everywhere => Next::State(self.ranges.iter().map(|&(low, _)| low).collect()),
                    Truth::Perhaps(variable) => self.split(variable),
                },
                Next::State(state) => {
                    (self.work, self.steps) = (self.work + 1, self.steps + state.len());
                    found(&state)?;
                    self.after(state)
                }
                Next::Back => self.back(),
                Next::Nothing => return Ok(true),
            };
            self.poll(sink)?;
        }
        Ok(matches!(self.next, Next::Nothing))
    }

    fn poll(&mut self, sink: &dyn ProgressSink) -> Result<()> {
        if self.steps >= PATIENCE {
            sink.advance(std::mem::take(&mut self.steps) as u64);
            if let Some(limit) = sink.stop() {
                return Err(limit.into());
            }
        }
        Ok(())
    }

    /// Looks at a box, and decides what to do with it.
    fn look(&mut self) -> Truth {
        self.work += 1;
        self.evaluate();
        match self.values.last() {
            Some(values) if !values.may_hold() => return Truth::Nowhere,
            Some(values) if !values.is_known() => {}
            _ => return Truth::Everywhere,
        }
        let mut open = self.net.open(&self.values);
        // The net is copied only if it is halved, so that all copies together are small.
        if open.iter().filter(|open| **open).count() * 2 <= open.len() {
            self.net = Arc::new(self.net.reduced(&self.values, &open));
            self.evaluate();
            open = self.net.open(&self.values);
        }
        // The condition is known where all variables that decide it have one value.
        self.widest(&open).map_or(Truth::Nowhere, Truth::Perhaps)
    }

    fn evaluate(&mut self) {
        self.net.evaluate(&self.ranges, &mut self.values);
        self.steps += self.net.items.len();
    }

    /// Returns the variable with the most values, and more than one, of the open ones: if a narrow one were split to its
    /// end first, a part of the condition about a wide one would be tested late.
    fn widest(&self, open: &[bool]) -> Option<usize> {
        let items = self.net.items.iter().zip(open).filter(|(_, open)| **open);
        let variables = items.filter_map(|(item, _)| match item.op {
            Op::Var(v) if width(self.ranges[v]) > 0 => Some(v),
            _ => None,
        });
        variables.max_by_key(|&v| (width(self.ranges[v]), Reverse(v)))
    }

    /// Halves the range of a variable. The upper half waits.
    fn split(&mut self, variable: usize) -> Next {
        let (low, high) = self.ranges[variable];
        let middle = low.wrapping_add_unsigned(width((low, high)) / 2);
        let (net, trail) = (Arc::clone(&self.net), self.trail.len());
        self.waiting.push(Waiting { net, trail, variable, range: (middle + 1, high) });
        self.trail.push((variable, (low, high)));
        self.ranges[variable].1 = middle;
        Next::Box
    }

    /// Returns to the last box that waits.
    fn back(&mut self) -> Next {
        let Some(Waiting { net, trail, variable, range }) = self.waiting.pop() else { return Next::Nothing };
        for (variable, range) in self.trail.drain(trail..).rev() {
            self.ranges[variable] = range;
        }
        self.trail.push((variable, self.ranges[variable]));
        self.ranges[variable] = range;
        self.net = net;
        Next::Box
    }

    /// Returns the state of the box that follows another one, the last variable counting first.
    fn after(&self, mut state: Vec<i64>) -> Next {
        for (value, &(low, high)) in state.iter_mut().zip(&self.ranges).rev() {
            if *value < high {
                *value += 1;
                return Next::State(state);
            }
            *value = low;
        }
        Next::Back
    }
}

/// Returns the number of values of a range without one.
fn width((low, high): (i64, i64)) -> u64 {
    high.wrapping_sub(low) as u64
}
