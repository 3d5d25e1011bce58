//! The tables of a store, allocated only if the system grants their memory and threads.

use std::time::Duration;

use oxidd::bdd::BDDManagerRef;

use meliora_base::error::{Limit, Result};
use meliora_base::memory::grants;

/// Bytes per node, in the table and in its index.
pub(in crate::symbolic) const BYTES_PER_NODE: u64 = 32;
/// Bytes per entry of the operation cache.
pub(in crate::symbolic) const BYTES_PER_ENTRY: u64 = 20;

/// The nodes that the table of OxiDD must have in addition to those allowed. OxiDD gives nodes to the threads that use
/// it in blocks of 2^16, and no other thread can use the nodes of a block. Its number of nodes lags behind by at most a
/// block per thread. Each thread may keep two blocks to itself: that of the caller, that of the collector, and one more.
pub(in crate::symbolic) const SPARE_NODES: u64 = (3 * 2) << 16;

/// The stack of a table's thread, and 64 MiB for the rest of the process.
const THREAD_BYTES: usize = (1 << 30) + (64 << 20);

/// The number of times that the system is asked again for the memory and the thread of a table: after 1 ms,
/// another 2 ms and so on, 0.5 s in all.
const MOST_WAITS: u64 = 31;

/// Entries of the operation cache per node of the set of states.
const CACHE_PER_NODE: u64 = 400;
/// Maximum number of entries of the operation cache; more bring no gain.
const LARGEST_CACHE: u64 = 1 << 23;

/// Entries of the operation cache per valuation of the bits of a state, if these are few.
const CACHE_PER_VALUATION: u64 = 64;

/// Creates a manager for `nodes` nodes, if the system grants its memory and a thread.
///
/// OxiDD assumes both: without the memory it aborts the process; without the thread, which has a
/// stack of 1 GiB and remains idle, it panics. A thread and the memory are therefore asked for and given
/// back first, together with some for the rest of the process, which would end without it. The panic
/// occurs before any diagram exists, and is caught.
///
/// The threads of a manager end a moment after it is dropped, and nobody can wait for them. Until then,
/// the system may refuse those of the next one. So it is asked again for a while.
///
/// # Errors
/// A limit of the system: the memory or the thread.
pub(in crate::symbolic) fn manager(nodes: u64, cache_entries: u64) -> Result<BDDManagerRef> {
    let mut made = ask(nodes, cache_entries);
    for wait in 1..=MOST_WAITS {
        if made.is_ok() {
            break;
        }
        pause(Duration::from_millis(wait));
        made = ask(nodes, cache_entries);
    }
    Ok(made?)
}

/// Waits in another thread: the C library keeps the stack of a thread that has ended until another one ends.
fn pause(time: Duration) {
    let waiting = std::thread::Builder::new().spawn(move || std::thread::sleep(time));
    match waiting {
        Ok(thread) => drop(thread.join()),
        Err(_) => std::thread::sleep(time),
    }
}

/// Asks the system once for a manager, its memory and its thread.
fn ask(nodes: u64, cache_entries: u64) -> Result<BDDManagerRef, Limit> {
    let capacity = table_size(nodes);
    let bytes = capacity * BYTES_PER_NODE + cache_entries * BYTES_PER_ENTRY;
    let (end, wait) = std::sync::mpsc::channel::<()>();
    let idle = move || wait.recv().is_err();
    let thread = std::thread::Builder::new().stack_size(THREAD_BYTES).spawn(idle);
    let thread = thread.map_err(|_| no_thread())?;
    let granted = grants(bytes);
    drop(end);
    drop(thread.join());
    if !granted {
        let mib = bytes.div_ceil(1 << 20);
        let what = format!("a node table of {mib} MiB");
        return Err(Limit::System { what, bytes: Some(bytes) });
    }
    let make = || oxidd::bdd::new_manager(capacity as usize, cache_entries as usize, 1);
    std::panic::catch_unwind(make).map_err(|_| no_thread())
}

fn no_thread() -> Limit {
    let what = "the thread of the node table, with a stack of 1 GiB".to_owned();
    Limit::System { what, bytes: None }
}

/// Returns the size of OxiDD's table for a number of nodes. The table is so large that its threads
/// have spare nodes and that it is never 95 % full: then OxiDD would collect garbage in the
/// background. That would clear the operation cache at any time, and a collection that the store
/// asks for meanwhile does nothing. The system maps pages of the table only when they are used.
fn table_size(nodes: u64) -> u64 {
    (nodes + SPARE_NODES) / 15 * 16 + 16
}

/// Returns the number of entries of the operation cache that suits a set of states with a number of nodes.
pub(in crate::symbolic) fn cache_for_nodes(states: usize) -> u64 {
    (states as u64).saturating_mul(CACHE_PER_NODE).clamp(1, LARGEST_CACHE).next_power_of_two()
}

/// Returns the number of entries of the operation cache that suits states of `width` bits. With more, a small model would
/// spend most of its time on the cache, because all of its memory is written first.
pub(in crate::symbolic) fn cache_for_bits(width: usize) -> u64 {
    CACHE_PER_VALUATION << width.min(32)
}

/// Returns the largest power of two that is at most `wanted` and fits into an eighth of the memory;
/// at least 2^10.
pub(in crate::symbolic) fn cache_entries(memory: u64, wanted: u64) -> u64 {
    let most = (memory / 8 / BYTES_PER_ENTRY).max(1);
    (1u64 << most.min(wanted.max(1)).ilog2()).max(1 << 10)
}

#[cfg(test)]
mod tests {
    use super::{SPARE_NODES, cache_for_nodes, table_size};

    #[test]
    fn a_cache_suits_the_states() {
        let entries = [0, 10, 10_000, 1 << 60].map(cache_for_nodes);
        assert_eq!(entries, [1, 1 << 12, 1 << 22, 1 << 23]);
    }

    #[test]
    fn allowed_and_spare_nodes_fill_less_than_95_percent_of_a_table() {
        for nodes in [16, 1 << 20, 1 << 30] {
            let used = nodes + SPARE_NODES;
            let size = table_size(nodes);
            // OxiDD computes the mark in this way.
            assert!(used < size / 100 * 95, "{used} of {size}");
            assert!(size < 1 << 31);
        }
    }
}
