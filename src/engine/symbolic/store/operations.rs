//! The Boolean operations on the diagrams of a store, and recursions over them.

use std::sync::atomic::Ordering::Relaxed;

use num_bigint::BigUint;
use oxidd::util::num::Natural;

use super::Store;
use super::diagram::{Bdd, Diagram, Held};
use super::walk::{Halt, PATIENCE, Pass, Walk};
use crate::settings::Count;
use meliora_base::error::Result;

impl Store {
    /// Returns the literal of the variable on `level`, positive or negative.
    pub(in crate::symbolic) fn literal(&self, level: u32, positive: bool) -> Result<Bdd> {
        self.make(|w| {
            w.tick()?;
            w.node_on(level, w.m.constant(positive), w.m.constant(!positive))
        })
    }

    /// Computes f ∧ g.
    pub(in crate::symbolic) fn and(&self, f: &Bdd, g: &Bdd) -> Result<Bdd> {
        self.make(|w| w.and(w.edge(f), w.edge(g)))
    }

    /// Computes f ∨ g.
    pub(in crate::symbolic) fn or(&self, f: &Bdd, g: &Bdd) -> Result<Bdd> {
        self.make(|w| w.or(w.edge(f), w.edge(g)))
    }

    /// Computes ¬f.
    pub(in crate::symbolic) fn not(&self, f: &Bdd) -> Result<Bdd> {
        self.make(|w| w.not(w.edge(f)))
    }

    /// Computes f ⊕ g.
    pub(in crate::symbolic) fn xor(&self, f: &Bdd, g: &Bdd) -> Result<Bdd> {
        self.make(|w| w.xor(w.edge(f), w.edge(g)))
    }

    /// Computes f ↔ g.
    pub(in crate::symbolic) fn iff(&self, f: &Bdd, g: &Bdd) -> Result<Bdd> {
        self.make(|w| w.iff(w.edge(f), w.edge(g)))
    }

    /// Computes f ∧ ¬g.
    pub(in crate::symbolic) fn minus(&self, f: &Bdd, g: &Bdd) -> Result<Bdd> {
        self.make(|w| w.minus(w.edge(f), w.edge(g)))
    }

    /// Computes: if c then f else g.
    pub(in crate::symbolic) fn ite(&self, c: &Bdd, f: &Bdd, g: &Bdd) -> Result<Bdd> {
        self.make(|w| w.ite(w.edge(c), w.edge(f), w.edge(g)))
    }

    /// Computes the disjunction of many functions in pairs, so that intermediate results stay
    /// small.
    pub(in crate::symbolic) fn any(&self, functions: impl IntoIterator<Item = Bdd>) -> Result<Bdd> {
        let mut round: Vec<Bdd> = functions.into_iter().collect();
        while round.len() > 1 {
            let mut next = Vec::with_capacity(round.len().div_ceil(2));
            for pair in round.chunks(2) {
                next.push(if let [f, g] = pair { self.or(f, g)? } else { pair[0].clone() });
            }
            round = next;
        }
        Ok(round.pop().unwrap_or_else(|| self.zero()))
    }

    /// Computes ∃ V . f, where `variables` is the conjunction of the variables V.
    pub(in crate::symbolic) fn exists(&self, f: &Bdd, variables: &Bdd) -> Result<Bdd> {
        self.make(|w| w.exists(w.edge(f), w.edge(variables)))
    }

    /// Returns the cofactor of f by the present value of a bit. f depends on no earlier bit.
    pub(in crate::symbolic) fn cofactor(&self, f: &Bdd, bit: u32, value: bool) -> Bdd {
        self.shared(|m| {
            let (set, clear) = m.children(m.edge(f), 2 * bit);
            m.handle(if value { set } else { clear })
        })
    }

    /// Returns the number of satisfying assignments to the variables, without `unused` of them on
    /// which f does not depend.
    pub(in crate::symbolic) fn count(&self, f: &Bdd, unused: u32) -> Result<Count> {
        self.count_common(f, &self.one, unused)
    }

    /// Returns the number of satisfying assignments of f ∧ g to the variables, without `unused` of
    /// them on which neither depends.
    pub(in crate::symbolic) fn count_common(&self, f: &Bdd, g: &Bdd, unused: u32) -> Result<Count> {
        let all = self.walk_to_the_end(Pass::forward(None), |w| w.count_common(w.edge(f), w.edge(g)))?;
        Ok(to_biguint(&all) >> unused)
    }

    /// Runs one operation.
    pub(in crate::symbolic) fn make(
        &self,
        operation: impl for<'m, 'id> FnOnce(&Walk<'m, 'id>) -> Result<Held<'m, 'id>, Halt>,
    ) -> Result<Bdd> {
        self.walk_to_the_end(Pass::forward(None), |walk| walk.own(operation))
    }

    /// Runs a recursion over diagrams; `None` if it takes more than `steps` steps.
    pub(in crate::symbolic) fn walk<T>(
        &self,
        pass: Pass,
        steps: u64,
        recursion: impl for<'m, 'id> FnOnce(&Walk<'m, 'id>) -> Result<T, Halt>,
    ) -> Result<Option<T>> {
        let (result, steps) = self.shared(|m| {
            let checked = |walk: &Walk<'_, '_>| {
                self.check_limits(m)?;
                recursion(walk)
            };
            self.deep(|| Walk::run(self, m, pass, steps, checked))
        });
        self.work.steps.fetch_add(steps, Relaxed);
        self.advance(steps % PATIENCE);
        match result {
            Ok(found) => Ok(Some(found)),
            Err(Halt::Failed(error)) => Err(*error),
            Err(Halt::Spent) => Ok(None),
        }
    }

    /// Runs a recursion over diagrams without a step limit.
    pub(in crate::symbolic) fn walk_to_the_end<T>(
        &self,
        pass: Pass,
        recursion: impl for<'m, 'id> FnOnce(&Walk<'m, 'id>) -> Result<T, Halt>,
    ) -> Result<T> {
        self.walk(pass, u64::MAX, recursion)?.ok_or_else(|| self.full())
    }
}

/// Computes `mantissa · 2^exp`.
fn to_biguint(n: &Natural) -> BigUint {
    let mut digits = Vec::new();
    for &d in n.mantissa() {
        digits.extend([d as u32, (d >> 32) as u32]);
    }
    BigUint::new(digits) << n.exp()
}
