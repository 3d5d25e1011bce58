//! Instances as processes, so that an instance that fails does not end the others.

use std::ffi::OsString;
use std::io::Read;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};

use serde_json::Value as Json;

use super::row::Ended;
use meliora::supervise::lock;

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
                    let (report, ended) = pool.one(index, own);
                    if sender.send(Outcome { index, report, ended }).is_err() {
                        break;
                    }
                }
            });
        }
        outcomes
    }

    fn one(&self, index: usize, arguments: &[OsString]) -> (Json, Option<Ended>) {
        match self.output(index, arguments) {
            Ok((text, status)) => (
                serde_json::from_str(&text).unwrap_or_else(|_| error("the process ended without a report")),
                match status {
                    Some(0) => Some(Ended::Done),
                    Some(1) => Some(Ended::No),
                    Some(4) => Some(Ended::Limit),
                    Some(130) => None,
                    _ if self.is_stopped() => None,
                    _ => Some(Ended::Error),
                },
            ),
            Err(e) => (error(&format!("the process could not be run: {e}")), Some(Ended::Error)),
        }
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

fn error(message: &str) -> Json {
    serde_json::json!({"schema": "meliora.error/1", "kind": "internal", "message": message})
}
