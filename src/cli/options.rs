//! Options that several commands share.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};
use meliora::engine::{Scope, Storage};
use meliora::error::Error;
use meliora::planning::{Options, Safety};

use super::size;
use super::sweep::ranges;

/// Headings in `--help`: what is below them comes after what a command is about.
pub(super) const LIMITS: &str = "Engine and limits";
const OUTPUT: &str = "Output";

/// The model and how to work on it.
#[derive(Debug, Clone, Args)]
pub(super) struct ModelArgs {
    /// The model, in PRISM's language or in JANI; `-` reads it from standard input
    #[arg(value_name = "MODEL")]
    pub(super) model: PathBuf,

    /// Values of undefined constants, such as K=4,N=3 (repeatable); `check`, `reach` and `compare` take
    /// ranges N=1:5, N=0:2:10 and lists N={2,4,8} too
    #[arg(short = 'c', long = "const", value_name = "NAME=VALUE,…", value_parser = constant_list)]
    constants: Vec<String>,

    /// Bounds for integers that have none in a JANI model, such as x=0..7,y=-1..1 (repeatable)
    #[arg(long, value_name = "NAME=LOW..HIGH,…")]
    bounds: Vec<String>,

    /// Which valuations are states
    #[arg(long, value_enum, default_value_t)]
    pub(super) scope: ScopeArg,

    /// The order of the BDD variables: as declared, chosen by the program, or a file with one name
    /// a line
    #[arg(help_heading = LIMITS, long, value_name = "declared|auto|FILE", default_value = "auto")]
    pub(super) order: String,

    /// Memory for node table and operation cache, or for the arrays of the explicit engine, such
    /// as 2GiB [default: half of the machine's memory]
    #[arg(help_heading = LIMITS, long, value_name = "SIZE", value_parser = size::parse)]
    pub(super) memory: Option<u64>,

    /// Use at most so many threads, and no more than the machine runs at once
    #[arg(help_heading = LIMITS, long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    pub(super) threads: u16,

    /// End the work after this time, such as 30s or 5m, with what is known by then
    #[arg(help_heading = LIMITS, long, value_name = "DURATION", value_parser = duration)]
    pub(super) timeout: Option<Duration>,

    /// The constants of one instance of a sweep, in place of `--const`; implies `--json`
    #[arg(long, hide = true, value_name = "NAME=VALUE,…")]
    pub(super) instance: Option<String>,

    /// So many instances of a sweep share the memory
    #[arg(long, hide = true, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    beside: u64,
}

impl ModelArgs {
    /// The model's path as it is named in reports.
    pub(super) fn path(&self) -> String {
        self.model.display().to_string()
    }

    /// The bytes that an engine may use.
    pub(super) fn memory(&self) -> u64 {
        self.memory.unwrap_or_else(size::default_memory) / self.beside
    }

    /// The threads that the symbolic engine may use.
    pub(super) fn threads(&self) -> u32 {
        let most = std::thread::available_parallelism().map_or(1, usize::from);
        u32::from(self.threads).min(u32::try_from(most).unwrap_or(u32::MAX))
    }

    /// All of `--const` as one list.
    pub(super) fn constants(&self) -> String {
        self.instance.clone().unwrap_or_else(|| self.constants.join(","))
    }

    /// The same with other constants.
    pub(super) fn with_constants(&self, constants: &str) -> Self {
        ModelArgs { instance: None, constants: vec![constants.to_owned()], ..self.clone() }
    }

    /// All of `--bounds` as one list.
    pub(super) fn bounds(&self) -> String {
        self.bounds.join(",")
    }
}

/// `--engine`.
#[derive(Debug, Clone, Copy, Args)]
pub(super) struct EngineArgs {
    /// How states are stored: as decision diagrams or one by one
    #[arg(help_heading = LIMITS, long, value_enum, default_value_t)]
    pub(super) engine: EngineArg,
}

impl EngineArgs {
    /// Refuses what makes no sense for the engine.
    ///
    /// # Errors
    /// Usage.
    pub(super) fn validate(self, model: &ModelArgs) -> Result<(), Error> {
        match self.engine {
            EngineArg::Explicit if model.order != "auto" => Err(Error::Usage(
                "`--order` orders BDD variables: it cannot be used with `--engine explicit`, which has none"
                    .to_owned(),
            )),
            _ => Ok(()),
        }
    }
}

/// The preferences and what is asked of them.
#[derive(Debug, Clone, Args)]
pub(super) struct PreferenceArgs {
    /// The preference file; `-` reads standard input
    #[arg(value_name = "PREFS")]
    pub(super) preferences: PathBuf,

    /// What is kept of a choice that may weaken
    #[arg(long, value_enum, default_value_t)]
    pub(super) safety: SafetyArg,

    /// End the search for levels after so many
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    max_level: Option<u32>,
}

impl PreferenceArgs {
    /// What to compute.
    pub(super) fn options(&self) -> Options {
        let max_level = self.max_level.map(|n| usize::try_from(n).unwrap_or(usize::MAX));
        Options { safety: self.safety.into(), max_level }
    }

    /// The preference file's path as it is named in reports.
    pub(super) fn path(&self) -> String {
        self.preferences.display().to_string()
    }
}

/// What is shown.
#[derive(Debug, Clone, Args)]
pub(super) struct ShownArgs {
    /// Write one JSON object instead of text
    #[arg(help_heading = OUTPUT, long)]
    pub(super) json: bool,

    /// Tell more on stderr (twice: everything)
    #[arg(help_heading = OUTPUT, short, long, action = clap::ArgAction::Count)]
    pub(super) verbose: u8,

    /// No warnings and no progress
    #[arg(help_heading = OUTPUT, short, long, conflicts_with = "verbose")]
    pub(super) quiet: bool,

    /// Colours; auto: on a terminal, unless `NO_COLOR` is set
    #[arg(help_heading = OUTPUT, long, value_enum, default_value_t, value_name = "WHEN")]
    pub(super) color: Color,
}

impl ShownArgs {
    /// What is shown of this model: an instance of a sweep answers in JSON, and warns only when asked.
    pub(super) fn of(&self, model: &ModelArgs) -> Self {
        let is_instance = model.instance.is_some();
        let quiet = self.quiet || (is_instance && self.verbose == 0);
        ShownArgs { json: self.json || is_instance, quiet, ..self.clone() }
    }
}

/// Which valuations are states.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(super) enum ScopeArg {
    /// Those reachable from the initial states
    #[default]
    Reachable,
    /// Every valuation of the declared variables
    All,
}

impl From<ScopeArg> for Scope {
    fn from(scope: ScopeArg) -> Self {
        match scope {
            ScopeArg::Reachable => Scope::Reachable,
            ScopeArg::All => Scope::All,
        }
    }
}

/// How states are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(super) enum EngineArg {
    /// Sets of states as binary decision diagrams
    #[default]
    Symbolic,
    /// States one by one
    Explicit,
}

impl From<EngineArg> for Storage {
    fn from(engine: EngineArg) -> Self {
        match engine {
            EngineArg::Symbolic => Storage::Symbolic,
            EngineArg::Explicit => Storage::Explicit,
        }
    }
}

impl EngineArg {
    /// The name in reports.
    pub(super) fn name(self) -> &'static str {
        Storage::from(self).name()
    }
}

/// What is kept of a choice that may weaken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(super) enum SafetyArg {
    /// Choices none of whose successors weakens the state: no step of any play weakens
    #[default]
    Action,
    /// The paper's construction: weakening successors are dropped, the others of the choice stay
    Transition,
    /// No later prefix weakens the one where planning started
    Prefix,
}

impl SafetyArg {
    /// The name in reports.
    pub(super) fn name(self) -> &'static str {
        Safety::from(self).name()
    }
}

impl From<SafetyArg> for Safety {
    fn from(safety: SafetyArg) -> Self {
        match safety {
            SafetyArg::Action => Safety::Action,
            SafetyArg::Transition => Safety::Transition,
            SafetyArg::Prefix => Safety::Prefix,
        }
    }
}

/// When colours are used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
#[repr(u8)]
pub(super) enum Color {
    /// On a terminal, unless `NO_COLOR` is set
    #[default]
    Auto,
    /// Always
    Always,
    /// Never
    Never,
}

/// Refuses what is not of the form `K=4,N=3`; the values are read by the front end, which knows the
/// types.
fn constant_list(text: &str) -> Result<String, String> {
    for part in ranges::parts(text) {
        let (name, value) = part.split_once('=').unwrap_or((part, ""));
        if name.trim().is_empty() || value.trim().is_empty() {
            return Err(format!("`{part}` is not of the form NAME=VALUE"));
        }
    }
    Ok(text.to_owned())
}

/// `1h 30m`, `500ms`, or a bare number of seconds.
pub(super) fn duration(text: &str) -> Result<Duration, String> {
    let parsed = match text.trim().parse::<f64>() {
        Ok(seconds) => Duration::try_from_secs_f64(seconds).map_err(|e| e.to_string()),
        Err(_) => humantime::parse_duration(text).map_err(|e| e.to_string()),
    };
    match parsed {
        Ok(duration) if duration.is_zero() => Err("a time limit must be longer than nothing".to_owned()),
        Ok(duration) => Ok(duration),
        Err(e) => Err(format!("{e}; a duration is written as 500ms, 30s, 5m or 1h30m")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_are_names_with_values() {
        for (text, fits) in
            [("K=4, x = 1.5", true), ("K", false), ("K=4,,", false), ("=4", false), ("K=", false)]
        {
            assert_eq!(constant_list(text).is_ok(), fits, "{text}");
        }
    }

    #[test]
    fn durations_have_units_or_are_seconds() {
        assert_eq!(duration("500ms"), Ok(Duration::from_millis(500)));
        assert_eq!(duration("2"), Ok(Duration::from_secs(2)));
        assert_eq!(duration("1h 1m"), Ok(Duration::from_secs(3660)));
        for text in ["0", "-1", "soon", "1 apple", "inf", "nan"] {
            assert!(duration(text).is_err(), "{text}");
        }
    }
}
