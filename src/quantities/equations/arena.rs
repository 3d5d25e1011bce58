//! All states of the scope of an engine, with their choices, owners and exact probabilities.

use std::ops::Deref;
use std::sync::Arc;

use bitvec::vec::BitVec;
use meliora_base::error::{Limit, Result};
use meliora_base::exact::Ratio;
use meliora_base::progress::ProgressSink;
use meliora_engine::Engine;
use meliora_model::rewards::Earner;
use meliora_model::{Program, State};
use meliora_space::weighted::{Codec, Fractions, Walker};
use num_traits::Zero;

use super::cost::check_rewards;
pub use super::game_graph::{Extremes, GameGraph, Rewards};
use super::graph::Graph;
use super::listing::listed;
use super::meter::Meter;
use super::narrow::Narrow;
use super::reached::Reached;
use super::search::Search;

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
    codec: Codec,
    pub(crate) sink: Arc<dyn ProgressSink>,
    /// The bytes that the arena leaves of the memory limit.
    memory: u64,
}

impl<'e> Arena<'e> {
    /// Lists the states of the scope of an engine, in the order of their values. Cost: one evaluation of the commands
    /// per state.
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
        let mut meter = Meter::new(engine);
        let search = Search { engine, program, end: engine.no_states(), inside: all.clone(), cost: None };
        let walker = search.walker()?;
        let membership = engine.membership(&[&all])?;
        let numbers = membership.numbers();
        let listed = numbers.map(|numbers| listed(numbers, &walker, &mut meter)).transpose()?.flatten();
        let (Graph { game: mut graph, positions, .. }, codes) = match listed {
            Some(listed) => listed,
            None => {
                let states = engine.list_states(&all, usize::MAX)?;
                explored(&search, (&states, each as usize), &walker, &mut meter)?
            }
        };
        let (codec, sink) = (walker.codec().clone(), Arc::clone(&settings.sink));
        let memory = meter.left();
        graph.theirs = None;
        let mut arena = Arena { program, graph, positions, codes, codec, sink, memory };
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

    fn code(&self, number: usize) -> &[u64] {
        let words = self.codec.words();
        &self.codes[number * words..][..words]
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
        let mut members = BitVec::repeat(false, self.states());
        for number in 0..self.states() {
            let inside = match membership.numbers() {
                Some(numbers) => numbers.number(self.code(number)).map_or(0, |number| numbers.marks(number)),
                None => membership.of(&self.state(number))?,
            };
            members.set(number, inside & 1 == 1);
        }
        Ok(members)
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
        let walker = Walker::new(program, &*self.sink)?;
        let (mut walk, mut known, mut steps) = (walker.walk(), Fractions::default(), Default::default());
        let mut rewards = Rewards::default();
        for number in 0..self.states() {
            meter.step()?;
            let state = self.state(number);
            let own = program.signed_reward_of(items, &state, &[])?;
            let own = rewards.fractions.number(own);
            rewards.of_state.push(own);
            if !by_state {
                walk.steps(&self.codec.known(&state)?, &mut known, &mut steps)?;
            }
            for choice in self.choices.of(number as u32) {
                rewards.of_choice.push(match by_state {
                    true => own,
                    false => {
                        let taken = walk.taken(self.positions.get(choice) as usize);
                        let reward = program.signed_reward_of(items, &state, &taken.combinations)?;
                        rewards.fractions.number(reward)
                    }
                });
            }
        }
        Ok(rewards)
    }

    /// Returns a meter for the memory that the arena leaves.
    pub(crate) fn meter(&self) -> Meter<'_> {
        Meter::with(self.memory, &*self.sink)
    }
}

/// Finds the graph of some states, which are all states of the engine, and their codes.
fn explored<E: Engine>(
    search: &Search<'_, E>,
    (states, bytes_of_state): (&[State], usize),
    walker: &Walker<'_>,
    meter: &mut Meter<'_>,
) -> Result<(Graph, Vec<u64>)> {
    let bytes = states.len() * bytes_of_state;
    meter.take(bytes)?;
    let Reached { mut graph, found, .. } = search.explored(states, walker, meter)?;
    meter.release(bytes);
    // The first node is the end of paths, which none of them enters.
    graph.game.choices.first.remove(0);
    graph.game.choices.to.iter_mut().for_each(|to| *to -= 1);
    let codes = (0..states.len() as u32).flat_map(|number| found.codes.code(number)).collect();
    Ok((graph, codes))
}

impl Deref for Arena<'_> {
    type Target = GameGraph;

    fn deref(&self) -> &GameGraph {
        &self.graph
    }
}
