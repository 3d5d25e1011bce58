//! The states that a strategy visits, with its memory.

use std::sync::Arc;

use ahash::AHashMap;
use meliora_base::error::{Limit, Result};

use super::Optimal;
use crate::equations::arena::Arena;
use crate::equations::graph::NONE;
use crate::several::Taking;
use crate::solvers::strategy::shared;

/// A state that a strategy visits, with its memory.
#[derive(Debug, Clone)]
pub struct Node {
    /// The number of the state in the arena.
    pub state: usize,
    /// The number of steps so far, as far as a bound counts it.
    pub steps: u32,
    /// The number of the set that is visited next, of those that are visited again and again.
    pub round: u32,
    /// True if the opponent chooses: all of its choices are listed.
    pub theirs: bool,
    /// The choice that is taken, or all of the opponent; none if the path is decided.
    pub choices: Vec<Taking>,
    /// The numbers of these choices in the arena.
    pub numbers: Vec<usize>,
}

/// A state with its memory.
type Key = (usize, u32, u32);

impl Optimal {
    /// Returns the nodes that the strategy visits from some states, these first. Cost: linear in the nodes.
    ///
    /// # Errors
    /// There are more than `limit` nodes.
    pub fn nodes(&self, arena: &Arena<'_>, starts: &[usize], limit: usize) -> Result<Vec<Node>> {
        let mut found = Found { keys: Vec::new(), numbers: AHashMap::new(), limit };
        for &state in starts {
            found.number((state, 0, self.entered(None, state)))?;
        }
        let (mut nodes, fractions): (Vec<Node>, _) = (Vec::new(), shared(arena));
        while let Some(&key) = found.keys.get(nodes.len()) {
            let (state, steps, round) = key;
            let theirs = arena.is_theirs(state as u32);
            let all = match self.is_decided(key) {
                true => 0..0,
                false if theirs => arena.choices.of(state as u32),
                false => match self.choice(key) {
                    NONE => 0..0,
                    choice => choice as usize..choice as usize + 1,
                },
            };
            let (mut choices, numbers) = (Vec::with_capacity(all.len()), all.clone().collect());
            for choice in all {
                let mut successors = Vec::new();
                for (to, weight) in arena.outcomes(choice) {
                    let later = (steps + 1).min(self.stages.len() as u32);
                    let next = (to as usize, later, self.entered(Some((state, round)), to as usize));
                    successors.push((found.number(next)?, Arc::clone(&fractions[weight as usize])));
                }
                choices.push(Taking { position: arena.position(choice), successors });
            }
            nodes.push(Node { state, steps, round, theirs, choices, numbers });
        }
        Ok(nodes)
    }

    fn entered(&self, from: Option<(usize, u32)>, to: usize) -> u32 {
        self.rounds.as_ref().map_or(0, |rounds| rounds.entered(from, to))
    }

    fn is_decided(&self, (state, steps, _): Key) -> bool {
        let (ends, since) = &self.ends;
        let is_last = steps as usize == self.stages.len() && self.rest.is_none();
        is_last || ends[state] && u64::from(steps) >= *since
    }

    fn choice(&self, (state, steps, round): Key) -> u32 {
        if let Some(stage) = self.stages.get(steps as usize) {
            return stage[state];
        }
        let again = self.rounds.as_ref().and_then(|rounds| rounds.choice(state, round));
        again.or_else(|| self.rest.as_ref().map(|rest| rest[state])).unwrap_or(NONE)
    }
}

/// The nodes found so far.
struct Found {
    keys: Vec<Key>,
    numbers: AHashMap<Key, usize>,
    limit: usize,
}

impl Found {
    fn number(&mut self, key: Key) -> Result<usize> {
        if let Some(&known) = self.numbers.get(&key) {
            return Ok(known);
        }
        let new = self.keys.len();
        if new == self.limit {
            let what = format!("a strategy of more than {} states with memory", self.limit);
            return Err(Limit::Size { what }.into());
        }
        self.keys.push(key);
        self.numbers.insert(key, new);
        Ok(new)
    }
}
