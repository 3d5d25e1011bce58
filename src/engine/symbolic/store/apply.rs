//! The Boolean operations, quantification and counting, as recursions over OxiDD's operation cache.
//!
//! OxiDD's own operations run to their end, however long that takes, and count no steps. These
//! count each result that was not in the cache, so that limits and cancellation reach every
//! operation.

use ahash::AHashMap;
use oxidd::util::num::Natural;
use oxidd::{Manager, NodeID};
use oxidd_rules_bdd::simple::BDDOp;

use super::charge::{BYTES_OF_TABLE, Charge};
use super::diagram::{Diagram, Edge, Held};
use super::walk::{Halt, Walk};

/// A connective of two functions.
trait Connective {
    /// Its operation in the cache.
    const OPERATION: BDDOp;
    /// Its truth table, indexed by the two operands.
    const TABLE: [[bool; 2]; 2];
}

/// Implements connectives, each given by its name, operation and truth table.
macro_rules! connectives {
    ($($name:ident: $table:expr;)*) => {$(
        struct $name;

        impl Connective for $name {
            const OPERATION: BDDOp = BDDOp::$name;
            const TABLE: [[bool; 2]; 2] = $table;
        }
    )*};
}

connectives! {
    And: [[false, false], [false, true]];
    Or: [[false, true], [true, true]];
    Xor: [[false, true], [true, false]];
    Equiv: [[true, false], [false, true]];
    Imp: [[true, true], [false, true]];
    ImpStrict: [[false, true], [false, false]];
}

/// The result of a connective without recursion.
enum Simple<'e, 'id: 'e> {
    Constant(bool),
    Same(Edge<'e, 'id>),
    Negation(Edge<'e, 'id>),
}

impl<'e, 'id: 'e> Simple<'e, 'id> {
    /// Returns the function of f with these values where f is false and where it is true.
    fn new([clear, set]: [bool; 2], f: Edge<'e, 'id>) -> Self {
        match (clear, set) {
            (false, true) => Simple::Same(f),
            (true, false) => Simple::Negation(f),
            (value, _) => Simple::Constant(value),
        }
    }
}

/// The numbers of common satisfying assignments of two functions, by their nodes.
struct Counts {
    found: AHashMap<[NodeID; 2], Natural>,
    charge: Charge,
}

type Made<'m, 'id> = Result<Held<'m, 'id>, Halt>;

impl<'m, 'id: 'm> Walk<'m, 'id> {
    /// Computes f ∧ g.
    pub(in crate::symbolic) fn and(&self, f: Edge<'_, 'id>, g: Edge<'_, 'id>) -> Made<'m, 'id> {
        self.apply::<And>(f, g)
    }

    /// Computes f ∨ g.
    pub(in crate::symbolic) fn or(&self, f: Edge<'_, 'id>, g: Edge<'_, 'id>) -> Made<'m, 'id> {
        self.apply::<Or>(f, g)
    }

    /// Computes f ⊕ g.
    pub(in crate::symbolic) fn xor(&self, f: Edge<'_, 'id>, g: Edge<'_, 'id>) -> Made<'m, 'id> {
        self.apply::<Xor>(f, g)
    }

    /// Computes f ↔ g.
    pub(in crate::symbolic) fn iff(&self, f: Edge<'_, 'id>, g: Edge<'_, 'id>) -> Made<'m, 'id> {
        self.apply::<Equiv>(f, g)
    }

    /// Computes f ∧ ¬g.
    pub(in crate::symbolic) fn minus(&self, f: Edge<'_, 'id>, g: Edge<'_, 'id>) -> Made<'m, 'id> {
        self.apply::<ImpStrict>(g, f)
    }

    /// Computes ¬f.
    pub(in crate::symbolic) fn not(&self, f: Edge<'_, 'id>) -> Made<'m, 'id> {
        self.negate(f)
    }

    /// Computes: if c then f else g.
    pub(in crate::symbolic) fn ite(
        &self,
        c: Edge<'_, 'id>,
        f: Edge<'_, 'id>,
        g: Edge<'_, 'id>,
    ) -> Made<'m, 'id> {
        self.choose(c, f, g)
    }

    /// Computes ∃ V . f, where `variables` is the conjunction of the variables V.
    pub(in crate::symbolic) fn exists(&self, f: Edge<'_, 'id>, variables: Edge<'_, 'id>) -> Made<'m, 'id> {
        self.quantify(f, variables)
    }

    /// Returns the number of assignments to all variables that satisfy f ∧ g. Makes no node.
    pub(in crate::symbolic) fn count_common(
        &self,
        f: Edge<'_, 'id>,
        g: Edge<'_, 'id>,
    ) -> Result<Natural, Halt> {
        let all = Natural::from(1u32) << self.m.num_levels();
        self.count_below(f, g, &all, &mut Counts { found: AHashMap::new(), charge: self.store.charge() })
    }

    fn count_below(
        &self,
        f: Edge<'_, 'id>,
        g: Edge<'_, 'id>,
        all: &Natural,
        known: &mut Counts,
    ) -> Result<Natural, Halt> {
        match (self.m.value_of(f), self.m.value_of(g)) {
            (Some(false), _) | (_, Some(false)) => return Ok(Natural::from(0u32)),
            (Some(true), Some(true)) => return Ok(all.clone()),
            _ => {}
        }
        let key = [f.node_id(), g.node_id()];
        if let Some(found) = known.found.get(&key) {
            return Ok(found.clone());
        }
        self.tick()?;
        let level = self.m.level_of(f).min(self.m.level_of(g));
        let ((f1, f0), (g1, g0)) = (self.m.children(f, level), self.m.children(g, level));
        let both = self.count_below(f1, g1, all, known)? + self.count_below(f0, g0, all, known)?;
        let count = both >> 1u32;
        known
            .charge
            .add(BYTES_OF_TABLE * size_of::<([NodeID; 2], Natural)>() + size_of_val(count.mantissa()));
        known.found.insert(key, count.clone());
        Ok(count)
    }

    fn apply<C: Connective>(&self, f: Edge<'_, 'id>, g: Edge<'_, 'id>) -> Made<'m, 'id> {
        if let Some(simple) = self.simple::<C>(f, g) {
            return self.finish(simple);
        }
        let symmetric = const { C::TABLE[0][1] == C::TABLE[1][0] };
        let key = if symmetric && g < f { [g, f] } else { [f, g] };
        if let Some(found) = self.m.recall_operation(C::OPERATION, &key) {
            return Ok(found);
        }
        self.tick()?;
        let level = self.m.level_of(f).min(self.m.level_of(g));
        let ((f1, f0), (g1, g0)) = (self.m.children(f, level), self.m.children(g, level));
        let (set, clear) = (self.apply::<C>(f1, g1)?, self.apply::<C>(f0, g0)?);
        let made = self.node_among(level, set, clear, [(f, (f1, f0)), (g, (g1, g0))])?;
        self.m.remember_operation(C::OPERATION, &key, made.borrowed());
        Ok(made)
    }

    /// Returns the result of a connective if an operand is constant or the operands are equal.
    #[inline]
    fn simple<'e, C: Connective>(&self, f: Edge<'e, 'id>, g: Edge<'e, 'id>) -> Option<Simple<'e, 'id>> {
        let table = C::TABLE;
        if f == g {
            return Some(Simple::new([table[0][0], table[1][1]], f));
        }
        if let Some(value) = self.m.value_of(f) {
            return Some(Simple::new(table[usize::from(value)], g));
        }
        let value = usize::from(self.m.value_of(g)?);
        Some(Simple::new([table[0][value], table[1][value]], f))
    }

    #[inline]
    fn finish(&self, simple: Simple<'_, 'id>) -> Made<'m, 'id> {
        match simple {
            Simple::Constant(value) => Ok(self.m.constant(value)),
            Simple::Same(f) => Ok(self.m.held(f)),
            Simple::Negation(f) => self.negate(f),
        }
    }

    fn negate(&self, f: Edge<'_, 'id>) -> Made<'m, 'id> {
        if let Some(value) = self.m.value_of(f) {
            return Ok(self.m.constant(!value));
        }
        if let Some(found) = self.m.recall_operation(BDDOp::Not, &[f]) {
            return Ok(found);
        }
        self.tick()?;
        let level = self.m.level_of(f);
        let (f1, f0) = self.m.children(f, level);
        let (set, clear) = (self.negate(f1)?, self.negate(f0)?);
        let made = self.node_on(level, set, clear)?;
        self.m.remember_operation(BDDOp::Not, &[f], made.borrowed());
        Ok(made)
    }

    fn choose(&self, c: Edge<'_, 'id>, f: Edge<'_, 'id>, g: Edge<'_, 'id>) -> Made<'m, 'id> {
        match (self.m.value_of(c), self.m.value_of(f), self.m.value_of(g)) {
            _ if f == g => return Ok(self.m.held(f)),
            (Some(value), ..) => return Ok(self.m.held(if value { f } else { g })),
            (_, Some(true), _) => return self.apply::<Or>(c, g),
            (_, Some(false), _) => return self.apply::<ImpStrict>(c, g),
            (.., Some(true)) => return self.apply::<Imp>(c, f),
            (.., Some(false)) => return self.apply::<And>(c, f),
            _ if c == f => return self.apply::<Or>(c, g),
            _ if c == g => return self.apply::<And>(c, f),
            _ => {}
        }
        if let Some(found) = self.m.recall_operation(BDDOp::Ite, &[c, f, g]) {
            return Ok(found);
        }
        self.tick()?;
        let level = self.m.level_of(c).min(self.m.level_of(f)).min(self.m.level_of(g));
        let (c1, c0) = self.m.children(c, level);
        let ((f1, f0), (g1, g0)) = (self.m.children(f, level), self.m.children(g, level));
        let (set, clear) = (self.choose(c1, f1, g1)?, self.choose(c0, f0, g0)?);
        let made = self.node_among(level, set, clear, [(f, (f1, f0)), (g, (g1, g0))])?;
        self.m.remember_operation(BDDOp::Ite, &[c, f, g], made.borrowed());
        Ok(made)
    }

    fn quantify<'e>(&'e self, f: Edge<'e, 'id>, variables: Edge<'e, 'id>) -> Made<'m, 'id> {
        let level = self.m.level_of(f);
        let mut variables = variables;
        while self.m.level_of(variables) < level {
            variables = self.m.children(variables, self.m.level_of(variables)).0;
        }
        if self.m.value_of(f).is_some() || self.m.value_of(variables).is_some() {
            return Ok(self.m.held(f));
        }
        if let Some(found) = self.m.recall_operation(BDDOp::Exists, &[f, variables]) {
            return Ok(found);
        }
        self.tick()?;
        let (f1, f0) = self.m.children(f, level);
        let (set, clear) = (self.quantify(f1, variables)?, self.quantify(f0, variables)?);
        let made = if self.m.level_of(variables) == level {
            self.apply::<Or>(set.borrowed(), clear.borrowed())?
        } else {
            self.node_on(level, set, clear)?
        };
        self.m.remember_operation(BDDOp::Exists, &[f, variables], made.borrowed());
        Ok(made)
    }
}
