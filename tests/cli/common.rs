//! Helpers shared by the tests of the command.

#![allow(dead_code, unreachable_pub, reason = "each test file uses a part")]

use std::ffi::OsStr;
use std::io::Write;
use std::process::Command;

use tempfile::TempDir;

use crate::common::prelude::*;

/// The command, without the environment's wishes for colours.
pub fn executable() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_meliora"));
    command.env_remove("NO_COLOR").env_remove("CLICOLOR_FORCE").current_dir(env!("CARGO_MANIFEST_DIR"));
    command
}

/// The command with arguments split at white space; those in `'…'` are whole.
pub fn run(arguments: &str) -> Finished {
    Finished::of(executable().args(words(arguments)))
}

fn words(arguments: &str) -> Vec<String> {
    let mut words = Vec::new();
    for (at, part) in arguments.split('\'').enumerate() {
        match at % 2 {
            0 => words.extend(part.split_whitespace().map(str::to_owned)),
            _ => words.push(part.to_owned()),
        }
    }
    words
}

/// The command line, the exit status and the output of a finished run.
#[derive(Debug, Clone)]
pub struct Finished {
    pub asked: String,
    pub status: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Finished {
    pub fn of(command: &mut Command) -> Self {
        let output = command.output().unwrap();
        Finished {
            asked: format!("{command:?}"),
            status: output.status.code().unwrap_or(-1),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Runs a command that reads a text, which a pipe can hold, from standard input.
    pub fn reading(command: &mut Command, input: &str) -> Self {
        let (reader, mut writer) = std::io::pipe().unwrap();
        writer.write_all(input.as_bytes()).unwrap();
        drop(writer);
        Finished::of(command.stdin(reader))
    }

    /// The one JSON object on stdout.
    pub fn json(&self) -> Json {
        serde_json::from_str(&self.stdout).unwrap_or_else(|e| panic!("{e}: {self:?}"))
    }

    /// Checks that standard error contains a text.
    #[track_caller]
    pub fn says(&self, text: impl AsRef<str>) -> &Self {
        assert!(self.stderr.contains(text.as_ref()), "{}: {}\n{}", text.as_ref(), self.asked, self.stderr);
        self
    }

    /// Checks that standard output contains a text.
    #[track_caller]
    pub fn shows(&self, text: impl AsRef<str>) -> &Self {
        assert!(self.stdout.contains(text.as_ref()), "{}: {}\n{}", text.as_ref(), self.asked, self.stdout);
        self
    }

    /// Requires an exit status, and a text on standard error.
    #[track_caller]
    pub fn ends(self, status: i32, text: impl AsRef<str>) -> Self {
        self.expect(status).says(text).clone()
    }

    /// Requires an exit status, and a text on standard output.
    #[track_caller]
    pub fn prints(self, status: i32, text: impl AsRef<str>) -> Self {
        self.expect(status).shows(text).clone()
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

    /// Runs the command here. Files below `models` are those of the repository.
    pub fn run(&self, arguments: impl AsRef<str>) -> Finished {
        self.ask(arguments, &[] as &[&str])
    }

    /// Runs the command here, with more arguments.
    pub fn ask(
        &self,
        arguments: impl AsRef<str>,
        more: impl IntoIterator<Item = impl AsRef<OsStr>>,
    ) -> Finished {
        let here = |word: String| match word.starts_with("models/") {
            true => format!("{}/{word}", env!("CARGO_MANIFEST_DIR")),
            false => word,
        };
        let arguments = words(arguments.as_ref()).into_iter().map(here);
        Finished::of(executable().current_dir(self.path("")).args(arguments).args(more))
    }

    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    pub fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        fs::write(self.path(name), text).unwrap();
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
