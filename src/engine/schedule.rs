//! Several methods of one fixpoint in turns, with budgets that double.
//!
//! Nobody can predict which method is best for a model that he has not seen. So they take turns, counted in steps, until
//! one of them ends. Whole questions race instead; see `race`.

use meliora_base::error::Result;

/// The turns of several ways. The first one is the likeliest to be the best.
///
/// In each round the first way has a budget, and the others share as much; the budget of a round is twice that of the
/// round before. So the first way has the first budget alone, and half of all later work. Whichever way is the best, all of
/// them together take at most a fixed multiple of its work. A single way has no budget.
pub(crate) struct Schedule {
    ways: usize,
    /// The next way.
    next: usize,
    /// The budget of the round.
    budget: u64,
}

/// A turn of one way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Turn {
    /// The number of the way.
    pub(crate) way: usize,
    /// The most steps of this turn.
    pub(crate) steps: u64,
}

impl Schedule {
    /// Creates a schedule for a number of ways, at least 1, with the first budget.
    pub(crate) fn new(ways: usize, first: u64) -> Self {
        Schedule { ways, next: 0, budget: first.max(1) }
    }

    /// Takes turns until one of them has a result.
    ///
    /// # Errors
    /// The first error of a turn.
    pub(crate) fn first_to_end<T>(
        self,
        mut take: impl FnMut(Turn) -> Result<Option<T>>,
    ) -> Result<Option<T>> {
        for turn in self {
            if let Some(found) = take(turn)? {
                return Ok(Some(found));
            }
        }
        Ok(None)
    }
}

impl Iterator for Schedule {
    type Item = Turn;

    fn next(&mut self) -> Option<Turn> {
        if self.next >= self.ways {
            self.next = 0;
            self.budget = self.budget.saturating_mul(2);
        }
        let way = self.next;
        self.next += 1;
        let steps = match way {
            _ if self.ways == 1 => u64::MAX,
            0 => self.budget,
            _ => (self.budget / (self.ways as u64 - 1)).max(1),
        };
        Some(Turn { way, steps })
    }
}

#[cfg(test)]
mod tests {
    use super::Schedule;

    /// The ways of all turns until one ends, by the steps that each needs in a single turn, and all steps.
    fn turns(needed: &[u64]) -> (Vec<usize>, u64) {
        let (mut ways, mut steps) = (Vec::new(), 0);
        for turn in Schedule::new(needed.len(), 8) {
            ways.push(turn.way);
            steps += turn.steps.min(needed[turn.way]);
            if needed[turn.way] <= turn.steps {
                break;
            }
        }
        (ways, steps)
    }

    #[test]
    fn the_first_way_has_the_first_budget_alone() {
        assert_eq!(turns(&[8, 1, 2]), (vec![0], 8));
    }

    #[test]
    fn the_first_way_to_end_has_the_result() {
        assert_eq!(turns(&[1000, 999, 3]), (vec![0, 1, 2], 8 + 4 + 3));
        assert_eq!(turns(&[30, 1000, 999]).0, [0, 1, 2, 0, 1, 2, 0]);
    }

    #[test]
    fn the_steps_are_at_most_a_multiple_of_those_of_the_best_way() {
        for best in 9..300 {
            for at in 0..3 {
                let mut needed = [u64::MAX; 3];
                needed[at] = best;
                // The last budget is less than twice the best, all budgets of a way less than twice its last one.
                let shares = if at == 0 { 1 } else { 2 };
                assert!(turns(&needed).1 < 2 * 4 * shares * best, "{best} by way {at}");
            }
        }
    }

    #[test]
    fn a_single_way_has_no_budget() {
        assert_eq!(turns(&[1000]), (vec![0], 1000));
    }
}
