//! Long calls on worker threads, while the caller's thread handles signals and progress.
//!
//! Each exploration has one worker, for all objects that belong to it. A worker runs one call at a
//! time; calls from other threads wait for their turn. A worker thread never uses Python, so it can
//! be left behind if it does not stop at once; the worker stays taken until the thread has stopped.

use std::sync::atomic::{AtomicBool, Ordering::AcqRel, Ordering::Acquire, Ordering::Release};
use std::sync::{Arc, Mutex};
use std::thread::ThreadId;
use std::time::Duration;

use meliora::Error;
use meliora::supervise::{self, Position, Reporter, Supervisor, TimeLimit, lock, parse_duration};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyBool;

use crate::errors::{self, Failure};
use crate::progress::Callback;

/// The interval at which another thread checks if the worker is free.
const NAP: Duration = Duration::from_millis(2);

/// The worker of an exploration.
pub(crate) struct Worker {
    pub(crate) supervisor: Arc<Supervisor>,
    /// The memory limit of the work, in bytes.
    memory: u64,
    taken: AtomicBool,
    /// The thread that waits for the work.
    caller: Mutex<Option<ThreadId>>,
    process: u32,
}

/// The right to use a worker, until it is dropped.
struct Turn(Arc<Worker>);

impl Drop for Turn {
    fn drop(&mut self) {
        *lock(&self.0.caller) = None;
        self.0.taken.store(false, Release);
    }
}

/// The limits and the progress callback of a call.
pub(crate) struct Call {
    limit: Option<TimeLimit>,
    callback: Callback,
}

impl Call {
    /// Creates a call that begins now. `timeout` is a number of seconds, or a text such as `5s`.
    ///
    /// # Errors
    /// The timeout is not a duration.
    pub(crate) fn new(timeout: Option<&Bound<'_, PyAny>>, progress: Option<Py<PyAny>>) -> PyResult<Self> {
        let limit = timeout.map(duration).transpose()?.and_then(TimeLimit::starting_now);
        Ok(Call { limit, callback: Callback::new(progress) })
    }

    /// Creates a call without a time limit and a callback.
    pub(crate) fn plain() -> Self {
        Call { limit: None, callback: Callback::new(None) }
    }
}

fn duration(given: &Bound<'_, PyAny>) -> PyResult<Duration> {
    if let Ok(text) = given.extract::<String>() {
        return parse_duration(&text).map_err(|wrong| errors::usage(format!("timeout={text:?}: {wrong}")));
    }
    let seconds = given.extract::<f64>().ok().filter(|_| !given.is_instance_of::<PyBool>());
    if seconds == Some(f64::INFINITY) {
        // As long as a time can be.
        return Ok(Duration::MAX);
    }
    let seconds = seconds.and_then(|s| Duration::try_from_secs_f64(s).ok());
    seconds.ok_or_else(|| {
        errors::usage(format!("timeout={given}: a number of seconds from 0, or a text such as \"5s\""))
    })
}

impl Worker {
    pub(crate) fn new(memory: u64) -> Arc<Self> {
        Arc::new(Worker {
            supervisor: Arc::new(Supervisor::new()),
            memory,
            taken: AtomicBool::new(false),
            caller: Mutex::new(None),
            process: std::process::id(),
        })
    }

    /// Waits for this call's turn, and checks for signals.
    fn turn(self: &Arc<Self>, py: Python<'_>) -> PyResult<Turn> {
        if self.process != std::process::id() {
            let message = "this was explored before the process was forked, and does not work in the child: \
                explore in the child, or start processes by `spawn`";
            return Err(PyRuntimeError::new_err(message));
        }
        let this = std::thread::current().id();
        loop {
            if self.taken.compare_exchange(false, true, AcqRel, Acquire).is_ok() {
                *lock(&self.caller) = Some(this);
                return Ok(Turn(Arc::clone(self)));
            }
            if *lock(&self.caller) == Some(this) {
                let message = "a progress callback or signal handler cannot use what it interrupts";
                return Err(PyRuntimeError::new_err(message));
            }
            py.detach(|| std::thread::sleep(NAP));
            py.check_signals()?;
        }
    }

    /// Runs short work on the caller's thread, without releasing the interpreter.
    ///
    /// # Errors
    /// The errors of the work; an exception of a signal handler while waiting for the turn.
    pub(crate) fn quick<T>(
        self: &Arc<Self>,
        py: Python<'_>,
        work: impl FnOnce() -> Result<T, Error>,
    ) -> PyResult<T> {
        let turn = self.turn(py)?;
        self.supervisor.reset(None);
        let result = work();
        drop(turn);
        result.map_err(|error| Failure::of(error).raise(py))
    }

    /// Runs work without a time limit; it can be interrupted.
    ///
    /// # Errors
    /// The errors of the work; `KeyboardInterrupt`, or any other exception of a signal handler.
    pub(crate) fn long<T: Send + 'static>(
        self: &Arc<Self>,
        py: Python<'_>,
        work: impl FnOnce() -> Result<T, Error> + Send + 'static,
    ) -> PyResult<T> {
        self.run(py, &Call::plain(), |_| work()).map_err(|failure| failure.raise(py))
    }

    /// Runs the work of a call, which calls it `phase`.
    ///
    /// # Errors
    /// See [`Worker::run`].
    pub(crate) fn phase<T: Send + 'static>(
        self: &Arc<Self>,
        py: Python<'_>,
        call: &Call,
        phase: &'static str,
        work: impl FnOnce() -> Result<T, Error> + Send + 'static,
    ) -> PyResult<T> {
        let work = move |reporter: &Reporter<'_>| {
            reporter.report(phase, String::new());
            work()
        };
        self.run(py, call, work).map_err(|failure| failure.raise(py))
    }

    /// Runs the work of a call.
    ///
    /// # Errors
    /// The errors of the work; the time of the call is up; an exception of a signal handler or the
    /// callback.
    pub(crate) fn run<T: Send + 'static>(
        self: &Arc<Self>,
        py: Python<'_>,
        call: &Call,
        work: impl FnOnce(&Reporter<'_>) -> Result<T, Error> + Send + 'static,
    ) -> Result<T, Failure> {
        let turn = self.turn(py)?;
        self.supervisor.reset(call.limit);
        self.supervisor.limit_growth(self.memory);
        let in_turn = move |reporter: &Reporter<'_>| {
            let _turn = turn;
            work(reporter)
        };
        let thread = supervise::spawn(&self.supervisor, in_turn).map_err(Failure::of)?;
        let attend = |position: &Position| {
            Python::attach(|py| {
                call.callback.call(py, position)?;
                py.check_signals()
            })
        };
        let end = py.detach(|| thread.wait(attend));
        // A thread that was left behind keeps the turn, but nobody waits for it.
        lock(&self.caller).take_if(|caller| *caller == std::thread::current().id());
        end.map_err(|failure| match failure {
            supervise::Failure::Cancelled(raised) => Failure::from(raised),
            supervise::Failure::Panic(message) => Failure::panic(&message),
            supervise::Failure::Error(error) => Failure::of(error).at(self.supervisor.position()),
        })
    }
}
