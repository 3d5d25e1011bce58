//! The sets of one engine as those of another one for the same model: of diagrams in one order as those in another, and of
//! diagrams as those of the explicit engine.

use std::borrow::Cow;
use std::hash::Hash;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use ahash::AHashMap;

use super::engine::Engine;
use super::explicit::{self, ExplicitEngine, Groups, PartOfGroups};
use super::handover::HandOver;
use super::membership;
use super::order_turns::Shared;
use super::symbolic::{self, OfGroup, SymbolicEngine};
use meliora_base::error::{Error, Result};

/// The sets translated so far.
pub(super) struct Translated {
    /// For each order the sets of other orders, since all orders last began to take turns.
    copies: Vec<Mutex<Copies>>,
    /// The sets of the explicit engine: diagrams are made no more, so these are at most the sets in use when it took over.
    listed: Mutex<Sets<explicit::StateSet, explicit::ChoiceSet>>,
    /// The number of each choice of the explicit engine among the groups of diagrams.
    groups: OnceLock<Groups>,
}

/// Sets by those of diagrams that they are translated from.
struct Sets<S, C> {
    states: AHashMap<symbolic::StateSet, S>,
    choices: AHashMap<symbolic::ChoiceSet, C>,
}

type Copies = Sets<symbolic::StateSet, symbolic::ChoiceSet>;

impl<S, C> Default for Sets<S, C> {
    fn default() -> Self {
        Sets { states: AHashMap::new(), choices: AHashMap::new() }
    }
}

impl Translated {
    pub(super) fn new(orders: usize) -> Self {
        let copies = Vec::from_iter((0..orders).map(|_| Mutex::default()));
        Translated { copies, listed: Mutex::default(), groups: OnceLock::new() }
    }

    /// Forgets the copies of all orders.
    pub(super) fn forget_copies(&self) {
        self.copies.iter().for_each(|sets| *lock(sets) = Sets::default());
    }
}

fn lock<T>(sets: &Mutex<T>) -> MutexGuard<'_, T> {
    sets.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Returns the translation of a set, and keeps it.
fn kept<T, X: Clone + Eq + Hash, Y: Clone>(
    sets: &Mutex<T>,
    of: impl Fn(&mut T) -> &mut AHashMap<X, Y>,
    x: &X,
    translate: impl FnOnce() -> Result<Y>,
) -> Result<Y> {
    if let Some(known) = of(&mut lock(sets)).get(x) {
        return Ok(known.clone());
    }
    let found = translate()?;
    of(&mut lock(sets)).insert(x.clone(), found.clone());
    Ok(found)
}

impl HandOver {
    /// Returns a set of states as one of an engine of diagrams.
    ///
    /// # Errors
    /// A limit; the set belongs to an engine of another model.
    pub(super) fn states_in<'x>(
        &self,
        engine: &SymbolicEngine,
        x: &'x symbolic::StateSet,
    ) -> Result<Cow<'x, symbolic::StateSet>> {
        if engine.owns(x) {
            return Ok(Cow::Borrowed(x));
        }
        let copy = || engine.copied(self.shared.owner(|from| from.owns(x))?, x);
        kept(self.shared.copies(engine)?, |sets| &mut sets.states, x, copy).map(Cow::Owned)
    }

    /// Returns a set of choices as one of an engine of diagrams.
    ///
    /// # Errors
    /// A limit; the set belongs to an engine of another model.
    pub(super) fn choices_in<'c>(
        &self,
        engine: &SymbolicEngine,
        c: &'c symbolic::ChoiceSet,
    ) -> Result<Cow<'c, symbolic::ChoiceSet>> {
        if engine.owns_choices(c) {
            return Ok(Cow::Borrowed(c));
        }
        let copy = || engine.copied_choices(self.shared.owner(|from| from.owns_choices(c))?, c);
        kept(self.shared.copies(engine)?, |sets| &mut sets.choices, c, copy).map(Cow::Owned)
    }

    /// Returns a set of states as one of the explicit engine.
    ///
    /// # Errors
    /// A limit; the set belongs to an engine of another model.
    pub(super) fn explicit_states(&self, x: &symbolic::StateSet) -> Result<explicit::StateSet> {
        let shared = &self.shared;
        kept(
            &shared.translated.listed,
            |sets| &mut sets.states,
            x,
            || {
                let (whole, owner) = (shared.listing()?, shared.owner(|from| from.owns(x))?);
                match *x == owner.all_states() {
                    true => Ok(whole.all_states()),
                    false => whole.adopt_states(&*owner.membership(&[x])?),
                }
            },
        )
    }

    /// Returns a set of choices as one of the explicit engine.
    ///
    /// # Errors
    /// A limit; the set belongs to an engine of another model.
    pub(super) fn explicit_choices(&self, c: &symbolic::ChoiceSet) -> Result<explicit::ChoiceSet> {
        let shared = &self.shared;
        kept(
            &shared.translated.listed,
            |sets| &mut sets.choices,
            c,
            || {
                let owner = shared.owner(|from| from.owns_choices(c))?;
                let parts = owner.by_group(c)?;
                match parts.iter().any(|part| matches!(part, OfGroup::Part(_) | OfGroup::Nothing)) {
                    true => shared.listed_in(owner, &parts),
                    false => Ok(shared.listing()?.all_choices()),
                }
            },
        )
    }
}

impl Shared {
    /// Returns the engine of diagrams that has a set.
    fn owner(&self, has: impl Fn(&SymbolicEngine) -> bool) -> Result<&Arc<SymbolicEngine>> {
        self.diagrams().find(|engine| has(engine)).ok_or(Error::ForeignSet)
    }

    /// Returns the copies for the order of an engine.
    fn copies(&self, engine: &SymbolicEngine) -> Result<&Mutex<Copies>> {
        let order = self.order_of(engine).ok_or(Error::ForeignSet)?;
        Ok(&self.translated.copies[order])
    }

    fn listing(&self) -> Result<&Arc<ExplicitEngine>> {
        self.explicit.get().ok_or(Error::ForeignSet)
    }

    /// Returns the pairs of some parts of all groups, as a set of the explicit engine.
    fn listed_in(&self, owner: &SymbolicEngine, parts: &[OfGroup]) -> Result<explicit::ChoiceSet> {
        let whole: Vec<bool> = parts.iter().map(|part| matches!(part, OfGroup::All)).collect();
        let some = parts.iter().enumerate().filter_map(|(group, part)| match part {
            OfGroup::Part(states) => Some((group, states)),
            OfGroup::All | OfGroup::Nothing => None,
        });
        let (groups, states): (Vec<usize>, Vec<&symbolic::StateSet>) = some.unzip();
        let chunks = groups.chunks(membership::MOST).zip(states.chunks(membership::MOST));
        let part = |(groups, states): (&[usize], &[&symbolic::StateSet])| {
            Ok(PartOfGroups { groups: groups.to_vec(), test: owner.membership(states)? })
        };
        let parts = chunks.map(part).collect::<Result<Vec<_>>>()?;
        self.listing()?.adopt_choices(self.groups()?, &whole, &parts)
    }

    fn groups(&self) -> Result<&Groups> {
        let groups = &self.translated.groups;
        if let Some(groups) = groups.get() {
            return Ok(groups);
        }
        let found = self.listing()?.group(&mut |choice| self.first.group_of(choice).unwrap_or(0) as u32)?;
        Ok(groups.get_or_init(|| found))
    }
}
