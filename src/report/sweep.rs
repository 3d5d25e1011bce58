//! The report of a sweep: the reports of its instances.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value as Json};

use super::columns::Row;
use super::report::Failure;
use super::{CheckReport, CompareReport, ReachReport};

/// The results of a sweep.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[schemars(rename = "sweep")]
pub struct SweepReport {
    /// The kind and version of the object.
    #[schemars(extend("const" = Self::SCHEMA))]
    pub schema: &'static str,
    /// The command that writes the report of an instance.
    #[schemars(extend("enum" = ["check", "reach", "compare"]))]
    pub command: &'static str,
    /// The values of each constant that varies, as a list.
    pub ranges: Map<String, Json>,
    /// The instances in their order.
    pub runs: Vec<Instance>,
}

/// An instance of a sweep.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Instance {
    /// The constants of the instance.
    pub constants: Map<String, Json>,
    /// The end of the run.
    #[schemars(extend("enum" = ["done", "limit", "error"]))]
    pub status: &'static str,
    /// The object that the command writes for the instance, an error among them.
    #[schemars(with = "Any")]
    pub result: Json,
}

/// The objects of instances.
#[derive(JsonSchema)]
#[serde(untagged)]
#[expect(dead_code, reason = "only its schema is used")]
enum Any {
    Check(Box<CheckReport>),
    Reach(Box<ReachReport>),
    Compare(Box<CompareReport>),
    Error(Box<Failure>),
}

impl SweepReport {
    const SCHEMA: &str = "meliora.sweep/1";

    /// Creates the report of a command with its instances.
    pub fn new(command: &'static str, ranges: Map<String, Json>, runs: Vec<Instance>) -> Self {
        SweepReport { schema: Self::SCHEMA, command, ranges, runs }
    }
}

/// The result of the process of an instance: its report, or the error that it ended with, and its row.
#[derive(Debug, Serialize, Deserialize)]
pub struct Outcome<R> {
    /// The report or the error.
    pub report: R,
    /// Its row.
    pub row: Row,
}

impl<'f> Outcome<&'f Failure> {
    /// Returns the result of an instance without a report.
    pub fn failed(report: &'f Failure) -> Self {
        Outcome { report, row: Row { problem: Some(report.message.clone()), ..Row::default() } }
    }
}
