//! Runs the work of a command on a worker thread, and prints its report.
//!
//! The worker fills in the report step by step, so that the partial results can be printed when it
//! is cancelled, even if it does not stop.

use std::convert::Infallible;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, MutexGuard, TryLockError};
use std::time::Duration;

use meliora::commands::Work;
use meliora::supervise::{Failure, Supervisor, TimeLimit, lock, memory, spawn};
use meliora_base::error::{Error, Limit};
use meliora_engine::{ProgressSink, Selection, Usage};
use meliora_question::{Answers, Listener, Warning, race};
use meliora_report::ReachReport;
use meliora_report::envelope::{Envelope, Findings};
use meliora_report::sweep::Outcome;
use meliora_report::{Failure as Failed, FailureKind, Report};

use super::exit::Status;
use super::options::{Limits, ShownArgs};
use super::progress::TerminalSink;
use super::terminal::Form;
use super::{advice, signals, terminal, watch};

/// The number of times that the report is tried to be locked, and the time between them.
const TRIALS: (usize, Duration) = (50, Duration::from_millis(5));

/// The report that the worker fills in, and the sink of its progress.
pub(super) struct Job<R> {
    report: Arc<Mutex<R>>,
    /// The progress sink for the library.
    pub(super) sink: Arc<TerminalSink>,
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
        self.sink.enter(name);
        let result = work()?;
        self.ended(name, note);
        Ok(result)
    }

    /// Reports that a piece of work has ended, and records its seconds in the report.
    fn ended(&self, name: &'static str, note: impl FnOnce(&mut R, f64)) {
        let seconds = self.sink.start(name).elapsed().as_secs_f64();
        self.update(|r| note(r, seconds));
        self.sink.finished(name);
    }
}

impl<F: Findings + Clone + Send> race::Job for Job<Envelope<F>> {
    fn copy(&self) -> Self {
        Job { report: Arc::new(Mutex::new(lock(&self.report).clone())), sink: Arc::clone(&self.sink) }
    }

    fn of_way(&self, way: usize) -> Self {
        Job { sink: Arc::new(self.sink.of_way(way)), ..self.copy() }
    }

    fn sink(&self) -> Arc<dyn ProgressSink> {
        Arc::clone(&self.sink) as _
    }

    fn begin(&self) {
        self.sink.enter("build");
        self.sink.show(None);
    }

    fn built(&self, selection: &Selection) {
        self.ended("build", |r, s| r.time.add("build", s));
        self.update(|r| r.header.select(selection));
    }

    fn leave_to(&self, way: Self) -> Self {
        self.sink.show(Some(&way.sink));
        Job { report: Arc::clone(&self.report), sink: way.sink }
    }

    fn take(&self, other: &Self) {
        if !Arc::ptr_eq(&self.report, &other.report) {
            let report = lock(&other.report).clone();
            *lock(&self.report) = report;
        }
        if !Arc::ptr_eq(&self.sink, &other.sink) {
            self.sink.show(Some(&other.sink));
        }
    }
}

impl<R: Send> Work<R> for Job<R> {
    fn change(&self, change: &mut dyn FnMut(&mut R)) {
        self.update(|r| change(r));
    }

    fn begin(&self, name: &'static str) {
        self.sink.enter(name);
    }

    fn end(&self, name: &'static str) -> f64 {
        let seconds = self.sink.start(name).elapsed().as_secs_f64();
        self.sink.finished(name);
        seconds
    }

    fn part(&self, name: &'static str, part: &str) {
        self.sink.report(name, part.to_owned());
    }

    fn warn(&self, warning: Warning) {
        self.sink.tell(warning);
    }

    fn note(&self, text: &str) {
        self.sink.note(text);
    }

    fn share(&self, parts: Option<usize>) {
        self.sink.share(parts);
    }

    fn sink(&self) -> Arc<dyn ProgressSink> {
        Arc::clone(&self.sink) as _
    }
}

impl Listener for Job<ReachReport> {
    fn change(&self, change: &mut dyn FnMut(&mut Answers)) {
        self.update(|r| change(&mut r.answers));
    }

    fn used(&self, usage: Usage) {
        self.update(|r| r.used(usage));
    }

    fn begin(&self, name: &'static str) {
        self.sink.enter(name);
    }

    fn end(&self, name: &'static str, phase: &'static str) {
        self.ended(name, |r, s| r.time.add(phase, s));
    }

    fn warn(&self, warning: Warning) {
        self.sink.tell(warning);
    }

    fn stop(&self) -> Option<Limit> {
        self.sink.stop()
    }

    fn share(&self, parts: Option<usize>) {
        self.sink.share(parts);
    }

    fn end_share(&self, limit: Limit) {
        self.sink.end_share(limit);
    }

    fn ended_share(&self) -> Option<Limit> {
        self.sink.ended_share()
    }
}

/// Runs `work` and prints the report. Returns an error in the input to the caller, who shows it.
///
/// # Errors
/// The input is wrong, or standard output cannot be written.
pub(super) fn supervise<R, W>(report: R, limits: Limits, shown: &ShownArgs, work: W) -> Result<Status, Error>
where
    R: Report + Send + 'static,
    W: FnOnce(&Job<R>) -> Result<(), Error> + Send + 'static,
{
    terminal::set_color(shown.color);
    let supervisor = Arc::new(Supervisor::new());
    supervisor.reset(limits.timeout.and_then(TimeLimit::starting_now));
    supervisor.limit_memory(limits.memory);
    watch::limit_memory(limits.memory);
    let sink = Arc::new(TerminalSink::new(&supervisor, shown));
    let report = Arc::new(Mutex::new(report));
    let job = Job { report: Arc::clone(&report), sink: Arc::clone(&sink) };
    let over = signals::set_on_interrupt(supervisor.interrupt_flag());
    let panic = record_panics();
    let worker = spawn(&supervisor, move |_| work(&job))?;
    let end = worker.wait(|_| {
        sink.tick();
        Ok::<_, Infallible>(())
    });
    sink.finished("release");
    // From now on only the output of results can hang, and an interrupt ends the process.
    over.store(true, Ordering::Relaxed);
    sink.clear();
    // Reports can be large, so this one is not copied. A worker that was left behind waits for the
    // lock, unless it was left while it changes the report.
    let mut report = match (try_lock(&report), &end) {
        (Some(report), _) => report,
        (None, Err(Failure::Error(error))) => return Err(error.clone()),
        (None, _) => lock(&report),
    };
    report.finish(supervisor.elapsed().as_secs_f64(), memory::peak_rss());
    match end {
        Err(Failure::Error(Error::Limit(_))) if terminal::is_unread() => Ok(Status::Done),
        Ok(()) => {
            show(&*report, shown)?;
            Ok(match (report.is_no(), report.is_unread()) {
                (true, _) => Status::No,
                (false, true) => Status::Input,
                (false, false) => Status::Done,
            })
        }
        Err(Failure::Panic(_)) => internal(&lock(&panic), shown),
        Err(Failure::Error(error @ Error::Limit(_))) => {
            report.fail(advice::failure(&error));
            show(&*report, shown)?;
            terminal::show_error(&error, sink.position().as_deref());
            Ok(Status::for_error(&error))
        }
        Err(Failure::Error(error)) => Err(error),
        Err(Failure::Cancelled(never)) => match never {},
    }
}

/// Locks the report; `None` if a worker keeps it.
fn try_lock<R>(report: &Mutex<R>) -> Option<MutexGuard<'_, R>> {
    for _ in 0..TRIALS.0 {
        match report.try_lock() {
            Ok(report) => return Some(report),
            Err(TryLockError::Poisoned(report)) => return Some(report.into_inner()),
            Err(TryLockError::WouldBlock) => std::thread::sleep(TRIALS.1),
        }
    }
    None
}

fn show(report: &impl Report, shown: &ShownArgs) -> Result<(), Error> {
    match shown.form() {
        _ if shown.csv => Ok(()),
        Form::Text => terminal::print_report(report, terminal::stdout_style()),
        Form::Json => terminal::print_json(report),
        Form::Instance => terminal::print_json(&Outcome { report, row: report.row() }),
    }
}

fn internal(message: &str, shown: &ShownArgs) -> Result<Status, Error> {
    terminal::show_internal(message);
    terminal::print_failure(&Failed::new(FailureKind::Internal, message), shown.form())?;
    Ok(Status::Internal)
}

/// Keeps the message of a panic with its place, to be shown with the other errors.
fn record_panics() -> Arc<Mutex<String>> {
    let text = Arc::new(Mutex::new(String::new()));
    let kept = Arc::clone(&text);
    std::panic::set_hook(Box::new(move |info| {
        *lock(&kept) = info.to_string().replace('\n', " ");
    }));
    text
}
