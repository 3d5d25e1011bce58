//! The observer of a run: carries the order to stop into the library, and its progress out.

use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use meliora::engine::Observer;
use meliora::error::{Diagnostic, Limit, render};

use super::options::ShownArgs;
use super::terminal;

const RUNNING: u8 = 0;
const TIMED_OUT: u8 = 1;
const INTERRUPTED: u8 = 2;

/// Progress is shown for work that takes longer than this.
const QUIET_AT_FIRST: Duration = Duration::from_secs(1);
/// Progress is asked for at most this often.
const INTERVAL_MILLIS: u64 = 100;

/// What worker and supervisor share besides the report.
pub(super) struct Watch {
    order: AtomicU8,
    timeout: Option<Duration>,
    started: Instant,
    /// When the library was last asked for details, in milliseconds since the start.
    asked: AtomicU64,
    phase: Mutex<Phase>,
    bar: Mutex<Option<ProgressBar>>,
    quiet: bool,
    verbose: u8,
}

/// What is being done.
#[derive(Debug, Clone, Default)]
struct Phase {
    name: &'static str,
    detail: String,
}

/// Locks, also where a panic of the worker has poisoned the lock: the data are plain.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Watch {
    /// A watch that starts now.
    pub(super) fn new(timeout: Option<Duration>, shown: &ShownArgs) -> Self {
        Watch {
            order: AtomicU8::new(RUNNING),
            timeout,
            started: Instant::now(),
            asked: AtomicU64::new(0),
            phase: Mutex::default(),
            bar: Mutex::default(),
            quiet: shown.quiet,
            verbose: shown.verbose,
        }
    }

    /// Since the start.
    pub(super) fn elapsed(&self) -> Duration {
        self.started.elapsed()
    }

    /// What is left of `--timeout`; none without one.
    pub(super) fn time_left(&self) -> Option<Duration> {
        self.timeout.map(|t| t.saturating_sub(self.elapsed()))
    }

    /// Asks the work to end because time is up.
    pub(super) fn time_out(&self) {
        let _ = self.order.compare_exchange(RUNNING, TIMED_OUT, Ordering::Relaxed, Ordering::Relaxed);
    }

    /// Asks the work to end because the user wants it.
    pub(super) fn interrupt(&self) {
        self.order.store(INTERRUPTED, Ordering::Relaxed);
    }

    /// The work turns to something else.
    pub(super) fn enter(&self, name: &'static str) {
        let mut phase = lock(&self.phase);
        *phase = Phase { name, detail: String::new() };
        drop(phase);
        self.refresh();
    }

    /// The present piece of work took so long.
    pub(super) fn leave(&self, name: &str, seconds: f64) {
        if self.verbose > 0 {
            self.say(&format!("{name}: {seconds:.3} s"));
        }
    }

    /// Something the user should know, on stderr.
    pub(super) fn warn(&self, text: &str) {
        if !self.quiet {
            let warning = terminal::stderr_style().warn("warning");
            self.say(&format!("{warning}: {text}"));
        }
    }

    /// Warnings that point into a text.
    pub(super) fn warn_of(&self, warnings: &[Diagnostic]) {
        if !self.quiet && !warnings.is_empty() {
            self.say(render(warnings, terminal::stderr_style().color).trim_end());
        }
    }

    /// Something the user asked to know by `-v`.
    pub(super) fn note(&self, text: &str) {
        if self.verbose > 0 {
            self.say(&format!("note: {text}"));
        }
    }

    fn say(&self, text: &str) {
        match &*lock(&self.bar) {
            Some(bar) => bar.suspend(|| terminal::message(text)),
            None => terminal::message(text),
        }
    }

    /// What was being done, in words: how far the work got.
    pub(super) fn position(&self) -> Option<String> {
        let phase = lock(&self.phase).clone();
        match (phase.name, phase.detail.as_str()) {
            ("", _) => None,
            (name, "") => Some(format!("the work ended in the phase `{name}`")),
            (name, detail) => Some(format!("the work ended in the phase `{name}` ({detail})")),
        }
    }

    /// Called by the supervisor now and then: shows progress once the work has taken a while.
    pub(super) fn tick(&self) {
        let mut bar = lock(&self.bar);
        if bar.is_none() && !self.quiet && self.elapsed() > QUIET_AT_FIRST {
            *bar = Some(spinner(self.started.elapsed()));
        }
        drop(bar);
        self.refresh();
    }

    fn refresh(&self) {
        if let Some(bar) = &*lock(&self.bar) {
            let phase = lock(&self.phase).clone();
            bar.set_message(format!("{} {}", phase.name, phase.detail));
            bar.tick();
        }
    }

    /// Takes the progress from the terminal.
    pub(super) fn clear(&self) {
        if let Some(bar) = lock(&self.bar).take() {
            bar.finish_and_clear();
        }
    }

    /// Whether it is time to ask for details again.
    fn due(&self) -> bool {
        let now = u64::try_from(self.elapsed().as_millis()).unwrap_or(u64::MAX);
        let last = self.asked.load(Ordering::Relaxed);
        now >= last.saturating_add(INTERVAL_MILLIS)
            && self.asked.compare_exchange(last, now, Ordering::Relaxed, Ordering::Relaxed).is_ok()
    }
}

/// A line on stderr, on a terminal only.
fn spinner(elapsed: Duration) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr()).with_elapsed(elapsed);
    match ProgressStyle::with_template("{spinner} {elapsed} {wide_msg}") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

impl Observer for Watch {
    fn stop(&self) -> Option<Limit> {
        match self.order.load(Ordering::Relaxed) {
            RUNNING => None,
            TIMED_OUT => Some(Limit::Time(self.timeout.unwrap_or_default())),
            _ => Some(Limit::Interrupted),
        }
    }

    fn progress(&self, phase: &'static str, detail: &dyn Fn() -> String) {
        if !self.due() {
            return;
        }
        let detail = detail();
        if self.verbose > 1 {
            self.say(&format!("{:9.3} s  {phase}: {detail}", self.elapsed().as_secs_f64()));
        }
        lock(&self.phase).detail = format!("{phase}: {detail}");
    }
}
