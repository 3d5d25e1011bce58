//! Signals that would end the process without a message when it hits a limit of the system.

#[cfg(unix)]
use std::sync::Arc;
#[cfg(unix)]
use std::sync::atomic::AtomicBool;

#[cfg(unix)]
use super::exit::Status;

/// Makes a write beyond the maximum file size fail like a write to a full disk. Makes an abort of
/// the allocator, for memory that the system does not provide, end with the exit status of a limit.
#[cfg(unix)]
pub(super) fn prepare() {
    use signal_hook::consts::{SIGABRT, SIGXFSZ};
    use signal_hook::flag;
    // Without a handler, the system's default action remains.
    let _ = flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
    let status = i32::from(Status::Limit.code());
    let _ = flag::register_conditional_shutdown(SIGABRT, status, Arc::new(AtomicBool::new(true)));
}

/// Does nothing: other systems have no such signals.
#[cfg(not(unix))]
pub(super) fn prepare() {}
