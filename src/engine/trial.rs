//! The explicit engine in turns with diagrams, until one of them knows all states.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::explicit::Exploration;
use super::settings::{Settings, Storage};
use super::symbolic::Thresholds;
use meliora_model::Program;
use meliora_model::error::{Error, Limit};
use meliora_model::progress::ProgressSink;

/// Steps to translate the model that do not count. Most models need no more, and the number of steps of a
/// translation says less about the states than that of an exploration.
const FREE_STEPS: u64 = 1 << 16;
/// The most work of the explicit engine in turns.
const MOST_WORK: u64 = 1 << 20;
/// The same, if a question lists the states anyway. Its equations need more time and memory than the states.
const MOST_WORK_TO_LIST: u64 = 1 << 25;
/// The share of the explicit engine in the memory, while it takes turns: one in this many bytes, …
const MEMORY_SHARE: u64 = 8;
/// … and at most this many …
const MOST_BYTES: u64 = 128 << 20;
/// … or this many, if a question lists the states anyway.
const MOST_BYTES_TO_LIST: u64 = 1 << 30;
/// The partial valuations that may always be tried to find the initial states. To prepare the commands
/// takes longer.
const FREE_TRIES: u64 = 1 << 12;

/// The explicit exploration of a program in turns with diagrams. It is their sink: it explores when
/// they ask whether to stop, and stops them once it knows all states.
///
/// Work is counted in states and their successors, and about as fast as the steps of diagrams. Turns
/// depend on these counts alone, so that each run ends with the same engine.
pub(crate) struct Trial {
    sink: Arc<dyn ProgressSink>,
    thresholds: Thresholds,
    /// True if a question lists the states anyway.
    lists_states: bool,
    state: Mutex<State>,
    /// The steps of the diagrams so far.
    steps: AtomicU64,
    /// The steps to translate the model; the greatest number until they are over.
    translated: AtomicU64,
    /// The number of steps that count at which the next turn begins.
    next: AtomicU64,
}

/// The state of a trial.
pub(crate) enum State {
    /// It has not begun.
    New(Arc<Program>, Box<Settings>),
    /// Some states are not explored.
    Open(Box<Exploration>),
    /// All states are explored.
    Done(Box<Exploration>),
    /// The model has no meaning in some state, or the work is to end.
    Failed(Error),
    /// The states need too much memory, or the trial is over.
    Closed,
}

impl Trial {
    /// Creates a trial. It begins at once if a question lists the states.
    pub(crate) fn new(program: &Arc<Program>, settings: &Settings, lists_states: bool) -> Self {
        let memory = share(settings.memory, lists_states);
        let own = Settings { storage: Storage::Explicit, memory, ..settings.clone() };
        let trial = Trial {
            sink: Arc::clone(&settings.sink),
            thresholds: settings.thresholds,
            lists_states,
            state: Mutex::new(State::New(Arc::clone(program), Box::new(own))),
            steps: AtomicU64::new(0),
            translated: AtomicU64::new(u64::MAX),
            next: AtomicU64::new(if lists_states { 0 } else { settings.thresholds.steps_before_trial }),
        };
        trial.turn();
        trial
    }

    /// Returns the settings of the diagrams.
    pub(crate) fn settings(self: &Arc<Self>, settings: &Settings) -> Settings {
        let memory = settings.memory - share(settings.memory, self.lists_states);
        Settings { sink: Arc::clone(self) as _, memory, storage: Storage::Symbolic, ..settings.clone() }
    }

    /// Returns true if the diagrams are not needed.
    pub(crate) fn is_over(&self) -> bool {
        matches!(*self.state(), State::Done(_) | State::Failed(_))
    }

    /// Returns true if the explicit engine was the only one that explored.
    pub(crate) fn is_alone(&self) -> bool {
        self.steps.load(Relaxed) == 0
    }

    /// Ends the trial, and returns its state.
    pub(crate) fn end(&self) -> State {
        self.next.store(u64::MAX, Relaxed);
        std::mem::replace(&mut *self.state(), State::Closed)
    }

    /// Returns the number of steps that count.
    fn steps(&self) -> u64 {
        let steps = self.steps.load(Relaxed);
        steps - steps.min(self.translated.load(Relaxed)).min(FREE_STEPS)
    }

    fn is_due(&self) -> bool {
        self.steps() >= self.next.load(Relaxed)
    }

    /// Explores for one turn, if it has begun.
    fn turn(&self) {
        if !self.is_due() {
            return;
        }
        let steps = self.steps();
        // Turns grow with the work, so that there are few.
        self.next.store(steps + steps / 8 + self.thresholds.steps_before_trial / 4, Relaxed);
        let mut state = self.state();
        *state = match std::mem::replace(&mut *state, State::Closed) {
            State::New(program, settings) => {
                let most = self.allowed(steps, true);
                match Exploration::new(program, *settings, most.max(FREE_TRIES)) {
                    Ok(exploration) => self.explored(Box::new(exploration), most),
                    Err(error) => State::of(error),
                }
            }
            State::Open(exploration) => {
                let most = self.allowed(steps, exploration.waiting() <= exploration.explored());
                self.explored(exploration, most)
            }
            state => state,
        };
    }

    fn explored(&self, mut exploration: Box<Exploration>, most: u64) -> State {
        match exploration.run(most) {
            Ok(true) => State::Done(exploration),
            Ok(false) => State::Open(exploration),
            Err(error) => State::of(error),
        }
    }

    /// Returns the work that the explicit engine may have done after some steps of the diagrams: an
    /// eighth of the steps, and half of those of a long exploration. So diagrams take at most 9/8 of their
    /// time alone, or 3/2 in a long exploration; and the explicit engine is found after at most 9 times
    /// its time alone, or 3 times and a short exploration.
    ///
    /// If a question lists the states, it may do eight times the steps, as long as it seems to come to
    /// an end: no more states wait for it than are explored.
    fn allowed(&self, steps: u64, ends: bool) -> u64 {
        let long = steps.saturating_sub(self.thresholds.first_steps);
        let work = steps / 8 + long / 8 * 3;
        if !self.lists_states {
            return work.min(MOST_WORK);
        }
        let more = if ends { steps.saturating_mul(8) } else { 0 };
        work.max(more).max(self.thresholds.work_before_diagrams).min(MOST_WORK_TO_LIST)
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    /// Returns the state after an error: a limit of the explicit engine alone does not end the work.
    fn of(error: Error) -> Self {
        match error {
            Error::Limit(Limit::Memory { .. } | Limit::Size { .. } | Limit::States(_)) => State::Closed,
            error => State::Failed(error),
        }
    }
}

/// Returns the bytes of the explicit engine while it takes turns.
fn share(memory: u64, lists_states: bool) -> u64 {
    (memory / MEMORY_SHARE).min(if lists_states { MOST_BYTES_TO_LIST } else { MOST_BYTES })
}

impl ProgressSink for Trial {
    fn stop(&self) -> Option<Limit> {
        let limit = self.sink.stop();
        if limit.is_some() || !self.is_due() {
            return limit;
        }
        self.turn();
        self.is_over().then_some(Limit::Interrupted)
    }

    fn advance(&self, steps: u64) {
        self.steps.fetch_add(steps, Relaxed);
    }

    fn clock(&self) -> Duration {
        self.sink.clock()
    }

    /// The exploration is the first work of diagrams that tells its progress.
    fn progress(&self, phase: &'static str, detail: &dyn Fn() -> String) {
        self.translated.fetch_min(self.steps.load(Relaxed), Relaxed);
        self.sink.progress(phase, detail);
    }
}
