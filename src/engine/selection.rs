//! The ways to an answer, and the choice of the engine by the first of them to end.

use std::sync::Arc;

use super::any::AnyEngine;
use super::engine::{Algebra, Engine};
use super::explicit::{ExplicitEngine, Guided};
use super::race::{Lane, Place, Rules, Share, race};
use super::settings::{Scope, Settings, Storage};
use super::symbolic::{Order, Ordered, SymbolicEngine, candidates, large_first};
use meliora_base::error::{Error, Result};
use meliora_base::progress::ProgressSink;
use meliora_model::Program;
use meliora_model::predicate::Predicate;
use meliora_space::STEPS_PER_WORK;

/// The engine for a model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Selection {
    /// The engine.
    pub storage: Storage,
    /// The reason, such as "3600 states found"; `None` if the user has named the engine.
    pub reason: Option<String>,
    /// True if several ways race: nobody knows before which engine is faster.
    pub is_open: bool,
}

/// A way that has the question to answer.
#[derive(Debug, Clone)]
pub struct Racer {
    /// The number of the way, from 0 on.
    pub way: usize,
    /// True for the first way that knows all states. Its partial results are those to show at a limit.
    pub leads: bool,
    /// Its engine, and the reason to take it.
    pub selection: Selection,
}

/// Answers a question by an engine of all valuations.
pub type OverAll<'q, T> = &'q (dyn Fn(&SymbolicEngine) -> Result<T> + Sync);
/// Answers a question by a finished search.
pub type BySearch<'q, T> = &'q (dyn Fn(Guided) -> Result<T> + Sync);

/// A question, with the ways to answer it. Several threads may ask it at the same time.
pub struct RacedQuestion<'q, T> {
    /// Answers it by an engine that knows all states.
    pub by_states: &'q (dyn Fn(&Racer, AnyEngine) -> Result<T> + Sync),
    /// Answers a question about the initial states by an engine of [`SymbolicEngine::everywhere`]; `None` if the answer
    /// depends on how a state is reached.
    pub everywhere: Option<OverAll<'q, T>>,
    /// Answers by a finished search for a strategy that reaches the target almost surely from all initial states; `None`
    /// if this is not the question.
    pub guided: Option<(&'q Predicate, BySearch<'q, T>)>,
    /// True if the answer lists the states anyway, such as one with a number.
    pub lists_states: bool,
    /// Returns the sink of a way. All of them end with the one of the settings.
    pub sinks: Option<&'q (dyn Fn(usize) -> Arc<dyn ProgressSink> + Sync)>,
}

/// A way to an answer: it explores, and answers with the engine that it has found.
enum Way {
    Explicit,
    /// Diagrams with the bits in an order.
    Symbolic(Ordered),
    /// Diagrams over all valuations, with the bits in an order.
    Everywhere(Ordered),
    Guided,
}

impl Selection {
    /// Lets several ways race.
    pub fn open() -> Self {
        let reason = Some("the states are not known yet".to_owned());
        Selection { storage: Storage::Symbolic, reason, is_open: true }
    }

    /// Builds the engine, and updates the selection. As long as it is open, the engine is the first to know all states.
    ///
    /// # Errors
    /// The errors of [`AnyEngine::new`].
    pub fn build(&mut self, program: &Arc<Program>, settings: Settings) -> Result<AnyEngine> {
        let memory = settings.memory;
        let engine = self.answer(program, settings, &RacedQuestion::new(&|_, engine| Ok(engine)))?;
        match engine {
            AnyEngine::Explicit(engine) => {
                // The others have ended.
                let mut engine = Arc::unwrap_or_clone(engine);
                engine.set_memory(memory);
                Ok(engine.into())
            }
            engine => Ok(engine),
        }
    }

    /// Answers a question, and updates the selection. As long as it is open, several ways race, and the first to end has
    /// the answer. The answer does not depend on the way.
    ///
    /// # Errors
    /// The errors of [`AnyEngine::new`], and those of the question.
    pub fn answer<T: Send>(
        &mut self,
        program: &Arc<Program>,
        settings: Settings,
        question: &RacedQuestion<'_, T>,
    ) -> Result<T> {
        if !self.is_open {
            let racer = Racer { way: 0, leads: true, selection: self.clone() };
            let sink = question.sinks.map(|sinks| sinks(0));
            let settings =
                Settings { sink: sink.unwrap_or(settings.sink), storage: self.storage, ..settings };
            return (question.by_states)(&racer, AnyEngine::new(Arc::clone(program), settings)?);
        }
        let ways = question.ways(program, settings.scope);
        let (selection, found) = raced(program, &settings, question, &ways)?;
        *self = selection;
        Ok(found)
    }
}

impl SymbolicEngine {
    /// Creates an engine as [`SymbolicEngine::new`] does. Without an order, several orders race, and the first that knows
    /// all states is taken.
    ///
    /// # Errors
    /// The errors of [`SymbolicEngine::new`].
    pub fn in_some_order(program: Arc<Program>, settings: Settings) -> Result<Self> {
        if settings.order != Order::Auto {
            return SymbolicEngine::new(program, settings);
        }
        let ways = Vec::from_iter(candidates(&program).into_iter().map(Way::Symbolic));
        let taken = |_: &Racer, engine: AnyEngine| {
            engine.symbolic().map(|engine| SymbolicEngine::clone(engine)).ok_or(Error::ForeignSet)
        };
        raced(&program, &settings, &RacedQuestion::new(&taken), &ways).map(|(_, engine)| engine)
    }
}

impl<'q, T> RacedQuestion<'q, T> {
    /// Creates a question for engines that know all states.
    pub fn new(by_states: &'q (dyn Fn(&Racer, AnyEngine) -> Result<T> + Sync)) -> Self {
        RacedQuestion { by_states, everywhere: None, guided: None, lists_states: false, sinks: None }
    }

    /// Returns the ways, those that are likelier to be the first to end before others.
    fn ways(&self, program: &Program, scope: Scope) -> Vec<Way> {
        let is_early = scope == Scope::Reachable;
        let mut symbolic = candidates(program).into_iter().map(Way::Symbolic);
        let mut ways = vec![Way::Explicit];
        // Planning problems have too many states in most cases, and the search is short where it ends.
        ways.extend(self.guided.filter(|_| is_early).map(|_| Way::Guided));
        ways.extend(symbolic.next());
        ways.extend(self.everywhere.filter(|_| is_early).map(|_| Way::Everywhere(large_first(program))));
        ways.extend(symbolic);
        ways
    }
}

/// Lets some ways race. Returns the answer with the engine of the way.
fn raced<T: Send>(
    program: &Arc<Program>,
    settings: &Settings,
    question: &RacedQuestion<'_, T>,
    ways: &[Way],
) -> Result<(Selection, T)> {
    let turn = settings.thresholds.first_turn;
    let alone = settings.thresholds.work_before_diagrams.saturating_mul(STEPS_PER_WORK);
    let rules = Rules {
        threads: settings.threads.max(1),
        alone: if question.lists_states { alone + turn } else { alone },
        turn,
        lead: settings.thresholds.lead,
        memory: settings.memory,
    };
    let mut orders = 0;
    let share = |way: &Way| {
        let (weight, late) = match way {
            Way::Explicit => (4, 0),
            Way::Guided | Way::Everywhere(_) => (2, 0),
            Way::Symbolic(_) => {
                orders += 1;
                // Most questions end before other orders begin. So these allocate no tables in vain.
                if orders == 1 { (2, 0) } else { (1, turn / 4 * 3) }
            }
        };
        Share { weight, late }
    };
    let shares = Vec::from_iter(ways.iter().map(share));
    let own = || Arc::clone(&settings.sink);
    let sinks = |way: usize| question.sinks.map_or_else(own, |sinks| sinks(way));
    let entrant = Entrant { program, settings, question, ways };
    race(rules, &shares, &*settings.sink, &sinks, &|lane| entrant.run(lane))
}

/// The input of all ways.
struct Entrant<'e, 'q, T> {
    program: &'e Arc<Program>,
    settings: &'e Settings,
    question: &'e RacedQuestion<'q, T>,
    ways: &'e [Way],
}

impl<T: Send> Entrant<'_, '_, T> {
    /// Answers the question by a way; `None` if it has no answer for this model.
    fn run(&self, lane: &Arc<Lane>) -> Result<Option<(Selection, T)>> {
        let program = || Arc::clone(self.program);
        let of =
            |storage, reason: &str| Selection { storage, reason: Some(reason.to_owned()), is_open: false };
        match &self.ways[lane.way] {
            Way::Explicit => {
                let engine = ExplicitEngine::new(program(), self.settings(lane, Storage::Explicit))?;
                let states = engine.count(&engine.all_states())?;
                let whose = if self.program.monitors.is_some() { " with those of the monitors" } else { "" };
                let found = format!("{states} states{whose} found");
                let reason = |place| match place {
                    Place::Alone => found.clone(),
                    Place::First => format!("{found}, before diagrams found them"),
                    Place::Later => format!("{found}, and the answer before diagrams found it"),
                };
                self.by_states(lane, engine.into(), &reason)
            }
            Way::Symbolic(order) => {
                let settings = self.settings(lane, Storage::Symbolic);
                let engine = SymbolicEngine::in_order(program(), order, settings)?;
                let reason = |place| match place {
                    Place::Alone | Place::First => "diagrams found all states first".to_owned(),
                    Place::Later => "diagrams found the answer first".to_owned(),
                };
                self.by_states(lane, engine.into(), &reason)
            }
            Way::Everywhere(order) => {
                let Some(question) = self.question.everywhere else { return Ok(None) };
                let order = Order::Bits(order.bits.clone());
                let settings = Settings { order, ..self.settings(lane, Storage::Symbolic) };
                let how = "the initial states judged over all valuations, before their successors were found";
                let engine = SymbolicEngine::everywhere(program(), settings)?;
                match engine.map(|engine| question(&engine)).transpose() {
                    // A state without a meaning for the question may be none that is reached.
                    Err(Error::Input(_)) => Ok(None),
                    found => Ok(found?.map(|found| (of(Storage::Symbolic, how), found))),
                }
            }
            Way::Guided => {
                let Some((target, question)) = self.question.guided else { return Ok(None) };
                let how =
                    "the initial states judged by a guided search, before all their successors were found";
                let settings = self.settings(lane, Storage::Explicit);
                let found = Guided::finished(program(), settings, target)?.map(question).transpose()?;
                Ok(found.map(|found| (of(Storage::Explicit, how), found)))
            }
        }
    }

    /// Answers the question by an engine that knows all states. The reason depends on who else knows them.
    fn by_states(
        &self,
        lane: &Lane,
        engine: AnyEngine,
        reason: &dyn Fn(Place) -> String,
    ) -> Result<Option<(Selection, T)>> {
        let place = lane.knows_all_states(self.steps_of_lists(lane, &engine)?);
        let selection = Selection { storage: engine.storage(), reason: Some(reason(place)), is_open: false };
        let racer = Racer { way: lane.way, leads: place != Place::Later, selection: selection.clone() };
        let found = (self.question.by_states)(&racer, engine.clone())?;
        // The others end now, and the answer may need more memory later.
        engine.explicit().iter().for_each(|engine| engine.allow(self.settings.memory));
        Ok(Some((selection, found)))
    }

    /// Returns the steps in which the explicit engine is likely to answer the question, if it is the first way, and diagrams
    /// know all states. `None` if a leader has fewer alone anyway: then nothing is counted that takes long.
    fn steps_of_lists(&self, lane: &Lane, engine: &AnyEngine) -> Result<Option<u64>> {
        let (AnyEngine::Symbolic(engine), [Way::Explicit, ..]) = (engine, self.ways) else { return Ok(None) };
        let all = engine.all_states();
        let states = engine.count(&all)?;
        if states >= lane.alone().into() {
            return Ok(None);
        }
        let listing = states + engine.count_transitions(&engine.all_choices(), &all)?;
        // Most questions take less than twice as long as the lists for them.
        Ok(u64::try_from(listing * 3u32 * STEPS_PER_WORK).ok())
    }

    /// Returns the settings of a way. The one that is the likeliest to be the first has half of the memory, and a whole
    /// operation cache from the beginning.
    fn settings(&self, lane: &Arc<Lane>, storage: Storage) -> Settings {
        let Settings { memory: all, mut thresholds, .. } = *self.settings;
        let first = self.ways.iter().position(|way| matches!(way, Way::Symbolic(_)));
        let memory = match self.ways.len() as u64 {
            _ if lane.is_last => all,
            1 => all,
            _ if first == Some(lane.way) => all / 2,
            ways => {
                thresholds.cache /= 2;
                all / 2 / (ways - 1)
            }
        };
        Settings { memory, storage, thresholds, sink: Arc::clone(lane) as _, ..self.settings.clone() }
    }
}
