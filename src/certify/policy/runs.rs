//! Random runs of policies with memory, as their nodes describe them.

use super::nodes::{Aim, NodePolicy};
use super::rules::{FaultKind, PolicyFault, step};
use super::space::holds;
use meliora_base::error::Result;
use meliora_base::random::Draw;
use meliora_model::preference::{Change, Goal, ObjectiveSet, Preferences};
use meliora_model::{Program, State, fault};

/// A run of a policy with memory.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct NodeRun {
    /// The steps: each action with the state that it is taken in.
    pub steps: Vec<(State, String)>,
    /// The state in which the run ends.
    pub last: State,
    /// The number of improvements.
    pub improvements: usize,
    /// True if a step weakened the reference before the policy committed.
    pub weakens: bool,
    /// True if it made the improvements that the start promises (of any number, one) and achieved the objectives that
    /// the policy pursued.
    pub is_kept: bool,
    /// True if the limit of steps ended it.
    pub is_given_up: bool,
}

impl NodePolicy {
    /// Runs the policy from one of its starts, at most for some steps. Returns a fault if its nodes do not follow the
    /// model.
    ///
    /// # Errors
    /// A command has no meaning in a state.
    pub fn run(
        &self,
        program: &Program,
        preferences: &Preferences,
        start: usize,
        most: u64,
        draw: &mut Draw,
    ) -> Result<std::result::Result<NodeRun, PolicyFault>> {
        let (mut run, mut at, mut achieved) = (NodeRun::default(), start, ObjectiveSet::new());
        loop {
            let node = &self.nodes[at];
            achieved.extend_with(&decided(program, preferences, &node.state)?);
            let wanted = self.nodes[start].ahead.unwrap_or(1);
            let is_achieved = node.pursues.iter().all(|objective| achieved.contains(objective));
            run.is_kept = run.improvements >= wanted && is_achieved;
            run.last.clone_from(&node.state);
            if node.actions.is_empty() {
                return Ok(Ok(run));
            }
            if run.steps.len() as u64 == most {
                run.is_given_up = true;
                return Ok(Ok(run));
            }
            let taking = &node.actions[draw.below(node.actions.len())];
            let steps = program.steps(&node.state).map_err(|f| fault::error(program, &f, &node.state))?;
            let wrong = |kind| Ok(Err(PolicyFault { state: node.state.clone(), kind }));
            let found = match step(program, &taking.taken, steps) {
                Ok(found) => found,
                Err(kind) => return wrong(kind),
            };
            let drawn = draw.by_probability(found.successors.iter().map(|(_, p)| *p));
            let state = &found.successors[drawn].0;
            let Some(&to) = taking.next.iter().find(|&&to| self.nodes[to].state == *state) else {
                return wrong(FaultKind::Broken("a successor of an action has no node".to_owned()));
            };
            run.improvements += usize::from(self.improves(preferences, at, to));
            let change = preferences.change(&node.reference, &self.nodes[to].most_preferred);
            let compares = self.promise.aim != Aim::Achieve && !node.commits;
            run.weakens |= compares && change == Change::Weakening;
            run.steps.push((node.state.clone(), found.name));
            at = to;
        }
    }
}

/// Returns the objectives that a path has achieved when it is in a state.
fn decided(program: &Program, preferences: &Preferences, state: &State) -> Result<ObjectiveSet> {
    let mut all = ObjectiveSet::new();
    for (number, objective) in preferences.objectives.iter().enumerate() {
        let (Goal::Reach(decided) | Goal::Satisfy { decided, .. }) = &objective.goal;
        if holds(program, decided, state)? {
            all.insert(number);
        }
    }
    Ok(all)
}
