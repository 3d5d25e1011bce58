//! Instances as processes, so that an instance that fails does not end the others.

use std::ffi::OsString;
use std::io::Read;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};

use meliora::supervise::lock;
use meliora_report::{Failure, FailureKind};
use serde_json::{Map, Value as Json};

use super::row::Ended;

/// The result of one instance.
pub(crate) struct Outcome {
    /// The position among the instances that are run.
    pub(crate) index: usize,
    /// The report or the error.
    pub(crate) report: Json,
    /// The end of the instance; `None` if it was interrupted.
    pub(crate) ended: Option<Ended>,
}

/// The running processes, and the request to stop.
#[derive(Default)]
pub(crate) struct Pool {
    running: Mutex<Vec<(usize, Child)>>,
    pub(super) stopped: Arc<AtomicBool>,
}

impl Pool {
    /// Ends the running processes and starts no more.
    pub(crate) fn stop(&self) {
        self.stopped.store(true, Ordering::Relaxed);
        for (_, child) in lock(&self.running).iter_mut() {
            let _ = child.kill();
        }
    }

    pub(crate) fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }

    /// Runs the command line once per instance, at most `jobs` at a time.
    pub(crate) fn run(self: &Arc<Self>, jobs: usize, arguments: Vec<Vec<OsString>>) -> Receiver<Outcome> {
        let (sender, outcomes) = channel();
        let next = Arc::new(AtomicUsize::new(0));
        let arguments = Arc::new(arguments);
        for _ in 0..jobs.min(arguments.len()) {
            let (pool, next, arguments, sender) =
                (Arc::clone(self), Arc::clone(&next), Arc::clone(&arguments), sender.clone());
            std::thread::spawn(move || {
                while !pool.is_stopped() {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(own) = arguments.get(index) else { break };
                    if sender.send(pool.one(index, own)).is_err() {
                        break;
                    }
                }
            });
        }
        outcomes
    }

    fn one(&self, index: usize, arguments: &[OsString]) -> Outcome {
        let (read, status) = match self.output(index, arguments) {
            Ok((text, status)) => (report(&text), status),
            Err(e) => (Err(format!("the process could not be run: {e}")), None),
        };
        let ended = match status {
            Some(130) => None,
            None if self.is_stopped() => None,
            Some(0) if read.is_ok() => Some(Ended::Done),
            Some(1) if read.is_ok() => Some(Ended::No),
            Some(4) => Some(Ended::Limit),
            _ => Some(Ended::Error),
        };
        let report = read.unwrap_or_else(|message| {
            serde_json::to_value(Failure::new(FailureKind::Internal, message)).unwrap_or_default()
        });
        Outcome { index, report, ended }
    }

    /// Runs a process. Returns its output and its exit status.
    fn output(&self, index: usize, arguments: &[OsString]) -> std::io::Result<(String, Option<i32>)> {
        let program = std::env::current_exe()?;
        let mut child =
            Command::new(program).args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).spawn()?;
        let mut out = child.stdout.take();
        lock(&self.running).push((index, child));
        if self.is_stopped() {
            self.stop();
        }
        let mut bytes = Vec::new();
        let read = out.as_mut().map_or(Ok(0), |out| out.read_to_end(&mut bytes));
        let child = {
            let mut running = lock(&self.running);
            let at = running.iter().position(|(i, _)| *i == index);
            at.map(|at| running.swap_remove(at).1)
        };
        let status = child.map(|mut child| child.wait()).transpose()?;
        read?;
        Ok((String::from_utf8_lossy(&bytes).into_owned(), status.and_then(|s| s.code())))
    }
}

/// Reads the report of an instance.
fn report(text: &str) -> Result<Json, String> {
    let report = serde_json::from_str::<Map<String, Json>>(text);
    report.map(Json::Object).map_err(|e| format!("the process ended without a report ({e})"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_instance_that_dies_without_a_report_has_an_error_with_all_fields() {
        // The program is that of the tests, which prints no report.
        let outcome = Pool::default().one(0, &["--help".into()]);
        assert_eq!(outcome.ended, Some(Ended::Error));
        assert_eq!(outcome.report["kind"], "internal");
        let keys: Vec<&str> = outcome.report.as_object().unwrap().keys().map(String::as_str).collect();
        assert_eq!(keys, ["schema", "kind", "message", "file", "line", "column"]);
    }
}
