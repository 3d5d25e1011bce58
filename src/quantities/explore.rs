//! From a finished analysis to the graph of the solver: the states that kept choices reach from the
//! states asked for.
//!
//! States from which no improvement is possible have the values 0; they are not explored further.

use num_traits::{One, Zero};

use super::cost::Cost;
use super::graph::{Closed, EVERY, Edge, Graph, LOST, Rank};
use super::meter::Meter;
use super::places::{Place, Places};
use meliora_engine::Engine;
use meliora_engine::explicit::weighted::{Code, Codec, Walk, Walker, Weighted};
use meliora_model::error::{Error, Result};
use meliora_model::exact::Ratio;
use meliora_model::preference::{Change, Preferences};
use meliora_model::{Program, State};
use meliora_planning::improvement::Arena;
use meliora_planning::levels::Level;
use meliora_planning::{Analysis, Classes, Improvement, Kind, Levels, Safety};

/// The results of an analysis that the graph needs.
pub(super) struct Facts<'a, E: Engine> {
    pub(super) engine: &'a E,
    program: &'a Program,
    classes: &'a Classes<E>,
    improvement: &'a Improvement<E>,
    spi: &'a Levels<E>,
    /// The SASI levels; under `transition` those of `action`, where P_k = 1.
    sasi: Own<'a, Levels<E>>,
    /// The effect of a step between two classes.
    changes: Vec<Vec<Change>>,
    /// The states of which each arena does not keep all choices that the program lists: the safety
    /// mode or the requirements forbid some.
    restricted: Vec<E::States>,
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
        let sasi = if improvement.safety.never_weakens() {
            Own::Borrowed(sasi)
        } else {
            let strict = Improvement::new(engine, classes, Safety::Action)?;
            let mut sure = Levels::new(Kind::Sasi);
            while sure.advance(engine, classes, &strict, Some(levels))? {}
            Own::Owned(sure)
        };
        let changes = changes(analysis.preferences(), classes);
        let restricted = |arena: &Arena<E>| analysis.partly_in(&arena.choices);
        let restricted = improvement.arenas.iter().map(restricted).collect::<Result<_>>()?;
        Ok(Facts { engine, program, classes, improvement, spi, sasi, changes, restricted })
    }

    /// Returns the effect of a step between two classes; see [`Classes::change`].
    fn change(&self, from: Option<u32>, to: Option<u32>) -> Change {
        match (from, to) {
            (Some(from), Some(to)) => self.changes[from as usize][to as usize],
            _ => Change::Lateral,
        }
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

    /// Divides states of an arena by what the levels say about them; see [`Facts::rank`]. Some parts
    /// may be empty. Cost: two Boolean operations per pair of levels.
    fn ranked(&self, arena: Option<u32>, states: E::States) -> Result<Vec<(E::States, Rank)>> {
        let Some(arena) = arena else { return Ok(vec![(states, Rank::default())]) };
        let mut parts = Vec::new();
        for (part, positive) in self.ranked_in(self.spi, arena, states)? {
            let sure = match positive {
                0 => vec![(part, 0)],
                _ => self.ranked_in(self.sasi.get(), arena, part)?,
            };
            parts.extend(sure.into_iter().map(|(part, sure)| (part, Rank { positive, sure })));
        }
        Ok(parts)
    }

    /// Divides states of an arena by the number of levels that contain them; see
    /// [`Facts::rank_in`].
    fn ranked_in(
        &self,
        levels: &Levels<E>,
        arena: u32,
        mut rest: E::States,
    ) -> Result<Vec<(E::States, u32)>> {
        let (mut parts, mut rank) = (Vec::new(), 0);
        let game = |level: &Level<E>| level.games.get(arena as usize).map(|game| game.states.clone());
        if let Some(inside) = levels.unbounded().and_then(game) {
            parts.push((self.engine.intersection(&rest, &inside)?, EVERY));
            rest = self.engine.difference(&rest, &inside)?;
        }
        for inside in levels.found.iter().map_while(game) {
            parts.push((self.engine.difference(&rest, &inside)?, rank));
            rest = self.engine.intersection(&rest, &inside)?;
            rank += 1;
        }
        parts.push((rest, rank));
        Ok(parts)
    }

    /// Returns the arena of the states of a class; see [`Improvement::arena_of`].
    pub(super) fn arena_of(&self, class: Option<u32>) -> Option<u32> {
        let arena = self.improvement.arena_of(class.map(|class| class as usize));
        arena.map(|arena| arena as u32)
    }

    /// Returns the class of a state; `guess` is tested first.
    fn class(&self, state: &[i64], guess: Option<u32>) -> Result<Option<u32>> {
        if let Some(class) = guess
            && self.engine.contains(&self.classes.list[class as usize].states, state)?
        {
            return Ok(guess);
        }
        Ok(self.classes.of(self.engine, state)?.map(|class| class as u32))
    }
}

fn changes<E: Engine>(preferences: &Preferences, classes: &Classes<E>) -> Vec<Vec<Change>> {
    let all = || (0..classes.list.len()).map(Some);
    let row = |from| all().map(|to| classes.change(preferences, from, to)).collect();
    all().map(row).collect()
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
        *places = Places::new(codec.clone(), facts.improvement.arenas.len() as u32);
        let cost = costs.constant().map(|cost| graph.fraction(cost));
        Ok(Explorer { facts, costs, graph, places, meter, codec, cost })
    }

    /// Adds the node of a state in its own arena; `None` for states without a class: unsafe states
    /// have no values.
    pub(super) fn start(&mut self, state: &State) -> Result<Option<u32>> {
        let class = self.facts.class(state, None)?;
        if class.is_none() {
            return Ok(None);
        }
        let code = self.codec.known(state)?;
        self.node(Place::of(self.facts.arena_of(class)), &code, class).map(Some)
    }

    /// Does the same as [`Explorer::start`] for all states with a class, which are listed class by
    /// class and level by level, so that no state is tested for membership. Returns the number of
    /// nodes.
    pub(super) fn start_everywhere(&mut self) -> Result<u32> {
        let facts = self.facts;
        for (class, states) in (0..).zip(&facts.classes.list).map(|(number, class)| (number, &class.states)) {
            self.start_class(Some(class), states.clone())?;
        }
        self.meter.number(self.graph.nodes())
    }

    fn start_class(&mut self, class: Option<u32>, states: E::States) -> Result<()> {
        let facts = self.facts;
        let (engine, number) = (facts.engine, facts.arena_of(class));
        let all = engine.all_states();
        let restricted = number.map_or(&all, |number| &facts.restricted[number as usize]);
        for (part, rank) in self.facts.ranked(number, states)? {
            let free = engine.difference(&part, restricted)?;
            let restricted = engine.intersection(&part, restricted)?;
            for (part, unrestricted) in [(free, true), (restricted, false)] {
                for state in engine.list_states(&part, usize::MAX)? {
                    let code = self.codec.known(&state)?;
                    let node = self.add(Place::of(number), &code, class, rank)?;
                    self.places.unrestricted.set(node as usize, unrestricted);
                }
            }
        }
        Ok(())
    }

    /// Explores all nodes that the nodes so far reach.
    ///
    /// # Errors
    /// A limit is reached, or a command or a cost has no meaning in some state.
    pub(super) fn run(&mut self) -> Result<()> {
        let mut walker = Walker::new(self.facts.program, &*self.facts.engine.settings().sink)?;
        let mut walk = walker.walk();
        // Nodes are numbered in the order in which they are found: a breadth-first search.
        let mut next = 0;
        while next < self.graph.nodes() as u32 {
            let (node, nodes) = (next, self.graph.nodes());
            next += 1;
            self.meter.step()?;
            if self.graph.rank(node).positive == 0 {
                continue;
            }
            self.meter.progress(&|| format!("{nodes} states"));
            let code = Code::from_slice(self.places.code(node));
            let arena = self.places.arena(node);
            let choices = match self.graph.is_junction(node) {
                true => self.junction(node, arena, &code)?,
                false => self.choices(node, arena, &code, &mut *walk)?,
            };
            self.graph.close(node, choices, self.meter)?;
        }
        self.places.end_exploration();
        Ok(())
    }

    fn node(&mut self, place: Place, code: &Code, class: Option<u32>) -> Result<u32> {
        if let Some(known) = self.places.find_code(place, code) {
            return Ok(known);
        }
        let state = self.codec.decode(code);
        let own = self.facts.arena_of(class);
        let mut rank = self.facts.rank(place.arena, &state)?;
        if place.junction {
            let counted = self.facts.rank(own, &state)?;
            let more = |k: u32| k.saturating_add(1);
            let positive = rank.positive.max(more(counted.positive));
            rank = Rank { positive, sure: rank.sure.max(more(counted.sure)) };
        }
        self.add(place, code, class, rank)
    }

    /// Adds the node of a state that is not known.
    fn add(&mut self, place: Place, code: &Code, class: Option<u32>, rank: Rank) -> Result<u32> {
        self.meter.take(self.places.bytes_of_node())?;
        let node = self.graph.add_node(rank, place.junction, self.meter)?;
        let own = place.arena == self.facts.arena_of(class);
        self.places.add(node, place, code, (class, own));
        Ok(node)
    }

    /// Returns the choices after an improving step: to count it, or to go on in the old arena.
    fn junction(&mut self, node: u32, arena: Option<u32>, code: &Code) -> Result<Vec<Closed>> {
        let class = self.places.class(node);
        let own = self.facts.arena_of(class);
        let mut choices = Vec::new();
        for (position, (arena, counts)) in [(own, true), (arena, false)].into_iter().enumerate() {
            let to = self.node(Place::of(arena), code, class)?;
            let probability = self.graph.fraction(Ratio::one());
            let free = self.graph.fraction(Ratio::zero());
            choices.push((position as u32, free, vec![Edge::new(to, probability, counts)]));
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
        let Some(index) = number.map(|number| number as usize) else { return Ok(Vec::new()) };
        let (arena, restricted) = (&facts.improvement.arenas[index], &facts.restricted[index]);
        let reference = match arena.reference {
            Some(class) => Some(class as u32),
            None => self.places.class(node),
        };
        let (state, mut choices) = (self.codec.decode(code), Vec::new());
        // One test of the state in place of one per choice.
        let unrestricted =
            self.places.unrestricted[node as usize] || !facts.engine.contains(restricted, &state)?;
        for (position, step) in (0u32..).zip(walk.choices(code, &mut self.graph.known)?) {
            if unrestricted || facts.engine.contains_choice(&arena.choices, &state, &step.choice)? {
                let cost = match self.cost {
                    Some(cost) => cost,
                    None => self.graph.fraction(self.costs.of(&state, &step.combinations())?),
                };
                choices.push((position, cost, self.edges(number, reference, step)?));
            }
        }
        Ok(choices)
    }

    fn edges(&mut self, arena: Option<u32>, reference: Option<u32>, step: Weighted) -> Result<Vec<Edge>> {
        let mut edges = Vec::with_capacity(step.successors.len());
        let keeps_reference = self.facts.improvement.safety.has_reference();
        for (code, probability) in step.successors {
            let known = self.places.find_code(Place::of(arena), &code);
            let class = match known {
                Some(node) => self.places.class(node),
                None => self.facts.class(&self.codec.decode(&code), reference)?,
            };
            let change = self.facts.change(reference, class);
            let improves = change == Change::Improving;
            let to = match (change, known) {
                (Change::Weakening, _) => LOST,
                (_, Some(node)) if !(keeps_reference && improves) => node,
                _ => self.node(Place { arena, junction: keeps_reference && improves }, &code, class)?,
            };
            edges.push(Edge::new(to, probability, improves && !keeps_reference));
        }
        Ok(edges)
    }
}
