//! Winning regions: the states from which each objective can be achieved.

use super::result::Share;
use super::temporal_game;
use meliora_base::error::Result;
use meliora_engine::parallel::{self, Port, Portable};
use meliora_engine::regions::{Which, pmax_positive};
use meliora_engine::{Count, Engine, position};
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

impl<E: Engine> Portable<E> for ObjectiveRegions<E> {
    fn ported(&self, port: &mut Port<E>) -> Self {
        ObjectiveRegions {
            target: port.states(&self.target),
            positive: port.states(&self.positive),
            almost_sure: port.states(&self.almost_sure),
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

/// The search for the regions of a goal, given a set that contains its almost-sure region.
struct Search<E: Engine> {
    goal: Sought<E>,
    bound: Option<E::States>,
}

impl<E: Engine> Portable<E> for Search<E> {
    fn ported(&self, port: &mut Port<E>) -> Self {
        let Sought { target, condition } = &self.goal;
        let bound = self.bound.as_ref().map(|bound| port.states(bound));
        Search { goal: Sought { target: port.states(target), condition: condition.clone() }, bound }
    }
}

/// The work that is left for a goal.
enum Task<E: Engine> {
    /// An equal goal has these regions.
    Known(ObjectiveRegions<E>),
    /// The regions are to be searched for.
    Open(Search<E>),
}

/// The results for one objective so far.
struct Found<E: Engine> {
    regions: Option<ObjectiveRegions<E>>,
    counts: Option<RegionCounts>,
}

impl<E: Engine> Portable<E> for Found<E> {
    fn ported(&self, port: &mut Port<E>) -> Self {
        Found { regions: self.regions.ported(port), counts: self.counts.clone() }
    }
}

/// The winning regions of all objectives: Out(s) = { i : s ∈ ASWin(F_i) }, as state sets.
///
/// Larger targets come first: the regions of a larger target bound the search for a smaller one.
/// Objectives whose targets do not contain each other are independent. Results remain when a limit
/// ends the work.
pub struct WinningRegions<E: Engine> {
    goals: Vec<Sought<E>>,
    /// The objectives in the order of their computation.
    order: Vec<usize>,
    known: Vec<Found<E>>,
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
        let known = goals.iter().map(|_| Found { regions: None, counts: None }).collect();
        Ok(WinningRegions { goals, order, known })
    }

    /// Computes the regions of one more objective and returns the objective; `None` if all are
    /// known. If the engine has workers, computes independent objectives next to each other.
    ///
    /// If a target is a subset of a known one, its almost-sure region is a subset of the known
    /// one's, because reaching the smaller target reaches the larger one. This bounds the search.
    /// Equal targets share all regions. Cost per objective: one `can_reach` and one
    /// `almost_surely_reach`; for a temporal objective in a game, two nested fixpoints.
    ///
    /// # Errors
    /// A limit of the engine is reached; objectives that are not known then remain to be computed.
    pub(crate) fn advance(&mut self, engine: &E) -> Result<Option<usize>> {
        let Some(first) = self.order.iter().copied().find(|&i| self.get(i).is_none()) else {
            return Ok(None);
        };
        let (mut objectives, mut searches) = (Vec::new(), Vec::new());
        for objective in self.independent(engine, first)? {
            match self.task(engine, &self.goals[objective])? {
                Task::Open(search) => {
                    objectives.push(objective);
                    searches.push((search, Found { regions: None, counts: None }));
                }
                Task::Known(same) => self.known[objective] = Found { counts: None, regions: Some(same) },
            }
        }
        let end = parallel::run(engine, &mut searches, find);
        for (objective, (_, found)) in objectives.into_iter().zip(searches) {
            self.known[objective] = found;
        }
        end.map(|()| Some(first))
    }

    /// Returns the objectives that can be computed next to the first unknown one: their targets are
    /// not subsets of other unknown ones.
    fn independent(&self, engine: &E, first: usize) -> Result<Vec<usize>> {
        let unknown = Vec::from_iter(self.order.iter().copied().filter(|&i| self.get(i).is_none()));
        if unknown.len() == 1 || engine.workers() == 0 {
            return Ok(vec![first]);
        }
        let mut independent = Vec::new();
        for (at, &i) in unknown.iter().enumerate() {
            let inside = |j: &usize| {
                let rest = engine.difference(&self.goals[i].target, &self.goals[*j].target)?;
                engine.is_empty(&rest)
            };
            if position(&unknown[..at], inside)?.is_none() {
                independent.push(i);
            }
        }
        Ok(independent)
    }

    /// Returns the work that is left for a goal. Regions that do not follow from the target are not
    /// shared. Cost: no image.
    fn task(&self, engine: &E, goal: &Sought<E>) -> Result<Task<E>> {
        let mut bound: Option<E::States> = None;
        if goal.condition.is_some() {
            return Ok(Task::Open(Search { goal: goal.clone(), bound }));
        }
        let target = &goal.target;
        for larger in self.known.iter().filter_map(|found| found.regions.as_ref()) {
            if engine.same(target, &larger.target)? {
                return Ok(Task::Known(larger.clone()));
            }
            if engine.is_empty(&engine.difference(target, &larger.target)?)? {
                bound = Some(match bound {
                    None => larger.almost_sure.clone(),
                    Some(b) => engine.intersection(&b, &larger.almost_sure)?,
                });
            }
        }
        Ok(Task::Open(Search { goal: goal.clone(), bound }))
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

/// Computes the regions of one goal, and counts them.
fn find<E: Engine>(engine: &E, search: &Search<E>, found: &mut Found<E>) -> Result<()> {
    let regions = match found.regions.take() {
        Some(regions) => regions,
        None => regions_of(engine, search)?,
    };
    let counts = counts_of(engine, found.regions.insert(regions))?;
    found.counts = Some(counts);
    Ok(())
}

fn regions_of<E: Engine>(engine: &E, Search { goal, bound }: &Search<E>) -> Result<ObjectiveRegions<E>> {
    let target = goal.target.clone();
    if let (Some(condition), Some(opponent)) = (&goal.condition, engine.exchanged()?) {
        let region = |which| temporal_game::region((engine, &opponent), which, condition);
        let (positive, almost_sure) = (region(Which::PmaxPositive)?, region(Which::PmaxOne)?);
        return Ok(ObjectiveRegions { target, positive, almost_sure });
    }
    let positive = pmax_positive(engine, &target)?;
    let bound = match bound {
        None => positive.clone(),
        Some(b) => engine.intersection(b, &positive)?,
    };
    let almost_sure = almost_sure_within(engine, &target, &bound)?;
    Ok(ObjectiveRegions { target, positive, almost_sure })
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
/// 1), given any `bound` ⊇ ASWin(F), such as PWin(F).
///
/// The search starts with the choices of the bound. States outside of a superset of the result are
/// lost, so the result is the same and one backward fixpoint is saved. Cost: one
/// `almost_surely_reach`.
pub(crate) fn almost_sure_within<E: Engine>(
    engine: &E,
    target: &E::States,
    bound: &E::States,
) -> Result<E::States> {
    let within = if engine.same(bound, &engine.all_states())? {
        engine.all_choices()
    } else {
        engine.choices_in(&engine.all_choices(), bound)?
    };
    Ok(engine.almost_surely_reach(target, &within)?.states)
}
