//! Orders of variables, and of their values, in which each choice may make a state smaller.

use super::SymbolicEngine;
use super::relations::partial_relation::PartialRelation;
use super::store::diagram::Bdd;
use meliora_base::error::Result;
use meliora_model::VarId;
use meliora_model::trend::{Digit, Trend};

/// Maximum number of values of a variable whose values get an order of their own, as a manifest lists them.
const MOST_VALUES: u64 = 64;

/// The steps of the choices of a group.
type Group = Vec<PartialRelation>;

impl SymbolicEngine {
    /// Returns an order of the variables and their values in which each choice has a falling step, as far
    /// as the values of single variables show: each digit is one that, of the choices with no step that makes
    /// a digit before it smaller, each one that changes it may make it smaller. A machine that works, breaks
    /// and is repaired needs an order of the values for this: idle, then busy, then done, whatever
    /// their numbers are.
    ///
    /// Returns `None` if it finds none, or if the values need no order of their own.
    ///
    /// Cost: one quantification of a relation for each variable that it changes, and again whenever a digit
    /// takes choices from it.
    ///
    /// # Errors
    /// A limit.
    pub fn order_of_falling_choices(&self) -> Result<Option<Vec<Digit>>> {
        let mut groups: Vec<Group> = vec![Vec::new(); self.transitions.guards.len()];
        for piece in &self.transitions.pieces {
            groups[piece.group].push(piece.steps.clone());
        }
        // Each variable, and whether a choice that changes it was taken away since its last trial.
        let mut left: Vec<(VarId, bool)> = self.program.variable_ids().map(|v| (v, true)).collect();
        let mut order = Vec::new();
        while let Some(at) = left.iter().position(|(_, is_open)| *is_open) {
            left[at].1 = false;
            let variable = left[at].0;
            let Some(digit) = self.falling_digit(variable, &groups)? else { continue };
            left.remove(at);
            for group in &mut groups {
                let before = group.clone();
                self.keep_undecided(&digit, group)?;
                for steps in before.iter().zip(&*group).filter(|(old, new)| old != new).map(|(old, _)| old) {
                    left.iter_mut().for_each(|(other, is_open)| *is_open |= self.writes(steps, *other));
                }
            }
            order.push(digit);
        }
        Ok((left.is_empty() && order.iter().any(|digit| !digit.values.is_empty())).then_some(order))
    }

    fn writes(&self, steps: &PartialRelation, variable: VarId) -> bool {
        self.encoding.positions(variable).iter().any(|bit| steps.support.bits().binary_search(bit).is_ok())
    }

    /// Returns a variable as a digit that each choice that changes it may make smaller, if it can be one.
    fn falling_digit(&self, variable: VarId, groups: &[Group]) -> Result<Option<Digit>> {
        let mut moves = Vec::new();
        for group in groups {
            let written = group.iter().filter(|steps| self.writes(steps, variable));
            let own = written.map(|steps| self.moves(variable, steps)).collect::<Result<Group>>()?;
            moves.extend((!own.is_empty()).then_some(own));
        }
        for reversed in [false, true] {
            let digit = Digit { reversed, ..Digit::natural(variable) };
            let mut falls = true;
            for PartialRelation { support, relation } in moves.iter().flatten() {
                let falling = self.has_trend(std::slice::from_ref(&digit), support, Trend::Falling)?;
                falls &= self.store.is_zero(&self.store.minus(relation, &falling)?);
            }
            if falls {
                return Ok(Some(digit));
            }
        }
        Ok(self.settled(variable, &moves)?.map(|values| Digit { values, ..Digit::natural(variable) }))
    }

    /// Returns the pairs of values of a variable between which some steps move.
    fn moves(&self, variable: VarId, steps: &PartialRelation) -> Result<PartialRelation> {
        let (store, own) = (&self.store, self.encoding.positions(variable));
        let moving = store.minus(&steps.relation, &self.keeping(variable, &steps.support)?)?;
        let mut others = store.one();
        // From the last level up, so that each conjunction only adds nodes on top.
        for bit in (0..self.encoding.width() as u32).rev().filter(|bit| !own.contains(bit)) {
            if steps.support.bits().binary_search(&bit).is_ok() {
                others = store.and(&store.literal(2 * bit + 1, true)?, &others)?;
            }
            others = store.and(&store.literal(2 * bit, true)?, &others)?;
        }
        Ok(PartialRelation { relation: store.exists(&moving, &others)?, support: steps.support.clone() })
    }

    /// Returns the values of a variable in an order in which each group that moves from a value may move to
    /// one before it, if there is one.
    fn settled(&self, variable: VarId, moves: &[Group]) -> Result<Option<Vec<u64>>> {
        let (store, own) = (&self.store, &self.program.variables[variable.index()]);
        let last = own.high.wrapping_sub(own.low) as u64;
        if last >= MOST_VALUES {
            return Ok(None);
        }
        let values = (0..=last).map(|value| self.encoding.value(store, variable, value));
        let values = values.collect::<Result<Vec<Bdd>>>()?;
        let (mut settled, mut order) = (store.zero(), Vec::new());
        while order.len() < values.len() {
            let mut blocked = settled.clone();
            for group in moves {
                let moving = self.sources_of(group, None)?;
                let falling = self.sources_of(group, Some(&settled))?;
                blocked = store.or(&blocked, &store.minus(&moving, &falling)?)?;
            }
            let before = order.len();
            for (value, states) in (0..).zip(&values) {
                if store.is_zero(&store.and(states, &blocked)?) {
                    order.push(value);
                    settled = store.or(&settled, states)?;
                }
            }
            if order.len() == before {
                return Ok(None);
            }
        }
        Ok(Some(order))
    }

    /// Returns the states in which a group has a step, into some states if they are given.
    fn sources_of(&self, group: &Group, into: Option<&Bdd>) -> Result<Bdd> {
        let store = &self.store;
        let mut all = store.zero();
        for steps in group {
            let mut steps = steps.clone();
            if let Some(into) = into {
                steps.relation = store.and(&steps.relation, &store.primed(&steps.support, into)?)?;
            }
            all = store.or(&all, &steps.sources(store)?)?;
        }
        Ok(all)
    }

    /// Keeps the choices of a group that have no step which makes a digit smaller, and of their steps those
    /// that keep the digit.
    fn keep_undecided(&self, digit: &Digit, group: &mut Group) -> Result<()> {
        let store = &self.store;
        let mut falling = Vec::new();
        for steps in group.iter().filter(|steps| self.writes(steps, digit.variable)) {
            let mut steps = steps.clone();
            let has_trend = self.has_trend(std::slice::from_ref(digit), &steps.support, Trend::Falling)?;
            steps.relation = store.and(&steps.relation, &has_trend)?;
            falling.push(steps);
        }
        if falling.is_empty() {
            return Ok(());
        }
        let decided = self.sources_of(&falling, None)?;
        for steps in group {
            let kept = self.keeping(digit.variable, &steps.support)?;
            steps.relation = store.minus(&store.and(&steps.relation, &kept)?, &decided)?;
        }
        Ok(())
    }
}
