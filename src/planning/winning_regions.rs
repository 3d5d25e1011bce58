//! Winning regions: the states from which each objective can be achieved.

use crate::engine::regions::pmax_positive;
use crate::engine::{Count, Engine};
use crate::error::Result;

/// The winning regions of one objective.
pub struct ObjectiveRegions<E: Engine> {
    /// F: the target itself.
    pub target: E::States,
    /// PWin(F): the states from which some strategy reaches F with positive probability.
    pub positive: E::States,
    /// ASWin(F): the states from which some strategy reaches F almost surely.
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

/// The winning regions of all objectives: Out(s) = { i : s ∈ ASWin(F_i) }, as state sets.
///
/// The regions are computed one objective at a time, larger targets first: the regions of a larger
/// target bound the search for a smaller one. Results remain when a limit ends the work.
pub struct WinningRegions<E: Engine> {
    targets: Vec<E::States>,
    /// The objectives that are not computed yet, the next one last.
    pending: Vec<usize>,
    known: Vec<Option<ObjectiveRegions<E>>>,
}

impl<E: Engine> WinningRegions<E> {
    /// Creates the computation for these targets. Cost: no image.
    ///
    /// # Errors
    /// A limit of the engine is reached while the targets are counted.
    pub fn new(engine: &E, targets: Vec<E::States>) -> Result<Self> {
        let sizes = targets.iter().map(|t| engine.count(t)).collect::<Result<Vec<Count>>>()?;
        let mut pending: Vec<usize> = (0..targets.len()).collect();
        pending.sort_by(|&i, &j| sizes[i].cmp(&sizes[j]).then(j.cmp(&i)));
        let known = targets.iter().map(|_| None).collect();
        Ok(WinningRegions { targets, pending, known })
    }

    /// Computes the regions of one more objective and returns the objective; `None` if all are
    /// known.
    ///
    /// If a target is a subset of a known one, its almost-sure region is a subset of the known
    /// one's, because reaching the smaller target reaches the larger one. This bounds the search.
    /// Equal targets share all regions. Cost: one `can_reach` and one `almost_surely_reach`.
    ///
    /// # Errors
    /// A limit of the engine is reached; the objective then remains to be computed.
    pub fn advance(&mut self, engine: &E) -> Result<Option<usize>> {
        let Some(&objective) = self.pending.last() else {
            return Ok(None);
        };
        let outcome = self.compute(engine, &self.targets[objective])?;
        self.known[objective] = Some(outcome);
        self.pending.pop();
        Ok(Some(objective))
    }

    fn compute(&self, engine: &E, target: &E::States) -> Result<ObjectiveRegions<E>> {
        let mut bound: Option<E::States> = None;
        for larger in self.known.iter().flatten() {
            if engine.same(target, &larger.target)? {
                return Ok(larger.clone());
            }
            if engine.is_empty(&engine.difference(target, &larger.target)?)? {
                bound = Some(match bound {
                    None => larger.almost_sure.clone(),
                    Some(b) => engine.intersection(&b, &larger.almost_sure)?,
                });
            }
        }
        let positive = pmax_positive(engine, target)?;
        let bound = match bound {
            None => positive.clone(),
            Some(b) => engine.intersection(&b, &positive)?,
        };
        let almost_sure = almost_sure_within(engine, target, &bound)?;
        Ok(ObjectiveRegions { target: target.clone(), positive, almost_sure })
    }

    /// Returns F, the target of an objective, which is known before its regions.
    pub fn target(&self, objective: usize) -> Option<&E::States> {
        self.targets.get(objective)
    }

    /// Returns the regions of an objective, if they are known yet.
    pub fn get(&self, objective: usize) -> Option<&ObjectiveRegions<E>> {
        self.known.get(objective)?.as_ref()
    }

    /// Returns the almost-sure regions of all objectives, once all are known.
    pub fn almost_sure(&self) -> Option<Vec<&E::States>> {
        self.known.iter().map(|o| o.as_ref().map(|o| &o.almost_sure)).collect()
    }
}

/// Computes ASWin(F) = νY. μX. F ∪ { s : some a has succ(s,a) ⊆ Y and succ(s,a) ∩ X ≠ ∅ } (Pmax =
/// 1), given any `bound` ⊇ ASWin(F), such as PWin(F).
///
/// The search starts with the choices of the bound. States outside of a superset of the result are
/// lost, so the result is the same and one backward fixpoint is saved. Cost: one
/// `almost_surely_reach`.
///
/// # Errors
/// A limit of the engine is reached.
pub(super) fn almost_sure_within<E: Engine>(
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
