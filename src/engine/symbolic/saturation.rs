//! Saturation: a reachability fixpoint that goes down the diagram and closes the lower parts first.
//!
//! A relation that depends on no bit above some level acts on every subdiagram below that level by
//! itself. So the fixpoint goes down to the parts that the lowest relations move, closes each of
//! them once and for all (the operation cache remembers it), and fires a higher relation only on
//! what is closed below (Ciardo, Lüttgen and Siminiescu, Saturation, TACAS 2001). All sets stay
//! within a bound that goes down with them (Zhao and Ciardo, Symbolic CTL model checking with
//! constrained saturation, ATVA 2009), so that relations need not be confined to the reachable
//! states, which would make every one depend on every bit.

use super::diagram::{Diagram, Edge, Held};
use super::relation_lists::Layers;
use super::walk::{Halt, Walk};

impl<'m, 'id: 'm> Walk<'m, 'id> {
    /// [`Walk::close`] where relations act on the first bit: fires all that do, each on what is new to it,
    /// and closes the lower parts in between.
    pub(super) fn fire(
        &self,
        x: Edge<'_, 'id>,
        b: Edge<'_, 'id>,
        layers: &Layers,
    ) -> Result<Held<'m, 'id>, Halt> {
        let mut fired = layers.here.iter().map(|_| self.zero()).collect::<Result<Vec<_>, _>>()?;
        let mut closed = self.m.held(x);
        loop {
            let before = self.m.held(closed.borrowed());
            closed = self.close(true, closed.borrowed(), b, &layers.below)?;
            for (relation, fired) in layers.here.iter().zip(&mut fired) {
                let new = self.minus(closed.borrowed(), fired.borrowed())?;
                *fired = self.m.held(closed.borrowed());
                let entered = self.step(new.borrowed(), b, relation)?;
                closed = self.or(closed.borrowed(), entered.borrowed())?;
            }
            if closed.borrowed() == before.borrowed() {
                return Ok(closed);
            }
        }
    }
}
