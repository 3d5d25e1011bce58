//! The sink of a run: carries the order to stop into the library, and its progress out.

use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use meliora::engine::ProgressSink;
use meliora::error::{Diagnostic, Limit, render};
use meliora::escape;

use super::options::ShownArgs;
use super::terminal;

const RUNNING: u8 = 0;
const TIMED_OUT: u8 = 1;
const INTERRUPTED: u8 = 2;
const TOO_LARGE: u8 = 3;

/// What a process may have beyond `--memory`: the program itself, the text of the model, the report.
const BESIDE: u64 = 64 << 20;
/// The memory of the process is looked at at most this often.
const WEIGHING_MILLIS: u64 = 5;

/// Progress is shown for work that takes longer than this.
const QUIET_AT_FIRST: Duration = Duration::from_secs(1);
/// Progress is asked for at most this often.
const INTERVAL_MILLIS: u64 = 100;

/// What worker and supervisor share besides the report.
pub(super) struct Watch {
    order: AtomicU8,
    /// The bytes that the process may have; all of them where nothing has bounded them yet.
    memory: AtomicU64,
    /// When the memory was last looked at, in milliseconds since the start.
    weighed: AtomicU64,
    timeout: Option<Duration>,
    started: Instant,
    /// When the library was last asked for details, in milliseconds since the start.
    asked: AtomicU64,
    phase: Mutex<Stage>,
    /// The phase of the library that was told of last.
    told: Mutex<&'static str>,
    bar: Mutex<Option<ProgressBar>>,
    quiet: bool,
    verbose: u8,
}

/// What is being done.
#[derive(Debug, Clone, Default)]
struct Stage {
    name: &'static str,
    /// Which part of it, such as `objective 2 of 5`.
    part: String,
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

    /// Since the start.
    pub(super) fn elapsed(&self) -> Duration {
        self.started.elapsed()
    }

    /// What is left of `--timeout`; none without one.
    pub(super) fn time_left(&self) -> Option<Duration> {
        self.timeout.map(|t| t.saturating_sub(self.elapsed()))
    }

    /// The work may have so many bytes, and the process [`BESIDE`] more.
    pub(super) fn bound_memory(&self, bytes: u64) {
        self.memory.store(bytes.saturating_add(BESIDE), Ordering::Relaxed);
    }

    /// Whether the work is to go on, for work that no loop of the library does.
    ///
    /// # Errors
    /// The limit that ends it.
    pub(super) fn check(&self) -> Result<(), Limit> {
        self.stop().map_or(Ok(()), Err)
    }

    /// Asks the work to end because the process has become too large.
    fn weigh(&self) {
        let bound = self.memory.load(Ordering::Relaxed);
        if bound < u64::MAX
            && self.due(&self.weighed, WEIGHING_MILLIS)
            && memory_stats::memory_stats().is_some_and(|m| m.physical_mem as u64 > bound)
        {
            let _ = self.order.compare_exchange(RUNNING, TOO_LARGE, Ordering::Relaxed, Ordering::Relaxed);
        }
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
        *phase = Stage { name, ..Stage::default() };
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
            self.say(&format!("{warning}: {}", escape::lines(text)));
        }
    }

    /// Warnings that point into a text.
    pub(super) fn warn_of(&self, warnings: &[Diagnostic]) {
        if !self.quiet && !warnings.is_empty() {
            self.say(render(warnings, terminal::stderr_style().color).trim_end());
        }
    }

    /// Says which part of the present piece of work is being done.
    pub(super) fn turn_to(&self, part: String) {
        if self.verbose > 1 {
            self.say(&format!("{:9.3} s  {part}", self.elapsed().as_secs_f64()));
        }
        lock(&self.phase).part = part;
        self.refresh();
    }

    /// Something the user asked to know by `-v`.
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

    /// What was being done, in words: how far the work got.
    pub(super) fn position(&self) -> Option<String> {
        let phase = lock(&self.phase).clone();
        let details = [phase.part.as_str(), &phase.detail].into_iter().filter(|word| !word.is_empty());
        match (phase.name, details.collect::<Vec<_>>().join(", ")) {
            ("", _) => None,
            (name, details) if details.is_empty() => Some(format!("the work ended in the phase `{name}`")),
            (name, details) => Some(format!("the work ended in the phase `{name}` ({details})")),
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
            let words = [phase.name, &phase.part, &phase.detail].into_iter().filter(|word| !word.is_empty());
            bar.set_message(words.collect::<Vec<_>>().join(" · "));
            bar.tick();
        }
    }

    /// Takes the progress from the terminal.
    pub(super) fn clear(&self) {
        if let Some(bar) = lock(&self.bar).take() {
            bar.finish_and_clear();
        }
    }

    /// The phase of the library that was told of last; the given one is from now on.
    fn last_told(&self, phase: &'static str) -> &'static str {
        std::mem::replace(&mut lock(&self.told), phase)
    }

    /// Whether it is time to do again what was last done then.
    fn due(&self, then: &AtomicU64, interval: u64) -> bool {
        let now = u64::try_from(self.elapsed().as_millis()).unwrap_or(u64::MAX);
        let last = then.load(Ordering::Relaxed);
        now >= last.saturating_add(interval)
            && then.compare_exchange(last, now, Ordering::Relaxed, Ordering::Relaxed).is_ok()
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

impl ProgressSink for Watch {
    fn stop(&self) -> Option<Limit> {
        self.weigh();
        match self.order.load(Ordering::Relaxed) {
            RUNNING => None,
            TOO_LARGE => {
                let mebibytes = self.memory.load(Ordering::Relaxed).saturating_sub(BESIDE) >> 20;
                let what = format!("the process has passed {mebibytes} MiB and {} MiB beside", BESIDE >> 20);
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
        // The first news of each phase is always told, so that short work has some too.
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
