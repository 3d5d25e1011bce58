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

/// The most valuations of a model for which the explicit engine is selected.
///
/// Measured: of 198 models of the PRISM benchmark suite and PRISM's tests, the explicit engine
/// answers all that have at most 4,096 valuations faster; the first for which it is slower has
/// 8,192. On grid worlds of the generator it is faster up to about 50,000.
const MOST_VALUATIONS: u64 = 1 << 12;

/// The most states for which the explicit engine is taken whatever the diagrams are, where a question
/// lists the states anyway.
///
/// Measured on properties of the Quantitative Verification Benchmark Set that ask for a number: up to
/// about this many, the explicit engine answers faster, up to 190 times.
const MOST_LISTED: u64 = 400_000;

/// The engine for a model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Selection {
    /// The engine.
    pub storage: Storage,
    /// The reason, such as "at most 3600 states"; `None` if the user has named the engine.
    pub reason: Option<String>,
    /// True if the states may still select the explicit engine: the text does not show which engine
    /// is faster.
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
    /// Selects the explicit engine for programs that are so small that it is known to be faster,
    /// else the symbolic engine; the largest of the programs decides.
    ///
    /// The bound is read off the text: ∏ |range of x| valuations over the variables x. No state is explored.
    pub fn of<'a>(programs: impl IntoIterator<Item = &'a Program>) -> Self {
        let most = programs.into_iter().map(valuations).try_fold(1, |most, n| Some(n?.max(most)));
        let (storage, reason) = match most.filter(|&n| n <= MOST_VALUATIONS) {
            Some(n) => (Storage::Explicit, format!("at most {n} states")),
            None => (Storage::Symbolic, format!("over {MOST_VALUATIONS} states possible")),
        };
        Selection { storage, reason: Some(reason), is_open: storage == Storage::Symbolic }
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
                self.take(
                    "the initial states judged by a guided search, before all their successors were found"
                        .into(),
                );
                return Ok(Decision::Guided(guided));
            }
            Taken::Answered => {}
        }
        self.is_open = false;
        self.reason =
            Some("the initial states judged over all valuations, before their successors were found".into());
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
            First::Symbolic(begun) => self.begun(*begun, lists_states, settings).map(Taken::Built),
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
        self.take(format!("{states} states found{first}"));
        Ok(engine.into())
    }

    /// Takes the symbolic engine, which was the first to know all states, in turns with other orders, until the explicit
    /// engine takes over: at once if a question lists the states anyway and they are few, and never if the memory does
    /// not suffice.
    fn begun(&mut self, begun: Begun, lists_states: bool, settings: Settings) -> Result<AnyEngine> {
        let Begun { explored, budget, rest, pace } = begun;
        let count = explored.count()?;
        let states = u64::try_from(&count).unwrap_or(u64::MAX);
        let symbolic = explored.engine()?;
        let memory = settings.memory;
        let steps = pace.work(states).saturating_mul(settings.thresholds.steps_per_work);
        let rest = Rest {
            exploration: rest,
            settings: settings.clone(),
            states: usize::try_from(states).unwrap_or(0),
        };
        if lists_states && states <= MOST_LISTED {
            let used = symbolic.usage().bytes;
            let Some(mut engine) = rest.explore(&symbolic, used)? else { return Ok(symbolic.into()) };
            engine.set_memory(memory);
            self.take(format!("{count} states found"));
            return Ok(engine.into());
        }
        let rest = (pace.bytes(states) <= memory).then_some((rest, steps));
        Ok(HandOver::new(symbolic, settings, budget, rest).into())
    }

    /// Selects the explicit engine.
    fn take(&mut self, reason: String) {
        *self = Selection { storage: Storage::Explicit, reason: Some(reason), is_open: false };
    }
}

/// Returns ∏ |range of x| over the variables x, or `None` if it passes 2^64.
fn valuations(program: &Program) -> Option<u64> {
    let size = |low: i64, high: i64| (high.wrapping_sub(low) as u64).checked_add(1);
    program.variables.iter().try_fold(1_u64, |n, v| n.checked_mul(size(v.low, v.high)?))
}
