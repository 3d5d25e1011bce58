//! Memory that the system grants.

use crate::error::Limit;

/// The stack of a thread that works, in bytes. Recursion is as deep as expressions and diagrams; the system maps pages of
/// the stack only when they are used.
pub const STACK: usize = 512 << 20;

/// The addresses of the heap of a thread, in bytes. If there are fewer, glibc asks the system for each small piece of
/// memory, and work takes a hundred times as long.
const HEAP: u64 = 128 << 20;

/// Returns whether the system grants this memory. Maps no pages.
pub fn grants(bytes: u64) -> bool {
    usize::try_from(bytes).is_ok_and(|bytes| Vec::<u8>::new().try_reserve_exact(bytes).is_ok())
}

/// Returns once the system grants a heap for this thread. To be called where a thread begins.
///
/// # Errors
/// The addresses of the process do not suffice.
pub fn check_heap() -> Result<(), Limit> {
    match grants(HEAP) {
        true => Ok(()),
        false => {
            Err(Limit::System { what: format!("a heap of {} MiB for a thread", HEAP >> 20), bytes: None })
        }
    }
}
