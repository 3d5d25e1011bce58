//! The progress sink of a run: passes cancellation to the library, and shows its progress.

use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use meliora::advanced::escape;
use meliora::engine::ProgressSink;
use meliora::error::{Diagnostic, Limit, render};

use super::options::ShownArgs;
use super::terminal;

const RUNNING: u8 = 0;
const TIMED_OUT: u8 = 1;
const INTERRUPTED: u8 = 2;
const TOO_LARGE: u8 = 3;

/// Memory of the process beyond `--memory`, in bytes: the program, the text of the model, the
/// report.
const BESIDE: u64 = 64 << 20;
/// Minimum interval between two looks at the memory of the process.
const WEIGHING_MILLIS: u64 = 5;

/// Progress is shown after this time.
const QUIET_AT_FIRST: Duration = Duration::from_secs(1);
/// Minimum interval between two requests for progress.
const INTERVAL_MILLIS: u64 = 100;

/// The state that worker and supervisor share in addition to the report.
pub(super) struct Watch {
    order: AtomicU8,
    /// Memory limit of the process in bytes; `u64::MAX` until it is set.
    memory: AtomicU64,
    /// Time of the last look at the memory, in milliseconds since the start.
    weighed: AtomicU64,
    timeout: Option<Duration>,
    started: Instant,
    /// Time of the last request for details, in milliseconds since the start.
    asked: AtomicU64,
    phase: Mutex<Stage>,
    /// The phase of the library that was reported last.
    told: Mutex<&'static str>,
    bar: Mutex<Option<ProgressBar>>,
    quiet: bool,
    verbose: u8,
}

/// The current work.
#[derive(Debug, Clone, Default)]
struct Stage {
    name: &'static str,
    /// The part of the phase, such as `objective 2 of 5`.
    part: String,
    detail: String,
}

/// Locks a mutex, even if a panic of the worker has poisoned it: the data are plain.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Watch {
    /// Creates a watch that starts now.
    pub(super) fn new(timeout: Option<Duration>, shown: &ShownArgs) -> Self {
        Watch {
            order: AtomicU8::new(RUNNING),
            memory: AtomicU64::new(u64::MAX),
            weighed: AtomicU64::new(0),
            timeout,
            started: Instant::now(),
            asked: AtomicU64::new(0),
            phase: Mutex::default(),
            told: Mutex::default(),
            bar: Mutex::default(),
            quiet: shown.quiet,
            verbose: shown.verbose,
        }
    }

    /// Returns the time since the start.
    pub(super) fn elapsed(&self) -> Duration {
        self.started.elapsed()
    }

    /// Returns the rest of `--timeout`, if there is one.
    pub(super) fn time_left(&self) -> Option<Duration> {
        self.timeout.map(|t| t.saturating_sub(self.elapsed()))
    }

    /// Sets the memory limit of the work in bytes; the process may use 64 MiB more.
    pub(super) fn bound_memory(&self, bytes: u64) {
        self.memory.store(bytes.saturating_add(BESIDE), Ordering::Relaxed);
    }

    /// Checks for cancellation, for work outside of the library's loops.
    ///
    /// # Errors
    /// The limit that ends the work.
    pub(super) fn check(&self) -> Result<(), Limit> {
        self.stop().map_or(Ok(()), Err)
    }

    /// Asks the work to stop if the process has become too large.
    fn weigh(&self) {
        let bound = self.memory.load(Ordering::Relaxed);
        if bound < u64::MAX
            && self.due(&self.weighed, WEIGHING_MILLIS)
            && memory_stats::memory_stats().is_some_and(|m| m.physical_mem as u64 > bound)
        {
            let _ = self.order.compare_exchange(RUNNING, TOO_LARGE, Ordering::Relaxed, Ordering::Relaxed);
        }
    }

    /// Asks the work to stop because time is up.
    pub(super) fn time_out(&self) {
        let _ = self.order.compare_exchange(RUNNING, TIMED_OUT, Ordering::Relaxed, Ordering::Relaxed);
    }

    /// Asks the work to stop because the user wants it.
    pub(super) fn interrupt(&self) {
        self.order.store(INTERRUPTED, Ordering::Relaxed);
    }

    /// Starts a phase.
    pub(super) fn enter(&self, name: &'static str) {
        let mut phase = lock(&self.phase);
        *phase = Stage { name, ..Stage::default() };
        drop(phase);
        self.refresh();
    }

    /// Ends a phase that took this time.
    pub(super) fn leave(&self, name: &str, seconds: f64) {
        if self.verbose > 0 {
            self.say(&format!("{name}: {seconds:.3} s"));
        }
    }

    /// Writes a warning to stderr.
    pub(super) fn warn(&self, text: &str) {
        if !self.quiet {
            let warning = terminal::stderr_style().warn("warning");
            self.say(&format!("{warning}: {}", escape::lines(text)));
        }
    }

    /// Writes warnings that point into a text.
    pub(super) fn warn_of(&self, warnings: &[Diagnostic]) {
        if !self.quiet && !warnings.is_empty() {
            self.say(render(warnings, terminal::stderr_style().color).trim_end());
        }
    }

    /// Starts a part of the phase.
    pub(super) fn turn_to(&self, part: String) {
        if self.verbose > 1 {
            self.say(&format!("{:9.3} s  {part}", self.elapsed().as_secs_f64()));
        }
        lock(&self.phase).part = part;
        self.refresh();
    }

    /// Writes a note for `-v`.
    pub(super) fn note(&self, text: &str) {
        if self.verbose > 0 {
            self.say(&format!("note: {}", escape::lines(text)));
        }
    }

    fn say(&self, text: &str) {
        match &*lock(&self.bar) {
            Some(bar) => bar.suspend(|| terminal::message(text)),
            None => terminal::message(text),
        }
    }

    /// Describes how far the work got.
    pub(super) fn position(&self) -> Option<String> {
        let phase = lock(&self.phase).clone();
        let details = [phase.part.as_str(), &phase.detail].into_iter().filter(|word| !word.is_empty());
        match (phase.name, details.collect::<Vec<_>>().join(", ")) {
            ("", _) => None,
            (name, details) if details.is_empty() => Some(format!("stopped in the phase `{name}`")),
            (name, details) => Some(format!("stopped in the phase `{name}` ({details})")),
        }
    }

    /// Shows progress once the work has taken a while. The supervisor calls this regularly.
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
            let words = [phase.name, &phase.part, &phase.detail].into_iter().filter(|word| !word.is_empty());
            bar.set_message(words.collect::<Vec<_>>().join(" · "));
            bar.tick();
        }
    }

    /// Removes the progress from the terminal.
    pub(super) fn clear(&self) {
        if let Some(bar) = lock(&self.bar).take() {
            bar.finish_and_clear();
        }
    }

    /// Returns the phase that was reported last, and replaces it.
    fn last_told(&self, phase: &'static str) -> &'static str {
        std::mem::replace(&mut lock(&self.told), phase)
    }

    /// Returns whether `interval` milliseconds have passed since `then`, and sets `then` to now if
    /// so.
    fn due(&self, then: &AtomicU64, interval: u64) -> bool {
        let now = u64::try_from(self.elapsed().as_millis()).unwrap_or(u64::MAX);
        let last = then.load(Ordering::Relaxed);
        now >= last.saturating_add(interval)
            && then.compare_exchange(last, now, Ordering::Relaxed, Ordering::Relaxed).is_ok()
    }
}

/// Creates the progress line on stderr, which only a terminal shows.
fn spinner(elapsed: Duration) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr()).with_elapsed(elapsed);
    match ProgressStyle::with_template("{spinner} {elapsed} {wide_msg}") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

impl ProgressSink for Watch {
    fn stop(&self) -> Option<Limit> {
        self.weigh();
        match self.order.load(Ordering::Relaxed) {
            RUNNING => None,
            TOO_LARGE => {
                let mebibytes = self.memory.load(Ordering::Relaxed).saturating_sub(BESIDE) >> 20;
                let what =
                    format!("the process uses more than {mebibytes} MiB + {} MiB for itself", BESIDE >> 20);
                Some(Limit::Memory { what })
            }
            TIMED_OUT => Some(Limit::Time(self.timeout.unwrap_or_default())),
            _ => Some(Limit::Interrupted),
        }
    }

    fn clock(&self) -> Duration {
        self.elapsed()
    }

    fn progress(&self, phase: &'static str, detail: &dyn Fn() -> String) {
        // The first message of each phase is always shown, so that short work shows some too.
        let news = self.verbose > 1 && self.last_told(phase) != phase;
        if !self.due(&self.asked, INTERVAL_MILLIS) && !news {
            return;
        }
        let detail = detail();
        if self.verbose > 1 {
            self.say(&format!("{:9.3} s  {phase}: {detail}", self.elapsed().as_secs_f64()));
        }
        lock(&self.phase).detail = format!("{phase}: {detail}");
    }
}
