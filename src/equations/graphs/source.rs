//! The states of an engine by number, with the choices of each.

use std::sync::Arc;

use meliora_base::error::Result;
use meliora_engine::membership::{Membership, Numbers};
use meliora_model::step::Combination;
use meliora_model::{ModelKind, Program, State};
use meliora_space::enabled::Enabled;
use meliora_space::index::Looked;
use meliora_space::probabilities::Probabilities;
use meliora_space::weighted::{Code, Codec, Fractions, Steps, Walk, Walker};

use super::codes::{Codes, marks};
use super::game_graph::LOST;
use super::meter::Meter;

/// The states of an engine by number, with the choices of one state at a time.
pub(crate) trait Source {
    /// Returns all probabilities that are known so far.
    fn fractions(&self) -> Fractions;

    /// Returns the number of a state, or [`LOST`] if the engine stores its states without this one.
    ///
    /// # Errors
    /// A value is out of range; a limit is reached.
    fn number(&mut self, state: &State, meter: &mut Meter<'_>) -> Result<u32>;

    /// Returns the number of states that have numbers.
    fn count(&self) -> usize;

    /// Returns the sets that contain a state.
    ///
    /// # Errors
    /// A set belongs to another engine.
    fn marks(&self, number: u32) -> Result<u64>;

    /// Returns the code of a state.
    fn code(&self, number: u32) -> Code;

    /// Lists the choices of a state in the order of [`Program::steps`]; returns how many there are.
    ///
    /// # Errors
    /// A limit is reached; a command has no meaning in the state.
    fn expand(&mut self, number: u32, fractions: &mut Fractions, meter: &mut Meter<'_>) -> Result<usize>;

    /// Returns the successors of a choice of the last state, each once and ordered by values, and the numbers of their
    /// probabilities.
    fn choice(&self, position: usize) -> (&[u32], &[u32]);
}

/// The numbers of the states of an arena in their engine.
pub(crate) struct Numbered {
    pub(crate) of_state: Vec<u32>,
    /// Their choices by commands, if the engine keeps these.
    pub(crate) choices: Option<Arc<Enabled>>,
    /// The probabilities of the exploration that has given the numbers.
    pub(crate) probabilities: Arc<Probabilities>,
}

/// Returns the numbers of some states.
pub(crate) fn numbers_of(
    source: &mut impl Source,
    states: &[State],
    meter: &mut Meter<'_>,
) -> Result<Vec<u32>> {
    states.iter().map(|state| source.number(state, meter)).collect()
}

/// Returns the combinations that a choice draws from, of all of its state.
pub(crate) fn drawn<'c>(program: &Program, all: &'c [Combination], position: usize) -> &'c [Combination] {
    match program.kind {
        ModelKind::Dtmc => all,
        // A deadlock has none.
        _ => all.get(position..=position).unwrap_or_default(),
    }
}

/// The states that an engine stores, with the choices that it has found.
pub(crate) struct Stored<'a> {
    pub(crate) numbers: &'a dyn Numbers,
    probabilities: &'a Arc<Probabilities>,
    codec: &'a Codec,
    /// The first choice of the state whose choices are listed.
    first: usize,
}

impl<'a> Stored<'a> {
    /// Returns the states of an engine; `None` if it does not store them with their probabilities.
    pub(crate) fn new(numbers: Option<&'a dyn Numbers>, codec: &'a Codec) -> Option<Self> {
        let numbers = numbers?;
        let probabilities = numbers.probabilities()?;
        Some(Stored { numbers, probabilities, codec, first: 0 })
    }

    /// Returns the choices by commands, if the engine keeps them, and the probabilities of all.
    pub(crate) fn choices(&self) -> (Option<Arc<Enabled>>, Arc<Probabilities>) {
        (self.numbers.kept_choices().cloned(), Arc::clone(self.probabilities))
    }
}

impl Source for Stored<'_> {
    fn fractions(&self) -> Fractions {
        self.probabilities.fractions().clone()
    }

    fn number(&mut self, state: &State, _: &mut Meter<'_>) -> Result<u32> {
        Ok(self.numbers.number(&self.codec.known(state)?).unwrap_or(LOST))
    }

    fn count(&self) -> usize {
        self.numbers.states()
    }

    fn marks(&self, number: u32) -> Result<u64> {
        Ok(self.numbers.marks(number))
    }

    fn code(&self, number: u32) -> Code {
        Code::from_slice(self.numbers.code(number))
    }

    fn expand(&mut self, number: u32, _: &mut Fractions, _: &mut Meter<'_>) -> Result<usize> {
        let choices = self.numbers.choices(number);
        self.first = choices.start;
        Ok(choices.len())
    }

    fn choice(&self, position: usize) -> (&[u32], &[u32]) {
        let choice = self.first + position;
        (self.numbers.successors(choice), self.probabilities.of(choice))
    }
}

/// States by code, whose commands are evaluated.
pub(crate) struct Walked<'a> {
    sets: &'a dyn Membership,
    codec: &'a Codec,
    walk: Box<dyn Walk + 'a>,
    codes: Codes,
    /// The successors of a state, looked up.
    looked: Looked,
    steps: Steps,
    targets: Vec<u32>,
}

impl<'a> Walked<'a> {
    /// Begins without states.
    pub(crate) fn new(sets: &'a dyn Membership, walker: &'a Walker<'_>) -> Self {
        Walked {
            sets,
            codec: walker.codec(),
            walk: walker.walk(),
            codes: Codes::new(walker.codec(), 1),
            looked: Looked::default(),
            steps: Steps::default(),
            targets: Vec::new(),
        }
    }

    /// Returns the codes of the states by number.
    pub(crate) fn into_codes(self) -> Codes {
        self.codes
    }
}

impl Source for Walked<'_> {
    fn fractions(&self) -> Fractions {
        Fractions::default()
    }

    fn number(&mut self, state: &State, meter: &mut Meter<'_>) -> Result<u32> {
        let code = self.codec.known(state)?;
        if let Some(known) = self.codes.find(0, &code) {
            return Ok(known);
        }
        self.codes.add(0, &code, meter)
    }

    fn count(&self) -> usize {
        self.codes.len()
    }

    fn marks(&self, number: u32) -> Result<u64> {
        marks(self.sets, self.codec, &self.code(number))
    }

    fn code(&self, number: u32) -> Code {
        self.codes.code(number)
    }

    fn expand(&mut self, number: u32, fractions: &mut Fractions, meter: &mut Meter<'_>) -> Result<usize> {
        let Walked { walk, codes, looked, steps, targets, .. } = self;
        walk.steps(&codes.code(number), fractions, steps)?;
        codes.look(0, steps, looked);
        targets.clear();
        for (at, code) in steps.codes().enumerate() {
            let known = codes.find_looked(0, code, looked, at);
            targets.push(known.map_or_else(|| codes.add(0, code, meter), Ok)?);
        }
        Ok(steps.choices())
    }

    fn choice(&self, position: usize) -> (&[u32], &[u32]) {
        let own = self.steps.range(position);
        (&self.targets[own], self.steps.weights(position))
    }
}
