//! Worker threads for long calls, while the caller's thread handles signals, time and progress.
//!
//! Each exploration has one worker, for all objects that belong to it. A worker runs one call at a
//! time; calls from other threads wait for their turn. A worker thread never uses Python, so it can
//! be left behind if it does not stop at once; the worker stays taken until the thread has stopped.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering::AcqRel, Ordering::Acquire, Ordering::Release};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex};
use std::thread::ThreadId;
use std::time::{Duration, Instant};

use meliora::{Error, Limit};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::errors::{self, Failure};
use crate::progress::Listener;
use crate::watch::{Position, Watch, lock};

/// The time that a worker thread gets to stop after it was cancelled.
const GRACE: Duration = Duration::from_millis(250);
/// The interval at which signals are checked.
const TICK: Duration = Duration::from_millis(50);
/// The interval at which another thread checks if the worker is free.
const NAP: Duration = Duration::from_millis(2);
/// The stack of a worker thread, in bytes. Recursion is as deep as expressions and diagrams; the
/// system maps pages of the stack only when they are used.
const STACK: usize = 512 << 20;

/// The worker of an exploration.
pub(crate) struct Worker {
    pub(crate) watch: Arc<Watch>,
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
    timeout: Option<Duration>,
    deadline: Option<Instant>,
    listener: Listener,
}

impl Call {
    /// Creates a call that begins now.
    ///
    /// # Errors
    /// The timeout is not a duration.
    pub(crate) fn new(timeout: Option<f64>, progress: Option<Py<PyAny>>) -> PyResult<Self> {
        let timeout = timeout.map(|seconds| {
            Duration::try_from_secs_f64(seconds)
                .map_err(|_| errors::usage(format!("timeout={seconds}: not a number of seconds")))
        });
        let timeout = timeout.transpose()?;
        let deadline = timeout.and_then(|t| Instant::now().checked_add(t));
        Ok(Call { timeout, deadline, listener: Listener::new(progress) })
    }

    /// Creates a call without a time limit and a callback.
    pub(crate) fn plain() -> Self {
        Call { timeout: None, deadline: None, listener: Listener::new(None) }
    }

    fn left(&self) -> Option<Duration> {
        self.deadline.map(|end| end.saturating_duration_since(Instant::now()))
    }
}

/// A message of a worker thread.
enum News<T> {
    Step(Position),
    Done(Result<T, Halt>),
}

/// The reason why a worker thread ended early.
enum Halt {
    Error(Error),
    Panic(String),
}

/// The sender through which a worker thread reports its position.
pub(crate) struct Teller<'d> {
    watch: &'d Watch,
    tell: Box<dyn Fn(Position) + 'd>,
}

impl Teller<'_> {
    /// Reports that the work turns to a part of a phase.
    pub(crate) fn turn_to(&self, phase: &'static str, part: String) {
        self.watch.turn_to(phase, part.clone());
        (self.tell)(Position { phase, part, detail: String::new() });
    }
}

impl Worker {
    pub(crate) fn new(memory: u64) -> Arc<Self> {
        Arc::new(Worker {
            watch: Arc::new(Watch::new()),
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
        self.watch.disarm();
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

    /// Runs the work of a call.
    ///
    /// # Errors
    /// The errors of the work; the time of the call is up; an exception of a signal handler or the
    /// callback.
    pub(crate) fn run<T: Send + 'static>(
        self: &Arc<Self>,
        py: Python<'_>,
        call: &Call,
        work: impl FnOnce(&Teller<'_>) -> Result<T, Error> + Send + 'static,
    ) -> Result<T, Failure> {
        let turn = self.turn(py)?;
        self.watch.arm(self.memory, call.timeout);
        // Without a queue: the work waits while a callback is told what it turns to.
        let (sender, news) = sync_channel(0);
        self.start(turn, sender, work)?;
        let news = Mutex::new(news);
        self.wait(py, call, &news)
    }

    /// Starts a worker thread, which returns the turn when it ends.
    fn start<T: Send + 'static>(
        self: &Arc<Self>,
        turn: Turn,
        sender: SyncSender<News<T>>,
        work: impl FnOnce(&Teller<'_>) -> Result<T, Error> + Send + 'static,
    ) -> Result<(), Failure> {
        let body = move || {
            let watch = Arc::clone(&turn.0.watch);
            // The receiver is gone if the caller has given up waiting.
            let tell = |position| drop(sender.send(News::Step(position)));
            let teller = Teller { watch: &watch, tell: Box::new(tell) };
            let end = match catch_unwind(AssertUnwindSafe(|| work(&teller))) {
                Ok(result) => result.map_err(Halt::Error),
                Err(panic) => Err(Halt::Panic(errors::panic_message(&*panic))),
            };
            drop(teller);
            drop(turn);
            let _ = sender.send(News::Done(end));
        };
        match std::thread::Builder::new().name("meliora".to_owned()).stack_size(STACK).spawn(body) {
            Ok(_) => Ok(()),
            Err(e) => {
                let what = format!("a thread with a stack of {} MiB ({e})", STACK >> 20);
                Err(Failure::of(Limit::System { what, bytes: None }.into()))
            }
        }
    }

    /// Waits for the end of the work, or for a reason to cancel it.
    fn wait<T: Send>(
        self: &Arc<Self>,
        py: Python<'_>,
        call: &Call,
        news: &Mutex<Receiver<News<T>>>,
    ) -> Result<T, Failure> {
        // The reason to cancel the work, and the time at which the thread is left behind.
        let mut ending: Option<(Failure, Instant)> = None;
        loop {
            let pause = call.left().filter(|_| ending.is_none()).unwrap_or(TICK).min(TICK);
            match py.detach(|| lock(news).recv_timeout(pause)) {
                Ok(News::Done(end)) => return self.ended(end, ending),
                Ok(News::Step(position)) if ending.is_none() => {
                    ending = self.heed(call.listener.hear(py, &position));
                }
                Ok(News::Step(_)) => {}
                Err(RecvTimeoutError::Timeout) if ending.is_none() => {
                    ending = self.heed(call.listener.hear(py, &self.watch.position()));
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(Failure::panic("the worker is gone"));
                }
            }
            if ending.is_none() {
                ending = self.heed(py.check_signals());
            }
            if ending.is_none() && call.left().is_some_and(|left| left.is_zero()) {
                self.watch.time_out();
                let limit = Limit::Time(call.timeout.unwrap_or_default());
                ending = Some((self.failure(limit.into()), Instant::now() + GRACE));
            }
            if let Some((failure, _)) = ending.take_if(|(_, until)| Instant::now() >= *until) {
                // The thread is left behind; the next caller waits until it has stopped.
                *lock(&self.caller) = None;
                return Err(failure);
            }
        }
    }

    /// Cancels the work if a handler or callback raised an exception.
    fn heed(&self, raised: PyResult<()>) -> Option<(Failure, Instant)> {
        let error = raised.err()?;
        self.watch.interrupt();
        Some((Failure::from(error), Instant::now() + GRACE))
    }

    fn ended<T>(&self, end: Result<T, Halt>, ending: Option<(Failure, Instant)>) -> Result<T, Failure> {
        match (end, ending) {
            // An exception takes precedence, even if the work has ended meanwhile.
            (_, Some((raised, _))) if raised.is_raised() => Err(raised),
            (Ok(found), _) => Ok(found),
            (Err(Halt::Error(error)), _) => Err(self.failure(error)),
            (Err(Halt::Panic(message)), _) => Err(Failure::panic(&message)),
        }
    }

    /// Returns an error with the position of the work.
    fn failure(&self, error: Error) -> Failure {
        Failure::of(error).at(self.watch.position())
    }
}
