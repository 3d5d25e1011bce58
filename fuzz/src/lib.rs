//! The common part of all fuzz targets: the entry points, and a limit on memory.

#[path = "../../tests/common/entry.rs"]
pub mod entry;

/// The bytes that the library may allocate at any time. An allocation beyond ends the process, which is a finding.
const MEMORY: usize = 256 << 20;

/// libFuzzer's own limit on allocations needs a sanitizer.
#[global_allocator]
static ALLOCATOR: cap::Cap<std::alloc::System> = cap::Cap::new(std::alloc::System, MEMORY);
