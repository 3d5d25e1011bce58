//! Tests of states for membership in several sets: one diagram with all answers at its leaves, in an array of its own,
//! so that a test follows one path.

use ahash::AHashMap;
use oxidd::LevelNo;

use super::Bit;
use super::encoding::Encoding;
use super::store::Store;
use super::store::diagram::{Bdd, Diagram, Edge, ManagerOf};
use crate::membership::Membership;
use crate::settings::Settings;
use meliora_base::error::Result;
use meliora_base::progress::Poll;

/// The greatest number of nodes: 48 MiB.
const MOST_NODES: usize = 1 << 22;
/// The greatest number of bits of a state, for the recursion.
const MOST_BITS: usize = 2048;

/// A node: an inner one by its place, or a leaf by the complement of its place.
type Place = i32;

/// An inner node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Inner {
    /// The position of the bit.
    bit: u32,
    set: Place,
    clear: Place,
}

/// The diagram of several sets.
pub(super) struct Marks<'e> {
    encoding: &'e Encoding,
    /// For each bit its variable, the lowest value of that, and its place in the value.
    bits: Vec<(usize, i64, u32)>,
    nodes: Vec<Inner>,
    /// The sets that contain the states of each leaf.
    leaves: Vec<u64>,
    root: Place,
}

impl<'e> Marks<'e> {
    /// Builds the diagram; `None` if it would be too large. Cost: that of one Boolean operation per set.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(super) fn new(
        store: &Store,
        encoding: &'e Encoding,
        sets: &[&Bdd],
        settings: &Settings,
    ) -> Result<Option<Self>> {
        if encoding.width() > MOST_BITS {
            return Ok(None);
        }
        // While it is built, a node takes about four times as much.
        let most = MOST_NODES.min((settings.memory / 16) as usize / (4 * size_of::<Inner>()));
        let poll = Poll::new(&*settings.sink);
        let mut build = Build { poll, most, nodes: Vec::new(), places: AHashMap::new(), leaves: vec![0] };
        let mut root = !0;
        for (number, &set) in sets.iter().enumerate() {
            let mut memo = AHashMap::new();
            let joined = store.shared(|m| {
                let mut step = Step { build: &mut build, memo: &mut memo, mark: 1 << number };
                step.join(m, root, m.edge(set))
            })?;
            let Some(joined) = joined else { return Ok(None) };
            root = joined;
        }
        let Build { nodes, leaves, .. } = build;
        let variables = encoding.variables();
        let place = |bit: &Bit| (bit.variable.index(), variables[bit.variable.index()].low, bit.index);
        let bits = encoding.order().iter().map(place).collect();
        Ok(Some(Marks { encoding, bits, nodes, leaves, root }))
    }
}

impl Membership for Marks<'_> {
    fn of(&self, state: &[i64]) -> Result<u64> {
        if !self.encoding.is_valid(state) {
            return Ok(0);
        }
        let mut place = self.root;
        while let Some(node) = usize::try_from(place).ok().map(|place| self.nodes[place]) {
            let (variable, low, index) = self.bits[node.bit as usize];
            let offset = state[variable].wrapping_sub(low) as u64;
            place = if offset >> index & 1 == 1 { node.set } else { node.clear };
        }
        Ok(self.leaves[!place as usize])
    }
}

/// The nodes so far.
struct Build<'s> {
    poll: Poll<'s>,
    most: usize,
    nodes: Vec<Inner>,
    places: AHashMap<Inner, Place>,
    leaves: Vec<u64>,
}

impl Build<'_> {
    fn leaf(&mut self, marks: u64) -> Place {
        let known = self.leaves.iter().position(|&leaf| leaf == marks);
        let place = known.unwrap_or_else(|| {
            self.leaves.push(marks);
            self.leaves.len() - 1
        });
        !(place as Place)
    }

    fn node(&mut self, node: Inner) -> Place {
        if node.set == node.clear {
            return node.set;
        }
        *self.places.entry(node).or_insert_with(|| {
            self.nodes.push(node);
            self.nodes.len() as Place - 1
        })
    }
}

/// The step that adds a set.
struct Step<'b, 's> {
    build: &'b mut Build<'s>,
    /// The results by node of the diagram so far and node of the set.
    memo: &'b mut AHashMap<(Place, usize), Place>,
    mark: u64,
}

impl Step<'_, '_> {
    /// Adds the mark to the leaves of a node whose states are in a set; `None` if there are too many nodes.
    fn join<'id>(&mut self, m: &ManagerOf<'id>, place: Place, set: Edge<'_, 'id>) -> Result<Option<Place>> {
        let value = m.value_of(set);
        if value == Some(false) {
            return Ok(Some(place));
        }
        let own = usize::try_from(place).ok().map(|place| self.build.nodes[place]);
        if let (None, Some(_)) = (own, value) {
            let marks = self.build.leaves[!place as usize] | self.mark;
            return Ok(Some(self.build.leaf(marks)));
        }
        let key = (place, set.node_id());
        if let Some(&known) = self.memo.get(&key) {
            return Ok(Some(known));
        }
        self.build.poll.step()?;
        if self.build.nodes.len() >= self.build.most || self.memo.len() >= 2 * self.build.most {
            return Ok(None);
        }
        let of_set = m.level_of(set);
        let level = own.map_or(LevelNo::MAX, |node| 2 * node.bit).min(of_set);
        let (set_in, set_out) = m.children(set, level);
        let (own_in, own_out) = match own {
            Some(node) if 2 * node.bit == level => (node.set, node.clear),
            _ => (place, place),
        };
        let Some(set) = self.join(m, own_in, set_in)? else { return Ok(None) };
        let Some(clear) = self.join(m, own_out, set_out)? else { return Ok(None) };
        let joined = self.build.node(Inner { bit: level / 2, set, clear });
        self.memo.insert(key, joined);
        Ok(Some(joined))
    }
}
