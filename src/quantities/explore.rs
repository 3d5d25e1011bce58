//! From a finished analysis to the graph of the solver: the states that kept choices reach from the
//! states asked for.
//!
//! States from which no improvement is possible have the values 0; they are not explored further.

use std::collections::VecDeque;

use ahash::RandomState;
use hashbrown::HashTable;
use num_traits::{One, Zero};

use super::cost::Cost;
use super::graph::{Closed, EVERY, Edge, Graph, LOST, Rank};
use super::meter::Meter;
use crate::engine::Engine;
use crate::engine::explicit::weighted::{Code, Codec, Walk, Walker, Weighted};
use crate::error::{Error, Result};
use crate::model::exact::Ratio;
use crate::model::preference::{Change, ObjectiveSet, Preferences};
use crate::model::{Program, State};
use crate::planning::levels::Level;
use crate::planning::{Analysis, Classes, Improvement, Kind, Levels, Safety};

/// The results of an analysis that the graph needs.
pub(super) struct Facts<'a, E: Engine> {
    pub(super) engine: &'a E,
    program: &'a Program,
    classes: &'a Classes<E>,
    improvement: &'a Improvement<E>,
    spi: &'a Levels<E>,
    /// The SASI levels; under `transition` those of `action`, where P_k = 1.
    sasi: Own<'a, Levels<E>>,
    /// The effect of a step between two classes; states outside of all classes have the last number.
    changes: Vec<Vec<Change>>,
}

/// A borrowed or an own value.
enum Own<'a, T> {
    Borrowed(&'a T),
    Owned(T),
}

impl<T> Own<'_, T> {
    fn get(&self) -> &T {
        match self {
            Own::Borrowed(value) => value,
            Own::Owned(value) => value,
        }
    }
}

impl<'a, E: Engine> Facts<'a, E> {
    /// Takes the results of an analysis. Under `transition`, computes the SASI levels of `action` up
    /// to the given one. Cost: that of the levels.
    ///
    /// # Errors
    /// The levels of the analysis are not known, or a limit is reached.
    pub(super) fn new(analysis: &'a Analysis<E>, program: &'a Program, levels: usize) -> Result<Self> {
        let missing = || Error::Usage("quantities need the levels; run the analysis first".to_owned());
        let classes = analysis.classes().ok_or_else(missing)?;
        let improvement = analysis.improvement().ok_or_else(missing)?;
        let [sasi, spi] = [Kind::Sasi, Kind::Spi].map(|kind| analysis.levels(kind));
        if sasi.end.is_none() || spi.end.is_none() {
            return Err(missing());
        }
        let engine = analysis.engine();
        let sasi = match improvement.safety {
            Safety::Transition => {
                let strict = Improvement::new(engine, classes, Safety::Action)?;
                let mut sure = Levels::new(Kind::Sasi);
                while sure.advance(engine, classes, &strict, Some(levels))? {}
                Own::Owned(sure)
            }
            Safety::Action | Safety::Prefix => Own::Borrowed(sasi),
        };
        let changes = changes(analysis.preferences(), classes);
        Ok(Facts { engine, program, classes, improvement, spi, sasi, changes })
    }

    /// Returns the effect of a step between two classes.
    fn change(&self, from: Option<u32>, to: Option<u32>) -> Change {
        let number = |class: Option<u32>| class.map_or(self.changes.len() - 1, |class| class as usize);
        self.changes[number(from)][number(to)]
    }

    /// Returns the number of levels that contain a state in an arena, or [`EVERY`].
    fn rank_in(&self, levels: &Levels<E>, arena: u32, state: &[i64]) -> Result<u32> {
        let holds = |level: &Level<E>| match level.games.get(arena as usize) {
            Some(game) => self.engine.contains(&game.states, state),
            None => Ok(false),
        };
        if let Some(fixpoint) = levels.unbounded()
            && holds(fixpoint)?
        {
            return Ok(EVERY);
        }
        let mut rank = 0;
        for level in &levels.found {
            if !holds(level)? {
                break;
            }
            rank += 1;
        }
        Ok(rank)
    }

    /// Returns what the levels say about a state in an arena.
    fn rank(&self, arena: Option<u32>, state: &[i64]) -> Result<Rank> {
        let Some(arena) = arena else { return Ok(Rank::default()) };
        let positive = self.rank_in(self.spi, arena, state)?;
        // W_k of SASI is a subset of W_k of SPI.
        let sure = if positive == 0 { 0 } else { self.rank_in(self.sasi.get(), arena, state)? };
        Ok(Rank { positive, sure })
    }

    /// Returns the arena of the states of a class; `None` if no state of the class is safe.
    pub(super) fn arena_of(&self, class: Option<u32>) -> Option<u32> {
        let class = class.map(|class| class as usize);
        let own = |arena: &crate::planning::improvement::Arena<E>| {
            arena.reference.is_none() || arena.reference == class
        };
        self.improvement.arenas.iter().position(own).map(|arena| arena as u32)
    }

    pub(super) fn class(&self, state: &[i64]) -> Result<Option<u32>> {
        Ok(self.classes.of(self.engine, state)?.map(|class| class as u32))
    }
}

fn changes<E: Engine>(preferences: &Preferences, classes: &Classes<E>) -> Vec<Vec<Change>> {
    let nothing = ObjectiveSet::new();
    let members = || classes.list.iter().map(|class| &class.most_preferred).chain([&nothing]);
    let row = |from| members().map(|to| preferences.change(from, to)).collect();
    members().map(row).collect()
}

/// The nodes found so far: states in arenas.
#[derive(Debug, Default)]
pub(super) struct Places {
    numbers: HashTable<u32>,
    hasher: RandomState,
    /// The codes of states; none before the first exploration.
    codec: Option<Codec>,
    /// The state of each node.
    states: Vec<Code>,
    /// The arena of each node and whether it is a junction; see [`key`].
    keys: Vec<u32>,
    /// The class of each node's state.
    classes: Vec<Option<u32>>,
    /// True for each node whose arena is that of its state's own class.
    pub(super) own: Vec<bool>,
    /// The number of arenas.
    pub(super) arenas: u32,
    queue: VecDeque<u32>,
}

/// Combines an arena, and whether a node is a junction: right after an improving step under `prefix`.
fn key(arena: Option<u32>, junction: bool) -> u32 {
    2 * arena.map_or(0, |arena| arena + 1) + u32::from(junction)
}

impl Places {
    /// Returns the node of a state in an arena.
    pub(super) fn find(&self, arena: Option<u32>, junction: bool, state: &[i64]) -> Option<u32> {
        self.find_code(arena, junction, &self.codec.as_ref()?.encode(state)?)
    }

    /// Returns the state of a node.
    pub(super) fn state(&self, node: u32) -> State {
        self.codec.as_ref().map_or_else(State::new, |codec| codec.decode(&self.states[node as usize]))
    }

    /// Returns whether a node is that of a state.
    pub(super) fn is_at(&self, node: u32, state: &[i64]) -> bool {
        let code = self.codec.as_ref().and_then(|codec| codec.encode(state));
        code.is_some_and(|code| self.states[node as usize] == code)
    }

    fn find_code(&self, arena: Option<u32>, junction: bool, state: &Code) -> Option<u32> {
        let key = key(arena, junction);
        let same = |&node: &u32| self.keys[node as usize] == key && self.states[node as usize] == *state;
        self.numbers.find(self.hasher.hash_one((key, &state[..])), same).copied()
    }

    /// Returns the arena of a node.
    pub(super) fn arena(&self, node: u32) -> Option<u32> {
        (self.keys[node as usize] / 2).checked_sub(1)
    }

    fn add(&mut self, node: u32, (arena, junction): (Option<u32>, bool), state: Code, class: Option<u32>) {
        let key = key(arena, junction);
        let hash = self.hasher.hash_one((key, &state[..]));
        self.states.push(state);
        self.keys.push(key);
        self.classes.push(class);
        let Places { numbers, hasher, states, keys, .. } = self;
        let again = |&node: &u32| hasher.hash_one((keys[node as usize], &states[node as usize][..]));
        numbers.insert_unique(hash, node, again);
    }
}

/// The exploration of a graph.
pub(super) struct Explorer<'a, 'm, E: Engine> {
    pub(super) facts: &'a Facts<'a, E>,
    pub(super) costs: &'a dyn Cost,
    pub(super) graph: &'a mut Graph,
    pub(super) places: &'a mut Places,
    pub(super) meter: &'a mut Meter<'m>,
    pub(super) codec: Codec,
    /// The number of the cost of every step, if all have the same.
    cost: Option<u32>,
}

impl<'a, 'm, E: Engine> Explorer<'a, 'm, E> {
    /// Starts to explore a graph.
    ///
    /// # Errors
    /// The states need more than 2048 bits.
    pub(super) fn new(
        facts: &'a Facts<'a, E>,
        costs: &'a dyn Cost,
        graph: &'a mut Graph,
        places: &'a mut Places,
        meter: &'a mut Meter<'m>,
    ) -> Result<Self> {
        let codec = Codec::new(facts.program)?;
        places.codec = Some(codec.clone());
        places.arenas = facts.improvement.arenas.len() as u32;
        let cost = costs.constant().map(|cost| graph.fraction(cost));
        Ok(Explorer { facts, costs, graph, places, meter, codec, cost })
    }

    /// Adds the node of a state of the scope in its own arena.
    ///
    /// # Errors
    /// A limit is reached.
    pub(super) fn start(&mut self, state: &State) -> Result<u32> {
        let class = self.facts.class(state)?;
        let code = self.codec.known(state)?;
        self.node((self.facts.arena_of(class), false), &code, class)
    }

    /// Explores all nodes that the nodes so far reach.
    ///
    /// # Errors
    /// A limit is reached, or a command or a cost has no meaning in some state.
    pub(super) fn run(&mut self) -> Result<()> {
        let mut walker = Walker::new(self.facts.program, &*self.facts.engine.settings().sink)?;
        let mut walk = walker.walk();
        while let Some(node) = self.places.queue.pop_front() {
            let nodes = self.graph.nodes();
            self.meter.step()?;
            self.meter.progress(&|| format!("{nodes} states"));
            let code = self.places.states[node as usize].clone();
            let arena = self.places.arena(node);
            let choices = match self.graph.junction[node as usize] {
                true => self.junction(node, arena, &code)?,
                false => self.choices(node, arena, &code, &mut *walk)?,
            };
            self.graph.close(node, choices, self.meter)?;
        }
        Ok(())
    }

    fn node(&mut self, place: (Option<u32>, bool), code: &Code, class: Option<u32>) -> Result<u32> {
        let (arena, junction) = place;
        if let Some(known) = self.places.find_code(arena, junction, code) {
            return Ok(known);
        }
        let state = self.codec.decode(code);
        let own = self.facts.arena_of(class);
        let mut rank = self.facts.rank(arena, &state)?;
        if junction {
            let counted = self.facts.rank(own, &state)?;
            let more = |k: u32| k.saturating_add(1);
            let positive = rank.positive.max(more(counted.positive));
            rank = Rank { positive, sure: rank.sure.max(more(counted.sure)) };
        }
        self.meter.take(size_of::<Code>() + 8 * code.len() + 24)?;
        let node = self.graph.add_node(rank, junction, self.meter)?;
        self.places.add(node, place, code.clone(), class);
        self.places.own.push(arena == own);
        if rank.positive > 0 {
            self.places.queue.push_back(node);
        }
        Ok(node)
    }

    /// Returns the choices after an improving step: to count it, or to go on in the old arena.
    fn junction(&mut self, node: u32, arena: Option<u32>, code: &Code) -> Result<Vec<Closed>> {
        let class = self.places.classes[node as usize];
        let own = self.facts.arena_of(class);
        let mut choices = Vec::new();
        for (position, (arena, counts)) in [(own, true), (arena, false)].into_iter().enumerate() {
            let to = self.node((arena, false), code, class)?;
            let probability = self.graph.fraction(Ratio::one());
            let free = self.graph.fraction(Ratio::zero());
            choices.push((position as u32, free, vec![Edge { to, probability, counts }]));
        }
        Ok(choices)
    }

    /// Returns the kept choices of a state.
    fn choices(
        &mut self,
        node: u32,
        number: Option<u32>,
        code: &Code,
        walk: &mut dyn Walk,
    ) -> Result<Vec<Closed>> {
        let facts = self.facts;
        let arena = number.and_then(|arena| facts.improvement.arenas.get(arena as usize));
        let Some(arena) = arena else { return Ok(Vec::new()) };
        let reference = match arena.reference {
            Some(class) => Some(class as u32),
            None => self.places.classes[node as usize],
        };
        let (state, mut choices) = (self.codec.decode(code), Vec::new());
        for (position, step) in (0u32..).zip(walk.choices(code, &mut self.graph.known)?) {
            if facts.engine.contains_choice(&arena.choices, &state, &step.choice)? {
                let cost = match self.cost {
                    Some(cost) => cost,
                    None => self.graph.fraction(self.costs.of(&state, &step.combinations)?),
                };
                choices.push((position, cost, self.edges(number, reference, step)?));
            }
        }
        Ok(choices)
    }

    fn edges(&mut self, arena: Option<u32>, reference: Option<u32>, step: Weighted) -> Result<Vec<Edge>> {
        let mut edges = Vec::with_capacity(step.successors.len());
        let prefix = self.facts.improvement.safety == Safety::Prefix;
        for (code, probability) in step.successors {
            let known = self.places.find_code(arena, false, &code);
            let class = match known {
                Some(node) => self.places.classes[node as usize],
                None => self.facts.class(&self.codec.decode(&code))?,
            };
            let change = self.facts.change(reference, class);
            let improves = change == Change::Improving;
            let to = match (change, known) {
                (Change::Weakening, _) => LOST,
                (_, Some(node)) if !(prefix && improves) => node,
                _ => self.node((arena, prefix && improves), &code, class)?,
            };
            edges.push(Edge { to, probability, counts: improves && !prefix });
        }
        Ok(edges)
    }
}
