//! Ground actions, with one list of effects for each outcome.

use num_traits::One;

use super::outcomes::{Change, Outcomes};
use super::reach::Reached;
use super::{Atoms, Fact, Ground, Meaning};
use crate::task::{Object, Task};
use meliora_base::error::{Diagnostic, Result};
use meliora_base::exact::Ratio;
use meliora_base::progress::{Poll, ProgressSink};

/// An action for some objects.
#[derive(Debug)]
pub(crate) struct GroundAction {
    /// Its position in [`Task::actions`].
    pub(crate) schema: usize,
    pub(crate) arguments: Vec<Object>,
    pub(crate) precondition: Ground,
    pub(crate) outcomes: Vec<Outcome>,
}

/// One of the things that an action can do.
#[derive(Debug)]
pub(crate) struct Outcome {
    pub(crate) probability: Ratio,
    pub(crate) effects: Vec<GroundEffect>,
}

/// The addition or deletion of a fact, under a condition on the state before.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct GroundEffect {
    pub(crate) fact: Fact,
    pub(crate) is_added: bool,
    pub(crate) condition: Ground,
}

/// Grounds all reachable actions.
///
/// # Errors
/// A limit; an action with too many outcomes.
pub(super) fn ground(
    task: &Task,
    reached: &Reached,
    atoms: &Atoms,
    sink: &dyn ProgressSink,
) -> Result<Vec<GroundAction>> {
    let mut poll = Poll::new(sink);
    let mut all = Vec::new();
    for (schema, action) in task.actions.iter().enumerate() {
        for row in reached.applicable(schema) {
            poll.step()?;
            let precondition = atoms.ground(&action.precondition, &mut row.to_vec());
            if precondition == Ground::False {
                continue;
            }
            let Some(outcomes) = Outcomes::of(&action.effect, &mut row.to_vec(), &mut Vec::new()) else {
                let name = task.called(&action.name, row);
                let message = format!("`{name}` has more than {} outcomes", super::outcomes::MOST_OUTCOMES);
                let wrong = Diagnostic::new(&task.source, action.span.clone(), message);
                return Err(wrong.help("split it into several actions, one after the other").into());
            };
            let outcomes = simplified(atoms, outcomes);
            all.push(GroundAction { schema, arguments: row.to_vec(), precondition, outcomes });
        }
    }
    Ok(all)
}

/// Leaves out changes that have no effect, and joins outcomes that have become equal.
fn simplified(atoms: &Atoms, outcomes: Outcomes) -> Vec<Outcome> {
    let mut all: Vec<Outcome> = Vec::new();
    for (probability, changes) in outcomes.with_probabilities() {
        let effects = effects(atoms, &changes);
        match all.iter_mut().find(|known| known.effects == effects) {
            Some(known) => known.probability += probability,
            None => all.push(Outcome { probability, effects }),
        }
    }
    if let [only] = all.as_mut_slice() {
        only.probability = Ratio::one();
    }
    all
}

fn effects(atoms: &Atoms, changes: &[Change]) -> Vec<GroundEffect> {
    let mut effects = Vec::new();
    for change in changes {
        let Some(&Meaning::Fact(fact)) = atoms.known.get(&change.atom) else { continue };
        let conditions = change.conditions.iter().map(|c| atoms.ground(c, &mut Vec::new()));
        let condition = Ground::join(true, conditions.collect::<Vec<_>>());
        if condition != Ground::False {
            effects.push(GroundEffect { fact, is_added: change.is_added, condition });
        }
    }
    effects.sort_unstable();
    effects.dedup();
    // A fact that is added and deleted is added.
    let added: Vec<Fact> =
        effects.iter().filter(|e| e.is_added && e.condition == Ground::True).map(|e| e.fact).collect();
    effects.retain(|e| (e.is_added && e.condition == Ground::True) || added.binary_search(&e.fact).is_err());
    effects
}
