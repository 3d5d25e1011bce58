//! Lower bounds of the numbers of steps to an improvement: as many as the luckiest outcomes need.
//!
//! They guide the search for the best choices of a part of the states, as admissible heuristics do: P. Hart, N. Nilsson and
//! B. Raphael, "A formal basis for the heuristic determination of minimum cost paths" (1968).

use std::cell::{Cell, OnceCell, RefCell};

use meliora_base::error::Result;
use meliora_engine::Engine;
use meliora_engine::edge_labels::winning;
use meliora_engine::membership::Membership;
use meliora_planning::levels::Game;

/// The layers D_1 ⊆ D_2 ⊆ … of an arena: D_i has the states from which i steps may be enough for an improvement, by choices
/// with which it is certain.
pub(crate) struct Distances<'e, E: Engine> {
    engine: &'e E,
    game: &'e Game<E>,
    /// The greatest layer, and whether it is the last one.
    last: RefCell<E::States>,
    is_complete: Cell<bool>,
    /// The tests of the layers, one by one: these differ in too many states for one test of them all.
    layers: RefCell<Vec<Box<dyn Membership + 'e>>>,
    /// The number of layers that were there before the first state was looked up.
    first: OnceCell<usize>,
}

impl<'e, E: Engine> Distances<'e, E> {
    /// Computes the first layer of a game of the first SASI level. Cost: one pre-image.
    ///
    /// # Errors
    /// A limit is reached.
    pub(crate) fn new(engine: &'e E, game: &'e Game<E>) -> Result<Self> {
        let last = engine.can_choose(&winning(engine, &game.choices, &game.edge_labels)?)?;
        let layers = RefCell::new(vec![engine.membership(&[&last])?]);
        let (last, is_complete, first) = (RefCell::new(last), Cell::new(false), OnceCell::new());
        Ok(Distances { engine, game, last, is_complete, layers, first })
    }

    /// Computes more layers until one has a state, or the engine has taken that many steps. Cost: one pre-image per layer.
    ///
    /// # Errors
    /// A limit is reached.
    pub(crate) fn widen(&self, state: &[i64], steps: u64) -> Result<()> {
        let engine = self.engine;
        while !self.is_complete.get()
            && !engine.contains(&self.last.borrow(), state)?
            && engine.usage().steps < steps
        {
            let last = self.last.borrow().clone();
            let next = engine.union(&last, &engine.can_enter(&self.game.choices, &last)?)?;
            match engine.same(&next, &last)? {
                true => self.is_complete.set(true),
                false => self.layers.borrow_mut().push(engine.membership(&[&next])?),
            }
            *self.last.borrow_mut() = next;
        }
        Ok(())
    }

    /// Returns whether a bound is the number of steps, and no wider layers change it.
    pub(crate) fn is_tight(&self, steps: u32) -> bool {
        steps > 0 && self.first.get().is_some_and(|&first| steps as usize <= first)
    }

    /// Returns a lower bound of the number of steps of a state. Cost: membership tests, logarithmic in the number of layers.
    pub(crate) fn steps(&self, state: &[i64]) -> Result<u32> {
        let layers = self.layers.borrow();
        self.first.get_or_init(|| layers.len());
        let (mut outside, mut inside) = (0, layers.len());
        while outside < inside {
            let middle = (outside + inside) / 2;
            match layers[middle].of(state)? {
                0 => outside = middle + 1,
                _ => inside = middle,
            }
        }
        Ok(outside as u32 + 1)
    }
}
