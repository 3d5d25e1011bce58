//! The nodes of the graph as states in arenas, and the way back from a state to its node.

use std::hash::{BuildHasher, Hasher};
use std::sync::OnceLock;

use ahash::RandomState;
use bitvec::vec::BitVec;
use hashbrown::HashTable;

use super::narrow::Narrow;
use meliora_engine::explicit::weighted::Codec;
use meliora_model::State;

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

    fn key(self) -> u32 {
        2 * self.arena.map_or(0, |arena| arena + 1) + u32::from(self.junction)
    }
}

/// The nodes found so far.
#[derive(Debug, Default)]
pub(super) struct Places {
    /// The nodes by their codes and places. Large models need the memory for their equations, so this is
    /// dropped after the exploration, and built again for the first question.
    numbers: OnceLock<HashTable<u32>>,
    hasher: RandomState,
    /// The codes of states; none before the first exploration.
    codec: Option<Codec>,
    /// The code of each node's state, one after the other.
    codes: Vec<u64>,
    /// The key of the place of each node.
    keys: Narrow,
    /// The class of each node's state plus 1; 0 for no class.
    classes: Narrow,
    /// True for each node whose arena is that of its state's own class.
    pub(super) own: BitVec,
    /// True for each node of which it is known that its arena keeps every choice.
    pub(super) unrestricted: BitVec,
    /// The number of arenas.
    pub(super) arenas: u32,
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
        let same = |&node: &u32| self.code(node) == code && self.keys.get(node as usize) == key;
        let numbers = self.numbers.get_or_init(|| self.numbered());
        numbers.find(hash(&self.hasher, key, code), same).copied()
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
        let words = self.words();
        &self.codes[node as usize * words..][..words]
    }

    /// Returns the arena of a node.
    pub(super) fn arena(&self, node: u32) -> Option<u32> {
        (self.keys.get(node as usize) / 2).checked_sub(1)
    }

    /// Returns the class of a node's state.
    pub(super) fn class(&self, node: u32) -> Option<u32> {
        self.classes.get(node as usize).checked_sub(1)
    }

    /// Adds the next node: its place, the code of its state, the class of the state, and whether the
    /// place is the arena of this class.
    pub(super) fn add(&mut self, node: u32, place: Place, code: &[u64], (class, own): (Option<u32>, bool)) {
        self.codes.extend(code);
        self.keys.push(place.key());
        self.classes.push(class.map_or(0, |class| class + 1));
        self.own.push(own);
        self.unrestricted.push(false);
        let mut numbers = self.numbers.take().unwrap_or_default();
        numbers.insert_unique(self.hash(node), node, |&node| self.hash(node));
        self.numbers = OnceLock::from(numbers);
    }

    /// Drops what the exploration needs.
    pub(super) fn end_exploration(&mut self) {
        self.numbers.take();
    }

    fn numbered(&self) -> HashTable<u32> {
        let mut numbers = HashTable::with_capacity(self.own.len());
        for node in 0..self.own.len() as u32 {
            numbers.insert_unique(self.hash(node), node, |&node| self.hash(node));
        }
        numbers
    }

    fn hash(&self, node: u32) -> u64 {
        hash(&self.hasher, self.keys.get(node as usize), self.code(node))
    }

    /// Returns the bytes of all nodes.
    pub(super) fn bytes(&self) -> usize {
        self.own.len() * (8 * self.words() + self.keys.width() + self.classes.width() + 1)
    }

    /// Returns the bytes of a node.
    pub(super) fn bytes_of_node(&self) -> usize {
        // The table has up to twice as many places of five bytes.
        8 * self.words() + self.keys.width() + self.classes.width() + 1 + 10
    }

    fn words(&self) -> usize {
        self.codec.as_ref().map_or(0, Codec::words)
    }
}

fn hash(hasher: &RandomState, key: u32, code: &[u64]) -> u64 {
    let mut state = hasher.build_hasher();
    code.iter().for_each(|&word| state.write_u64(word));
    state.write_u32(key);
    state.finish()
}
