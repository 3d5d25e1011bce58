//! From a finished analysis to the graph of the solver: the states that kept choices reach from the
//! states asked for.
//!
//! States from which no improvement is possible have the values 0; they are not explored further.

use num_traits::{One, Zero};

use super::cost::Cost;
use super::facts::{Facts, Numbers, Seen};
use super::graph::{Edge, Graph, LOST, Rank};
use super::meter::Meter;
use super::places::{Place, Places};
use meliora_engine::Engine;
use meliora_engine::explicit::weighted::{Code, Codec, Steps, Walk, Walker};
use meliora_engine::membership::{self, Membership};
use meliora_model::State;
use meliora_model::error::Result;
use meliora_model::exact::Ratio;
use meliora_model::preference::Change;

/// The exploration of a graph.
pub(super) struct Explorer<'a, 'm, E: Engine> {
    pub(super) facts: &'a Facts<'a, E>,
    pub(super) costs: &'a dyn Cost,
    pub(super) graph: &'a mut Graph,
    pub(super) places: &'a mut Places,
    pub(super) meter: &'a mut Meter<'m>,
    pub(super) codec: Codec,
    /// Looks states up in [`Facts::sets`]; `None` if these are too many.
    marks: Option<Box<dyn Membership + 'a>>,
    /// The numbers of the sets of each arena.
    numbers: Vec<Numbers>,
    /// The number of the cost of every step, if all have the same.
    cost: Option<u32>,
    /// The state of the last edge, kept for its memory.
    state: State,
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
        *places = Places::new(facts.program, codec.clone(), facts.improvement.arenas.len() as u32);
        let cost = costs.constant().map(|cost| graph.fraction(cost));
        let sets = facts.sets();
        let marks = match sets.len() {
            ..=membership::MOST => Some(facts.engine.membership(&sets)?),
            _ => None,
        };
        let numbers = (0..facts.restricted.len() as u32).map(|arena| facts.numbers(arena)).collect();
        Ok(Explorer { facts, costs, graph, places, meter, codec, marks, numbers, cost, state: State::new() })
    }

    /// Looks a state up.
    fn seen<'s>(&self, state: &'s [i64]) -> Result<Seen<'s>> {
        let marks = self.marks.as_ref().map(|marks| marks.of(state)).transpose()?;
        Ok(Seen { state, marks })
    }

    fn rank(&self, arena: Option<u32>, seen: Seen<'_>) -> Result<Rank> {
        self.facts.rank(arena.map(|arena| self.numbers[arena as usize]), seen)
    }

    /// Adds the node of a state in its own arena; `None` for states without a class: unsafe states
    /// have no values.
    pub(super) fn start(&mut self, state: &State) -> Result<Option<u32>> {
        let seen = self.seen(state)?;
        let class = self.facts.class(seen, None)?;
        if class.is_none() {
            return Ok(None);
        }
        let code = self.codec.known(state)?;
        self.node(Place::of(self.facts.arena_of(class)), (&code, seen), class).map(Some)
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
        let (mut walk, mut steps) = (walker.walk(), Steps::default());
        // Nodes are numbered in the order in which they are found: a breadth-first search.
        let mut next = 0;
        while next < self.graph.nodes() as u32 {
            let (node, nodes) = (next, self.graph.nodes());
            next += 1;
            self.meter.step()?;
            if self.graph.rank(node).positive == 0 {
                continue;
            }
            self.meter.progress_at(node as usize, &|| format!("{nodes} states"));
            let code = self.places.code(node);
            let arena = self.places.arena(node);
            self.graph.begin(node, self.meter)?;
            match self.graph.is_junction(node) {
                true => self.junction(node, arena, &code)?,
                false => self.choices(node, arena, &code, (&mut *walk, &mut steps))?,
            }
            self.graph.end(node, self.meter)?;
        }
        self.places.end_exploration();
        Ok(())
    }

    /// Returns the node of a state, which is added if it is not known.
    fn node(&mut self, place: Place, (code, seen): (&[u64], Seen<'_>), class: Option<u32>) -> Result<u32> {
        match self.places.find_code(place, code) {
            Some(known) => Ok(known),
            None => self.new_node(place, (code, seen), class),
        }
    }

    /// Adds the node of a state that is not known, with what the levels say about it.
    fn new_node(
        &mut self,
        place: Place,
        (code, seen): (&[u64], Seen<'_>),
        class: Option<u32>,
    ) -> Result<u32> {
        let own = self.facts.arena_of(class);
        let mut rank = self.rank(place.arena, seen)?;
        if place.junction {
            let counted = self.rank(own, seen)?;
            let more = |k: u32| k.saturating_add(1);
            let positive = rank.positive.max(more(counted.positive));
            rank = Rank { positive, sure: rank.sure.max(more(counted.sure)) };
        }
        let node = self.add(place, code, class, rank)?;
        if let (Some(arena), Some(marks)) = (place.arena, seen.marks) {
            let restricted = marks >> self.numbers[arena as usize].restricted & 1 == 1;
            self.places.unrestricted.set(node as usize, !restricted);
        }
        Ok(node)
    }

    /// Adds the node of a state that is not known, with its rank.
    fn add(&mut self, place: Place, code: &[u64], class: Option<u32>, rank: Rank) -> Result<u32> {
        let node = self.graph.add_node(rank, place.junction, self.meter)?;
        let own = place.arena == self.facts.arena_of(class);
        self.places.add(place, code, (class, own), self.meter)?;
        Ok(node)
    }

    /// Adds the choices after an improving step: to count it, or to go on in the old arena.
    fn junction(&mut self, node: u32, arena: Option<u32>, code: &Code) -> Result<()> {
        let class = self.places.class(node);
        let own = self.facts.arena_of(class);
        let state = self.codec.decode(code);
        let seen = self.seen(&state)?;
        for (position, (arena, counts)) in [(own, true), (arena, false)].into_iter().enumerate() {
            let to = self.node(Place::of(arena), (code, seen), class)?;
            let probability = self.graph.fraction(Ratio::one());
            let free = self.graph.fraction(Ratio::zero());
            self.graph.add_choice(position as u32, free);
            self.graph.add_edge(Edge::new(to, probability, counts));
        }
        Ok(())
    }

    /// Adds the kept choices of a state.
    fn choices(
        &mut self,
        node: u32,
        number: Option<u32>,
        code: &Code,
        (walk, steps): (&mut dyn Walk, &mut Steps),
    ) -> Result<()> {
        let facts = self.facts;
        let Some(index) = number.map(|number| number as usize) else { return Ok(()) };
        let (arena, restricted) = (&facts.improvement.arenas[index], &facts.restricted[index]);
        let reference = match arena.reference {
            Some(class) => Some(class as u32),
            None => self.places.class(node),
        };
        let free = self.places.unrestricted[node as usize];
        // The code says all unless choices are tested or have costs of their own.
        let state = if free && self.cost.is_some() { State::new() } else { self.codec.decode(code) };
        // One test of the state in place of one per choice.
        let unrestricted = free || !facts.engine.contains(restricted, &state)?;
        walk.steps(code, &mut self.graph.known, steps)?;
        for position in 0..steps.choices() {
            if !unrestricted
                && !facts.engine.contains_choice(&arena.choices, &state, &walk.taken(position).choice)?
            {
                continue;
            }
            let cost = match self.cost {
                Some(cost) => cost,
                None => self.graph.fraction(self.costs.of(&state, &walk.taken(position).combinations)?),
            };
            self.graph.add_choice(position as u32, cost);
            for (code, probability) in steps.of(position) {
                let edge = self.edge((number, reference), code, probability)?;
                self.graph.add_edge(edge);
            }
        }
        Ok(())
    }

    /// Returns the edge of a step from an arena and a reference class to a state.
    fn edge(
        &mut self,
        (arena, reference): (Option<u32>, Option<u32>),
        code: &[u64],
        probability: u32,
    ) -> Result<Edge> {
        let keeps_reference = self.facts.improvement.safety.has_reference();
        let known = self.places.find_code(Place::of(arena), code);
        if let Some(node) = known {
            let change = self.facts.change(reference, self.places.class(node));
            let (lost, improves) = (change == Change::Weakening, change == Change::Improving);
            if !(keeps_reference && improves) {
                return Ok(Edge::new(if lost { LOST } else { node }, probability, improves));
            }
        }
        let mut state = std::mem::take(&mut self.state);
        self.codec.decode_into(code, &mut state);
        let seen = self.seen(&state)?;
        let class = match known {
            Some(node) => self.places.class(node),
            None => self.facts.class(seen, reference)?,
        };
        let change = self.facts.change(reference, class);
        let improves = change == Change::Improving;
        let junction = keeps_reference && improves;
        let to = match change {
            Change::Weakening => LOST,
            _ if junction => self.node(Place { arena, junction }, (code, seen), class)?,
            _ => self.new_node(Place::of(arena), (code, seen), class)?,
        };
        self.state = state;
        Ok(Edge::new(to, probability, improves && !keeps_reference))
    }
}
