//! The choices of the states that were explored, by their commands. Many states have the same; each list is stored once.

use std::sync::Arc;

use ahash::AHashMap;
use smallvec::SmallVec;

use super::meter::{Array, Meter};
use meliora_base::error::Result;
use meliora_model::step::Combination;
use meliora_model::{CommandId, ModelKind, Program};

/// Maximum number of lists. A model whose states have more of them has no short description of its choices.
pub(crate) const MOST: usize = 1 << 16;

/// A list of synchronisations, each with the enabled commands of its factors: see
/// [`Stepper::key_into`](super::stepper::Stepper::key_into).
type Key = Arc<[u32]>;

/// The lists of choices, while states are explored.
pub(crate) struct Collected {
    numbers: AHashMap<Key, u32>,
    lists: Vec<Key>,
    of_state: Array<u32>,
    /// The list that was added last.
    pub(crate) key: Vec<u32>,
}

impl Collected {
    pub(crate) fn new(meter: &Meter) -> Self {
        let of_state = Array::new(meter);
        Collected { numbers: AHashMap::new(), lists: Vec::new(), of_state, key: Vec::new() }
    }

    /// Adds the list of the next state, [`Collected::key`]; returns false if there are too many lists.
    pub(crate) fn add(&mut self) -> Result<bool> {
        let number = match self.numbers.get(&self.key[..]) {
            Some(&known) => known,
            None if self.lists.len() == MOST => return Ok(false),
            None => {
                let (key, new) = (Key::from(&self.key[..]), self.lists.len() as u32);
                self.lists.push(Arc::clone(&key));
                self.numbers.insert(key, new);
                new
            }
        };
        self.of_state.push(number)?;
        Ok(true)
    }

    pub(crate) fn finish(self) -> Enabled {
        Enabled { lists: self.lists, of_state: self.of_state }
    }
}

/// The lists of choices of all states.
#[derive(Debug)]
pub struct Enabled {
    lists: Vec<Key>,
    of_state: Array<u32>,
}

impl Enabled {
    /// Returns the number of the list of a state.
    pub fn list(&self, state: usize) -> u32 {
        self.of_state[state]
    }

    /// Returns a list, by its number.
    pub fn key(&self, list: u32) -> &[u32] {
        &self.lists[list as usize]
    }

    /// Returns the number of lists.
    pub fn lists(&self) -> usize {
        self.lists.len()
    }

    /// Returns the synchronisations of a list, each with the enabled commands of its factors.
    fn parts(&self, program: &Program, list: u32) -> impl Iterator<Item = Part<'_>> {
        let mut key = self.key(list);
        std::iter::from_fn(move || {
            first_part(&mut key, |index| program.synchronisations[index].factors.len())
        })
    }

    /// Returns the synchronisations of a list, each with the number of its choices.
    pub fn synchronisations(&self, program: &Program, list: u32) -> impl Iterator<Item = (usize, usize)> {
        self.parts(program, list)
            .map(|(index, factors)| (index, factors.iter().map(|own| own.len()).product()))
    }

    /// Returns the choices of a list, in the order of [`Program::steps`]; none of a deadlock.
    pub fn combinations(&self, program: &Program, list: u32) -> Vec<Combination> {
        let mut found = Vec::new();
        for (synchronisation, factors) in self.parts(program, list) {
            let mut combinations: Vec<Vec<CommandId>> = vec![Vec::new()];
            for commands in factors {
                let with = |own: &Vec<CommandId>| {
                    let own = own.clone();
                    commands
                        .iter()
                        .map(move |&command| own.iter().copied().chain([CommandId(command)]).collect())
                };
                combinations = combinations.iter().flat_map(with).collect();
            }
            found.extend(combinations.into_iter().map(|commands| (synchronisation, commands)));
        }
        found
    }

    /// Returns the names of the choices of a list, as [`Program::choices`] does.
    pub fn names(&self, program: &Program, list: u32) -> Vec<String> {
        names_of(program, &self.combinations(program, list))
    }
}

/// A synchronisation, with the enabled commands of its factors.
type Part<'k> = (usize, SmallVec<[&'k [u32]; 4]>);

/// Takes the first synchronisation from a list, given the number of the factors of each.
pub(crate) fn first_part<'k>(key: &mut &'k [u32], factors: impl Fn(usize) -> usize) -> Option<Part<'k>> {
    let (&index, mut rest) = key.split_first()?;
    let mut commands = SmallVec::new();
    for _ in 0..factors(index as usize) {
        let (&count, own) = rest.split_first()?;
        let (own, left) = own.split_at(count as usize);
        commands.push(own);
        rest = left;
    }
    *key = rest;
    Some((index as usize, commands))
}

/// Returns the names of the choices of a state, as [`Program::choices`] does.
pub(crate) fn names_of(program: &Program, combinations: &[Combination]) -> Vec<String> {
    if combinations.is_empty() {
        return vec!["deadlock".to_owned()];
    }
    let names = program.names(combinations);
    if program.kind == ModelKind::Dtmc { vec![names.join("+")] } else { names }
}
