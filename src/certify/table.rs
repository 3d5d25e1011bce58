//! The table of `values.csv`, with what the levels say about its rows.
//!
//! This module looks up no set of the dump. It uses the levels that were proved before.

use ahash::AHashMap;
use num_traits::{One, Zero};

use super::arena::Arena;
use super::checker::Checker;
use super::condition::Condition;
use super::error::{CheckError, CheckResult};
use super::levels::{Known, Levels};
use super::safety;
use meliora_base::bound::Bound;
use meliora_dump::bounds::{Bounds, Row};
use meliora_engine::symbolic::StateSet;
use meliora_engine::{Algebra, Engine};

/// The rows of a dump, with what the levels say about them.
pub(super) struct Table<'a> {
    pub(super) arenas: &'a [Arena],
    /// True if there are reference classes: an improving step may be counted or not.
    pub(super) may_skip: bool,
    /// True if edges are dropped: the levels do not show where a probability is 1.
    pub(super) shows_ones: bool,
    pub(super) levels: usize,
    pub(super) entries: Vec<Entry<'a>>,
    index: AHashMap<(usize, &'a [i64]), usize>,
    /// For each arena, the states with P_1 > 0.
    possible: Vec<StateSet>,
    /// The levels of SASI and of SPI.
    known: &'a [Levels; 2],
}

/// A row, and the levels of its state in its arena.
pub(super) struct Entry<'a> {
    pub(super) row: &'a Row,
    pub(super) arena: usize,
    /// The greatest k with P_k > 0, at most the levels of the table.
    pub(super) positive: usize,
    /// The greatest k with P_k = 1.
    pub(super) sure: usize,
}

impl<'a> Table<'a> {
    pub(super) fn new(
        checker: &Checker<'_>,
        arenas: &'a [Arena],
        known: &'a [Levels; 2],
        levels: usize,
        rows: &'a [Row],
    ) -> CheckResult<Self> {
        let shows_ones = safety::drops_edges(checker.manifest.safety);
        let first = |arena: usize| match known[1].known(arena, 1) {
            Known::Exactly(states) => states.clone(),
            // No state counts for it, and no row is needed.
            Known::AtMost(_) | Known::Empty | Known::Nothing => checker.engine.no_states(),
        };
        let possible = (0..arenas.len()).map(first).collect();
        let may_skip = safety::has_reference(checker.manifest.safety);
        let (entries, index) = (Vec::with_capacity(rows.len()), AHashMap::with_capacity(rows.len()));
        let mut table = Table { arenas, may_skip, shows_ones, levels, entries, index, possible, known };
        let named = |arena: &Arena| arena.reference.clone().unwrap_or_default();
        let numbers: AHashMap<String, usize> = arenas.iter().map(named).zip(0..).collect();
        for row in rows {
            let Some(&arena) = numbers.get(&row.arena) else {
                let condition = Condition::ArenaOfDump { name: row.arena.clone() };
                return Err(CheckError::violated(condition, None));
            };
            let wrong = |condition| Err(CheckError::violated(condition, Some(row.state.clone())));
            if [row.probabilities.len(), row.costs.len()] != [levels; 2] {
                return wrong(Condition::AllLevels);
            }
            if !checker.engine.contains(&table.possible[arena], &row.state)? {
                return wrong(Condition::PossibleRow);
            }
            let (positive, is_exact) = table.rank(checker, 1, arena, &row.state)?;
            if !is_exact {
                return wrong(Condition::KnownZero { level: positive + 1 });
            }
            let sure = match shows_ones {
                true => row.probabilities.iter().take_while(|p| is_one(&p.lower)).count(),
                false => table.rank(checker, 0, arena, &row.state)?.0,
            };
            let number = table.entries.len();
            if table.index.insert((arena, &row.state), number).is_some() {
                return wrong(Condition::OneRow);
            }
            table.entries.push(Entry { row, arena, positive, sure });
        }
        Ok(table)
    }

    /// Returns the greatest k, at most the levels of the table, such that a state is in level k of an
    /// arena as far as is known; `false` if it may be in the next level, too. `kind` is 0 for SASI, 1
    /// for SPI. Levels are decreasing.
    fn rank(
        &self,
        checker: &Checker<'_>,
        kind: usize,
        arena: usize,
        state: &[i64],
    ) -> CheckResult<(usize, bool)> {
        for k in 1..=self.levels {
            match self.known[kind].known(arena, k) {
                Known::Exactly(states) if checker.engine.contains(states, state)? => {}
                Known::AtMost(states) if checker.engine.contains(states, state)? => {
                    return Ok((k - 1, false));
                }
                Known::Exactly(_) | Known::AtMost(_) | Known::Empty => return Ok((k - 1, true)),
                Known::Nothing => return Ok((k - 1, false)),
            }
        }
        Ok((self.levels, true))
    }

    /// Checks that each state from which an improvement is possible has a row in its own arena.
    pub(super) fn complete(&self, checker: &Checker<'_>) -> CheckResult {
        let engine = &checker.engine;
        for (number, (arena, possible)) in self.arenas.iter().zip(&self.possible).enumerate() {
            let own = engine.intersection(&arena.start, possible)?;
            let mut rows = 0usize;
            for entry in self.entries.iter().filter(|entry| entry.arena == number) {
                rows += usize::from(engine.contains(&own, &entry.row.state)?);
            }
            let count = engine.count(&own)?;
            if count != meliora_engine::Count::from(rows) {
                let condition = Condition::AllRows { states: count.to_string(), rows };
                return Err(CheckError::violated(condition, None));
            }
        }
        Ok(())
    }

    /// Returns the entry of a state in an arena; `None` if P_1 is 0 there.
    pub(super) fn find(
        &self,
        checker: &Checker<'_>,
        arena: usize,
        state: &[i64],
    ) -> CheckResult<Option<&Entry<'a>>> {
        if let Some(&number) = self.index.get(&(arena, state)) {
            return Ok(Some(&self.entries[number]));
        }
        if checker.engine.contains(&self.possible[arena], state)? {
            return Err(CheckError::violated(Condition::NeededRow, Some(state.to_vec())));
        }
        Ok(None)
    }

    /// Returns the arena of a state's own class; `None` if no strategy avoids weakening this class.
    pub(super) fn own_arena(&self, checker: &Checker<'_>, state: &[i64]) -> CheckResult<Option<usize>> {
        for (number, arena) in self.arenas.iter().enumerate() {
            if checker.engine.contains(&arena.start, state)? {
                return Ok(Some(number));
            }
        }
        Ok(None)
    }
}

fn is_one(number: &Bound) -> bool {
    number.exact().is_some_and(|x| x.is_one())
}

fn is_zero(number: &Bound) -> bool {
    number.exact().is_some_and(|x| x.is_zero())
}

impl Entry<'_> {
    /// Checks the row against the levels, and the order of its bounds.
    pub(super) fn consistent(&self, table: &Table<'_>) -> CheckResult {
        let wrong = |condition| Err(CheckError::violated(condition, Some(self.row.state.clone())));
        for (k, (p, c)) in (1..).zip(self.row.probabilities.iter().zip(&self.row.costs)) {
            if k > self.positive && !(is_zero(&p.lower) && is_zero(&p.upper)) {
                return wrong(Condition::ZeroOutside { level: k });
            }
            if k <= self.sure && !(is_one(&p.lower) && is_one(&p.upper)) {
                return wrong(Condition::OneInside { level: k });
            }
            if table.shows_ones && k > self.sure && is_one(&p.upper) {
                return wrong(Condition::BelowOne { level: k });
            }
            if c.is_some() != (k <= self.sure) {
                return wrong(Condition::CostIfCertain { level: k });
            }
            for (what, bounds) in [("P", Some(p)), ("C", c.as_ref())] {
                if bounds.is_some_and(|bounds| !is_ordered(bounds)) {
                    return wrong(Condition::OrderedBounds { what, level: k });
                }
            }
            if p.upper.exact().is_none_or(|x| x > num_traits::One::one()) {
                return wrong(Condition::AtMostOne { level: k });
            }
        }
        Ok(())
    }
}

fn is_ordered(bounds: &Bounds) -> bool {
    match (bounds.lower.exact(), bounds.upper.exact()) {
        (Some(lower), Some(upper)) => lower <= upper,
        (Some(_), None) => true,
        (None, _) => false,
    }
}
