//! Iteration over the states of a set.

use super::{ExplicitEngine, StateSet};
use meliora_base::error::Result;
use meliora_model::State;
use meliora_space::explore::Space;
use meliora_space::meter::Charge;
use meliora_space::set::{BitSet, set};

/// An iteration over the states of a set in the order of their values, first variable first.
pub struct Listing {
    /// The numbers of the remaining states, the next one last.
    left: Vec<usize>,
    _charge: Charge,
}

impl StateSet {
    /// Returns the number of states of the scope, rounded up to a multiple of 64. Work on the set
    /// is proportional to it.
    pub fn capacity(&self) -> usize {
        64 * self.0.words().len()
    }
}

impl ExplicitEngine {
    /// Starts an iteration over the states of X; `ExplicitEngine::next_listed` returns them.
    /// Cost: the states of X are sorted.
    pub fn listing(&self, x: &StateSet) -> Result<Listing> {
        let count = usize::try_from(self.bits(x)?.count()).unwrap_or(usize::MAX);
        let charge = self.meter.charge(count.saturating_mul(size_of::<usize>()))?;
        let mut left: Vec<usize> = self.bits(x)?.iter().collect();
        match &*self.space {
            Space::Every(_) => left.reverse(),
            // Codes compare as the values do.
            Space::Indexed(index) => left.sort_unstable_by(|&a, &b| index.code(b).cmp(index.code(a))),
        }
        Ok(Listing { left, _charge: charge })
    }

    /// Returns the next state of a listing; `None` at its end.
    pub fn next_listed(&self, listing: &mut Listing) -> Option<State> {
        listing.left.pop().map(|state| self.values(state))
    }

    /// Calls `each` with every state of X, in no particular order.
    pub fn visit(&self, x: &StateSet, each: &mut dyn FnMut(&[i64])) -> Result<()> {
        let mut values = vec![0; self.program.variables.len()];
        for state in self.bits(x)?.iter() {
            self.tick()?;
            self.with_code(state, |code| self.layout.decode(code, &mut values));
            each(&values);
        }
        Ok(())
    }

    /// Returns { s ∈ X : `wanted(s)` }.
    pub fn filter(&self, x: &StateSet, wanted: &mut dyn FnMut(&[i64]) -> bool) -> Result<StateSet> {
        let mut found = BitSet::empty(&self.meter, self.graph.states());
        let words = found.words_mut();
        let mut values = vec![0; self.program.variables.len()];
        for state in self.bits(x)?.iter() {
            self.tick()?;
            self.with_code(state, |code| self.layout.decode(code, &mut values));
            if wanted(&values) {
                set(words, state);
            }
        }
        Ok(StateSet(found))
    }

    /// Returns the states of X at the given positions, counted from 0 in an order that is always
    /// the same. Cost: one pass over X.
    pub fn members_at(&self, x: &StateSet, positions: &[u64]) -> Result<Vec<State>> {
        let mut sorted: Vec<(u64, usize)> = positions.iter().copied().zip(0..).collect();
        sorted.sort_unstable();
        let mut found = vec![State::new(); positions.len()];
        let mut wanted = sorted.into_iter().peekable();
        for (position, state) in (0..).zip(self.bits(x)?.iter()) {
            self.tick()?;
            while let Some((_, place)) = wanted.next_if(|&(at, _)| at == position) {
                found[place] = self.values(state);
            }
            if wanted.peek().is_none() {
                break;
            }
        }
        Ok(found)
    }
}
