//! Values of any type that depend on the state, as a partition: each value with the states that
//! have it.
//!
//! Reals are represented this way, and integers if [`SymbolicInteger`] does not support an
//! operation. Every operator of the language works value by value, by the reference semantics.

use ahash::AHashMap;

use super::symbolic_integer::SymbolicInteger;
use crate::symbolic::store::Store;
use crate::symbolic::store::diagram::Bdd;
use meliora_base::error::{Limit, Result};
use meliora_base::exact::Exact;
use meliora_base::value::EvalError;

/// Maximum number of values. More are refused.
const MOST_VALUES: usize = 1 << 16;

/// Disjoint sets of states, one per value. States in none of them have no value.
#[derive(Clone)]
pub(in crate::symbolic) struct Partition {
    parts: Vec<(Exact, Bdd)>,
}

impl Partition {
    /// Returns the number of values.
    pub(in crate::symbolic) fn len(&self) -> usize {
        self.parts.len()
    }

    /// Creates the partition with one value in all states.
    pub(in crate::symbolic) fn constant(store: &Store, value: Exact) -> Self {
        Partition { parts: vec![(value, store.one())] }
    }

    /// Computes the values of an integer in the states `within`, by splitting on its bits.
    pub(in crate::symbolic) fn of_bits(store: &Store, bits: &SymbolicInteger, within: &Bdd) -> Result<Self> {
        let mut parts = vec![(0i64, within.clone())];
        for k in (0..bits.len()).rev() {
            let mut next = Vec::with_capacity(2 * parts.len());
            for (prefix, states) in parts {
                let prefix = if k + 1 == bits.len() { 0 } else { prefix << 1 };
                // The sign bit has negative weight.
                let one = if k + 1 == bits.len() { -1 } else { prefix | 1 };
                let zero = store.minus(&states, bits.bit(k))?;
                let set = store.and(&states, bits.bit(k))?;
                next.extend([(prefix, zero), (one, set)].into_iter().filter(|(_, s)| !store.is_zero(s)));
            }
            check_size(next.len())?;
            parts = next;
        }
        Ok(Partition { parts: parts.into_iter().map(|(v, s)| (Exact::Int(v), s)).collect() })
    }

    /// Returns the truth values of a Boolean.
    pub(in crate::symbolic) fn of_bool(store: &Store, f: &Bdd) -> Result<Self> {
        let parts = vec![(Exact::Bool(true), f.clone()), (Exact::Bool(false), store.not(f)?)];
        Ok(Partition { parts: parts.into_iter().filter(|(_, s)| !store.is_zero(s)).collect() })
    }

    /// Applies `op` to every value. The second result is the states in which it fails.
    pub(in crate::symbolic) fn map(
        &self,
        store: &Store,
        op: impl Fn(&Exact) -> Result<Exact, EvalError>,
    ) -> Result<(Self, Bdd)> {
        let results = self.parts.iter().map(|(v, s)| (op(v), s.clone())).collect();
        Partition::collect(store, results)
    }

    /// Applies `op` to every pair of values that some state has. The second result is the states in
    /// which it fails.
    pub(in crate::symbolic) fn combine(
        &self,
        store: &Store,
        other: &Partition,
        op: impl Fn(&Exact, &Exact) -> Result<Exact, EvalError>,
    ) -> Result<(Self, Bdd)> {
        let mut results = Vec::new();
        for (x, states) in &self.parts {
            for (y, others) in &other.parts {
                let both = store.and(states, others)?;
                if !store.is_zero(&both) {
                    results.push((op(x, y), both));
                }
            }
            check_size(results.len() / 16)?;
        }
        Partition::collect(store, results)
    }

    /// Computes: if c then self else other.
    pub(in crate::symbolic) fn select(&self, store: &Store, c: &Bdd, other: &Partition) -> Result<Self> {
        let mut results = Vec::new();
        for (value, states) in &self.parts {
            results.push((Ok(value.clone()), store.and(states, c)?));
        }
        for (value, states) in &other.parts {
            results.push((Ok(value.clone()), store.minus(states, c)?));
        }
        Ok(Partition::collect(store, results)?.0)
    }

    /// Returns the values within a set of states.
    pub(in crate::symbolic) fn within(&self, store: &Store, states: &Bdd) -> Result<Self> {
        let mut parts = Vec::new();
        for (value, s) in &self.parts {
            let both = store.and(s, states)?;
            if !store.is_zero(&both) {
                parts.push((value.clone(), both));
            }
        }
        Ok(Partition { parts })
    }

    /// Returns the states whose value satisfies a condition.
    pub(in crate::symbolic) fn states_where(
        &self,
        store: &Store,
        holds: impl Fn(&Exact) -> bool,
    ) -> Result<Bdd> {
        store.any(self.parts.iter().filter(|(v, _)| holds(v)).map(|(_, s)| s.clone()))
    }

    /// Converts to a symbolic integer; every value must be an integer.
    pub(in crate::symbolic) fn to_bits(&self, store: &Store) -> Result<SymbolicInteger> {
        let values: Vec<(i64, &Bdd)> = self.parts.iter().map(|(v, s)| (int(v), s)).collect();
        let low = values.iter().map(|(v, _)| *v).min().unwrap_or(0);
        let high = values.iter().map(|(v, _)| *v).max().unwrap_or(0);
        let mut bits = Vec::new();
        for k in
            0..SymbolicInteger::constant(store, low).len().max(SymbolicInteger::constant(store, high).len())
        {
            let set = values.iter().filter(|(v, _)| v >> k.min(63) & 1 == 1);
            bits.push(store.any(set.map(|(_, s)| (*s).clone()))?);
        }
        Ok(SymbolicInteger::from_bits(bits, low, high))
    }

    /// Unites the states of equal values. The second result is the states without a value.
    fn collect(store: &Store, results: Vec<(Result<Exact, EvalError>, Bdd)>) -> Result<(Self, Bdd)> {
        let (mut order, mut sets, mut failed) = (Vec::new(), AHashMap::<Exact, Vec<Bdd>>::new(), Vec::new());
        for (result, states) in results {
            match result {
                Err(_) => failed.push(states),
                Ok(_) if store.is_zero(&states) => {}
                Ok(value) => sets
                    .entry(value)
                    .or_insert_with_key(|value| {
                        order.push(value.clone());
                        Vec::new()
                    })
                    .push(states),
            }
        }
        check_size(order.len())?;
        let mut parts = Vec::new();
        for value in order {
            let states = store.any(sets.remove(&value).unwrap_or_default())?;
            parts.push((value, states));
        }
        Ok((Partition { parts }, store.any(failed)?))
    }
}

fn int(value: &Exact) -> i64 {
    match value {
        Exact::Bool(b) => i64::from(*b),
        Exact::Int(i) => *i,
        Exact::Real(x) => x.to_f64() as i64,
    }
}

fn check_size(values: usize) -> Result<()> {
    if values <= MOST_VALUES {
        return Ok(());
    }
    let what = format!("an expression with more than {MOST_VALUES} different values over the states");
    Err(Limit::Size { what }.into())
}
