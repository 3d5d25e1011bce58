//! The improvement MDP on sets: kept choices, and edges that improve or are dropped.
//!
//! In the paper's V = S × {0,1} the bit says whether the last step improved. (s,0) and (s,1) have
//! the same choices, so everything is computed over S with improving steps as goal *edges*; only
//! [`Sizes`] refers to V.

use std::sync::OnceLock;

use serde::Serialize;

use super::classes::{Class, Classes};
use super::safety::Safety;
use meliora_base::error::Result;
use meliora_engine::edge_labels::{dropped, grouped, pairs_into};
use meliora_engine::{Count, EdgeLabels, Engine, Region, position};
use meliora_model::valuation::{Decimal, decimal};

/// An arena: the kept choices and the edges of one class (under `prefix`) or of all states.
pub struct Arena<E: Engine> {
    /// The class that steps are compared with, by its position in [`Classes::list`]; `None` if each
    /// step is compared with the state it leaves.
    pub reference: Option<usize>,
    /// The states of the arena.
    pub states: E::States,
    /// The kept choices of these states; each has at least one successor that is not dropped.
    pub choices: E::Choices,
    /// The edge labels: edges into `goal` improve; `dropped` is empty except under
    /// [`Safety::Transition`]. Together the labels cover `states`.
    pub edge_labels: Vec<EdgeLabels<E::States>>,
    /// The first arena with the same states, choices and edge labels, by its position in
    /// [`Improvement::arenas`], if it is another one. Its levels are those of this arena.
    pub twin: Option<usize>,
    /// The states from which an improvement is possible, once a search has found them.
    pub(crate) possible: OnceLock<E::States>,
}

impl<E: Engine> Arena<E> {
    fn new(
        reference: Option<usize>,
        states: E::States,
        choices: E::Choices,
        edge_labels: Vec<EdgeLabels<E::States>>,
    ) -> Self {
        Arena { reference, states, choices, edge_labels, twin: None, possible: OnceLock::new() }
    }
}

impl<E: Engine> Clone for Arena<E> {
    fn clone(&self) -> Self {
        Arena {
            twin: self.twin,
            possible: self.possible.clone(),
            reference: self.reference,
            states: self.states.clone(),
            choices: self.choices.clone(),
            edge_labels: self.edge_labels.clone(),
        }
    }
}

/// The size of the improvement MDP.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct Sizes {
    /// |V| = 2 |S|: twice the states of the scope, without unsafe ones.
    #[serde(serialize_with = "decimal")]
    #[schemars(with = "Decimal")]
    pub states: Count,
    /// The kept transitions over V: twice those of the model.
    #[serde(serialize_with = "decimal")]
    #[schemars(with = "Decimal")]
    pub transitions: Count,
    /// The transitions that the requirements leave and the safety mode does not keep, counted once.
    #[serde(serialize_with = "decimal")]
    #[schemars(with = "Decimal")]
    pub dropped: Count,
}

/// The improvement MDP under one safety mode.
pub struct Improvement<E: Engine> {
    /// The safety mode.
    pub safety: Safety,
    /// One arena; under [`Safety::Prefix`] one per class with a safe state.
    pub arenas: Vec<Arena<E>>,
    /// The bad states of a game under [`Safety::Action`]: those of the opponent in which no choice is kept,
    /// because one of them may weaken, or may lead to a bad state. `None` for other models and modes.
    pub bad: Option<E::States>,
    /// In a game under [`Safety::Prefix`], Safe_c of each class c of which no state is safe, by the
    /// position of the class. Planning starts in none of its states, but the opponent may move there.
    pub unsafe_classes: Vec<(usize, E::States)>,
}

impl<E: Engine> Improvement<E> {
    /// Computes the arenas of the improvement MDP under `safety`. Cost: one pre-image per class
    /// with distinct Worse(c); under `prefix` one `stay_within` per class.
    pub fn new(engine: &E, classes: &Classes<E>, safety: Safety) -> Result<Self> {
        let (mut arenas, mut unsafe_classes) = (Vec::new(), Vec::new());
        for arena in safety.arenas(engine, classes)? {
            match unsafe_class(engine, classes, &arena)? {
                None => arenas.push(Arena { twin: twin(classes, &arenas, &arena), ..arena }),
                Some(class) if engine.is_game() => unsafe_classes.push((class, arena.states)),
                Some(_) => {}
            }
        }
        let bad =
            if engine.is_game() && !safety.has_reference() { Some(bad(engine, &arenas)?) } else { None };
        Ok(Improvement { safety, arenas, bad, unsafe_classes })
    }

    /// Returns the position of the arena in which planning starts in a state of a class. `None` if no
    /// state of the class is safe, and for states without a class: those outside of the scope, and
    /// unsafe ones.
    pub fn arena_of(&self, class: Option<usize>) -> Option<usize> {
        let class = class?;
        self.arenas.iter().position(|arena| arena.reference.is_none_or(|own| own == class))
    }

    /// Computes the size of the improvement MDP, given the number of all transitions if it is known;
    /// `None` under `prefix`, which has one arena per class. Cost: counting, no image.
    pub(crate) fn sizes(&self, engine: &E, transitions: Option<&Count>) -> Result<Option<Sizes>> {
        let (Some(arena), false) = (self.arenas.first(), self.safety.has_reference()) else {
            return Ok(None);
        };
        let all = engine.all_states();
        let total = match transitions {
            Some(known) => known.clone(),
            None => engine.count_transitions(&engine.all_choices(), &all)?,
        };
        // Most choices are kept, so the others are counted.
        let gone = engine.difference(&engine.all_choices(), &arena.choices)?;
        let mut lost = engine.count_transitions(&gone, &all)?;
        for (from, into) in &dropped(engine, &arena.edge_labels)? {
            // The dropped edges of kept choices; choices without a kept successor are not in
            // `arena.choices`.
            lost += engine.count_transitions(&engine.choices_in(&arena.choices, from)?, into)?;
        }
        let states = engine.count(&all)? * 2u32;
        Ok(Some(Sizes { states, transitions: (total - &lost) * 2u32, dropped: lost }))
    }
}

/// Returns the first of some arenas that equals another one, because steps from both reference classes
/// have the same effects.
fn twin<E: Engine>(classes: &Classes<E>, arenas: &[Arena<E>], arena: &Arena<E>) -> Option<usize> {
    let changes = |arena: &Arena<E>| arena.reference.and_then(|c| Some(&classes.list.get(c)?.changes));
    let own = changes(arena)?;
    arenas.iter().position(|other| changes(other) == Some(own))
}

/// Returns the reference class of an arena if no state of the class is in it.
fn unsafe_class<E: Engine>(engine: &E, classes: &Classes<E>, arena: &Arena<E>) -> Result<Option<usize>> {
    let Some(class) = arena.reference else { return Ok(None) };
    let own = engine.intersection(&arena.states, &classes.list[class].states)?;
    Ok(engine.is_empty(&own)?.then_some(class))
}

/// Computes the arena under [`Safety::Action`]: all enabled choices minus ⋃ over c of [c] ∩
/// pre(Worse(c)); in a game, without those that may step into a state where the opponent can weaken.
pub(crate) fn action<E: Engine>(engine: &E, classes: &Classes<E>) -> Result<Arena<E>> {
    let weakening = pairs_into(engine, &engine.all_choices(), by_worse(classes))?;
    let choices = engine.difference(&engine.all_choices(), &weakening)?;
    let choices = without_bad_states(engine, choices)?;
    Ok(Arena::new(None, engine.all_states(), choices, edge_labels(engine, classes, Worse::Barred)?))
}

/// Removes the choices of the opponent's bad states, and those that may step into one. A state of the
/// opponent is bad if one of its choices is not in C, or has a bad successor. Cost: one removal of an
/// attractor.
fn without_bad_states<E: Engine>(engine: &E, c: E::Choices) -> Result<E::Choices> {
    let Some(theirs) = engine.theirs() else { return Ok(c) };
    let bad = engine.difference(
        &engine.intersection(&theirs, &engine.sources(&engine.all_choices())?)?,
        &engine.can_choose(&c)?,
    )?;
    if engine.is_empty(&bad)? {
        return Ok(c);
    }
    let ours = engine.difference(&engine.all_states(), &theirs)?;
    let left = Region { states: engine.difference(&engine.all_states(), &bad)?, choices: c.clone() };
    let Region { states, choices } = engine.remove_attractor(left, &c, &ours, &[], bad)?;
    engine.choices_in(&choices, &states)
}

/// Returns the states of the opponent in which no choice is kept.
fn bad<E: Engine>(engine: &E, arenas: &[Arena<E>]) -> Result<E::States> {
    let (Some(arena), Some(theirs)) = (arenas.first(), engine.theirs()) else {
        return Ok(engine.no_states());
    };
    let theirs = engine.intersection(&theirs, &engine.all_states())?;
    engine.difference(&theirs, &engine.sources(&arena.choices)?)
}

/// Computes the arena under [`Safety::Transition`]: all enabled choices minus ⋃ over c of [c] ∩
/// pre_within(Worse(c)), without the edges from [c] into Worse(c).
pub(crate) fn transition<E: Engine>(engine: &E, classes: &Classes<E>) -> Result<Arena<E>> {
    let mut choices = engine.all_choices();
    for (from, worse) in &grouped(engine, by_worse(classes))? {
        let emptied = engine.choices_in(&engine.pre_within(&engine.all_choices(), worse)?, from)?;
        choices = engine.difference(&choices, &emptied)?;
    }
    let edge_labels = edge_labels(engine, classes, Worse::Dropped)?;
    Ok(Arena::new(None, engine.all_states(), choices, edge_labels))
}

/// Safe_c with the choices that stay in it.
type Safe<E> = Region<<E as Engine>::States, <E as Engine>::Choices>;

/// Computes the arenas under [`Safety::Prefix`]: for each class c, Safe_c = νZ. S \ Worse(c) ∩ { s
/// : some choice has all successors in Z }.
///
/// Worse(c) ⊆ Worse(d) implies Safe_d ⊆ Safe_c, so the search for Safe_d starts in Safe_c. Cost: one
/// `stay_within` per class with distinct Worse(c).
pub(crate) fn prefix<E: Engine>(engine: &E, classes: &Classes<E>) -> Result<Vec<Arena<E>>> {
    let mut order = Vec::from_iter(0..classes.list.len());
    order.sort_by_cached_key(|&class| classes.list[class].weakened_by());
    let mut known: Vec<(&Class<E>, Safe<E>)> = Vec::new();
    let mut arenas = Vec::with_capacity(order.len());
    for reference in order {
        let class = &classes.list[reference];
        let wider = known.iter().rev().find(|(wider, _)| wider.is_weakened_within(class));
        let safe = match wider {
            Some((equal, safe)) if class.is_weakened_within(equal) => safe.clone(),
            _ => {
                let wider = wider.map(|(_, safe)| safe);
                let safe = safe_states(engine, class, wider)?;
                known.push((class, safe.clone()));
                safe
            }
        };
        let goal = engine.intersection(&class.better, &safe.states)?;
        let edge_labels = vec![EdgeLabels::new(safe.states.clone(), goal, engine.no_states())];
        let Region { states, choices } = safe;
        arenas.push(Arena::new(Some(reference), states, choices, edge_labels));
    }
    arenas.sort_by_key(|arena| arena.reference);
    Ok(arenas)
}

/// Computes Safe_c, given Safe of a class that fewer classes weaken. Cost: one `stay_within`.
fn safe_states<E: Engine>(engine: &E, class: &Class<E>, wider: Option<&Safe<E>>) -> Result<Safe<E>> {
    let (states, choices) = match wider {
        Some(wider) => (wider.states.clone(), wider.choices.clone()),
        None => (engine.all_states(), engine.all_choices()),
    };
    engine.stay_within(&engine.difference(&states, &class.worse)?, &choices)
}

fn by_worse<E: Engine>(classes: &Classes<E>) -> Vec<(E::States, E::States)> {
    classes.list.iter().map(|c| (c.states.clone(), c.worse.clone())).collect()
}

/// The treatment of the edges into Worse(c).
#[derive(Clone, Copy, PartialEq)]
enum Worse {
    /// The choices with such an edge are not kept.
    Barred,
    /// The edges are dropped.
    Dropped,
}

/// Returns the labels of the edges from each class. Classes with the same Better(c) and the same
/// dropped set are merged.
fn edge_labels<E: Engine>(
    engine: &E,
    classes: &Classes<E>,
    worse: Worse,
) -> Result<Vec<EdgeLabels<E::States>>> {
    let mut edge_labels: Vec<EdgeLabels<E::States>> = Vec::new();
    for class in &classes.list {
        let dropped = if worse == Worse::Dropped { class.worse.clone() } else { engine.no_states() };
        let same = |labels: &EdgeLabels<E::States>| {
            Ok(engine.same(&labels.goal, &class.better)? && engine.same(&labels.dropped, &dropped)?)
        };
        let at = position(&edge_labels, same)?.unwrap_or(edge_labels.len());
        match edge_labels.get_mut(at) {
            Some(labels) => labels.from = engine.union(&labels.from, &class.states)?,
            None => edge_labels.push(EdgeLabels::new(class.states.clone(), class.better.clone(), dropped)),
        }
        if worse == Worse::Barred {
            edge_labels[at].barred.push((class.states.clone(), class.worse.clone()));
        }
    }
    Ok(edge_labels)
}
