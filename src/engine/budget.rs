//! An end of work, or a pause in it, after a number of steps of decision diagrams.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use meliora_base::error::Limit;
use meliora_base::progress::ProgressSink;

/// A progress sink that ends the work after a number of steps of decision diagrams, or lets it wait for its next turn.
pub(crate) struct Budget {
    sink: Arc<dyn ProgressSink>,
    /// The maximum number of steps.
    most: AtomicU64,
    spent: AtomicU64,
    /// True if this sink has ended the work, and not the one that it passes all on to.
    ended: AtomicBool,
    phase: Mutex<Phase>,
    changed: Condvar,
}

/// The state of work, for another thread that gives it its turns.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// Nobody gives it turns: it ends when no steps are left.
    Alone,
    Runs,
    Waits,
    Done,
}

impl Budget {
    pub(crate) fn new(steps: u64, sink: &Arc<dyn ProgressSink>) -> Self {
        let (most, spent) = (AtomicU64::new(steps), AtomicU64::new(0));
        let (phase, changed) = (Mutex::new(Phase::Alone), Condvar::new());
        Budget { sink: Arc::clone(sink), most, spent, ended: AtomicBool::new(false), phase, changed }
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
        self.ended.store(false, Relaxed);
    }

    /// Removes the limit.
    pub(crate) fn lift(&self) {
        self.allow(u64::MAX);
    }

    /// Lets work in another thread wait for its turns from now on.
    pub(crate) fn begin_turns(&self) {
        drop(self.enter(Phase::Waits));
    }

    /// Gives work in another thread a turn, and waits until it has taken the steps or is done. Returns whether it is
    /// done; see [`Budget::done`].
    pub(crate) fn give_turn(&self, steps: u64) -> bool {
        self.allow(steps);
        let phase = self.enter(Phase::Runs);
        let is_running = |phase: &mut Phase| *phase == Phase::Runs;
        let phase = self.changed.wait_while(phase, is_running).unwrap_or_else(PoisonError::into_inner);
        *phase == Phase::Done
    }

    /// Returns a value whose end tells that the work of this thread is done.
    pub(crate) fn done(&self) -> impl Drop + '_ {
        struct Done<'b>(&'b Budget);
        impl Drop for Done<'_> {
            fn drop(&mut self) {
                let mut phase = self.0.phase();
                // After the end of all turns, other work has the budget.
                if *phase != Phase::Alone {
                    *phase = Phase::Done;
                    self.0.changed.notify_all();
                }
            }
        }
        Done(self)
    }

    /// Lets work end that waits for a turn: from now on it has none.
    pub(crate) fn end_turns(&self) {
        drop(self.enter(Phase::Alone));
    }

    fn enter(&self, phase: Phase) -> MutexGuard<'_, Phase> {
        let mut now = self.phase();
        *now = phase;
        self.changed.notify_all();
        now
    }

    fn phase(&self) -> MutexGuard<'_, Phase> {
        self.phase.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for the next turn of work that has turns. Returns whether there is one.
    fn waits(&self) -> bool {
        if *self.phase() == Phase::Alone {
            return false;
        }
        let phase = self.enter(Phase::Waits);
        let is_waiting = |phase: &mut Phase| *phase == Phase::Waits;
        let phase = self.changed.wait_while(phase, is_waiting).unwrap_or_else(PoisonError::into_inner);
        *phase == Phase::Runs
    }
}

impl ProgressSink for Budget {
    fn stop(&self) -> Option<Limit> {
        if let Some(limit) = self.sink.stop() {
            return Some(limit);
        }
        if self.left() > 0 || self.waits() {
            return None;
        }
        self.ended.store(true, Relaxed);
        Some(Limit::Interrupted)
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

#[cfg(test)]
mod tests {
    use super::*;
    use meliora_base::progress::NoProgress;

    fn budget() -> Budget {
        let sink: Arc<dyn ProgressSink> = Arc::new(NoProgress);
        Budget::new(0, &sink)
    }

    /// Takes steps until the budget ends them, at most `most`.
    fn work(budget: &Budget, most: u64) -> u64 {
        let _done = budget.done();
        (0..most).take_while(|_| budget.stop().is_none()).inspect(|_| budget.advance(1)).count() as u64
    }

    #[test]
    fn work_continues_where_its_last_turn_ended() {
        let budget = budget();
        budget.begin_turns();
        std::thread::scope(|scope| {
            let run = scope.spawn(|| work(&budget, 10));
            assert!(!budget.give_turn(4));
            assert_eq!(budget.spent(), 4);
            assert!(!budget.give_turn(5));
            assert!(budget.give_turn(5));
            assert_eq!(run.join().unwrap(), 10);
        });
        assert!(!budget.has_ended());
    }

    #[test]
    fn work_without_more_turns_ends() {
        let budget = budget();
        budget.begin_turns();
        std::thread::scope(|scope| {
            let run = scope.spawn(|| work(&budget, 10));
            assert!(!budget.give_turn(3));
            budget.end_turns();
            assert_eq!(run.join().unwrap(), 3);
        });
        assert!(budget.has_ended());
        budget.allow(2);
        assert_eq!(work(&budget, 10), 2, "the next work has no turns either");
    }
}
