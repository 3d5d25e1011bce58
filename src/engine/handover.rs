//! A question that several engines answer in turns, after diagrams have found the states.
//!
//! The order of the bits by which the states were found need not be the best one for the question. So that order and the
//! others that an exploration tries take turns, counted in steps. The first order has the first turn alone; an operation
//! that does not end in it is begun by the others, too, each in a thread of its own, of which one runs at a time. The
//! first to end continues the question. Sets of other orders are translated where they are used.
//!
//! The work of a question is not known before it is answered, but that of the explicit engine is: its fixpoints are
//! linear in the states and their successors, whose number diagrams know. So each order has at most as many steps as
//! the explicit engine needs to list the states. After these, it lists them and answers the rest of the question.

use std::sync::{Arc, OnceLock};

use super::any::{AnyChoices, AnyEngine, AnyStates, Of, region_of};
use super::budget::Budget;
use super::engine::{Engine, Region};
use super::explicit::ExplicitEngine;
use super::order_turns::{Next, Shared, Turns};
use super::rest::Rest;
use super::settings::{Settings, Usage};
use super::symbolic::SymbolicEngine;
use meliora_base::error::{Error, Result};

/// Engines for the same states: one of diagrams for each order, and the explicit one once it has taken over.
#[derive(Clone)]
pub(super) struct HandOver {
    origin: Origin,
    /// The engine whose turn it was when this value was made.
    first: One,
    /// The engines of diagrams that were needed, by their order.
    diagrams: Vec<OnceLock<Arc<SymbolicEngine>>>,
    explicit: OnceLock<Arc<ExplicitEngine>>,
    pub(super) shared: Arc<Shared>,
}

/// The operation that made the engines.
#[derive(Clone)]
enum Origin {
    Model,
    Coalition(Box<AnyEngine>, Vec<bool>),
    Region(Box<AnyEngine>, Region<AnyStates, AnyChoices>),
}

#[derive(Clone)]
enum One {
    Symbolic(Arc<SymbolicEngine>),
    Explicit(Arc<ExplicitEngine>),
}

/// An engine of either kind.
#[derive(Clone, Copy)]
pub(super) enum Current<'e> {
    Symbolic(&'e Arc<SymbolicEngine>),
    Explicit(&'e Arc<ExplicitEngine>),
}

impl HandOver {
    /// Begins a question with the engine that has found the states; see [`Shared::new`].
    pub(super) fn new(
        first: SymbolicEngine,
        settings: Settings,
        budget: Arc<Budget>,
        rest: Option<(Rest, u64)>,
    ) -> Self {
        let first = Arc::new(first);
        let shared = Shared::new(Arc::clone(&first), settings, budget, rest);
        HandOver::of(Origin::Model, One::Symbolic(first), Arc::new(shared))
    }

    fn of(origin: Origin, first: One, shared: Arc<Shared>) -> Self {
        let diagrams = vec![OnceLock::new(); shared.orders()];
        HandOver { origin, first, diagrams, explicit: OnceLock::new(), shared }
    }

    /// Returns engines with other players.
    pub(super) fn with_coalition(&self, engine: &AnyEngine, coalition: &[bool]) -> Result<Self> {
        self.child(Origin::Coalition(Box::new(engine.clone()), coalition.to_vec()))
    }

    /// Returns engines for a part of the model.
    pub(super) fn restricted_to(
        &self,
        engine: &AnyEngine,
        to: &Region<AnyStates, AnyChoices>,
    ) -> Result<Self> {
        self.child(Origin::Region(Box::new(engine.clone()), to.clone()))
    }

    fn child(&self, origin: Origin) -> Result<Self> {
        let mut child = HandOver::of(origin, self.first.clone(), Arc::clone(&self.shared));
        child.first = child.answer(&|engine: Current<'_>| Ok(engine.cloned()))?;
        Ok(child)
    }

    /// Returns whether both are engines for one model.
    pub(super) fn shares(&self, other: &HandOver) -> bool {
        Arc::ptr_eq(&self.shared, &other.shared)
    }

    /// Returns the engine whose turn it is.
    ///
    /// # Errors
    /// A limit, such as the steps of the turn.
    pub(super) fn current(&self) -> Result<Current<'_>> {
        match self.shared.explicit.get() {
            Some(_) => self.explicit().map(Current::Explicit),
            None => self.diagrams(self.shared.at()).map(Current::Symbolic),
        }
    }

    /// Returns the engine whose turn it is, or the first one if that cannot be made in this turn.
    pub(super) fn known(&self) -> Current<'_> {
        self.current().unwrap_or(match &self.first {
            One::Symbolic(engine) => Current::Symbolic(engine),
            One::Explicit(engine) => Current::Explicit(engine),
        })
    }

    fn explicit(&self) -> Result<&Arc<ExplicitEngine>> {
        let whole = || self.shared.explicit.get().ok_or(Error::ForeignSet);
        self.made(&self.explicit, &whole, &|parent| parent.explicit())
    }

    fn diagrams(&self, order: usize) -> Result<&Arc<SymbolicEngine>> {
        let whole = || self.shared.whole(order);
        self.made(&self.diagrams[order], &whole, &|parent| parent.diagrams(order))
    }

    /// Makes an engine by the operation that made this value, once, from that of the whole model or of the parent.
    fn made<'h, E: Engine>(
        &'h self,
        own: &'h OnceLock<Arc<E>>,
        whole: &dyn Fn() -> Result<&'h Arc<E>>,
        of: &dyn Fn(&'h HandOver) -> Result<&'h Arc<E>>,
    ) -> Result<&'h Arc<E>>
    where
        AnyStates: Of<E, Set = E::States>,
        AnyChoices: Of<E, Set = E::Choices>,
    {
        if let Some(own) = own.get() {
            return Ok(own);
        }
        let of = |parent: &'h AnyEngine| of(parent.in_turns().ok_or(Error::ForeignSet)?);
        let made = match &self.origin {
            Origin::Model => Arc::clone(whole()?),
            Origin::Coalition(parent, coalition) => Arc::new(of(parent)?.with_coalition(coalition)?),
            Origin::Region(parent, region) => {
                let of = of(parent)?;
                Arc::new(of.restricted_to(&region_of(parent, &**of, region)?)?)
            }
        };
        Ok(own.get_or_init(|| made))
    }

    /// Runs an operation by the engine whose turn it is. If that has no steps or no memory left, all orders take turns
    /// with the operation, each in a thread of its own, until the first of them has the result.
    ///
    /// # Errors
    /// The error of the operation; a limit of the whole work, or of the last engine.
    pub(super) fn answer<T: Send>(
        &self,
        operation: &(impl Fn(Current<'_>) -> Result<T> + Sync),
    ) -> Result<T> {
        loop {
            let result = self.current().and_then(operation);
            let mut turns = self.shared.turns();
            match self.shared.after(&mut turns, &result)? {
                Next::Nobody => return result,
                Next::Alone => {}
                Next::Turns => {
                    if let Some(found) = self.in_turns(&mut turns, operation)? {
                        return Ok(found);
                    }
                }
            }
        }
    }

    /// Runs an operation by all orders in turns. Returns the result of the first one to end; `None` if the explicit engine
    /// has to take over before.
    fn in_turns<T: Send>(
        &self,
        turns: &mut Turns,
        operation: &(impl Fn(Current<'_>) -> Result<T> + Sync),
    ) -> Result<Option<T>> {
        let shared = &*self.shared;
        shared.translated.forget_copies();
        shared.budgets().for_each(Budget::begin_turns);
        std::thread::scope(|scope| {
            let found = shared.first_to_end(turns, |order| {
                let work = move || {
                    let _done = shared.budget(order).done();
                    self.diagrams(order).and_then(|engine| operation(Current::Symbolic(engine)))
                };
                std::thread::Builder::new().spawn_scoped(scope, work)
            });
            // Those that wait end.
            shared.budgets().for_each(Budget::end_turns);
            found
        })
    }

    /// Runs an operation of diagrams that cannot be repeated, without a limit of its steps.
    pub(super) fn at_once<T>(&self, operation: impl FnOnce() -> Result<T>) -> Result<T> {
        let budget = self.shared.budget(self.shared.at());
        let left = budget.left();
        budget.lift();
        let result = operation();
        budget.allow(left);
        result
    }

    /// Returns the settings, with the sink of the whole work.
    pub(super) fn settings(&self) -> &Settings {
        self.shared.settings()
    }

    /// Returns the resources that all engines have used so far.
    pub(super) fn usage(&self) -> Usage {
        self.shared.usage()
    }
}

impl Current<'_> {
    fn cloned(self) -> One {
        match self {
            Current::Symbolic(engine) => One::Symbolic(Arc::clone(engine)),
            Current::Explicit(engine) => One::Explicit(Arc::clone(engine)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regions::regions;
    use crate::settings::{Count, Storage};
    use meliora_base::error::SourceFile;
    use meliora_base::progress::NoProgress;

    #[test]
    fn diagrams_end_a_question_if_the_memory_does_not_suffice_for_the_explicit_engine() {
        let text =
            "mdp module m x : [0..9999]; [] true -> 0.5: (x'=mod(21*x+1, 10000)) + 0.5: true; endmodule";
        let none = SourceFile::new("none", "");
        let program = meliora_lang::load(&SourceFile::new("m", text), &none).unwrap().program;
        for (memory, takes_over) in [(1 << 20, false), (1 << 30, true)] {
            let sink: Arc<dyn meliora_base::progress::ProgressSink> = Arc::new(NoProgress);
            let budget = Arc::new(Budget::new(u64::MAX, &sink));
            let settings = Settings { sink: Arc::clone(&budget) as _, ..Settings::default() };
            let symbolic = SymbolicEngine::new(Arc::new(program.clone()), settings).unwrap();
            let settings = Settings { memory, ..Settings::default() };
            let rest = Rest { exploration: None, settings: settings.clone(), states: 10_000 };
            let engine = AnyEngine::from(HandOver::new(symbolic, settings, budget, Some((rest, 0))));
            let found = regions(&engine, &engine.singleton(&[3]).unwrap()).unwrap();
            let count = |x| crate::engine::Algebra::<AnyStates>::count(&engine, x).unwrap();
            assert_eq!(count(&found.pmin_one), Count::from(count(&engine.all_states())));
            assert_eq!(engine.usage().taken_over_after, takes_over.then_some(0));
            assert_eq!(engine.storage() == Storage::Explicit, takes_over);
        }
    }
}
