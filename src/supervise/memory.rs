//! Sizes such as `2GiB`, and the memory of the machine.

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

/// Returns half of the memory that this process may use: of the machine, or of the control group if
/// its limit is lower. Returns 2 GiB if neither is known.
pub fn default_memory() -> u64 {
    let limits = [machine_memory(), control_group_limit()];
    limits.into_iter().flatten().min().map_or(2 << 30, |all| all / 2)
}

fn machine_memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find(|l| l.starts_with("MemTotal:"))?;
    let kib: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib * 1024)
}

fn control_group_limit() -> Option<u64> {
    let files = ["/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"];
    files.iter().find_map(|f| std::fs::read_to_string(f).ok()?.trim().parse().ok())
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
    fn the_memory_of_the_machine_and_of_the_process_is_found() {
        assert!(default_memory() > 1 << 20);
        assert!(peak_rss() > 1 << 16);
    }
}
