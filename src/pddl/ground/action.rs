//! Ground actions, with one list of effects for each outcome.

use std::rc::Rc;

use ahash::AHashMap;
use num_traits::One;

use super::database::Key;
use super::earned::{Earned, earned};
use super::outcomes::{Change, Outcomes};
use super::reach::Reached;
use super::reach::every;
use super::{Atoms, Fact, Ground, Meaning};
use crate::task::{Action, Condition, Effect, Object, Task};
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
    /// The amounts that the action adds to the measures, on average over its outcomes.
    pub(crate) earned: Vec<Earned>,
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
/// A limit; an action with too many outcomes, or with an amount that has no value.
pub(super) fn ground(
    task: &Task,
    reached: &Reached,
    atoms: &Atoms,
    sink: &dyn ProgressSink,
) -> Result<Vec<GroundAction>> {
    let mut poll = Poll::new(sink);
    let mut all = Vec::new();
    for (schema, action) in task.actions.iter().enumerate() {
        let has_alternatives = action.effect.has_alternatives();
        for row in reached.applicable(schema) {
            poll.step()?;
            let precondition = atoms.ground(&action.precondition, &mut row.to_vec());
            if precondition == Ground::False {
                continue;
            }
            let outcomes = if has_alternatives {
                outcomes(task, atoms, action, row)?
            } else {
                let mut effects = Vec::new();
                atoms.changes(&action.effect, &mut row.to_vec(), &Ground::True, &mut effects);
                prevail(&mut effects);
                vec![Outcome { probability: Ratio::one(), effects }]
            };
            let earned = earned(task, atoms, action, row)?;
            all.push(GroundAction { schema, arguments: row.to_vec(), precondition, outcomes, earned });
        }
    }
    Ok(all)
}

/// Returns the outcomes of an effect with alternatives.
///
/// # Errors
/// There are too many.
fn outcomes(task: &Task, atoms: &Atoms, action: &Action, row: &[Object]) -> Result<Vec<Outcome>> {
    match Outcomes::new(atoms, &action.effect, &mut row.to_vec(), &Rc::default()) {
        Some(outcomes) => Ok(simplified(atoms, outcomes)),
        None => {
            let name = task.called(&action.name, row);
            let message = format!("`{name}` has more than {} outcomes", super::outcomes::MOST_OUTCOMES);
            let wrong = Diagnostic::new(&task.source, action.span.clone(), message);
            Err(wrong.help("split it into several actions, one after the other").into())
        }
    }
}

/// Leaves out changes that have no effect, and joins outcomes that have become equal.
fn simplified(atoms: &Atoms, outcomes: Outcomes) -> Vec<Outcome> {
    let mut all: Vec<Outcome> = Vec::new();
    let mut known: AHashMap<Vec<GroundEffect>, usize> = AHashMap::new();
    for (probability, changes) in outcomes.with_probabilities() {
        let effects = effects(atoms, &changes);
        match known.get(&effects) {
            Some(&at) => all[at].probability += probability,
            None => {
                known.insert(effects.clone(), all.len());
                all.push(Outcome { probability, effects });
            }
        }
    }
    if let [only] = all.as_mut_slice() {
        only.probability = Ratio::one();
    }
    all
}

fn effects(atoms: &Atoms, changes: &[Rc<Change>]) -> Vec<GroundEffect> {
    let mut effects = Vec::new();
    // Changes under the same conditions are often neighbours.
    let mut last: Option<(&Rc<Vec<Condition>>, Ground)> = None;
    for change in changes {
        let Some(Meaning::Fact(fact)) = atoms.get(change.atom.0, &change.atom.1) else { continue };
        let condition = match &last {
            Some((conditions, known)) if Rc::ptr_eq(conditions, &change.conditions) => known.clone(),
            _ => {
                let parts = change.conditions.iter().map(|c| atoms.ground(c, &mut Vec::new()));
                Ground::join(true, parts.collect::<Vec<_>>())
            }
        };
        if condition != Ground::False {
            effects.push(GroundEffect { fact, is_added: change.is_added, condition: condition.clone() });
        }
        last = Some((&change.conditions, condition));
    }
    prevail(&mut effects);
    effects
}

/// Sorts effects, of which a fact that is added and deleted keeps the addition.
fn prevail(effects: &mut Vec<GroundEffect>) {
    effects.sort_unstable();
    effects.dedup();
    let is_sure = |effect: &GroundEffect| effect.is_added && effect.condition == Ground::True;
    let added: Vec<Fact> = effects.iter().filter(|e| is_sure(e)).map(|e| e.fact).collect();
    effects.retain(|effect| is_sure(effect) || added.binary_search(&effect.fact).is_err());
}

impl Atoms {
    /// Lists the changes of an effect without alternatives. Conditions are evaluated on the way, so that
    /// large effects of which little is left cost little.
    fn changes(
        &self,
        effect: &Effect,
        values: &mut Vec<Object>,
        condition: &Ground,
        all: &mut Vec<GroundEffect>,
    ) {
        match effect {
            Effect::Earn(_) => {}
            Effect::Literal(atom, is_added) => {
                let row: Key = atom.arguments.iter().map(|term| term.object(values)).collect();
                if let Some(Meaning::Fact(fact)) = self.get(atom.predicate, &row) {
                    all.push(GroundEffect { fact, is_added: *is_added, condition: condition.clone() });
                }
            }
            Effect::When(further, inner) => {
                let both = Ground::join(true, [condition.clone(), self.ground(further, values)]);
                if both != Ground::False {
                    self.changes(inner, values, &both, all);
                }
            }
            Effect::All(domains, inner) => every(domains, values, &mut |values| {
                self.changes(inner, &mut values.to_vec(), condition, all);
            }),
            Effect::And(parts) | Effect::OneOf(parts) => {
                parts.iter().for_each(|part| self.changes(part, values, condition, all));
            }
            Effect::Probably(parts) => {
                parts.iter().for_each(|(_, part)| self.changes(part, values, condition, all));
            }
        }
    }
}
