//! Classes: states by their most preferred outcomes.

use crate::engine::Engine;
use crate::error::Result;
use crate::model::preference::{Change, ObjectiveSet, Preferences};

/// The states with one value of MP, and how the other classes look from there.
pub struct Class<E: Engine> {
    /// MP(s) of all states s of the class.
    pub most_preferred: ObjectiveSet,
    /// The states; never empty.
    pub states: E::States,
    /// Better(c): the states of the classes that improve on c without weakening it.
    pub better: E::States,
    /// Worse(c): the states of the classes that weaken c.
    pub worse: E::States,
}

/// The non-empty classes, sorted by the members of MP; "nothing achievable" is last.
pub struct Classes<E: Engine> {
    /// The classes; they partition the states of the scope.
    pub list: Vec<Class<E>>,
}

impl<E: Engine> Classes<E> {
    /// The partition of the scope by MP, from the almost-sure region of each objective.
    ///
    /// M_i = AS_i \ ⋃ { AS_j : j strictly preferred to i } holds the states that have i in MP; the
    /// classes are the non-empty intersections of these and their complements.
    ///
    /// # Errors
    /// A limit of the engine. Cost: no image; Boolean operations, two a class and objective.
    pub fn new(engine: &E, preferences: &Preferences, almost_sure: &[&E::States]) -> Result<Self> {
        let mut split = vec![(ObjectiveSet::new(), engine.all_states())];
        for (i, region) in almost_sure.iter().enumerate() {
            let member = undominated(engine, preferences, almost_sure, i, region)?;
            split = split_by(engine, split, i, &member)?;
        }
        split.retain(|(_, states)| !engine.is_empty(states));
        split.sort_by_cached_key(|(mp, _)| (mp.is_empty(), mp.iter().collect::<Vec<_>>()));
        let mut list = Vec::with_capacity(split.len());
        for (mp, states) in &split {
            list.push(Class {
                most_preferred: mp.clone(),
                states: states.clone(),
                better: related(engine, preferences, &split, mp, Change::Improving)?,
                worse: related(engine, preferences, &split, mp, Change::Weakening)?,
            });
        }
        Ok(Classes { list })
    }

    /// The position in [`Classes::list`] of the class that a state is in; none outside the scope. Cost: one
    /// membership a class.
    pub fn of(&self, engine: &E, state: &[i64]) -> Option<usize> {
        self.list.iter().position(|c| engine.contains(&c.states, state))
    }
}

type Split<E> = Vec<(ObjectiveSet, <E as Engine>::States)>;

/// M_i
fn undominated<E: Engine>(
    engine: &E,
    preferences: &Preferences,
    almost_sure: &[&E::States],
    i: usize,
    region: &E::States,
) -> Result<E::States> {
    let mut member = region.clone();
    for j in preferences.order.strictly_above(i).into_iter().flat_map(ObjectiveSet::iter) {
        if let Some(above) = almost_sure.get(j) {
            member = engine.difference(&member, above)?;
        }
    }
    Ok(member)
}

/// Each set divided into its part inside `member`, which gets objective i, and the rest.
fn split_by<E: Engine>(engine: &E, sets: Split<E>, i: usize, member: &E::States) -> Result<Split<E>> {
    let mut split = Vec::with_capacity(sets.len() + 1);
    for (mp, states) in sets {
        let inside = engine.intersection(&states, member)?;
        if engine.is_empty(&inside) {
            split.push((mp, states));
            continue;
        }
        let outside = engine.difference(&states, &inside)?;
        let mut with = mp.clone();
        with.insert(i);
        split.push((with, inside));
        if !engine.is_empty(&outside) {
            split.push((mp, outside));
        }
    }
    Ok(split)
}

/// The states of the classes that a step from `from` enters with this change.
fn related<E: Engine>(
    engine: &E,
    preferences: &Preferences,
    split: &Split<E>,
    from: &ObjectiveSet,
    change: Change,
) -> Result<E::States> {
    let mut union = engine.no_states();
    for (to, states) in split {
        if preferences.change(from, to) == change {
            union = engine.union(&union, states)?;
        }
    }
    Ok(union)
}
