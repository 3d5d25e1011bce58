//! The progress sink of a call: cancels the library's work, and receives its progress.

use std::sync::atomic::{AtomicU8, AtomicU64, Ordering::Relaxed};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use meliora::{Limit, ProgressSink};

const RUNNING: u8 = 0;
const TIMED_OUT: u8 = 1;
const INTERRUPTED: u8 = 2;
const TOO_LARGE: u8 = 3;

/// The bytes that the process may gain beyond `memory`, for texts, results and other Python
/// objects.
const BESIDE: u64 = 64 << 20;
/// The minimum time between two measurements of the process's memory.
const WEIGHING_MILLIS: u64 = 5;
/// The minimum time between two queries for details.
const ASKING_MILLIS: u64 = 50;

/// The position of the work.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Position {
    /// The phase: `model`, `states`, `outcomes`, `sasi`, …
    pub(crate) phase: &'static str,
    /// The part of the phase, in words; may be empty.
    pub(crate) part: String,
    /// The last detail from the library; may be empty.
    pub(crate) detail: String,
}

impl Position {
    /// Returns the part and the detail in words.
    pub(crate) fn words(&self) -> String {
        let words = [self.part.as_str(), &self.detail].into_iter().filter(|word| !word.is_empty());
        words.collect::<Vec<_>>().join(", ")
    }
}

/// The state that the worker thread shares with the thread that waits for it.
pub(crate) struct Watch {
    order: AtomicU8,
    /// The maximum size of the process, in bytes.
    bound: AtomicU64,
    /// The memory limit of the work in bytes, for messages.
    memory: AtomicU64,
    timeout: Mutex<Duration>,
    started: Instant,
    weighed: AtomicU64,
    asked: AtomicU64,
    position: Mutex<Position>,
}

/// Locks a mutex, even if a panic of the worker thread has poisoned it: the data are plain.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Watch {
    pub(crate) fn new() -> Self {
        Watch {
            order: AtomicU8::new(RUNNING),
            bound: AtomicU64::new(u64::MAX),
            memory: AtomicU64::new(u64::MAX),
            timeout: Mutex::new(Duration::ZERO),
            started: Instant::now(),
            weighed: AtomicU64::new(0),
            asked: AtomicU64::new(0),
            position: Mutex::default(),
        }
    }

    /// Prepares for a new call: resets the order to stop and the position.
    pub(crate) fn arm(&self, memory: u64, timeout: Option<Duration>) {
        let now = memory_stats::memory_stats().map_or(0, |m| m.physical_mem as u64);
        self.bound.store(now.saturating_add(memory).saturating_add(BESIDE), Relaxed);
        self.memory.store(memory, Relaxed);
        *lock(&self.timeout) = timeout.unwrap_or_default();
        *lock(&self.position) = Position::default();
        self.order.store(RUNNING, Relaxed);
    }

    /// Prepares for a call that is too short to be watched.
    pub(crate) fn disarm(&self) {
        self.bound.store(u64::MAX, Relaxed);
        self.order.store(RUNNING, Relaxed);
    }

    /// Cancels the work because time is up.
    pub(crate) fn time_out(&self) {
        let _ = self.order.compare_exchange(RUNNING, TIMED_OUT, Relaxed, Relaxed);
    }

    /// Cancels the work because the caller asked for it.
    pub(crate) fn interrupt(&self) {
        self.order.store(INTERRUPTED, Relaxed);
    }

    /// Sets the position of the work.
    pub(crate) fn turn_to(&self, phase: &'static str, part: String) {
        *lock(&self.position) = Position { phase, part, detail: String::new() };
    }

    /// Returns the position of the work.
    pub(crate) fn position(&self) -> Position {
        lock(&self.position).clone()
    }

    /// Returns true, and resets the timer `then`, if the interval has passed.
    fn due(&self, then: &AtomicU64, interval: u64) -> bool {
        let now = u64::try_from(self.started.elapsed().as_millis()).unwrap_or(u64::MAX);
        let last = then.load(Relaxed);
        now >= last.saturating_add(interval) && then.compare_exchange(last, now, Relaxed, Relaxed).is_ok()
    }

    /// Cancels the work if the process has become too large.
    fn weigh(&self) {
        let bound = self.bound.load(Relaxed);
        if bound < u64::MAX
            && self.due(&self.weighed, WEIGHING_MILLIS)
            && memory_stats::memory_stats().is_some_and(|m| m.physical_mem as u64 > bound)
        {
            let _ = self.order.compare_exchange(RUNNING, TOO_LARGE, Relaxed, Relaxed);
        }
    }
}

impl ProgressSink for Watch {
    fn stop(&self) -> Option<Limit> {
        self.weigh();
        match self.order.load(Relaxed) {
            RUNNING => None,
            TIMED_OUT => Some(Limit::Time(*lock(&self.timeout))),
            TOO_LARGE => {
                let memory = self.memory.load(Relaxed) >> 20;
                let what = format!("the process has gained {memory} MiB and {} MiB beside", BESIDE >> 20);
                Some(Limit::Memory { what })
            }
            _ => Some(Limit::Interrupted),
        }
    }

    fn clock(&self) -> Duration {
        self.started.elapsed()
    }

    fn progress(&self, phase: &'static str, detail: &dyn Fn() -> String) {
        if self.due(&self.asked, ASKING_MILLIS) {
            let detail = format!("{phase}: {}", detail());
            lock(&self.position).detail = detail;
        }
    }
}
