//! One type for either engine, for callers that choose the engine at run time.

use std::sync::Arc;

use super::edge_labels::EdgeLabels;
use super::engine::{Algebra, Engine, Region, Won};
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
pub enum AnyEngine {
    /// The symbolic engine.
    Symbolic(Arc<SymbolicEngine>),
    /// The explicit engine.
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
    type Set: Clone;
    /// # Errors
    /// The set belongs to the other kind of engine.
    fn of(&self, engine: &E) -> Result<&Self::Set>;
}

macro_rules! sets_of {
    ($any:ident, $set:ident) => {
        impl Of<SymbolicEngine> for $any {
            type Set = symbolic::$set;
            fn of(&self, _: &SymbolicEngine) -> Result<&symbolic::$set> {
                if let $any::Symbolic(set) = self { Ok(set) } else { Err(Error::ForeignSet) }
            }
        }

        impl Of<ExplicitEngine> for $any {
            type Set = explicit::$set;
            fn of(&self, _: &ExplicitEngine) -> Result<&explicit::$set> {
                if let $any::Explicit(set) = self { Ok(set) } else { Err(Error::ForeignSet) }
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

sets_of!(AnyStates, StateSet);
sets_of!(AnyChoices, ChoiceSet);

/// Evaluates the same expression with the engine of either kind.
macro_rules! on {
    ($any:expr, $engine:ident => $work:expr) => {
        match $any {
            AnyEngine::Symbolic($engine) => {
                let $engine: &SymbolicEngine = $engine;
                $work
            }
            AnyEngine::Explicit($engine) => {
                let $engine: &ExplicitEngine = $engine;
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
        match self {
            AnyEngine::Symbolic(_) => Storage::Symbolic,
            AnyEngine::Explicit(_) => Storage::Explicit,
        }
    }

    /// Returns the symbolic engine, or `None` if the engine is explicit.
    pub fn symbolic(&self) -> Option<&Arc<SymbolicEngine>> {
        if let AnyEngine::Symbolic(engine) = self { Some(engine) } else { None }
    }

    /// Returns the explicit engine, or `None` if the engine is symbolic.
    pub fn explicit(&self) -> Option<&Arc<ExplicitEngine>> {
        if let AnyEngine::Explicit(engine) = self { Some(engine) } else { None }
    }

    /// Returns the program.
    pub fn program(&self) -> &Arc<Program> {
        on!(self, e => e.program())
    }

    /// Returns whether both share the explored states, so that each accepts the sets of the other.
    pub fn shares(&self, other: &AnyEngine) -> bool {
        match (self, other) {
            (AnyEngine::Symbolic(a), AnyEngine::Symbolic(b)) => a.shares(b),
            (AnyEngine::Explicit(a), AnyEngine::Explicit(b)) => a.shares(b),
            _ => false,
        }
    }
}

impl From<SymbolicEngine> for AnyEngine {
    fn from(engine: SymbolicEngine) -> Self {
        AnyEngine::Symbolic(Arc::new(engine))
    }
}

impl From<ExplicitEngine> for AnyEngine {
    fn from(engine: ExplicitEngine) -> Self {
        AnyEngine::Explicit(Arc::new(engine))
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
        can_enter(c: AnyChoices, x: AnyStates) -> AnyStates;
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
        on!(self, e => Ok(e.with_coalition(coalition)?.into()))
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
        on!(self, e => Ok(e.restricted_to(&region_of(e, to)?)?.into()))
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
    ) -> Result<Won<AnyStates, AnyChoices>> {
        on!(self, e => {
            let won = e.almost_surely_win(region_of(e, &start)?, &edge_labels_of(e, edge_labels)?)?;
            Ok(Won { region: region(won.region), possible: won.possible.map(Into::into) })
        })
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
        on!(self, e => {
            let own = sets.iter().map(|x| x.of(e)).collect::<Result<Vec<_>>>()?;
            e.membership(&own)
        })
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
