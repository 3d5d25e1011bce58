//! A question that diagrams begin to answer, and that the explicit engine takes over.
//!
//! The work of a question is not known before it is answered, but that of the explicit engine is: its fixpoints are
//! linear in the states and their successors, whose number diagrams know. So diagrams have as many steps as the explicit
//! engine needs to list the states. After these, it lists them and answers the rest of the question; sets of diagrams are
//! translated where they are used.

use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use ahash::AHashMap;

use super::any::{self, AnyChoices, AnyEngine, AnyStates};
use super::budget::Budget;
use super::engine::{Engine, Region};
use super::explicit::{self, ExplicitEngine, Exploration, Groups, PartOfGroups};
use super::membership;
use super::settings::{Settings, Storage, Usage};
use super::symbolic::{self, OfGroup, SymbolicEngine};
use meliora_base::error::{Error, Limit, Result};

/// An engine of diagrams whose question the explicit engine may take over.
#[derive(Clone)]
pub(super) struct HandOver {
    symbolic: Arc<SymbolicEngine>,
    origin: Origin,
    /// The explicit engine of the same origin, once it has taken over.
    own: OnceLock<Arc<ExplicitEngine>>,
    shared: Arc<Shared>,
}

/// The operation that made an engine.
#[derive(Clone)]
enum Origin {
    Model,
    Coalition(Box<AnyEngine>, Vec<bool>),
    Region(Box<AnyEngine>, Region<AnyStates, AnyChoices>),
}

/// The parts that all engines for a model share.
struct Shared {
    settings: Settings,
    budget: Arc<Budget>,
    /// All states.
    all: symbolic::StateSet,
    /// The steps of the question after which the explicit engine takes over.
    steps: u64,
    /// The states that the explicit engine has explored; `None` once it has tried to take over.
    rest: Mutex<Option<Rest>>,
    /// The explicit engine of the whole model, once it has taken over.
    explicit: OnceLock<Arc<ExplicitEngine>>,
    /// The number of each choice among the groups of the symbolic engine.
    groups: OnceLock<Groups>,
    /// The sets translated so far: diagrams are made no more, so these are at most those in use at the time.
    translated: Mutex<Translated>,
}

/// Sets of the explicit engine by those of the symbolic one.
#[derive(Default)]
struct Translated {
    states: AHashMap<symbolic::StateSet, explicit::StateSet>,
    choices: AHashMap<symbolic::ChoiceSet, explicit::ChoiceSet>,
}

/// The exploration by the explicit engine.
pub(super) struct Rest {
    /// The states explored so far, if there are any.
    pub(super) exploration: Option<Box<Exploration>>,
    /// The settings of the engine.
    pub(super) settings: Settings,
    /// The number of states.
    pub(super) states: usize,
}

impl HandOver {
    /// Gives an engine some steps for a question. The budget is the sink of its settings.
    pub(super) fn new(symbolic: SymbolicEngine, budget: Arc<Budget>, steps: u64, rest: Rest) -> Self {
        budget.allow(steps);
        let (settings, explicit, groups) = (rest.settings.clone(), OnceLock::new(), OnceLock::new());
        let (rest, translated) = (Mutex::new(Some(rest)), Mutex::default());
        let shared = Arc::new(Shared {
            settings,
            budget,
            all: symbolic.all_states(),
            steps,
            rest,
            explicit,
            groups,
            translated,
        });
        HandOver { symbolic: Arc::new(symbolic), origin: Origin::Model, own: OnceLock::new(), shared }
    }

    pub(super) fn symbolic(&self) -> &Arc<SymbolicEngine> {
        &self.symbolic
    }

    /// Returns the explicit engine, if it has taken over.
    ///
    /// # Errors
    /// A limit.
    pub(super) fn explicit(&self) -> Result<Option<&Arc<ExplicitEngine>>> {
        let Some(whole) = self.shared.explicit.get() else { return Ok(None) };
        if let Some(own) = self.own.get() {
            return Ok(Some(own));
        }
        let of = |parent: &AnyEngine| parent.explicit().cloned().ok_or(Error::ForeignSet);
        let own = match &self.origin {
            Origin::Model => Arc::clone(whole),
            Origin::Coalition(parent, coalition) => Arc::new(of(parent)?.with_coalition(coalition)?),
            Origin::Region(parent, region) => {
                let own = of(parent)?;
                Arc::new(own.restricted_to(&any::region_of(parent, &*own, region)?)?)
            }
        };
        Ok(Some(self.own.get_or_init(|| own)))
    }

    /// Returns whether an operation ended since no steps were left.
    pub(super) fn has_ended<T>(&self, result: &Result<T>) -> bool {
        matches!(result, Err(Error::Limit(Limit::Interrupted))) && self.shared.budget.has_ended()
    }

    /// Lets the explicit engine take over, if the memory suffices for both.
    ///
    /// # Errors
    /// A limit of the whole work.
    pub(super) fn take_over(&self) -> Result<()> {
        let mut rest = self.shared.rest.lock().unwrap_or_else(PoisonError::into_inner);
        self.shared.budget.lift();
        let Some(rest) = rest.take() else { return Ok(()) };
        if let Some(engine) = rest.explore(&self.symbolic)? {
            drop(self.shared.explicit.set(Arc::new(engine)));
        }
        Ok(())
    }

    /// Runs an operation of diagrams that cannot be repeated, without a limit of its steps.
    pub(super) fn at_once<T>(&self, operation: impl FnOnce(&SymbolicEngine) -> Result<T>) -> Result<T> {
        let budget = &self.shared.budget;
        let left = budget.left();
        budget.lift();
        let result = operation(&self.symbolic);
        budget.allow(left);
        result
    }

    /// Returns an engine with other players.
    pub(super) fn with_coalition(&self, engine: &AnyEngine, coalition: &[bool]) -> Result<Self> {
        let make = |symbolic: &SymbolicEngine| symbolic.with_coalition(coalition);
        self.child(make, Origin::Coalition(Box::new(engine.clone()), coalition.to_vec()))
    }

    /// Returns an engine for a part of the model.
    pub(super) fn restricted_to(
        &self,
        engine: &AnyEngine,
        to: &Region<AnyStates, AnyChoices>,
    ) -> Result<Self> {
        let make = |symbolic: &SymbolicEngine| symbolic.restricted_to(&any::region_of(engine, symbolic, to)?);
        self.child(make, Origin::Region(Box::new(engine.clone()), to.clone()))
    }

    /// Returns an engine that an operation makes. Once the explicit engine has taken over, that of diagrams only
    /// translates sets, and remains as it is.
    fn child(
        &self,
        make: impl FnOnce(&SymbolicEngine) -> Result<SymbolicEngine>,
        origin: Origin,
    ) -> Result<Self> {
        let symbolic = match self.shared.explicit.get() {
            Some(_) => Arc::clone(&self.symbolic),
            None => Arc::new(self.at_once(make)?),
        };
        let child = HandOver { symbolic, origin, own: OnceLock::new(), shared: Arc::clone(&self.shared) };
        child.explicit()?;
        Ok(child)
    }

    /// Returns whether both are engines for one model.
    pub(super) fn shares(&self, other: &HandOver) -> bool {
        Arc::ptr_eq(&self.shared, &other.shared)
    }

    /// Returns a set of states as one of the explicit engine.
    ///
    /// # Errors
    /// A limit; the set belongs to another engine.
    pub(super) fn explicit_states(&self, x: &symbolic::StateSet) -> Result<explicit::StateSet> {
        if let Some(known) = self.translated().states.get(x) {
            return Ok(known.clone());
        }
        let whole = self.whole()?;
        let found = match *x == self.shared.all {
            true => whole.all_states(),
            false => whole.adopt_states(&*self.symbolic.membership(&[x])?)?,
        };
        self.translated().states.insert(x.clone(), found.clone());
        Ok(found)
    }

    fn translated(&self) -> MutexGuard<'_, Translated> {
        self.shared.translated.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns a set of choices as one of the explicit engine.
    ///
    /// # Errors
    /// A limit; the set belongs to another engine.
    pub(super) fn explicit_choices(&self, c: &symbolic::ChoiceSet) -> Result<explicit::ChoiceSet> {
        if let Some(known) = self.translated().choices.get(c) {
            return Ok(known.clone());
        }
        let parts = self.symbolic.by_group(c)?;
        let found = match parts.iter().any(|part| matches!(part, OfGroup::Part(_) | OfGroup::Nothing)) {
            true => self.chosen_in(&parts)?,
            false => self.whole()?.all_choices(),
        };
        self.translated().choices.insert(c.clone(), found.clone());
        Ok(found)
    }

    /// Returns the pairs of some parts of all groups.
    fn chosen_in(&self, parts: &[OfGroup]) -> Result<explicit::ChoiceSet> {
        let whole: Vec<bool> = parts.iter().map(|part| matches!(part, OfGroup::All)).collect();
        let some = parts.iter().enumerate().filter_map(|(group, part)| match part {
            OfGroup::Part(states) => Some((group, states)),
            OfGroup::All | OfGroup::Nothing => None,
        });
        let (groups, states): (Vec<usize>, Vec<&symbolic::StateSet>) = some.unzip();
        let chunks = groups.chunks(membership::MOST).zip(states.chunks(membership::MOST));
        let part = |(groups, states): (&[usize], &[&symbolic::StateSet])| {
            Ok(PartOfGroups { groups: groups.to_vec(), test: self.symbolic.membership(states)? })
        };
        let parts = chunks.map(part).collect::<Result<Vec<_>>>()?;
        self.whole()?.adopt_choices(self.groups()?, &whole, &parts)
    }

    fn groups(&self) -> Result<&Groups> {
        if let Some(groups) = self.shared.groups.get() {
            return Ok(groups);
        }
        let groups = self.whole()?.group(&mut |choice| self.symbolic.group_of(choice).unwrap_or(0) as u32)?;
        Ok(self.shared.groups.get_or_init(|| groups))
    }

    fn whole(&self) -> Result<&ExplicitEngine> {
        Ok(self.shared.explicit.get().ok_or(Error::ForeignSet)?)
    }

    /// Returns the settings, with the sink of the whole work.
    pub(super) fn settings(&self) -> &Settings {
        &self.shared.settings
    }

    /// Returns the resources that both engines have used so far.
    pub(super) fn usage(&self) -> Usage {
        let mut usage = self.symbolic.usage();
        if let Some(explicit) = self.shared.explicit.get() {
            usage.bytes += explicit.usage().bytes;
            usage.taken_over_after = Some(self.shared.steps);
        }
        usage
    }
}

impl Rest {
    /// Explores the rest of the states that diagrams know; `None` if they do not fit the memory left.
    ///
    /// # Errors
    /// A limit of the whole work.
    pub(super) fn explore(self, symbolic: &SymbolicEngine) -> Result<Option<ExplicitEngine>> {
        match self.engine(symbolic) {
            Err(Error::Limit(Limit::Memory { .. } | Limit::Size { .. } | Limit::States(_))) => Ok(None),
            engine => engine.map(Some),
        }
    }

    fn engine(self, symbolic: &SymbolicEngine) -> Result<ExplicitEngine> {
        let memory = self.settings.memory.saturating_sub(symbolic.usage().bytes);
        let mut exploration = match self.exploration {
            Some(mut exploration) => {
                exploration.set_memory(memory);
                *exploration
            }
            None => {
                let settings = Settings { memory, storage: Storage::Explicit, ..self.settings };
                Exploration::new(Arc::clone(symbolic.program()), settings)?
            }
        };
        if !exploration.has_begun() {
            // Diagrams know the states in which paths begin. The search for them may take much longer.
            let start = symbolic.beginnings()?.unwrap_or_else(|| symbolic.all_states());
            exploration.begin_with(&symbolic.list_states(&start, usize::MAX)?)?;
        }
        exploration.expect(self.states);
        ExplicitEngine::explored(exploration)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regions::regions;
    use crate::settings::Count;
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
            let rest = Rest { exploration: None, settings, states: 10_000 };
            let engine = AnyEngine::from(HandOver::new(symbolic, budget, 0, rest));
            let found = regions(&engine, &engine.singleton(&[3]).unwrap()).unwrap();
            let count = |x| crate::engine::Algebra::<AnyStates>::count(&engine, x).unwrap();
            assert_eq!(count(&found.pmin_one), Count::from(count(&engine.all_states())));
            assert_eq!(engine.usage().taken_over_after, takes_over.then_some(0));
            assert_eq!(engine.storage() == Storage::Explicit, takes_over);
        }
    }
}
