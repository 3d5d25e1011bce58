//! Chains: operands of a recursion over bits, linked in the order of the first bit that each depends on.
//!
//! A link holds the operands that depend on one bit and on no earlier one; all later operands are the
//! rest of the chain. Operands that depend on no bit come first, so that nothing is passed to insert one. Chains with equal ends share them. So the cofactors of a chain by its first bit
//! cost what that bit concerns: `n` independent modules have n links in all.

use std::collections::BTreeMap;
use std::hash::Hash;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use ahash::AHashMap;

use meliora_base::error::Result;

/// A link of a chain; its operands are of type `Operand`.
pub(super) trait Link: Sized {
    /// An operand.
    type Operand: Clone;

    /// Returns the first bit that the operands of this link depend on; `u32::MAX` if they depend on none.
    fn top(&self) -> u32;
    /// Returns the operands of this link.
    fn here(&self) -> &Arc<[Self::Operand]>;
    /// Returns the rest of the chain.
    fn below(&self) -> Option<&Arc<Self>>;
}

/// The links of a store.
pub(super) trait Links<L: Link> {
    /// Returns the first bit that an operand depends on; `u32::MAX` if it depends on none.
    fn top_of(&self, operand: &L::Operand) -> u32;
    /// Returns the operands of a link in their order, without superfluous ones. An operand may be replaced by
    /// one that depends on later bits only.
    fn simplified(&self, operands: Vec<L::Operand>) -> Result<Vec<L::Operand>>;
    /// Returns the link with these operands before a rest, which depends on later bits only.
    fn link(&self, here: Arc<[L::Operand]>, below: Option<Arc<L>>) -> Result<Arc<L>>;
}

/// The links of a store by their names. Links with equal names exist once.
pub(super) struct Known<N, L>(Mutex<AHashMap<N, Arc<L>>>);

impl<N, L> Default for Known<N, L> {
    fn default() -> Self {
        Known(Mutex::default())
    }
}

impl<N: Hash + Eq, L> Known<N, L> {
    /// Returns the link with a name, or makes it.
    pub(super) fn get(&self, name: N, make: impl FnOnce() -> Result<L>) -> Result<Arc<L>> {
        let mut known = self.names();
        if let Some(found) = known.get(&name) {
            return Ok(found.clone());
        }
        let made = Arc::new(make()?);
        known.insert(name, made.clone());
        Ok(made)
    }

    /// Forgets all names. This frees the links that are not in use.
    pub(super) fn forget(&self) {
        self.names().clear();
    }

    fn names(&self) -> MutexGuard<'_, AHashMap<N, Arc<L>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Returns the chain of some operands and those of a chain; the link without operands if there are none.
///
/// # Errors
/// The first error of a link.
pub(super) fn inserted<L: Link>(
    links: &impl Links<L>,
    operands: Vec<L::Operand>,
    chain: Option<Arc<L>>,
) -> Result<Arc<L>> {
    let mut open: BTreeMap<u32, Vec<L::Operand>> = BTreeMap::new();
    let sort = |open: &mut BTreeMap<u32, Vec<_>>, operand| {
        open.entry(links.top_of(&operand)).or_default().push(operand);
    };
    operands.into_iter().for_each(|operand| sort(&mut open, operand));
    let (mut rest, mut passed) = (chain, Vec::new());
    if let Some(link) = rest.take_if(|link| link.top() == u32::MAX) {
        link.here().iter().for_each(|operand| sort(&mut open, operand.clone()));
        rest = link.below().cloned();
    }
    while let Some((&top, _)) = open.first_key_value().filter(|&(&top, _)| top < u32::MAX) {
        while let Some(link) = rest.take_if(|link| link.top() < top) {
            passed.push(link.here().clone());
            rest = link.below().cloned();
        }
        let mut here = open.remove(&top).unwrap_or_default();
        if let Some(link) = rest.take_if(|link| link.top() == top) {
            here.extend_from_slice(link.here());
            rest = link.below().cloned();
        }
        let (here, later): (Vec<_>, Vec<_>) =
            links.simplified(here)?.into_iter().partition(|operand| links.top_of(operand) == top);
        later.into_iter().for_each(|operand| sort(&mut open, operand));
        passed.extend((!here.is_empty()).then(|| here.into()));
    }
    let constant = links.simplified(open.into_values().flatten().collect())?;
    let chain = passed.into_iter().rev().try_fold(rest, |below, here| links.link(here, below).map(Some))?;
    match chain {
        Some(chain) if constant.is_empty() => Ok(chain),
        chain => links.link(constant.into(), chain),
    }
}
