//! From a finished analysis to the graph of the solver: the states that kept choices reach from the
//! states asked for.
//!
//! States from which no improvement is possible have the values 0; they are not explored further. Nodes are numbered in
//! the order in which they are found: a breadth-first search.

use std::collections::{BTreeMap, VecDeque};

use bitvec::vec::BitVec;
use num_traits::{One, Zero};

use crate::cost::Cost;
use crate::facts::{Known, Standing};
use crate::places::{Noted, Place, Places};
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_equations::{Edge, Graph, LOST, Meter, Quantities, Rank};
use meliora_model::State;
use meliora_model::preference::Change;
use meliora_space::index::Looked;
use meliora_space::weighted::{Code, Codec, Steps, Walk, Walker};

/// The exploration of a graph.
pub(crate) struct Explorer<'a, 'm> {
    facts: &'a dyn Known,
    costs: &'a dyn Cost,
    codec: Codec,
    /// The number of the cost of every step, if all have the same.
    cost: Option<u32>,
    graph: &'a mut Graph,
    places: &'a mut Places,
    /// The successors of a state, looked up in its arena.
    looked: Looked,
    meter: &'a mut Meter<'m>,
}

impl<'a, 'm> Explorer<'a, 'm> {
    /// Starts to explore a graph, or continues.
    ///
    /// # Errors
    /// The states need more than 2048 bits; a limit is reached.
    pub(crate) fn new(
        facts: &'a dyn Known,
        costs: &'a dyn Cost,
        graph: &'a mut Graph,
        places: &'a mut Places,
        meter: &'a mut Meter<'m>,
    ) -> Result<Self> {
        let codec = Codec::new(facts.program())?;
        if graph.nodes() == 0 {
            *places = Places::new(codec.clone(), facts.arenas() as u32);
            if facts.is_game() {
                graph.be_game();
            }
        }
        let cost = costs.constant().map(|cost| graph.fraction(cost));
        Ok(Explorer { facts, costs, codec, cost, graph, places, looked: Looked::default(), meter })
    }

    /// Returns the graph so far.
    pub(crate) fn graph(&self) -> &Graph {
        self.graph
    }

    /// Adds the node of a state in its own arena; `None` for states without a class: unsafe states
    /// have no values.
    pub(crate) fn start(&mut self, state: &State) -> Result<Option<u32>> {
        match self.facts.class(state)? {
            Some(class) => self.start_in(class, state).map(Some),
            None => Ok(None),
        }
    }

    /// Does the same as [`Explorer::start`] for a state of a class.
    pub(crate) fn start_in(&mut self, class: u32, state: &State) -> Result<u32> {
        let place = Place::of(self.facts.arena_of(Some(class)));
        let standing = Standing { class: Some(class), ..self.standing(place.arena, state)? };
        let code = self.codec.known(state)?;
        self.enter(place, &code, state, standing)
    }

    /// Returns the node of a state, which is added if it is new. `standing` is what the arena of the place knows about it.
    fn enter(&mut self, place: Place, code: &[u64], state: &[i64], standing: Standing) -> Result<u32> {
        if let Some(known) = self.places.find_code(place, code) {
            return Ok(known);
        }
        let Standing { class, mut rank, unrestricted } = standing;
        let own = self.facts.arena_of(class);
        if place.junction {
            let counted = self.standing(own, state)?.rank;
            let more = |k: u32| k.saturating_add(1);
            let positive = rank.positive.max(more(counted.positive));
            rank = Rank { positive, sure: rank.sure.max(more(counted.sure)) };
        }
        let node = self.graph.add_node(rank, place.junction, self.meter)?;
        let noted = Noted { class, own: place.arena == own, unrestricted };
        self.places.add(place, code, noted, self.meter)?;
        self.note_steps(node, state)?;
        Ok(node)
    }

    /// Returns the arena of a node with distances: an improvement is certain there.
    fn measured(&self, node: u32) -> Option<usize> {
        let is_certain = self.graph.rank(node).sure > 0 && !self.graph.is_junction(node);
        self.places.arena(node).filter(|_| is_certain).map(|arena| arena as usize)
    }

    /// Notes the least number of steps of a node to an improvement, as far as it is known.
    fn note_steps(&mut self, node: u32, state: &[i64]) -> Result<()> {
        let Some(arena) = self.measured(node) else { return Ok(()) };
        match self.facts.steps(arena, state)? {
            steps if steps == self.graph.steps(node) => {}
            steps => self.graph.note_steps(node, steps),
        }
        Ok(())
    }

    /// Measures the steps of some nodes to an improvement, and then those of all nodes. Cost: the layers of their arenas, and
    /// some membership tests per node.
    pub(crate) fn measure(&mut self, starts: &[u32]) -> Result<()> {
        for &start in starts.iter().filter(|&&start| self.graph.steps(start) == 0) {
            if let Some(arena) = self.measured(start) {
                self.facts.measure(arena, &self.places.state(start), true)?;
            }
        }
        for node in 0..self.graph.nodes() as u32 {
            self.renote(node)?;
        }
        Ok(())
    }

    /// Notes the steps of a node to an improvement again, if they may be known better since.
    fn renote(&mut self, node: u32) -> Result<()> {
        let is_tight = |arena| self.facts.is_tight(arena, self.graph.steps(node));
        match self.measured(node).is_none_or(is_tight) {
            true => Ok(()),
            false => self.note_steps(node, &self.places.state(node)),
        }
    }

    /// Returns what an arena knows about a state; nothing is known outside of all arenas.
    fn standing(&self, arena: Option<u32>, state: &[i64]) -> Result<Standing> {
        match arena {
            Some(arena) => self.facts.standing(arena as usize, state),
            None => Ok(Standing::default()),
        }
    }

    /// Explores all nodes that the nodes so far reach.
    ///
    /// # Errors
    /// A limit is reached, or a command or a cost has no meaning in some state.
    pub(crate) fn run(&mut self) -> Result<()> {
        let walker = Walker::new(self.facts.program(), self.facts.sink())?;
        let (mut walk, mut steps, mut next) = (walker.walk(), Steps::default(), 0);
        while next < self.graph.nodes() {
            if self.graph.is_unexplored(next as u32) {
                self.expand(next as u32, &mut *walk, &mut steps)?;
            }
            next += 1;
        }
        Ok(())
    }

    /// Explores more nodes of a part of a graph, those that are nearest to some nodes, until the part has that many. The
    /// length of a step is 1 plus the change of the least number of steps to an improvement.
    ///
    /// # Errors
    /// The errors of [`Explorer::run`].
    pub(crate) fn extend(&mut self, from: &[u32], most: usize) -> Result<()> {
        let walker = Walker::new(self.facts.program(), self.facts.sink())?;
        let (mut walk, mut steps) = (walker.walk(), Steps::default());
        let mut queues = BTreeMap::from([(0, VecDeque::from(from.to_vec()))]);
        let mut seen = BitVec::<usize>::new();
        while self.graph.nodes() < most
            && let Some(mut queue) = queues.first_entry()
        {
            let lost = *queue.key();
            let Some(node) = queue.get_mut().pop_front() else {
                queue.remove();
                continue;
            };
            if self.graph.is_frontier(node) {
                self.expand(node, &mut *walk, &mut steps)?;
            }
            seen.resize(self.graph.nodes(), false);
            let new = |&to: &u32| to != LOST && !seen.replace(to as usize, true);
            for to in self.graph.successors(node).filter(new) {
                queues.entry(lost + self.lost_steps(node, to)).or_default().push_back(to);
            }
        }
        Ok(())
    }

    /// Returns the steps that a step between two nodes loses: 1 plus the change of the least number of steps to an improvement.
    fn lost_steps(&self, node: u32, to: u32) -> u32 {
        match self.graph.is_junction(node) {
            true => 0,
            false => (1 + self.graph.steps(to)).saturating_sub(self.graph.steps(node)),
        }
    }

    /// Explores where the choices lead that are [followed](Quantities::follow), until they end in the part, or it has that many
    /// nodes.
    ///
    /// # Errors
    /// The errors of [`Explorer::run`].
    pub(crate) fn close(&mut self, found: &mut Quantities, most: usize) -> Result<()> {
        let walker = Walker::new(self.facts.program(), self.facts.sink())?;
        let (mut walk, mut steps) = (walker.walk(), Steps::default());
        loop {
            let next = found.follow(self.graph);
            for &node in &next {
                if self.graph.nodes() >= most {
                    return Ok(());
                }
                if let Some(arena) = self.measured(node) {
                    self.facts.measure(arena, &self.places.state(node), false)?;
                }
                if self.graph.is_frontier(node) {
                    self.expand(node, &mut *walk, &mut steps)?;
                }
                for to in self.graph.successors(node).filter(|&to| to != LOST).collect::<Vec<_>>() {
                    self.renote(to)?;
                }
            }
            if next.is_empty() {
                return Ok(());
            }
        }
    }

    /// Adds the choices of a node.
    fn expand(&mut self, node: u32, walk: &mut dyn Walk, steps: &mut Steps) -> Result<()> {
        let nodes = self.graph.nodes();
        self.meter.step()?;
        self.meter.progress_at(node as usize, &|| format!("{nodes} states"));
        let (code, arena) = (self.places.code(node), self.places.arena(node));
        self.graph.begin(node, self.meter)?;
        match self.graph.is_junction(node) {
            true => self.junction(node, arena, &code)?,
            false => self.choices(node, arena, &code, walk, steps)?,
        }
        self.graph.end(node, self.meter)
    }

    /// Adds the choices after an improving step: to count it, or to go on in the old arena.
    fn junction(&mut self, node: u32, arena: Option<u32>, code: &Code) -> Result<()> {
        let class = self.places.class(node);
        let own = self.facts.arena_of(class);
        let state = self.codec.decode(code);
        let (sure, free) = (self.graph.fraction(Ratio::one()), self.graph.fraction(Ratio::zero()));
        for (position, (arena, counts)) in (0..).zip([(own, true), (arena, false)]) {
            let standing = Standing { class, ..self.standing(arena, &state)? };
            let to = self.enter(Place::of(arena), code, &state, standing)?;
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
        let reference = facts.reference(index).or_else(|| self.places.class(node));
        let unrestricted = self.places.unrestricted[node as usize];
        // The code says all unless choices are tested, have costs of their own, or have owners.
        let is_plain = unrestricted && self.cost.is_some() && !facts.is_game();
        let state = if is_plain { State::new() } else { self.codec.decode(code) };
        if facts.is_game() {
            self.graph.set_owner(node, facts.is_theirs(&state)?);
        }
        walk.steps(code, self.graph.fractions_mut(), steps)?;
        self.places.look(Place::of(number), steps, &mut self.looked);
        let mut next = 0;
        for position in 0..steps.choices() {
            let first = next;
            next += steps.weights(position).len();
            let taken = || walk.taken(position);
            if !unrestricted && !facts.keeps(index, &state, &taken().choice)? {
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
        let keeps_reference = facts.has_reference();
        let known = known.map(|node| (node, self.places.class(node)));
        if let Some((node, class)) = known {
            match facts.change(reference, class) {
                Change::Weakening => return Ok((LOST, false)),
                Change::Improving if keeps_reference => {}
                change => return Ok((node, change == Change::Improving)),
            }
        }
        let state = self.codec.decode(code);
        let standing = self.standing(arena, &state)?;
        let change = facts.change(reference, standing.class);
        let improves = change == Change::Improving;
        let junction = keeps_reference && improves;
        let to = match change {
            Change::Weakening => LOST,
            _ => self.enter(Place { arena, junction }, code, &state, standing)?,
        };
        Ok((to, improves && !keeps_reference))
    }
}
