//! Runs the work on its own thread and watches the clock meanwhile.
//!
//! The worker fills in the report step by step. When time is up or the user interrupts, the worker
//! is asked to stop. If it does not stop within [`GRACE`], the partial results are printed anyway.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use meliora::error::{Error, Limit};
use meliora::output::{Failure, FailureKind, Report};

use super::exit::Status;
use super::options::ShownArgs;
use super::watch::{Watch, lock};
use super::{advice, size, terminal};

/// The time that the worker has to stop.
const GRACE: Duration = Duration::from_millis(250);
/// The interval between updates of the progress.
const TICK: Duration = Duration::from_millis(100);
/// Stack size of the worker: recursion is as deep as the expressions and diagrams. The system maps
/// pages of the stack only when they are used.
const STACK: usize = 512 << 20;

/// The report that the worker fills in, and the watch that it obeys.
pub(super) struct Job<R> {
    report: Arc<Mutex<R>>,
    /// The progress sink for the library.
    pub(super) watch: Arc<Watch>,
}

impl<R> Job<R> {
    /// Changes the report.
    pub(super) fn update(&self, change: impl FnOnce(&mut R)) {
        change(&mut lock(&self.report));
    }

    /// Runs a piece of work and records its seconds in the report.
    ///
    /// # Errors
    /// The errors of the work.
    pub(super) fn timed<T>(
        &self,
        name: &'static str,
        work: impl FnOnce() -> Result<T, Error>,
        note: impl FnOnce(&mut R, f64),
    ) -> Result<T, Error> {
        self.watch.enter(name);
        let start = Instant::now();
        let result = work()?;
        let seconds = start.elapsed().as_secs_f64();
        self.update(|r| note(r, seconds));
        self.watch.leave(name, seconds);
        Ok(result)
    }
}

enum Event {
    Ended(Result<(), End>),
    Interrupt,
}

/// The reason why the work ended early.
enum End {
    Error(Error),
    Panic,
}

/// Runs `work` and prints the report. Returns an error in the input to the caller, who shows it.
///
/// # Errors
/// The input is wrong, or standard output cannot be written.
pub(super) fn supervise<R, W>(
    report: R,
    timeout: Option<Duration>,
    shown: &ShownArgs,
    work: W,
) -> Result<Status, Error>
where
    R: Report + Send + 'static,
    W: FnOnce(&Job<R>) -> Result<(), Error> + Send + 'static,
{
    terminal::set_color(shown.color);
    let watch = Arc::new(Watch::new(timeout, shown));
    let report = Arc::new(Mutex::new(report));
    let job = Job { report: Arc::clone(&report), watch: Arc::clone(&watch) };
    let (sender, events) = channel();
    let over = handle_interrupts(sender.clone());
    let panic = record_panics();
    start(job, work, sender)?;
    let end = wait(&watch, &events);
    over.store(true, Ordering::Relaxed);
    watch.clear();
    // Reports can be large, so this one is not copied. A worker that was left behind waits for the
    // lock.
    let mut report = lock(&report);
    report.finish(watch.elapsed().as_secs_f64(), size::peak_rss());
    match end {
        Ok(()) => {
            show(&*report, shown)?;
            Ok(if report.is_no() { Status::No } else { Status::Done })
        }
        Err(End::Panic) => internal(&lock(&panic), shown),
        Err(End::Error(error @ Error::Limit(_))) => {
            report.fail(advice::failure(&error));
            show(&*report, shown)?;
            terminal::show_error(&error, watch.position().as_deref());
            Ok(Status::of(&error))
        }
        Err(End::Error(error)) => Err(error),
    }
}

fn show(report: &impl Report, shown: &ShownArgs) -> Result<(), Error> {
    if shown.json {
        terminal::print_json(report)
    } else {
        terminal::print_report(report, terminal::stdout_style())
    }
}

fn internal(message: &str, shown: &ShownArgs) -> Result<Status, Error> {
    terminal::show_internal(message);
    if shown.json {
        terminal::print_json(&Failure::new(FailureKind::Internal, message))?;
    }
    Ok(Status::Internal)
}

/// Starts the worker.
fn start<R, W>(job: Job<R>, work: W, sender: Sender<Event>) -> Result<(), Error>
where
    R: Send + 'static,
    W: FnOnce(&Job<R>) -> Result<(), Error> + Send + 'static,
{
    let body = move || {
        let end = match catch_unwind(AssertUnwindSafe(|| work(&job))) {
            Ok(result) => result.map_err(End::Error),
            Err(_) => Err(End::Panic),
        };
        // The supervisor may have given up waiting.
        let _ = sender.send(Event::Ended(end));
    };
    match std::thread::Builder::new().name("worker".to_owned()).stack_size(STACK).spawn(body) {
        Ok(_) => Ok(()),
        Err(e) => {
            let what = format!("a thread with a stack of {} MiB ({e})", STACK >> 20);
            Err(Limit::System { what, bytes: None }.into())
        }
    }
}

/// Waits for the end of the work, or for a reason to stop it.
fn wait(watch: &Watch, events: &Receiver<Event>) -> Result<(), End> {
    loop {
        let left = watch.time_left();
        if left.is_some_and(|l| l.is_zero()) {
            watch.time_out();
            return wind_up(watch, events);
        }
        match events.recv_timeout(left.unwrap_or(TICK).min(TICK)) {
            Ok(Event::Ended(end)) => return end,
            Ok(Event::Interrupt) => {
                watch.interrupt();
                return wind_up(watch, events);
            }
            Err(RecvTimeoutError::Timeout) => watch.tick(),
            Err(RecvTimeoutError::Disconnected) => return Err(End::Panic),
        }
    }
}

/// Gives the worker a moment to stop, and leaves it behind if it does not.
fn wind_up(watch: &Watch, events: &Receiver<Event>) -> Result<(), End> {
    let until = Instant::now() + GRACE;
    loop {
        match events.recv_timeout(until.saturating_duration_since(Instant::now())) {
            Ok(Event::Ended(end)) => return end,
            Ok(Event::Interrupt) => watch.interrupt(),
            Err(_) => {
                use meliora::engine::ProgressSink;
                let limit = watch.stop().unwrap_or(Limit::Interrupted);
                return Err(End::Error(limit.into()));
            }
        }
    }
}

/// Turns Ctrl-C into an event. After the work (when the returned flag is set) Ctrl-C ends the
/// process at once: then only the output of results can hang.
fn handle_interrupts(sender: Sender<Event>) -> Arc<AtomicBool> {
    let over = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&over);
    let handler = move || {
        if flag.load(Ordering::Relaxed) || sender.send(Event::Interrupt).is_err() {
            std::process::exit(i32::from(Status::Interrupted.code()));
        }
    };
    // Without a handler Ctrl-C still ends the process, but without the partial results.
    let _ = ctrlc::set_handler(handler);
    over
}

/// Keeps the message of a panic, to be shown with the other errors.
fn record_panics() -> Arc<Mutex<String>> {
    let text = Arc::new(Mutex::new(String::new()));
    let kept = Arc::clone(&text);
    std::panic::set_hook(Box::new(move |info| {
        *lock(&kept) = info.to_string().replace('\n', " ");
    }));
    text
}
