//! One command as a partial relation, with the states in which it has no meaning.

use std::cell::RefCell;

use super::Encoding;
use super::partition::Partition;
use super::symbolic_integer::SymbolicInteger;
use super::translate::Translator;
use crate::symbolic::relations::partial_relation::PartialRelation;
use crate::symbolic::store::Store;
use crate::symbolic::store::diagram::Bdd;
use meliora_base::error::Result;
use meliora_base::exact::{self, Exact, Real};
use meliora_base::rounding::{Sum, is_weight};
use meliora_base::value::Binary;
use meliora_model::{Branch, Command, VarId};

/// A command over the bits.
pub(in crate::symbolic) struct CommandRelation {
    /// The states in which the command is enabled.
    pub(in crate::symbolic) guard: Bdd,
    /// guard ∧ the union of the effects of all branches of positive probability. Its support is the
    /// variables that some branch writes.
    pub(in crate::symbolic) steps: PartialRelation,
    /// The states of the guard in which an update leaves its range or has no value.
    pub(in crate::symbolic) bad_update: Bdd,
}

/// Builds the relations of commands.
pub(in crate::symbolic) struct CommandBuilder<'a> {
    pub(in crate::symbolic) store: &'a Store,
    pub(in crate::symbolic) encoding: &'a Encoding,
    pub(in crate::symbolic) translator: &'a Translator<'a>,
    /// The states in which the commands built so far have probabilities that were rounded.
    pub(in crate::symbolic) rounded: RefCell<Bdd>,
}

impl CommandBuilder<'_> {
    /// Returns the relation of a command, and the states in which the guard has no value or the
    /// probabilities are not a distribution.
    pub(in crate::symbolic) fn build(&self, command: &Command) -> Result<(CommandRelation, Bdd)> {
        let (guard, fails) = self.translator.condition(command.guard)?;
        let guard = self.store.and(&guard, &self.within(command)?)?;
        let mut writes: Vec<VarId> =
            command.branches.iter().flat_map(|b| b.updates.iter().map(|(v, _)| *v)).collect();
        writes.sort_unstable();
        writes.dedup();
        let (taken, wrong) = self.probabilities(command, &guard)?;
        let (mut relations, mut bad) = (Vec::new(), Vec::new());
        for (branch, states) in command.branches.iter().zip(&taken) {
            if self.store.is_zero(states) {
                continue;
            }
            let (relation, bad_states) = self.effect(branch, states, &writes)?;
            relations.push(relation);
            bad.push(bad_states);
        }
        let steps = PartialRelation {
            support: self.encoding.support_of(&writes),
            relation: self.store.any(relations)?,
        };
        let bad_update = self.store.any(bad)?;
        Ok((CommandRelation { guard, steps, bad_update }, self.store.or(&fails, &wrong)?))
    }

    /// Returns the bit patterns that are values of the variables that the command reads. Other
    /// variables are not restricted: a relation should depend on as few bits as possible.
    fn within(&self, command: &Command) -> Result<Bdd> {
        let updates = command.branches.iter().flat_map(|b| b.updates.iter().map(|(_, e)| *e));
        let read = command.branches.iter().map(|b| b.probability).chain(updates);
        [command.guard]
            .into_iter()
            .chain(read)
            .try_fold(self.store.one(), |all, e| self.store.and(&all, &self.translator.within(e)?))
    }

    /// Returns for each branch the states of the guard in which its probability is positive. The
    /// second result is the states of the guard in which the probabilities are not a distribution.
    fn probabilities(&self, command: &Command, guard: &Bdd) -> Result<(Vec<Bdd>, Bdd)> {
        let store = self.store;
        let mut wrong = Vec::new();
        let mut taken = Vec::new();
        let mut sum = Partition::constant(store, Exact::Real(Real::from(0))).within(store, guard)?;
        for branch in &command.branches {
            let (p, fails) = self.translator.values(branch.probability)?;
            let p = p.within(store, guard)?;
            wrong.push(store.and(&fails, guard)?);
            wrong.push(p.states_where(store, |v| !is_weight(&real(v)))?);
            taken.push(p.states_where(store, |v| !real(v).is_zero())?);
            let (next, fails) = sum.combine(store, &p, |x, y| exact::binary(Binary::Add, x, y))?;
            wrong.push(fails);
            sum = next;
        }
        wrong.push(sum.states_where(store, |v| Sum::judge(&real(v)) == Sum::Wrong)?);
        let rounded = sum.states_where(store, |v| Sum::judge(&real(v)) == Sum::Rounded)?;
        let before = self.rounded.borrow().clone();
        self.rounded.replace(store.or(&before, &rounded)?);
        Ok((taken, store.any(wrong)?))
    }

    /// Returns the effect of one branch on the written variables, and the states in which an update
    /// has no value in range.
    fn effect(&self, branch: &Branch, states: &Bdd, writes: &[VarId]) -> Result<(Bdd, Bdd)> {
        let store = self.store;
        let mut bad = Vec::new();
        // Position and new value of each written bit.
        let mut next: Vec<(u32, Bdd)> = Vec::new();
        for &variable in writes {
            let positions = self.encoding.positions(variable);
            match branch.updates.iter().find(|(v, _)| *v == variable) {
                None => {
                    for &p in positions {
                        next.push((p, store.literal(2 * p, true)?));
                    }
                }
                Some((_, e)) => {
                    let (offset, wrong) = self.offset(variable, *e)?;
                    bad.push(store.and(states, &wrong)?);
                    next.extend(positions.iter().enumerate().map(|(k, &p)| (p, offset.bit(k).clone())));
                }
            }
        }
        let bad = store.any(bad)?;
        // From the last level up, so that each conjunction only adds nodes on top.
        next.sort_by_key(|(p, _)| std::cmp::Reverse(*p));
        let mut relation = store.one();
        for (p, value) in next {
            let equal = store.iff(&store.literal(2 * p + 1, true)?, &value)?;
            relation = store.and(&equal, &relation)?;
        }
        let relation = store.and(&store.minus(states, &bad)?, &relation)?;
        Ok((relation, bad))
    }

    /// Returns the new value minus the smallest value of the variable, and the states in which it
    /// is out of range or undefined.
    fn offset(&self, variable: VarId, e: meliora_model::expr::ExprId) -> Result<(SymbolicInteger, Bdd)> {
        let store = self.store;
        let declared = &self.encoding.variables()[variable.index()];
        let (value, fails) = self.translator.integer(e)?;
        let below = value.lt(store, &SymbolicInteger::constant(store, declared.low))?;
        let above = SymbolicInteger::constant(store, declared.high).lt(store, &value)?;
        let wrong = store.any([fails, below, above])?;
        let shifted = match SymbolicInteger::constant(store, declared.low).neg(store)? {
            Some(minus) => value.add(store, &minus)?,
            None => None,
        };
        Ok((shifted.unwrap_or(value), wrong))
    }
}

fn real(value: &Exact) -> Real {
    value.clone().into_real()
}
