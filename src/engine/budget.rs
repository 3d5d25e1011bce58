//! An end of work after a number of steps of decision diagrams.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::time::Duration;

use meliora_base::error::Limit;
use meliora_base::progress::ProgressSink;

/// A progress sink that ends the work after a number of steps of decision diagrams.
pub(crate) struct Budget {
    sink: Arc<dyn ProgressSink>,
    /// The maximum number of steps.
    most: AtomicU64,
    spent: AtomicU64,
    /// True if this sink has ended the work, and not the one that it passes all on to.
    ended: AtomicBool,
}

impl Budget {
    pub(crate) fn new(steps: u64, sink: &Arc<dyn ProgressSink>) -> Self {
        let (most, spent) = (AtomicU64::new(steps), AtomicU64::new(0));
        Budget { sink: Arc::clone(sink), most, spent, ended: AtomicBool::new(false) }
    }

    pub(crate) fn has_ended(&self) -> bool {
        self.ended.load(Relaxed)
    }

    /// Returns the steps so far.
    pub(crate) fn spent(&self) -> u64 {
        self.spent.load(Relaxed)
    }

    /// Returns the steps that are left.
    pub(crate) fn left(&self) -> u64 {
        self.most.load(Relaxed).saturating_sub(self.spent())
    }

    /// Sets the most steps from now on.
    pub(crate) fn allow(&self, steps: u64) {
        self.most.store(self.spent().saturating_add(steps), Relaxed);
    }

    /// Removes the limit.
    pub(crate) fn lift(&self) {
        self.allow(u64::MAX);
        self.ended.store(false, Relaxed);
    }
}

impl ProgressSink for Budget {
    fn stop(&self) -> Option<Limit> {
        if let Some(limit) = self.sink.stop() {
            return Some(limit);
        }
        let is_spent = self.spent() >= self.most.load(Relaxed);
        self.ended.fetch_or(is_spent, Relaxed);
        is_spent.then_some(Limit::Interrupted)
    }

    fn advance(&self, steps: u64) {
        self.spent.fetch_add(steps, Relaxed);
        self.sink.advance(steps);
    }

    fn clock(&self) -> Duration {
        self.sink.clock()
    }

    fn progress(&self, phase: &'static str, detail: &dyn Fn() -> String) {
        self.sink.progress(phase, detail);
    }
}
