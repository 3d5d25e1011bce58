//! The choices of single states with exact probabilities, by the compiled program.
//!
//! [`Program::exact_steps`] evaluates every guard and adds fractions. Here the guard index finds the
//! enabled commands, and probabilities are numbers of fractions, each of which is stored once. The
//! probabilities of commands that do not depend on the state are read once.

use ahash::AHashMap;
use num_traits::One;

use super::layout::Layout;
use super::program::{Chances, Prepared};
use super::stepper::{Broken, Stepper};
use crate::error::{Error, Result};
use crate::model::exact::Ratio;
use crate::model::step::{Choice, StepError};
use crate::model::{CommandId, ModelKind, Program, fault};
use crate::progress::ProgressSink;

/// Fractions, each stored once.
#[derive(Debug, Default)]
pub(crate) struct Fractions {
    list: Vec<Ratio>,
    numbers: AHashMap<Ratio, u32>,
    products: AHashMap<(u32, u32), u32>,
    sums: AHashMap<(u32, u32), u32>,
}

impl Fractions {
    /// Returns the fractions in the order of their numbers.
    pub(crate) fn list(&self) -> &[Ratio] {
        &self.list
    }

    /// Returns the number of a fraction; a new one if the fraction is new.
    pub(crate) fn number(&mut self, fraction: Ratio) -> u32 {
        let Fractions { list, numbers, .. } = self;
        *numbers.entry(fraction).or_insert_with_key(|fraction| {
            list.push(fraction.clone());
            list.len() as u32 - 1
        })
    }

    fn product(&mut self, a: u32, b: u32) -> u32 {
        if let Some(&known) = self.products.get(&(a, b)) {
            return known;
        }
        let product = self.number(&self.list[a as usize] * &self.list[b as usize]);
        self.products.insert((a, b), product);
        product
    }

    fn sum(&mut self, a: u32, b: u32) -> u32 {
        if let Some(&known) = self.sums.get(&(a, b)) {
            return known;
        }
        let sum = self.number(&self.list[a as usize] + &self.list[b as usize]);
        self.sums.insert((a, b), sum);
        sum
    }
}

/// A choice with its successors.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Weighted {
    /// The choice.
    pub(crate) choice: Choice,
    /// Each successor once, with the number of its probability; ordered by values.
    pub(crate) successors: Vec<(Vec<i64>, u32)>,
}

/// Lists the choices of states, as [`Program::exact_steps`] does, without their names.
pub(crate) struct Walker<'p> {
    program: &'p Program,
    layout: Layout,
    prepared: Prepared,
    /// The probabilities of the branches of each command, if they do not depend on the state.
    constant: Vec<Option<Vec<u32>>>,
}

impl<'p> Walker<'p> {
    /// Compiles a program.
    ///
    /// # Errors
    /// The states need more than 2048 bits, or the work is cancelled.
    pub(crate) fn new(program: &'p Program, sink: &dyn ProgressSink) -> Result<Self> {
        let layout = Layout::packed(program)?;
        let prepared = Prepared::new(program, &layout, sink)?;
        let constant = vec![None; program.commands.len()];
        Ok(Walker { program, layout, prepared, constant })
    }

    /// Creates the walk, which keeps work between states.
    pub(crate) fn walk(&mut self) -> Box<dyn Walk + '_> {
        let Walker { program, layout, prepared, constant } = self;
        match layout.words() {
            1 => Run::<1>::boxed(program, layout, prepared, constant),
            2 => Run::<2>::boxed(program, layout, prepared, constant),
            3 => Run::<3>::boxed(program, layout, prepared, constant),
            4 => Run::<4>::boxed(program, layout, prepared, constant),
            5..=8 => Run::<8>::boxed(program, layout, prepared, constant),
            9..=16 => Run::<16>::boxed(program, layout, prepared, constant),
            _ => Run::<32>::boxed(program, layout, prepared, constant),
        }
    }
}

/// A walk over states.
pub(crate) trait Walk {
    /// Returns the choices of a state in the order of [`Program::steps`].
    ///
    /// # Errors
    /// A command has no meaning in the state, or there are too many choices.
    fn choices(&mut self, state: &[i64], fractions: &mut Fractions) -> Result<Vec<Weighted>>;
}

struct Run<'w, const W: usize> {
    program: &'w Program,
    layout: &'w Layout,
    stepper: Stepper<'w, W>,
    prepared: &'w Prepared,
    constant: &'w mut [Option<Vec<u32>>],
}

impl<const W: usize> Walk for Run<'_, W> {
    fn choices(&mut self, state: &[i64], fractions: &mut Fractions) -> Result<Vec<Weighted>> {
        let Some(code) = self.layout.encode(state) else { return Ok(Vec::new()) };
        self.stepper.enter_values(state);
        self.stepper.expand().map_err(|broken| self.error(broken, state))?;
        if self.stepper.ends.is_empty() {
            let one = fractions.number(Ratio::one());
            return Ok(vec![Weighted { choice: Choice::Deadlock, successors: vec![(state.to_vec(), one)] }]);
        }
        let (mut found, mut at) = (Vec::new(), 0);
        for synchronisation in 0..self.prepared.synchronisations.len() {
            for number in 0..self.stepper.combinations(synchronisation) {
                let commands = self.stepper.combination(synchronisation, number);
                let weights = self.weights(&commands, state, fractions)?;
                let steps = &self.stepper.steps[at..at + weights.len()];
                at += weights.len();
                let target = |(step, weight): (&[u64; W], u32)| {
                    let mut to = [0; W];
                    to.iter_mut().zip(&code).zip(step).for_each(|((to, a), b)| *to = a.wrapping_add(*b));
                    let mut values = vec![0; state.len()];
                    self.layout.decode(&to, &mut values);
                    (values, weight)
                };
                let successors = steps.iter().zip(weights).map(target).collect();
                let commands = commands.iter().map(|&c| CommandId(c)).collect();
                found
                    .push(Weighted { choice: Choice::Combination { synchronisation, commands }, successors });
            }
        }
        if self.program.kind == ModelKind::Dtmc {
            found = vec![uniform(found, fractions)];
        }
        found.iter_mut().for_each(|choice| merge(&mut choice.successors, fractions));
        Ok(found)
    }
}

impl<'w, const W: usize> Run<'w, W> {
    fn boxed(
        program: &'w Program,
        layout: &'w Layout,
        prepared: &'w Prepared,
        constant: &'w mut [Option<Vec<u32>>],
    ) -> Box<dyn Walk + 'w> {
        Box::new(Run::<W> { program, layout, stepper: Stepper::new(prepared), prepared, constant })
    }

    /// Returns the probabilities of all ways to take a branch of each command, in the order of the
    /// stepper.
    fn weights(&mut self, commands: &[u32], state: &[i64], fractions: &mut Fractions) -> Result<Vec<u32>> {
        if let &[command] = commands {
            return self.branches(command, state, fractions);
        }
        let mut weights = vec![fractions.number(Ratio::one())];
        for &command in commands.iter().rev() {
            let own = self.branches(command, state, fractions)?;
            let Some((&first, others)) = own.split_first() else { continue };
            let until = weights.len();
            for &other in others {
                for at in 0..until {
                    weights.push(fractions.product(weights[at], other));
                }
            }
            weights[..until].iter_mut().for_each(|weight| *weight = fractions.product(*weight, first));
        }
        Ok(weights)
    }

    /// Returns the probabilities of the branches of a command that are positive.
    fn branches(&mut self, command: u32, state: &[i64], fractions: &mut Fractions) -> Result<Vec<u32>> {
        let index = command as usize;
        if let Some(known) = &self.constant[index] {
            return Ok(known.clone());
        }
        let exact = self.program.exact_branches(CommandId(command), state);
        let exact = exact.map_err(|fault| fault::error(self.program, &fault, state))?;
        let numbers: Vec<u32> = exact.into_iter().map(|p| fractions.number(p)).collect();
        if self.prepared.commands[index].chances != Chances::Vary {
            self.constant[index] = Some(numbers.clone());
        }
        Ok(numbers)
    }

    /// Returns the error of a state that cannot be expanded.
    fn error(&self, broken: Broken, state: &[i64]) -> Error {
        match (broken, self.program.steps(state)) {
            (Broken::Limit(limit), _) => limit.into(),
            (Broken::Fault, Err(fault)) => fault::error(self.program, &fault, state),
            (Broken::Fault, Ok(_)) => fault::error(self.program, &StepError::TooMany, state),
        }
    }
}

/// Merges all choices into one that selects each with the same probability.
fn uniform(choices: Vec<Weighted>, fractions: &mut Fractions) -> Weighted {
    let share = fractions.number(Ratio::new(1.into(), choices.len().into()));
    let mut successors: Vec<_> = choices.into_iter().flat_map(|choice| choice.successors).collect();
    successors.iter_mut().for_each(|(_, weight)| *weight = fractions.product(*weight, share));
    Weighted { choice: Choice::Uniform, successors }
}

/// Sorts the successors and adds up the probabilities of equal ones.
fn merge(successors: &mut Vec<(Vec<i64>, u32)>, fractions: &mut Fractions) {
    if successors.len() < 2 {
        return;
    }
    successors.sort_by(|a, b| a.0.cmp(&b.0));
    successors.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 = fractions.sum(kept.1, next.1);
        }
        same
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::SourceFile;
    use crate::lang;
    use crate::progress::NoProgress;

    fn same(model: &str) {
        let read = |name, text: &str| SourceFile::new(name, text);
        let program = lang::load(&read("model", model), &read("constants", "")).unwrap().program;
        let (mut fractions, mut walker) = (Fractions::default(), Walker::new(&program, &NoProgress).unwrap());
        let mut walk = walker.walk();
        let (mut states, mut next) = (vec![vec![0; program.variables.len()]], 0);
        while next < states.len() {
            let state = states[next].clone();
            let found = walk.choices(&state, &mut fractions).unwrap();
            let expected = program.exact_steps(&state).unwrap();
            assert_eq!(found.len(), expected.len(), "{state:?}");
            for (found, expected) in found.iter().zip(expected) {
                assert_eq!(found.choice, expected.choice, "{state:?}");
                let exact = |(to, p): &(Vec<i64>, u32)| (to.clone(), fractions.list()[*p as usize].clone());
                let successors: Vec<_> = found.successors.iter().map(exact).collect();
                assert_eq!(successors, expected.successors, "{state:?}");
                for (to, _) in successors {
                    if !states.contains(&to) {
                        states.push(to);
                    }
                }
            }
            next += 1;
        }
        assert!(states.len() > 5);
    }

    const MODULES: &str = "module m x:[0..3];
          [a] x<3 -> 0.1:(x'=x+1) + 0.2:true + 0.7:(x'=0); [a] x>1 -> 1/3:(x'=x-1) + 2/3:true;
          [] x=1 -> x/3:(x'=2) + 1-x/3:(x'=3); [c] x=3 -> true;
        endmodule
        module n y:[0..2]; [a] y<2 -> 0.5:(y'=y+1) + 0.5:(y'=0); [a] y=0 -> (y'=2); [c] y=2 -> (y'=0); endmodule";

    #[test]
    fn choices_and_probabilities_are_those_of_exact_steps() {
        same(&format!("mdp {MODULES}"));
        same(&format!("dtmc {MODULES}"));
    }
}
