//! Independent pieces of work on several threads that share no diagrams.
//!
//! Threads that make nodes in one store wait for each other. Therefore each thread has an engine of
//! its own, a *worker* ([`Engine::workers`]), and the sets of each piece are copied to the worker
//! and back. Results do not depend on the number of workers.

use std::panic::resume_unwind;
use std::sync::{Mutex, PoisonError};
use std::thread;

use super::edge_labels::EdgeLabels;
use super::engine::{Engine, Region};
use meliora_base::error::{Error, Limit, Result};

/// State sets and choice sets of one engine.
pub struct Sets<S, C> {
    /// The state sets.
    pub states: Vec<S>,
    /// The choice sets.
    pub choices: Vec<C>,
}

/// Visits the sets of a value one after the other: gathers them, or replaces them by others.
pub struct Port<E: Engine> {
    gathered: Sets<E::States, E::Choices>,
    states: std::vec::IntoIter<E::States>,
    choices: std::vec::IntoIter<E::Choices>,
}

impl<E: Engine> Port<E> {
    /// Replaces sets by these in their order; gathers the sets for which none is left.
    fn new(by: Sets<E::States, E::Choices>) -> Self {
        let gathered = Sets { states: Vec::new(), choices: Vec::new() };
        Port { gathered, states: by.states.into_iter(), choices: by.choices.into_iter() }
    }

    /// Gathers all sets.
    fn gather() -> Self {
        Port::new(Sets { states: Vec::new(), choices: Vec::new() })
    }

    /// Returns the set that replaces X, or X.
    pub fn states(&mut self, x: &E::States) -> E::States {
        // If a set is missing, X remains foreign to the engine, which refuses it.
        self.states.next().unwrap_or_else(|| {
            self.gathered.states.push(x.clone());
            x.clone()
        })
    }

    /// Returns the set that replaces C, or C.
    pub fn choices(&mut self, c: &E::Choices) -> E::Choices {
        self.choices.next().unwrap_or_else(|| {
            self.gathered.choices.push(c.clone());
            c.clone()
        })
    }
}

/// A value that contains sets of an engine.
pub trait Portable<E: Engine>: Sized {
    /// Returns the same value with each set as the port returns it, in a fixed order.
    fn ported(&self, port: &mut Port<E>) -> Self;
}

impl<E: Engine, T: Portable<E>> Portable<E> for Option<T> {
    fn ported(&self, port: &mut Port<E>) -> Self {
        self.as_ref().map(|value| value.ported(port))
    }
}

impl<E: Engine, T: Portable<E>> Portable<E> for Vec<T> {
    fn ported(&self, port: &mut Port<E>) -> Self {
        self.iter().map(|value| value.ported(port)).collect()
    }
}

impl<E: Engine> Portable<E> for EdgeLabels<E::States> {
    fn ported(&self, port: &mut Port<E>) -> Self {
        let EdgeLabels { from, goal, dropped, barred } = self;
        let barred = barred.iter().map(|(from, into)| (port.states(from), port.states(into))).collect();
        EdgeLabels { from: port.states(from), goal: port.states(goal), dropped: port.states(dropped), barred }
    }
}

impl<E: Engine> Portable<E> for Region<E::States, E::Choices> {
    fn ported(&self, port: &mut Port<E>) -> Self {
        Region { states: port.states(&self.states), choices: port.choices(&self.choices) }
    }
}

/// Copies a value of one engine to another engine of the same model.
fn copied<E: Engine, T: Portable<E>>(from: &E, to: &E, value: &T) -> Result<T> {
    let mut port = Port::gather();
    value.ported(&mut port);
    let sets = to.adopt(from, port.gathered)?;
    Ok(value.ported(&mut Port::new(sets)))
}

/// Returns a copy of a value, with the same sets.
pub fn same<E: Engine, T: Portable<E>>(value: &T) -> T {
    value.ported(&mut Port::gather())
}

/// A piece of work that a thread has begun: its number, its result and how it ended.
type Ended<T> = (usize, Result<T>, Result<()>);

/// Does `work` on each job, next to each other if the engine has workers, else one after the other.
///
/// The engine begins with the first job, and the workers begin with the last one. The longest job is
/// therefore best the first one: its sets are not copied. Jobs that share intermediate results are
/// best neighbours, because threads do not share them.
///
/// Each job comes with its result so far, which `work` completes. After an error, results found so
/// far remain, and `work` must be able to continue from them: if the memory does not suffice for
/// all workers, the rest is done on `engine` alone, without workers.
///
/// # Errors
/// The first error in the order of the jobs.
pub fn run<E, J, T>(
    engine: &E,
    jobs: &mut [(J, T)],
    work: impl Fn(&E, &J, &mut T) -> Result<()> + Sync,
) -> Result<()>
where
    E: Engine,
    J: Portable<E> + Sync,
    T: Portable<E> + Send + Sync,
{
    if jobs.len() <= 1 || engine.workers() == 0 {
        return jobs.iter_mut().try_for_each(|(job, result)| work(engine, job, result));
    }
    let mut ends: Vec<Option<Result<()>>> = jobs.iter().map(|_| None).collect();
    for (at, result, end) in side_by_side(engine, jobs, &work) {
        ends[at] = Some(result.map(|result| jobs[at].1 = result).and(end));
    }
    if let Some(error) =
        ends.iter_mut().find_map(|end| end.take_if(|end| matches!(end, Err(e) if !is_memory(e))))
    {
        return error;
    }
    if ends.iter().any(|end| !matches!(end, Some(Ok(())))) {
        engine.dismiss_workers(true);
    }
    let mut open = jobs.iter_mut().zip(ends).filter(|(_, end)| !matches!(end, Some(Ok(()))));
    open.try_for_each(|((job, result), _)| work(engine, job, result))
}

/// Distributes the jobs to the engine and its workers. Returns all that were begun.
fn side_by_side<E, J, T>(
    engine: &E,
    jobs: &[(J, T)],
    work: &(impl Fn(&E, &J, &mut T) -> Result<()> + Sync),
) -> Vec<Ended<T>>
where
    E: Engine,
    J: Portable<E> + Sync,
    T: Portable<E> + Send + Sync,
{
    let mut open = jobs.iter().enumerate();
    let first = open.next();
    let open = Mutex::new(open);
    let next = |from_end: bool| {
        let mut open = open.lock().unwrap_or_else(PoisonError::into_inner);
        if from_end { open.next_back() } else { open.next() }
    };
    let turns = |worker: &E, first: Option<(usize, &(J, T))>, from_end: bool| {
        let (mut found, mut begun) = (Vec::new(), first);
        while let Some((at, (job, so_far))) = begun {
            let (result, end) = on_worker(engine, worker, (job, so_far), work);
            if result.is_err() || end.is_err() {
                // Leaves no job to the other threads.
                while next(from_end).is_some() {}
            }
            found.push((at, result, end));
            begun = next(from_end);
        }
        found
    };
    thread::scope(|scope| {
        let (turns, next) = (&turns, &next);
        // If there is no memory for a worker, or no thread, the others do its work.
        let start = |number| {
            let turns = move || match engine.worker(number) {
                Some(worker) => turns(&worker, next(true), true),
                None => Vec::new(),
            };
            thread::Builder::new().spawn_scoped(scope, turns).ok()
        };
        let threads = Vec::from_iter((0..engine.workers()).take(jobs.len() - 1).filter_map(start));
        let mut found = turns(engine, first, false);
        for thread in threads {
            found.extend(thread.join().unwrap_or_else(|panic| resume_unwind(panic)));
        }
        found
    })
}

/// Does one job on a worker. Returns its result as one of `engine`, and how it ended.
fn on_worker<E: Engine, J: Portable<E>, T: Portable<E>>(
    engine: &E,
    worker: &E,
    (job, so_far): (&J, &T),
    work: &impl Fn(&E, &J, &mut T) -> Result<()>,
) -> (Result<T>, Result<()>) {
    let copies = copied(engine, worker, job).and_then(|job| Ok((job, copied(engine, worker, so_far)?)));
    match copies {
        Ok((job, mut result)) => {
            let end = work(worker, &job, &mut result);
            (copied(worker, engine, &result), end)
        }
        Err(error) => (Err(error), Ok(())),
    }
}

fn is_memory(error: &Error) -> bool {
    matches!(error, Error::Limit(Limit::Memory { .. }))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

    use super::{Port, Portable, run};
    use crate::engine::Engine;
    use crate::settings::Settings;
    use crate::symbolic::SymbolicEngine;
    use crate::symbolic::{StateSet, Thresholds};
    use meliora_base::error::{Error, Limit, Result, SourceFile};
    use meliora_lang as lang;

    struct One(StateSet);

    impl Portable<SymbolicEngine> for One {
        fn ported(&self, port: &mut Port<SymbolicEngine>) -> Self {
            One(port.states(&self.0))
        }
    }

    fn engine() -> SymbolicEngine {
        let text = "mdp module m x : [0..9]; [] x<9 -> (x'=x+1); endmodule";
        let none = SourceFile::new("constants", "");
        let program = lang::load(&SourceFile::new("m", text), &none).unwrap().program;
        let thresholds = Thresholds { nodes_for_threads: 0, ..Thresholds::default() };
        let settings = Settings { threads: 3, thresholds, memory: 64 << 20, ..Settings::default() };
        SymbolicEngine::new(Arc::new(program), settings).unwrap()
    }

    /// Fails in workers, after all threads have begun a job, with an error.
    fn failing(error: fn() -> Error) -> (SymbolicEngine, Result<()>, Vec<Option<One>>) {
        let engine = engine();
        assert_eq!(engine.workers(), 2);
        let states = (0..8).map(|x| (One(engine.singleton(&[x]).unwrap()), None));
        let (mut jobs, begun) = (Vec::from_iter(states), AtomicUsize::new(0));
        let end = run(&engine, &mut jobs, |own, One(x), found| {
            begun.fetch_add(1, Relaxed);
            while begun.load(Relaxed) < 3 {
                std::thread::yield_now();
            }
            if own.settings().threads == 1 {
                return Err(error());
            }
            *found = Some(One(own.post(&own.choices_in(&own.all_choices(), x)?)?));
            Ok(())
        });
        (engine, end, jobs.into_iter().map(|(_, found)| found).collect())
    }

    #[test]
    fn the_rest_is_done_without_workers_if_they_run_out_of_memory() {
        let (engine, end, found) = failing(|| Limit::Memory { what: String::new() }.into());
        end.unwrap();
        for (x, found) in found.into_iter().enumerate() {
            let next = engine.list_states(&found.unwrap().0, 2).unwrap();
            assert_eq!(next, [[x as i64 + 1]]);
        }
        assert!(engine.workers() == 0);
    }

    #[test]
    fn an_error_of_a_worker_is_the_error_of_the_run_and_results_before_it_remain() {
        let (engine, end, found) = failing(|| Limit::Interrupted.into());
        assert!(matches!(end, Err(Error::Limit(Limit::Interrupted))));
        // The thread that called completes its first job, and others until a worker has failed.
        // No worker completes any.
        let complete = found.iter().flatten().count();
        assert!((1..=6).contains(&complete), "{complete} jobs");
        assert_eq!(engine.workers(), 2);
    }
}
