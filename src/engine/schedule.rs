//! Several ways to the same result in turns, with budgets that double.
//!
//! Nobody can predict which variable order, method or engine is best for a model that he has not seen. So the
//! ways take turns, counted in steps, until one of them ends.

use meliora_base::error::Result;

/// The turns of several ways. The first one is the likeliest to be the best.
///
/// In each round the first way has a budget, and the others share as much, or each has as much if none is likelier; the
/// budget of a round is twice that of the round before. So the first way has the first budget alone, and its share of all
/// later work. Whichever way is the best, all of them together take at most a fixed multiple of its work, as long as none is preferred. The last way that
/// is left has no budget.
pub(crate) struct Schedule {
    /// The number of ways among which the budget of those other than the first is divided.
    others: u64,
    /// The way that is the likeliest to be the best.
    first: usize,
    /// For each way, the number of times that another one was preferred since it was.
    lost: Vec<u32>,
    /// The ways that have turns, in their order.
    open: Vec<usize>,
    /// The place of the next turn among these.
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
        Schedule {
            others: (ways as u64).saturating_sub(1).max(1),
            first: 0,
            lost: vec![0; ways],
            open: (0..ways).collect(),
            next: 0,
            budget: first.max(1),
        }
    }

    /// Creates a schedule of ways that are equally likely: each has the whole budget of a round.
    pub(crate) fn even(ways: usize, first: u64) -> Self {
        Schedule { others: 1, ..Schedule::new(ways, first) }
    }

    /// Removes a way, which has no more turns.
    pub(crate) fn withdraw(&mut self, way: usize) {
        if let Some(place) = self.open.iter().position(|&open| open == way) {
            self.open.remove(place);
            self.next -= usize::from(place < self.next);
        }
    }

    /// Returns the ways that have turns.
    pub(crate) fn open(&self) -> &[usize] {
        &self.open
    }

    /// Makes a way the likeliest one from now on, and begins a round with it. Each time, the turns of the other ways are
    /// halved.
    pub(crate) fn prefer(&mut self, way: usize) {
        self.first = way;
        self.lost.iter_mut().for_each(|lost| *lost = (*lost + 1).min(63));
        self.lost[way] = 0;
        self.open.sort_by_key(|&open| open != way);
        self.next = self.open.len();
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

    /// Returns the next turn; `None` once all ways are withdrawn.
    fn next(&mut self) -> Option<Turn> {
        if self.next >= self.open.len() {
            self.next = 0;
            self.budget = self.budget.saturating_mul(2);
        }
        let way = *self.open.get(self.next)?;
        self.next += 1;
        let steps = match way {
            _ if self.open.len() == 1 => u64::MAX,
            _ if way == self.first => self.budget,
            _ => ((self.budget / self.others) >> self.lost[way]).max(1),
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
    fn ways_that_are_equally_likely_have_equal_turns() {
        let turns = Schedule::even(3, 8).take(4).map(|turn| (turn.way, turn.steps));
        assert_eq!(turns.collect::<Vec<_>>(), [(0, 8), (1, 8), (2, 8), (0, 16)]);
    }

    #[test]
    fn a_way_that_is_preferred_begins_the_next_round() {
        let mut schedule = Schedule::new(3, 8);
        let turns = |schedule: &mut Schedule, n| {
            let turns = schedule.take(n).map(|turn| (turn.way, turn.steps));
            turns.collect::<Vec<_>>()
        };
        assert_eq!(turns(&mut schedule, 2), [(0, 8), (1, 4)]);
        schedule.prefer(1);
        assert_eq!(turns(&mut schedule, 4), [(1, 16), (0, 4), (2, 4), (1, 32)]);
    }

    #[test]
    fn the_last_way_has_no_budget() {
        assert_eq!(turns(&[1000]), (vec![0], 1000));
        let mut schedule = Schedule::new(3, 8);
        assert_eq!(schedule.next().map(|turn| (turn.way, turn.steps)), Some((0, 8)));
        schedule.withdraw(0);
        assert_eq!(schedule.next().map(|turn| (turn.way, turn.steps)), Some((1, 4)));
        schedule.withdraw(1);
        assert_eq!(schedule.next().map(|turn| (turn.way, turn.steps)), Some((2, u64::MAX)));
        schedule.withdraw(2);
        assert_eq!(schedule.next(), None);
    }
}
