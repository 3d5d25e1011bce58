//! The probabilities of the choices of the states that were explored.

use num_traits::One;

use super::explore::Task;
use super::fractions::Fractions;
use super::graph::Graph;
use super::lists::{Collected, Lists};
use super::meter::Meter;
use super::stepper::{Stepper, sum};
use super::weigher::Weigher;
use meliora_base::error::Result;
use meliora_base::exact::Ratio;

/// The probabilities of the successors of all choices, by choice. Many choices have the same.
#[derive(Debug)]
pub struct Probabilities {
    fractions: Fractions,
    lists: Lists,
}

impl Probabilities {
    /// Returns all probabilities.
    pub fn fractions(&self) -> &Fractions {
        &self.fractions
    }

    /// Returns the numbers of the probabilities of the successors of a choice, in the order of the graph.
    #[inline]
    pub fn of(&self, choice: usize) -> &[u32] {
        self.lists.list(self.lists.number(choice))
    }
}

/// The probabilities of choices, while states are explored.
pub(crate) struct Weighed {
    fractions: Fractions,
    collected: Collected,
}

impl Weighed {
    pub(crate) fn new(meter: &Meter) -> Self {
        let mut fractions = Fractions::default();
        let sure = fractions.number(Ratio::one());
        Weighed { fractions, collected: Collected::new(meter, &[sure]) }
    }

    /// Adds a choice with one successor.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub(crate) fn certain(&mut self) -> Result<()> {
        self.collected.add_first()
    }

    pub(crate) fn finish(self) -> Probabilities {
        Probabilities { fractions: self.fractions, lists: self.collected.finish() }
    }
}

/// Adds choices with their probabilities.
pub(crate) struct Weighing<'t, const W: usize> {
    task: &'t Task,
    weigher: Weigher<'t>,
    /// The successors of a choice: the code and the number of each, and the number of its probability.
    successors: Vec<(([u64; W], u32), u32)>,
}

impl<'t, const W: usize> Weighing<'t, W> {
    pub(crate) fn new(task: &'t Task) -> Self {
        let weigher = Weigher::new(&task.program, &task.prepared);
        Weighing { task, weigher, successors: Vec::new() }
    }

    /// Finds the probabilities of the current state of the stepper, for [`Weighing::add`]; returns false if one has no value.
    pub(crate) fn weigh(&mut self, stepper: &Stepper<'_, W>, code: &[u64; W], into: &mut Weighed) -> bool {
        let Weighing { task, weigher, .. } = self;
        // Certain steps need none.
        stepper.ends.len() == stepper.steps.len()
            || weigher.weigh(stepper, &|| task.values(code), &mut into.fractions).is_ok()
    }

    /// Adds the choices of the current state of the stepper, given its code and the numbers of its steps. The
    /// successors of a choice are each once, in the order of the values. Returns false if there are too many lists.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub(crate) fn add(
        &mut self,
        stepper: &Stepper<'_, W>,
        (code, numbers): (&[u64; W], &[u32]),
        graph: &mut Graph,
        into: &mut Weighed,
    ) -> Result<bool> {
        let (mut at, mut is_kept) = (0, true);
        for &end in &stepper.ends {
            let own = at..end as usize;
            at = end as usize;
            if own.len() == 1 {
                graph.extend(&numbers[own])?;
                graph.end_row()?;
                into.certain()?;
                continue;
            }
            self.successors.clear();
            let steps = stepper.steps[own.clone()].iter().map(|step| sum(code, step));
            let found = steps.zip(&numbers[own.clone()]).zip(&self.weigher.weights[own]);
            self.successors.extend(found.map(|((code, &number), &weight)| ((code, number), weight)));
            into.fractions.unite(&mut self.successors);
            into.collected.key.clear();
            for &((_, number), weight) in &self.successors {
                graph.extend(&[number])?;
                into.collected.key.push(weight);
            }
            graph.end_row()?;
            is_kept &= into.collected.add()?;
        }
        Ok(is_kept)
    }
}
