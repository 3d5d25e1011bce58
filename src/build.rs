//! The build script: tells the command the commit that it is built from.

use std::process::Command;

fn main() {
    // Git writes to this log with each commit and each change of the branch.
    match git(&["rev-parse", "--git-path", "logs/HEAD"]) {
        Some(log) => println!("cargo::rerun-if-changed={log}"),
        None => println!("cargo::rerun-if-changed=src/build.rs"),
    }
    let commit = git(&["rev-parse", "--short=12", "HEAD"]).unwrap_or_else(|| "unknown".to_owned());
    println!("cargo::rustc-env=MELIORA_COMMIT={commit}");
}

/// Returns what git prints; `None` without git, or if the sources are in no repository of their own.
fn git(arguments: &[&str]) -> Option<String> {
    // The sources may lie in the repository of another project.
    if !std::path::Path::new(".git").exists() {
        return None;
    }
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    (output.status.success() && !text.trim().is_empty()).then(|| text.trim().to_owned())
}
