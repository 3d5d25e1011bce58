//! Saturation: a reachability fixpoint that closes the lower parts of the diagram first.
//!
//! A relation that depends on no bit above some level acts on every subdiagram below that level
//! separately. The fixpoint first descends to the parts that the lowest relations change, and
//! closes each of them once (the operation cache remembers it). It applies a higher relation only
//! to parts whose children are closed (Ciardo, Lüttgen and Siminiescu, Saturation, TACAS 2001).
//!
//! All sets stay within a bound that is split along with them (Zhao and Ciardo, Symbolic CTL model
//! checking with constrained saturation, ATVA 2009). Restricting the relations to the reachable
//! states instead would make each of them depend on every bit.

use crate::symbolic::relations::lists::Layers;
use crate::symbolic::store::diagram::{Diagram, Edge, Held};
use crate::symbolic::store::walk::{Halt, Walk};

impl<'m, 'id: 'm> Walk<'m, 'id> {
    /// Computes [`Walk::close`] for relations that read or write the first bit: applies each to the
    /// states that are new to it, and closes the lower parts in between.
    pub(in crate::symbolic) fn fire(
        &self,
        x: Edge<'_, 'id>,
        b: Edge<'_, 'id>,
        layers: &Layers,
    ) -> Result<Held<'m, 'id>, Halt> {
        let mut fired = Vec::from_iter(layers.here.iter().map(|_| self.zero()));
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
