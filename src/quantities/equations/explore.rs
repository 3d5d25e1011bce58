//! From a finished analysis to the graph of the solver: the states that kept choices reach from the
//! states asked for.
//!
//! States from which no improvement is possible have the values 0; they are not explored further. Nodes are numbered in
//! the order in which they are found: a breadth-first search.

use bitvec::vec::BitVec;
use num_traits::{One, Zero};

use crate::equations::cost::Cost;
use crate::equations::facts::{Facts, Numbers, Seen};
use crate::equations::game_graph::{Edge, LOST};
use crate::equations::graph::{Graph, Rank};
use crate::equations::meter::Meter;
use crate::equations::places::{Noted, Place, Places};
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_engine::Engine;
use meliora_engine::membership::{self, Membership};
use meliora_model::State;
use meliora_model::preference::Change;
use meliora_space::index::Looked;
use meliora_space::weighted::{Code, Codec, Steps, Walk, Walker};

/// The exploration of a graph.
pub(crate) struct Explorer<'a, 'm, E: Engine> {
    facts: &'a Facts<'a, E>,
    costs: &'a dyn Cost,
    codec: Codec,
    /// Looks states up in [`Facts::sets`]; `None` if these are too many.
    marks: Option<Box<dyn Membership + 'a>>,
    /// The numbers of the sets of each arena.
    numbers: Vec<Numbers>,
    /// The number of the cost of every step, if all have the same.
    cost: Option<u32>,
    /// The states in which the opponent of a game chooses.
    theirs: Option<E::States>,
    graph: &'a mut Graph,
    places: &'a mut Places,
    /// The successors of a state, looked up in its arena.
    looked: Looked,
    meter: &'a mut Meter<'m>,
}

/// The facts about a state that gets a node.
#[derive(Clone, Copy)]
struct Facing {
    class: Option<u32>,
    rank: Rank,
    /// True if it is known that its arena keeps every choice.
    unrestricted: bool,
}

impl<'a, 'm, E: Engine> Explorer<'a, 'm, E> {
    /// Starts to explore a graph.
    ///
    /// # Errors
    /// The states need more than 2048 bits; a limit is reached.
    pub(crate) fn new(
        facts: &'a Facts<'a, E>,
        costs: &'a dyn Cost,
        graph: &'a mut Graph,
        places: &'a mut Places,
        meter: &'a mut Meter<'m>,
    ) -> Result<Self> {
        let sets = facts.sets();
        let marks = match sets.len() {
            ..=membership::MOST => Some(facts.engine.membership(&sets)?),
            _ => None,
        };
        let numbers = (0..facts.restricted.len() as u32).map(|arena| facts.numbers(arena)).collect();
        let codec = Codec::new(facts.program)?;
        *places = Places::new(codec.clone(), facts.improvement.arenas.len() as u32);
        let cost = costs.constant().map(|cost| graph.fraction(cost));
        let theirs = facts.engine.theirs();
        graph.theirs = theirs.as_ref().map(|_| BitVec::new());
        Ok(Explorer {
            facts,
            costs,
            codec,
            marks,
            numbers,
            cost,
            theirs,
            graph,
            places,
            looked: Looked::default(),
            meter,
        })
    }

    /// Adds the node of a state in its own arena; `None` for states without a class: unsafe states
    /// have no values.
    pub(crate) fn start(&mut self, state: &State) -> Result<Option<u32>> {
        let seen = self.seen(state)?;
        let class = self.facts.class(seen, None)?;
        if class.is_none() {
            return Ok(None);
        }
        let code = self.codec.known(state)?;
        self.enter(Place::of(self.facts.arena_of(class)), &code, seen, class).map(Some)
    }

    /// Does the same as [`Explorer::start`] for all states with a class. Returns the number of nodes.
    pub(crate) fn start_everywhere(&mut self) -> Result<u32> {
        for class in &self.facts.classes.list {
            for state in self.facts.engine.list_states(&class.states, usize::MAX)? {
                self.start(&state)?;
            }
        }
        self.meter.number(self.graph.nodes())
    }

    /// Adds the node of a state that is not known.
    fn add(&mut self, place: Place, code: &[u64], facing: Facing) -> Result<u32> {
        let Facing { class, rank, unrestricted } = facing;
        let node = self.graph.add_node(rank, place.junction, self.meter)?;
        let own = place.arena == self.facts.arena_of(class);
        self.places.add(place, code, Noted { class, own, unrestricted }, self.meter)?;
        Ok(node)
    }

    /// Returns the node of a state, which is added if it is new.
    fn enter(&mut self, place: Place, code: &[u64], seen: Seen<'_>, class: Option<u32>) -> Result<u32> {
        match self.places.find_code(place, code) {
            Some(known) => Ok(known),
            None => self.add(place, code, self.facing(place, seen, class)?),
        }
    }

    /// Looks a state up.
    fn seen<'s>(&self, state: &'s [i64]) -> Result<Seen<'s>> {
        let marks = self.marks.as_ref().map(|marks| marks.of(state)).transpose()?;
        Ok(Seen { state, marks })
    }

    fn rank(&self, arena: Option<u32>, seen: Seen<'_>) -> Result<Rank> {
        self.facts.rank(arena.map(|arena| self.numbers[arena as usize]), seen)
    }

    /// Returns the facts about a state of a class that gets a node.
    fn facing(&self, place: Place, seen: Seen<'_>, class: Option<u32>) -> Result<Facing> {
        let mut rank = self.rank(place.arena, seen)?;
        if place.junction {
            let counted = self.rank(self.facts.arena_of(class), seen)?;
            let more = |k: u32| k.saturating_add(1);
            let positive = rank.positive.max(more(counted.positive));
            rank = Rank { positive, sure: rank.sure.max(more(counted.sure)) };
        }
        let restricted =
            |(arena, marks): (u32, u64)| marks >> self.numbers[arena as usize].restricted & 1 == 1;
        let unrestricted = place.arena.zip(seen.marks).is_some_and(|known| !restricted(known));
        Ok(Facing { class, rank, unrestricted })
    }

    /// Explores all nodes that the nodes so far reach.
    ///
    /// # Errors
    /// A limit is reached, or a command or a cost has no meaning in some state.
    pub(crate) fn run(&mut self) -> Result<()> {
        let walker = Walker::new(self.facts.program, &*self.facts.engine.settings().sink)?;
        let (mut walk, mut steps, mut next) = (walker.walk(), Steps::default(), 0);
        while next < self.graph.nodes() {
            let nodes = self.graph.nodes();
            self.meter.step()?;
            self.meter.progress_at(next, &|| format!("{nodes} states"));
            let node = next as u32;
            next += 1;
            if self.graph.rank(node).positive == 0 {
                continue;
            }
            let (code, arena) = (self.places.code(node), self.places.arena(node));
            self.graph.begin(node, self.meter)?;
            match self.graph.is_junction(node) {
                true => self.junction(node, arena, &code)?,
                false => self.choices(node, arena, &code, &mut *walk, &mut steps)?,
            }
            self.graph.end(node, self.meter)?;
        }
        Ok(())
    }

    /// Adds the choices after an improving step: to count it, or to go on in the old arena.
    fn junction(&mut self, node: u32, arena: Option<u32>, code: &Code) -> Result<()> {
        let class = self.places.class(node);
        let own = self.facts.arena_of(class);
        let state = self.codec.decode(code);
        let (sure, free) = (self.graph.fraction(Ratio::one()), self.graph.fraction(Ratio::zero()));
        for (position, (arena, counts)) in (0..).zip([(own, true), (arena, false)]) {
            let to = self.enter(Place::of(arena), code, self.seen(&state)?, class)?;
            self.graph.add_choice(position, free);
            self.graph.add_edge(Edge::new(to, sure, counts));
        }
        Ok(())
    }

    /// Adds the kept choices of a state.
    fn choices(
        &mut self,
        node: u32,
        number: Option<u32>,
        code: &Code,
        walk: &mut dyn Walk,
        steps: &mut Steps,
    ) -> Result<()> {
        let (facts, Some(index)) = (self.facts, number.map(|number| number as usize)) else { return Ok(()) };
        let (arena, restricted) = (&facts.improvement.arenas[index], &facts.restricted[index]);
        let reference = match arena.reference {
            Some(class) => Some(class as u32),
            None => self.places.class(node),
        };
        let free = self.places.unrestricted[node as usize];
        // The code says all unless choices are tested, have costs of their own, or have owners.
        let is_plain = free && self.cost.is_some() && self.theirs.is_none();
        let state = if is_plain { State::new() } else { self.codec.decode(code) };
        if let Some(theirs) = &self.theirs {
            self.graph.set_owner(node, facts.engine.contains(theirs, &state)?);
        }
        // One test of the state in place of one per choice.
        let unrestricted = free || !facts.engine.contains(restricted, &state)?;
        walk.steps(code, &mut self.graph.game.fractions, steps)?;
        self.places.look(Place::of(number), steps, &mut self.looked);
        let mut next = 0;
        for position in 0..steps.choices() {
            let first = next;
            next += steps.weights(position).len();
            let taken = || walk.taken(position);
            if !unrestricted && !facts.engine.contains_choice(&arena.choices, &state, &taken().choice)? {
                continue;
            }
            let cost = match self.cost {
                Some(cost) => cost,
                None => self.graph.fraction(self.costs.of(&state, &taken().combinations)?),
            };
            self.graph.add_choice(position as u32, cost);
            for (at, (code, probability)) in (first..).zip(steps.of(position)) {
                self.meter.step()?;
                let known = self.places.find_looked(Place::of(number), code, &self.looked, at);
                let (to, counts) = self.edge(number, reference, code, known)?;
                self.graph.add_edge(Edge::new(to, probability, counts));
            }
        }
        Ok(())
    }

    /// Returns the end of a step from an arena and a reference class to a state, and whether the step counts. `known` is the
    /// node of the state in the arena, if it has one.
    fn edge(
        &mut self,
        arena: Option<u32>,
        reference: Option<u32>,
        code: &[u64],
        known: Option<u32>,
    ) -> Result<(u32, bool)> {
        let facts = self.facts;
        let keeps_reference = facts.improvement.safety.has_reference();
        let known = known.map(|node| (node, self.places.class(node)));
        if let Some((node, class)) = known {
            match facts.change(reference, class) {
                Change::Weakening => return Ok((LOST, false)),
                Change::Improving if keeps_reference => {}
                change => return Ok((node, change == Change::Improving)),
            }
        }
        let state = self.codec.decode(code);
        let seen = self.seen(&state)?;
        let class = match known {
            Some((_, class)) => class,
            None => facts.class(seen, reference)?,
        };
        let change = facts.change(reference, class);
        let improves = change == Change::Improving;
        let junction = keeps_reference && improves;
        let to = match change {
            Change::Weakening => LOST,
            _ => self.enter(Place { arena, junction }, code, seen, class)?,
        };
        Ok((to, improves && !keeps_reference))
    }
}
