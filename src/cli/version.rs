//! The texts of `--version` and `-V`.

use std::sync::LazyLock;

/// The versions of all packages that the command is built with.
const LOCK: &str = include_str!("../../Cargo.lock");

/// Returns the version, the commit, the features, and the version of OxiDD, a line each.
pub(super) fn long() -> &'static str {
    static LINES: LazyLock<String> = LazyLock::new(lines);
    &LINES
}

fn lines() -> String {
    let all = [
        ("cli", cfg!(feature = "cli")),
        ("output", cfg!(feature = "output")),
        ("supervise", cfg!(feature = "supervise")),
    ];
    let features = all.iter().filter_map(|&(name, is_on)| is_on.then_some(name)).collect::<Vec<_>>();
    format!(
        "{}\ncommit {}\nfeatures {}\noxidd {}",
        env!("CARGO_PKG_VERSION"),
        env!("MELIORA_COMMIT"),
        features.join(", "),
        locked("oxidd").unwrap_or("of unknown version"),
    )
}

/// Returns the version of a package.
fn locked(package: &str) -> Option<&'static str> {
    let (_, after) = LOCK.split_once(&format!("name = \"{package}\"\nversion = \""))?;
    after.split('"').next()
}
