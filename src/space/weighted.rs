//! The choices of single states with exact probabilities, by the compiled program.
//!
//! [`Program::exact_steps`] evaluates every guard and adds fractions. Here the values of variables list the
//! enabled commands, and probabilities are numbers of fractions, each of which is stored once. The
//! probabilities of commands that do not depend on the state are read once. The successors of all choices
//! of a state are written to buffers that are used again for the next state.

use super::enabled::names_of;
pub use super::fractions::Fractions;
pub use super::layout::Code;
use super::layout::{Layout, by_words};
use super::lists::MOST;
use super::program::Prepared;
use super::states::fixed;
use super::stepper::{Stepper, sum};
pub use super::steps::{Steps, Taken};
use super::weigher::Weigher;
use ahash::AHashMap;
use meliora_base::error::{Error, Result};
use meliora_base::exact::Ratio;
use meliora_base::progress::ProgressSink;
use meliora_model::step::{Choice, Combination};
use meliora_model::{CommandId, ModelKind, Program, State};
use num_traits::One;

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

    /// Returns the number of low bits of the last word of a code that are always 0.
    pub fn spare(&self) -> u32 {
        self.layout.spare()
    }

    /// Returns the code of a state; `None` if a value is out of range.
    pub fn encode(&self, state: &[i64]) -> Option<Code> {
        self.layout.encode(state)
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
        let mut state = State::new();
        self.decode_into(code, &mut state);
        state
    }

    /// Replaces a state by that of a code.
    pub fn decode_into(&self, code: &[u64], state: &mut State) {
        state.resize(self.variables, 0);
        self.layout.decode(code, state);
    }
}

/// Lists the choices of states, as [`Program::exact_steps`] does, without their names.
pub struct Walker<'p> {
    program: &'p Program,
    codec: Codec,
    prepared: Prepared,
}

impl<'p> Walker<'p> {
    /// Compiles a program.
    ///
    /// # Errors
    /// The states need more than 2048 bits, or the work is cancelled.
    pub fn new(program: &'p Program, sink: &dyn ProgressSink) -> Result<Self> {
        let codec = Codec::new(program)?;
        let prepared = Prepared::new(program, &codec.layout, sink)?;
        Ok(Walker { program, codec, prepared })
    }

    /// Returns the codes of the states.
    pub fn codec(&self) -> &Codec {
        &self.codec
    }

    /// Creates a walk, which keeps work between states. Several threads may walk.
    pub fn walk(&self) -> Box<dyn Walk + '_> {
        by_words!(self.codec.layout.words(), W => Box::new(PackedWalk::<W>::new(self)))
    }
}

/// A walk over states.
pub trait Walk: Send {
    /// Lists the successors of the choices of a state, in the order of [`Program::steps`].
    ///
    /// # Errors
    /// A command has no meaning in the state, or there are too many choices.
    fn steps(&mut self, state: &[u64], fractions: &mut Fractions, into: &mut Steps) -> Result<()>;

    /// Lists the choices of a state for [`Walk::taken`] and [`Walk::combinations`], without their successors.
    ///
    /// # Errors
    /// A guard or a probability has no meaning in the state.
    fn enable(&mut self, state: &[u64]) -> Result<()>;

    /// Returns a choice of the state of the last [`Walk::steps`] or [`Walk::enable`], by its position.
    fn taken(&self, position: usize) -> Taken;

    /// Returns the combinations of commands that are enabled in the state of the last [`Walk::enable`], in the order of
    /// [`Program::steps`].
    fn combinations(&self) -> Vec<Combination>;

    /// Returns the number of this list: states with the same number have the same one. `None` if there are too many.
    fn list(&mut self) -> Option<u32>;

    /// Returns the names of the choices of a state, as [`Program::choices`] does.
    ///
    /// # Errors
    /// A command has no meaning in the state, or there are too many choices.
    fn names(&mut self, state: &[u64]) -> Result<&[String]>;
}

struct PackedWalk<'w, const W: usize> {
    program: &'w Program,
    codec: &'w Codec,
    stepper: Stepper<'w, W>,
    weigher: Weigher<'w>,
    /// The successors of a choice.
    successors: Vec<([u64; W], u32)>,
    /// The numbers of lists of choices that are enabled together, by [`Stepper::key_into`].
    lists: AHashMap<Box<[u32]>, u32>,
    /// The names of the choices of a list, after those of the last list without a number.
    names: Vec<Vec<String>>,
    key: Vec<u32>,
}

impl<const W: usize> Walk for PackedWalk<'_, W> {
    fn steps(&mut self, state: &[u64], fractions: &mut Fractions, into: &mut Steps) -> Result<()> {
        // An error may have left some.
        self.successors.clear();
        self.stepper.enter(&self.codec.layout, state);
        self.stepper.expand().map_err(|broken| broken.error(self.program, &self.codec.decode(state)))?;
        into.clear(state.len());
        let code = fixed::<W>(state);
        if self.stepper.ends.is_empty() {
            self.successors.push((code, fractions.number(Ratio::one())));
            into.add(&mut self.successors, fractions);
            return Ok(());
        }
        self.weigher.weigh(&self.stepper, &|| self.codec.decode(state), fractions)?;
        let mut at = 0;
        for &end in &self.stepper.ends {
            let own = at..end as usize;
            let targets = self.stepper.steps[own.clone()].iter().map(|step| sum(&code, step));
            self.successors.extend(targets.zip(self.weigher.weights[own].iter().copied()));
            into.add(&mut self.successors, fractions);
            at = end as usize;
        }
        Ok(())
    }

    fn enable(&mut self, state: &[u64]) -> Result<()> {
        self.stepper.enter(&self.codec.layout, state);
        self.stepper.enable().map_err(|broken| broken.error(self.program, &self.codec.decode(state)))
    }

    fn taken(&self, position: usize) -> Taken {
        if self.stepper.active.is_empty() {
            return Taken { choice: Choice::Deadlock, combinations: Vec::new() };
        }
        if self.program.kind == ModelKind::Dtmc {
            return Taken { choice: Choice::Uniform, combinations: self.combinations() };
        }
        let (mut place, mut number) = (0, position);
        while number >= self.stepper.combinations(self.stepper.active[place]) {
            number -= self.stepper.combinations(self.stepper.active[place]);
            place += 1;
        }
        let (synchronisation, commands) = self.combination(self.stepper.active[place], number);
        let combinations = vec![(synchronisation, commands.clone())];
        Taken { choice: Choice::Combination { synchronisation, commands }, combinations }
    }

    fn combinations(&self) -> Vec<Combination> {
        let of = |&index: &usize| {
            (0..self.stepper.combinations(index)).map(move |number| self.combination(index, number))
        };
        self.stepper.active.iter().flat_map(of).collect()
    }

    fn list(&mut self) -> Option<u32> {
        self.stepper.key_into(&mut self.key);
        let new = self.lists.len();
        match self.lists.get(&self.key[..]) {
            Some(&known) => Some(known),
            None if new == MOST => None,
            None => {
                self.lists.insert(self.key.as_slice().into(), new as u32);
                Some(new as u32)
            }
        }
    }

    fn names(&mut self, state: &[u64]) -> Result<&[String]> {
        self.enable(state)?;
        let at = self.list().map_or(0, |list| list as usize + 1);
        self.names.resize(self.names.len().max(at + 1), Vec::new());
        if at == 0 || self.names[at].is_empty() {
            self.names[at] = names_of(self.program, &self.combinations());
        }
        Ok(&self.names[at])
    }
}

impl<'w, const W: usize> PackedWalk<'w, W> {
    fn new(walker: &'w Walker<'_>) -> Self {
        let Walker { program, codec, prepared } = walker;
        PackedWalk {
            program,
            codec,
            stepper: Stepper::new(prepared),
            weigher: Weigher::new(program, prepared),
            successors: Vec::new(),
            lists: AHashMap::new(),
            names: Vec::new(),
            key: Vec::new(),
        }
    }

    fn combination(&self, synchronisation: usize, number: usize) -> Combination {
        let commands = self.stepper.combination(synchronisation, number);
        (synchronisation, commands.into_iter().map(CommandId).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meliora_base::error::SourceFile;
    use meliora_base::progress::NoProgress;
    use meliora_lang as lang;

    /// Compares all states that a first one reaches.
    fn same(model: &str, first: &[i64]) {
        let read = |name, text: &str| SourceFile::new(name, text);
        let program = lang::load(&read("model", model), &read("constants", "")).unwrap().program;
        let (mut fractions, walker) = (Fractions::default(), Walker::new(&program, &NoProgress).unwrap());
        let codec = walker.codec().clone();
        let mut walk = walker.walk();
        let (mut states, mut next) = (vec![first.to_vec()], 0);
        let mut found = Steps::default();
        while next < states.len() {
            let state = states[next].clone();
            let code = codec.encode(&state).unwrap();
            assert_eq!(codec.decode(&code), state);
            walk.steps(&code, &mut fractions, &mut found).unwrap();
            let taken: Vec<Choice> = (0..found.choices()).map(|at| walk.taken(at).choice).collect();
            let names: Vec<_> = program.choices(&state).unwrap().into_iter().map(|(_, name)| name).collect();
            assert_eq!(walk.names(&code).unwrap(), names, "{state:?}");
            let expected = program.exact_steps(&state).unwrap();
            assert_eq!(found.choices(), expected.len(), "{state:?}");
            for (at, expected) in expected.into_iter().enumerate() {
                assert_eq!(taken[at], expected.choice, "{state:?}");
                let exact = |(to, p): (&[u64], u32)| (codec.decode(to), fractions.list()[p as usize].clone());
                let successors: Vec<_> = found.of(at).map(exact).collect();
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

    /// Long conditions over x and y, and others over b, some without a value where b=0.
    const CELLS: &str = "module m x:[0..3]; y:[0..3]; b:[0..5000];
          [] b>0 & (x=0&y=0 | x=1&y=2 | x=2&y=3 | x=3&y=0) -> 1/2:(x'=mod(x+1,4))&(b'=b-1) + 1/2:(y'=mod(y+1,4))&(b'=b-1);
          [] (x=0&y=0 | x=1&y=0 | x=2&y=3 | x=3&y>1) & b>0 & 6/b>1 -> (x'=3-x)&(y'=3-y)&(b'=b-1);
          [] b>1 & 6/b>1 & (x=0&y=1 | x=1&y=1 | x=2&y=2 | x=3&y=1) -> (x'=y)&(b'=b-2);
          [] b<5 & (x=0&y=3 | x=3&y=3 | x=1&y<2 | x=2&y=1) -> (b'=1+b);
        endmodule";

    #[test]
    fn choices_and_probabilities_are_those_of_exact_steps() {
        same(&format!("mdp {CELLS}"), &[0, 0, 5]);
        same(&format!("dtmc {CELLS}"), &[0, 0, 5]);
        same(&format!("mdp {MODULES}"), &[0, 0]);
        same(&format!("dtmc {MODULES}"), &[0, 0]);
    }
}
