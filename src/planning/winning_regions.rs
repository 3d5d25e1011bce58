//! Where each objective can be achieved.

use crate::engine::regions::pmax_positive;
use crate::engine::{Count, Engine};
use crate::error::Result;

/// The regions of one objective.
pub struct ObjectiveRegions<E: Engine> {
    /// F: the target itself.
    pub target: E::States,
    /// PWin(F): where some strategy reaches F with positive probability.
    pub positive: E::States,
    /// ASWin(F): where some strategy reaches F almost surely.
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

/// The regions of all objectives: Out(s) = { i : s ∈ ASWin(F_i) } by state sets.
///
/// Computed one objective at a time, the larger targets first, so that a smaller one may start from
/// what is known of a larger one. What was computed stays when a limit ends the work.
pub struct WinningRegions<E: Engine> {
    targets: Vec<E::States>,
    /// The objectives still to do, the next one last.
    pending: Vec<usize>,
    known: Vec<Option<ObjectiveRegions<E>>>,
}

impl<E: Engine> WinningRegions<E> {
    /// Nothing computed yet for these targets.
    ///
    /// # Errors
    /// A limit of the engine while it counts. Cost: no image.
    pub fn new(engine: &E, targets: Vec<E::States>) -> Result<Self> {
        let sizes = targets.iter().map(|t| engine.count(t)).collect::<Result<Vec<Count>>>()?;
        let mut pending: Vec<usize> = (0..targets.len()).collect();
        pending.sort_by(|&i, &j| sizes[i].cmp(&sizes[j]).then(j.cmp(&i)));
        let known = targets.iter().map(|_| None).collect();
        Ok(WinningRegions { targets, pending, known })
    }

    /// Computes the regions of one more objective and says which; none when all are known.
    ///
    /// A target inside a known larger one has its almost-sure region inside the larger one's
    /// (to reach the smaller is to reach the larger), which bounds the search. Equal targets share
    /// everything.
    ///
    /// # Errors
    /// A limit of the engine; the objective is then still to do. Cost: one `can_reach` and
    /// one `almost_surely_reach`.
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
            if engine.same(target, &larger.target) {
                return Ok(larger.clone());
            }
            if engine.is_empty(&engine.difference(target, &larger.target)?) {
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

    /// F: the target of an objective, known before its regions are.
    pub fn target(&self, objective: usize) -> Option<&E::States> {
        self.targets.get(objective)
    }

    /// The regions of an objective, if they are known yet.
    pub fn get(&self, objective: usize) -> Option<&ObjectiveRegions<E>> {
        self.known.get(objective)?.as_ref()
    }

    /// The almost-sure regions of all objectives, once all are known.
    pub fn almost_sure(&self) -> Option<Vec<&E::States>> {
        self.known.iter().map(|o| o.as_ref().map(|o| &o.almost_sure)).collect()
    }
}

/// ASWin(F) = νY. μX. F ∪ { s : some a has succ(s,a) ⊆ Y and ∩ X ≠ ∅ } (Pmax = 1), given any
/// `bound` ⊇ ASWin(F), such as PWin(F).
///
/// Starts with the choices of the bound alone: what is outside of a superset of the result is lost, so
/// the result is the same and a backward fixpoint is spared.
///
/// # Errors
/// A limit of the engine. Cost: an `almost_surely_reach`.
pub(super) fn almost_sure_within<E: Engine>(
    engine: &E,
    target: &E::States,
    bound: &E::States,
) -> Result<E::States> {
    let within = if engine.same(bound, &engine.all_states()) {
        engine.all_choices()
    } else {
        engine.choices_in(&engine.all_choices(), bound)?
    };
    Ok(engine.almost_surely_reach(target, &within)?.states)
}
