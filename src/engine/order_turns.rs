//! The turns of several orders of the bits with a question, and the engines that they share.

use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread::ScopedJoinHandle;

use super::budget::Budget;
use super::engine::Engine;
use super::explicit::ExplicitEngine;
use super::rest::Rest;
use super::schedule::{Schedule, Turn};
use super::settings::{MEMORY_SHARE, Settings, Storage, Usage};
use super::symbolic::Bit;
use super::symbolic::SymbolicEngine;
use super::translation::Translated;
use meliora_base::error::{Error, Limit, Result};

/// The parts that all engines for a model share.
pub(super) struct Shared {
    settings: Settings,
    /// The engine that has found the states.
    pub(super) first: Arc<SymbolicEngine>,
    /// The orders, that of the first engine first.
    orders: Vec<OneOrder>,
    /// The explicit engine of the whole model, once it has taken over.
    pub(super) explicit: OnceLock<Arc<ExplicitEngine>>,
    /// The order whose turn it is; 0 is that of the first engine.
    at: AtomicUsize,
    turns: Mutex<Turns>,
    pub(super) translated: Translated,
}

/// An order of the bits.
struct OneOrder {
    bits: Vec<Bit>,
    /// The sink of its engine.
    budget: Arc<Budget>,
    /// The steps before the question.
    begun: u64,
    /// The engine of the whole model, once it is made.
    engine: OnceLock<Arc<SymbolicEngine>>,
}

/// The engine that continues an operation.
pub(super) enum Next {
    /// Nobody: it has its result.
    Nobody,
    /// The engine whose turn it is.
    Alone,
    /// All orders in turns.
    Turns,
}

/// The turns of the orders.
pub(super) struct Turns {
    schedule: Schedule,
    /// The explicit engine, and the steps of the question after which it takes over; `None` if it cannot.
    rest: Option<(Rest, u64)>,
    /// The steps after which it took over.
    taken_over_after: Option<u64>,
    /// The first limit of an order that has no more turns.
    full: Option<Limit>,
}

/// Returns whether an engine had not enough memory.
fn is_of_memory(limit: &Limit) -> bool {
    matches!(limit, Limit::Memory { .. } | Limit::System { .. })
}

impl Turns {
    /// Gives no more turns to an order that has met a limit.
    fn withdraw(&mut self, order: usize, limit: &Limit) {
        self.schedule.withdraw(order);
        self.full.get_or_insert_with(|| limit.clone());
    }
}

impl Shared {
    /// Begins a question with the engine that has found the states, whose sink is the budget. The first turn has as many
    /// steps as the exploration, since another order has to build its engine first. With `rest`, the explicit engine
    /// takes over after some steps.
    pub(super) fn new(
        first: Arc<SymbolicEngine>,
        settings: Settings,
        budget: Arc<Budget>,
        rest: Option<(Rest, u64)>,
    ) -> Self {
        let begun = budget.spent();
        let fresh = |bits| {
            let budget = Arc::new(Budget::new(0, &settings.sink));
            OneOrder { bits, budget, begun: 0, engine: OnceLock::new() }
        };
        let mut orders = Vec::from_iter(first.orders().into_iter().map(fresh));
        budget.allow(0);
        (orders[0].budget, orders[0].begun) = (budget, begun);
        orders[0].engine = Arc::clone(&first).into();
        let schedule = Schedule::new(orders.len(), begun.max(settings.thresholds.first_turn));
        let shared = Shared {
            settings,
            first,
            translated: Translated::new(orders.len()),
            orders,
            explicit: OnceLock::new(),
            at: AtomicUsize::new(0),
            turns: Mutex::new(Turns { schedule, rest, taken_over_after: None, full: None }),
        };
        shared.begin_turn(&mut shared.turns());
        shared
    }

    /// Returns the settings, with the sink of the whole work.
    pub(super) fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Returns the number of orders.
    pub(super) fn orders(&self) -> usize {
        self.orders.len()
    }

    /// Returns the order whose turn it is.
    pub(super) fn at(&self) -> usize {
        self.at.load(Relaxed)
    }

    pub(super) fn turns(&self) -> MutexGuard<'_, Turns> {
        self.turns.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the budget of an order.
    pub(super) fn budget(&self, order: usize) -> &Budget {
        &self.orders[order].budget
    }

    pub(super) fn budgets(&self) -> impl Iterator<Item = &Budget> {
        self.orders.iter().map(|order| &*order.budget)
    }

    /// Returns the steps of an order before the explicit engine takes over; `None` if it cannot.
    fn left(&self, turns: &Turns) -> Option<u64> {
        let spent = self.orders.iter().map(|order| order.budget.spent() - order.begun).fold(0, u64::max);
        turns.rest.as_ref().map(|(_, steps)| steps.saturating_sub(spent))
    }

    /// Adds the steps of its next turn to those that an order has left.
    fn begin_turn(&self, turns: &mut Turns) {
        let Some(Turn { way, steps }) = turns.schedule.next() else { return };
        let steps = self.budget(way).left().saturating_add(steps);
        self.budget(way).allow(steps.min(self.left(turns).unwrap_or(u64::MAX)));
    }

    /// Returns the engine that continues an operation after a turn.
    ///
    /// # Errors
    /// A limit of the whole work.
    pub(super) fn after<T>(&self, turns: &mut Turns, result: &Result<T>) -> Result<Next> {
        let at = self.at();
        match result {
            Err(Error::Limit(Limit::Interrupted)) if self.budget(at).has_ended() => {}
            Err(Error::Limit(limit)) if is_of_memory(limit) && self.explicit.get().is_none() => {
                turns.withdraw(at, limit);
            }
            _ => return Ok(Next::Nobody),
        }
        if self.left(turns) == Some(0) && self.take_over(turns)? {
            return Ok(Next::Alone);
        }
        match turns.schedule.open().to_vec()[..] {
            [] if self.take_over(turns)? => Ok(Next::Alone),
            [] => Err(turns.full.take().unwrap_or(Limit::Interrupted).into()),
            [only] => {
                self.at.store(only, Relaxed);
                self.budget(only).allow(self.left(turns).unwrap_or(u64::MAX));
                Ok(Next::Alone)
            }
            _ => Ok(Next::Turns),
        }
    }

    /// Gives the work of all orders turns until the first ends. That order begins the next round, and has the most steps
    /// from then on. An order whose engine is not made in its first turn has no more turns.
    ///
    /// # Errors
    /// The error of the work, unless another one can go on.
    pub(super) fn first_to_end<'s, T>(
        &self,
        turns: &mut Turns,
        begin: impl Fn(usize) -> std::io::Result<ScopedJoinHandle<'s, Result<T>>>,
    ) -> Result<Option<T>> {
        let mut running = Vec::from_iter(self.budgets().map(|_| None));
        while self.left(turns) != Some(0) {
            let Some(Turn { way, steps }) = turns.schedule.next() else { return Ok(None) };
            let run = match running[way].take().map_or_else(|| begin(way), Ok) {
                Ok(run) => run,
                // The last order needs no thread of its own.
                Err(_) if turns.schedule.open().len() == 1 => return Ok(None),
                Err(_) => {
                    turns.schedule.withdraw(way);
                    continue;
                }
            };
            if !self.budget(way).give_turn(steps.min(self.left(turns).unwrap_or(u64::MAX))) {
                match self.is_made(way) {
                    true => running[way] = Some(run),
                    false => turns.schedule.withdraw(way),
                }
                continue;
            }
            match run.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)) {
                Err(Error::Limit(limit)) if is_of_memory(&limit) => turns.withdraw(way, &limit),
                result => {
                    self.at.store(way, Relaxed);
                    turns.schedule.prefer(way);
                    self.begin_turn(turns);
                    return result.map(Some);
                }
            }
        }
        Ok(None)
    }

    /// Lets the explicit engine take over. Returns whether it does: it needs memory in addition to the diagrams.
    ///
    /// # Errors
    /// A limit of the whole work.
    fn take_over(&self, turns: &mut Turns) -> Result<bool> {
        let Some((rest, steps)) = turns.rest.take() else { return Ok(false) };
        // The sets of all orders are translated from now on.
        self.budgets().for_each(Budget::lift);
        let used = self.usage().bytes;
        let Some(engine) = rest.explore(&self.first, used)? else { return Ok(false) };
        turns.taken_over_after = Some(steps);
        Ok(self.explicit.set(Arc::new(engine)).is_ok())
    }

    /// Returns the engines of diagrams that are made.
    pub(super) fn diagrams(&self) -> impl Iterator<Item = &Arc<SymbolicEngine>> {
        self.orders.iter().filter_map(|order| order.engine.get())
    }

    /// Returns the engine of diagrams of the whole model in an order. Each order but the first has a share of the memory.
    pub(super) fn whole(&self, order: usize) -> Result<&Arc<SymbolicEngine>> {
        let OneOrder { bits, budget, engine, .. } = &self.orders[order];
        if let Some(engine) = engine.get() {
            return Ok(engine);
        }
        let memory = self.settings.memory / MEMORY_SHARE;
        let others = memory * (self.orders.len() - 1) as u64;
        if !self.first.limit_to(self.first.settings().memory.saturating_sub(others)) {
            let what = "diagrams in two orders at once".to_owned();
            return Err(Limit::Memory { what }.into());
        }
        let settings = Settings {
            memory,
            storage: Storage::Symbolic,
            sink: Arc::clone(budget) as _,
            ..self.settings.clone()
        };
        let made = self.first.reordered(bits, settings)?;
        Ok(engine.get_or_init(|| Arc::new(made)))
    }

    /// Returns the order of an engine of diagrams.
    pub(super) fn order_of(&self, engine: &SymbolicEngine) -> Option<usize> {
        self.orders.iter().position(|order| order.engine.get().is_some_and(|own| own.shares(engine)))
    }

    fn is_made(&self, order: usize) -> bool {
        self.orders[order].engine.get().is_some()
    }

    /// Returns the resources that all engines have used so far.
    pub(super) fn usage(&self) -> Usage {
        let mut all = Usage::default();
        for usage in self.diagrams().map(|engine| engine.usage()) {
            all.peak_nodes += usage.peak_nodes;
            all.bytes += usage.bytes;
        }
        if let Some(explicit) = self.explicit.get() {
            all.bytes += explicit.usage().bytes;
            all.taken_over_after = self.turns().taken_over_after;
        }
        all
    }
}
