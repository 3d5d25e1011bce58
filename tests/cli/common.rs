//! Helpers shared by the tests of the command.

#![allow(dead_code, unreachable_pub, reason = "each test file uses a part")]

use assert_cmd::Command;
use tempfile::TempDir;

use crate::common::prelude::*;

/// The command, without the environment's wishes for colours.
pub fn executable() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_meliora"));
    command.env_remove("NO_COLOR").env_remove("CLICOLOR_FORCE").current_dir(env!("CARGO_MANIFEST_DIR"));
    command
}

/// The command with arguments split at white space.
pub fn run(arguments: &str) -> Finished {
    Finished::of(executable().args(arguments.split_whitespace()))
}

/// The exit status and the output of a finished run.
#[derive(Debug)]
pub struct Finished {
    pub status: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Finished {
    pub fn of(command: &mut Command) -> Self {
        let output = command.output().unwrap();
        Finished {
            status: output.status.code().unwrap_or(-1),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// The one JSON object on stdout.
    pub fn json(&self) -> Json {
        serde_json::from_str(&self.stdout).unwrap_or_else(|e| panic!("{e}: {self:?}"))
    }

    /// Checks that standard error contains a text.
    pub fn says(&self, text: &str) {
        assert!(self.stderr.contains(text), "{text}: {}", self.stderr);
    }

    /// Requires an exit status.
    #[track_caller]
    pub fn expect(self, status: i32) -> Self {
        assert_eq!(self.status, status, "{self:#?}");
        self
    }
}

/// A directory with files, gone at the end of the test.
pub struct Scratch(TempDir);

impl Scratch {
    pub fn new(files: &[(&str, &str)]) -> Self {
        let scratch = Scratch(TempDir::new().unwrap());
        for (name, text) in files {
            std::fs::write(scratch.path(name), text).unwrap();
        }
        scratch
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn show(&self, name: &str) -> String {
        self.path(name).display().to_string()
    }
}

/// The keys of an object, in their order.
pub fn keys(value: &Json) -> Vec<&str> {
    value.as_object().unwrap().keys().map(String::as_str).collect()
}

/// Counters that take turns: many states, a long way, two objectives at its ends.
pub const LONG: &str = "mdp\nconst int N;\nmodule m\n x : [0..N] init 0; y : [0..N] init 0;\n\
    [a] x<N -> 0.5: (x'=x+1) + 0.5: (x'=max(x-1,0));\n [b] y<N & mod(x*y+x,7)!=3 -> (y'=mod(y*3+x,N));\n\
    [c] x>0 & mod(x*x+y*y,5)=1 -> (x'=mod(x*y+1,N));\nendmodule\n";

/// Preferences for [`LONG`].
pub const LONG_PREFS: &str = "objective A = F x=N; objective B = F (y=N-1 & x=0); prefer B > A;\n";
