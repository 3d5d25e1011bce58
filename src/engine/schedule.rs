//! Several methods of one fixpoint in turns, with budgets that double.
//!
//! Nobody can predict which method is best for a model that he has not seen. So they take turns, counted in steps, until
//! one of them ends. Whole questions race instead; see `race`.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering::Relaxed};

/// The way that ended the last search of one kind, and the steps with which it ended searches since another way did.
#[derive(Debug, Default)]
pub(crate) struct Leader {
    way: AtomicUsize,
    steps: AtomicU64,
}

impl Leader {
    /// Returns the way that ended the last search; the first way if there is none.
    pub(crate) fn way(&self) -> usize {
        self.way.load(Relaxed)
    }

    /// Notes that a way has ended a search by a turn of a number of steps.
    pub(crate) fn ended(&self, way: usize, steps: u64) {
        if self.way.swap(way, Relaxed) != way {
            self.steps.store(0, Relaxed);
        }
        self.steps.fetch_add(steps, Relaxed);
    }
}

/// The turns of several ways to one search. The leader of searches of its kind is the first.
///
/// In each round the first way has a budget, and the others share as much; the budget of a round is twice that of the
/// round before. So the first way has the first budget alone, and half of all later work. Whichever way is the best, all of
/// them together take at most a fixed multiple of its work. A single way has no budget.
///
/// The first budget is at least the steps with which the leader has ended searches since it leads. A turn in vain at most
/// doubles these: if another way ends this search, it leads, and they are forgotten; else this search takes more.
pub(crate) struct Schedule {
    /// The ways in the order of their turns.
    ways: Vec<usize>,
    /// The place of the next way.
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
    /// Creates a schedule for some ways, at least one, with the least first budget.
    pub(crate) fn new(ways: Range<usize>, first: u64, leader: &Leader) -> Self {
        let mut ways = Vec::from_iter(ways);
        ways.sort_by_key(|&way| way != leader.way());
        Schedule { ways, next: 0, budget: leader.steps.load(Relaxed).max(first).max(1) }
    }
}

impl Iterator for Schedule {
    type Item = Turn;

    fn next(&mut self) -> Option<Turn> {
        if self.next >= self.ways.len() {
            self.next = 0;
            self.budget = self.budget.saturating_mul(2);
        }
        let place = self.next;
        self.next += 1;
        let steps = match place {
            _ if self.ways.len() == 1 => u64::MAX,
            0 => self.budget,
            _ => (self.budget / (self.ways.len() as u64 - 1)).max(1),
        };
        Some(Turn { way: self.ways[place], steps })
    }
}

#[cfg(test)]
mod tests {
    use super::{Leader, Schedule};

    /// The ways of all turns until one ends, by the steps that each needs in a single turn, and all steps.
    fn turns(needed: &[u64], leader: &Leader) -> (Vec<usize>, u64) {
        let (mut ways, mut steps) = (Vec::new(), 0);
        for turn in Schedule::new(0..needed.len(), 8, leader) {
            ways.push(turn.way);
            steps += turn.steps.min(needed[turn.way]);
            if needed[turn.way] <= turn.steps {
                leader.ended(turn.way, needed[turn.way]);
                break;
            }
        }
        (ways, steps)
    }

    fn first_turns(needed: &[u64]) -> (Vec<usize>, u64) {
        turns(needed, &Leader::default())
    }

    #[test]
    fn the_first_way_has_the_first_budget_alone() {
        assert_eq!(first_turns(&[8, 1, 2]), (vec![0], 8));
    }

    #[test]
    fn the_first_way_to_end_has_the_result() {
        assert_eq!(first_turns(&[1000, 999, 3]), (vec![0, 1, 2], 8 + 4 + 3));
        assert_eq!(first_turns(&[30, 1000, 999]).0, [0, 1, 2, 0, 1, 2, 0]);
    }

    #[test]
    fn the_steps_are_at_most_a_multiple_of_those_of_the_best_way() {
        for best in 9..300 {
            for at in 0..3 {
                let mut needed = [u64::MAX; 3];
                needed[at] = best;
                // The last budget is less than twice the best, all budgets of a way less than twice its last one.
                let shares = if at == 0 { 1 } else { 2 };
                assert!(first_turns(&needed).1 < 2 * 4 * shares * best, "{best} by way {at}");
            }
        }
    }

    #[test]
    fn the_leader_may_take_the_steps_of_all_searches_that_it_ended_since_it_leads() {
        let leader = Leader::default();
        assert_eq!(turns(&[100, 10, 100], &leader).0, [0, 1, 2, 0, 1, 2, 0, 1]);
        assert_eq!(turns(&[1, 10, 1], &leader), (vec![1], 10));
        assert_eq!(turns(&[1, 20, 1], &leader), (vec![1], 20));
        assert_eq!(turns(&[1, 41, 100], &leader), (vec![1, 0], 40 + 1), "40 steps, then another way");
        assert_eq!(
            turns(&[9, 2, 2], &leader),
            (vec![0, 1], 8 + 2),
            "the leader changed, and its steps are lost"
        );
    }

    #[test]
    fn a_single_way_has_no_budget() {
        assert_eq!(first_turns(&[1000]), (vec![0], 1000));
    }
}
