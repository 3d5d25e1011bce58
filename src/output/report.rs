//! The parts that all reports share.

use std::io;

use serde::Serialize;
use serde_json::{Map, Value as Json};

use super::Number;
use super::style::Style;
use crate::engine::Engine;
use crate::error::{Error, Limit, Result};
use crate::model::value::{Type, Value};
use crate::model::{ModelKind, Program};
use crate::planning::result::ModelCounts;

/// The result of a command as plain data.
pub trait Report: Serialize {
    /// Marks the report as incomplete, with the reason.
    fn fail(&mut self, failure: Failure);
    /// Adds the seconds of the whole run and the largest resident set in bytes.
    fn finish(&mut self, seconds: f64, peak_rss_bytes: u64);
    /// Renders the report as text.
    fn text(&self, style: Style) -> String;

    /// Writes the report as text. Long reports are written in pieces.
    ///
    /// # Errors
    /// The output cannot be written.
    fn write(&self, style: Style, out: &mut dyn io::Write) -> io::Result<()> {
        out.write_all(self.text(style).as_bytes())
    }

    /// Returns whether the question was a yes/no question and the answer is no.
    fn is_no(&self) -> bool {
        false
    }
}

/// The sort of an error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FailureKind {
    /// The model, the preferences, an expression or a file is wrong.
    Input,
    /// A limit of memory, nodes or time.
    Resource,
    /// The command line is wrong.
    Usage,
    /// A bug in this program.
    Internal,
}

/// An error in JSON.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Failure {
    /// `meliora.error/1`
    pub schema: &'static str,
    /// The sort of error.
    pub kind: FailureKind,
    /// The message.
    pub message: String,
    /// The file that is wrong.
    pub file: Option<String>,
    /// The line, from 1.
    pub line: Option<usize>,
    /// The column in characters, from 1.
    pub column: Option<usize>,
    /// True if the user interrupted the work.
    #[serde(skip)]
    pub interrupted: bool,
}

impl Failure {
    /// Creates a failure without a place.
    pub fn new(kind: FailureKind, message: impl Into<String>) -> Self {
        let message = message.into();
        let schema = "meliora.error/1";
        Failure { schema, kind, message, file: None, line: None, column: None, interrupted: false }
    }
}

impl From<&Error> for Failure {
    fn from(error: &Error) -> Self {
        let mut failure = match error {
            Error::Limit(_) => Failure::new(FailureKind::Resource, error.to_string()),
            Error::Usage(_) | Error::ForeignSet => Failure::new(FailureKind::Usage, error.to_string()),
            Error::Input(_) | Error::Dump { .. } | Error::Io { .. } => {
                Failure::new(FailureKind::Input, error.to_string())
            }
        };
        match error {
            Error::Input(diagnostics) => {
                if let Some(first) = diagnostics.first() {
                    failure.message.clone_from(&first.message);
                    failure.file = Some(first.source.name.clone());
                    let (line, column) = first.position();
                    (failure.line, failure.column) = (Some(line), Some(column));
                }
            }
            Error::Dump { file, line, message } => {
                failure.message.clone_from(message);
                failure.file = Some(file.clone());
                failure.line = Some(*line);
            }
            Error::Io { path, .. } => failure.file = Some(path.clone()),
            Error::Limit(limit) => failure.interrupted = *limit == Limit::Interrupted,
            Error::Usage(_) | Error::ForeignSet => {}
        }
        failure
    }
}

/// The model of a report.
#[derive(Debug, Clone, Default, Serialize)]
pub struct ModelSummary {
    /// The file as the user named it.
    pub path: String,
    /// `mdp` or `dtmc`.
    #[serde(rename = "type")]
    pub kind: Option<&'static str>,
    /// The constants given by `--const`.
    pub constants: Map<String, Json>,
    /// The variables in the order of declaration.
    pub variables: Vec<VariableSummary>,
}

/// A variable of the model.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct VariableSummary {
    /// Its name.
    pub name: String,
    /// `bool` or `int`.
    #[serde(rename = "type")]
    pub ty: &'static str,
    /// The smallest value.
    pub low: i64,
    /// The largest value.
    pub high: i64,
    /// Number of bits of its encoding.
    pub bits: u32,
    /// The names of its values from `low` on, if they have names.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub values: Vec<String>,
}

impl ModelSummary {
    /// Creates a summary that knows only the path.
    pub fn of_path(path: &str) -> Self {
        ModelSummary { path: path.to_owned(), ..ModelSummary::default() }
    }

    /// Summarises a model.
    pub fn of(path: &str, program: &Program) -> Self {
        let constant = |name: &String| {
            let value = program.constants.iter().find(|(n, _)| n == name)?.1;
            Some((name.clone(), json_value(value)))
        };
        let variable = |v: &crate::model::Variable| VariableSummary {
            name: v.name.clone(),
            ty: if v.ty == Type::Bool { "bool" } else { "int" },
            low: v.low,
            high: v.high,
            bits: v.bits(),
            values: v.values.clone(),
        };
        ModelSummary {
            path: path.to_owned(),
            kind: Some(match program.kind {
                ModelKind::Mdp => "mdp",
                ModelKind::Dtmc => "dtmc",
            }),
            constants: program.given_constants.iter().filter_map(constant).collect(),
            variables: program.variables.iter().map(variable).collect(),
        }
    }

    /// Returns the number of bits of all variables.
    pub fn bits(&self) -> u64 {
        self.variables.iter().map(|v| u64::from(v.bits)).sum()
    }
}

/// Converts a value of a constant to JSON. An infinite value becomes a string.
fn json_value(value: Value) -> Json {
    match value {
        Value::Bool(b) => Json::Bool(b),
        Value::Int(i) => Json::from(i),
        Value::Real(x) => {
            serde_json::Number::from_f64(x).map_or_else(|| value.to_string().into(), Json::Number)
        }
    }
}

/// Converts a state to an object from variables to values.
pub fn json_state(program: &Program, state: &[i64]) -> Map<String, Json> {
    let value = |v: &crate::model::Variable, x: i64| match (v.ty, v.value_name(x)) {
        (_, Some(name)) => Json::from(name),
        (Type::Bool, None) => Json::Bool(x != 0),
        _ => Json::from(x),
    };
    program.variables.iter().zip(state).map(|(v, &x)| (v.name.clone(), value(v, x))).collect()
}

/// Formats a state as `x=1,b=false`.
pub fn show_state(state: &Map<String, Json>) -> String {
    let show = |value: &Json| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    state.iter().map(|(name, value)| format!("{name}={}", show(value))).collect::<Vec<_>>().join(",")
}

/// The numbers of states, choices and transitions of a model.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Number of states in the scope; with monitors, of states of the product.
    pub states: Number,
    /// Number of states without monitors, if there are monitors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub model_states: Option<Number>,
    /// Number of pairs of a state and a choice enabled there.
    pub choices: Number,
    /// Number of triples (s, a, s').
    pub transitions: Number,
    /// Number of states without an enabled command.
    pub deadlocks: Number,
    /// Number of initial states.
    pub initial: Number,
}

impl Counts {
    /// Counts the model of an engine.
    ///
    /// # Errors
    /// A limit of the engine is hit.
    pub fn of<E: Engine>(engine: &E) -> Result<Self> {
        Ok(Counts::from(&ModelCounts::of(engine)?))
    }

    /// Counts some states with their choices and transitions.
    ///
    /// # Errors
    /// A limit of the engine is hit.
    pub fn within<E: Engine>(engine: &E, states: &E::States) -> Result<Self> {
        let choices = engine.choices_in(&engine.all_choices(), states)?;
        let deadlocks = engine.intersection(&engine.deadlock_states(), states)?;
        Ok(Counts {
            states: engine.count(states)?.into(),
            model_states: None,
            choices: engine.count(&choices)?.into(),
            transitions: engine.count_transitions(&choices, &engine.all_states())?.into(),
            deadlocks: engine.count(&deadlocks)?.into(),
            initial: engine.count(&engine.initial_states())?.into(),
        })
    }
}

impl From<&ModelCounts> for Counts {
    fn from(counts: &ModelCounts) -> Self {
        Counts {
            states: counts.states.clone().into(),
            model_states: counts.model_states.clone().map(Number::from),
            choices: counts.choices.clone().into(),
            transitions: counts.transitions.clone().into(),
            deadlocks: counts.deadlocks.clone().into(),
            initial: counts.initial.clone().into(),
        }
    }
}

/// The memory used.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct MemoryUse {
    /// The maximum number of live diagram nodes; 0 for the explicit engine.
    pub peak_nodes: u64,
    /// The largest resident set of the process, in bytes.
    pub peak_rss_bytes: u64,
}
