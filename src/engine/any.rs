//! One type for either engine, for callers that choose the engine at run time.

use std::borrow::Cow;
use std::sync::Arc;

use super::edge_labels::EdgeLabels;
use super::engine::{Algebra, Engine, Region};
use super::explicit::{self, ExplicitEngine};
use super::handover::{Current, HandOver};
use super::membership::Membership;
use super::settings::{Count, Settings, Storage, Usage};
use super::symbolic::{self, SymbolicEngine};
use meliora_base::error::{Error, Result};
use meliora_model::predicate::Predicate;
use meliora_model::step::Choice;
use meliora_model::{Program, State, VarId};

/// The symbolic or the explicit engine, or several that take turns until the explicit one takes over. Clones share the
/// explored states and the sets.
#[derive(Clone)]
pub struct AnyEngine {
    inner: Inner,
}

#[derive(Clone)]
enum Inner {
    Symbolic(Arc<SymbolicEngine>),
    Explicit(Arc<ExplicitEngine>),
    InTurns(Arc<HandOver>),
}

/// A set of states of an [`AnyEngine`].
#[derive(Clone)]
pub enum AnyStates {
    /// A set of the symbolic engine.
    Symbolic(symbolic::StateSet),
    /// A set of the explicit engine.
    Explicit(explicit::StateSet),
}

/// A set of (state, choice) pairs of an [`AnyEngine`].
#[derive(Clone)]
pub enum AnyChoices {
    /// A set of the symbolic engine.
    Symbolic(symbolic::ChoiceSet),
    /// A set of the explicit engine.
    Explicit(explicit::ChoiceSet),
}

/// Conversion of a set of either engine to the set type of one engine.
pub(super) trait Of<E: Engine> {
    type Set: Clone;
    /// # Errors
    /// The set belongs to the other kind of engine, and cannot be translated; a limit.
    fn of(&self, any: &AnyEngine, engine: &E) -> Result<Cow<'_, Self::Set>>;
}

macro_rules! sets_of {
    ($any:ident, $set:ident, $copied:ident, $listed:ident) => {
        impl Of<SymbolicEngine> for $any {
            type Set = symbolic::$set;
            fn of(&self, any: &AnyEngine, engine: &SymbolicEngine) -> Result<Cow<'_, symbolic::$set>> {
                match (self, &any.inner) {
                    ($any::Symbolic(set), Inner::InTurns(all)) => all.$copied(engine, set),
                    ($any::Symbolic(set), _) => Ok(Cow::Borrowed(set)),
                    ($any::Explicit(_), _) => Err(Error::ForeignSet),
                }
            }
        }

        impl Of<ExplicitEngine> for $any {
            type Set = explicit::$set;
            fn of(&self, any: &AnyEngine, _: &ExplicitEngine) -> Result<Cow<'_, explicit::$set>> {
                match (self, &any.inner) {
                    ($any::Explicit(set), _) => Ok(Cow::Borrowed(set)),
                    ($any::Symbolic(set), Inner::InTurns(all)) => all.$listed(set).map(Cow::Owned),
                    _ => Err(Error::ForeignSet),
                }
            }
        }

        impl From<symbolic::$set> for $any {
            fn from(set: symbolic::$set) -> Self {
                $any::Symbolic(set)
            }
        }

        impl From<explicit::$set> for $any {
            fn from(set: explicit::$set) -> Self {
                $any::Explicit(set)
            }
        }
    };
}

sets_of!(AnyStates, StateSet, states_in, explicit_states);
sets_of!(AnyChoices, ChoiceSet, choices_in, explicit_choices);

/// Evaluates the same expression with the engine of either kind.
macro_rules! on {
    ($any:expr, $engine:ident => $work:expr) => {
        match $any.known() {
            Current::Symbolic($engine) => $work,
            Current::Explicit($engine) => $work,
        }
    };
}

/// Evaluates the same fallible expression with the engine of either kind, or with several in turns.
macro_rules! attempt {
    ($any:expr, $engine:ident => $work:expr) => {{
        let work = |current: Current<'_>| match current {
            Current::Symbolic(engine) => {
                let $engine: &SymbolicEngine = engine;
                $work
            }
            Current::Explicit(engine) => {
                let $engine: &ExplicitEngine = engine;
                $work
            }
        };
        match &$any.inner {
            Inner::InTurns(all) => all.answer(&work),
            _ => work($any.known()),
        }
    }};
}

impl AnyEngine {
    /// Explores a program with the engine that the settings name.
    ///
    /// # Errors
    /// The errors of [`SymbolicEngine::new`] and [`ExplicitEngine::new`].
    pub fn new(program: Arc<Program>, settings: Settings) -> Result<Self> {
        Ok(match settings.storage {
            Storage::Symbolic => SymbolicEngine::new(program, settings)?.into(),
            Storage::Explicit => ExplicitEngine::new(program, settings)?.into(),
        })
    }

    /// Returns the kind of the engine.
    pub fn storage(&self) -> Storage {
        match self.known() {
            Current::Symbolic(_) => Storage::Symbolic,
            Current::Explicit(_) => Storage::Explicit,
        }
    }

    /// Returns the symbolic engine, or `None` if the engine is explicit.
    pub fn symbolic(&self) -> Option<&Arc<SymbolicEngine>> {
        match self.known() {
            Current::Symbolic(engine) => Some(engine),
            Current::Explicit(_) => None,
        }
    }

    /// Returns the explicit engine, or `None` if the engine is symbolic.
    pub fn explicit(&self) -> Option<&Arc<ExplicitEngine>> {
        match self.known() {
            Current::Symbolic(_) => None,
            Current::Explicit(engine) => Some(engine),
        }
    }

    /// Returns the engines that take turns; `None` if there is one engine.
    pub(super) fn in_turns(&self) -> Option<&HandOver> {
        match &self.inner {
            Inner::InTurns(all) => Some(all),
            _ => None,
        }
    }

    /// Runs an operation that cannot be repeated, without a limit of its steps.
    fn at_once<T>(&self, operation: impl FnOnce() -> Result<T>) -> Result<T> {
        match self.in_turns() {
            Some(all) => all.at_once(operation),
            None => operation(),
        }
    }

    fn known(&self) -> Current<'_> {
        match &self.inner {
            Inner::Symbolic(engine) => Current::Symbolic(engine),
            Inner::Explicit(engine) => Current::Explicit(engine),
            Inner::InTurns(all) => all.known(),
        }
    }

    /// Returns the program.
    pub fn program(&self) -> &Arc<Program> {
        on!(self, e => e.program())
    }

    /// Returns whether both share the explored states, so that each accepts the sets of the other.
    pub fn shares(&self, other: &AnyEngine) -> bool {
        match (&self.inner, &other.inner) {
            (Inner::Symbolic(a), Inner::Symbolic(b)) => a.shares(b),
            (Inner::Explicit(a), Inner::Explicit(b)) => a.shares(b),
            (Inner::InTurns(a), Inner::InTurns(b)) => a.shares(b),
            _ => false,
        }
    }
}

impl From<SymbolicEngine> for AnyEngine {
    fn from(engine: SymbolicEngine) -> Self {
        AnyEngine { inner: Inner::Symbolic(Arc::new(engine)) }
    }
}

impl From<ExplicitEngine> for AnyEngine {
    fn from(engine: ExplicitEngine) -> Self {
        AnyEngine { inner: Inner::Explicit(Arc::new(engine)) }
    }
}

impl From<HandOver> for AnyEngine {
    fn from(all: HandOver) -> Self {
        AnyEngine { inner: Inner::InTurns(Arc::new(all)) }
    }
}

/// Converts a region of one engine to a region of an [`AnyEngine`].
fn region<S: Into<AnyStates>, C: Into<AnyChoices>>(found: Region<S, C>) -> Region<AnyStates, AnyChoices> {
    Region { states: found.states.into(), choices: found.choices.into() }
}

/// Converts a region to the set types of one engine.
pub(super) fn region_of<E: Engine>(
    any: &AnyEngine,
    engine: &E,
    region: &Region<AnyStates, AnyChoices>,
) -> Result<Region<E::States, E::Choices>>
where
    AnyStates: Of<E, Set = E::States>,
    AnyChoices: Of<E, Set = E::Choices>,
{
    let states = region.states.of(any, engine)?.into_owned();
    Ok(Region { states, choices: region.choices.of(any, engine)?.into_owned() })
}

/// Converts edge labels to the set types of one engine.
fn edge_labels_of<E: Engine>(
    any: &AnyEngine,
    engine: &E,
    edge_labels: &[EdgeLabels<AnyStates>],
) -> Result<Vec<EdgeLabels<E::States>>>
where
    AnyStates: Of<E, Set = E::States>,
{
    let of = |set: &AnyStates| set.of(any, engine).map(Cow::into_owned);
    edge_labels
        .iter()
        .map(|labels| {
            let barred = labels.barred.iter().map(|(from, into)| Ok((of(from)?, of(into)?)));
            let barred = barred.collect::<Result<_>>()?;
            let (from, goal, dropped) = (of(&labels.from)?, of(&labels.goal)?, of(&labels.dropped)?);
            Ok(EdgeLabels { from, goal, dropped, barred })
        })
        .collect()
}

/// Defines methods without arguments by the methods of the engine.
macro_rules! constants {
    ($($name:ident: $result:ty;)*) => {$(
        fn $name(&self) -> $result {
            on!(self, e => e.$name().into())
        }
    )*};
}

/// Defines methods whose arguments are sets by the methods of the engine.
macro_rules! operations {
    ($($name:ident($($set:ident: $sort:ty),*) -> $result:ty;)*) => {$(
        fn $name(&self, $($set: &$sort),*) -> Result<$result> {
            attempt!(self, e => Ok(e.$name($(&*$set.of(self, e)?),*)?.into()))
        }
    )*};
}

macro_rules! algebra_of {
    ($any:ident) => {
        impl Algebra<$any> for AnyEngine {
            operations! {
                union(x: $any, y: $any) -> $any;
                intersection(x: $any, y: $any) -> $any;
                difference(x: $any, y: $any) -> $any;
                is_empty(x: $any) -> bool;
                same(x: $any, y: $any) -> bool;
                count(x: $any) -> Count;
            }
        }
    };
}

algebra_of!(AnyStates);
algebra_of!(AnyChoices);

// Every method calls the engine's own, including methods with a default body: the engine may have a
// faster one.
#[deny(clippy::missing_trait_methods, reason = "a default body would bypass the engine's own")]
impl Engine for AnyEngine {
    type States = AnyStates;
    type Choices = AnyChoices;

    constants! {
        all_states: AnyStates;
        no_states: AnyStates;
        initial_states: AnyStates;
        deadlock_states: AnyStates;
        all_choices: AnyChoices;
        no_choices: AnyChoices;
    }

    operations! {
        choices_in(c: AnyChoices, x: AnyStates) -> AnyChoices;
        sources(c: AnyChoices) -> AnyStates;
        can_choose(c: AnyChoices) -> AnyStates;
        cannot_choose(x: AnyStates, c: AnyChoices) -> AnyStates;
        pre(c: AnyChoices, x: AnyStates) -> AnyChoices;
        pre_within(c: AnyChoices, y: AnyStates) -> AnyChoices;
        post(c: AnyChoices) -> AnyStates;
        count_model_states(x: AnyStates) -> Option<Count>;
        count_transitions(c: AnyChoices, x: AnyStates) -> Count;
    }

    fn theirs(&self) -> Option<AnyStates> {
        on!(self, e => e.theirs().map(AnyStates::from))
    }

    fn player_states(&self) -> Vec<AnyStates> {
        on!(self, e => e.player_states().into_iter().map(AnyStates::from).collect())
    }

    fn coalition(&self) -> Vec<bool> {
        on!(self, e => e.coalition())
    }

    fn is_game(&self) -> bool {
        on!(self, e => e.is_game())
    }

    fn with_coalition(&self, coalition: &[bool]) -> Result<Self> {
        Ok(match &self.inner {
            Inner::Symbolic(e) => e.with_coalition(coalition)?.into(),
            Inner::Explicit(e) => e.with_coalition(coalition)?.into(),
            Inner::InTurns(all) => all.with_coalition(self, coalition)?.into(),
        })
    }

    fn exchanged(&self) -> Result<Option<Self>> {
        let others: Vec<bool> = self.coalition().into_iter().map(|ours| !ours).collect();
        self.theirs().map(|_| self.with_coalition(&others)).transpose()
    }

    fn is_markov_chain(&self) -> bool {
        on!(self, e => e.is_markov_chain())
    }

    fn drawing_states(&self) -> Option<Count> {
        on!(self, e => e.drawing_states())
    }

    fn rounded_state(&self) -> Option<&State> {
        on!(self, e => e.rounded_state())
    }

    fn restricted_to(&self, to: &Region<AnyStates, AnyChoices>) -> Result<Self> {
        Ok(match &self.inner {
            Inner::Symbolic(e) => e.restricted_to(&region_of(self, &**e, to)?)?.into(),
            Inner::Explicit(e) => e.restricted_to(&region_of(self, &**e, to)?)?.into(),
            Inner::InTurns(all) => all.restricted_to(self, to)?.into(),
        })
    }

    fn states_where(&self, predicate: &Predicate) -> Result<AnyStates> {
        attempt!(self, e => Ok(e.states_where(predicate)?.into()))
    }

    fn can_reach(
        &self,
        target: &AnyStates,
        within: &AnyChoices,
        edge_labels: &[EdgeLabels<AnyStates>],
    ) -> Result<AnyStates> {
        attempt!(self, e => Ok(e.can_reach(&*target.of(self, e)?, &*within.of(self, e)?, &edge_labels_of(self, e, edge_labels)?)?.into()))
    }

    fn can_win(
        &self,
        winning: &AnyChoices,
        within: &AnyChoices,
        edge_labels: &[EdgeLabels<AnyStates>],
    ) -> Result<AnyStates> {
        attempt!(self, e => {
            let edge_labels = edge_labels_of(self, e, edge_labels)?;
            Ok(e.can_win(&*winning.of(self, e)?, &*within.of(self, e)?, &edge_labels)?.into())
        })
    }

    fn remove_attractor(
        &self,
        left: Region<AnyStates, AnyChoices>,
        within: &AnyChoices,
        won: &AnyStates,
        edge_labels: &[EdgeLabels<AnyStates>],
        lost: AnyStates,
    ) -> Result<Region<AnyStates, AnyChoices>> {
        attempt!(self, e => {
            let (left, edge_labels) = (region_of(self, e, &left)?, edge_labels_of(self, e, edge_labels)?);
            let (within, won, lost) = (&*within.of(self, e)?, &*won.of(self, e)?, lost.of(self, e)?.into_owned());
            Ok(region(e.remove_attractor(left, within, won, &edge_labels, lost)?))
        })
    }

    fn stay_within(&self, x: &AnyStates, within: &AnyChoices) -> Result<Region<AnyStates, AnyChoices>> {
        attempt!(self, e => Ok(region(e.stay_within(&*x.of(self, e)?, &*within.of(self, e)?)?)))
    }

    fn can_reach_through(&self, target: &AnyStates, bound: &AnyStates) -> Result<AnyStates> {
        attempt!(self, e => Ok(e.can_reach_through(&*target.of(self, e)?, &*bound.of(self, e)?)?.into()))
    }

    fn surely_staying(&self, x: &AnyStates, within: &AnyChoices) -> Result<AnyStates> {
        attempt!(self, e => Ok(e.surely_staying(&*x.of(self, e)?, &*within.of(self, e)?)?.into()))
    }

    fn almost_surely_reach(
        &self,
        target: &AnyStates,
        within: &AnyChoices,
    ) -> Result<Region<AnyStates, AnyChoices>> {
        attempt!(self, e => Ok(region(e.almost_surely_reach(&*target.of(self, e)?, &*within.of(self, e)?)?)))
    }

    fn almost_surely_win(
        &self,
        start: Region<AnyStates, AnyChoices>,
        edge_labels: &[EdgeLabels<AnyStates>],
    ) -> Result<Region<AnyStates, AnyChoices>> {
        attempt!(self, e => Ok(region(e.almost_surely_win(region_of(self, e, &start)?, &edge_labels_of(self, e, edge_labels)?)?)))
    }

    fn list_states(&self, x: &AnyStates, limit: usize) -> Result<Vec<State>> {
        attempt!(self, e => e.list_states(&*x.of(self, e)?, limit))
    }

    fn singleton(&self, state: &[i64]) -> Result<AnyStates> {
        attempt!(self, e => Ok(e.singleton(state)?.into()))
    }

    fn set_of(&self, states: &mut dyn Iterator<Item = State>) -> Result<AnyStates> {
        // The states cannot be listed twice.
        self.at_once(|| on!(self, e => Ok(e.set_of(states)?.into())))
    }

    fn slice(&self, fixed: &[(VarId, i64)]) -> Result<AnyStates> {
        attempt!(self, e => Ok(e.slice(fixed)?.into()))
    }

    fn contains(&self, x: &AnyStates, state: &[i64]) -> Result<bool> {
        attempt!(self, e => e.contains(&*x.of(self, e)?, state))
    }

    fn membership<'e>(&'e self, sets: &[&AnyStates]) -> Result<Box<dyn Membership + 'e>> {
        let own = attempt!(self, e => {
            sets.iter().map(|x| Ok(AnyStates::from(x.of(self, e)?.into_owned()))).collect::<Result<Vec<_>>>()
        })?;
        let sets = || -> Result<_> {
            on!(self, e => {
                let e = &**e;
                let sets = own.iter().map(|x| x.of(self, e)).collect::<Result<Vec<_>>>()?;
                e.membership(&sets.iter().map(|x| &**x).collect::<Vec<_>>())
            })
        };
        self.at_once(sets)
    }

    fn contains_choice(&self, c: &AnyChoices, state: &[i64], choice: &Choice) -> Result<bool> {
        attempt!(self, e => e.contains_choice(&*c.of(self, e)?, state, choice))
    }

    fn usage(&self) -> Usage {
        match &self.inner {
            Inner::InTurns(all) => all.usage(),
            _ => on!(self, e => e.usage()),
        }
    }

    fn settings(&self) -> &Settings {
        match &self.inner {
            Inner::InTurns(all) => all.settings(),
            _ => on!(self, e => e.settings()),
        }
    }
}
