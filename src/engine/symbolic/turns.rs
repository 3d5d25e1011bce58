//! Several ways to the same result in turns, with budgets in steps that double.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::time::Duration;

use crate::settings::Settings;
use meliora_model::error::{Error, Limit, Result};
use meliora_model::progress::ProgressSink;

/// Returns the result of the first way that ends. In each round the first way has a budget in steps, and the others share
/// as much; the budget of a round is twice that of the round before.
///
/// Each way begins anew in each round, so all its turns take at most twice the steps of the last one. Hence the steps are
/// at most a fixed multiple of those of the best way. A way that runs out of memory has no more turns.
///
/// # Errors
/// An input error or another limit that a way meets; the memory limit of the first way if none succeeds.
pub(super) fn first_to_end<W, T>(
    ways: &[W],
    settings: &Settings,
    attempt: impl Fn(&W, Settings) -> Result<T>,
) -> Result<T> {
    let shares = |at: usize| if at == 0 { 1 } else { ways.len() as u64 - 1 };
    let mut open: Vec<usize> = (0..ways.len()).collect();
    let mut steps = settings.thresholds.first_steps;
    let mut thresholds = settings.thresholds;
    let mut full = Limit::Interrupted;
    while !open.is_empty() {
        let is_alone = open.len() == 1;
        let mut still_open = Vec::new();
        for at in open {
            let most = if is_alone { u64::MAX } else { steps / shares(at) };
            let budget = Arc::new(Budget::new(most, &settings.sink));
            let own = Settings { sink: Arc::clone(&budget) as _, thresholds, ..settings.clone() };
            match attempt(&ways[at], own) {
                Err(Error::Limit(Limit::Interrupted)) if budget.has_ended() => still_open.push(at),
                Err(Error::Limit(limit @ Limit::Memory { .. })) => {
                    if at == 0 || full == Limit::Interrupted {
                        full = limit;
                    }
                }
                result => {
                    budget.lift();
                    return result;
                }
            }
        }
        (open, steps) = (still_open, steps.saturating_mul(2));
        // Later turns have a large operation cache from the start.
        thresholds.first_steps = 0;
    }
    Err(full.into())
}

/// A progress sink that ends the work after a number of steps of decision diagrams.
struct Budget {
    sink: Arc<dyn ProgressSink>,
    /// The number of steps that are left.
    left: AtomicU64,
    /// True if this sink has ended the work, and not the one that it passes all on to.
    ended: AtomicBool,
}

impl Budget {
    fn new(steps: u64, sink: &Arc<dyn ProgressSink>) -> Self {
        Budget { sink: Arc::clone(sink), left: AtomicU64::new(steps), ended: AtomicBool::new(false) }
    }

    fn has_ended(&self) -> bool {
        self.ended.load(Relaxed)
    }

    /// Removes the limit.
    fn lift(&self) {
        self.left.store(u64::MAX, Relaxed);
    }
}

impl ProgressSink for Budget {
    fn stop(&self) -> Option<Limit> {
        if let Some(limit) = self.sink.stop() {
            return Some(limit);
        }
        let is_spent = self.left.load(Relaxed) == 0;
        self.ended.fetch_or(is_spent, Relaxed);
        is_spent.then_some(Limit::Interrupted)
    }

    fn advance(&self, steps: u64) {
        // The greatest number means no limit.
        let less = |left: u64| (left < u64::MAX).then(|| left.saturating_sub(steps));
        let _ = self.left.fetch_update(Relaxed, Relaxed, less);
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
    use std::sync::{Arc, Mutex};

    use super::{Result, Settings, first_to_end};
    use crate::settings::Count;
    use crate::symbolic::Thresholds;
    use meliora_model::error::{Error, Limit};
    use meliora_model::progress::ProgressSink;

    fn settings() -> Settings {
        Settings { thresholds: Thresholds { first_steps: 8, ..Thresholds::default() }, ..Settings::default() }
    }

    /// Takes some steps, each reported to the sink; returns the sink at the end.
    fn work(steps: u64, settings: &Settings) -> Result<Arc<dyn ProgressSink>> {
        for _ in 0..steps {
            if let Some(limit) = settings.sink.stop() {
                return Err(limit.into());
            }
            settings.sink.advance(1);
        }
        Ok(Arc::clone(&settings.sink))
    }

    fn full(what: &str) -> Error {
        Limit::Memory { what: what.to_owned() }.into()
    }

    /// The turns, by the steps that each way needs, until the first ends: the ways, and the steps of all turns.
    fn turns(needed: &[u64]) -> (Vec<u64>, u64) {
        let (turns, spent) = (Mutex::new(Vec::new()), Arc::new(Spent::default()));
        let settings = Settings { sink: Arc::clone(&spent) as _, ..settings() };
        first_to_end(needed, &settings, |way, settings| {
            turns.lock().unwrap().push(*way);
            work(*way, &settings)
        })
        .unwrap();
        let steps = *spent.0.lock().unwrap();
        (turns.into_inner().unwrap(), steps)
    }

    #[derive(Default)]
    struct Spent(Mutex<u64>);

    impl ProgressSink for Spent {
        fn advance(&self, steps: u64) {
            *self.0.lock().unwrap() += steps;
        }
    }

    #[test]
    fn the_first_way_has_the_first_budget_alone() {
        assert_eq!(turns(&[8, 1, 2]), (vec![8], 8));
    }

    #[test]
    fn the_first_way_to_end_has_the_result() {
        assert_eq!(turns(&[1000, 999, 3]), (vec![1000, 999, 3], 8 + 4 + 3));
        assert_eq!(turns(&[30, 1000, 999]).0, [30, 1000, 999, 30, 1000, 999, 30]);
    }

    #[test]
    fn the_steps_are_at_most_a_multiple_of_those_of_the_best_way() {
        for best in 9..300 {
            for at in 0..3 {
                let mut needed = [u64::MAX; 3];
                needed[at] = best;
                // The last budget is less than twice the best, all budgets of a way less than twice its last one.
                let shares = if at == 0 { 1 } else { 2 };
                assert!(turns(&needed).1 < 2 * 4 * shares * best, "{best} by way {at}");
            }
        }
    }

    #[test]
    fn the_last_way_has_no_budget() {
        assert_eq!(turns(&[1000]), (vec![1000], 1000));
        let only = |way: &u64, settings: Settings| {
            if *way == 0 { Err(full("first")) } else { work(*way, &settings).map(|_| ()) }
        };
        first_to_end(&[0, 1000], &settings(), only).unwrap();
    }

    #[test]
    fn no_budget_remains_after_the_result() {
        let sink = first_to_end(&[3, 3], &settings(), |way, settings| work(*way, &settings)).unwrap();
        sink.advance(1000);
        assert_eq!(sink.stop(), None);
    }

    #[test]
    fn other_limits_and_errors_end_all_turns() {
        let none = |error: Error| first_to_end(&[1, 2], &settings(), |_, _| Err::<(), _>(error.clone()));
        assert!(matches!(none(Limit::Interrupted.into()), Err(Error::Limit(Limit::Interrupted))));
        assert!(matches!(none(Error::Usage("x".to_owned())), Err(Error::Usage(_))));
        let all_full = first_to_end(&["a", "b"], &settings(), |way, _| Err::<Count, _>(full(way)));
        assert!(matches!(all_full, Err(Error::Limit(Limit::Memory { what })) if what == "a"));
    }
}
