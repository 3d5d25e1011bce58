//! Signals that would end the process without a word where it meets a limit.

#[cfg(unix)]
use std::sync::Arc;
#[cfg(unix)]
use std::sync::atomic::AtomicBool;

#[cfg(unix)]
use super::exit::Status;

/// Writing past the largest size of a file fails as on a full disk, and memory that the system does not
/// give ends with the exit status of a limit: the allocator says what it wanted, and aborts.
#[cfg(unix)]
pub(super) fn prepare() {
    use signal_hook::consts::{SIGABRT, SIGXFSZ};
    use signal_hook::flag;
    // Where a handler cannot be set, the system does what it always does.
    let _ = flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
    let status = i32::from(Status::Limit.code());
    let _ = flag::register_conditional_shutdown(SIGABRT, status, Arc::new(AtomicBool::new(true)));
}

/// Elsewhere there are none.
#[cfg(not(unix))]
pub(super) fn prepare() {}
