//! Single states of a set.

use super::encoding::Encoding;
use super::store::{Bdd, Store};
use crate::error::Result;
use crate::model::{State, VarId};

/// The first state of a set that is not empty, in the order of [`list`].
pub(super) fn first(store: &Store, encoding: &Encoding, x: &Bdd) -> Result<State> {
    Ok(list(store, encoding, x, 1)?.pop().unwrap_or_default())
}

/// Up to `limit` states in the order of their values, the first variable first.
///
/// Goes down bit by bit in the order of the declarations, whatever the order of the diagram.
pub(super) fn list(store: &Store, encoding: &Encoding, x: &Bdd, limit: usize) -> Result<Vec<State>> {
    let mut positions = Vec::new();
    for index in 0..encoding.variables().len() {
        positions.extend(encoding.positions(VarId(index as u32)).iter().rev().copied());
    }
    let mut found = Vec::new();
    // What is left to visit: a set, how many bits are decided, and how.
    let mut stack = vec![(x.clone(), 0usize, vec![false; encoding.width()])];
    while let Some((rest, depth, pattern)) = stack.pop() {
        if found.len() >= limit {
            break;
        }
        if store.is_zero(&rest) {
            continue;
        }
        let Some(&position) = positions.get(depth) else {
            found.push(encoding.decode(&pattern));
            continue;
        };
        let mut set = pattern.clone();
        set[position as usize] = true;
        let bit = store.literal(2 * position, true)?;
        stack.push((store.and(&rest, &bit)?, depth + 1, set));
        stack.push((store.minus(&rest, &bit)?, depth + 1, pattern));
    }
    Ok(found)
}
