//! The main thread: it runs the command on a thread of its own, and ends the process if the process
//! grows too large.
//!
//! The library and the supervisor of a run end work with its partial results before that. This
//! watch covers the rest: reading and writing outside of that work, and work that was left behind, whose
//! temporary files it removes.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::thread::Builder;
use std::time::Duration;

use meliora::supervise::memory;
use meliora_base::error::{Error, Limit};
use meliora_base::files::remove_unfinished;

use super::exit::Status;

/// The stack of the command, in bytes. That of the main thread may be tiny (`ulimit -s`).
const STACK: usize = 16 << 20;
/// The interval between two checks of the size of the process.
const CHECKS: Duration = Duration::from_millis(20);
/// The memory that the process may use in addition to `--memory` before it is ended, in bytes.
const ALLOWANCE: u64 = 256 << 20;

/// The value of `--memory` in bytes, once it is known.
static MEMORY: AtomicU64 = AtomicU64::new(u64::MAX);

/// Limits the memory of the process to `bytes` and 256 MiB.
pub(super) fn limit_memory(bytes: u64) {
    MEMORY.store(bytes, Ordering::Relaxed);
}

/// Runs a command and returns its status. `fail` shows the error that ends the process before.
pub(super) fn run(
    command: impl FnOnce() -> Status + Send + 'static,
    fail: impl Fn(&Error) -> Status,
) -> Status {
    let (sender, ended) = sync_channel(1);
    let body = move || {
        let _ = sender.send(command());
    };
    if let Err(e) = Builder::new().name("meliora".to_owned()).stack_size(STACK).spawn(body) {
        let what = format!("a thread with a stack of {} MiB ({e})", STACK >> 20);
        return fail(&Limit::System { what, bytes: None }.into());
    }
    let status = wait(&ended, memory::resident).unwrap_or_else(|limit| fail(&limit.into()));
    remove_unfinished();
    status
}

/// Waits for the status of the command.
///
/// # Errors
/// The process, of which `size` returns the size, has grown too large.
fn wait(ended: &Receiver<Status>, size: impl Fn() -> Option<u64>) -> Result<Status, Limit> {
    loop {
        match ended.recv_timeout(CHECKS) {
            Ok(status) => return Ok(status),
            Err(RecvTimeoutError::Disconnected) => return Ok(Status::Internal),
            Err(RecvTimeoutError::Timeout) => {}
        }
        let memory = MEMORY.load(Ordering::Relaxed);
        if size().is_some_and(|used| used > memory.saturating_add(ALLOWANCE)) {
            let (own, more) = (memory >> 20, ALLOWANCE >> 20);
            let what = format!("the process uses more than {own} MiB + {more} MiB for itself");
            return Err(Limit::Memory { what });
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;
    use std::process::Command;
    use std::sync::mpsc::channel;

    use meliora_base::files::{NewDirectory, Replacement};

    use super::*;

    #[test]
    fn a_process_that_grows_outside_of_supervised_work_is_ended() {
        limit_memory(1 << 20);
        let (sender, ended) = channel();
        let limit = wait(&ended, || Some(300 << 20)).unwrap_err();
        assert_eq!(limit.to_string(), "out of memory: the process uses more than 1 MiB + 256 MiB for itself");
        sender.send(Status::Done).unwrap();
        assert_eq!(wait(&ended, || Some(200 << 20)), Ok(Status::Done));
        drop(sender);
        assert_eq!(wait(&ended, || None), Ok(Status::Internal));
    }

    /// The folder of the process that the next test starts.
    const FOLDER: &str = "MELIORA_TEST_FOLDER";

    /// Temporary files were left where the process ended before the thread that wrote them.
    #[test]
    fn work_that_is_left_behind_leaves_no_files() {
        let Some(folder) = std::env::var_os(FOLDER) else {
            let folder = tempfile::tempdir().unwrap();
            let mut own = Command::new(std::env::current_exe().unwrap());
            own.args(["--exact", "cli::watch::tests::work_that_is_left_behind_leaves_no_files"]);
            assert!(own.env(FOLDER, folder.path()).status().unwrap().success());
            let left = fs::read_dir(folder.path()).unwrap().map(|file| file.unwrap().file_name());
            assert_eq!(left.collect::<Vec<_>>(), ["whole"]);
            return;
        };
        let path = Path::new(&folder).join("whole");
        fs::write(&path, "old").unwrap();
        let old = fs::metadata(&path).unwrap();
        let (file, new) = (path.clone(), path.with_file_name("new"));
        let status = run(
            move || {
                let file = Replacement::new(&file, Some(&old), b"new", true).unwrap();
                let folder = NewDirectory::new(&new).unwrap();
                folder.write("part", b"one").unwrap();
                // As a thread that is left behind, these are never dropped.
                std::mem::forget((file, folder));
                Status::Limit
            },
            |_| Status::Internal,
        );
        assert_eq!((status, fs::read_to_string(&path).unwrap().as_str()), (Status::Limit, "old"));
        let late = Replacement::new(&path, None, b"late", false);
        assert!(late.is_err_and(|e| e.to_string() == "the process ends"));
    }
}
