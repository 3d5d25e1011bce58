//! Choices as groups, and their relations as partial relations.
//!
//! A *group* is a set of choices of which at most one is enabled in each state: commands of one
//! synchronisation with disjoint guards. A set of (state, choice) pairs is therefore one set of
//! states per group, and thousands of commands need few groups. A *piece* is a partial relation of
//! a group.

use std::sync::Arc;

use ahash::AHashMap;

use super::command::{CommandBuilder, CommandRelation};
use crate::symbolic::relations::lists::{Lists, RelationList};
use crate::symbolic::relations::partial_relation::PartialRelation;
use crate::symbolic::relations::support::Support;
use crate::symbolic::store::Store;
use crate::symbolic::store::diagram::Bdd;
use meliora_base::error::{Error, Limit, Result};
use meliora_model::players::Unlisted;
use meliora_model::step::Choice;
use meliora_model::{CommandId, ModelKind, Program, Synchronisation};

/// Maximum number of groups. More are refused: the product of overlapping alternatives is too
/// large.
const MOST_GROUPS: usize = 1 << 14;

/// A partial relation of one group.
#[derive(Clone)]
pub(in crate::symbolic) struct Piece {
    /// The group of the choices.
    pub(in crate::symbolic) group: usize,
    pub(in crate::symbolic) steps: PartialRelation,
}

/// All relations of a program, before its states are known.
#[derive(Clone)]
pub(in crate::symbolic) struct Transitions {
    /// The states in which a choice of each group is enabled.
    pub(in crate::symbolic) guards: Vec<Bdd>,
    /// The pieces of all groups, sorted by group.
    pub(in crate::symbolic) pieces: Vec<Piece>,
    /// The states in which some command has no meaning.
    pub(in crate::symbolic) bad: Bdd,
    /// For each synchronisation the index of its first group and, for each factor, the colour of
    /// each command.
    colours: Vec<(usize, Vec<Colouring>)>,
    uniform: bool,
}

/// The choices that have one number in a dump.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Numbered {
    /// Combinations of a synchronisation: for each factor one of the listed commands.
    Combinations {
        /// The position in [`Program::synchronisations`].
        synchronisation: usize,
        /// The commands of each factor.
        commands: Vec<Vec<CommandId>>,
    },
    /// The only choice of the states of a `dtmc`.
    Uniform,
    /// The self-loop of deadlock states.
    Deadlock,
}

/// Commands of one factor by colour: commands of one colour have disjoint guards.
#[derive(Clone)]
struct Colouring {
    of: AHashMap<CommandId, usize>,
    count: usize,
}

/// The commands of one colour of one factor, with the union of their guards.
struct Alternative {
    guard: Bdd,
    members: Vec<CommandId>,
}

pub(in crate::symbolic) struct Builder<'a> {
    store: &'a Store,
    commands: Vec<CommandRelation>,
    /// The command of the monitors, which takes part in every synchronisation.
    watching: Option<CommandId>,
}

impl<'a> Builder<'a> {
    /// Translates all commands and combines them into groups.
    pub(in crate::symbolic) fn build(
        program: &'a Program,
        store: &'a Store,
        commands: &CommandBuilder<'_>,
    ) -> Result<Transitions> {
        let (mut relations, mut bad) = (Vec::new(), Vec::new());
        for command in &program.commands {
            let (relation, wrong) = commands.build(command)?;
            relations.push(relation);
            bad.push(wrong);
        }
        let watching = program.monitors.as_ref().map(|o| CommandId(o.command as u32));
        let builder = Builder { store, commands: relations, watching };
        let uniform = program.kind == ModelKind::Dtmc;
        let mut all =
            Transitions { guards: vec![], pieces: vec![], bad: store.any(bad)?, colours: vec![], uniform };
        for synchronisation in &program.synchronisations {
            builder.synchronise(&synchronisation.factors, &mut all)?;
        }
        if uniform {
            all.guards = vec![store.any(std::mem::take(&mut all.guards))?];
            all.pieces.iter_mut().for_each(|p| p.group = 0);
        }
        Ok(all)
    }

    /// Adds the groups and pieces of one synchronisation.
    fn synchronise(&self, factors: &[Vec<CommandId>], all: &mut Transitions) -> Result<()> {
        let mut alternatives = Vec::new();
        let mut colourings = Vec::new();
        for factor in factors {
            let (colouring, members) = self.colour(factor)?;
            colourings.push(colouring);
            alternatives.push(members);
        }
        all.bad = self.store.or(&all.bad, &self.bad_updates(factors)?)?;
        let groups = alternatives.iter().map(Vec::len).try_fold(1usize, usize::checked_mul);
        let first = all.guards.len();
        if groups.is_none_or(|n| n + first > MOST_GROUPS) {
            return Err(too_many());
        }
        for combination in product(&alternatives) {
            self.group(&combination, all)?;
        }
        all.colours.push((first, colourings));
        Ok(())
    }

    /// Returns the states in which a combination is enabled and one of its updates is bad.
    fn bad_updates(&self, factors: &[Vec<CommandId>]) -> Result<Bdd> {
        let enabled = |factor: &Vec<CommandId>| {
            self.store.any(factor.iter().map(|c| self.commands[c.index()].guard.clone()))
        };
        let mut total = Vec::new();
        for (index, factor) in factors.iter().enumerate() {
            let mut bad =
                self.store.any(factor.iter().map(|c| self.commands[c.index()].bad_update.clone()))?;
            for (other, partner) in factors.iter().enumerate() {
                if other != index && !self.store.is_zero(&bad) {
                    bad = self.store.and(&bad, &enabled(partner)?)?;
                }
            }
            total.push(bad);
        }
        self.store.any(total)
    }

    /// Colours the commands greedily: each command gets the first colour with which its guard does
    /// not overlap.
    fn colour(&self, factor: &[CommandId]) -> Result<(Colouring, Vec<Alternative>)> {
        let mut alternatives: Vec<Alternative> = Vec::new();
        let mut of = AHashMap::new();
        for &id in factor {
            let guard = &self.commands[id.index()].guard;
            let mut colour = alternatives.len();
            for (index, alternative) in alternatives.iter().enumerate() {
                if self.store.is_zero(&self.store.and(&alternative.guard, guard)?) {
                    colour = index;
                    break;
                }
            }
            if colour >= MOST_GROUPS {
                return Err(too_many());
            }
            of.insert(id, colour);
            match alternatives.get_mut(colour) {
                None => alternatives.push(Alternative { guard: guard.clone(), members: vec![id] }),
                Some(alternative) => {
                    alternative.guard = self.store.or(&alternative.guard, guard)?;
                    alternative.members.push(id);
                }
            }
        }
        Ok((Colouring { of, count: alternatives.len() }, alternatives))
    }

    /// Adds one group: a combination of one colour per factor.
    fn group(&self, combination: &[&Alternative], all: &mut Transitions) -> Result<()> {
        let group = all.guards.len();
        let mut guard = self.store.one();
        for alternative in combination {
            guard = self.store.and(&guard, &alternative.guard)?;
        }
        all.guards.push(guard);
        match combination {
            [single] => self.single(group, single, None, all),
            // One piece per written bit, as without monitors; each one includes the step of the
            // monitors.
            [single, other] if self.watching.is_some_and(|w| other.members == [w]) => {
                self.single(group, single, self.watching, all)
            }
            several => self.several(group, several, all),
        }
    }

    /// Adds the pieces of a group with one participant: one piece for the commands with the same
    /// first written bit.
    fn single(
        &self,
        group: usize,
        alternative: &Alternative,
        watching: Option<CommandId>,
        all: &mut Transitions,
    ) -> Result<()> {
        let mut by_top: Vec<(u32, Vec<&PartialRelation>)> = Vec::new();
        for steps in alternative.members.iter().map(|id| self.steps(*id)) {
            let top = steps.support.top();
            match by_top.iter_mut().find(|(t, _)| *t == top) {
                Some((_, several)) => several.push(steps),
                None => by_top.push((top, vec![steps])),
            }
        }
        for (_, several) in by_top {
            let mut steps = PartialRelation::union(self.store, &several)?;
            if let Some(command) = watching {
                steps = steps.beside(self.store, self.steps(command))?;
            }
            all.pieces.push(Piece { group, steps });
        }
        Ok(())
    }

    /// Adds the piece of a group with several participants: their simultaneous steps.
    fn several(&self, group: usize, combination: &[&Alternative], all: &mut Transitions) -> Result<()> {
        let mut steps = PartialRelation { support: Support::new([]), relation: self.store.one() };
        for alternative in combination {
            let own = Vec::from_iter(alternative.members.iter().map(|id| self.steps(*id)));
            steps = steps.beside(self.store, &PartialRelation::union(self.store, &own)?)?;
        }
        if !self.store.is_zero(&steps.relation) {
            all.pieces.push(Piece { group, steps });
        }
        Ok(())
    }

    fn steps(&self, command: CommandId) -> &PartialRelation {
        &self.commands[command.index()].steps
    }
}

fn too_many() -> Error {
    let what = format!("more than {MOST_GROUPS} combinations of overlapping commands");
    Limit::Size { what }.into()
}

impl Transitions {
    /// Returns all diagrams.
    pub(in crate::symbolic) fn diagrams(&mut self) -> impl Iterator<Item = &mut Bdd> {
        self.guards
            .iter_mut()
            .chain(self.pieces.iter_mut().map(|p| &mut p.steps.relation))
            .chain([&mut self.bad])
    }

    /// Returns the list of the pieces of all groups.
    pub(in crate::symbolic) fn list(&self, store: &Store, lists: &Arc<Lists>) -> Result<Arc<RelationList>> {
        lists.of(store, self.pieces.iter().map(|piece| piece.steps.clone()).collect())
    }

    /// Returns the list of the pieces of each group.
    pub(in crate::symbolic) fn lists(
        &self,
        store: &Store,
        lists: &Arc<Lists>,
    ) -> Result<Vec<Arc<RelationList>>> {
        let mut entries = vec![Vec::new(); self.guards.len()];
        self.pieces.iter().for_each(|p| entries[p.group].push(p.steps.clone()));
        entries.into_iter().map(|e| lists.of(store, e)).collect()
    }

    /// Returns the combinations of commands that make up each group; not for a `dtmc`.
    pub(in crate::symbolic) fn combinations(&self, program: &Program) -> Vec<Numbered> {
        let mut all = Vec::new();
        for (synchronisation, (_, colourings)) in self.colours.iter().enumerate() {
            let factors = &program.synchronisations[synchronisation].factors;
            let mut rows: Vec<Vec<Vec<CommandId>>> = vec![Vec::new()];
            for (colouring, factor) in colourings.iter().zip(factors) {
                let coloured = |colour: usize| -> Vec<CommandId> {
                    factor.iter().copied().filter(|c| colouring.of.get(c) == Some(&colour)).collect()
                };
                let longer = |row: &Vec<Vec<CommandId>>| -> Vec<_> {
                    (0..colouring.count).map(|k| [row.clone(), vec![coloured(k)]].concat()).collect()
                };
                rows = rows.iter().flat_map(longer).collect();
            }
            all.extend(rows.into_iter().map(|commands| Numbered::Combinations { synchronisation, commands }));
        }
        all
    }

    /// Returns the player of each group in a game.
    pub(in crate::symbolic) fn players(&self, program: &Program) -> Vec<Option<usize>> {
        self.by_group(program, None, |synchronisation| program.player_of(synchronisation))
    }

    /// Returns for each group in a game whether its choice must be the only one of a state.
    pub(in crate::symbolic) fn alone(&self, program: &Program) -> Vec<bool> {
        let is_alone = |synchronisation: &_| program.unlisted(synchronisation) == Some(Unlisted::Alone);
        self.by_group(program, false, is_alone)
    }

    /// Returns a property of the synchronisation of each group.
    fn by_group<T: Clone>(&self, program: &Program, none: T, of: impl Fn(&Synchronisation) -> T) -> Vec<T> {
        let mut found = vec![none; self.guards.len()];
        for ((first, colourings), synchronisation) in self.colours.iter().zip(&program.synchronisations) {
            let groups = colourings.iter().map(|colouring| colouring.count).product::<usize>();
            found[*first..*first + groups].fill(of(synchronisation));
        }
        found
    }

    /// Returns the group of a choice.
    pub(in crate::symbolic) fn group_of(&self, choice: &Choice) -> Option<usize> {
        match choice {
            Choice::Uniform => self.uniform.then_some(0),
            Choice::Deadlock => Some(self.guards.len()),
            // All enabled combinations are one choice, so none is a choice alone.
            Choice::Combination { .. } if self.uniform => None,
            Choice::Combination { synchronisation, commands } => {
                let (first, colourings) = self.colours.get(*synchronisation)?;
                let mut index = 0;
                for (colouring, command) in colourings.iter().zip(commands) {
                    index = index * colouring.count + colouring.of.get(command)?;
                }
                Some(first + index)
            }
        }
    }
}

/// Returns the Cartesian product; the first factor varies slowest.
fn product(factors: &[Vec<Alternative>]) -> Vec<Vec<&Alternative>> {
    let mut all: Vec<Vec<&Alternative>> = vec![Vec::new()];
    for factor in factors {
        let mut longer = Vec::new();
        for prefix in &all {
            longer.extend(factor.iter().map(|a| prefix.iter().copied().chain([a]).collect::<Vec<_>>()));
        }
        all = longer;
    }
    all
}
