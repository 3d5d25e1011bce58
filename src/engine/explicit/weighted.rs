//! The choices of single states with exact probabilities, by the compiled program.
//!
//! [`Program::exact_steps`] evaluates every guard and adds fractions. Here the guard index finds the
//! enabled commands, and probabilities are numbers of fractions, each of which is stored once. The
//! probabilities of commands that do not depend on the state are read once.

use std::borrow::Cow;

use ahash::AHashMap;
use num_traits::One;
use smallvec::SmallVec;

use super::layout::Layout;
use super::program::{Chances, Prepared};
use super::stepper::Stepper;
use meliora_model::error::{Error, Result};
use meliora_model::exact::{Ratio, Real};
use meliora_model::progress::ProgressSink;
use meliora_model::step::{Choice, Combination};
use meliora_model::{CommandId, ModelKind, Program, State, fault};

/// Fractions, each stored once.
#[derive(Debug, Default)]
pub struct Fractions {
    list: Vec<Ratio>,
    /// The numbers by fraction; see the hash of [`Real`].
    numbers: AHashMap<Real, u32>,
    products: AHashMap<(u32, u32), u32>,
    sums: AHashMap<(u32, u32), u32>,
}

impl Fractions {
    /// Returns the fractions in the order of their numbers.
    pub fn list(&self) -> &[Ratio] {
        &self.list
    }

    /// Returns the number of a fraction; a new one if the fraction is new.
    pub fn number(&mut self, fraction: Ratio) -> u32 {
        let Fractions { list, numbers, .. } = self;
        *numbers.entry(Real::Finite(fraction)).or_insert_with_key(|fraction| {
            list.extend(fraction.finite().cloned());
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

/// A state in few bytes. Codes compare as the values do.
pub type Code = SmallVec<[u64; 2]>;

/// The codes of the states of a program.
#[derive(Debug, Clone)]
pub struct Codec {
    layout: Layout,
    variables: usize,
}

impl Codec {
    /// Creates the codes of a program.
    ///
    /// # Errors
    /// The states need more than 2048 bits.
    pub fn new(program: &Program) -> Result<Self> {
        Ok(Codec { layout: Layout::packed(program)?, variables: program.variables.len() })
    }

    /// Returns the number of words of a code.
    pub fn words(&self) -> usize {
        self.layout.words()
    }

    /// Returns the code of a state; `None` if a value is out of range.
    pub fn encode(&self, state: &[i64]) -> Option<Code> {
        self.layout.encode(state).map(Code::from_vec)
    }

    /// Returns the code of a state.
    ///
    /// # Errors
    /// A value is out of range.
    pub fn known(&self, state: &[i64]) -> Result<Code> {
        let wrong = || Error::Usage("a value of a state is out of range".to_owned());
        self.encode(state).ok_or_else(wrong)
    }

    /// Returns the state of a code.
    pub fn decode(&self, code: &[u64]) -> State {
        let mut state = vec![0; self.variables];
        self.layout.decode(code, &mut state);
        state
    }
}

/// A choice with its successors.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Weighted {
    /// The choice.
    pub choice: Choice,
    /// The combinations of commands that a [`Choice::Uniform`] draws from.
    drawn: Vec<Combination>,
    /// Each successor once, with the number of its probability; ordered by values.
    pub successors: Vec<(Code, u32)>,
}

impl Weighted {
    /// Returns the combinations of commands that the choice draws from; none for a deadlock.
    pub fn combinations(&self) -> Cow<'_, [Combination]> {
        match &self.choice {
            Choice::Combination { synchronisation, commands } => {
                Cow::Owned(vec![(*synchronisation, commands.clone())])
            }
            _ => Cow::Borrowed(&self.drawn),
        }
    }
}

/// The numbers of some probabilities.
type Weights = SmallVec<[u32; 8]>;

/// Lists the choices of states, as [`Program::exact_steps`] does, without their names.
pub struct Walker<'p> {
    program: &'p Program,
    codec: Codec,
    prepared: Prepared,
    /// The probabilities of the branches of each command, if they do not depend on the state.
    constant: Vec<Option<Weights>>,
}

impl<'p> Walker<'p> {
    /// Compiles a program.
    ///
    /// # Errors
    /// The states need more than 2048 bits, or the work is cancelled.
    pub fn new(program: &'p Program, sink: &dyn ProgressSink) -> Result<Self> {
        let codec = Codec::new(program)?;
        let prepared = Prepared::new(program, &codec.layout, sink)?;
        let constant = vec![None; program.commands.len()];
        Ok(Walker { program, codec, prepared, constant })
    }

    /// Returns the codes of the states.
    pub fn codec(&self) -> &Codec {
        &self.codec
    }

    /// Creates the walk, which keeps work between states.
    pub fn walk(&mut self) -> Box<dyn Walk + '_> {
        let Walker { program, codec, prepared, constant } = self;
        match codec.layout.words() {
            1 => PackedWalk::<1>::boxed(program, codec, prepared, constant),
            2 => PackedWalk::<2>::boxed(program, codec, prepared, constant),
            3 => PackedWalk::<3>::boxed(program, codec, prepared, constant),
            4 => PackedWalk::<4>::boxed(program, codec, prepared, constant),
            5..=8 => PackedWalk::<8>::boxed(program, codec, prepared, constant),
            9..=16 => PackedWalk::<16>::boxed(program, codec, prepared, constant),
            _ => PackedWalk::<32>::boxed(program, codec, prepared, constant),
        }
    }
}

/// A walk over states.
pub trait Walk {
    /// Returns the choices of a state in the order of [`Program::steps`].
    ///
    /// # Errors
    /// A command has no meaning in the state, or there are too many choices.
    fn choices(&mut self, state: &[u64], fractions: &mut Fractions) -> Result<Vec<Weighted>>;

    /// Returns the names of the choices of a state, as [`Program::choices`] does.
    ///
    /// # Errors
    /// A command has no meaning in the state, or there are too many choices.
    fn names(&mut self, state: &[u64]) -> Result<Vec<String>>;
}

struct PackedWalk<'w, const W: usize> {
    program: &'w Program,
    codec: &'w Codec,
    stepper: Stepper<'w, W>,
    prepared: &'w Prepared,
    constant: &'w mut [Option<Weights>],
}

impl<const W: usize> Walk for PackedWalk<'_, W> {
    fn choices(&mut self, state: &[u64], fractions: &mut Fractions) -> Result<Vec<Weighted>> {
        self.expand(state)?;
        if self.stepper.ends.is_empty() {
            let one = fractions.number(Ratio::one());
            let successors = vec![(state.into(), one)];
            return Ok(vec![Weighted { choice: Choice::Deadlock, drawn: Vec::new(), successors }]);
        }
        let (mut found, mut at) = (Vec::new(), 0);
        for synchronisation in 0..self.prepared.synchronisations.len() {
            for number in 0..self.stepper.combinations(synchronisation) {
                let commands = self.stepper.combination(synchronisation, number);
                let weights = self.weights(&commands, state, fractions)?;
                let steps = &self.stepper.steps[at..at + weights.len()];
                at += weights.len();
                let target = |(step, weight): (&[u64; W], u32)| {
                    let sums = state.iter().zip(step).map(|(a, b)| a.wrapping_add(*b));
                    (sums.collect(), weight)
                };
                let successors = steps.iter().zip(weights).map(target).collect();
                let commands = commands.iter().map(|&c| CommandId(c)).collect();
                let choice = Choice::Combination { synchronisation, commands };
                found.push(Weighted { choice, drawn: Vec::new(), successors });
            }
        }
        if self.program.kind == ModelKind::Dtmc {
            found = vec![uniform(found, fractions)];
        }
        found.iter_mut().for_each(|choice| merge(&mut choice.successors, fractions));
        Ok(found)
    }

    fn names(&mut self, state: &[u64]) -> Result<Vec<String>> {
        self.expand(state)?;
        if self.stepper.ends.is_empty() {
            return Ok(vec!["deadlock".to_owned()]);
        }
        let mut all = Vec::new();
        for synchronisation in 0..self.prepared.synchronisations.len() {
            for number in 0..self.stepper.combinations(synchronisation) {
                let commands = self.stepper.combination(synchronisation, number);
                all.push((synchronisation, commands.iter().map(|&c| CommandId(c)).collect()));
            }
        }
        let names = self.program.names(&all);
        Ok(if self.program.kind == ModelKind::Dtmc { vec![names.join("+")] } else { names })
    }
}

impl<'w, const W: usize> PackedWalk<'w, W> {
    fn boxed(
        program: &'w Program,
        codec: &'w Codec,
        prepared: &'w Prepared,
        constant: &'w mut [Option<Weights>],
    ) -> Box<dyn Walk + 'w> {
        Box::new(PackedWalk::<W> { program, codec, stepper: Stepper::new(prepared), prepared, constant })
    }

    /// Lists the commands that are enabled in a state, and their effects.
    fn expand(&mut self, state: &[u64]) -> Result<()> {
        self.stepper.enter(&self.codec.layout, state);
        self.stepper.expand().map_err(|broken| broken.error(self.program, &self.codec.decode(state)))
    }

    /// Returns the probabilities of all ways to take a branch of each command, in the order of the
    /// stepper.
    fn weights(&mut self, commands: &[u32], state: &[u64], fractions: &mut Fractions) -> Result<Weights> {
        if let &[command] = commands {
            return self.branches(command, state, fractions);
        }
        let mut weights = Weights::from_slice(&[fractions.number(Ratio::one())]);
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
    fn branches(&mut self, command: u32, state: &[u64], fractions: &mut Fractions) -> Result<Weights> {
        let index = command as usize;
        if let Some(known) = &self.constant[index] {
            return Ok(known.clone());
        }
        let state = self.codec.decode(state);
        let exact = self.program.exact_branches(CommandId(command), &state);
        let exact = exact.map_err(|fault| fault::error(self.program, &fault, &state))?;
        let numbers: Weights = exact.into_iter().map(|p| fractions.number(p)).collect();
        if self.prepared.commands[index].chances != Chances::Vary {
            self.constant[index] = Some(numbers.clone());
        }
        Ok(numbers)
    }
}

/// Merges all choices into one that selects each with the same probability.
fn uniform(choices: Vec<Weighted>, fractions: &mut Fractions) -> Weighted {
    let share = fractions.number(Ratio::new(1.into(), choices.len().into()));
    let (mut drawn, mut successors) = (Vec::with_capacity(choices.len()), Vec::new());
    for choice in choices {
        drawn.extend(choice.combinations().into_owned());
        successors.extend(choice.successors);
    }
    successors.iter_mut().for_each(|(_, weight)| *weight = fractions.product(*weight, share));
    Weighted { choice: Choice::Uniform, drawn, successors }
}

/// Sorts the successors and adds up the probabilities of equal ones.
fn merge(successors: &mut Vec<(Code, u32)>, fractions: &mut Fractions) {
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
    use meliora_lang as lang;
    use meliora_model::error::SourceFile;
    use meliora_model::progress::NoProgress;

    fn same(model: &str) {
        let read = |name, text: &str| SourceFile::new(name, text);
        let program = lang::load(&read("model", model), &read("constants", "")).unwrap().program;
        let (mut fractions, mut walker) = (Fractions::default(), Walker::new(&program, &NoProgress).unwrap());
        let codec = walker.codec().clone();
        let mut walk = walker.walk();
        let (mut states, mut next) = (vec![vec![0; program.variables.len()]], 0);
        while next < states.len() {
            let state = states[next].clone();
            let code = codec.encode(&state).unwrap();
            assert_eq!(codec.decode(&code), state);
            let found = walk.choices(&code, &mut fractions).unwrap();
            let names: Vec<_> = program.choices(&state).unwrap().into_iter().map(|(_, name)| name).collect();
            assert_eq!(walk.names(&code).unwrap(), names, "{state:?}");
            let expected = program.exact_steps(&state).unwrap();
            assert_eq!(found.len(), expected.len(), "{state:?}");
            for (found, expected) in found.iter().zip(expected) {
                assert_eq!(found.choice, expected.choice, "{state:?}");
                let exact = |(to, p): &(Code, u32)| (codec.decode(to), fractions.list()[*p as usize].clone());
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
