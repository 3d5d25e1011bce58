//! The choices of the states that were explored, by their commands. Many states have the same; each list is stored once.

use smallvec::SmallVec;

use super::lists::Lists;
pub use super::lists::MOST;
use meliora_model::step::Combination;
use meliora_model::{CommandId, ModelKind, Program};

/// The choices of all states. A model whose states have too many different lists of them has no short description of these.
///
/// A list has synchronisations, each with the enabled commands of its factors: see
/// [`Stepper::key_into`](super::stepper::Stepper::key_into).
#[derive(Debug)]
pub struct Enabled(pub(crate) Lists);

impl Enabled {
    /// Returns the number of the list of a state.
    pub fn list(&self, state: usize) -> u32 {
        self.0.number(state)
    }

    /// Returns the number of lists.
    pub fn lists(&self) -> usize {
        self.0.count()
    }

    /// Returns the synchronisations of a list, each with the enabled commands of its factors.
    fn parts(&self, program: &Program, list: u32) -> impl Iterator<Item = Part<'_>> {
        let mut key = self.0.list(list);
        std::iter::from_fn(move || {
            first_part(&mut key, |index| program.synchronisations[index].factors.len())
        })
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
fn first_part<'k>(key: &mut &'k [u32], factors: impl Fn(usize) -> usize) -> Option<Part<'k>> {
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
