//! Cancellation and progress.

use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;

use crate::error::Limit;

/// Cancels long work and receives its progress.
///
/// The library reads no clock and installs no signal handler; the caller does this and answers
/// here.
pub trait ProgressSink: Send + Sync {
    /// Returns the limit that ends the work, or none to continue. Called often, from inside loops.
    fn stop(&self) -> Option<Limit> {
        None
    }

    /// Receives the number of steps of the work since the last call. A step is one of decision diagrams, or takes as long.
    fn advance(&self, _steps: u64) {}

    /// Returns the time on the caller's clock, for events with durations; always 0 if the caller
    /// has no clock.
    fn clock(&self) -> Duration {
        Duration::ZERO
    }

    /// Returns the time until a limit of the caller ends the work; `None` without a limit.
    fn remaining(&self) -> Option<Duration> {
        None
    }

    /// Ends the other ways to the same answer, if several race: the work that follows costs the same on each of them.
    /// Returns the bytes of memory that this way has from then on; `None` without a race.
    fn settle(&self) -> Option<u64> {
        None
    }

    /// Receives the progress: a phase, and its state in words.
    fn progress(&self, _phase: &'static str, _detail: &dyn Fn() -> String) {}
}

/// A sink that never stops the work and ignores its progress.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoProgress;

impl ProgressSink for NoProgress {}

/// A sink that ends the work once [`CancellationToken::cancel`] is called, from any thread.
#[derive(Debug, Default)]
pub struct CancellationToken(AtomicBool);

impl CancellationToken {
    /// Ends the work with [`Limit::Interrupted`].
    pub fn cancel(&self) {
        self.0.store(true, Relaxed);
    }
}

impl ProgressSink for CancellationToken {
    fn stop(&self) -> Option<Limit> {
        self.0.load(Relaxed).then_some(Limit::Interrupted)
    }
}

/// The number of steps between two queries of a sink; they take some tens of microseconds.
const STEPS_BETWEEN_QUERIES: u32 = 1 << 10;

/// A poll that queries a sink once in many steps, and keeps the answer.
pub struct Poll<'o> {
    sink: &'o dyn ProgressSink,
    steps: u32,
    limit: Option<Limit>,
}

impl<'o> Poll<'o> {
    /// Creates a poll that has not queried the sink yet.
    pub fn new(sink: &'o dyn ProgressSink) -> Self {
        Poll { sink, steps: 0, limit: None }
    }

    /// Returns the sink.
    pub fn sink(&self) -> &'o dyn ProgressSink {
        self.sink
    }

    /// Ends the work with a limit that another poll has received.
    pub fn end(&mut self, limit: Limit) {
        self.limit.get_or_insert(limit);
    }

    /// Returns true if the work must stop. Called in each of many small steps.
    #[inline]
    pub fn should_stop(&mut self) -> bool {
        self.steps = self.steps.wrapping_add(1);
        if self.limit.is_none() && self.steps.is_multiple_of(STEPS_BETWEEN_QUERIES) {
            self.sink.advance(STEPS_BETWEEN_QUERIES.into());
            self.limit = self.sink.stop();
        }
        self.limit.is_some()
    }

    /// Counts one of many small steps.
    ///
    /// # Errors
    /// The limit that ended the work.
    #[inline]
    pub fn step(&mut self) -> Result<(), Limit> {
        if self.should_stop() { self.check() } else { Ok(()) }
    }

    /// Checks that the work may continue, without a query.
    ///
    /// # Errors
    /// The limit that ended the work.
    pub fn check(&self) -> Result<(), Limit> {
        self.limit.clone().map_or(Ok(()), Err)
    }
}
