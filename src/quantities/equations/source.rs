//! The states of an engine by number, with the choices of each.

use std::borrow::Cow;
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
pub(super) trait Source {
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

    /// Returns the combinations of commands that a choice of the last state draws from.
    fn combinations(&self, position: usize) -> Cow<'_, [Combination]>;
}

/// The numbers of the states of an arena in their engine.
pub(super) struct Numbered {
    pub(super) of_state: Vec<u32>,
    /// Their choices by commands, if the engine keeps these.
    pub(super) choices: Option<Arc<Enabled>>,
    /// The probabilities of the exploration that has given the numbers.
    pub(super) probabilities: Arc<Probabilities>,
}

/// Returns the combinations that a choice draws from, of all of its state.
pub(super) fn drawn<'c>(program: &Program, all: &'c [Combination], position: usize) -> &'c [Combination] {
    match program.kind {
        ModelKind::Dtmc => all,
        // A deadlock has none.
        _ => all.get(position..=position).unwrap_or_default(),
    }
}

/// The states that an engine stores, with the choices that it has found.
pub(super) struct Stored<'a> {
    pub(super) numbers: &'a dyn Numbers,
    probabilities: &'a Arc<Probabilities>,
    program: &'a Program,
    codec: &'a Codec,
    /// The choices by commands, if they are needed.
    kept: Option<&'a Enabled>,
    /// The combinations of each list of choices that was needed.
    combinations: Vec<Option<Vec<Combination>>>,
    /// The first choice of the state whose choices are listed, and the list of these.
    last: (usize, u32),
}

impl<'a> Stored<'a> {
    /// Returns the states of an engine; `None` if it does not store them with their probabilities, and with their commands if
    /// these are needed.
    pub(super) fn new(
        numbers: Option<&'a dyn Numbers>,
        (program, codec): (&'a Program, &'a Codec),
        needs_commands: bool,
    ) -> Option<Self> {
        let numbers = numbers?;
        let kept = match needs_commands {
            true => Some(&**numbers.kept_choices()?),
            false => None,
        };
        let combinations = vec![None; kept.map_or(0, Enabled::lists)];
        let probabilities = numbers.probabilities()?;
        Some(Stored { numbers, probabilities, program, codec, kept, combinations, last: (0, 0) })
    }

    /// Returns the choices by commands, if the engine keeps them, and the probabilities of all.
    pub(super) fn choices(&self) -> (Option<Arc<Enabled>>, Arc<Probabilities>) {
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
        self.last = (choices.start, 0);
        if let Some(kept) = self.kept {
            let list = kept.list(number as usize);
            self.last.1 = list;
            let known = &mut self.combinations[list as usize];
            known.get_or_insert_with(|| kept.combinations(self.program, list));
        }
        Ok(choices.len())
    }

    fn choice(&self, position: usize) -> (&[u32], &[u32]) {
        let choice = self.last.0 + position;
        (self.numbers.successors(choice), self.probabilities.of(choice))
    }

    fn combinations(&self, position: usize) -> Cow<'_, [Combination]> {
        let all = self.combinations.get(self.last.1 as usize).and_then(Option::as_deref).unwrap_or_default();
        Cow::Borrowed(drawn(self.program, all, position))
    }
}

/// States by code, whose commands are evaluated.
pub(super) struct Walked<'a> {
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
    pub(super) fn new(sets: &'a dyn Membership, walker: &'a Walker<'_>) -> Self {
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
    pub(super) fn into_codes(self) -> Codes {
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

    fn combinations(&self, position: usize) -> Cow<'_, [Combination]> {
        Cow::Owned(self.walk.taken(position).combinations)
    }
}
