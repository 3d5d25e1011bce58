//! Options that several commands share.

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::{Args, ValueEnum};
use meliora::supervise::{memory, parse_duration};
use meliora_base::error::Error;
use meliora_engine::{Scope, Selection, Storage};
use meliora_planning::{Options, Safety};
use meliora_report::Header;

use super::by_name::by_name;
use super::files::Target;
use super::model_files::ModelFiles;
use super::ranges;
use super::terminal::{Color, Form};

/// Heading in `--help`, below the options of the command itself.
pub(super) const LIMITS: &str = "Engine and limits";
const OUTPUT: &str = "Output";

/// The limits of a run.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// `--timeout`
    pub(super) timeout: Option<Duration>,
    /// `--memory`, in bytes.
    pub(super) memory: u64,
}

/// The model and the options for its construction.
#[derive(Debug, Clone, Args)]
pub(super) struct ModelArgs {
    #[command(flatten)]
    pub(super) model: ModelFiles,

    /// Values of undefined constants, such as K=4,N=3 (repeatable)
    #[arg(short = 'c', long = "const", value_name = "NAME=VALUE,…", value_parser = constant_list)]
    constants: Vec<String>,

    /// Bounds of integers that are unbounded in a JANI model, such as x=0..7,y=-1..1 (repeatable)
    #[arg(long, value_name = "NAME=LOW..HIGH,…")]
    bounds: Vec<String>,

    /// Players of a game who we are, such as p1,p3; all others are the opponent [default: those of the
    /// preference file, else the first player]
    #[arg(long, value_name = "PLAYER,…")]
    pub(super) coalition: Option<String>,

    /// Valuations of the variables that count as states
    #[arg(long, value_parser = by_name::<Scope>(), default_value = Scope::default().name())]
    pub(super) scope: Scope,

    /// Order of the BDD variables: as declared, chosen by a heuristic, or from a file with one name
    /// per line
    #[arg(help_heading = LIMITS, long, value_name = "declared|auto|FILE", default_value = "auto")]
    pub(super) order: String,

    /// Memory for the node table and the operation cache, or for the arrays of the explicit engine,
    /// such as 2GiB; the process needs up to 64 MiB more [default: half of the memory that the process
    /// may use]
    #[arg(help_heading = LIMITS, long, value_name = "SIZE", value_parser = memory::parse)]
    pub(super) memory: Option<u64>,

    /// Maximum number of threads: as many ways to the answer are tried at once [default: the cores that
    /// the process may use]
    #[arg(help_heading = LIMITS, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,

    /// Stop after this time, such as 30s or 5m, and print the partial results
    #[arg(help_heading = LIMITS, long, value_name = "DURATION", value_parser = parse_duration)]
    timeout: Option<Duration>,

    /// The constants of one instance of a sweep, instead of `--const`; prints what the sweep reads
    #[arg(long, hide = true, value_name = "NAME=VALUE,…")]
    pub(super) instance: Option<String>,

    /// The number of instances of a sweep that share the memory
    #[arg(long, hide = true, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    sharing: u64,
}

impl ModelArgs {
    /// Returns the header of a report about the model.
    pub(super) fn header(&self) -> Header {
        Header { scope: Some(self.scope), ..Header::of_model(&self.path()) }
    }

    /// Returns the path of the model as reports show it.
    pub(super) fn path(&self) -> String {
        self.model.shown()
    }

    /// Returns the memory limit of the engine, in bytes.
    pub(super) fn memory(&self) -> u64 {
        self.memory.unwrap_or_else(memory::default_memory) / self.sharing
    }

    /// Returns the number of threads.
    pub(super) fn threads(&self) -> usize {
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        self.threads.map_or_else(cores, usize::from)
    }

    /// Returns the limits of a run.
    pub(super) fn limits(&self) -> Limits {
        Limits { timeout: self.timeout, memory: self.memory() }
    }

    /// Returns all values of `--const` as one list.
    pub(super) fn constants(&self) -> String {
        self.instance.clone().unwrap_or_else(|| self.constants.join(","))
    }

    /// Returns these arguments with other constants.
    pub(super) fn with_constants(&self, constants: &str) -> Self {
        ModelArgs { instance: None, constants: vec![constants.to_owned()], ..self.clone() }
    }

    /// Returns all values of `--bounds` as one list.
    pub(super) fn bounds(&self) -> String {
        self.bounds.join(",")
    }
}

/// `--engine`.
#[derive(Debug, Clone, Copy, Args)]
pub(super) struct EngineArgs {
    /// Representation of states: in decision diagrams or one by one
    #[arg(help_heading = LIMITS, long, value_enum, default_value_t)]
    pub(super) engine: EngineChoice,
}

/// The values of `--engine`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(super) enum EngineChoice {
    /// Symbolic, unless the model is small enough for explicit to be faster
    #[default]
    Auto,
    /// Sets of states are binary decision diagrams
    Symbolic,
    /// States are stored one by one; for small models and cross-checks
    Explicit,
}

impl EngineArgs {
    /// Refuses options that do not fit the engine.
    ///
    /// # Errors
    /// [`Error::Usage`] for `--order` with the explicit engine.
    pub(super) fn validate(self, model: &ModelArgs) -> Result<(), Error> {
        match self.engine {
            EngineChoice::Explicit if model.order != "auto" => Err(Error::Usage(
                "`--order` orders BDD variables; it cannot be used with `--engine explicit`, which has none"
                    .to_owned(),
            )),
            _ => Ok(()),
        }
    }

    /// Returns the engine that the user has named.
    fn named(self) -> Option<Storage> {
        match self.engine {
            EngineChoice::Auto => None,
            EngineChoice::Symbolic => Some(Storage::Symbolic),
            EngineChoice::Explicit => Some(Storage::Explicit),
        }
    }

    /// Adds the engine to a header, if the user has named it.
    pub(super) fn header(self, header: Header) -> Header {
        Header { engine: self.named().map(Storage::name), ..header }
    }

    /// Returns the engine that the user has named, or else lets the states select one.
    pub(super) fn select(self, model: &ModelArgs) -> Selection {
        match self.named() {
            Some(storage) => Selection { storage, reason: None, is_open: false },
            None if model.order != "auto" => self.diagrams("`--order`"),
            None => Selection::open(),
        }
    }

    /// Returns the engine that the user has named, or else the symbolic one for this reason.
    pub(super) fn diagrams(self, reason: &str) -> Selection {
        let reason = self.named().is_none().then(|| reason.to_owned());
        Selection { storage: self.named().unwrap_or(Storage::Symbolic), reason, is_open: false }
    }
}

/// The preferences and the options of the analysis.
#[derive(Debug, Clone, Args)]
pub(super) struct PreferenceArgs {
    /// Preference file; `-` reads standard input
    #[arg(value_name = "PREFS")]
    pub(super) preferences: PathBuf,

    /// Treatment of actions that can make the prospects worse
    #[arg(long, value_parser = by_name::<Safety>(), default_value = Safety::default().name())]
    pub(super) safety: Safety,

    /// Maximum number of levels to compute
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    max_level: Option<u32>,
}

impl PreferenceArgs {
    /// Returns the header of a report about a model and these preferences.
    pub(super) fn header(&self, model: &ModelArgs) -> Header {
        model.header().with_preferences(&self.path(), self.safety)
    }

    /// Returns the options of the analysis.
    pub(super) fn options(&self) -> Options {
        let max_level = self.max_level.map(|n| usize::try_from(n).unwrap_or(usize::MAX));
        Options { safety: self.safety, max_level }
    }

    /// Returns the files of a model and these preferences.
    pub(super) fn inputs<'a>(&'a self, model: &'a ModelArgs) -> Vec<&'a Path> {
        model.model.paths().chain([self.preferences.as_path()]).collect()
    }

    /// Returns the path of the preference file as reports show it.
    pub(super) fn path(&self) -> String {
        self.preferences.display().to_string()
    }
}

/// The options for the output.
#[derive(Debug, Clone, Args)]
pub(super) struct ShownArgs {
    /// Print one JSON object instead of text
    #[arg(help_heading = OUTPUT, long)]
    pub(super) json: bool,

    /// Print more on stderr (-vv: everything)
    #[arg(help_heading = OUTPUT, short, long, action = clap::ArgAction::Count)]
    pub(super) verbose: u8,

    /// Print no warnings and no progress
    #[arg(help_heading = OUTPUT, short, long, conflicts_with = "verbose")]
    pub(super) quiet: bool,

    /// Use of colours; auto: on a terminal, unless `NO_COLOR` is set
    #[arg(help_heading = OUTPUT, long, value_enum, default_value_t, value_name = "WHEN")]
    pub(super) color: Color,

    /// True if standard output has comma-separated values in place of the text.
    #[arg(skip)]
    pub(super) csv: bool,

    /// True for an instance of a sweep, which hands over its report and its row.
    #[arg(skip)]
    pub(super) instance: bool,
}

impl ShownArgs {
    /// Returns the options for a run that also writes comma-separated values.
    ///
    /// # Errors
    /// Both `--csv` and `--json` are on standard output.
    pub(super) fn with_csv(&self, csv: Option<&Target>) -> Result<Self, Error> {
        let csv = csv.is_some_and(Target::is_stdout);
        if csv && self.json {
            let message = "`--csv` and `--json` cannot both be on standard output; give `--csv` a file";
            return Err(Error::Usage(message.to_owned()));
        }
        Ok(ShownArgs { csv, ..self.clone() })
    }

    /// Returns the form of results on standard output.
    pub(super) fn form(&self) -> Form {
        match (self.instance, self.json) {
            (true, _) => Form::Instance,
            (_, true) => Form::Json,
            _ => Form::Text,
        }
    }

    /// Returns the options for a model: an instance of a sweep prints JSON, and warns only on
    /// request.
    pub(super) fn of(&self, model: &ModelArgs) -> Self {
        let instance = model.instance.is_some();
        let quiet = self.quiet || (instance && self.verbose == 0);
        ShownArgs { json: self.json || instance, instance, quiet, ..self.clone() }
    }
}

/// Parses the argument of `--precision`.
///
/// # Errors
/// It is not a number between 0 and 1.
pub(super) fn precision(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x < 1.0 => Ok(x),
        _ => Err("expected a number between 0 and 1".to_owned()),
    }
}

/// Checks that a list has the form `K=4,N=3`. The front end reads the values, because it knows the
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
}
