//! Classes: the states grouped by their most preferred objectives.

use meliora_base::error::Result;
use meliora_engine::{Engine, position};
use meliora_model::preference::{Change, ObjectiveSet, Preferences, Rated};

/// The states with one value of MP, and the states of better and worse classes.
pub struct Class<E: Engine> {
    /// MP(s), the same for all states s of the class.
    pub most_preferred: ObjectiveSet,
    /// The states; never empty.
    pub states: E::States,
    /// Better(c): the states of the classes that improve on c and do not weaken it.
    pub better: E::States,
    /// Worse(c): the states of the classes that weaken c.
    pub worse: E::States,
    /// The effect of a step from this class into each class, in the order of [`Classes::list`].
    pub changes: Vec<Change>,
}

impl<E: Engine> Class<E> {
    /// Returns the number of classes that weaken this one.
    pub(crate) fn weakened_by(&self) -> usize {
        self.changes.iter().filter(|change| **change == Change::Weakening).count()
    }

    /// Returns whether each class that weakens this one also weakens another one.
    pub(crate) fn is_weakened_within(&self, other: &Self) -> bool {
        let weakens = |change: &Change| *change == Change::Weakening;
        self.changes.iter().zip(&other.changes).all(|(own, other)| !weakens(own) || weakens(other))
    }
}

/// The non-empty classes, sorted by the members of MP; the class with an empty MP is last.
pub struct Classes<E: Engine> {
    /// The classes, which partition the states of the scope. Unsafe states have no class.
    pub list: Vec<Class<E>>,
}

impl<E: Engine> Classes<E> {
    /// Computes the partition of the scope by MP from the almost-sure region of each objective.
    ///
    /// M_i = AS_i \ ⋃ { AS_j : j strictly preferred to i } contains the states that have i in MP.
    /// The classes are the non-empty intersections of these sets and their complements. Cost: no
    /// image; two Boolean operations per class and objective.
    pub(crate) fn new(engine: &E, preferences: &Preferences, almost_sure: &[&E::States]) -> Result<Self> {
        let all = engine.all_states();
        let mut split = match engine.is_empty(&all)? {
            true => Vec::new(),
            false => vec![(ObjectiveSet::new(), all)],
        };
        for (i, region) in almost_sure.iter().enumerate() {
            let member = undominated(engine, preferences, almost_sure, i, region)?;
            split = split_by(engine, split, i, &member)?;
        }
        split.sort_by_cached_key(|(mp, _)| (mp.is_empty(), mp.iter().collect::<Vec<_>>()));
        let rated: Vec<Rated<'_>> = split.iter().map(|(mp, _)| preferences.rated(mp)).collect();
        let mut list = Vec::with_capacity(split.len());
        for ((mp, states), from) in split.iter().zip(&rated) {
            let changes = Vec::from_iter(rated.iter().map(|to| preferences.change_between(from, to)));
            list.push(Class {
                most_preferred: mp.clone(),
                states: states.clone(),
                better: union_of(engine, &split, &changes, Change::Improving)?,
                worse: union_of(engine, &split, &changes, Change::Weakening)?,
                changes,
            });
        }
        Ok(Classes { list })
    }

    /// Returns the position in [`Classes::list`] of a state's class; `None` for unsafe states and
    /// outside the scope. Cost: one membership test per class.
    ///
    /// # Errors
    /// The classes belong to another engine.
    pub fn of(&self, engine: &E, state: &[i64]) -> Result<Option<usize>> {
        position(&self.list, |c| engine.contains(&c.states, state))
    }

    /// Returns the effect of a step between two classes. States without a class are compared with
    /// nothing: such a step neither improves nor weakens.
    pub fn change(&self, from: Option<usize>, to: Option<usize>) -> Change {
        let change = from.zip(to).and_then(|(from, to)| self.list.get(from)?.changes.get(to).copied());
        change.unwrap_or(Change::Lateral)
    }

    /// Returns MP(s); empty outside the scope. Cost: one membership test per class.
    ///
    /// # Errors
    /// The classes belong to another engine.
    pub fn most_preferred(&self, engine: &E, state: &[i64]) -> Result<ObjectiveSet> {
        let class = self.of(engine, state)?;
        Ok(class.map_or_else(ObjectiveSet::new, |class| self.list[class].most_preferred.clone()))
    }
}

type Split<E> = Vec<(ObjectiveSet, <E as Engine>::States)>;

/// Computes M_i; see [`Classes::new`].
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

/// Splits each set into its part inside `member`, which gets objective i, and the rest.
fn split_by<E: Engine>(engine: &E, sets: Split<E>, i: usize, member: &E::States) -> Result<Split<E>> {
    let mut split = Vec::with_capacity(sets.len() + 1);
    for (mp, states) in sets {
        let inside = engine.intersection(&states, member)?;
        if engine.is_empty(&inside)? {
            split.push((mp, states));
            continue;
        }
        let outside = engine.difference(&states, &inside)?;
        let mut with = mp.clone();
        with.insert(i);
        split.push((with, inside));
        if !engine.is_empty(&outside)? {
            split.push((mp, outside));
        }
    }
    Ok(split)
}

/// Returns the states of the classes to which a step has this effect.
fn union_of<E: Engine>(
    engine: &E,
    split: &Split<E>,
    changes: &[Change],
    wanted: Change,
) -> Result<E::States> {
    let mut union = engine.no_states();
    for ((_, states), _) in split.iter().zip(changes).filter(|(_, change)| **change == wanted) {
        union = engine.union(&union, states)?;
    }
    Ok(union)
}
