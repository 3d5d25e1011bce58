//! Computation of the choices of one state, as differences of codes.

use smallvec::SmallVec;

use super::guards::Candidate;
use super::layout::Layout;
use super::machine::Machine;
use super::offers::Offers;
use super::program::{Chances, Prepared, Ready, Update};
use super::states::fixed;
use meliora_base::error::{Error, Limit};
use meliora_base::rounding::Sum;
use meliora_base::value::EvalError;
use meliora_model::{Program, fault};

/// Maximum number of successors of a state, counted with every combination.
const MOST_SUCCESSORS: usize = 1 << 22;

/// The reasons why the choices of a state cannot be listed.
#[derive(Debug)]
pub enum Broken {
    /// A command has no meaning in the state; [`meliora_model::fault`] finds the command.
    Fault,
    /// The state has too many choices or successors.
    Limit(Limit),
}

impl Broken {
    /// Returns the error for the state.
    pub fn error(self, program: &Program, state: &[i64]) -> Error {
        match self {
            Broken::Fault => fault::in_state(program, state),
            Broken::Limit(limit) => limit.into(),
        }
    }
}

impl From<EvalError> for Broken {
    fn from(_: EvalError) -> Self {
        Broken::Fault
    }
}

/// Computes the choices of states with codes of `W` words.
pub struct Stepper<'a, const W: usize> {
    prepared: &'a Prepared,
    machine: Machine,
    /// The enabled commands of the factors, and their effects.
    offers: Offers<'a, W>,
    /// True if the one choice of the current state draws from several.
    pub draws: bool,
    /// True if the probabilities of an enabled command summed to 1 only after rounding.
    pub rounded: bool,
    /// The differences that the choices add to the code, one after the other.
    pub steps: Vec<[u64; W]>,
    /// The end of each choice in `steps`.
    pub ends: Vec<u32>,
    /// Room for lists that are not in use.
    spare: Vec<Vec<u32>>,
    /// The guards that were evaluated in the current state.
    pub guards: usize,
    /// The synchronisations that have choices in the current state, in their order.
    pub active: Vec<usize>,
}

impl<'a, const W: usize> Stepper<'a, W> {
    /// Creates a stepper for a program.
    pub fn new(prepared: &'a Prepared) -> Self {
        Stepper {
            prepared,
            machine: Machine::new(&prepared.code),
            offers: Offers::new(&prepared.factors),
            draws: false,
            rounded: false,
            steps: Vec::new(),
            ends: Vec::new(),
            spare: Vec::new(),
            guards: 0,
            active: Vec::new(),
        }
    }

    /// Moves to a state and discards the results for the last one.
    pub fn enter(&mut self, layout: &Layout, code: &[u64]) {
        self.machine.next_state();
        self.offers.next_state(fixed(code));
        self.guards = 0;
        layout.decode(code, &mut self.machine.regs);
    }

    /// Returns whether the current state is an initial state.
    pub fn is_initial(&mut self) -> Result<bool, EvalError> {
        self.machine.run(&self.prepared.code, self.prepared.initial.start)
    }

    /// Lists the choices of the current state in the order of [`meliora_model::Program::steps`]; a
    /// deadlock has none.
    pub fn expand(&mut self) -> Result<(), Broken> {
        let prepared = self.prepared;
        let mut room = self.spare.pop().unwrap_or_default();
        let listed = prepared.by_value.find(&self.machine.regs, &mut room);
        self.expand_among(listed.iter().map(|&index| index as usize))?;
        self.spare.push(room);
        Ok(())
    }

    /// Lists the same choices, given the synchronisations that may have some, in their order.
    pub fn expand_among(&mut self, mut among: impl Iterator<Item = usize>) -> Result<(), Broken> {
        self.steps.clear();
        self.ends.clear();
        self.active.clear();
        among.try_for_each(|index| self.synchronise(index))?;
        self.draws = self.prepared.uniform && self.ends.len() > 1;
        if self.prepared.uniform && !self.ends.is_empty() {
            self.ends.clear();
            self.ends.push(self.steps.len() as u32);
        }
        Ok(())
    }

    /// Lists the synchronisations with choices in the current state, and the commands that are enabled, as
    /// [`Stepper::expand`] does, but no effects.
    pub fn enable(&mut self) -> Result<(), Broken> {
        let prepared = self.prepared;
        self.steps.clear();
        self.ends.clear();
        self.active.clear();
        let mut room = self.spare.pop().unwrap_or_default();
        for &index in prepared.by_value.find(&self.machine.regs, &mut room) {
            if self.count(&prepared.synchronisations[index as usize])? > 0 {
                self.active.push(index as usize);
            }
        }
        self.spare.push(room);
        Ok(())
    }

    /// Replaces a list by numbers that tell the choices of the current state apart from those of other states: its
    /// synchronisations, and the enabled commands of their factors.
    pub fn key_into(&self, key: &mut Vec<u32>) {
        key.clear();
        for &index in &self.active {
            key.push(index as u32);
            for &factor in &self.prepared.synchronisations[index] {
                let own = self.enabled(factor);
                key.push(own.len() as u32);
                key.extend_from_slice(own);
            }
        }
    }

    /// Returns whether the current state is a deadlock in which monitors step.
    pub fn steps_alone(&self) -> bool {
        self.prepared.alone.is_some_and(|factor| !self.enabled(factor).is_empty())
    }

    /// Returns the difference between the current state and the same state with fresh monitors.
    pub fn restart(&self) -> [u64; W] {
        let mut effect = [0; W];
        for &(variable, field) in &self.prepared.monitors {
            field.add(&mut effect, self.machine.regs[variable], 0);
        }
        effect
    }

    /// Returns the number of choices of a synchronisation in the current state, which is expanded.
    pub fn combinations(&self, index: usize) -> usize {
        self.prepared.synchronisations[index].iter().map(|&factor| self.enabled(factor).len()).product()
    }

    /// Returns the commands of one of these choices, in the order of the factors.
    pub fn combination(&self, index: usize, number: usize) -> SmallVec<[u32; 4]> {
        let (mut rest, mut commands) = (number, SmallVec::new());
        for &factor in self.prepared.synchronisations[index].iter().rev() {
            let enabled = self.enabled(factor);
            commands.push(enabled[rest % enabled.len()]);
            rest /= enabled.len();
        }
        commands.reverse();
        commands
    }

    /// Returns the position of the choice of some commands, one per factor of a synchronisation, among those of the
    /// current state, from 0; `None` if they are not enabled.
    ///
    /// # Errors
    /// A command has no meaning in the state.
    pub fn position(
        &mut self,
        synchronisation: usize,
        commands: &mut dyn ExactSizeIterator<Item = u32>,
    ) -> Result<Option<usize>, Broken> {
        let prepared = self.prepared;
        let Some(factors) = prepared.synchronisations.get(synchronisation) else { return Ok(None) };
        let mut before = 0;
        for own in &prepared.synchronisations[..synchronisation] {
            let mut product = 1;
            for &factor in own {
                product *= self.factor(factor)?;
            }
            before += product;
        }
        if factors.len() != commands.len() {
            return Ok(None);
        }
        let mut rank = 0;
        for (&factor, command) in factors.iter().zip(commands) {
            self.factor(factor)?;
            let enabled = self.enabled(factor);
            let Some(position) = enabled.iter().position(|&c| c == command) else { return Ok(None) };
            rank = rank * enabled.len() + position;
        }
        Ok(Some(before + rank))
    }

    /// Adds the choices of a synchronisation.
    fn synchronise(&mut self, index: usize) -> Result<(), Broken> {
        let before = self.ends.len();
        self.add_choices(index)?;
        if self.ends.len() > before {
            self.active.push(index);
        }
        Ok(())
    }

    fn add_choices(&mut self, index: usize) -> Result<(), Broken> {
        let factors: &'a [usize] = &self.prepared.synchronisations[index];
        if let &[factor] = factors {
            if self.factor(factor)? > 0 {
                self.find_effects(factor)?;
                let before = self.steps.len() as u32;
                let Some(offer) = self.offers.known(factor) else { return Ok(()) };
                self.steps.extend_from_slice(&offer.effects);
                self.ends.extend(offer.ends.iter().map(|end| before + end));
            }
            return self.check_size();
        }
        let count = self.count(factors)?;
        if count > MOST_SUCCESSORS {
            return Err(too_many(count));
        }
        if count > 0 {
            factors.iter().try_for_each(|&factor| self.find_effects(factor))?;
        }
        for number in 0..count {
            self.combine(factors, number)?;
        }
        Ok(())
    }

    /// Returns the number of combinations of the enabled commands of some factors.
    fn count(&mut self, factors: &[usize]) -> Result<usize, Broken> {
        let mut count: usize = 1;
        for &factor in factors {
            // If no fault is possible, a factor is irrelevant once another one has no enabled
            // command.
            if count > 0 || !self.prepared.factors[factor].is_sound {
                count = count.saturating_mul(self.factor(factor)?);
            }
        }
        Ok(count)
    }

    /// Adds the choice for combination `number`, the last factor fastest: all ways to take a branch
    /// of each command.
    fn combine(&mut self, factors: &[usize], number: usize) -> Result<(), Broken> {
        let start = self.steps.len();
        self.steps.push([0; W]);
        let mut rest = number;
        for &factor in factors.iter().rev() {
            let Some(offer) = self.offers.known(factor) else { continue };
            let effects = offer.effects_of(rest % offer.ends.len());
            rest /= offer.ends.len();
            let until = self.steps.len();
            if (until - start).saturating_mul(effects.len()) > MOST_SUCCESSORS {
                return Err(too_many((until - start).saturating_mul(effects.len())));
            }
            let Some((first, others)) = effects.split_first() else { continue };
            for effect in others {
                for at in start..until {
                    self.steps.push(sum(&self.steps[at], effect));
                }
            }
            for step in &mut self.steps[start..until] {
                *step = sum(step, first);
            }
        }
        self.ends.push(self.steps.len() as u32);
        self.check_size()
    }

    fn check_size(&self) -> Result<(), Broken> {
        if self.steps.len() > MOST_SUCCESSORS { Err(too_many(self.steps.len())) } else { Ok(()) }
    }

    /// Returns the enabled commands of a factor in the current state, as far as they were needed.
    #[inline]
    fn enabled(&self, factor: usize) -> &[u32] {
        self.offers.known(factor).map_or(&[], |offer| &offer.commands)
    }

    /// Finds the enabled commands of a factor, and returns how many there are, after checking their probabilities.
    #[inline]
    fn factor(&mut self, index: usize) -> Result<usize, Broken> {
        if let Some(known) = self.offers.known(index) {
            return Ok(known.commands.len());
        }
        if self.offers.look_up(index, &self.machine.regs) {
            self.guards += 1;
            return Ok(self.enabled(index).len());
        }
        self.test_all(index)
    }

    fn test_all(&mut self, index: usize) -> Result<usize, Broken> {
        let candidates = &self.prepared.factors[index].candidates;
        let mut offer = self.offers.room(index);
        let mut room = self.spare.pop().unwrap_or_default();
        for &at in candidates.by_value.find(&self.machine.regs, &mut room) {
            let candidate = &candidates.all[at as usize];
            if self.test(candidate)? {
                offer.commands.push(candidate.command);
            }
        }
        self.spare.push(room);
        let count = offer.commands.len();
        self.offers.set(index, offer, true);
        Ok(count)
    }

    /// Returns whether a command is enabled, after checking its probabilities.
    #[inline]
    fn test(&mut self, candidate: &Candidate) -> Result<bool, Broken> {
        let prepared = self.prepared;
        self.guards += 1;
        if !candidate.guard.map_or(Ok(true), |guard| self.machine.run(&prepared.code, guard.start))? {
            return Ok(false);
        }
        let ready = &prepared.commands[candidate.command as usize];
        match ready.chances {
            Chances::Sound => {}
            Chances::Rounded => self.rounded = true,
            Chances::Broken => return Err(Broken::Fault),
            Chances::Vary => self.check_probabilities(ready)?,
        }
        Ok(true)
    }

    fn check_probabilities(&mut self, ready: &Ready) -> Result<(), Broken> {
        let mut places: SmallVec<[i64; 8]> = SmallVec::new();
        for branch in &ready.branches {
            let Some(entry) = branch.probability else { continue };
            self.machine.run(&self.prepared.code, entry.start)?;
            places.push(self.machine.regs[entry.result as usize]);
        }
        match self.machine.numbers.judge(places)? {
            Sum::One => {}
            Sum::Rounded => self.rounded = true,
            Sum::Wrong => return Err(Broken::Fault),
        }
        Ok(())
    }

    /// Finds the differences that the branches of positive probability of the enabled commands of a factor add to the
    /// code.
    #[inline]
    fn find_effects(&mut self, factor: usize) -> Result<(), Broken> {
        if self.offers.known(factor).is_some_and(|known| known.has_effects) {
            return Ok(());
        }
        let mut offer = self.offers.room(factor);
        for &command in &offer.commands {
            self.add_effects(command, &mut offer.effects)?;
            offer.ends.push(offer.effects.len() as u32);
        }
        offer.has_effects = true;
        let classes = self.prepared.factors[factor].classes.as_ref();
        let is_steady = classes.is_some_and(|classes| offer.commands.iter().all(|&c| classes.is_steady(c)));
        self.offers.set(factor, offer, is_steady);
        Ok(())
    }

    fn add_effects(&mut self, command: u32, effects: &mut Vec<[u64; W]>) -> Result<(), Broken> {
        let prepared = self.prepared;
        for branch in &prepared.commands[command as usize].branches {
            if let Some(entry) = branch.probability {
                self.machine.run(&prepared.code, entry.start)?;
                if self.machine.is_zero(entry.result) {
                    continue;
                }
            }
            effects.push(self.effect(&branch.updates)?);
        }
        Ok(())
    }

    fn effect(&mut self, updates: &[Update]) -> Result<[u64; W], Broken> {
        let mut effect = [0; W];
        for update in updates {
            if !update.is_given {
                self.machine.run(&self.prepared.code, update.value.start)?;
            }
            let new = self.machine.regs[update.value.result as usize];
            if !update.field.holds(new) {
                return Err(Broken::Fault);
            }
            update.field.add(&mut effect, self.machine.regs[update.variable], new);
        }
        Ok(effect)
    }
}

/// Adds word by word, without a carry between words.
#[inline]
pub fn sum<const W: usize>(a: &[u64; W], b: &[u64; W]) -> [u64; W] {
    let mut sum = *a;
    for (x, y) in sum.iter_mut().zip(b) {
        *x = x.wrapping_add(*y);
    }
    sum
}

fn too_many(count: usize) -> Broken {
    let what = format!(
        "a state with {count} successors by synchronised commands; at most {MOST_SUCCESSORS} are supported"
    );
    Broken::Limit(Limit::Size { what })
}
