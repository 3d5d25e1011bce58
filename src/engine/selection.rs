//! The choice between the two engines for a model.

use std::sync::Arc;

use super::any::AnyEngine;
use super::both::{Asked, Begun, First, explore};
use super::engine::{Algebra, Engine};
use super::explicit::{ExplicitEngine, Exploration, Guided};
use super::handover::HandOver;
use super::rest::Rest;
use super::settings::{Scope, Settings, Storage};
use super::symbolic::SymbolicEngine;
use meliora_base::error::{Limit, Result};
use meliora_model::Program;
use meliora_model::predicate::Predicate;

/// The engine for a model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Selection {
    /// The engine.
    pub storage: Storage,
    /// The reason, such as "3600 states found"; `None` if the user has named the engine.
    pub reason: Option<String>,
    /// True if the states may still select the explicit engine: nobody knows before which engine is faster.
    pub is_open: bool,
}

/// A question for an engine.
pub(crate) type Everywhere<'q, T> = &'q dyn Fn(&SymbolicEngine) -> Result<T>;

/// A question about the initial states that counts no states, with the ways to answer it before all states are known.
pub struct Initially<'q, T> {
    /// The question for engines of [`SymbolicEngine::everywhere`], unless the answer depends on how a state is reached.
    pub everywhere: Option<Everywhere<'q, T>>,
    /// The target, if the question is whether some strategy reaches it almost surely from all initial states.
    pub target: Option<&'q Predicate>,
}

/// The result of [`Selection::decide`].
pub enum Decision<T, E = AnyEngine> {
    /// The answer, found over all valuations before the states were known.
    Answered(T),
    /// The search that found the answer before the states were known.
    Guided(Box<Guided>),
    /// The engine, which has the question still to answer.
    Built(E),
}

/// The result of the way that was the first to end.
enum Taken {
    Built(AnyEngine),
    Answered,
    Guided(Box<Guided>),
}

impl Selection {
    /// Lets the states select the engine.
    pub fn open() -> Self {
        let reason = Some("the states are not known yet".to_owned());
        Selection { storage: Storage::Symbolic, reason, is_open: true }
    }

    /// Builds the engine for some questions and updates the selection. As long as it is open, the
    /// states decide: both engines explore them in turns (`both::explore`).
    ///
    /// - If the explicit engine is the first to know all states, it is selected. It has the first turn if a question
    ///   lists the states anyway, such as one for a number.
    /// - If it is the symbolic engine, the question is answered by diagrams of several orders in turns. The explicit
    ///   engine takes over once they have taken as many steps as it takes to list the states.
    ///
    /// # Errors
    /// The errors of [`AnyEngine::new`].
    pub fn build(
        &mut self,
        program: &Arc<Program>,
        settings: Settings,
        lists_states: bool,
    ) -> Result<AnyEngine> {
        if !self.is_open {
            return AnyEngine::new(Arc::clone(program), Settings { storage: self.storage, ..settings });
        }
        match self.taken(program, settings, lists_states, Asked::default())? {
            Taken::Built(engine) => Ok(engine),
            Taken::Answered | Taken::Guided(_) => Err(Limit::Interrupted.into()),
        }
    }

    /// Answers a question about the initial states over all valuations or by some of the states, or builds the engine
    /// for it, whichever ends first; updates the selection. The question is asked only as long as the selection is open
    /// and the states are not known.
    ///
    /// # Errors
    /// The errors of [`AnyEngine::new`], and those of the question other than input errors.
    pub fn decide<T>(
        &mut self,
        program: &Arc<Program>,
        settings: Settings,
        question: &Initially<'_, T>,
    ) -> Result<Decision<T>> {
        if !self.is_open || settings.scope != Scope::Reachable {
            return self.build(program, settings, false).map(Decision::Built);
        }
        let mut answer = None;
        let mut ask = |engine: &SymbolicEngine| {
            answer = question.everywhere.map(|question| question(engine)).transpose()?;
            Ok(())
        };
        let everywhere = question.everywhere.map(|_| &mut ask as _);
        let asked = Asked { everywhere, target: question.target };
        match self.taken(program, settings, false, asked)? {
            Taken::Built(engine) => return Ok(Decision::Built(engine)),
            Taken::Guided(guided) => {
                let how =
                    "the initial states judged by a guided search, before all their successors were found";
                self.take(Storage::Explicit, how);
                return Ok(Decision::Guided(guided));
            }
            Taken::Answered => {}
        }
        let how = "the initial states judged over all valuations, before their successors were found";
        self.take(Storage::Symbolic, how);
        answer.map(Decision::Answered).ok_or_else(|| Limit::Interrupted.into())
    }

    /// Builds the engine that is the first to know all states, unless a question was answered before.
    fn taken(
        &mut self,
        program: &Arc<Program>,
        settings: Settings,
        lists_states: bool,
        asked: Asked<'_, '_>,
    ) -> Result<Taken> {
        match explore(program, &settings, lists_states, asked)? {
            First::Explicit(all, is_alone) => {
                self.found_by(*all, is_alone, settings.memory).map(Taken::Built)
            }
            First::Symbolic(begun) => self.begun(*begun, settings).map(Taken::Built),
            First::Answered => Ok(Taken::Answered),
            First::Guided(guided) => Ok(Taken::Guided(guided)),
        }
    }

    /// Takes the explicit engine, which was the first to know all states.
    fn found_by(&mut self, mut all: Exploration, is_alone: bool, memory: u64) -> Result<AnyEngine> {
        all.set_memory(memory);
        let engine = ExplicitEngine::explored(all)?;
        let states = engine.count(&engine.all_states())?;
        let first = if is_alone { "" } else { ", before diagrams found them" };
        self.take(Storage::Explicit, format!("{states} states found{first}"));
        Ok(engine.into())
    }

    /// Takes the symbolic engine, which was the first to know all states, in turns with other orders, until the explicit
    /// engine takes over; it never does if the memory does not suffice.
    fn begun(&mut self, begun: Begun, settings: Settings) -> Result<AnyEngine> {
        let Begun { explored, budget, rest, pace } = begun;
        let count = explored.count()?;
        let states = u64::try_from(&count).unwrap_or(u64::MAX);
        let symbolic = explored.engine()?;
        self.take(Storage::Symbolic, "diagrams found all states first");
        let steps = pace.work(states).saturating_mul(settings.thresholds.steps_per_work);
        let rest = Rest {
            exploration: rest,
            settings: settings.clone(),
            states: usize::try_from(states).unwrap_or(0),
        };
        let rest = (pace.bytes(states) <= settings.memory).then_some((rest, steps));
        Ok(HandOver::new(symbolic, settings, budget, rest).into())
    }

    /// Selects an engine.
    fn take(&mut self, storage: Storage, reason: impl Into<String>) {
        *self = Selection { storage, reason: Some(reason.into()), is_open: false };
    }
}
