//! Several ways to the same diagrams in turns.

use std::sync::Arc;

use crate::budget::Budget;
use crate::schedule::{Schedule, Turn};
use crate::settings::Settings;
use meliora_base::error::{Error, Limit, Result};

/// Ways to the same result, each with its turns of a [`Schedule`]. A way begins anew in each turn. A way that runs out
/// of memory has no more turns.
pub(super) struct Turns<W> {
    ways: Vec<W>,
    settings: Settings,
    schedule: Schedule,
    /// The steps of all turns so far.
    work: u64,
    /// For each way its memory limit, once it has met it.
    full: Vec<Option<Limit>>,
}

impl<W> Turns<W> {
    pub(super) fn new(ways: Vec<W>, settings: Settings) -> Self {
        let schedule = Schedule::new(ways.len(), settings.thresholds.first_turn);
        let full = ways.iter().map(|_| None).collect();
        Turns { ways, settings, schedule, work: 0, full }
    }

    /// Takes turns until the first way ends, or the steps of all turns so far are at least `most`.
    ///
    /// # Errors
    /// An input error or another limit that a way meets; the memory limit of the first way if none succeeds.
    pub(super) fn run<T>(
        &mut self,
        most: u64,
        mut attempt: impl FnMut(&W, Settings) -> Result<T>,
    ) -> Result<Option<T>> {
        while self.work < most {
            let Some(Turn { way, steps }) = self.schedule.next() else {
                let full = self.full.iter_mut().find_map(Option::take);
                return Err(full.unwrap_or(Limit::Interrupted).into());
            };
            // The last way has no budget of its own.
            let steps = if steps == u64::MAX { most - self.work } else { steps };
            let budget = Arc::new(Budget::new(steps, &self.settings.sink));
            let own = Settings { sink: Arc::clone(&budget) as _, ..self.settings.clone() };
            let result = attempt(&self.ways[way], own);
            self.work = self.work.saturating_add(budget.spent());
            match result {
                Err(Error::Limit(Limit::Interrupted)) if budget.has_ended() => {}
                Err(Error::Limit(limit @ Limit::Memory { .. })) => {
                    self.full[way] = Some(limit);
                    self.schedule.withdraw(way);
                }
                result => {
                    budget.lift();
                    return result.map(Some);
                }
            }
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::{Result, Settings, Turns};
    use crate::settings::Count;
    use crate::symbolic::Thresholds;
    use meliora_base::error::{Error, Limit};
    use meliora_base::progress::ProgressSink;

    fn turns<W>(ways: impl Into<Vec<W>>) -> Turns<W> {
        let thresholds = Thresholds { first_turn: 8, ..Thresholds::default() };
        Turns::new(ways.into(), Settings { thresholds, ..Settings::default() })
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

    #[test]
    fn a_way_that_is_out_of_memory_leaves_the_turns_to_the_others() {
        let only = |way: &u64, settings: Settings| {
            if *way == 0 { Err(full("first")) } else { work(*way, &settings).map(|_| ()) }
        };
        assert!(turns([0, 1000]).run(u64::MAX, only).unwrap().is_some());
    }

    #[test]
    fn turns_go_on_where_they_were_interrupted() {
        for ways in [vec![100], vec![1000, 100], vec![100, 1000]] {
            let mut turns = turns(ways);
            let mut most = 0;
            while turns.run(most, |way, settings| work(*way, &settings)).unwrap().is_none() {
                assert!(turns.work >= most && turns.work < 2 * most + 8, "{} of {most}", turns.work);
                most = 2 * most + 1;
                assert!(most < 2_000);
            }
        }
    }

    #[test]
    fn no_budget_remains_after_the_result() {
        let sink = turns([3, 3]).run(u64::MAX, |way, settings| work(*way, &settings)).unwrap().unwrap();
        sink.advance(1000);
        assert_eq!(sink.stop(), None);
    }

    #[test]
    fn other_limits_and_errors_end_all_turns() {
        let none = |error: Error| turns([1, 2]).run(u64::MAX, |_, _| Err::<(), _>(error.clone()));
        assert!(matches!(none(Limit::Interrupted.into()), Err(Error::Limit(Limit::Interrupted))));
        assert!(matches!(none(Error::Usage("x".to_owned())), Err(Error::Usage(_))));
        let all_full = turns(["a", "b"]).run(u64::MAX, |way, _| Err::<Count, _>(full(way)));
        assert!(matches!(all_full, Err(Error::Limit(Limit::Memory { what })) if what == "a"));
    }
}
