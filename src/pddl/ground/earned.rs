//! The amounts that ground actions add to the measures: rewards and costs, averaged over outcomes.

use std::collections::BTreeMap;

use num_traits::{One, Zero};

use super::reach::every;
use super::{Atoms, Ground};
use crate::task::{Action, Effect, Measure, Object, Task};
use meliora_base::error::Result;
use meliora_base::exact::Ratio;

/// An amount that an action adds to a measure in the states of a condition.
#[derive(Debug)]
pub(crate) struct Earned {
    pub(crate) measure: Measure,
    pub(crate) condition: Ground,
    pub(crate) amount: Ratio,
}

/// The sum of the amounts under each condition.
struct Sums<'t> {
    task: &'t Task,
    atoms: &'t Atoms,
    action: &'t Action,
    sums: BTreeMap<(Measure, Ground), Ratio>,
}

/// Returns what an action with these arguments adds. Amounts under the same condition are one.
///
/// # Errors
/// A function has no value for the arguments, or one below 0 for a cost.
pub(super) fn earned(task: &Task, atoms: &Atoms, action: &Action, row: &[Object]) -> Result<Vec<Earned>> {
    if task.measures.is_empty() {
        return Ok(Vec::new());
    }
    let mut sums = Sums { task, atoms, action, sums: BTreeMap::new() };
    sums.add(&action.effect, &mut row.to_vec(), (&Ground::True, &Ratio::one()))?;
    let all = sums.sums.into_iter().filter(|(_, amount)| !amount.is_zero());
    Ok(all.map(|((measure, condition), amount)| Earned { measure, condition, amount }).collect())
}

impl Sums<'_> {
    /// Adds the amounts of an effect that happens under a condition, with a probability.
    fn add(
        &mut self,
        effect: &Effect,
        values: &mut Vec<Object>,
        (condition, probability): (&Ground, &Ratio),
    ) -> Result<()> {
        match effect {
            // No amount depends on the outcome of `oneof`.
            Effect::Literal(..) | Effect::OneOf(_) => Ok(()),
            Effect::Earn(amount) => {
                let value = self.task.amount(self.action, amount, values)? * probability;
                *self.sums.entry((amount.measure, condition.clone())).or_default() += value;
                Ok(())
            }
            Effect::And(parts) => {
                parts.iter().try_for_each(|part| self.add(part, values, (condition, probability)))
            }
            Effect::When(further, inner) => {
                let both = Ground::join(true, [condition.clone(), self.atoms.ground(further, values)]);
                if both == Ground::False { Ok(()) } else { self.add(inner, values, (&both, probability)) }
            }
            Effect::All(domains, inner) => {
                let mut end = Ok(());
                every(domains, values, &mut |values| {
                    if end.is_ok() {
                        end = self.add(inner, &mut values.to_vec(), (condition, probability));
                    }
                });
                end
            }
            Effect::Probably(parts) => parts
                .iter()
                .try_for_each(|(share, part)| self.add(part, values, (condition, &(share * probability)))),
        }
    }
}
