//! The kept choices of some nodes, listed without a change of the graph, so that several threads list those of
//! different nodes. Nodes that are missing are noted in the order in which they are met, each once.

use std::ops::Range;

use ahash::RandomState;
use hashbrown::HashTable;
use num_traits::{One, Zero};

use crate::equations::codes::hash;
use crate::equations::cost::Cost;
use crate::equations::facts::{Facts, Numbers, Seen};
use crate::equations::graph::{Graph, LOST, Rank};
use crate::equations::places::{Place, Places};
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_base::progress::{Poll, ProgressSink};
use meliora_engine::Engine;
use meliora_engine::explicit::weighted::{Code, Codec, Fractions, Steps, Walk};
use meliora_engine::membership::{self, Membership};
use meliora_model::State;
use meliora_model::preference::Change;

/// The rules by which states get nodes, and nodes get choices.
pub(crate) struct Rules<'a, E: Engine> {
    pub(crate) facts: &'a Facts<'a, E>,
    costs: &'a dyn Cost,
    pub(crate) codec: Codec,
    /// Looks states up in [`Facts::sets`]; `None` if these are too many.
    marks: Option<Box<dyn Membership + 'a>>,
    /// The numbers of the sets of each arena.
    numbers: Vec<Numbers>,
    /// The cost of every step, if all have the same.
    pub(crate) cost: Option<Ratio>,
}

impl<'a, E: Engine> Rules<'a, E> {
    /// Takes the results of an analysis, and the cost of a step.
    ///
    /// # Errors
    /// The states need more than 2048 bits; a limit is reached.
    pub(crate) fn new(facts: &'a Facts<'a, E>, costs: &'a dyn Cost) -> Result<Self> {
        let sets = facts.sets();
        let marks = match sets.len() {
            ..=membership::MOST => Some(facts.engine.membership(&sets)?),
            _ => None,
        };
        let numbers = (0..facts.restricted.len() as u32).map(|arena| facts.numbers(arena)).collect();
        let codec = Codec::new(facts.program)?;
        Ok(Rules { facts, costs, codec, marks, numbers, cost: costs.constant() })
    }

    /// Looks a state up.
    pub(crate) fn seen<'s>(&self, state: &'s [i64]) -> Result<Seen<'s>> {
        let marks = self.marks.as_ref().map(|marks| marks.of(state)).transpose()?;
        Ok(Seen { state, marks })
    }

    fn rank(&self, arena: Option<u32>, seen: Seen<'_>) -> Result<Rank> {
        self.facts.rank(arena.map(|arena| self.numbers[arena as usize]), seen)
    }

    /// Returns the facts about a state of a class that gets a node.
    pub(crate) fn missing(&self, place: Place, seen: Seen<'_>, class: Option<u32>) -> Result<Missing> {
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
        Ok(Missing { place, class, rank, unrestricted })
    }
}

/// A node that the graph does not have.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Missing {
    pub(crate) place: Place,
    pub(crate) class: Option<u32>,
    pub(crate) rank: Rank,
    /// True if it is known that its arena keeps every choice.
    pub(crate) unrestricted: bool,
}

/// The end of an edge.
#[derive(Debug, Clone, Copy)]
pub(crate) enum To {
    /// A node of the graph, or [`LOST`].
    Node(u32),
    /// A missing node, by its position in [`Listed::missing`].
    Missing(u32),
}

/// An edge: its end, the number of its probability in [`Lister::fractions`], and whether the step counts.
pub(crate) type Drawn = (To, u32, bool);

/// A choice: its position among those of the state, the number of its cost, and the end of its edges.
pub(crate) type Listed = (u32, u32, u32);

/// A thread's list of choices.
pub(crate) struct Lister<'w> {
    walk: Box<dyn Walk + 'w>,
    steps: Steps,
    poll: Poll<'w>,
    /// The probabilities and costs of this thread by number.
    pub(crate) fractions: Fractions,
    /// The number of the cost of every step, if all have the same.
    cost: Option<u32>,
    /// The end of the choices of each node of the list.
    pub(crate) nodes: Vec<u32>,
    pub(crate) choices: Vec<Listed>,
    pub(crate) edges: Vec<Drawn>,
    pub(crate) missing: Vec<Missing>,
    /// The codes of the missing nodes, one after the other.
    codes: Vec<u64>,
    /// The positions of the missing nodes by place and code.
    positions: HashTable<u32>,
    hasher: RandomState,
    /// The state of the last edge, kept for its memory.
    state: State,
}

impl<'w> Lister<'w> {
    /// Creates a list without nodes. `cost` is that of every step, if all have the same.
    pub(crate) fn new(walk: Box<dyn Walk + 'w>, cost: Option<Ratio>, sink: &'w dyn ProgressSink) -> Self {
        let mut fractions = Fractions::default();
        Lister {
            cost: cost.map(|cost| fractions.number(cost)),
            walk,
            steps: Steps::default(),
            poll: Poll::new(sink),
            fractions,
            nodes: Vec::new(),
            choices: Vec::new(),
            edges: Vec::new(),
            missing: Vec::new(),
            codes: Vec::new(),
            positions: HashTable::new(),
            hasher: RandomState::new(),
            state: State::new(),
        }
    }

    /// Forgets all nodes. Their memory is used again.
    pub(crate) fn clear(&mut self) {
        self.nodes.clear();
        self.choices.clear();
        self.edges.clear();
        self.missing.clear();
        self.codes.clear();
        self.positions.clear();
    }

    /// Returns the code of a missing node.
    pub(crate) fn code(&self, position: usize) -> &[u64] {
        let words = self.codes.len() / self.missing.len().max(1);
        &self.codes[position * words..(position + 1) * words]
    }

    /// Returns the bytes of the list.
    pub(crate) fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<u32>()
            + self.choices.capacity() * size_of::<Listed>()
            + self.edges.capacity() * size_of::<Drawn>()
            + self.missing.capacity() * size_of::<Missing>()
            + self.codes.capacity() * size_of::<u64>()
            + self.positions.allocation_size()
    }

    /// Notes a missing node, unless it is there; returns its position.
    fn add(&mut self, code: &[u64], missing: Missing) -> u32 {
        let position = self.missing.len() as u32;
        self.missing.push(missing);
        self.codes.extend_from_slice(code);
        let Lister { missing, codes, hasher, .. } = self;
        let hash = |&position: &u32| {
            let own = position as usize * code.len();
            hash(hasher, missing[position as usize].place.key(), codes[own..own + code.len()].iter().copied())
        };
        self.positions.insert_unique(hash(&position), position, hash);
        position
    }

    /// Returns the position of a missing node that was noted.
    fn find(&self, place: Place, code: &[u64]) -> Option<u32> {
        let same = |&position: &u32| {
            self.missing[position as usize].place == place && self.code(position as usize) == code
        };
        self.positions.find(hash(&self.hasher, place.key(), code.iter().copied()), same).copied()
    }
}

/// The graph so far, with the rules by which it grows.
pub(crate) struct View<'v, 'a, E: Engine> {
    pub(crate) rules: &'v Rules<'a, E>,
    pub(crate) graph: &'v Graph,
    pub(crate) places: &'v Places,
}

impl<E: Engine> View<'_, '_, E> {
    /// Lists the choices of some nodes that follow each other, from the first one on. The list ends before the last
    /// node after an error, or after `most` edges.
    ///
    /// # Errors
    /// The work is cancelled, or a command or a cost has no meaning in some state.
    pub(crate) fn list(&self, nodes: Range<u32>, most: usize, lister: &mut Lister<'_>) -> Result<()> {
        for node in nodes {
            if lister.edges.len() >= most {
                break;
            }
            lister.poll.step()?;
            if self.graph.rank(node).positive > 0 {
                let (code, arena) = (self.places.code(node), self.places.arena(node));
                match self.graph.is_junction(node) {
                    true => self.junction(node, arena, &code, lister)?,
                    false => self.choices(node, arena, &code, lister)?,
                }
            }
            lister.nodes.push(lister.choices.len() as u32);
        }
        Ok(())
    }

    /// Finds the node of a state, which may be missing.
    pub(crate) fn enter(
        &self,
        place: Place,
        (code, seen): (&[u64], Seen<'_>),
        class: Option<u32>,
        lister: &mut Lister<'_>,
    ) -> Result<To> {
        let known = self.places.find_code(place, code).map(To::Node);
        match known.or_else(|| lister.find(place, code).map(To::Missing)) {
            Some(to) => Ok(to),
            None => Ok(To::Missing(lister.add(code, self.rules.missing(place, seen, class)?))),
        }
    }

    /// Lists the choices after an improving step: to count it, or to go on in the old arena.
    fn junction(&self, node: u32, arena: Option<u32>, code: &Code, lister: &mut Lister<'_>) -> Result<()> {
        let class = self.places.class(node);
        let own = self.rules.facts.arena_of(class);
        let state = self.rules.codec.decode(code);
        let seen = self.rules.seen(&state)?;
        for (position, (arena, counts)) in (0..).zip([(own, true), (arena, false)]) {
            let to = self.enter(Place::of(arena), (code, seen), class, lister)?;
            let probability = lister.fractions.number(Ratio::one());
            let free = lister.fractions.number(Ratio::zero());
            lister.edges.push((to, probability, counts));
            lister.choices.push((position, free, lister.edges.len() as u32));
        }
        Ok(())
    }

    /// Lists the kept choices of a state.
    fn choices(&self, node: u32, number: Option<u32>, code: &Code, lister: &mut Lister<'_>) -> Result<()> {
        let Rules { facts, costs, codec, .. } = self.rules;
        let Some(index) = number.map(|number| number as usize) else { return Ok(()) };
        let (arena, restricted) = (&facts.improvement.arenas[index], &facts.restricted[index]);
        let reference = match arena.reference {
            Some(class) => Some(class as u32),
            None => self.places.class(node),
        };
        let free = self.places.unrestricted[node as usize];
        // The code says all unless choices are tested or have costs of their own.
        let state = if free && lister.cost.is_some() { State::new() } else { codec.decode(code) };
        // One test of the state in place of one per choice.
        let unrestricted = free || !facts.engine.contains(restricted, &state)?;
        let mut steps = std::mem::take(&mut lister.steps);
        lister.walk.steps(code, &mut lister.fractions, &mut steps)?;
        for position in 0..steps.choices() {
            let taken = || lister.walk.taken(position);
            if !unrestricted && !facts.engine.contains_choice(&arena.choices, &state, &taken().choice)? {
                continue;
            }
            let cost = match lister.cost {
                Some(cost) => cost,
                None => {
                    let cost = costs.of(&state, &taken().combinations)?;
                    lister.fractions.number(cost)
                }
            };
            for (code, probability) in steps.of(position) {
                lister.poll.step()?;
                let (to, counts) = self.edge((number, reference), code, lister)?;
                lister.edges.push((to, probability, counts));
            }
            lister.choices.push((position as u32, cost, lister.edges.len() as u32));
        }
        lister.steps = steps;
        Ok(())
    }

    /// Returns the end of a step from an arena and a reference class to a state, and whether the step counts.
    fn edge(
        &self,
        (arena, reference): (Option<u32>, Option<u32>),
        code: &[u64],
        lister: &mut Lister<'_>,
    ) -> Result<(To, bool)> {
        let facts = self.rules.facts;
        let (place, keeps_reference) = (Place::of(arena), facts.improvement.safety.has_reference());
        let known = match self.places.find_code(place, code) {
            Some(node) => Some((To::Node(node), self.places.class(node))),
            None => lister.find(place, code).map(|at| (To::Missing(at), lister.missing[at as usize].class)),
        };
        if let Some((to, class)) = known {
            let change = facts.change(reference, class);
            let (lost, improves) = (change == Change::Weakening, change == Change::Improving);
            if !(keeps_reference && improves) {
                return Ok((if lost { To::Node(LOST) } else { to }, improves));
            }
        }
        let mut state = std::mem::take(&mut lister.state);
        self.rules.codec.decode_into(code, &mut state);
        let seen = self.rules.seen(&state)?;
        let class = match known {
            Some((_, class)) => class,
            None => facts.class(seen, reference)?,
        };
        let change = facts.change(reference, class);
        let improves = change == Change::Improving;
        let junction = keeps_reference && improves;
        let to = match change {
            Change::Weakening => To::Node(LOST),
            _ if junction => self.enter(Place { arena, junction }, (code, seen), class, lister)?,
            _ => To::Missing(lister.add(code, self.rules.missing(place, seen, class)?)),
        };
        lister.state = state;
        Ok((to, improves && !keeps_reference))
    }
}
