//! All states of the scope of an engine, with their choices, owners and exact probabilities.

use std::ops::Deref;
use std::sync::Arc;

use bitvec::vec::BitVec;
use meliora_base::error::{Limit, Result};
use meliora_base::exact::Ratio;
use meliora_base::progress::ProgressSink;
use meliora_engine::Engine;
use meliora_engine::membership::Numbers;
use meliora_model::rewards::Earner;
use meliora_model::{Program, State};
use meliora_space::enabled::Enabled;
use meliora_space::weighted::{Codec, Walker};
use num_traits::Zero;

use super::codes::marks;
use super::cost::check_rewards;
use super::earnings::Earnings;
pub use super::game_graph::{Extremes, GameGraph, Rewards};
use super::graph::Graph;
use super::meter::Meter;
use super::narrow::Narrow;
use super::reached::Growing;
use super::source::{Numbered, Source, Stored, Walked};

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
    /// The bytes that the arena leaves of the memory limit.
    memory: u64,
}

impl<'e> Arena<'e> {
    /// Lists the states of the scope of an engine, in the order of their values. Cost: one evaluation of the commands
    /// per state, unless the engine keeps the probabilities of its choices.
    ///
    /// # Errors
    /// The states do not fit into the memory limit; another limit is reached; a command has no meaning in some state.
    pub fn new<E: Engine>(engine: &'e E, program: &'e Program) -> Result<Self> {
        let all = engine.all_states();
        let count = engine.count(&all)?;
        let settings = engine.settings();
        // A state and its code; its choices come later.
        let each = (size_of::<State>() + 2 * 8 * program.variables.len()) as u64;
        let most = settings.memory / each;
        if count > most.into() {
            let what = format!(
                "numbers of all states need a list of the {count} states of the scope, more than the {most} that fit"
            );
            return Err(Limit::Memory { what }.into());
        }
        let (mut meter, codec, sink) = (Meter::new(engine), Codec::new(program)?, Arc::clone(&settings.sink));
        let none = engine.no_states();
        let membership = engine.membership(&[&none, &all])?;
        let stored = Stored::new(membership.numbers(), (program, &codec), false);
        let (graph, codes, numbers) = match stored {
            Some(mut stored) => {
                let of_state = in_order(stored.numbers, &mut meter)?;
                let graph = listed(&mut stored, &codec, &of_state, &mut meter)?;
                let codes =
                    of_state.iter().flat_map(|&number| stored.numbers.code(number)).copied().collect();
                (graph, codes, Some(stored.numbered(of_state)))
            }
            None => {
                let walker = Walker::new(program, &*sink)?;
                let mut walked = Walked::new(&*membership, &walker);
                let states = engine.list_states(&all, usize::MAX)?;
                let bytes = states.len() * each as usize;
                meter.take(bytes)?;
                let order: Result<Vec<u32>> =
                    states.iter().map(|state| walked.number(state, &mut meter)).collect();
                let order = order?;
                drop(states);
                meter.release(bytes);
                let graph = listed(&mut walked, &codec, &order, &mut meter)?;
                (graph, order.iter().flat_map(|&number| walked.code(number)).collect(), None)
            }
        };
        let Graph { game: graph, positions, .. } = graph;
        let memory = meter.left();
        let mut arena = Arena { program, graph, positions, codes, numbers, codec, sink, memory };
        arena.graph.theirs = engine.theirs().map(|theirs| arena.members(engine, &theirs)).transpose()?;
        Ok(arena)
    }

    /// Returns the position of a choice among those of its state in the program.
    pub(crate) fn position(&self, choice: usize) -> usize {
        self.positions.get(choice) as usize
    }

    /// Returns the values of the variables of a state.
    pub fn state(&self, number: usize) -> State {
        self.codec.decode(self.code(number))
    }

    pub(crate) fn code(&self, number: usize) -> &[u64] {
        let words = self.codec.words();
        &self.codes[number * words..][..words]
    }

    /// Returns the choices of the states of the engine by their commands, if it keeps them.
    pub(crate) fn kept_choices(&self) -> Option<&Arc<Enabled>> {
        self.numbers.as_ref()?.choices.as_ref()
    }

    /// Returns the number of the list of choices of a state among those that the engine keeps.
    pub(crate) fn list(&self, state: usize) -> Option<u32> {
        let Numbered { of_state, choices, .. } = self.numbers.as_ref()?;
        Some(choices.as_ref()?.list(of_state[state] as usize))
    }

    /// Returns the codes of the states.
    pub(crate) fn codec(&self) -> &Codec {
        &self.codec
    }

    /// Returns the number of a state.
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
        let (program, items) = (self.program, &self.program.rewards[structure]);
        let mut meter = self.meter();
        meter.take((self.states() + self.choices.start.len()) * 4)?;
        let by_state = items.items.iter().all(|item| matches!(item.earner, Earner::State));
        let walker = if by_state { None } else { Earnings::walker(self, items)? };
        let mut earnings = (!by_state).then(|| Earnings::new(self, items, walker.as_ref()));
        let mut rewards = Rewards::default();
        for number in 0..self.states() {
            meter.step()?;
            let state = self.state(number);
            let own = program.signed_reward_of(items, &state, &[])?;
            let own = rewards.fractions.number(own);
            rewards.of_state.push(own);
            match &mut earnings {
                Some(earnings) => earnings.add(number, &state, &mut rewards)?,
                None => self.choices.of(number as u32).for_each(|_| rewards.of_choice.push(own)),
            }
        }
        Ok(rewards)
    }

    /// Returns a meter for the memory that the arena leaves.
    pub(crate) fn meter(&self) -> Meter<'_> {
        Meter::with(self.memory, &*self.sink)
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

/// Returns the graph of the states of these numbers, and counts the bytes of their codes. Cost: linear, with the choices of each
/// state listed once.
fn listed(source: &mut impl Source, codec: &Codec, order: &[u32], meter: &mut Meter<'_>) -> Result<Graph> {
    let before = meter.bytes();
    let graph = Growing::new(source, (codec, None), (false, false), meter)?.run(source, order)?.graph;
    meter.release_to(before + graph.bytes());
    meter.take(order.len() * codec.words() * size_of::<u64>())?;
    Ok(graph)
}

impl Deref for Arena<'_> {
    type Target = GameGraph;

    fn deref(&self) -> &GameGraph {
        &self.graph
    }
}
