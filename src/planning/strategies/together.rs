//! Objectives that one strategy achieves together, in the same path.
//!
//! Targets can be far apart, so a path needs a memory of those that it has reached. While Q are the
//! others, it stays in W(Q), from where one strategy reaches all of Q, and approaches their union. A
//! state of W(Q) in a target of i ∈ Q is in W(Q \ {i}), because that asks for less. So each entered
//! target leaves less to reach, and the path almost surely reaches all of them.
//!
//! This is right in games, too. Let W(Q) be the states from which we reach all of Q almost surely against
//! every strategy of the opponent. To win from a state of W(Q) outside of all targets, a path must almost
//! surely enter the target of some i ∈ Q, and what the strategy does afterwards must win there: it enters
//! the target in W(Q \ {i}). Conversely, a strategy that reaches such a state almost surely can win there.
//!
//! Temporal objectives have monitors, which are this memory: together they are their conjunction.

use super::achieve::{Stage, Stages};
use crate::analysis::joint::{Joint, MOST, is_too_large};
use crate::{Analysis, temporal};
use meliora_base::error::{Error, Result};
use meliora_engine::{Engine, Region};
use meliora_model::preference::{Goal, ObjectiveSet};
use meliora_model::temporal::Condition;

impl<E: Engine> Stages<E> {
    /// Computes the stages of objectives that are to be achieved together. Cost: one almost-sure
    /// fixpoint per subset; for temporal objectives, those of their conjunction.
    ///
    /// # Errors
    /// [`Error::Usage`] for more than [`MOST`] objectives; a limit of the engine is reached.
    pub(crate) fn together(analysis: &Analysis<E>, objectives: &ObjectiveSet) -> Result<Self> {
        if is_too_large(objectives) {
            let count = objectives.len();
            let message = format!("at most {MOST} objectives are achieved together, and {count} are named");
            return Err(Error::Usage(message));
        }
        let engine = analysis.engine();
        let joint = Joint::of_set(analysis, objectives)?;
        let sure = joint.states(objectives).cloned().unwrap_or_else(|| engine.no_states());
        let goals = objectives.iter().map(|objective| &analysis.preferences().objectives[objective].goal);
        let condition = |goal: &Goal| match goal {
            Goal::Satisfy { condition, .. } => Some(condition.clone()),
            Goal::Reach(_) => None,
        };
        // Either all objectives are targets, or all are temporal.
        match goals.map(condition).collect::<Option<Vec<_>>>() {
            Some(all) => {
                let choices = engine.all_choices();
                let accepting = temporal::accepting_regions(engine, &Condition::All(all), &choices)?;
                let target = temporal::secured(engine, &accepting)?;
                Stages::new(engine, &target, &sure, &choices, &accepting)
            }
            None => Stages::of_targets(analysis, &joint, objectives),
        }
    }

    /// Returns a stage for each set of targets that a path has reached. Cost: one pre-image per set.
    fn of_targets(analysis: &Analysis<E>, joint: &Joint<E>, objectives: &ObjectiveSet) -> Result<Self> {
        let engine = analysis.engine();
        let together: Vec<usize> = objectives.iter().collect();
        let mut all = Vec::with_capacity(1 << together.len());
        for reached in 0..1usize << together.len() {
            let left = together.iter().enumerate().filter(|(i, _)| reached >> i & 1 == 0);
            let left: ObjectiveSet = left.map(|(_, &objective)| objective).collect();
            let states = match joint.states(&left) {
                Some(states) => states.clone(),
                None if left.is_empty() => engine.all_states(),
                None => engine.no_states(),
            };
            let mut goal = engine.no_states();
            for regions in left.iter().filter_map(|objective| analysis.outcomes()?.get(objective)) {
                goal = engine.union(&goal, &regions.target)?;
            }
            let staying = engine.pre_within(&engine.all_choices(), &states)?;
            let region = Region { choices: engine.choices_in(&staying, &states)?, states };
            all.push(Stage { region, goal, recurs: false });
        }
        Ok(Stages { all, disjuncts: Vec::new(), together })
    }
}
