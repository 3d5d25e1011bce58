//! Engines with only the edges that make a state smaller, or only those that make it greater.
//!
//! A state is read as a number: its variables in some order are the digits, the first one most
//! significant, and in some of them a greater value makes the number smaller. A path of
//! falling edges never returns to a state, so a proof by falling edges needs no distances: if every
//! state of X has a falling edge into X ∪ Y, then from every state of X there is a path into Y.

use std::cmp::Reverse;
use std::sync::{Arc, OnceLock};

use num_traits::Zero;

use super::encoding::transitions::Piece;
use super::fixpoints::clusters::Clusters;
use super::relations::partial_relation::PartialRelation;
use super::relations::support::Support;
use super::store::diagram::Bdd;
use super::{ChoiceSet, StateSet, SymbolicEngine};
use crate::settings::Count;
use meliora_model::VarId;
use meliora_model::error::Result;
use meliora_model::trend::{Digit, Trend};

impl SymbolicEngine {
    /// Returns an engine of the same states and choices that has only the edges s → s' with s' < s
    /// (falling) or s' > s (rising), where the first variable of `order` in which s and s' differ
    /// decides. Edges that change no variable of `order` are left out. The engines share their
    /// sets.
    ///
    /// Here a choice may have no edge. Cost: linear in the relations.
    ///
    /// # Errors
    /// A limit.
    pub fn with_trend(&self, order: &[Digit], trend: Trend) -> Result<Self> {
        let mut transitions = (*self.transitions).clone();
        for Piece { steps, .. } in &mut transitions.pieces {
            let has_trend = self.has_trend(order, &steps.support, trend)?;
            steps.relation = self.store.and(&steps.relation, &has_trend)?;
        }
        transitions.pieces.retain(|piece| !self.store.is_zero(&piece.steps.relation));
        Ok(SymbolicEngine {
            groups: transitions.lists(&self.store, &self.lists)?,
            clusters: Arc::new(Clusters::new(&self.store, &self.lists, &transitions.pieces)?),
            transitions: Arc::new(transitions),
            has_loops: false,
            tuple: OnceLock::new(),
            few_parts: OnceLock::new(),
            reaching: Arc::default(),
            workers: Default::default(),
            ..self.clone()
        })
    }

    /// Returns the pairs of present and next values of a support in which the next ones are less,
    /// or greater.
    fn has_trend(&self, order: &[Digit], support: &Support, trend: Trend) -> Result<Bdd> {
        let store = &self.store;
        let mut decided = store.zero();
        for &Digit { variable, reversed } in order.iter().rev() {
            for &position in self.encoding.positions(variable) {
                if support.bits().binary_search(&position).is_ok() {
                    let before = store.literal(2 * position, true)?;
                    let after = store.literal(2 * position + 1, true)?;
                    let lowers = (trend == Trend::Falling) != reversed;
                    let (more, less) = if lowers { (before, after) } else { (after, before) };
                    let greater = store.or(&more, &decided)?;
                    decided = store.ite(&less, &store.and(&more, &decided)?, &greater)?;
                }
            }
        }
        Ok(decided)
    }

    /// Returns an order of the variables in which many edges fall. Most transitions that change a
    /// variable make its digit smaller. The fewer make it greater, the more significant it is; of
    /// equals, the one that more transitions make smaller.
    ///
    /// Cost: linear in the relations, for each variable that they change.
    ///
    /// # Errors
    /// A limit.
    pub fn falling_order(&self) -> Result<Vec<Digit>> {
        let mut all = Vec::new();
        for index in 0..self.encoding.variables().len() as u32 {
            let variable = VarId(index);
            let [falling, rising] = Trend::ALL.map(|trend| self.count_trend(variable, trend));
            let (falling, rising) = (falling?, rising?);
            let reversed = rising > falling;
            let (most, least) = if reversed { (rising, falling) } else { (falling, rising) };
            all.push((least, Reverse(most), Digit { variable, reversed }));
        }
        all.sort_by(|a, b| (&a.0, &a.1).cmp(&(&b.0, &b.1)));
        Ok(all.into_iter().map(|(_, _, digit)| digit).collect())
    }

    /// Returns the number of transitions that lower or raise a variable.
    fn count_trend(&self, variable: VarId, trend: Trend) -> Result<Count> {
        let own = Support::new(self.encoding.positions(variable).iter().copied());
        let mut total = Count::zero();
        for Piece { group, steps } in &self.transitions.pieces {
            let changed = own.bits().iter().any(|bit| steps.support.bits().binary_search(bit).is_ok());
            if changed {
                let has_trend =
                    self.has_trend(&[Digit { variable, reversed: false }], &steps.support, trend)?;
                let relation = self.store.and(&steps.relation, &has_trend)?;
                let steps = PartialRelation { relation, support: steps.support.clone() };
                let piece = Piece { group: *group, steps };
                total += self.count_piece(&piece, &self.choices.0[*group], None)?;
            }
        }
        Ok(total)
    }

    /// Computes μX. T ∪ { s' ∈ S : some s ∈ X has an edge into s' }.
    ///
    /// # Errors
    /// A limit, or the set belongs to another engine.
    pub fn reached_from(&self, start: &StateSet) -> Result<StateSet> {
        let start = self.diagram_of(start)?;
        let found = self.clusters.forward(&self.store, start, &self.states.0, None)?;
        found.map(StateSet).ok_or_else(|| self.store.full())
    }

    /// Returns the states with a choice of `c` that has no edge at all; see
    /// [`SymbolicEngine::with_trend`].
    pub(super) fn without_edges(&self, c: &ChoiceSet) -> Result<Bdd> {
        let mut found = Vec::new();
        if !self.has_loops {
            for (list, own) in self.groups.iter().zip(&*c.0) {
                found.push(self.store.minus(own, &list.sources(&self.store)?)?);
            }
        }
        self.store.any(found)
    }
}
