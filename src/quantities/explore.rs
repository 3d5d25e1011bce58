//! From a finished analysis to the graph of the solver: the states that kept choices reach from the
//! states asked for.
//!
//! States from which no improvement is possible have the values 0; they are not explored further.

use std::collections::VecDeque;

use ahash::AHashMap;
use num_traits::{One, Zero};

use super::cost::Cost;
use super::graph::{EVERY, Edge, Graph, LOST, Rank};
use super::meter::Meter;
use crate::engine::Engine;
use crate::error::{Error, Result};
use crate::model::exact::Ratio;
use crate::model::preference::{Change, ObjectiveSet, Preferences};
use crate::model::step::Step;
use crate::model::{Program, State, fault};
use crate::planning::levels::Level;
use crate::planning::{Analysis, Classes, Improvement, Kind, Levels, Safety};

/// A state in an arena; with `junction`, right after an improving step under `prefix`.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Place {
    pub(super) arena: Option<u32>,
    pub(super) junction: bool,
    pub(super) state: State,
}

/// The results of an analysis that the graph needs.
pub(super) struct Facts<'a, E: Engine> {
    pub(super) engine: &'a E,
    program: &'a Program,
    preferences: &'a Preferences,
    classes: &'a Classes<E>,
    improvement: &'a Improvement<E>,
    spi: &'a Levels<E>,
    /// The SASI levels; under `transition` those of `action`, where P_k = 1.
    sasi: Own<'a, Levels<E>>,
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
        let preferences = analysis.preferences();
        Ok(Facts { engine, program, preferences, classes, improvement, spi, sasi })
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

    fn most_preferred(&self, class: Option<u32>) -> ObjectiveSet {
        let class = class.and_then(|class| self.classes.list.get(class as usize));
        class.map_or_else(ObjectiveSet::new, |class| class.most_preferred.clone())
    }
}

/// The nodes found so far.
#[derive(Debug, Default)]
pub(super) struct Places {
    pub(super) index: AHashMap<Place, u32>,
    /// The state of each node.
    pub(super) states: Vec<State>,
    /// True for each node whose arena is that of its state's own class.
    pub(super) own: Vec<bool>,
    /// The number of arenas.
    pub(super) arenas: u32,
    queue: VecDeque<(u32, Place)>,
}

/// The exploration of a graph.
pub(super) struct Explorer<'a, 'm, E: Engine> {
    pub(super) facts: &'a Facts<'a, E>,
    pub(super) costs: &'a dyn Cost,
    pub(super) graph: &'a mut Graph,
    pub(super) places: &'a mut Places,
    pub(super) meter: &'a mut Meter<'m>,
}

impl<E: Engine> Explorer<'_, '_, E> {
    /// Adds the node of a state of the scope in its own arena.
    ///
    /// # Errors
    /// A limit is reached.
    pub(super) fn start(&mut self, state: &State) -> Result<u32> {
        let class = self.facts.class(state)?;
        let arena = self.facts.arena_of(class);
        self.node(Place { arena, junction: false, state: state.clone() }, class)
    }

    /// Explores all nodes that the nodes so far reach.
    ///
    /// # Errors
    /// A limit is reached, or a command or a cost has no meaning in some state.
    pub(super) fn run(&mut self) -> Result<()> {
        self.places.arenas = self.facts.improvement.arenas.len() as u32;
        while let Some((node, place)) = self.places.queue.pop_front() {
            let nodes = self.graph.nodes();
            self.meter.step()?;
            self.meter.progress(&|| format!("{nodes} states"));
            let choices = if place.junction { self.junction(&place)? } else { self.choices(&place)? };
            self.graph.close(node, choices, self.meter)?;
        }
        Ok(())
    }

    fn node(&mut self, place: Place, class: Option<u32>) -> Result<u32> {
        if let Some(&known) = self.places.index.get(&place) {
            return Ok(known);
        }
        let mut rank = self.facts.rank(place.arena, &place.state)?;
        if place.junction {
            let own = self.facts.rank(self.facts.arena_of(class), &place.state)?;
            let more = |k: u32| k.saturating_add(1);
            rank =
                Rank { positive: rank.positive.max(more(own.positive)), sure: rank.sure.max(more(own.sure)) };
        }
        self.meter.take(3 * size_of::<Place>() + 24 * place.state.len() + 16)?;
        let node = self.graph.add_node(rank, place.junction, self.meter)?;
        self.places.index.insert(place.clone(), node);
        self.places.states.push(place.state.clone());
        self.places.own.push(place.arena == self.facts.arena_of(class));
        if rank.positive > 0 {
            self.places.queue.push_back((node, place));
        }
        Ok(node)
    }

    /// Returns the choices after an improving step: to count it, or to go on in the old arena.
    fn junction(&mut self, place: &Place) -> Result<Vec<(u32, Ratio, Vec<Edge>)>> {
        let class = self.facts.class(&place.state)?;
        let own = self.facts.arena_of(class);
        let mut choices = Vec::new();
        for (position, (arena, counts)) in [(own, true), (place.arena, false)].into_iter().enumerate() {
            let target = Place { arena, junction: false, state: place.state.clone() };
            let to = self.node(target, class)?;
            let probability = self.graph.fraction(Ratio::one(), self.meter)?;
            choices.push((position as u32, Ratio::zero(), vec![Edge { to, probability, counts }]));
        }
        Ok(choices)
    }

    /// Returns the kept choices of a state.
    fn choices(&mut self, place: &Place) -> Result<Vec<(u32, Ratio, Vec<Edge>)>> {
        let facts = self.facts;
        let arena = place.arena.and_then(|arena| facts.improvement.arenas.get(arena as usize));
        let Some(arena) = arena else { return Ok(Vec::new()) };
        let reference = match arena.reference {
            Some(class) => Some(class as u32),
            None => facts.class(&place.state)?,
        };
        let reference = facts.most_preferred(reference);
        let steps = facts.program.exact_steps(&place.state);
        let steps = steps.map_err(|f| fault::error(facts.program, &f, &place.state))?;
        let mut choices = Vec::new();
        for (position, step) in (0u32..).zip(steps) {
            if facts.engine.contains_choice(&arena.choices, &place.state, &step.choice)? {
                let cost = self.costs.of(&place.state, &step)?;
                choices.push((position, cost, self.edges(place, &reference, step)?));
            }
        }
        Ok(choices)
    }

    fn edges(&mut self, place: &Place, reference: &ObjectiveSet, step: Step<Ratio>) -> Result<Vec<Edge>> {
        let mut edges = Vec::with_capacity(step.successors.len());
        let prefix = self.facts.improvement.safety == Safety::Prefix;
        for (state, p) in step.successors {
            let class = self.facts.class(&state)?;
            let change = self.facts.preferences.change(reference, &self.facts.most_preferred(class));
            let (improves, arena) = (change == Change::Improving, place.arena);
            let to = match change {
                Change::Weakening => LOST,
                _ => self.node(Place { arena, junction: prefix && improves, state }, class)?,
            };
            let probability = self.graph.fraction(p, self.meter)?;
            edges.push(Edge { to, probability, counts: improves && !prefix });
        }
        Ok(edges)
    }
}
