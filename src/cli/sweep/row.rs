//! One row of a sweep: the values of a report for the table and the file.

use std::fmt::{self, Display, Formatter};

use serde::Deserialize;
use strum::IntoStaticStr;

/// Number of levels with a column if `--max-level` does not say how many there can be. The header
/// must not depend on the results, so that the files of several shards fit together.
const LEVELS: usize = 16;

/// The end of an instance, by its name in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
pub(crate) enum Ended {
    Done,
    /// Done, and the answer is no.
    #[strum(serialize = "done")]
    No,
    /// A limit was hit; the row has the partial results.
    Limit,
    Error,
}

/// The parts of a report that rows show. Each command fills in its own, a limit leaves out some.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Found {
    counts: Option<Counts>,
    sasi: Option<Levels>,
    spi: Option<Levels>,
    initial: Option<Initial>,
    target: Option<String>,
    pmax_one: Option<String>,
    pmax_positive: Option<String>,
    pmin_one: Option<String>,
    pmin_positive: Option<String>,
    equal: Option<bool>,
    engines: Vec<EngineTime>,
    prefer: Option<Prefer>,
    time: Option<Time>,
    memory: Option<Memory>,
    error: Option<Failure>,
    /// The message, if the report is an error.
    message: Option<String>,
    /// The kind of error, if the report is one.
    pub(crate) kind: Option<String>,
}

impl Found {
    /// Returns the reason why the instance ended early.
    pub(crate) fn failure(&self) -> Option<&str> {
        self.message.as_deref().or(self.error.as_ref().map(|error| error.message.as_str()))
    }
}

#[derive(Debug, Deserialize)]
struct Counts {
    states: String,
    choices: String,
    transitions: String,
}

#[derive(Debug, Deserialize)]
struct Levels {
    levels: Vec<String>,
    unbounded: Option<String>,
}

/// The initial states: a list for `check`, their shares of the regions for `reach`.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Initial {
    Ranks(Vec<Ranks>),
    Shares {},
}

#[derive(Debug, Deserialize)]
struct Ranks {
    sasi_rank: Option<Rank>,
    spi_rank: Option<Rank>,
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Rank {
    Finite(u64),
    Unbounded(String),
}

impl Display for Rank {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Rank::Finite(rank) => rank.fmt(f),
            Rank::Unbounded(word) => word.fmt(f),
        }
    }
}

#[derive(Debug, Deserialize)]
struct EngineTime {
    engine: String,
    time: Time,
}

#[derive(Debug, Deserialize)]
struct Prefer {
    engine: String,
}

#[derive(Debug, Deserialize)]
struct Time {
    total: f64,
}

#[derive(Debug, Deserialize)]
struct Memory {
    peak_nodes: Option<u64>,
    peak_rss_bytes: Option<u64>,
}

#[derive(Debug, Deserialize)]
struct Failure {
    message: String,
}

/// The command whose reports become rows, by its name in JSON.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
pub(crate) enum Job {
    Check { levels: usize },
    Reach,
    Compare,
}

/// The cells after the constants, each with the name of its column; unknown values are empty.
#[derive(Default)]
pub(crate) struct Row(Vec<(String, String)>);

impl Row {
    fn add(&mut self, name: impl Into<String>, value: Option<impl Display>) {
        self.0.push((name.into(), value.map(|value| value.to_string()).unwrap_or_default()));
    }

    /// Returns the names of the columns.
    pub(crate) fn columns(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|(name, _)| name.as_str())
    }

    /// Returns the cells.
    pub(crate) fn cells(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|(_, cell)| cell.as_str())
    }
}

impl Job {
    /// Returns the job for `check`, with columns for as many levels as there can be.
    pub(crate) fn check(max_level: Option<usize>) -> Self {
        Job::Check { levels: max_level.unwrap_or(LEVELS).min(LEVELS) }
    }

    /// Returns the row of a report. The columns do not depend on the report.
    pub(crate) fn row(self, found: &Found, ended: Ended) -> Row {
        let mut row = Row::default();
        let counts = found.counts.as_ref();
        row.add("states", counts.map(|c| &c.states));
        row.add("choices", counts.map(|c| &c.choices));
        row.add("transitions", counts.map(|c| &c.transitions));
        match self {
            Job::Check { levels } => found.levels(levels, &mut row),
            Job::Reach => {
                row.add("target", found.target.as_ref());
                row.add("pmax_one", found.pmax_one.as_ref());
                row.add("pmax_positive", found.pmax_positive.as_ref());
                row.add("pmin_one", found.pmin_one.as_ref());
                row.add("pmin_positive", found.pmin_positive.as_ref());
            }
            Job::Compare => {
                row.add("equal", found.equal);
                for name in ["symbolic", "explicit"] {
                    let own = found.engines.iter().find(|e| e.engine == name);
                    row.add(format!("seconds_{name}"), own.map(|e| e.time.total));
                }
                row.add("prefer", found.prefer.as_ref().map(|p| &p.engine));
            }
        }
        row.add("seconds", found.time.as_ref().map(|t| t.total));
        row.add("peak_nodes", found.memory.as_ref().and_then(|m| m.peak_nodes));
        row.add("peak_rss_bytes", found.memory.as_ref().and_then(|m| m.peak_rss_bytes));
        row.add("status", Some(<&str>::from(ended)));
        row
    }
}

impl Found {
    /// Adds the levels of `check`, and the ranks of the first initial state.
    fn levels(&self, levels: usize, row: &mut Row) {
        for (kind, found) in [("sasi", &self.sasi), ("spi", &self.spi)] {
            for k in 1..=levels {
                row.add(format!("{kind}_{k}"), found.as_ref().and_then(|f| f.levels.get(k - 1)));
            }
            row.add(format!("{kind}_unbounded"), found.as_ref().and_then(|f| f.unbounded.as_ref()));
            row.add(format!("{kind}_levels"), found.as_ref().map(|f| f.levels.len()));
        }
        let first = match &self.initial {
            Some(Initial::Ranks(all)) => all.first(),
            _ => None,
        };
        row.add("sasi_rank", first.and_then(|r| r.sasi_rank.as_ref()));
        row.add("spi_rank", first.and_then(|r| r.spi_rank.as_ref()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_stand_in_their_columns() {
        let report = serde_json::json!({
            "counts": {"states": "9", "choices": "8", "transitions": "7"},
            "sasi": {"levels": ["5", "3"], "unbounded": "0"}, "spi": {"levels": ["6"], "unbounded": "6"},
            "initial": [{"sasi_rank": 2, "spi_rank": "unbounded"}],
            "time": {"total": 0.5}, "memory": {"peak_nodes": 1, "peak_rss_bytes": 2}
        });
        let row = Job::check(Some(2)).row(&Found::deserialize(report).unwrap(), Ended::Done);
        let expected =
            ["9", "8", "7", "5", "3", "0", "2", "6", "", "6", "1", "2", "unbounded", "0.5", "1", "2", "done"];
        assert!(row.cells().eq(expected), "{:?}", row.0);
        assert!(row.columns().skip(3).take(4).eq(["sasi_1", "sasi_2", "sasi_unbounded", "sasi_levels"]));
    }
}
