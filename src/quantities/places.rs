//! The nodes of the graph as states in arenas, and the way back from a state to its node.

use std::collections::VecDeque;
use std::hash::{BuildHasher, Hasher};

use ahash::RandomState;
use hashbrown::HashTable;

use crate::engine::explicit::weighted::Codec;
use crate::model::State;

/// Where a state is taken: in an arena, or in a junction of it, right after an improving step under
/// `prefix`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    /// The arena; `None` if the state is in none.
    pub(super) arena: Option<u32>,
    pub(super) junction: bool,
}

impl Place {
    /// Returns the place in an arena.
    pub(super) fn of(arena: Option<u32>) -> Self {
        Place { arena, junction: false }
    }

    fn key(self) -> u64 {
        2 * self.arena.map_or(0, |arena| u64::from(arena) + 1) + u64::from(self.junction)
    }
}

/// No class.
const NONE: u32 = u32::MAX;

/// The nodes found so far.
#[derive(Debug, Default)]
pub(super) struct Places {
    numbers: HashTable<u32>,
    hasher: RandomState,
    /// The codes of states; none before the first exploration.
    codec: Option<Codec>,
    /// The code and the key of the place of each node, one after the other.
    rows: Vec<u64>,
    /// The class of each node's state, or [`NONE`].
    classes: Vec<u32>,
    /// True for each node whose arena is that of its state's own class.
    pub(super) own: Vec<bool>,
    /// True for each node of which it is known that its arena keeps every choice.
    pub(super) unrestricted: Vec<bool>,
    /// The number of arenas.
    pub(super) arenas: u32,
    /// The nodes that are to be explored.
    pub(super) queue: VecDeque<u32>,
}

impl Places {
    /// Creates an empty collection.
    pub(super) fn new(codec: Codec, arenas: u32) -> Self {
        Places { codec: Some(codec), arenas, ..Places::default() }
    }

    /// Returns the node of a state at a place.
    pub(super) fn find(&self, place: Place, state: &[i64]) -> Option<u32> {
        self.find_code(place, &self.codec.as_ref()?.encode(state)?)
    }

    /// Returns the node of a code at a place.
    pub(super) fn find_code(&self, place: Place, code: &[u64]) -> Option<u32> {
        let key = place.key();
        let same = |&node: &u32| self.row(node).split_last() == Some((&key, code));
        self.numbers.find(self.hash(key, code), same).copied()
    }

    /// Returns the state of a node.
    pub(super) fn state(&self, node: u32) -> State {
        self.codec.as_ref().map_or_else(State::new, |codec| codec.decode(self.code(node)))
    }

    /// Returns whether a node is that of a state.
    pub(super) fn is_at(&self, node: u32, state: &[i64]) -> bool {
        let code = self.codec.as_ref().and_then(|codec| codec.encode(state));
        code.is_some_and(|code| self.code(node) == &code[..])
    }

    /// Returns the code of a node's state.
    pub(super) fn code(&self, node: u32) -> &[u64] {
        self.row(node).split_last().map_or(&[], |(_, code)| code)
    }

    /// Returns the arena of a node.
    pub(super) fn arena(&self, node: u32) -> Option<u32> {
        let key = self.row(node).last().copied().unwrap_or(0);
        (key as u32 / 2).checked_sub(1)
    }

    /// Returns the class of a node's state.
    pub(super) fn class(&self, node: u32) -> Option<u32> {
        Some(self.classes[node as usize]).filter(|&class| class != NONE)
    }

    /// Adds the next node: its place, the code of its state, the class of the state, and whether the
    /// place is the arena of this class.
    pub(super) fn add(&mut self, node: u32, place: Place, code: &[u64], (class, own): (Option<u32>, bool)) {
        self.rows.extend(code);
        self.rows.push(place.key());
        self.classes.push(class.unwrap_or(NONE));
        self.own.push(own);
        self.unrestricted.push(false);
        let Places { numbers, rows, hasher, .. } = self;
        let width = code.len() + 1;
        let again = |&node: &u32| {
            let row = &rows[node as usize * width..][..width];
            hash(hasher, row[width - 1], &row[..width - 1])
        };
        numbers.insert_unique(hash(hasher, place.key(), code), node, again);
    }

    /// Returns the bytes of a node.
    pub(super) fn bytes_of_node(&self) -> usize {
        // The table has up to twice as many places of five bytes, the queue of four.
        8 * self.width() + size_of::<u32>() + 2 + 18
    }

    fn width(&self) -> usize {
        self.codec.as_ref().map_or(1, |codec| codec.words() + 1)
    }

    fn row(&self, node: u32) -> &[u64] {
        let width = self.width();
        &self.rows[node as usize * width..][..width]
    }

    fn hash(&self, key: u64, code: &[u64]) -> u64 {
        hash(&self.hasher, key, code)
    }
}

fn hash(hasher: &RandomState, key: u64, code: &[u64]) -> u64 {
    let mut state = hasher.build_hasher();
    code.iter().for_each(|&word| state.write_u64(word));
    state.write_u64(key);
    state.finish()
}
