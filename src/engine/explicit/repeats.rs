//! The choices of cells: each list of choices that is common to all states of a cell is computed once.

use ahash::AHashMap;

use super::cells::Cells;
use super::steps::{Steps, Taken};

/// The number of states of a cell whose choices are listed one by one before its row is found.
const PATIENCE: u32 = 4;
/// Stands for a cell whose states do not have the same choices, or whose choices were not stored.
const NONE: u32 = u32::MAX;
/// The greatest number of successors in all stored lists together.
const MOST_STORED: usize = 1 << 20;

/// The choices of a state, relative to its code.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Row<const W: usize> {
    /// The difference between each successor and the code.
    differences: Vec<[u64; W]>,
    weights: Vec<u32>,
    /// The end of each choice in `weights`.
    ends: Vec<u32>,
    pub(super) taken: Vec<Taken>,
}

impl<const W: usize> Row<W> {
    /// Creates the row of the successors of a state.
    pub(super) fn new(code: &[u64], steps: &Steps, taken: Vec<Taken>) -> Self {
        let difference = |to: &[u64]| {
            let mut difference = [0; W];
            for (word, (to, from)) in difference.iter_mut().zip(to.iter().zip(code)) {
                *word = to.wrapping_sub(*from);
            }
            difference
        };
        let differences = steps.codes.chunks_exact(code.len()).map(difference).collect();
        Row { differences, weights: steps.weights.clone(), ends: steps.ends.clone(), taken }
    }

    /// Replaces steps by those of a state.
    pub(super) fn apply(&self, code: &[u64], into: &mut Steps) {
        into.clear(code.len());
        for difference in &self.differences {
            into.codes.extend(code.iter().zip(difference).map(|(word, more)| word.wrapping_add(*more)));
        }
        into.weights.extend_from_slice(&self.weights);
        into.ends.extend_from_slice(&self.ends);
    }
}

/// The knowledge about the choices of a cell.
pub(super) enum Known {
    /// The number of the row of all its states.
    Row(u32),
    /// The cell, whose row may be found now.
    Unknown(usize),
    /// Each state is listed alone.
    Alone,
}

/// The rows of the cells of a program.
pub(super) struct Repeats<const W: usize> {
    pub(super) cells: Cells,
    /// For each cell the number of its states that were listed, up to [`PATIENCE`]; then the number of its row,
    /// counted from there, or [`NONE`].
    numbers: Vec<u32>,
    rows: Vec<Row<W>>,
    known: AHashMap<Row<W>, u32>,
    stored: usize,
}

impl<const W: usize> Repeats<W> {
    /// Creates cells without rows.
    pub(super) fn new(cells: Cells) -> Self {
        let numbers = vec![0; cells.count()];
        Repeats { cells, numbers, rows: Vec::new(), known: AHashMap::new(), stored: 0 }
    }

    /// Looks up the choices of a state, which is counted.
    #[inline]
    pub(super) fn look(&mut self, code: &[u64]) -> Known {
        let cell = self.cells.cell(code);
        match &mut self.numbers[cell] {
            &mut NONE => Known::Alone,
            &mut PATIENCE => Known::Unknown(cell),
            number if *number < PATIENCE => {
                *number += 1;
                Known::Alone
            }
            number => Known::Row(*number - PATIENCE - 1),
        }
    }

    /// Returns a row.
    pub(super) fn row(&self, number: u32) -> &Row<W> {
        &self.rows[number as usize]
    }

    /// Stores the row of all states of a cell, or that there is none; returns its number.
    pub(super) fn set(&mut self, cell: usize, row: Option<Row<W>>) -> Option<u32> {
        let number = row.and_then(|row| self.number(row));
        self.numbers[cell] = number.map_or(NONE, |number| number + PATIENCE + 1);
        number
    }

    /// Returns the number of a row, a new one if the row is new; `None` if there are too many.
    fn number(&mut self, row: Row<W>) -> Option<u32> {
        if let Some(&known) = self.known.get(&row) {
            return Some(known);
        }
        // Each row counts, also one without successors.
        self.stored += row.differences.len() + 1;
        if self.stored > MOST_STORED {
            return None;
        }
        let number = self.rows.len() as u32;
        self.known.insert(row.clone(), number);
        self.rows.push(row);
        Some(number)
    }
}
