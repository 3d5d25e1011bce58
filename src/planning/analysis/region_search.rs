//! The search for the qualitative regions of a goal, one region after the other.

use super::temporal::{accepting_regions, secured};
use super::temporal_game;
use super::winning_regions::almost_sure_within;
use meliora_base::error::Result;
use meliora_engine::Engine;
use meliora_engine::regions::{self, Regions, Which};
use meliora_model::temporal::Condition;

/// A search for regions of a goal: to reach a target, or to satisfy a condition on the product with
/// monitors. Each region is computed when it is asked for.
///
/// In a Markov chain, Pmin = Pmax, so a region of Pmin is that of Pmax.
pub struct RegionSearch<'a, E: Engine> {
    engine: &'a E,
    goal: SearchGoal<'a, E>,
    known: Regions<Option<E::States>>,
    /// The states from which the condition can be kept, if they are known.
    secured: Option<E::States>,
    /// The states from which its negation can be kept, if they are known.
    against: Option<E::States>,
}

enum SearchGoal<'a, E: Engine> {
    Target(E::States),
    Condition(&'a Condition),
}

impl<'a, E: Engine> RegionSearch<'a, E> {
    /// Begins the search for regions of a target. Cost: no image.
    pub fn of_target(engine: &'a E, target: E::States) -> Self {
        RegionSearch::new(engine, SearchGoal::Target(target))
    }

    /// Begins the search for regions of a condition on the product. Cost: no image.
    pub fn of_condition(engine: &'a E, condition: &'a Condition) -> Self {
        RegionSearch::new(engine, SearchGoal::Condition(condition))
    }

    fn new(engine: &'a E, goal: SearchGoal<'a, E>) -> Self {
        RegionSearch { engine, goal, known: Regions::default(), secured: None, against: None }
    }

    /// Returns some regions and those that they are computed from, in the order in which they should
    /// be asked for: of usual cost, each after the one that it is computed from.
    pub fn order(&self, wanted: &[Which]) -> Vec<Which> {
        let mut order = Vec::new();
        for which in Which::ALL.into_iter().filter(|which| wanted.contains(which)) {
            let chain = std::iter::successors(Some(which), |which| self.basis(*which));
            let missing: Vec<Which> = chain.take_while(|which| !order.contains(which)).collect();
            order.extend(missing.into_iter().rev());
        }
        order
    }

    /// Returns the region that another one is computed from.
    fn basis(&self, which: Which) -> Option<Which> {
        match (which, &self.goal) {
            (Which::PminPositive, _) if self.engine.is_markov_chain() => Some(Which::PmaxPositive),
            (Which::PminOne, _) if self.engine.is_markov_chain() => Some(Which::PmaxOne),
            (Which::PminOne, SearchGoal::Target(_)) => Some(Which::PminPositive),
            // In a game, each region is computed alone.
            (_, SearchGoal::Condition(_)) if self.engine.theirs().is_some() => None,
            (Which::PmaxOne, SearchGoal::Condition(_)) => Some(Which::PmaxPositive),
            (Which::PminPositive, SearchGoal::Condition(_)) => Some(Which::PminOne),
            _ => None,
        }
    }

    /// Returns the states of the goal: the target, or the states from which the condition can be kept.
    /// Cost: no image for a target; for a condition, that of [`accepting_regions`], once.
    ///
    /// # Errors
    /// A limit of the engine is reached, or a state formula has no value.
    pub fn goal(&mut self) -> Result<E::States> {
        match &self.goal {
            SearchGoal::Target(target) => Ok(target.clone()),
            &SearchGoal::Condition(condition) => self.secured(condition),
        }
    }

    /// Returns the regions that are known.
    pub fn known(&self) -> &Regions<Option<E::States>> {
        &self.known
    }

    /// Computes all four regions.
    ///
    /// # Errors
    /// The errors of [`RegionSearch::region`].
    pub fn all(mut self) -> Result<Regions<E::States>> {
        Ok(Regions {
            pmax_positive: self.region(Which::PmaxPositive)?,
            pmax_one: self.region(Which::PmaxOne)?,
            pmin_one: self.region(Which::PminOne)?,
            pmin_positive: self.region(Which::PminPositive)?,
        })
    }

    /// Returns a region, which is computed if it is not known. Cost: for a target, that of its function
    /// in [`meliora_engine::regions`]; for a condition, one backward or almost-sure fixpoint, and that of
    /// [`accepting_regions`] for the first region of Pmax and for the first one of Pmin; for a condition in
    /// a game, a nested fixpoint per region.
    ///
    /// # Errors
    /// A limit of the engine is reached, or a state formula has no value. A condition in a game needs
    /// several recurring marks. Known regions stay known.
    pub fn region(&mut self, which: Which) -> Result<E::States> {
        if let Some(known) = self.known.get(which) {
            return Ok(known.clone());
        }
        let found = match (which, &self.goal) {
            (Which::PminPositive, _) if self.engine.is_markov_chain() => self.region(Which::PmaxPositive)?,
            (Which::PminOne, _) if self.engine.is_markov_chain() => self.region(Which::PmaxOne)?,
            (_, SearchGoal::Target(_)) => self.region_of_target(which)?,
            (_, &SearchGoal::Condition(condition)) => self.region_of_condition(which, condition)?,
        };
        *self.known.get_mut(which) = Some(found.clone());
        Ok(found)
    }

    fn region_of_target(&mut self, which: Which) -> Result<E::States> {
        let (engine, target) = (self.engine, self.goal()?);
        match which {
            Which::PmaxPositive => regions::pmax_positive(engine, &target),
            Which::PmaxOne => regions::pmax_one(engine, &target),
            Which::PminPositive => regions::pmin_positive(engine, &target),
            Which::PminOne => regions::pmin_one(engine, &target, &self.region(Which::PminPositive)?),
        }
    }

    /// A state from which no strategy satisfies the negation is a state from which every strategy
    /// satisfies the condition.
    fn region_of_condition(&mut self, which: Which, condition: &Condition) -> Result<E::States> {
        let engine = self.engine;
        if let Some(opponent) = engine.exchanged()? {
            return temporal_game::region(engine, &opponent, which, condition);
        }
        let others = |states: &E::States| engine.difference(&engine.all_states(), states);
        match which {
            Which::PmaxPositive => regions::pmax_positive(engine, &self.secured(condition)?),
            Which::PmaxOne => {
                let positive = self.region(Which::PmaxPositive)?;
                almost_sure_within(engine, &self.secured(condition)?, &positive)
            }
            Which::PminOne => others(&regions::pmax_positive(engine, &self.against(condition)?)?),
            Which::PminPositive => {
                let threatened = others(&self.region(Which::PminOne)?)?;
                others(&almost_sure_within(engine, &self.against(condition)?, &threatened)?)
            }
        }
    }

    /// Returns the states from which the condition can be kept.
    fn secured(&mut self, condition: &Condition) -> Result<E::States> {
        kept(self.engine, condition, &mut self.secured)
    }

    /// Returns the states from which its negation can be kept.
    fn against(&mut self, condition: &Condition) -> Result<E::States> {
        kept(self.engine, &condition.negated(), &mut self.against)
    }
}

/// Returns the states from which a condition can be kept, which are computed once.
fn kept<E: Engine>(engine: &E, condition: &Condition, known: &mut Option<E::States>) -> Result<E::States> {
    if let Some(known) = known {
        return Ok(known.clone());
    }
    let states = secured(engine, &accepting_regions(engine, condition, &engine.all_choices())?)?;
    Ok(known.insert(states).clone())
}
