//! The sink of a call: carries the order to stop into the library, and its progress out.

use std::sync::atomic::{AtomicU8, AtomicU64, Ordering::Relaxed};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use meliora::{Limit, ProgressSink};

const RUNNING: u8 = 0;
const TIMED_OUT: u8 = 1;
const INTERRUPTED: u8 = 2;
const TOO_LARGE: u8 = 3;

/// What the process may gain beyond `memory`: texts, results, what else Python does meanwhile.
const BESIDE: u64 = 64 << 20;
/// The memory of the process is looked at at most this often.
const WEIGHING_MILLIS: u64 = 5;
/// Details are asked for at most this often.
const ASKING_MILLIS: u64 = 50;

/// What is being done.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Position {
    /// A phase: `model`, `states`, `outcomes`, `sasi`, …
    pub(crate) phase: &'static str,
    /// Which part of it, in words; may be empty.
    pub(crate) part: String,
    /// What the library said of it last; may be empty.
    pub(crate) detail: String,
}

impl Position {
    /// The part and the detail in words.
    pub(crate) fn words(&self) -> String {
        let words = [self.part.as_str(), &self.detail].into_iter().filter(|word| !word.is_empty());
        words.collect::<Vec<_>>().join(", ")
    }
}

/// What the thread that works and the one that waits for it share.
pub(crate) struct Watch {
    order: AtomicU8,
    /// The bytes that the process may have.
    bound: AtomicU64,
    /// The bytes that the work may have, for messages.
    memory: AtomicU64,
    timeout: Mutex<Duration>,
    started: Instant,
    weighed: AtomicU64,
    asked: AtomicU64,
    position: Mutex<Position>,
}

/// Locks, also where a panic of the worker has poisoned the lock: the data are plain.
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

    /// A new call begins: nothing of what earlier ones were told counts any more.
    pub(crate) fn arm(&self, memory: u64, timeout: Option<Duration>) {
        let now = memory_stats::memory_stats().map_or(0, |m| m.physical_mem as u64);
        self.bound.store(now.saturating_add(memory).saturating_add(BESIDE), Relaxed);
        self.memory.store(memory, Relaxed);
        *lock(&self.timeout) = timeout.unwrap_or_default();
        *lock(&self.position) = Position::default();
        self.order.store(RUNNING, Relaxed);
    }

    /// A call begins that is too short to be watched.
    pub(crate) fn disarm(&self) {
        self.bound.store(u64::MAX, Relaxed);
        self.order.store(RUNNING, Relaxed);
    }

    /// Asks the work to end because time is up.
    pub(crate) fn time_out(&self) {
        let _ = self.order.compare_exchange(RUNNING, TIMED_OUT, Relaxed, Relaxed);
    }

    /// Asks the work to end because the caller wants it.
    pub(crate) fn interrupt(&self) {
        self.order.store(INTERRUPTED, Relaxed);
    }

    /// The work turns to something else.
    pub(crate) fn turn_to(&self, phase: &'static str, part: String) {
        *lock(&self.position) = Position { phase, part, detail: String::new() };
    }

    /// How far the work is.
    pub(crate) fn position(&self) -> Position {
        lock(&self.position).clone()
    }

    /// Whether it is time to do again what was last done then.
    fn due(&self, then: &AtomicU64, interval: u64) -> bool {
        let now = u64::try_from(self.started.elapsed().as_millis()).unwrap_or(u64::MAX);
        let last = then.load(Relaxed);
        now >= last.saturating_add(interval) && then.compare_exchange(last, now, Relaxed, Relaxed).is_ok()
    }

    /// Asks the work to end because the process has become too large.
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
