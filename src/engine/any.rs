//! One type for either engine, for callers that choose the engine at run time.

use std::sync::Arc;

use super::edge_labels::EdgeLabels;
use super::engine::{Algebra, Engine, Region};
use super::explicit::{self, ExplicitEngine};
use super::membership::Membership;
use super::settings::{Count, Settings, Storage, Usage};
use super::symbolic::{self, SymbolicEngine};
use meliora_base::error::{Error, Result};
use meliora_model::predicate::Predicate;
use meliora_model::step::Choice;
use meliora_model::{Program, State, VarId};

/// The symbolic or the explicit engine. Clones share the explored states and the sets.
#[derive(Clone)]
pub struct AnyEngine {
    inner: Inner,
}

#[derive(Clone)]
enum Inner {
    Symbolic(Arc<SymbolicEngine>),
    Explicit(Arc<ExplicitEngine>),
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
trait Of<E: Engine> {
    type Set;
    /// # Errors
    /// The set belongs to the other kind of engine.
    fn of(&self, engine: &E) -> Result<&Self::Set>;
}

macro_rules! sets_of {
    ($any:ident, $variant:ident, $engine:ident, $set:ty) => {
        impl Of<$engine> for $any {
            type Set = $set;
            fn of(&self, _: &$engine) -> Result<&$set> {
                match self {
                    $any::$variant(set) => Ok(set),
                    _ => Err(Error::ForeignSet),
                }
            }
        }

        impl From<$set> for $any {
            fn from(set: $set) -> Self {
                $any::$variant(set)
            }
        }
    };
}

sets_of!(AnyStates, Symbolic, SymbolicEngine, symbolic::StateSet);
sets_of!(AnyStates, Explicit, ExplicitEngine, explicit::StateSet);
sets_of!(AnyChoices, Symbolic, SymbolicEngine, symbolic::ChoiceSet);
sets_of!(AnyChoices, Explicit, ExplicitEngine, explicit::ChoiceSet);

/// Evaluates the same expression with the engine of either kind.
macro_rules! on {
    ($any:expr, $engine:ident => $work:expr) => {
        match &$any.inner {
            Inner::Symbolic($engine) => {
                let $engine = &**$engine;
                $work
            }
            Inner::Explicit($engine) => {
                let $engine = &**$engine;
                $work
            }
        }
    };
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
        match &self.inner {
            Inner::Symbolic(_) => Storage::Symbolic,
            Inner::Explicit(_) => Storage::Explicit,
        }
    }

    /// Returns the symbolic engine, or `None` if the engine is explicit.
    pub fn symbolic(&self) -> Option<&Arc<SymbolicEngine>> {
        match &self.inner {
            Inner::Symbolic(engine) => Some(engine),
            Inner::Explicit(_) => None,
        }
    }

    /// Returns the explicit engine, or `None` if the engine is symbolic.
    pub fn explicit(&self) -> Option<&Arc<ExplicitEngine>> {
        match &self.inner {
            Inner::Symbolic(_) => None,
            Inner::Explicit(engine) => Some(engine),
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

/// Converts a region of one engine to a region of an [`AnyEngine`].
fn region<S: Into<AnyStates>, C: Into<AnyChoices>>(found: Region<S, C>) -> Region<AnyStates, AnyChoices> {
    Region { states: found.states.into(), choices: found.choices.into() }
}

/// Converts a region to the set types of one engine.
fn region_of<E: Engine>(
    engine: &E,
    region: &Region<AnyStates, AnyChoices>,
) -> Result<Region<E::States, E::Choices>>
where
    AnyStates: Of<E, Set = E::States>,
    AnyChoices: Of<E, Set = E::Choices>,
{
    Ok(Region { states: region.states.of(engine)?.clone(), choices: region.choices.of(engine)?.clone() })
}

/// Converts edge labels to the set types of one engine.
fn edge_labels_of<E: Engine>(
    engine: &E,
    edge_labels: &[EdgeLabels<AnyStates>],
) -> Result<Vec<EdgeLabels<E::States>>>
where
    AnyStates: Of<E, Set = E::States>,
{
    let of = |set: &AnyStates| set.of(engine).cloned();
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
            on!(self, e => Ok(e.$name($($set.of(e)?),*)?.into()))
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
        let inner = match &self.inner {
            Inner::Symbolic(e) => Inner::Symbolic(Arc::new(e.with_coalition(coalition)?)),
            Inner::Explicit(e) => Inner::Explicit(Arc::new(e.with_coalition(coalition)?)),
        };
        Ok(AnyEngine { inner })
    }

    fn exchanged(&self) -> Result<Option<Self>> {
        let inner = match &self.inner {
            Inner::Symbolic(e) => e.exchanged()?.map(|e| Inner::Symbolic(Arc::new(e))),
            Inner::Explicit(e) => e.exchanged()?.map(|e| Inner::Explicit(Arc::new(e))),
        };
        Ok(inner.map(|inner| AnyEngine { inner }))
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
        let inner = match &self.inner {
            Inner::Symbolic(e) => Inner::Symbolic(Arc::new(e.restricted_to(&region_of(&**e, to)?)?)),
            Inner::Explicit(e) => Inner::Explicit(Arc::new(e.restricted_to(&region_of(&**e, to)?)?)),
        };
        Ok(AnyEngine { inner })
    }

    fn states_where(&self, predicate: &Predicate) -> Result<AnyStates> {
        on!(self, e => Ok(e.states_where(predicate)?.into()))
    }

    fn can_reach(
        &self,
        target: &AnyStates,
        within: &AnyChoices,
        edge_labels: &[EdgeLabels<AnyStates>],
    ) -> Result<AnyStates> {
        on!(self, e => Ok(e.can_reach(target.of(e)?, within.of(e)?, &edge_labels_of(e, edge_labels)?)?.into()))
    }

    fn can_win(
        &self,
        winning: &AnyChoices,
        within: &AnyChoices,
        edge_labels: &[EdgeLabels<AnyStates>],
    ) -> Result<AnyStates> {
        on!(self, e => {
            let edge_labels = edge_labels_of(e, edge_labels)?;
            Ok(e.can_win(winning.of(e)?, within.of(e)?, &edge_labels)?.into())
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
        on!(self, e => {
            let (left, edge_labels) = (region_of(e, &left)?, edge_labels_of(e, edge_labels)?);
            let (within, won, lost) = (within.of(e)?, won.of(e)?, lost.of(e)?.clone());
            Ok(region(e.remove_attractor(left, within, won, &edge_labels, lost)?))
        })
    }

    fn stay_within(&self, x: &AnyStates, within: &AnyChoices) -> Result<Region<AnyStates, AnyChoices>> {
        on!(self, e => Ok(region(e.stay_within(x.of(e)?, within.of(e)?)?)))
    }

    fn can_reach_through(&self, target: &AnyStates, bound: &AnyStates) -> Result<AnyStates> {
        on!(self, e => Ok(e.can_reach_through(target.of(e)?, bound.of(e)?)?.into()))
    }

    fn surely_staying(&self, x: &AnyStates, within: &AnyChoices) -> Result<AnyStates> {
        on!(self, e => Ok(e.surely_staying(x.of(e)?, within.of(e)?)?.into()))
    }

    fn almost_surely_reach(
        &self,
        target: &AnyStates,
        within: &AnyChoices,
    ) -> Result<Region<AnyStates, AnyChoices>> {
        on!(self, e => Ok(region(e.almost_surely_reach(target.of(e)?, within.of(e)?)?)))
    }

    fn almost_surely_win(
        &self,
        start: Region<AnyStates, AnyChoices>,
        edge_labels: &[EdgeLabels<AnyStates>],
    ) -> Result<Region<AnyStates, AnyChoices>> {
        on!(self, e => Ok(region(e.almost_surely_win(region_of(e, &start)?, &edge_labels_of(e, edge_labels)?)?)))
    }

    fn list_states(&self, x: &AnyStates, limit: usize) -> Result<Vec<State>> {
        on!(self, e => e.list_states(x.of(e)?, limit))
    }

    fn singleton(&self, state: &[i64]) -> Result<AnyStates> {
        on!(self, e => Ok(e.singleton(state)?.into()))
    }

    fn set_of(&self, states: &mut dyn Iterator<Item = State>) -> Result<AnyStates> {
        on!(self, e => Ok(e.set_of(states)?.into()))
    }

    fn slice(&self, fixed: &[(VarId, i64)]) -> Result<AnyStates> {
        on!(self, e => Ok(e.slice(fixed)?.into()))
    }

    fn contains(&self, x: &AnyStates, state: &[i64]) -> Result<bool> {
        on!(self, e => e.contains(x.of(e)?, state))
    }

    fn membership<'e>(&'e self, sets: &[&AnyStates]) -> Result<Box<dyn Membership + 'e>> {
        on!(self, e => e.membership(&sets.iter().map(|x| x.of(e)).collect::<Result<Vec<_>>>()?))
    }

    fn contains_choice(&self, c: &AnyChoices, state: &[i64], choice: &Choice) -> Result<bool> {
        on!(self, e => e.contains_choice(c.of(e)?, state, choice))
    }

    fn usage(&self) -> Usage {
        on!(self, e => e.usage())
    }

    fn settings(&self) -> &Settings {
        on!(self, e => e.settings())
    }
}
