//! The explicit engine in turns with diagrams, until one of them knows all states.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::explicit::Exploration;
use super::settings::{Settings, Storage};
use super::symbolic::Thresholds;
use meliora_model::Program;
use meliora_model::error::{Error, Limit, Result};
use meliora_model::progress::ProgressSink;

/// Steps to translate the model that do not count. Most models need no more, and the number of steps of a
/// translation says less about the states than that of an exploration.
const FREE_STEPS: u64 = 1 << 16;
/// The most work of the explicit engine in turns.
const MOST_WORK: u64 = 1 << 20;
/// The same, if more and more states wait for it.
const MOST_WORK_OF_MANY: u64 = 1 << 18;
/// The same, if a question lists the states anyway. Its equations need more time and memory than the states.
const MOST_WORK_TO_LIST: u64 = 1 << 25;
/// The share of the explicit engine in the memory, while it takes turns: one in this many bytes, …
const MEMORY_SHARE: u64 = 8;
/// … and at most this many …
const MOST_BYTES: u64 = 128 << 20;
/// … or this many, if a question lists the states anyway.
const MOST_BYTES_TO_LIST: u64 = 1 << 30;
/// The states that wait for the explicit engine are few if they are at most one in this many explored ones.
const FEW_WAIT: usize = 8;

/// The explicit exploration of a program in turns with diagrams. It is their sink: it explores when
/// they ask whether to stop, and stops them once it knows all states.
///
/// Work is counted in states and their successors, and in steps of the search for the initial states, and
/// about as fast as the steps of diagrams. Turns depend on these counts alone, so that each run ends with
/// the same engine.
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
enum State {
    /// It has not begun.
    New(Arc<Program>, Box<Settings>),
    /// Some states are not explored.
    Open(Box<Exploration>, Outlook),
    /// All states are explored, the model has no meaning in some state, or the work is to end.
    Over(Result<Box<Exploration>>),
    /// The states need too much memory, or the trial has ended.
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

    /// Returns all states, or the error, if the explicit engine is done: diagrams are not needed then.
    pub(crate) fn take_all(&self) -> Option<Result<Box<Exploration>>> {
        let mut state = self.state();
        match std::mem::replace(&mut *state, State::Closed) {
            State::Over(all) => Some(all),
            other => {
                *state = other;
                None
            }
        }
    }

    /// Ends the trial, and returns the states so far, if there are any.
    pub(crate) fn end(&self) -> Option<Box<Exploration>> {
        self.next.store(u64::MAX, Relaxed);
        match std::mem::replace(&mut *self.state(), State::Closed) {
            State::Open(exploration, _) => Some(exploration),
            _ => None,
        }
    }

    /// Returns true if the explicit engine was the only one that explored.
    pub(crate) fn is_alone(&self) -> bool {
        self.steps.load(Relaxed) == 0
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
                let most = self.allowed(steps, &Outlook::default());
                match Exploration::new(program, *settings) {
                    Ok(exploration) => State::Open(Box::new(exploration), Outlook::default())
                        .explored(most / 4)
                        .explored(most),
                    Err(error) => State::of(error),
                }
            }
            State::Open(exploration, outlook) => {
                let most = self.allowed(steps, &outlook);
                State::Open(exploration, outlook).explored(most)
            }
            state => state,
        };
    }

    /// Returns the work that the explicit engine may have done after some steps of the diagrams: an
    /// eighth of the steps, and half of those of a long exploration. So diagrams take at most 9/8 of their
    /// time alone, or 3/2 in a long exploration; and the explicit engine is found after at most 9 times
    /// its time alone, or 3 times and a short exploration. If more and more states wait, it is a 32nd of the
    /// steps.
    ///
    /// If a question lists the states, it may do eight times the steps, as long as no more states wait for
    /// it than are explored.
    fn allowed(&self, steps: u64, outlook: &Outlook) -> u64 {
        let long = steps.saturating_sub(self.thresholds.first_steps);
        let usual = steps / 8 + long / 8 * 3;
        if self.lists_states {
            let more = if outlook.is_near { steps.saturating_mul(8) } else { 0 };
            return usual.max(more).max(self.thresholds.work_before_diagrams).min(MOST_WORK_TO_LIST);
        }
        if outlook.grows {
            return (steps / 32).min(MOST_WORK_OF_MANY);
        }
        usual.min(outlook.next()).min(MOST_WORK)
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A sign of how far the end of an exploration is: the states that wait for the explicit engine.
struct Outlook {
    /// The work, and the states that waited, when they were last compared.
    last: Option<(u64, usize)>,
    /// True if more states waited than when half of the work was done, unless they were few. In models of
    /// more states than can be explored, they become more and more.
    grows: bool,
    /// True if no more states wait than are explored.
    is_near: bool,
}

impl Default for Outlook {
    fn default() -> Self {
        Outlook { last: None, grows: false, is_near: true }
    }
}

impl Outlook {
    /// Returns the work after which the states that wait are compared again.
    fn next(&self) -> u64 {
        self.last.map_or(u64::MAX, |(work, _)| work.saturating_mul(2))
    }

    /// Looks at an exploration after some of its work. Before all initial states are found, nothing is
    /// known.
    fn look(&mut self, exploration: &Exploration) {
        if !exploration.has_begun() {
            return;
        }
        let (explored, waiting) = (exploration.explored(), exploration.waiting());
        self.is_near = waiting <= explored;
        if self.last.is_none() || exploration.work() >= self.next() {
            let few = explored / FEW_WAIT;
            self.grows = self.last.is_some_and(|(_, before)| waiting > before.max(few));
            self.last = Some((exploration.work(), waiting));
        }
    }
}

impl State {
    /// Returns the state after an error: a limit of the explicit engine alone does not end the work.
    fn of(error: Error) -> Self {
        match error {
            Error::Limit(Limit::Memory { .. } | Limit::Size { .. } | Limit::States(_)) => State::Closed,
            error => State::Over(Err(error)),
        }
    }

    /// Explores until the work is `most`, if some states are not explored.
    fn explored(self, most: u64) -> Self {
        match self {
            State::Open(mut exploration, mut outlook) if exploration.work() < most => {
                match exploration.run(most) {
                    Ok(true) => State::Over(Ok(exploration)),
                    Ok(false) => {
                        outlook.look(&exploration);
                        State::Open(exploration, outlook)
                    }
                    Err(error) => State::of(error),
                }
            }
            state => state,
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
        matches!(*self.state(), State::Over(_)).then_some(Limit::Interrupted)
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::{Exploration, ProgressSink, Trial};
    use crate::settings::Settings;
    use meliora_lang as lang;
    use meliora_model::error::SourceFile;

    /// The trial of a model after a number of steps of the diagrams, of which each counts.
    fn after(text: &str, steps: u64) -> Trial {
        let source = SourceFile::new("m", text);
        let program = lang::load(&source, &SourceFile::new("constants", "")).unwrap().program;
        let trial = Trial::new(&Arc::new(program), &Settings::default(), false);
        trial.progress("reachable states", &String::new);
        for _ in 0..steps / 1024 {
            trial.advance(1024);
            trial.stop();
        }
        trial
    }

    fn all_of(trial: &Trial) -> Option<usize> {
        trial.take_all().map(|all| all.unwrap().explored())
    }

    fn rest_of(trial: &Trial) -> Box<Exploration> {
        assert!(all_of(trial).is_none());
        trial.end().unwrap()
    }

    #[test]
    fn states_that_become_more_and_more_have_few_turns() {
        let module = |i: usize| format!("module m{i} x{i} : [0..9]; [] x{i}<9 -> (x{i}'=x{i}+1); endmodule ");
        let text = format!("mdp {}", (0..7).map(module).collect::<String>());
        // Half of 10^7 states and more wait at the end of this. An eighth of the steps is 2^17.
        let work = rest_of(&after(&text, 1 << 20)).work();
        assert!((1 << 14..=1 << 15).contains(&work), "{work}");
    }

    #[test]
    fn states_of_which_few_wait_have_an_eighth_of_the_steps_and_half_of_many() {
        let text = "dtmc module m x : [0..9999999]; [] x<9999999 -> 0.5: (x'=x+1) + 0.5: true; endmodule";
        let work = rest_of(&after(text, 1 << 18)).work();
        assert!((1 << 14..=1 << 15).contains(&work), "{work}");
        let work = rest_of(&after(text, 1 << 20)).work();
        assert!((1 << 17..=1 << 19).contains(&work), "{work}");
    }

    #[test]
    fn states_that_wait_from_the_start_do_not_count_as_more() {
        // 10,000 successors of the first state; each has a path of its own, so as many wait until the end.
        let branches: Vec<String> = (0..10_000).map(|i| format!("1/10000: (x'=1) & (y'={i})")).collect();
        let text = format!(
            "dtmc module m x : [0..5]; y : [0..9999]; [] x=0 -> {}; [] x>0 & x<5 -> (x'=x+1); endmodule",
            branches.join(" + ")
        );
        assert_eq!(all_of(&after(&text, 1 << 19)), None);
        assert_eq!(all_of(&after(&text, 1 << 20)), Some(50_001));
    }
}
