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
use super::relations::partial_relation::PartialRelation;
use super::relations::support::Support;
use super::store::diagram::Bdd;
use super::store::walk::Pass;
use super::{ChoiceSet, StateSet, SymbolicEngine};
use crate::engine::{Algebra, Engine};
use crate::settings::Count;
use meliora_base::error::Result;
use meliora_model::VarId;
use meliora_model::trend::{Digit, Trend};

/// A side of a game. A proof that it reaches a set needs one step at each of its states, and all steps
/// of the other side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// We; without an opponent all choices are ours.
    We,
    /// The opponent.
    Opponent,
}

/// The transitions of a piece that make each variable smaller, and those that make it greater.
struct Changes {
    piece: Piece,
    /// True if the other side chooses them.
    is_rival: bool,
    counts: Vec<(VarId, [Count; 2])>,
}

impl Changes {
    fn writes(&self, variable: VarId) -> bool {
        self.counts.iter().any(|(own, _)| *own == variable)
    }

    fn add_to(&self, totals: &mut [Totals]) {
        for (variable, [falling, rising]) in &self.counts {
            let [less, more] = totals[variable.index()].of(self.is_rival);
            *less += falling;
            *more += rising;
        }
    }

    fn take_from(&self, totals: &mut [Totals]) {
        for (variable, [falling, rising]) in &self.counts {
            let [less, more] = totals[variable.index()].of(self.is_rival);
            *less -= falling;
            *more -= rising;
        }
    }
}

/// The numbers of transitions of a side and of the other one that make a variable smaller, and greater.
#[derive(Clone, Default)]
struct Totals {
    own: [Count; 2],
    rival: [Count; 2],
}

impl Totals {
    fn of(&mut self, is_rival: bool) -> &mut [Count; 2] {
        if is_rival { &mut self.rival } else { &mut self.own }
    }

    /// Returns whether the other side changes the variable.
    fn has_rival(&self) -> bool {
        self.rival.iter().any(|count| !count.is_zero())
    }

    /// Returns true if more transitions rise than fall: of the other side, if it changes the variable.
    fn is_reversed(&self) -> bool {
        let [falling, rising] = if self.has_rival() { &self.rival } else { &self.own };
        rising > falling
    }

    /// Returns the numbers of falling and rising transitions, for the better direction.
    fn directed(of: &[Count; 2], is_reversed: bool) -> (&Count, &Count) {
        let [falling, rising] = of;
        if is_reversed { (rising, falling) } else { (falling, rising) }
    }

    /// Returns the rank of the variable as the next digit, the least one first.
    fn rank(&self) -> (&Count, &Count, Reverse<&Count>) {
        let [own, rival] = [&self.own, &self.rival].map(|of| Totals::directed(of, self.is_reversed()));
        (rival.1, own.1, Reverse(own.0))
    }

    /// Returns the variable as a digit.
    fn digit(&self, variable: VarId) -> Digit {
        let reversed = self.is_reversed();
        let steady = self.has_rival() || Totals::directed(&self.own, reversed).1.is_zero();
        Digit { reversed, steady, ..Digit::natural(variable) }
    }
}

fn has(support: &Support, bit: u32) -> bool {
    support.bits().binary_search(&bit).is_ok()
}

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
        // The lists of the opponent have all edges.
        let game =
            self.game.as_ref().map(|game| game.moved(&self.store, game.players.clone())).transpose()?;
        Ok(SymbolicEngine {
            game,
            groups: transitions.lists(&self.store, &self.lists)?,
            list: transitions.list(&self.store, &self.lists)?,
            transitions: Arc::new(transitions),
            has_loops: false,
            tuple: OnceLock::new(),
            quiet: OnceLock::new(),
            few_parts: OnceLock::new(),
            ..self.clone()
        })
    }

    /// Returns the pairs of present and next values of a support that have a trend.
    pub(super) fn has_trend(&self, order: &[Digit], support: &Support, trend: Trend) -> Result<Bdd> {
        let store = &self.store;
        let mut decided = store.zero();
        for digit in order.iter().rev() {
            if !digit.values.is_empty() {
                decided = self.decided_by(digit, support, trend, &decided)?;
                continue;
            }
            for &position in self.encoding.positions(digit.variable) {
                if has(support, position) {
                    let before = store.literal(2 * position, true)?;
                    let after = store.literal(2 * position + 1, true)?;
                    let (more, less) = if digit.lowers(trend) { (before, after) } else { (after, before) };
                    let greater = store.or(&more, &decided)?;
                    decided = store.ite(&less, &store.and(&more, &decided)?, &greater)?;
                }
            }
        }
        Ok(decided)
    }

    /// Returns the pairs of present and next values of a support that have a trend by a digit whose values have
    /// an order of their own, or keep it and are in `decided`.
    fn decided_by(&self, digit: &Digit, support: &Support, trend: Trend, decided: &Bdd) -> Result<Bdd> {
        let (store, bits) = (&self.store, self.encoding.positions(digit.variable));
        if !bits.iter().any(|bit| has(support, *bit)) {
            return Ok(decided.clone());
        }
        let mut order = digit.values.clone();
        if !digit.lowers(trend) {
            order.reverse();
        }
        // From the smallest digit on: a step leads to one of the values before.
        let (mut before, mut found) = (store.zero(), store.zero());
        for value in order {
            let mut next = store.one();
            for (index, &bit) in bits.iter().enumerate() {
                let level = 2 * bit + u32::from(has(support, bit));
                next = store.and(&next, &store.literal(level, value >> index & 1 == 1)?)?;
            }
            let kept = store.and(&next, decided)?;
            let now = self.encoding.value(store, digit.variable, value)?;
            found = store.or(&found, &store.and(&now, &store.or(&before, &kept)?)?)?;
            before = store.or(&before, &next)?;
        }
        Ok(found)
    }

    /// Returns an order of the variables in which many steps of a side fall, and nearly all steps of the
    /// other side do. Each digit is one that, of the transitions that keep all digits before it, the
    /// fewest of the other side make greater; of equals, the fewest of all. So a counter of rounds comes
    /// before the clocks that each round sets back, and the variable for the turn comes after those that
    /// the side itself changes, and before those that the other side does.
    ///
    /// A digit is steady if the other side changes it, or if no transition makes it greater.
    ///
    /// Cost: linear in the relations, for each pair of variables that one of them changes.
    ///
    /// # Errors
    /// A limit.
    pub fn falling_order(&self, side: Side) -> Result<Vec<Digit>> {
        let all = self.transitions.pieces.iter().map(|piece| self.changes(piece.clone(), side));
        let mut all = all.collect::<Result<Vec<_>>>()?;
        let mut left: Vec<VarId> = self.program.variable_ids().collect();
        let mut totals = vec![Totals::default(); left.len()];
        all.iter().for_each(|changes| changes.add_to(&mut totals));
        let mut order = Vec::new();
        while let Some(at) = (0..left.len()).min_by_key(|&at| totals[left[at].index()].rank()) {
            let variable = left.remove(at);
            order.push(totals[variable.index()].digit(variable));
            for changes in all.iter_mut().filter(|changes| changes.writes(variable)) {
                changes.take_from(&mut totals);
                let PartialRelation { relation, support } = &changes.piece.steps;
                let kept = self.keeping(variable, support)?;
                let steps =
                    PartialRelation { relation: self.store.and(relation, &kept)?, support: support.clone() };
                *changes = self.changes(Piece { group: changes.piece.group, steps }, side)?;
                changes.add_to(&mut totals);
            }
        }
        Ok(order)
    }

    /// Counts the transitions of a piece that change each variable.
    fn changes(&self, piece: Piece, side: Side) -> Result<Changes> {
        let mut counts = Vec::new();
        let support = &piece.steps.support;
        let written = |v: &VarId| self.encoding.positions(*v).iter().any(|bit| has(support, *bit));
        let is_empty = self.store.is_zero(&piece.steps.relation);
        for variable in self.program.variable_ids().filter(|v| !is_empty && written(v)) {
            let [falling, rising] = Trend::ALL.map(|trend| {
                let digit = Digit::natural(variable);
                let trend = self.has_trend(std::slice::from_ref(&digit), support, trend)?;
                let relation = self.store.and(&piece.steps.relation, &trend)?;
                let steps = PartialRelation { relation, support: support.clone() };
                self.count_piece(&Piece { group: piece.group, steps }, &self.choices.0[piece.group], None)
            });
            counts.push((variable, [falling?, rising?]));
        }
        let theirs = self.opponent().is_some_and(|opponent| opponent.has(piece.group));
        let is_rival = self.opponent().is_some() && theirs == (side == Side::We);
        Ok(Changes { piece, is_rival, counts })
    }

    /// Returns the pairs of present and next values of a support in which a variable has the same
    /// value.
    pub(super) fn keeping(&self, variable: VarId, support: &Support) -> Result<Bdd> {
        let mut kept = self.store.one();
        for &bit in self.encoding.positions(variable).iter().filter(|bit| has(support, **bit)) {
            let (before, after) =
                (self.store.literal(2 * bit, true)?, self.store.literal(2 * bit + 1, true)?);
            kept = self.store.and(&kept, &self.store.iff(&before, &after)?)?;
        }
        Ok(kept)
    }

    /// Computes μX. T ∪ { s' ∈ S : some s ∈ X has an edge into s' }.
    ///
    /// # Errors
    /// A limit, or the set belongs to another engine.
    pub fn reached_from(&self, start: &StateSet) -> Result<StateSet> {
        let (start, pass) = (self.diagram_of(start)?, Pass::forward("reachable states"));
        self.store.reach(pass, &self.list, start, &self.states.0).map(StateSet)
    }

    /// Returns the choices of `c` that have an edge; see [`SymbolicEngine::with_trend`].
    pub(super) fn with_edges(&self, c: &ChoiceSet) -> Result<ChoiceSet> {
        if self.has_loops {
            return Ok(c.clone());
        }
        let lists = self.groups.iter().zip(&*c.0);
        let moving = lists.map(|(list, own)| self.store.and(own, &list.sources(&self.store)?));
        let moving: Vec<Bdd> = moving.chain([Ok(self.store.zero())]).collect::<Result<_>>()?;
        Ok(ChoiceSet(Arc::new(moving)))
    }

    /// Returns the states in which a choice of `c` that has no edge keeps from moving: our states with
    /// such a choice, and the opponent's states that have no other choices.
    pub(super) fn without_edges(&self, c: &ChoiceSet) -> Result<Bdd> {
        if self.has_loops {
            return Ok(self.store.zero());
        }
        let moving = self.with_edges(c)?;
        let staying = self.sources(&self.difference(c, &moving)?)?;
        let Some(theirs) = self.opponent_states() else { return Ok(staying.0) };
        let moved = self.intersection(&theirs, &self.sources(&moving)?)?;
        Ok(self.difference(&staying, &moved)?.0)
    }
}
