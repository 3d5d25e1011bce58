//! The nodes of the graph as states in arenas, and the way back from a state to its node.

use bitvec::vec::BitVec;

use meliora_base::error::Result;
use meliora_equations::{Codes, Meter, Narrow};
use meliora_model::State;
use meliora_space::index::Looked;
use meliora_space::weighted::{Code, Codec, Steps};

/// The role of a state: in an arena, or in a junction of it, right after an improving step under
/// `prefix`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Place {
    /// The arena; `None` if the state is in none.
    pub(crate) arena: Option<u32>,
    pub(crate) junction: bool,
}

impl Place {
    /// Returns the place in an arena.
    pub(crate) fn of(arena: Option<u32>) -> Self {
        Place { arena, junction: false }
    }

    /// The number of places of a state in an arena.
    const KEYS: u32 = 2;

    /// Returns a number of its own for each place.
    pub(crate) fn key(self) -> u32 {
        Self::KEYS * self.arena.map_or(0, |arena| arena + 1) + u32::from(self.junction)
    }
}

/// The facts that are noted about a node.
pub(crate) struct Noted {
    /// The class of its state.
    pub(crate) class: Option<u32>,
    /// True if its arena is that of this class.
    pub(crate) own: bool,
    /// True if its arena keeps every choice.
    pub(crate) unrestricted: bool,
}

/// The nodes found so far.
#[derive(Debug, Default)]
pub(crate) struct Places {
    /// The code of each node's state, with the key of the node's place.
    codes: Codes,
    /// The codes of states; none before the first exploration.
    codec: Option<Codec>,
    /// The class of each node's state plus 1; 0 for no class.
    classes: Narrow,
    /// True for each node whose arena is that of its state's own class.
    pub(crate) own: BitVec,
    /// True for each node whose arena keeps every choice of its state.
    pub(crate) unrestricted: BitVec,
    /// The number of arenas.
    pub(crate) arenas: u32,
}

impl Places {
    /// Creates an empty collection.
    pub(crate) fn new(codec: Codec, arenas: u32) -> Self {
        let keys = Place::KEYS * (arenas + 1);
        Places { codes: Codes::new(&codec, keys), codec: Some(codec), arenas, ..Places::default() }
    }

    /// Returns the node of a state at a place.
    pub(crate) fn find(&self, place: Place, state: &[i64]) -> Option<u32> {
        self.find_code(place, &self.codec.as_ref()?.encode(state)?)
    }

    /// Looks the successors of a state up at a place, for [`Places::find_looked`].
    pub(crate) fn look(&self, place: Place, steps: &Steps, into: &mut Looked) {
        self.codes.look(place.key(), steps, into);
    }

    /// Returns the node of the code of a number among those that were looked up at a place.
    pub(crate) fn find_looked(
        &self,
        place: Place,
        code: &[u64],
        looked: &Looked,
        number: usize,
    ) -> Option<u32> {
        self.codes.find_looked(place.key(), code, looked, number)
    }

    /// Returns the node of a code at a place.
    pub(crate) fn find_code(&self, place: Place, code: &[u64]) -> Option<u32> {
        self.codes.find(place.key(), code)
    }

    /// Returns the state of a node.
    pub(crate) fn state(&self, node: u32) -> State {
        self.codec.as_ref().map_or_else(State::new, |codec| codec.decode(&self.code(node)))
    }

    /// Returns whether a node is that of a state.
    pub(crate) fn is_at(&self, node: u32, state: &[i64]) -> bool {
        let code = self.codec.as_ref().and_then(|codec| codec.encode(state));
        code.is_some_and(|code| self.code(node) == code)
    }

    /// Returns the code of a node's state.
    pub(crate) fn code(&self, node: u32) -> Code {
        self.codes.code(node)
    }

    /// Returns the arena of a node.
    pub(crate) fn arena(&self, node: u32) -> Option<u32> {
        (self.codes.key(node) / Place::KEYS).checked_sub(1)
    }

    /// Returns the class of a node's state.
    pub(crate) fn class(&self, node: u32) -> Option<u32> {
        self.classes.get(node as usize).checked_sub(1)
    }

    /// Adds the next node: its place, the code of its state, and its marks.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub(crate) fn add(
        &mut self,
        place: Place,
        code: &[u64],
        Noted { class, own, unrestricted }: Noted,
        meter: &mut Meter<'_>,
    ) -> Result<()> {
        meter.take(self.classes.width() + 1)?;
        self.codes.add(place.key(), code, meter)?;
        self.classes.push(class.map_or(0, |class| class + 1));
        self.own.push(own);
        self.unrestricted.push(unrestricted);
        Ok(())
    }

    /// Returns the bytes of all nodes.
    pub(crate) fn bytes(&self) -> usize {
        self.own.len() * (self.codes.width() + self.classes.width() + 1)
    }
}
