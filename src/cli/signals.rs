//! Signals: interrupts, and those that would end the process without a message when it hits a limit
//! of the system.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

#[cfg(unix)]
use rustix::process::{Resource, getrlimit};
#[cfg(unix)]
use signal_hook::consts::{SIGABRT, SIGHUP, SIGXFSZ};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use super::exit::Status;

/// The signals that interrupt a run.
#[cfg(unix)]
const INTERRUPTS: [i32; 3] = [SIGINT, SIGTERM, SIGHUP];
#[cfg(not(unix))]
const INTERRUPTS: [i32; 2] = [SIGINT, SIGTERM];

/// Makes a write beyond the maximum file size fail like a write to a full disk. Makes an abort of
/// the allocator, for memory that the system does not provide, end with the exit status of a limit.
///
/// An allocation fails only if the address space is limited. Without that limit, an abort is a bug,
/// such as an overflowing stack, and ends the process as a signal does.
#[cfg(unix)]
pub(super) fn prepare() {
    // Without a handler, the system's default action remains.
    let _ = flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
    if getrlimit(Resource::As).current.is_some() {
        let always = Arc::new(AtomicBool::new(true));
        let _ = flag::register_conditional_shutdown(SIGABRT, status(Status::Limit), always);
    }
}

/// Does nothing: other systems have no such signals.
#[cfg(not(unix))]
pub(super) fn prepare() {}

/// Makes interrupts set `interrupted`. Once the returned flag is set, an interrupt ends the process
/// at once.
pub(super) fn set_on_interrupt(interrupted: &Arc<AtomicBool>) -> Arc<AtomicBool> {
    let over = Arc::new(AtomicBool::new(false));
    for signal in INTERRUPTS {
        // Without a handler an interrupt still ends the process, but without the partial results.
        let _ = flag::register_conditional_shutdown(signal, status(Status::Interrupted), Arc::clone(&over));
        let _ = flag::register(signal, Arc::clone(interrupted));
    }
    over
}

fn status(status: Status) -> i32 {
    i32::from(status.code())
}
