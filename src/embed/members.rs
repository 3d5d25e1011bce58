//! The members of a set of states, one after the other or drawn at random.

use ahash::AHashSet;

use super::States;
use meliora_base::error::{Error, Result};
use meliora_base::random::Draw;
use meliora_dump::Members;
use meliora_engine::any::AnyStates;
use meliora_engine::symbolic::Set;
use meliora_engine::{AnyEngine, Count, explicit, symbolic};
use meliora_model::State;

/// An iterator over the states of a set, in the order of their values, first variable first. States
/// are found on demand.
pub struct Listing {
    engine: AnyEngine,
    rest: Rest,
}

enum Rest {
    Symbolic(symbolic::Listing),
    Explicit(explicit::Listing),
}

impl Iterator for Listing {
    type Item = Result<State>;

    fn next(&mut self) -> Option<Result<State>> {
        match &mut self.rest {
            Rest::Symbolic(rest) => self.engine.symbolic()?.next_listed(rest).transpose(),
            Rest::Explicit(rest) => self.engine.explicit()?.next_listed(rest).map(Ok),
        }
    }
}

impl States {
    /// Returns an iterator over all states in the order of their values, without a bound on their
    /// number.
    ///
    /// # Errors
    /// A limit is reached; with the explicit engine, before the first state.
    pub fn listing(&self) -> Result<Listing> {
        let rest = match (self.set(), self.engine().explicit(), self.engine().symbolic()) {
            (AnyStates::Symbolic(x), _, Some(engine)) => Rest::Symbolic(engine.listing(x)?),
            (AnyStates::Explicit(x), Some(engine), _) => Rest::Explicit(engine.listing(x)?),
            _ => return Err(Error::Usage("the set belongs to another engine".to_owned())),
        };
        Ok(Listing { engine: self.engine().clone(), rest })
    }

    /// Draws `size` distinct states uniformly at random, in random order. The same seed draws the
    /// same states with the same engine and order of bits. Cost: symbolically linear in the nodes
    /// of the diagram and the bits of the drawn states, explicitly linear in the states.
    ///
    /// # Errors
    /// [`Error::Usage`] if the set has fewer states; a limit is reached.
    pub fn sample(&self, size: usize, seed: u64) -> Result<Vec<State>> {
        let count = self.count()?;
        if Count::from(size) > count {
            return Err(Error::Usage(format!("{size} states cannot be drawn out of {count}")));
        }
        let numbers = draw(&mut Draw::new(seed), &count, size);
        match (self.set(), self.engine().explicit(), self.engine().symbolic()) {
            (AnyStates::Explicit(x), Some(engine), _) => {
                let number = |n: &Count| u64::try_from(n).unwrap_or(u64::MAX);
                engine.members_at(x, &numbers.iter().map(number).collect::<Vec<_>>())
            }
            (AnyStates::Symbolic(x), _, Some(engine)) => {
                let diagram = engine.diagram(&[Set::States(x.clone())], &[])?;
                let members = Members::new(&diagram, diagram.roots[0]);
                let patterns = numbers.iter().filter_map(|number| members.nth(number));
                Ok(patterns.map(|pattern| engine.encoding().decode(&pattern)).collect())
            }
            _ => Err(Error::Usage("the set belongs to another engine".to_owned())),
        }
    }
}

/// Draws `size` distinct numbers below `count`; `size` must not exceed `count`.
fn draw(draw: &mut Draw, count: &Count, size: usize) -> Vec<Count> {
    // At least half of them are taken, so shuffling all is faster than rejecting duplicates.
    if *count <= Count::from(2 * size) {
        let mut all: Vec<Count> = (0..usize::try_from(count).unwrap_or(0)).map(Count::from).collect();
        draw.shuffle(&mut all);
        all.truncate(size);
        return all;
    }
    let (mut taken, mut numbers) = (AHashSet::new(), Vec::with_capacity(size));
    while numbers.len() < size {
        let number = draw.below_large(count);
        if taken.insert(number.clone()) {
            numbers.push(number);
        }
    }
    numbers
}
