//! A report that is kept while it grows, for a caller who reads it when the work has ended.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use meliora_base::error::Limit;
use meliora_base::progress::ProgressSink;
use meliora_base::sync::lock;
use meliora_engine::Usage;
use meliora_question::{Answers, Listener, Warning, race};

/// A report that is kept while it grows, without times; its ways may race. The warnings are kept with it.
pub struct Kept<R> {
    state: Arc<Mutex<State<R>>>,
    sink: Arc<Shared>,
}

#[derive(Clone)]
struct State<R> {
    report: R,
    warnings: Vec<Warning>,
    /// The resources that an engine has used.
    usage: Option<Usage>,
    /// The limit that has ended the first share of the work.
    ended: Option<Limit>,
}

impl<R> Kept<R> {
    /// Begins with a report.
    pub fn new(report: R, sink: Arc<dyn ProgressSink>) -> Self {
        let limit = sink.remaining();
        let state = State { report, warnings: Vec::new(), usage: None, ended: None };
        Kept {
            state: Arc::new(Mutex::new(state)),
            sink: Arc::new(Shared { sink, limit, end: Mutex::default() }),
        }
    }
}

impl<R: Clone> Kept<R> {
    /// Returns the resources that an engine has used, as far as they are known.
    pub fn usage(&self) -> Option<Usage> {
        lock(&self.state).usage
    }

    /// Returns the report so far, and the warnings.
    pub fn known(&self) -> (R, Vec<Warning>) {
        let State { report, warnings, .. } = lock(&self.state).clone();
        (report, warnings)
    }
}

impl<R> Kept<R> {
    pub(super) fn change(&self, change: &mut dyn FnMut(&mut R)) {
        change(&mut lock(&self.state).report);
    }

    pub(super) fn warn(&self, warning: Warning) {
        lock(&self.state).warnings.push(warning);
    }

    pub(super) fn sink(&self) -> Arc<dyn ProgressSink> {
        Arc::clone(&self.sink) as _
    }

    /// Limits the work that follows to its share of the remaining time, if `parts` such parts are left and one more;
    /// `None` ends this limit.
    pub(super) fn share(&self, parts: Option<usize>) {
        let parts = parts.and_then(|parts| u32::try_from(parts).ok()?.checked_add(1));
        let left = parts.and_then(|parts| Some(self.sink.remaining()? / parts));
        *lock(&self.sink.end) = left.map(|left| self.sink.clock() + left);
    }
}

impl<R: Clone + Send> race::Job for Kept<R> {
    fn copy(&self) -> Self {
        let state = Arc::new(Mutex::new(lock(&self.state).clone()));
        Kept { state, sink: Arc::clone(&self.sink) }
    }

    fn of_way(&self, _: usize) -> Self {
        let Shared { sink, limit, end } = &*self.sink;
        let (sink, end) = (Arc::clone(sink), Mutex::new(*lock(end)));
        Kept { sink: Arc::new(Shared { sink, limit: *limit, end }), ..self.copy() }
    }

    fn sink(&self) -> Arc<dyn ProgressSink> {
        Kept::sink(self)
    }

    fn leave_to(&self, way: Self) -> Self {
        Kept { state: Arc::clone(&self.state), sink: way.sink }
    }

    fn take(&self, other: &Self) {
        if !Arc::ptr_eq(&self.state, &other.state) {
            let state = lock(&other.state).clone();
            *lock(&self.state) = state;
        }
    }
}

impl Listener for Kept<Answers> {
    fn change(&self, change: &mut dyn FnMut(&mut Answers)) {
        Kept::change(self, change);
    }

    fn used(&self, usage: Usage) {
        let known = &mut lock(&self.state).usage;
        *known = Some(match *known {
            Some(known) if known.peak_nodes > usage.peak_nodes => known,
            _ => usage,
        });
    }

    fn begin(&self, _: &'static str) {}

    fn end(&self, _: &'static str, _: &'static str) {}

    fn warn(&self, warning: Warning) {
        Kept::warn(self, warning);
    }

    fn stop(&self) -> Option<Limit> {
        self.sink.sink.stop()
    }

    fn share(&self, parts: Option<usize>) {
        Kept::share(self, parts);
    }

    fn end_share(&self, limit: Limit) {
        lock(&self.state).ended.get_or_insert(limit);
    }

    fn ended_share(&self) -> Option<Limit> {
        lock(&self.state).ended.take()
    }
}

/// The sink of the caller, with the end of a share of the time.
struct Shared {
    sink: Arc<dyn ProgressSink>,
    /// The time that all of the work has.
    limit: Option<Duration>,
    /// The end of the share on the clock of the caller.
    end: Mutex<Option<Duration>>,
}

impl ProgressSink for Shared {
    fn stop(&self) -> Option<Limit> {
        let is_late = || lock(&self.end).is_some_and(|end| end <= self.sink.clock());
        let late = || is_late().then(|| Limit::Share(self.limit.unwrap_or_default()));
        self.sink.stop().or_else(late)
    }

    fn advance(&self, steps: u64) {
        self.sink.advance(steps);
    }

    fn clock(&self) -> Duration {
        self.sink.clock()
    }

    fn remaining(&self) -> Option<Duration> {
        self.sink.remaining()
    }

    fn settle(&self) -> Option<u64> {
        self.sink.settle()
    }

    fn progress(&self, phase: &'static str, detail: &dyn Fn() -> String) {
        self.sink.progress(phase, detail);
    }
}
