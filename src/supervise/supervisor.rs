//! The state that a worker thread shares with the thread that waits for it.

use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use super::memory::{self, ALLOWANCE};
use meliora_base::error::Limit;
use meliora_base::progress::ProgressSink;
pub use meliora_base::sync::lock;

const RUNNING: u8 = 0;
const OUT_OF_TIME: u8 = 1;
const OUT_OF_MEMORY: u8 = 2;

/// The memory by which work may exceed its limit before it is left behind, in bytes. Work that asks
/// whether to stop exceeds it by less.
const GROWTH: u64 = 32 << 20;
/// The minimum time between two checks of the limits. In this time, a thread fills about 10 MiB.
pub(super) const CHECKS: Duration = Duration::from_millis(5);
/// The minimum time between two requests for details.
const DETAILS: Duration = Duration::from_millis(100);

/// A timer for actions that several threads may cause, but at most once per interval.
#[derive(Debug)]
pub struct Interval {
    started: Instant,
    /// Time of the last action in milliseconds since the start.
    last: AtomicU64,
    length: Duration,
}

impl Interval {
    /// Creates a timer; the first interval starts now.
    pub(crate) fn new(length: Duration) -> Self {
        Interval { started: Instant::now(), last: AtomicU64::new(0), length }
    }

    /// Returns true, and starts the next interval, if the interval has passed.
    fn has_passed(&self) -> bool {
        let millis = |time: Duration| u64::try_from(time.as_millis()).unwrap_or(u64::MAX);
        let (now, last) = (millis(self.started.elapsed()), self.last.load(Relaxed));
        now >= last.saturating_add(millis(self.length))
            && self.last.compare_exchange(last, now, Relaxed, Relaxed).is_ok()
    }
}

/// A time limit for one piece of work or several in a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TimeLimit {
    timeout: Duration,
    deadline: Instant,
}

impl TimeLimit {
    /// Creates a limit that starts now; `None` if the clock has no such time.
    pub fn starting_now(timeout: Duration) -> Option<Self> {
        Instant::now().checked_add(timeout).map(|deadline| TimeLimit { timeout, deadline })
    }

    /// Returns the remaining time.
    fn remaining(self) -> Duration {
        self.deadline.saturating_duration_since(Instant::now())
    }
}

/// A limit on the memory of the process.
#[derive(Debug, Clone, Copy)]
struct MemoryLimit {
    /// The memory that does not count, in bytes.
    baseline: u64,
    /// The memory of the work, in bytes.
    bytes: u64,
}

impl MemoryLimit {
    /// Returns whether the process exceeds the limit by more than some bytes.
    fn is_exceeded_by(self, more: u64) -> bool {
        let most = [self.bytes, ALLOWANCE, more].into_iter().fold(self.baseline, u64::saturating_add);
        memory::resident().is_some_and(|used| used > most)
    }

    fn reached(self) -> Limit {
        let uses = if self.baseline == 0 { "uses" } else { "has gained" };
        let (own, more) = (self.bytes >> 20, ALLOWANCE >> 20);
        Limit::Memory { what: format!("the process {uses} more than {own} MiB + {more} MiB for itself") }
    }
}

/// The position of the work.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Position {
    /// The phase: `states`, `outcomes`, `sasi`, …; empty before the first one.
    pub phase: &'static str,
    /// The part of the phase, such as `objective 2 of 5`; may be empty.
    pub part: String,
    /// The last detail from the library; may be empty.
    pub detail: String,
}

impl Position {
    /// Returns the part and the detail, separated by a comma.
    pub fn words(&self) -> String {
        joined(&[&self.part, &self.detail], ", ")
    }

    /// Returns the phase, the part and the detail, separated by dots.
    pub fn line(&self) -> String {
        joined(&[self.phase, &self.part, &self.detail], " · ")
    }
}

/// Joins the words that are not empty.
fn joined(words: &[&str], separator: &str) -> String {
    words.iter().copied().filter(|word| !word.is_empty()).collect::<Vec<_>>().join(separator)
}

#[derive(Debug, Default)]
struct Limits {
    time: Option<TimeLimit>,
    memory: Option<MemoryLimit>,
}

/// Cancels work, and follows its progress.
///
/// The work is cancelled by [`Supervisor::interrupt`], by its time limit, and when the process
/// exceeds its memory limit. The library asks for this in [`ProgressSink::stop`].
#[derive(Debug)]
pub struct Supervisor {
    started: Instant,
    interrupted: Arc<AtomicBool>,
    /// The limit that was reached.
    reached: AtomicU8,
    limits: Mutex<Limits>,
    check: Interval,
    position: Mutex<Position>,
    detail: Interval,
}

impl Default for Supervisor {
    fn default() -> Self {
        Supervisor {
            started: Instant::now(),
            interrupted: Arc::default(),
            reached: AtomicU8::new(RUNNING),
            limits: Mutex::default(),
            check: Interval::new(CHECKS),
            position: Mutex::default(),
            detail: Interval::new(DETAILS),
        }
    }
}

impl Supervisor {
    /// Creates a supervisor without limits, whose clock starts now.
    pub fn new() -> Self {
        Self::default()
    }

    /// Prepares for the next piece of work: without an interrupt, a position or a memory limit.
    pub fn reset(&self, time: Option<TimeLimit>) {
        *lock(&self.limits) = Limits { time, ..Limits::default() };
        *lock(&self.position) = Position::default();
        self.reached.store(RUNNING, Relaxed);
        self.interrupted.store(false, Relaxed);
    }

    /// Returns the end of a share of the remaining time, if `parts` such parts are left and one more; `None` without a
    /// time limit.
    pub fn share(&self, parts: usize) -> Option<Instant> {
        let all = u32::try_from(parts).ok()?.checked_add(1)?;
        lock(&self.limits).time.map(|time| Instant::now() + time.remaining() / all)
    }

    /// Returns the limit of work that has used up its share of the time.
    pub fn late(&self) -> Limit {
        Limit::Share(lock(&self.limits).time.map_or(Duration::ZERO, |time| time.timeout))
    }

    /// Limits the memory of the process to `bytes` and 64 MiB.
    pub fn limit_memory(&self, bytes: u64) {
        lock(&self.limits).memory = Some(MemoryLimit { baseline: 0, bytes });
    }

    /// Limits the memory that the process gains from now on to `bytes` and 64 MiB.
    pub fn limit_growth(&self, bytes: u64) {
        let baseline = memory::resident().unwrap_or(0);
        lock(&self.limits).memory = Some(MemoryLimit { baseline, bytes });
    }

    /// Cancels the work because the user wants it.
    pub fn interrupt(&self) {
        self.interrupted.store(true, Relaxed);
    }

    /// Returns the flag that [`Supervisor::interrupt`] sets; a signal handler can set it, too.
    pub fn interrupt_flag(&self) -> &Arc<AtomicBool> {
        &self.interrupted
    }

    /// Returns the time since the start.
    pub fn elapsed(&self) -> Duration {
        self.started.elapsed()
    }

    /// Returns the remaining time, if there is a time limit.
    pub(crate) fn remaining(&self) -> Option<Duration> {
        lock(&self.limits).time.map(TimeLimit::remaining)
    }

    /// Returns the limit of work that the user or the time limit has cancelled.
    pub(crate) fn overdue(&self) -> Option<Limit> {
        if self.interrupted.load(Relaxed) {
            return Some(Limit::Interrupted);
        }
        let time = lock(&self.limits).time.filter(|time| time.remaining().is_zero())?;
        let _ = self.reached.compare_exchange(RUNNING, OUT_OF_TIME, Relaxed, Relaxed);
        Some(Limit::Time(time.timeout))
    }

    /// Returns the memory limit if the process exceeds it so far that the work seems not to ask.
    pub(crate) fn outgrown(&self) -> Option<Limit> {
        let limit = lock(&self.limits).memory.filter(|memory| memory.is_exceeded_by(GROWTH))?;
        let _ = self.reached.compare_exchange(RUNNING, OUT_OF_MEMORY, Relaxed, Relaxed);
        Some(limit.reached())
    }

    /// Checks the limits, and stores the first one that is reached.
    fn check_limits(&self) {
        let limits = lock(&self.limits);
        let reached = match (limits.time, limits.memory) {
            (Some(time), _) if time.remaining().is_zero() => OUT_OF_TIME,
            (_, Some(memory)) if memory.is_exceeded_by(0) => OUT_OF_MEMORY,
            _ => return,
        };
        let _ = self.reached.compare_exchange(RUNNING, reached, Relaxed, Relaxed);
    }

    /// Sets the position of the work.
    pub fn set_position(&self, phase: &'static str, part: String) {
        *lock(&self.position) = Position { phase, part, detail: String::new() };
    }

    /// Sets the detail of the position.
    pub fn set_detail(&self, detail: String) {
        lock(&self.position).detail = detail;
    }

    /// Returns true at intervals, at which the details of the progress are wanted.
    pub fn wants_detail(&self) -> bool {
        self.detail.has_passed()
    }

    /// Returns the position of the work.
    pub fn position(&self) -> Position {
        lock(&self.position).clone()
    }
}

impl ProgressSink for Supervisor {
    fn stop(&self) -> Option<Limit> {
        if self.interrupted.load(Relaxed) {
            return Some(Limit::Interrupted);
        }
        if self.check.has_passed() {
            self.check_limits();
        }
        let limits = match self.reached.load(Relaxed) {
            RUNNING => return None,
            _ => lock(&self.limits),
        };
        match (self.reached.load(Relaxed), limits.memory) {
            (OUT_OF_MEMORY, Some(memory)) => Some(memory.reached()),
            _ => Some(Limit::Time(limits.time.map_or(Duration::ZERO, |time| time.timeout))),
        }
    }

    fn remaining(&self) -> Option<Duration> {
        lock(&self.limits).time.map(|time| time.remaining())
    }

    fn clock(&self) -> Duration {
        self.elapsed()
    }

    fn progress(&self, phase: &'static str, detail: &dyn Fn() -> String) {
        if self.wants_detail() {
            self.set_detail(format!("{phase}: {}", detail()));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_is_a_part_of_the_time_that_is_left() {
        let supervisor = Supervisor::new();
        assert_eq!(supervisor.share(1), None, "without a time limit");
        supervisor.reset(TimeLimit::starting_now(Duration::from_secs(3600)));
        let left = supervisor.share(3).unwrap().saturating_duration_since(Instant::now());
        assert!((899..=900).contains(&left.as_secs()), "{left:?}");
        assert_eq!(supervisor.stop(), None);
    }
}
