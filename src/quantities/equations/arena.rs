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
use meliora_space::enabled::Enabled;
use meliora_space::index::Looked;
use meliora_space::weighted::{Codec, Steps, Walker};
use num_traits::Zero;

use super::codes::{Codes, marks};
use super::cost::check_rewards;
use super::earnings::Earnings;
use super::game_graph::Edge;
pub use super::game_graph::{Extremes, GameGraph, Rewards};
use super::graph::Graph;
use super::listing::{Listed, Numbered, listed};
use super::meter::Meter;
use super::narrow::Narrow;

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
        let walker = Walker::new(program, &*settings.sink)?;
        let membership = engine.membership(&[&all])?;
        let numbers = membership.numbers();
        let listed = numbers.map(|numbers| listed(numbers, &walker, &mut meter)).transpose()?.flatten();
        let (graph, positions, codes, numbers) = match listed {
            Some(Listed { graph: Graph { game, positions, .. }, codes, numbers }) => {
                (game, positions, codes, Some(numbers))
            }
            None => {
                let states = engine.list_states(&all, usize::MAX)?;
                let (graph, positions, codes) = explored((states, each as usize), &walker, &mut meter)?;
                (graph, positions, codes, None)
            }
        };
        let graph = GameGraph { theirs: None, ..graph };
        let (codec, sink) = (walker.codec().clone(), Arc::clone(&settings.sink));
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
        let Numbered { of_state, choices } = self.numbers.as_ref()?;
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
        if let (Some(of), Some(Numbered { of_state: known, .. })) = (membership.numbers(), &self.numbers) {
            // Another engine with the same states may have other numbers.
            let is_same =
                |state: usize| known[state] < of.states() as u32 && of.code(known[state]) == self.code(state);
            let inside = |state: usize| is_same(state).then(|| of.marks(known[state]) & 1 == 1);
            if let Some(found) = (0..self.states()).map(inside).collect() {
                return Ok(found);
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

/// Lists the choices of states, in the order of their values, that lead to no others. Returns them with their positions
/// among those of their states, and the codes of the states.
fn explored(
    (states, bytes_of_state): (Vec<State>, usize),
    walker: &Walker<'_>,
    meter: &mut Meter<'_>,
) -> Result<(GameGraph, Narrow, Vec<u64>)> {
    let bytes = states.len() * bytes_of_state;
    meter.take(bytes)?;
    let mut codes = Codes::new(walker.codec(), 1);
    for state in &states {
        codes.add(0, &walker.codec().known(state)?, meter)?;
    }
    drop(states);
    meter.release(bytes);
    let (mut graph, mut positions, mut walk) = (GameGraph::default(), Narrow::default(), walker.walk());
    let (mut steps, mut looked, mut targets) = (Steps::default(), Looked::default(), Vec::new());
    for number in 0..codes.len() {
        meter.step()?;
        meter.progress_at(number, &|| format!("{number} of {} states", codes.len()));
        walk.steps(&codes.code(number as u32), &mut graph.fractions, &mut steps)?;
        codes.look(0, &steps, &mut looked);
        targets.clear();
        let find = |(at, code)| codes.find_looked(0, code, &looked, at);
        targets.extend(steps.codes().enumerate().map(find));
        let (mut next, edges) = (0, graph.edges_in_all());
        for position in 0..steps.choices() {
            let weights = steps.weights(position);
            let own = &targets[next..next + weights.len()];
            next += weights.len();
            if own.iter().all(Option::is_some) {
                let edges = own.iter().flatten().zip(weights);
                edges.for_each(|(&to, &p)| graph.add_edge(Edge::new(to, p, false)));
                graph.end_choice();
                positions.push(position as u32);
            }
        }
        graph.end_node();
        meter.number(graph.edges_in_all())?;
        let own = (graph.edges_in_all() - edges) * (4 + graph.weights.width());
        meter.take(own + 4 + graph.choices.of(number as u32).len() * (4 + positions.width()))?;
    }
    let codes = (0..codes.len() as u32).flat_map(|number| codes.code(number)).collect();
    Ok((graph, positions, codes))
}

impl Deref for Arena<'_> {
    type Target = GameGraph;

    fn deref(&self) -> &GameGraph {
        &self.graph
    }
}
