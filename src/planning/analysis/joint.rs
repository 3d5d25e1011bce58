//! Objectives that can be achieved together: by one strategy, almost surely, in the same path.
//!
//! W(R, T) is the set of states from which some strategy reaches each F_i, i ∈ R, and satisfies the
//! formulas of T, almost surely. W(∅, T) is the almost-sure region of the conjunction of T. For other
//! sets, W(R, T) is the set of states that almost surely reach ⋃_{i ∈ R} F_i ∩ W(R \ {i}, T): the
//! first target on a path leaves one target less to reach.

use std::collections::BTreeMap;

use super::temporal;
use super::winning_regions::almost_sure_within;
use crate::{Analysis, Class};
use meliora_base::error::{Error, Result};
use meliora_engine::Engine;
use meliora_engine::regions::pmax_positive;
use meliora_model::preference::{Goal, ObjectiveSet};
use meliora_model::temporal::Condition;

/// Maximum number of most preferred objectives of a class; the number of sets is exponential in it.
/// Nothing is computed for classes that have more.
pub const MOST: usize = 10;

/// Sets of objectives, each with the states from which one strategy achieves all of them.
type Sets<S> = Vec<(ObjectiveSet, S)>;

/// The sets of objectives that are jointly achievable somewhere, among the most preferred objectives of
/// a class.
pub struct Joint<E: Engine> {
    /// The regions W(R, T) by R ∪ T. A set without an entry is achieved jointly in no state.
    regions: BTreeMap<ObjectiveSet, E::States>,
}

impl<E: Engine> Joint<E> {
    /// Computes the regions of all sets of most preferred objectives of each class with at most
    /// [`MOST`] of them. Cost: one
    /// almost-sure fixpoint per set; for sets of temporal objectives also that of
    /// [`temporal::accepting_regions`].
    ///
    /// # Errors
    /// [`Error::Usage`] if the classes are not known; a limit of the engine is reached.
    pub fn new(analysis: &Analysis<E>) -> Result<Self> {
        if analysis.whole_engine().is_game() {
            let message = "`--jointly` of a game is not supported; strategies of the kind `achieve` say where several \
                           objectives are achieved together";
            return Err(Error::Usage(message.to_owned()));
        }
        let Some(classes) = analysis.classes() else {
            return Err(Error::Usage("the classes are not known; run the analysis first".to_owned()));
        };
        let mut joint = Joint { regions: BTreeMap::new() };
        for class in classes.list.iter().filter(|class| !is_too_large(&class.most_preferred)) {
            joint.add(analysis, &class.most_preferred)?;
        }
        Ok(joint)
    }

    /// Computes the regions of all subsets of at most [`MOST`] objectives. Cost: as [`Joint::new`].
    ///
    /// # Errors
    /// A limit of the engine is reached.
    pub(crate) fn of_set(analysis: &Analysis<E>, objectives: &ObjectiveSet) -> Result<Self> {
        let mut joint = Joint { regions: BTreeMap::new() };
        joint.add(analysis, objectives)?;
        Ok(joint)
    }

    /// Returns the states from which one strategy achieves all objectives of a set; `None` if there
    /// are none.
    pub(crate) fn states(&self, objectives: &ObjectiveSet) -> Option<&E::States> {
        self.regions.get(objectives)
    }

    /// Adds all subsets of a set, smaller ones first. A set whose subset is nowhere achieved is left
    /// out.
    fn add(&mut self, analysis: &Analysis<E>, objectives: &ObjectiveSet) -> Result<()> {
        let members: Vec<usize> = objectives.iter().collect();
        let subset = |bits: u32| -> ObjectiveSet {
            members.iter().enumerate().filter(|(at, _)| bits >> at & 1 == 1).map(|(_, &o)| o).collect()
        };
        let mut subsets: Vec<ObjectiveSet> = (1..1u32 << members.len()).map(subset).collect();
        subsets.sort_by_key(ObjectiveSet::len);
        for set in subsets {
            if self.regions.contains_key(&set) || !smaller(&set).all(|part| self.regions.contains_key(&part))
            {
                continue;
            }
            let region = self.region(analysis, &set)?;
            if !analysis.engine().is_empty(&region)? {
                self.regions.insert(set, region);
            }
        }
        Ok(())
    }

    /// Computes W(R, T) from the regions of the smaller sets.
    fn region(&self, analysis: &Analysis<E>, set: &ObjectiveSet) -> Result<E::States> {
        let (engine, preferences) = (analysis.engine(), analysis.preferences());
        let mut conditions = Vec::new();
        let mut goal = engine.no_states();
        for objective in set.iter() {
            let known = analysis.outcomes().and_then(|outcomes| outcomes.get(objective));
            let (Goal::Reach(_), Some(known)) = (&preferences.objectives[objective].goal, known) else {
                if let Goal::Satisfy { condition, .. } = &preferences.objectives[objective].goal {
                    conditions.push(condition.clone());
                }
                continue;
            };
            let rest: ObjectiveSet = set.iter().filter(|&other| other != objective).collect();
            let after = match self.regions.get(&rest) {
                Some(after) => engine.intersection(&known.target, after)?,
                None => known.target.clone(),
            };
            goal = engine.union(&goal, &after)?;
        }
        if conditions.len() == set.len() {
            goal = temporal::secured(
                engine,
                &temporal::accepting_regions(engine, &Condition::All(conditions), &engine.all_choices())?,
            )?;
        }
        let bound = pmax_positive(engine, &goal)?;
        almost_sure_within(engine, &goal, &bound)
    }

    /// Returns the sets of at least two members of a class that are jointly achievable in some of its
    /// states, each with these states; larger sets first. `None` if the class is too large.
    pub fn of_class(&self, engine: &E, class: &Class<E>) -> Result<Option<Sets<E::States>>> {
        if is_too_large(&class.most_preferred) {
            return Ok(None);
        }
        let mut found = Vec::new();
        for (set, region) in &self.regions {
            if set.len() < 2 || !set.iter().all(|objective| class.most_preferred.contains(objective)) {
                continue;
            }
            let states = engine.intersection(region, &class.states)?;
            if !engine.is_empty(&states)? {
                found.push((set.clone(), states));
            }
        }
        found.sort_by_key(|(set, _)| std::cmp::Reverse(set.len()));
        Ok(Some(found))
    }

    /// Returns the greatest sets of most preferred objectives that are jointly achievable from a state;
    /// `None` if its class is too large.
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub(crate) fn of_state(
        &self,
        analysis: &Analysis<E>,
        state: &[i64],
    ) -> Result<Option<Vec<ObjectiveSet>>> {
        let Some(classes) = analysis.classes() else { return Ok(None) };
        let most_preferred = classes.most_preferred(analysis.engine(), state)?;
        if is_too_large(&most_preferred) {
            return Ok(None);
        }
        let mut greatest: Vec<ObjectiveSet> = Vec::new();
        let mut sets: Vec<_> = self.regions.iter().collect();
        sets.sort_by_key(|(set, _)| std::cmp::Reverse(set.len()));
        for (set, region) in sets {
            let within = |larger: &ObjectiveSet| set.iter().all(|objective| larger.contains(objective));
            if within(&most_preferred)
                && !greatest.iter().any(within)
                && analysis.engine().contains(region, state)?
            {
                greatest.push(set.clone());
            }
        }
        Ok(Some(greatest))
    }
}

/// Returns whether a class has more than [`MOST`] most preferred objectives.
pub fn is_too_large(most_preferred: &ObjectiveSet) -> bool {
    most_preferred.len() > MOST
}

/// Returns the sets without one member of a set.
fn smaller(set: &ObjectiveSet) -> impl Iterator<Item = ObjectiveSet> + '_ {
    let without = |removed: usize| set.iter().filter(|&objective| objective != removed).collect();
    set.iter().map(without).filter(|part: &ObjectiveSet| !part.is_empty())
}
