//! Cancellation and progress.

use std::time::Duration;

use crate::error::Limit;

/// Cancels long work and receives its progress.
///
/// The library reads no clock and installs no handler: the caller does, and answers here.
pub trait ProgressSink: Send + Sync {
    /// Called often, from inside loops: an answer ends the work with this limit.
    fn stop(&self) -> Option<Limit> {
        None
    }

    /// The time on the caller's clock, for events that say how long something took; always 0 where the
    /// caller has no clock.
    fn clock(&self) -> Duration {
        Duration::ZERO
    }

    /// Called now and then with what is being done: a phase and its state in words.
    fn progress(&self, _phase: &'static str, _detail: &dyn Fn() -> String) {}
}

/// A sink that never stops the work and ignores its progress.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoProgress;

impl ProgressSink for NoProgress {}

/// Steps between two questions to a sink: some tens of microseconds.
const PATIENCE: u32 = 1 << 10;

/// Asks a sink once in many steps, and keeps the answer.
pub(crate) struct Poll<'o> {
    sink: &'o dyn ProgressSink,
    steps: u32,
    limit: Option<Limit>,
}

impl<'o> Poll<'o> {
    pub(crate) fn new(sink: &'o dyn ProgressSink) -> Self {
        Poll { sink, steps: 0, limit: None }
    }

    /// Who is asked.
    pub(crate) fn sink(&self) -> &'o dyn ProgressSink {
        self.sink
    }

    /// Ends the work: another one heard this.
    pub(crate) fn end(&mut self, limit: Limit) {
        self.limit.get_or_insert(limit);
    }

    /// Whether the work is to stop; to be asked at each of many small steps.
    pub(crate) fn is_over(&mut self) -> bool {
        self.steps = self.steps.wrapping_add(1);
        if self.limit.is_none() && self.steps.is_multiple_of(PATIENCE) {
            self.limit = self.sink.stop();
        }
        self.limit.is_some()
    }

    /// One of many small steps.
    ///
    /// # Errors
    /// The work is to stop.
    pub(crate) fn step(&mut self) -> Result<(), Limit> {
        if self.is_over() { self.check() } else { Ok(()) }
    }

    /// The limit that has ended the work.
    ///
    /// # Errors
    /// That limit.
    pub(crate) fn check(&self) -> Result<(), Limit> {
        self.limit.clone().map_or(Ok(()), Err)
    }
}
