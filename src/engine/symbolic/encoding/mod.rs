//! The encoding of states as bits: an integer is its distance from the smallest value, with the
//! most significant bit nearest to the root if the order is as declared.
//!
//! Commands are translated to partial relations: `translate` evaluates expressions on all states at
//! once, `command` builds the relation of a command, and `transitions` combines commands to groups
//! of choices.

pub(in crate::symbolic) mod command;
mod partition;
mod symbolic_integer;
pub(in crate::symbolic) mod transitions;
pub(in crate::symbolic) mod translate;

use crate::symbolic::order::Bit;
use crate::symbolic::relations::support::Support;
use crate::symbolic::store::Store;
use crate::symbolic::store::diagram::Bdd;
use meliora_base::error::Result;
use meliora_base::value::Type;
use meliora_model::{Program, State, VarId, Variable};

/// The position of every bit in the order of the diagram.
#[derive(Debug, Clone)]
pub struct Encoding {
    variables: Vec<Variable>,
    order: Vec<Bit>,
    /// For each variable the positions of its bits, least significant first.
    positions: Vec<Vec<u32>>,
    /// The reason for the order, if it was found.
    why: Option<String>,
}

impl Encoding {
    /// Creates the encoding with the bits in the given order, from the root down. The order must
    /// have every bit once.
    pub fn new(program: &Program, order: Vec<Bit>) -> Self {
        let variables = program.variables.clone();
        let mut positions: Vec<Vec<u32>> = variables.iter().map(|v| vec![0; v.bits() as usize]).collect();
        for (position, bit) in order.iter().enumerate() {
            positions[bit.variable.index()][bit.index as usize] = position as u32;
        }
        Encoding { variables, order, positions, why: None }
    }

    /// Returns the reason for the order, in words, if [`Order::Auto`](crate::Order::Auto) has taken it.
    pub fn why(&self) -> Option<&str> {
        self.why.as_deref()
    }

    pub(in crate::symbolic) fn set_why(&mut self, why: &str) {
        self.why = Some(why.to_owned());
    }

    /// Returns the number of bits of a state.
    pub fn width(&self) -> usize {
        self.order.len()
    }

    /// Returns the bits from the root down.
    pub fn order(&self) -> &[Bit] {
        &self.order
    }

    /// Returns the names of the bits from the root down: `x.2` for bit 2 of x, Booleans by their
    /// name.
    pub fn names(&self) -> Vec<String> {
        let name = |bit: &Bit| {
            let variable = &self.variables[bit.variable.index()];
            if variable.ty == Type::Bool {
                variable.name.clone()
            } else {
                format!("{}.{}", variable.name, bit.index)
            }
        };
        self.order.iter().map(name).collect()
    }

    /// Returns the variables with their ranges.
    pub fn variables(&self) -> &[Variable] {
        &self.variables
    }

    /// Returns the positions of the bits of a variable, least significant first.
    pub(in crate::symbolic) fn positions(&self, variable: VarId) -> &[u32] {
        &self.positions[variable.index()]
    }

    /// Returns the conjunction of the bits of some variables, for quantification.
    pub(in crate::symbolic) fn bits_of(&self, store: &Store, variables: &[VarId]) -> Result<Bdd> {
        let mut bits = store.one();
        // From the last level up, so that each conjunction only adds nodes on top.
        for &position in self.support_of(variables).bits().iter().rev() {
            bits = store.and(&store.literal(2 * position, true)?, &bits)?;
        }
        Ok(bits)
    }

    /// Returns the set of the bits of some variables.
    pub(in crate::symbolic) fn support_of(&self, variables: &[VarId]) -> Support {
        let bits = variables.iter().flat_map(|v| self.positions[v.index()].iter().copied());
        Support::new(bits)
    }

    /// Returns the bit patterns that are values: every variable is within its range.
    pub(in crate::symbolic) fn domain(&self, store: &Store) -> Result<Bdd> {
        let mut variables: Vec<VarId> = (0..self.variables.len() as u32).map(VarId).collect();
        // From the last level up, so that each conjunction only adds nodes on top.
        variables.sort_by_key(|v| std::cmp::Reverse(self.positions(*v).first().copied()));
        variables.into_iter().try_fold(store.one(), |all, v| store.and(&self.values_of(store, v)?, &all))
    }

    /// Returns the bit patterns in which one variable is within its range.
    pub(in crate::symbolic) fn values_of(&self, store: &Store, variable: VarId) -> Result<Bdd> {
        let Variable { low, high, .. } = self.variables[variable.index()];
        self.at_most(store, variable.index(), high.wrapping_sub(low) as u64)
    }

    /// Returns the bit patterns in which a variable has the value `low + offset`.
    pub(in crate::symbolic) fn value(&self, store: &Store, variable: VarId, offset: u64) -> Result<Bdd> {
        let mut value = store.one();
        for (index, &position) in self.positions(variable).iter().enumerate() {
            value = store.and(&store.literal(2 * position, offset >> index & 1 == 1)?, &value)?;
        }
        Ok(value)
    }

    /// Computes value - low ≤ largest.
    fn at_most(&self, store: &Store, variable: usize, largest: u64) -> Result<Bdd> {
        let mut below = store.one();
        for (index, &position) in self.positions[variable].iter().enumerate() {
            let bit = store.literal(2 * position, true)?;
            below = if largest >> index & 1 == 1 {
                store.ite(&bit, &below, &store.one())?
            } else {
                store.ite(&bit, &store.zero(), &below)?
            };
        }
        Ok(below)
    }

    /// Returns the set of one state.
    pub(in crate::symbolic) fn state(&self, store: &Store, state: &[i64]) -> Result<Bdd> {
        let mut cube = store.one();
        for (position, bit) in self.order.iter().enumerate().rev() {
            let variable = bit.variable.index();
            let offset = state[variable].wrapping_sub(self.variables[variable].low) as u64;
            let literal = store.literal(2 * position as u32, offset >> bit.index & 1 == 1)?;
            cube = store.and(&literal, &cube)?;
        }
        Ok(cube)
    }

    /// Returns true if every value of `state` lies in the range of its variable.
    pub(in crate::symbolic) fn is_valid(&self, state: &[i64]) -> bool {
        state.len() == self.variables.len()
            && self.variables.iter().zip(state).all(|(v, x)| (v.low..=v.high).contains(x))
    }

    /// Returns the value of the bit at `position` in `state`.
    pub(in crate::symbolic) fn bit_of(&self, state: &[i64], position: usize) -> bool {
        let bit = self.order[position];
        let variable = bit.variable.index();
        let offset = state[variable].wrapping_sub(self.variables[variable].low) as u64;
        offset >> bit.index & 1 == 1
    }

    /// Returns the state of a bit pattern: one value per bit, in the order of the diagram.
    pub fn decode(&self, pattern: &[bool]) -> State {
        let mut state: State = self.variables.iter().map(|v| v.low).collect();
        for (bit, _) in self.order.iter().zip(pattern).filter(|(_, set)| **set) {
            state[bit.variable.index()] += 1i64 << bit.index;
        }
        state
    }
}
