//! The states that a strategy visits, with its memory.

use std::sync::Arc;

use ahash::AHashMap;
use meliora_base::error::{Limit, Result};
use meliora_base::exact::Ratio;
use meliora_model::State;
use meliora_space::enabled::Enabled;
use meliora_space::weighted::Codec;

use super::Optimal;
use meliora_equations::several::Taking;
use meliora_equations::{Arena, Builder, Edge, GameGraph, NONE, Narrow};

/// The states that a strategy visits, each with its memory; those in which paths start come first.
#[derive(Debug)]
pub struct Nodes {
    pub(super) keys: Vec<Key>,
    /// The choices that are taken, or all of the opponent; none in a node that decides the path.
    pub(super) game: GameGraph,
    /// The numbers of these choices in the arena.
    pub(super) numbers: Vec<u32>,
    /// Their positions among the choices of their states in the program.
    positions: Narrow,
    fractions: Vec<Arc<Ratio>>,
    /// The codes of the states, one after the other.
    codes: Vec<u64>,
    codec: Codec,
    /// The choices of the states of the model by their commands, and the list of each node, if the engine keeps them.
    kept: Option<(Arc<Enabled>, Vec<u32>)>,
}

/// A state with its memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Key {
    /// The number of the state in the arena.
    pub(super) state: u32,
    /// The number of steps so far, as far as a bound counts it.
    pub(super) steps: u32,
    /// The number of the set that is visited next, of those that are visited again and again.
    pub(super) round: u32,
}

impl Nodes {
    /// Returns the number of nodes.
    pub fn count(&self) -> usize {
        self.keys.len()
    }

    /// Replaces a state by that of a node, with the states of monitors.
    pub fn state_into(&self, node: usize, state: &mut State) {
        let words = self.codec.words();
        self.codec.decode_into(&self.codes[node * words..][..words], state);
    }

    /// Returns the number of steps before a node, as far as a bound counts it, and the number of the set that is visited
    /// next.
    pub fn memory(&self, node: usize) -> (u32, u32) {
        let Key { steps, round, .. } = self.keys[node];
        (steps, round)
    }

    /// Returns the choices of the states of the model by their commands, and the number of the list of each node there,
    /// if the engine has kept them.
    pub fn kept_choices(&self) -> Option<(&Enabled, &[u32])> {
        self.kept.as_ref().map(|(all, lists)| (&**all, &lists[..]))
    }

    /// Returns whether the opponent chooses in a node: all of its choices are listed.
    pub fn is_theirs(&self, node: usize) -> bool {
        self.game.is_theirs(node as u32)
    }

    /// Replaces a list by the choices of a node: the one that is taken, or all of the opponent; none if the path is
    /// decided.
    pub fn choices_into(&self, node: usize, into: &mut Vec<Taking>) {
        let own = self.game.choices.of(node as u32);
        into.resize_with(own.len(), || Taking { position: 0, successors: Vec::new() });
        for (choice, taking) in own.zip(into) {
            taking.position = self.positions.get(choice) as usize;
            taking.successors.clear();
            let outcomes = self.game.outcomes(choice);
            taking.successors.extend(
                outcomes.map(|(to, weight)| (to as usize, Arc::clone(&self.fractions[weight as usize]))),
            );
        }
    }
}

impl Optimal {
    /// Returns the nodes that the strategy visits from some states, these first. Cost: linear in the nodes.
    ///
    /// # Errors
    /// There are more than `limit` nodes.
    pub fn nodes(&self, arena: &Arena<'_>, starts: &[usize], limit: usize) -> Result<Nodes> {
        let mut found = Found { keys: Vec::new(), known: self.nothing_known(arena), limit };
        for &state in starts {
            found.number(self.key((None, 0), state as u32))?;
        }
        let mut nodes = Nodes {
            keys: Vec::new(),
            game: GameGraph::default(),
            numbers: Vec::new(),
            positions: Narrow::default(),
            fractions: arena.shared_fractions(),
            codes: Vec::new(),
            codec: arena.codec().clone(),
            kept: arena.kept_choices().map(|kept| (Arc::clone(kept), Vec::new())),
        };
        let (mut builder, mut next) = (Builder::new(arena), 0);
        while let Some(&key) = found.keys.get(next) {
            next += 1;
            nodes.codes.extend_from_slice(arena.code(key.state as usize));
            if let (Some((_, lists)), Some(list)) = (&mut nodes.kept, arena.list(key.state as usize)) {
                lists.push(list);
            }
            let is_theirs = arena.is_theirs(key.state);
            let taken = match self.is_decided(key) {
                true => 0..0,
                false if is_theirs => arena.choices.of(key.state),
                false => match self.choice(key) {
                    NONE => 0..0,
                    choice => choice as usize..choice as usize + 1,
                },
            };
            let steps = (key.steps + 1).min(self.stages.len() as u32);
            for choice in taken {
                for (to, weight) in arena.outcomes(choice) {
                    let to = found.number(self.key((Some(key), steps), to))?;
                    builder.edge(Edge::new(to, weight, false));
                }
                builder.end_choice(Ratio::default());
                nodes.numbers.push(choice as u32);
                nodes.positions.push(arena.position(choice) as u32);
            }
            builder.end_state(is_theirs);
        }
        (nodes.keys, nodes.game) = (found.keys, builder.built().0);
        Ok(nodes)
    }

    /// Returns a state with the memory of a path that enters it after some steps, or begins there.
    fn key(&self, (from, steps): (Option<Key>, u32), state: u32) -> Key {
        let from = from.map(|from| (from.state as usize, from.round));
        let round = self.rounds.as_ref().map_or(0, |rounds| rounds.entered(from, state as usize));
        Key { state, steps, round }
    }

    fn is_decided(&self, Key { state, steps, .. }: Key) -> bool {
        let (ends, since) = &self.ends;
        let is_last = steps as usize == self.stages.len() && self.rest.is_none();
        is_last || ends[state as usize] && u64::from(steps) >= *since
    }

    fn choice(&self, Key { state, steps, round }: Key) -> u32 {
        let state = state as usize;
        if let Some(stage) = self.stages.get(steps as usize) {
            return stage[state];
        }
        let again = self.rounds.as_ref().and_then(|rounds| rounds.choice(state, round));
        again.or_else(|| self.rest.as_ref().map(|rest| rest[state])).unwrap_or(NONE)
    }

    fn nothing_known(&self, arena: &Arena<'_>) -> Known {
        match self.stages.is_empty() && self.rounds.is_none() {
            true => Known::States(vec![NONE; arena.states()]),
            false => Known::Keys(AHashMap::new()),
        }
    }
}

/// The nodes found so far.
struct Found {
    keys: Vec<Key>,
    known: Known,
    limit: usize,
}

/// The numbers of nodes.
enum Known {
    /// By state, or [`NONE`], if nothing else is remembered.
    States(Vec<u32>),
    Keys(AHashMap<Key, u32>),
}

impl Found {
    fn number(&mut self, key: Key) -> Result<u32> {
        let new = self.keys.len() as u32;
        let number = match &mut self.known {
            Known::States(numbers) => {
                let number = &mut numbers[key.state as usize];
                if *number == NONE {
                    *number = new;
                }
                *number
            }
            Known::Keys(numbers) => *numbers.entry(key).or_insert(new),
        };
        if number == new {
            if self.keys.len() == self.limit {
                let what = format!("a strategy of more than {} states with memory", self.limit);
                return Err(Limit::Size { what }.into());
            }
            self.keys.push(key);
        }
        Ok(number)
    }
}
