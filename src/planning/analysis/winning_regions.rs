//! Winning regions: the states from which each objective can be achieved.

use super::result::Share;
use super::temporal_game;
use meliora_base::error::Result;
use meliora_engine::regions::{Which, pmax_positive};
use meliora_engine::{Count, Engine};
use meliora_model::temporal::Condition;

/// The winning regions of one objective.
pub struct ObjectiveRegions<E: Engine> {
    /// F: the target itself.
    pub target: E::States,
    /// PWin(F): the states from which some strategy reaches F with positive probability.
    ///
    /// In a game against an opponent, the states from which some strategy satisfies a temporal
    /// objective with positive probability, even if it does not reach F.
    pub positive: E::States,
    /// ASWin(F): the states from which some strategy reaches F almost surely; for a temporal objective
    /// in a game, as above.
    pub almost_sure: E::States,
}

impl<E: Engine> Clone for ObjectiveRegions<E> {
    fn clone(&self) -> Self {
        ObjectiveRegions {
            target: self.target.clone(),
            positive: self.positive.clone(),
            almost_sure: self.almost_sure.clone(),
        }
    }
}

/// The sizes of the regions of one objective.
#[derive(Clone)]
pub(crate) struct RegionCounts {
    pub(crate) target: Count,
    pub(crate) positive: Count,
    pub(crate) almost_sure: Count,
    /// The shares of the initial states in the almost-sure and in the positive region.
    pub(crate) sure: Share,
    pub(crate) possible: Share,
}

/// The goal of an objective.
pub(crate) struct Sought<E: Engine> {
    /// F: the target, or the states in which a temporal objective is secured.
    pub(crate) target: E::States,
    /// The condition of a temporal objective in a game against an opponent: its regions do not follow
    /// from the target.
    pub(crate) condition: Option<Condition>,
}

impl<E: Engine> Clone for Sought<E> {
    fn clone(&self) -> Self {
        Sought { target: self.target.clone(), condition: self.condition.clone() }
    }
}

/// The results for one objective so far.
struct ObjectiveResult<E: Engine> {
    regions: Option<ObjectiveRegions<E>>,
    counts: Option<RegionCounts>,
}

/// The winning regions of all objectives: Out(s) = { i : s ∈ ASWin(F_i) }, as state sets.
///
/// Larger targets come first: the regions of a larger target bound the search for a smaller one.
/// Results remain when a limit ends the work.
pub struct WinningRegions<E: Engine> {
    goals: Vec<Sought<E>>,
    /// The objectives in the order of their computation.
    order: Vec<usize>,
    known: Vec<ObjectiveResult<E>>,
}

impl<E: Engine> WinningRegions<E> {
    /// Creates the computation for these goals. Cost: no image.
    ///
    /// # Errors
    /// A limit of the engine is reached while the targets are counted.
    pub(crate) fn new(engine: &E, goals: Vec<Sought<E>>) -> Result<Self> {
        let sizes = goals.iter().map(|goal| engine.count(&goal.target)).collect::<Result<Vec<Count>>>()?;
        let mut order: Vec<usize> = (0..goals.len()).collect();
        order.sort_by(|&i, &j| sizes[j].cmp(&sizes[i]).then(i.cmp(&j)));
        let known = goals.iter().map(|_| ObjectiveResult { regions: None, counts: None }).collect();
        Ok(WinningRegions { goals, order, known })
    }

    /// Computes the regions of one more objective and returns the objective; `None` if all are
    /// known.
    ///
    /// If a target is a subset of a known one, its almost-sure region is a subset of the known
    /// one's, because reaching the smaller target reaches the larger one. This bounds the search.
    /// Equal targets share all regions. Cost per objective: one `can_reach` and at most one
    /// `almost_surely_reach`; for a temporal objective in a game, two nested fixpoints.
    ///
    /// # Errors
    /// A limit of the engine is reached; objectives that are not known then remain to be computed.
    pub(crate) fn advance(&mut self, engine: &E) -> Result<Option<usize>> {
        let Some(objective) = self.order.iter().copied().find(|&i| self.get(i).is_none()) else {
            return Ok(None);
        };
        let regions = self.regions_of(engine, &self.goals[objective])?;
        let regions = self.known[objective].regions.insert(regions);
        self.known[objective].counts = Some(counts_of(engine, regions)?);
        Ok(Some(objective))
    }

    /// Returns the regions of a goal. Those that do not follow from the target are not shared.
    fn regions_of(&self, engine: &E, goal: &Sought<E>) -> Result<ObjectiveRegions<E>> {
        let target = goal.target.clone();
        if let (Some(condition), Some(opponent)) = (&goal.condition, engine.exchanged()?) {
            let region = |which| temporal_game::region(engine, &opponent, which, condition);
            let (positive, almost_sure) = (region(Which::PmaxPositive)?, region(Which::PmaxOne)?);
            return Ok(ObjectiveRegions { target, positive, almost_sure });
        }
        let mut bound: Option<E::States> = None;
        let larger = self.known.iter().filter_map(|found| found.regions.as_ref());
        for larger in larger.filter(|_| goal.condition.is_none()) {
            if engine.same(&target, &larger.target)? {
                return Ok(larger.clone());
            }
            if engine.is_empty(&engine.difference(&target, &larger.target)?)? {
                bound = Some(match bound {
                    None => larger.almost_sure.clone(),
                    Some(b) => engine.intersection(&b, &larger.almost_sure)?,
                });
            }
        }
        let positive = pmax_positive(engine, &target)?;
        let bound = match bound {
            None => positive.clone(),
            Some(b) => engine.intersection(&b, &positive)?,
        };
        let almost_sure = almost_sure_within(engine, &target, &bound)?;
        Ok(ObjectiveRegions { target, positive, almost_sure })
    }

    /// Returns the sizes of the known regions of an objective; `None` if they are not known. Counts
    /// them if a limit left them uncounted.
    pub(crate) fn counts(&self, engine: &E, objective: usize) -> Result<Option<RegionCounts>> {
        match (self.counted(objective), self.get(objective)) {
            (None, Some(regions)) => counts_of(engine, regions).map(Some),
            (counts, _) => Ok(counts),
        }
    }

    /// Returns the sizes of the regions of an objective, if they were counted.
    pub(crate) fn counted(&self, objective: usize) -> Option<RegionCounts> {
        self.known.get(objective)?.counts.clone()
    }

    /// Returns the objectives in the order of their computation.
    pub(crate) fn order(&self) -> &[usize] {
        &self.order
    }

    /// Returns F, the target of an objective, which is known before its regions.
    pub fn target(&self, objective: usize) -> Option<&E::States> {
        self.goals.get(objective).map(|goal| &goal.target)
    }

    /// Returns the regions of an objective, if they are known yet.
    pub fn get(&self, objective: usize) -> Option<&ObjectiveRegions<E>> {
        self.known.get(objective)?.regions.as_ref()
    }

    /// Returns the almost-sure regions of all objectives, once all are known.
    pub(crate) fn almost_sure(&self) -> Option<Vec<&E::States>> {
        self.known.iter().map(|found| found.regions.as_ref().map(|o| &o.almost_sure)).collect()
    }
}

fn counts_of<E: Engine>(engine: &E, regions: &ObjectiveRegions<E>) -> Result<RegionCounts> {
    Ok(RegionCounts {
        target: engine.count(&regions.target)?,
        positive: engine.count(&regions.positive)?,
        almost_sure: engine.count(&regions.almost_sure)?,
        sure: Share::of_initial(engine, &regions.almost_sure)?,
        possible: Share::of_initial(engine, &regions.positive)?,
    })
}

/// Computes ASWin(F) = νY. μX. F ∪ { s : some a has succ(s,a) ⊆ Y and succ(s,a) ∩ X ≠ ∅ } (Pmax =
/// 1), given any `bound` with ASWin(F) ⊆ `bound` ⊆ PWin(F).
///
/// If every state can reach F, a strategy can try again from each state until it reaches F, so no search is
/// needed. Otherwise the search starts with the choices of the bound. States outside of a superset of the
/// result are lost, so the result is the same and one backward fixpoint is saved. Cost: one
/// `almost_surely_reach`.
pub(crate) fn almost_sure_within<E: Engine>(
    engine: &E,
    target: &E::States,
    bound: &E::States,
) -> Result<E::States> {
    if engine.same(bound, &engine.all_states())? {
        return Ok(bound.clone());
    }
    let within = engine.choices_in(&engine.all_choices(), bound)?;
    Ok(engine.almost_surely_reach(target, &within)?.states)
}
