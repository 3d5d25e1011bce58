//! One row of a sweep: the values of a report for the table and the file.

use std::ops::Range;

use serde_json::Value as Json;
use strum::IntoStaticStr;

/// Number of levels with a column if `--max-level` does not say how many there can be. The header
/// must not depend on the results, so that the files of several sweeps fit together.
const LEVELS: usize = 16;

/// The fields of a target or of a single property.
pub(super) const REGIONS: [&str; 5] = ["target", "pmax_one", "pmax_positive", "pmin_one", "pmin_positive"];

/// The end of an instance, by its name in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, IntoStaticStr)]
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

/// Returns the reason why the instance of a report ended early.
pub(crate) fn failure(report: &Json) -> Option<&str> {
    report["message"].as_str().or(report["error"]["message"].as_str())
}

/// The command whose reports become rows, by its name in JSON.
#[derive(Debug, Clone, PartialEq, Eq, IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
pub(crate) enum Job {
    Check {
        levels: usize,
    },
    /// The regions of a target or of a single property, and the answers to properties, by their titles.
    Reach {
        regions: bool,
        properties: Vec<String>,
    },
    Compare,
}

/// The cells after the constants, each with the name of its column; unknown values are empty.
#[derive(Default)]
pub(crate) struct Row {
    cells: Vec<(String, String)>,
    /// The positions of the answers to properties.
    answers: Range<usize>,
}

impl Row {
    /// Adds the value at a place of a report, given as a JSON pointer.
    fn add(&mut self, name: impl Into<String>, report: &Json, place: &str) {
        self.push(name, report.pointer(place).map(cell).unwrap_or_default());
    }

    fn push(&mut self, name: impl Into<String>, cell: String) {
        self.cells.push((name.into(), cell));
    }

    /// Returns the names of the columns.
    pub(crate) fn columns(&self) -> impl Iterator<Item = &str> {
        self.cells.iter().map(|(name, _)| name.as_str())
    }

    /// Returns the cells.
    pub(crate) fn cells(&self) -> impl Iterator<Item = &str> {
        self.cells.iter().map(|(_, cell)| cell.as_str())
    }

    /// Returns the positions of the answers to properties.
    pub(crate) fn answers(&self) -> Range<usize> {
        self.answers.clone()
    }
}

impl Job {
    /// Returns the job for `check`, with columns for as many levels as there can be.
    pub(crate) fn check(max_level: Option<usize>) -> Self {
        Job::Check { levels: max_level.unwrap_or(LEVELS).min(LEVELS) }
    }

    /// Returns the row of a report, `null` before there is one. The columns do not depend on the
    /// report.
    pub(crate) fn row(&self, report: &Json, ended: Ended) -> Row {
        let mut row = Row::default();
        for name in ["states", "choices", "transitions"] {
            row.add(name, report, &format!("/counts/{name}"));
        }
        match self {
            Job::Check { levels } => {
                for kind in ["sasi", "spi"] {
                    row.levels(kind, *levels, report);
                }
                for name in ["sasi_rank", "spi_rank"] {
                    row.add(name, report, &format!("/initial/0/{name}"));
                }
            }
            Job::Reach { regions, properties } => {
                for name in REGIONS.into_iter().filter(|_| *regions) {
                    row.add(name, report, &format!("/{name}"));
                }
                let first = row.cells.len();
                for (index, title) in properties.iter().enumerate() {
                    row.push(title, answer(&report["properties"][index]));
                }
                row.answers = first..row.cells.len();
            }
            Job::Compare => {
                row.add("equal", report, "/equal");
                for name in ["symbolic", "explicit"] {
                    let mut engines = report["engines"].as_array().into_iter().flatten();
                    let own = engines.find(|e| e["engine"] == name);
                    row.add(format!("seconds_{name}"), own.unwrap_or(&Json::Null), "/time/total");
                }
                row.add("prefer", report, "/prefer/engine");
            }
        }
        row.add("seconds", report, "/time/total");
        row.add("peak_nodes", report, "/memory/peak_nodes");
        row.add("peak_rss_bytes", report, "/memory/peak_rss_bytes");
        row.push("status", <&str>::from(ended).to_owned());
        row
    }

    /// Returns how the instance of a row in a file ended, by the cells after the constants.
    pub(crate) fn ended(&self, cells: &[String]) -> Ended {
        let row = self.row(&Json::Null, Ended::Done);
        let answers =
            |(at, name): (usize, &str)| row.answers.contains(&at) || *self == Job::Compare && name == "equal";
        let mut named = row.columns().enumerate().zip(cells);
        let is_no = named.any(|(column, cell)| answers(column) && cell == "false");
        let wrote = |ended: Ended| cells.last().is_some_and(|status| status == <&str>::from(ended));
        match is_no {
            _ if wrote(Ended::Limit) => Ended::Limit,
            _ if !wrote(Ended::Done) => Ended::Error,
            true => Ended::No,
            false => Ended::Done,
        }
    }

    /// Returns the positions of the columns that a plot shows.
    pub(crate) fn plotted(&self) -> Vec<usize> {
        let row = self.row(&Json::Null, Ended::Done);
        let shown: &[&str] = match self {
            Job::Check { .. } => &["sasi_rank", "spi_rank", "sasi_1", "spi_1"],
            Job::Reach { properties, .. } if !properties.is_empty() => return row.answers().collect(),
            Job::Reach { .. } => &REGIONS[1..],
            Job::Compare => &["seconds_symbolic", "seconds_explicit"],
        };
        let columns = row.columns().enumerate().filter(|(_, name)| shown.contains(name));
        columns.map(|(position, _)| position).collect()
    }
}

/// Returns the answer to a property: a verdict, the bounds of a value, or why there is none. It is
/// empty if a limit or an error came first.
fn answer(property: &Json) -> String {
    let value = &property["value"];
    match (&property["holds"], value, property["reason"].as_str()) {
        (Json::Bool(holds), _, _) => holds.to_string(),
        (_, Json::Object(bounds), _) => {
            let [lower, upper] = ["lower", "upper"].map(|end| cell(&bounds[end]));
            if lower == upper { lower } else { format!("{lower}..{upper}") }
        }
        (_, _, Some(_)) if property.get("value").is_some() => "no value".to_owned(),
        (_, _, Some(_)) => "not answered".to_owned(),
        _ => String::new(),
    }
}

impl Row {
    /// Adds the levels of one kind.
    fn levels(&mut self, kind: &str, levels: usize, report: &Json) {
        for k in 1..=levels {
            self.add(format!("{kind}_{k}"), report, &format!("/{kind}/levels/{}", k - 1));
        }
        self.add(format!("{kind}_unbounded"), report, &format!("/{kind}/unbounded"));
        let found = report[kind]["levels"].as_array().map(|levels| levels.len().to_string());
        self.push(format!("{kind}_levels"), found.unwrap_or_default());
    }
}

/// Formats a value of a report; `null` is empty.
fn cell(value: &Json) -> String {
    match value {
        Json::Null => String::new(),
        Json::String(text) => text.clone(),
        Json::Number(number) if number.is_f64() => {
            number.as_f64().map_or_else(String::new, |x| x.to_string())
        }
        value => value.to_string(),
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
        let row = Job::check(Some(2)).row(&report, Ended::Done);
        let expected =
            ["9", "8", "7", "5", "3", "0", "2", "6", "", "6", "1", "2", "unbounded", "0.5", "1", "2", "done"];
        assert!(row.cells().eq(expected), "{:?}", row.cells);
        assert!(row.columns().skip(3).take(4).eq(["sasi_1", "sasi_2", "sasi_unbounded", "sasi_levels"]));
    }

    /// A resumed sweep of which nothing was left ended with 0 although the answers in the file were no.
    #[test]
    fn a_row_of_a_file_says_how_its_instance_ended() {
        let job = Job::Reach { regions: false, properties: vec!["p".to_owned(), "false".to_owned()] };
        let ended = |job: &Job, report: &Json, ended| {
            let row = job.row(report, ended);
            job.ended(&Vec::from_iter(row.cells().map(str::to_owned)))
        };
        let answers = |first: Json| serde_json::json!({"properties": [{"holds": first}, {"holds": true}]});
        for (holds, wrote, expected) in [
            (true, Ended::Done, Ended::Done),
            (false, Ended::No, Ended::No),
            (false, Ended::Limit, Ended::Limit),
            (true, Ended::Error, Ended::Error),
        ] {
            assert_eq!(ended(&job, &answers(holds.into()), wrote), expected, "{holds}");
        }
        let equal = |equal: bool| ended(&Job::Compare, &serde_json::json!({"equal": equal}), Ended::No);
        assert_eq!((equal(false), equal(true)), (Ended::No, Ended::Done));
    }

    #[test]
    fn answers_are_verdicts_or_bounds_and_never_empty_without_a_limit() {
        let bounds = |lower: Json, upper: Json| serde_json::json!({"lower": lower, "upper": upper});
        let property = |holds: Json, value: Json| serde_json::json!({"holds": holds, "value": value});
        for (property, expected) in [
            (property(true.into(), Json::Null), "true"),
            (property(false.into(), bounds(0.5.into(), 0.5.into())), "false"),
            (property(Json::Null, bounds(0.5.into(), 0.5.into())), "0.5"),
            (property(Json::Null, bounds(0.25.into(), "inf".into())), "0.25..inf"),
            (property(Json::Null, bounds("inf".into(), "inf".into())), "inf"),
            (serde_json::json!({"holds": null, "value": null, "reason": "unsafe"}), "no value"),
            (serde_json::json!({"holds": null, "reason": "unknown name"}), "not answered"),
            (serde_json::json!({"holds": null}), ""),
        ] {
            assert_eq!(answer(&property), expected, "{property}");
        }
    }
}
