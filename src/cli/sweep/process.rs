//! Instances as processes, so that an instance that fails does not end the others.
//!
//! The limit of an instance is the size of its process. The engines bound their own tables, but not reading,
//! grounding, solving and writing, which only the size of a process covers; instances that run at the
//! same time in one process could not be told apart. Work that does not ask whether to stop is left behind
//! on its thread, and only the end of a process returns its memory. A row also has the largest size of its
//! process.

use std::ffi::OsString;
use std::io::Read;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, sync_channel};
use std::sync::{Arc, Mutex};

use meliora::supervise::lock;
use meliora::sweep::Ended;
use meliora_report::columns::Row;
use meliora_report::sweep::Outcome as FromProcess;
use meliora_report::{Failure, FailureKind};
use serde_json::Value as Json;

/// An instance that is to be run.
pub(crate) struct Instance {
    /// The position among the instances that are run.
    pub(crate) index: usize,
    /// The position among all instances.
    pub(crate) position: usize,
}

/// The result of one instance.
pub(crate) struct Outcome {
    pub(crate) instance: Instance,
    /// The report or the error.
    pub(crate) report: Json,
    /// Its row.
    pub(crate) row: Row,
    /// The end of the instance; `None` if it was interrupted.
    pub(crate) ended: Option<Ended>,
    /// The exit status of its process; `None` if a signal ended it.
    pub(crate) code: Option<i32>,
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

    /// Runs the command line of each instance, at most `jobs` at a time. Instances are taken from the
    /// iterator as they start, and wait with their outcome until it is received.
    pub(crate) fn run<I>(self: &Arc<Self>, jobs: usize, instances: I) -> Receiver<Outcome>
    where
        I: Iterator<Item = (Instance, Vec<OsString>)> + Send + 'static,
    {
        let (sender, outcomes) = sync_channel(jobs);
        let instances = Arc::new(Mutex::new(instances));
        for _ in 0..jobs {
            let (pool, instances, sender) = (Arc::clone(self), Arc::clone(&instances), sender.clone());
            std::thread::spawn(move || {
                while !pool.is_stopped() {
                    let Some((instance, arguments)) = lock(&instances).next() else { break };
                    if sender.send(pool.one(instance, &arguments)).is_err() {
                        break;
                    }
                }
            });
        }
        outcomes
    }

    fn one(&self, instance: Instance, arguments: &[OsString]) -> Outcome {
        let (read, code) = match self.output(instance.index, arguments) {
            Ok((text, code)) => (read(&text), code),
            Err(e) => (Err(format!("the process could not be run: {e}")), None),
        };
        let ended = match code {
            Some(130) => None,
            None if self.is_stopped() => None,
            Some(0) if read.is_ok() => Some(Ended::Done),
            Some(1) if read.is_ok() => Some(Ended::No),
            Some(4) => Some(Ended::Limit),
            _ => Some(Ended::Error),
        };
        let FromProcess { report, row } = read.unwrap_or_else(|message| {
            let failure = Failure::new(FailureKind::Internal, message);
            let FromProcess { report, row } = FromProcess::failed(&failure);
            FromProcess { report: serde_json::to_value(report).unwrap_or_default(), row }
        });
        Outcome { instance, report, row, ended, code }
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

/// Reads what the process of an instance has printed.
fn read(text: &str) -> Result<FromProcess<Json>, String> {
    serde_json::from_str(text).map_err(|e| format!("the process ended without a report ({e})"))
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicUsize;

    use super::*;

    /// The arguments of all instances of a sweep were in memory before the first one ran.
    #[test]
    fn instances_are_taken_as_they_start_and_wait_for_those_before() {
        let (pool, taken) = (Arc::new(Pool::default()), Arc::new(AtomicUsize::new(0)));
        let counted = Arc::clone(&taken);
        let all = (0..1_000_000).map(move |index| {
            counted.fetch_add(1, Ordering::Relaxed);
            (Instance { index, position: index }, vec!["--help".into()])
        });
        let outcomes = pool.run(1, all);
        for index in 0..3 {
            assert_eq!(outcomes.recv().unwrap().instance.index, index);
        }
        pool.stop();
        // One is received, one is in the channel, one waits for a place there, and one may have started.
        assert!(taken.load(Ordering::Relaxed) <= 3 + 3);
    }

    #[test]
    fn an_instance_that_dies_without_a_report_has_an_error_with_all_fields() {
        // The program is that of the tests, which prints no report.
        let outcome = Pool::default().one(Instance { index: 0, position: 0 }, &["--help".into()]);
        assert_eq!(outcome.ended, Some(Ended::Error));
        assert_eq!(outcome.report["kind"], "internal");
        assert!(outcome.row.problem.is_some_and(|problem| problem.contains("without a report")));
        let keys: Vec<&str> = outcome.report.as_object().unwrap().keys().map(String::as_str).collect();
        assert_eq!(keys, ["schema", "kind", "message", "file", "line", "column"]);
    }
}
