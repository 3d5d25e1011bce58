//! All states of the scope of an engine, with their choices, owners and exact probabilities.

use std::ops::Deref;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use bitvec::vec::BitVec;
use meliora_base::error::{Limit, Result};
use meliora_base::exact::Ratio;
use meliora_base::progress::ProgressSink;
use meliora_engine::Engine;
use meliora_engine::membership::Numbers;
use meliora_model::{Program, State};
use meliora_space::enabled::Enabled;
use meliora_space::weighted::{Codec, Walker};
use num_traits::Zero;

use super::codes::marks;
use super::earnings::{Earnings, check_rewards};
use super::game_graph::{GameGraph, Rewards};
use super::graph::Graph;
use super::meter::Meter;
use super::narrow::Narrow;
use super::reached::{Growing, Reached};
use super::source::{Numbered, Source, Stored, Walked, numbers_of};

/// A set of states of an arena.
pub type Members = BitVec;

/// The states of the scope of an engine, numbered from 0, with their choices. Sets of them are bit vectors, and
/// values are vectors, both by these numbers.
pub struct Arena<'e> {
    pub(crate) program: &'e Program,
    graph: GameGraph,
    /// The position of each choice among those of its state in the program.
    positions: Narrow,
    /// The codes of the states, one after the other.
    codes: Vec<u64>,
    /// The numbers of the states in their engine, if it has some.
    numbers: Option<Numbered>,
    codec: Codec,
    pub(crate) sink: Arc<dyn ProgressSink>,
    /// The memory limit, and the bytes of it that the engine and the arena take.
    limit: AtomicU64,
    taken: u64,
}

impl<'e> Arena<'e> {
    /// Lists the states of the scope of an engine, in the order of their values. Cost: one evaluation of the commands
    /// per state, unless the engine keeps the probabilities of its choices.
    ///
    /// # Errors
    /// The states do not fit into the memory limit; another limit is reached; a command has no meaning in some state.
    pub fn new<E: Engine>(engine: &'e E, program: &'e Program) -> Result<Self> {
        let (count, most) =
            (engine.count(&engine.all_states())?, engine.settings().memory / bytes_of_state(program) as u64);
        if count > most.into() {
            let what = format!(
                "numbers of all states need a list of the {count} states of the scope, more than the {most} that fit"
            );
            return Err(Limit::Memory { what }.into());
        }
        Ok(Arena::listed(engine, program, None, &engine.no_states())?.0)
    }

    /// Lists the states that some states reach, breadth first, and returns the numbers of these. The states of `stops` are
    /// not left: each has one choice, which stays there. Cost: as [`Arena::new`], for these states.
    ///
    /// # Errors
    /// The errors of [`Arena::new`].
    pub fn reached<E: Engine>(
        engine: &'e E,
        program: &'e Program,
        starts: &[State],
        stops: &E::States,
    ) -> Result<(Self, Vec<usize>)> {
        let (arena, starts) = Arena::listed(engine, program, Some(starts), stops)?;
        Ok((arena, starts.into_iter().map(|number| number as usize).collect()))
    }

    /// Lists some states, or all, and those that they reach without leaving `stops`; returns the numbers of the first ones.
    fn listed<E: Engine>(
        engine: &'e E,
        program: &'e Program,
        starts: Option<&[State]>,
        stops: &E::States,
    ) -> Result<(Self, Vec<u32>)> {
        let all = engine.all_states();
        let (mut meter, codec, sink) =
            (Meter::new(engine), Codec::new(program)?, Arc::clone(&engine.settings().sink));
        let membership = engine.membership(&[stops, &all])?;
        let (found, codes, choices) = match Stored::new(membership.numbers(), &codec) {
            Some(mut stored) => {
                let in_order =
                    |stored: &mut Stored<'_>, meter: &mut Meter<'_>| in_order(stored.numbers, meter);
                let (found, codes) = explored(&mut stored, &codec, (starts, in_order), &mut meter)?;
                (found, codes, Some(stored.choices()))
            }
            None => {
                let walker = Walker::new(program, &*sink)?;
                let mut walked = Walked::new(&*membership, &walker);
                let in_order = |walked: &mut Walked<'_>, meter: &mut Meter<'_>| {
                    let states = engine.list_states(&all, usize::MAX)?;
                    let bytes = states.len() * bytes_of_state(program);
                    meter.take(bytes)?;
                    let order = numbers_of(walked, &states, meter);
                    meter.release(bytes);
                    order
                };
                let (found, codes) = explored(&mut walked, &codec, (starts, in_order), &mut meter)?;
                (found, codes, None)
            }
        };
        let Reached { graph: Graph { game: graph, positions, .. }, starts, numbers: of_state, .. } = found;
        let numbers = choices.map(|(choices, probabilities)| Numbered { of_state, choices, probabilities });
        let memory = engine.settings().memory;
        let (limit, taken) = (AtomicU64::new(memory), memory.saturating_sub(meter.left()));
        let mut arena = Arena { program, graph, positions, codes, numbers, codec, sink, limit, taken };
        arena.graph.theirs = engine.theirs().map(|theirs| arena.members(engine, &theirs)).transpose()?;
        Ok((arena, starts))
    }

    /// Returns the program whose states these are.
    pub fn program(&self) -> &'e Program {
        self.program
    }

    /// Returns the progress sink of the engine.
    pub fn sink(&self) -> &dyn ProgressSink {
        &*self.sink
    }

    /// Returns the position of a choice among those of its state in the program.
    pub fn position(&self, choice: usize) -> usize {
        self.positions.get(choice) as usize
    }

    /// Returns the values of the variables of a state.
    pub fn state(&self, number: usize) -> State {
        self.codec.decode(self.code(number))
    }

    /// Returns the code of a state.
    pub fn code(&self, number: usize) -> &[u64] {
        let words = self.codec.words();
        &self.codes[number * words..][..words]
    }

    /// Returns the choices of the states of the engine by their commands, if it keeps them.
    pub fn kept_choices(&self) -> Option<&Arc<Enabled>> {
        self.numbers.as_ref()?.choices.as_ref()
    }

    /// Returns the number of the list of choices of a state among those that the engine keeps.
    pub fn list(&self, state: usize) -> Option<u32> {
        let Numbered { of_state, choices, .. } = self.numbers.as_ref()?;
        Some(choices.as_ref()?.list(of_state[state] as usize))
    }

    /// Returns the codes of the states.
    pub fn codec(&self) -> &Codec {
        &self.codec
    }

    /// Returns the number of a state, of all states.
    pub fn number(&self, state: &State) -> usize {
        // The states are in the order of their values.
        let (mut low, mut high) = (0, self.states());
        while low + 1 < high {
            let middle = low.midpoint(high);
            if self.state(middle) <= *state {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }

    /// Returns the states of the arena that are in a set of an engine with the same states. Cost: one membership test
    /// per state.
    ///
    /// # Errors
    /// The set belongs to another engine; a limit is reached.
    pub fn members<E: Engine>(&self, engine: &E, set: &E::States) -> Result<BitVec> {
        let membership = engine.membership(&[set])?;
        if let (Some(of), Some(known)) = (membership.numbers(), &self.numbers) {
            // Another engine with the same states may have other numbers.
            if of.probabilities().is_some_and(|own| Arc::ptr_eq(own, &known.probabilities)) {
                return Ok(known.of_state.iter().map(|&number| of.marks(number) & 1 == 1).collect());
            }
        }
        let inside = |number| Ok(marks(&*membership, &self.codec, self.code(number))? & 1 == 1);
        (0..self.states()).map(inside).collect()
    }

    /// Returns a set of states of the arena as one of an engine with the same states.
    ///
    /// # Errors
    /// A limit is reached.
    pub fn set<E: Engine>(&self, engine: &E, members: &BitVec) -> Result<E::States> {
        engine.set_of(&mut members.iter_ones().map(|number| self.state(number)))
    }

    /// Returns the rewards of a structure of the program, after checking them.
    ///
    /// # Errors
    /// A reward is negative or has no value in some state; a limit is reached.
    pub fn rewards<E: Engine>(&self, engine: &E, structure: usize) -> Result<Rewards> {
        let program = self.program;
        check_rewards(engine, program, &program.rewards[structure], &program.wrong_rewards(structure))?;
        self.signed_rewards(structure)
    }

    /// Returns the differences of rewards of any sign to the least one, and the least one, or 0 if none is negative. The
    /// sum over n steps is the sum of the differences and n times the least one.
    ///
    /// # Errors
    /// A reward has no value in some state; a limit is reached.
    pub fn rewards_above_least(&self, structure: usize) -> Result<(Rewards, Ratio)> {
        let mut rewards = self.signed_rewards(structure)?;
        let least = rewards.fractions.list().iter().min().cloned().unwrap_or_default().min(Ratio::zero());
        if !least.is_zero() {
            rewards.fractions = rewards.fractions.moved_by(&-&least);
        }
        Ok((rewards, least))
    }

    fn signed_rewards(&self, structure: usize) -> Result<Rewards> {
        let items = &self.program.rewards[structure];
        let mut meter = self.meter();
        meter.take((self.states() + self.choices.start.len()) * 4)?;
        let walker = Earnings::walker(self, items)?;
        let mut earnings = Earnings::new(self, items, walker.as_ref());
        let (mut rewards, mut state) = (Rewards::default(), State::new());
        for number in 0..self.states() {
            meter.step()?;
            self.codec.decode_into(self.code(number), &mut state);
            earnings.add(number, &state, &mut rewards)?;
        }
        Ok(rewards)
    }

    /// Ends the other ways of a race, and takes their memory; see [`ProgressSink::settle`].
    pub fn settle(&self) {
        self.limit.fetch_max(self.sink.settle().unwrap_or(0), Relaxed);
    }

    /// Returns a meter for the memory that the arena leaves.
    pub fn meter(&self) -> Meter<'_> {
        Meter::with(self.limit.load(Relaxed) - self.taken, &*self.sink)
    }
}

/// Returns the numbers of the states of an engine in the order of their values. Cost: that of sorting them.
fn in_order(numbers: &dyn Numbers, meter: &mut Meter<'_>) -> Result<Vec<u32>> {
    // The first words of codes decide most comparisons, without access to the others.
    let first = |number: u32| numbers.code(number).first().copied().unwrap_or_default();
    let inside = (0..numbers.states() as u32).filter(|&number| numbers.marks(number) != 0);
    let mut order: Vec<(u64, u32)> = inside.map(|number| (first(number), number)).collect();
    meter.take(order.len() * size_of::<(u64, u32)>())?;
    // Codes compare as the values do.
    order.sort_unstable_by(|(first, a), (other, b)| {
        first.cmp(other).then_with(|| numbers.code(*a).cmp(numbers.code(*b)))
    });
    meter.release(order.len() * (size_of::<(u64, u32)>() - size_of::<u32>()));
    Ok(order.into_iter().map(|(_, number)| number).collect())
}

/// Returns the bytes of a state and its code, without its choices.
fn bytes_of_state(program: &Program) -> usize {
    size_of::<State>() + 2 * 8 * program.variables.len()
}

/// Returns the graph of the states that some states reach, or of all in an order, with their codes one after the other. Cost:
/// linear, with the choices of each state listed once.
fn explored<S: Source>(
    source: &mut S,
    codec: &Codec,
    (starts, in_order): (Option<&[State]>, impl FnOnce(&mut S, &mut Meter<'_>) -> Result<Vec<u32>>),
    meter: &mut Meter<'_>,
) -> Result<(Reached, Vec<u64>)> {
    let starts = match starts {
        Some(starts) => numbers_of(source, starts, meter)?,
        None => in_order(source, meter)?,
    };
    let before = meter.bytes();
    let found = Growing::new(source, (false, false), meter)?.run(source, &starts)?;
    meter.release_to(before + found.graph.bytes());
    meter.take(found.numbers.len() * codec.words() * size_of::<u64>())?;
    let codes = found.numbers.iter().flat_map(|&number| source.code(number)).collect();
    Ok((found, codes))
}

impl Deref for Arena<'_> {
    type Target = GameGraph;

    fn deref(&self) -> &GameGraph {
        &self.graph
    }
}
