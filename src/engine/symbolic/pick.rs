//! Enumeration of the states of a set.

use super::encoding::Encoding;
use super::store::Store;
use super::store::diagram::Bdd;
use super::{StateSet, SymbolicEngine};
use crate::settings::Count;
use meliora_base::error::{Error, Result};
use meliora_model::{State, VarId};

/// An enumeration of the states of a set by their values, the first variable first.
///
/// It decides bit by bit in the order of the declarations, independent of the order of the diagram.
pub struct Listing {
    /// The bits in the order of the declarations.
    positions: Vec<u32>,
    /// The subsets left to visit, each with the number of decided bits and their values.
    stack: Vec<(Bdd, usize, Vec<bool>)>,
}

impl Listing {
    fn new(encoding: &Encoding, x: &Bdd) -> Self {
        let mut positions = Vec::new();
        for index in 0..encoding.variables().len() {
            positions.extend(encoding.positions(VarId(index as u32)).iter().rev().copied());
        }
        Listing { positions, stack: vec![(x.clone(), 0, vec![false; encoding.width()])] }
    }

    fn advance(&mut self, store: &Store, encoding: &Encoding) -> Result<Option<State>> {
        while let Some((rest, depth, pattern)) = self.stack.pop() {
            if store.is_zero(&rest) {
                continue;
            }
            let Some(&position) = self.positions.get(depth) else {
                return Ok(Some(encoding.decode(&pattern)));
            };
            let mut set = pattern.clone();
            set[position as usize] = true;
            let bit = store.literal(2 * position, true)?;
            self.stack.push((store.and(&rest, &bit)?, depth + 1, set));
            self.stack.push((store.minus(&rest, &bit)?, depth + 1, pattern));
        }
        Ok(None)
    }
}

impl SymbolicEngine {
    /// Starts an enumeration of the states of X; [`SymbolicEngine::next_listed`] returns them one
    /// by one.
    ///
    /// # Errors
    /// The set belongs to another engine.
    pub fn listing(&self, x: &StateSet) -> Result<Listing> {
        Ok(Listing::new(&self.encoding, self.diagram_of(x)?))
    }

    /// Returns the next state of an enumeration; `None` at its end.
    ///
    /// Cost: at most two conjunctions per bit.
    ///
    /// # Errors
    /// A limit, or a set that belongs to another engine.
    pub fn next_listed(&self, listing: &mut Listing) -> Result<Option<State>> {
        if !listing.stack.iter().all(|(rest, ..)| self.store.owns(rest)) {
            return Err(Error::ForeignSet);
        }
        listing.advance(&self.store, &self.encoding)
    }
}

/// Returns the first state of a non-empty set, in the order of [`list`].
pub(super) fn first(store: &Store, encoding: &Encoding, x: &Bdd) -> Result<State> {
    Ok(list(store, encoding, x, 1)?.swap_remove(0))
}

/// A set with at most this many states, or as many as are wanted, is listed in the order of the diagram,
/// which needs no operation on diagrams, and sorted.
const MANY: usize = 64;

/// Returns up to `limit` states by their values, the first variable first.
pub(super) fn list(store: &Store, encoding: &Encoding, x: &Bdd, limit: usize) -> Result<Vec<State>> {
    let (most, mut all) = (limit.max(MANY), Vec::new());
    // More states than are wanted are not kept, so that few are listed in vain.
    if limit <= MANY || store.count(x, encoding.width() as u32)? <= Count::from(limit) {
        store.each_assignment(x, encoding.width(), |bits| {
            all.push(encoding.decode(bits));
            all.len() <= most
        })?;
        if all.len() <= most {
            all.sort_unstable();
            all.truncate(limit);
            return Ok(all);
        }
    }
    let (mut listing, mut found) = (Listing::new(encoding, x), Vec::new());
    while found.len() < limit {
        let Some(state) = listing.advance(store, encoding)? else { break };
        found.push(state);
    }
    Ok(found)
}
