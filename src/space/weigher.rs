//! The probabilities of the choices of a state, as numbers of fractions.

use smallvec::SmallVec;

use super::fractions::Fractions;
use super::program::{Chances, Prepared};
use super::stepper::Stepper;
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_model::{CommandId, ModelKind, Program, State, fault};

/// Finds the probabilities of choices. Those of commands that do not depend on the state are read once.
pub(crate) struct Weigher<'p> {
    program: &'p Program,
    prepared: &'p Prepared,
    /// The probabilities of the branches of each command, in the last state in which they were read.
    known: Vec<Option<SmallVec<[u32; 8]>>>,
    /// The probability of each step, once they are found.
    pub(crate) weights: Vec<u32>,
}

impl<'p> Weigher<'p> {
    pub(crate) fn new(program: &'p Program, prepared: &'p Prepared) -> Self {
        let known = vec![None; program.commands.len()];
        Weigher { program, prepared, known, weights: Vec::new() }
    }

    /// Finds the probability of each of [`Stepper::steps`] in the current state of the stepper, whose choices are listed;
    /// `state` returns the values of that state.
    ///
    /// # Errors
    /// A probability has no value.
    pub(crate) fn weigh<const W: usize>(
        &mut self,
        stepper: &Stepper<'_, W>,
        state: &dyn Fn() -> State,
        fractions: &mut Fractions,
    ) -> Result<()> {
        self.weights.clear();
        let mut choices = 0;
        for &synchronisation in &stepper.active {
            let own = stepper.combinations(synchronisation);
            choices += own;
            for number in 0..own {
                self.combine(&stepper.combination(synchronisation, number), state, fractions)?;
            }
        }
        if self.program.kind == ModelKind::Dtmc && choices > 1 {
            let share = fractions.number(Ratio::new(1.into(), choices.into()));
            self.weights.iter_mut().for_each(|weight| *weight = fractions.product(*weight, share));
        }
        Ok(())
    }

    /// Adds the probabilities of all ways to take a branch of each of some commands, in the order of the stepper.
    fn combine(
        &mut self,
        commands: &[u32],
        state: &dyn Fn() -> State,
        fractions: &mut Fractions,
    ) -> Result<()> {
        let mut weights = std::mem::take(&mut self.weights);
        let start = weights.len();
        for &command in commands.iter().rev() {
            let own = self.branches(command, state, fractions)?;
            if weights.len() == start {
                weights.extend_from_slice(own);
                continue;
            }
            let Some((&first, others)) = own.split_first() else { continue };
            let until = weights.len();
            for &other in others {
                for at in start..until {
                    weights.push(fractions.product(weights[at], other));
                }
            }
            weights[start..until].iter_mut().for_each(|weight| *weight = fractions.product(*weight, first));
        }
        self.weights = weights;
        Ok(())
    }

    /// Returns the probabilities of the branches of a command that are positive.
    fn branches(
        &mut self,
        command: u32,
        state: &dyn Fn() -> State,
        fractions: &mut Fractions,
    ) -> Result<&[u32]> {
        let index = command as usize;
        if self.known[index].is_none() || self.prepared.commands[index].chances == Chances::Vary {
            let state = state();
            let exact = self.program.exact_branches(CommandId(command), &state);
            let exact = exact.map_err(|fault| fault::error(self.program, &fault, &state))?;
            self.known[index] = Some(exact.into_iter().map(|p| fractions.number(p)).collect());
        }
        Ok(self.known[index].as_deref().unwrap_or_default())
    }
}
