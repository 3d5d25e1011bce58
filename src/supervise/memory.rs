//! Sizes such as `2GiB`, and the memory of the machine.

use meliora_base::memory::STACK;

/// The memory that a process may use in addition to its limit, in bytes: for the program, texts and
/// results.
pub(super) const ALLOWANCE: u64 = 64 << 20;

/// Reads a number of bytes: `1048576`, `512MiB`, `2GB`, `1.5g`. `KiB`, `MiB`, `GiB`, `TiB` and the
/// bare letters are powers of 1024; `KB`, `MB`, `GB` and `TB` powers of 1000.
///
/// # Errors
/// The text is not a size, or the size is 0.
pub fn parse(text: &str) -> Result<u64, String> {
    const ADVICE: &str = "a size is a positive number and a unit, such as 512MiB or 2GiB";
    let trimmed = text.trim();
    let split = trimmed.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(trimmed.len());
    let (number, unit) = trimmed.split_at(split);
    let number: f64 = number.parse().map_err(|_| ADVICE.to_owned())?;
    let factor: f64 = match unit.trim().to_ascii_lowercase().as_str() {
        "" | "b" => 1.0,
        "k" | "kib" => 1024.0,
        "m" | "mib" => 1024.0 * 1024.0,
        "g" | "gib" => 1024.0 * 1024.0 * 1024.0,
        "t" | "tib" => 1024.0 * 1024.0 * 1024.0 * 1024.0,
        "kb" => 1e3,
        "mb" => 1e6,
        "gb" => 1e9,
        "tb" => 1e12,
        other => return Err(format!("`{other}` is not a unit; {ADVICE}")),
    };
    let bytes = number * factor;
    if (1.0..1e18).contains(&bytes) { Ok(bytes as u64) } else { Err(ADVICE.to_owned()) }
}

/// A limit of the system on the address space of this process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AddressLimit {
    /// The limit, in bytes.
    pub bytes: u64,
    /// The option of the shell's `ulimit` that sets it: `v` for all addresses, `d` for data.
    pub option: char,
}

/// The addresses that are no memory of the work, in bytes: the stacks of the worker thread and of the
/// threads of two node tables, and what the process may use in addition.
const OTHER_ADDRESSES: u64 = STACK as u64 + (2 << 30) + ALLOWANCE;

/// Returns the memory for the work if the user names none: half of the memory of the machine or, if that
/// is less, of its control group. If the addresses of the process are limited, it is at most a third of
/// those that the stacks of threads leave: a node table exists twice while it grows, and the process
/// needs memory for itself. Returns 2 GiB if no limit is known.
pub fn default_memory() -> u64 {
    let memory = [machine_memory(), control_group_limit()].into_iter().flatten().min();
    share(memory, address_limit().map(|limit| limit.bytes))
}

fn share(memory: Option<u64>, addresses: Option<u64>) -> u64 {
    let share = memory.map_or(2 << 30, |all| all / 2);
    // Without diagrams, little memory and no large stacks are needed.
    addresses.map_or(share, |all| share.min((all.saturating_sub(OTHER_ADDRESSES) / 3).max(ALLOWANCE)))
}

/// Returns the lowest limit on the address space of this process, if there is one.
pub fn address_limit() -> Option<AddressLimit> {
    #[cfg(unix)]
    {
        use rustix::process::{Resource, getrlimit};
        let limits = [(Resource::As, 'v'), (Resource::Data, 'd')];
        let of = |(resource, option)| getrlimit(resource).current.map(|bytes| AddressLimit { bytes, option });
        limits.into_iter().filter_map(of).min_by_key(|limit| limit.bytes)
    }
    #[cfg(not(unix))]
    None
}

fn machine_memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find(|l| l.starts_with("MemTotal:"))?;
    let kib: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib * 1024)
}

/// Returns the lowest memory limit of the control groups of this process.
fn control_group_limit() -> Option<u64> {
    let groups = std::fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    let read = |file: String| std::fs::read_to_string(file).ok()?.trim().parse().ok();
    limit_files(&groups).into_iter().filter_map(read).min()
}

/// Returns the files with the memory limits of the control groups in `/proc/self/cgroup`, and of those that
/// contain them.
fn limit_files(groups: &str) -> Vec<String> {
    const ROOT: &str = "/sys/fs/cgroup";
    let mut files = vec![format!("{ROOT}/memory.max"), format!("{ROOT}/memory/memory.limit_in_bytes")];
    for line in groups.lines() {
        let mut parts = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(path)) = (parts.next(), parts.next()) else { continue };
        let (folder, name) = match controllers {
            "" => ("", "memory.max"),
            _ if controllers.split(',').any(|c| c == "memory") => ("/memory", "memory.limit_in_bytes"),
            _ => continue,
        };
        let inner = path.match_indices('/').skip(1).map(|(at, _)| &path[..at]).chain([path]);
        files.extend(inner.filter(|path| *path != "/").map(|path| format!("{ROOT}{folder}{path}/{name}")));
    }
    files
}

/// Returns the largest resident set of this process so far, in bytes; 0 if the system does not
/// tell.
pub fn peak_rss() -> u64 {
    let high_water = || {
        let text = std::fs::read_to_string("/proc/self/status").ok()?;
        let line = text.lines().find(|l| l.starts_with("VmHWM:"))?;
        let kib: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
        Some(kib * 1024)
    };
    high_water().or_else(resident).unwrap_or(0)
}

/// Returns the resident set of this process in bytes; `None` if the system does not tell.
pub fn resident() -> Option<u64> {
    memory_stats::memory_stats().map(|m| m.physical_mem as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_binary_and_decimal_units() {
        for (text, bytes) in
            [("1", 1), ("1MiB", 1 << 20), ("1.5g", 3 << 29), ("2GB", 2_000_000_000), (" 4 k ", 4096)]
        {
            assert_eq!(parse(text), Ok(bytes), "{text}");
        }
    }

    #[test]
    fn what_is_no_size_is_refused() {
        for text in ["", "0", "GiB", "-1", "1.2.3", "5 apples", "nan", "1e3", "99999999TiB"] {
            assert!(parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn the_share_is_of_the_least_of_the_machine_the_control_group_and_the_addresses() {
        assert_eq!(share(None, None), 2 << 30);
        assert_eq!(share(Some(24 << 30), None), 12 << 30);
        assert_eq!(share(Some(24 << 30), Some(1 << 40)), 12 << 30);
        assert_eq!(share(Some(24 << 30), Some(6 << 30)), ((6 << 30) - (2 << 30) - (576 << 20)) / 3);
        assert_eq!(share(Some(24 << 30), Some(1 << 30)), 64 << 20);
        assert_eq!(share(Some(64 << 20), Some(1 << 30)), 32 << 20);
    }

    #[test]
    fn the_limits_of_all_control_groups_around_the_process_count() {
        let v2 = limit_files("0::/user.slice/job.scope\n");
        assert_eq!(
            v2[2..],
            ["/sys/fs/cgroup/user.slice/memory.max", "/sys/fs/cgroup/user.slice/job.scope/memory.max"]
        );
        let v1 = limit_files("5:cpu:/a\n4:memory,hugetlb:/a:b\n0::/\n");
        assert_eq!(v1[2..], ["/sys/fs/cgroup/memory/a:b/memory.limit_in_bytes"]);
    }

    #[test]
    fn the_memory_of_the_machine_and_of_the_process_is_found() {
        assert!(default_memory() > 1 << 20);
        assert!(peak_rss() > 1 << 16);
    }
}
