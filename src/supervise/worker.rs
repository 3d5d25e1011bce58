//! Worker threads.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::{Duration, Instant};

use super::supervisor::{CHECKS, Position, Supervisor};
use meliora_base::error::{Error, Limit, Result};
use meliora_base::memory::{STACK, check_heap};

/// The time that a worker thread has to stop after it was cancelled.
const GRACE: Duration = Duration::from_millis(250);
/// The interval at which the waiting thread is called.
const TICK: Duration = Duration::from_millis(50);

/// The reason why work has no result. `X` is the error with which the waiting thread cancels.
#[derive(Debug)]
pub enum Failure<X> {
    /// An error of the work, or the limit that cancelled it.
    Error(Error),
    /// The work panicked with this message.
    Panic(String),
    /// The waiting thread cancelled the work.
    Cancelled(X),
}

enum Event<T> {
    Position(Position),
    Ended(std::thread::Result<Result<T>>),
}

/// The means by which work reports its position.
pub struct Reporter<'a> {
    supervisor: &'a Supervisor,
    send: &'a dyn Fn(Position),
}

impl Reporter<'_> {
    /// Reports that a part of a phase begins, and waits until the waiting thread has noticed.
    pub fn report(&self, phase: &'static str, part: String) {
        self.supervisor.set_position(phase, part.clone());
        (self.send)(Position { phase, part, detail: String::new() });
    }
}

/// A worker thread with its work.
pub struct Worker<T> {
    supervisor: Arc<Supervisor>,
    events: Receiver<Event<T>>,
}

/// Starts work on a new thread with a large stack.
///
/// # Errors
/// The system does not provide the thread.
pub fn spawn<T: Send + 'static>(
    supervisor: &Arc<Supervisor>,
    work: impl FnOnce(&Reporter<'_>) -> Result<T> + Send + 'static,
) -> Result<Worker<T>> {
    // Without a queue: the work waits until each position has been received.
    let (sender, events) = sync_channel(0);
    let own = Arc::clone(supervisor);
    let body = move || {
        // The receiver is gone if the waiting thread has given up.
        let send = |position| drop(sender.send(Event::Position(position)));
        let reporter = Reporter { supervisor: &own, send: &send };
        let begin = || {
            check_heap()?;
            work(&reporter)
        };
        let end = catch_unwind(AssertUnwindSafe(begin));
        let _ = sender.send(Event::Ended(end));
    };
    match std::thread::Builder::new().name("meliora-worker".to_owned()).stack_size(STACK).spawn(body) {
        Ok(_) => Ok(Worker { supervisor: Arc::clone(supervisor), events }),
        Err(e) => {
            let what = format!("a thread with a stack of {} MiB ({e})", STACK >> 20);
            Err(Limit::System { what, bytes: None }.into())
        }
    }
}

impl<T> Worker<T> {
    /// Waits for the result. Calls `attend` with the position whenever the work reports it, and
    /// every 50 ms; its error cancels the work.
    ///
    /// Cancelled work has 250 ms to stop. Then its thread is left behind, and ends at its next
    /// check for cancellation. Every 5 ms the memory limit is checked, too: work that exceeds it
    /// without asking whether to stop is left behind at once.
    ///
    /// # Errors
    /// The errors of the work and of `attend`; the limit that cancelled the work. An error of
    /// `attend` takes precedence, even if the work has ended meanwhile.
    pub fn wait<X>(
        self,
        mut attend: impl FnMut(&Position) -> std::result::Result<(), X>,
    ) -> std::result::Result<T, Failure<X>> {
        // The reason for the cancellation, and the time at which the thread is left behind.
        let mut cancelled: Option<(Failure<X>, Instant)> = None;
        let mut due = Instant::now() + TICK;
        loop {
            let left = match &cancelled {
                Some((_, until)) => Some(until.saturating_duration_since(Instant::now())),
                None => self.supervisor.remaining(),
            };
            let reported = match self.events.recv_timeout(left.unwrap_or(CHECKS).min(CHECKS)) {
                Ok(Event::Ended(end)) => return ended(end, cancelled),
                Ok(Event::Position(position)) => Some(position),
                Err(RecvTimeoutError::Timeout) => None,
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(Failure::Panic("the worker thread is gone".to_owned()));
                }
            };
            if let Some((reason, _)) = cancelled.take_if(|(_, until)| Instant::now() >= *until) {
                return Err(reason);
            }
            if let Some(limit) = self.supervisor.outgrown() {
                return Err(cancelled.map_or(Failure::Error(limit.into()), |(reason, _)| reason));
            }
            let is_late = self.supervisor.remaining().is_some_and(|left| left.is_zero());
            if cancelled.is_none() && (reported.is_some() || is_late || Instant::now() >= due) {
                due = Instant::now() + TICK;
                let position = reported.unwrap_or_else(|| self.supervisor.position());
                let reason = self.cancellation(attend(&position));
                cancelled = reason.map(|reason| (reason, Instant::now() + GRACE));
            }
        }
    }

    /// Returns the reason to cancel the work, if there is one.
    fn cancellation<X>(&self, attended: std::result::Result<(), X>) -> Option<Failure<X>> {
        match attended {
            Err(error) => {
                self.supervisor.interrupt();
                Some(Failure::Cancelled(error))
            }
            Ok(()) => self.supervisor.overdue().map(|limit| Failure::Error(limit.into())),
        }
    }
}

fn ended<T, X>(
    end: std::thread::Result<Result<T>>,
    cancelled: Option<(Failure<X>, Instant)>,
) -> std::result::Result<T, Failure<X>> {
    match (end, cancelled) {
        (_, Some((Failure::Cancelled(error), _))) => Err(Failure::Cancelled(error)),
        (Ok(result), _) => result.map_err(Failure::Error),
        (Err(panic), _) => Err(Failure::Panic(panic_message(&*panic))),
    }
}

fn panic_message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "a panic".to_owned())
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;
    use std::sync::Mutex;
    use std::sync::mpsc::channel;

    use super::super::supervisor::TimeLimit;
    use super::*;
    use meliora_base::progress::ProgressSink;

    /// Taken by the tests that measure the memory of the process, so that none frees memory that another has counted.
    static MEASURES_MEMORY: Mutex<()> = Mutex::new(());

    /// Works until it is cancelled.
    fn endless(supervisor: &Supervisor) -> Result<()> {
        loop {
            if let Some(limit) = supervisor.stop() {
                return Err(limit.into());
            }
            std::thread::yield_now();
        }
    }

    fn run<T: Send + 'static>(
        supervisor: &Arc<Supervisor>,
        work: impl FnOnce(&Supervisor, &Reporter<'_>) -> Result<T> + Send + 'static,
    ) -> std::result::Result<T, Failure<Infallible>> {
        let own = Arc::clone(supervisor);
        spawn(supervisor, move |reporter| work(&own, reporter)).unwrap().wait(|_| Ok(()))
    }

    #[test]
    fn every_reported_position_is_attended() {
        let supervisor = Arc::new(Supervisor::new());
        let work = |reporter: &Reporter<'_>| {
            (0..20).for_each(|part| reporter.report("phase", part.to_string()));
            Ok(7)
        };
        let mut parts = Vec::new();
        let found = spawn(&supervisor, work).unwrap().wait(|position| {
            parts.push(position.part.clone());
            Ok::<_, Infallible>(())
        });
        assert!(matches!(found, Ok(7)));
        parts.dedup();
        parts.retain(|part| !part.is_empty());
        assert_eq!(parts, (0..20).map(|part| part.to_string()).collect::<Vec<_>>());
        assert_eq!(supervisor.position().line(), "phase · 19");
    }

    #[test]
    fn an_interrupt_a_time_limit_and_a_memory_limit_cancel_the_work() {
        let _alone = MEASURES_MEMORY.lock().unwrap();
        let supervisor = Arc::new(Supervisor::new());
        let interrupted = run(&supervisor, |own, _| {
            own.interrupt();
            endless(own)
        });
        assert!(matches!(interrupted, Err(Failure::Error(Error::Limit(Limit::Interrupted)))));
        let timeout = Duration::from_millis(1);
        supervisor.reset(TimeLimit::starting_now(timeout));
        let late = run(&supervisor, |own, _| endless(own));
        assert!(matches!(late, Err(Failure::Error(Error::Limit(Limit::Time(t)))) if t == timeout));
        supervisor.reset(None);
        assert!(supervisor.stop().is_none());
        // No process has used 2^64 bytes, and a limit of 0 allows 64 MiB.
        supervisor.limit_memory(u64::MAX);
        assert!(matches!(run(&supervisor, |_, _| Ok(())), Ok(())));
        supervisor.limit_growth(0);
        let large = run(&supervisor, |own, _| {
            // Other tests may free any memory meanwhile.
            let mut blocks = Vec::new();
            while blocks.len() < 1 << 11 {
                if let Some(limit) = own.stop() {
                    return Err(limit.into());
                }
                blocks.push(vec![1_u8; 1 << 20]);
            }
            Ok(())
        });
        match large {
            Err(Failure::Error(Error::Limit(Limit::Memory { what }))) => {
                assert_eq!(what, "the process has gained more than 0 MiB + 64 MiB for itself");
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn work_that_does_not_stop_is_left_behind() {
        let supervisor = Arc::new(Supervisor::new());
        let (free, blocked) = channel::<()>();
        let worker = spawn(&supervisor, move |_| Ok(blocked.recv().is_ok())).unwrap();
        let found = worker.wait(|_| Err("enough"));
        assert!(matches!(found, Err(Failure::Cancelled("enough"))));
        assert!(matches!(supervisor.stop(), Some(Limit::Interrupted)));
        free.send(()).unwrap();
    }

    #[test]
    fn work_that_needs_more_and_more_memory_without_asking_is_left_behind() {
        let _alone = MEASURES_MEMORY.lock().unwrap();
        let supervisor = Arc::new(Supervisor::new());
        supervisor.limit_growth(0);
        let ((free, blocked), (end, ended)) = (channel::<()>(), channel::<()>());
        let worker = spawn(&supervisor, move |_| {
            let _end = end;
            // Enough even if the work of the other test frees its 80 MiB only now.
            let bytes = vec![1_u8; 320 << 20];
            Ok((blocked.recv().is_ok(), bytes.len()))
        });
        let found = worker.unwrap().wait(|_| Ok::<_, Infallible>(()));
        assert!(matches!(found, Err(Failure::Error(Error::Limit(Limit::Memory { .. })))));
        assert!(matches!(supervisor.stop(), Some(Limit::Memory { .. })), "the work hears of it");
        free.send(()).unwrap();
        // Else the other test would count this memory, and miss its own when this is freed.
        assert!(ended.recv().is_err());
    }

    #[test]
    fn a_panic_has_its_message() {
        let found = run(&Arc::new(Supervisor::new()), |_, _| -> Result<()> { panic!("no {}", "luck") });
        assert!(matches!(found, Err(Failure::Panic(message)) if message == "no luck"));
    }
}
