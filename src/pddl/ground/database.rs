//! Relations of a Datalog program: rows of objects, with indexes by some of their columns.

use ahash::{AHashMap, AHashSet};
use smallvec::SmallVec;

use crate::task::Object;

/// The values of some columns.
pub(super) type Key = SmallVec<[Object; 4]>;

/// The rows of a predicate, in the order in which they were derived.
#[derive(Default)]
pub(super) struct Relation {
    arity: usize,
    count: usize,
    rows: Vec<Object>,
    known: AHashSet<Key>,
    indexes: Vec<Index>,
    /// Rows before this position were known before the last round.
    old: usize,
    /// Rows before this position were known before this round.
    recent: usize,
}

/// The rows by the values of some columns.
struct Index {
    columns: Vec<usize>,
    rows: AHashMap<Key, Vec<u32>>,
}

/// The rows that an atom of a rule stands for in one round.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Range {
    /// All rows that were known before this round.
    All,
    /// The rows that were known before the last round.
    Old,
    /// The rows of the last round.
    Delta,
}

impl Relation {
    pub(super) fn new(arity: usize) -> Self {
        Relation { arity, ..Relation::default() }
    }

    /// Adds a row; returns false if it was known.
    pub(super) fn add(&mut self, row: &[Object]) -> bool {
        if !self.known.insert(Key::from_slice(row)) {
            return false;
        }
        let number = u32::try_from(self.count).unwrap_or(u32::MAX);
        for index in &mut self.indexes {
            let key = index.columns.iter().map(|&column| row[column]).collect();
            index.rows.entry(key).or_default().push(number);
        }
        self.rows.extend_from_slice(row);
        self.count += 1;
        true
    }

    pub(super) fn contains(&self, row: &[Object]) -> bool {
        self.known.contains(row)
    }

    pub(super) fn len(&self) -> usize {
        self.count
    }

    pub(super) fn row(&self, at: usize) -> &[Object] {
        &self.rows[at * self.arity..(at + 1) * self.arity]
    }

    pub(super) fn rows(&self) -> impl Iterator<Item = &[Object]> {
        (0..self.count).map(|at| self.row(at))
    }

    /// Begins a round: the rows of the last one are new now. Returns whether there are any.
    pub(super) fn advance(&mut self) -> bool {
        (self.old, self.recent) = (self.recent, self.count);
        self.has_delta()
    }

    pub(super) fn has_delta(&self) -> bool {
        self.old < self.recent
    }

    /// Returns the positions of the rows in a range.
    pub(super) fn positions(&self, range: Range) -> std::ops::Range<usize> {
        match range {
            Range::All => 0..self.recent,
            Range::Old => 0..self.old,
            Range::Delta => self.old..self.recent,
        }
    }

    /// Builds an index by some columns, unless there is one. Returns its number.
    pub(super) fn index_by(&mut self, columns: &[usize]) -> usize {
        if let Some(at) = self.indexes.iter().position(|index| index.columns == columns) {
            return at;
        }
        let mut rows: AHashMap<Key, Vec<u32>> = AHashMap::new();
        for (row, number) in self.rows().zip(0..) {
            let key = columns.iter().map(|&column| row[column]).collect();
            rows.entry(key).or_default().push(number);
        }
        self.indexes.push(Index { columns: columns.to_vec(), rows });
        self.indexes.len() - 1
    }

    /// Returns the positions of the rows with these values, in ascending order.
    pub(super) fn with(&self, index: usize, key: &[Object], range: Range) -> &[u32] {
        let Some(all) = self.indexes[index].rows.get(key) else { return &[] };
        let range = self.positions(range);
        let before = |end: usize| all.partition_point(|&row| (row as usize) < end);
        &all[before(range.start)..before(range.end)]
    }
}
