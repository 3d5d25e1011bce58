//! One row of a sweep: the values of a report for the table and the file.

use serde_json::Value as Json;

/// Number of levels with a column if `--max-level` does not say how many there can be. The header
/// must not depend on the results, so that the files of several shards fit together.
const LEVELS: usize = 16;

/// The end of an instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ended {
    Done,
    /// Done, and the answer is no.
    No,
    /// A limit was hit; the row has the partial results.
    Limit,
    Error,
}

impl Ended {
    /// Returns the status in the file.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Ended::Done | Ended::No => "done",
            Ended::Limit => "limit",
            Ended::Error => "error",
        }
    }
}

/// The command whose reports become rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Job {
    Check { levels: usize },
    Reach,
    Compare,
}

impl Job {
    /// Returns the job for `check`, with columns for as many levels as there can be.
    pub(crate) fn check(max_level: Option<usize>) -> Self {
        Job::Check { levels: max_level.unwrap_or(LEVELS).min(LEVELS) }
    }

    /// Returns the names of the columns after those of the constants.
    pub(crate) fn columns(self) -> Vec<String> {
        let mut names: Vec<String> = ["states", "choices", "transitions"].map(str::to_owned).to_vec();
        match self {
            Job::Check { levels } => {
                for kind in ["sasi", "spi"] {
                    names.extend((1..=levels).map(|k| format!("{kind}_{k}")));
                    names.push(format!("{kind}_unbounded"));
                    names.push(format!("{kind}_levels"));
                }
                names.extend(["sasi_rank", "spi_rank"].map(str::to_owned));
            }
            Job::Reach => {
                let regions = ["target", "pmax_one", "pmax_positive", "pmin_one", "pmin_positive"];
                names.extend(regions.map(str::to_owned));
            }
            Job::Compare => {
                let names_of = ["equal", "seconds_symbolic", "seconds_explicit", "prefer"];
                names.extend(names_of.map(str::to_owned));
            }
        }
        names.extend(["seconds", "peak_nodes", "peak_rss_bytes", "status"].map(str::to_owned));
        names
    }

    /// Returns the cells of a report; unknown values are empty.
    pub(crate) fn cells(self, report: &Json, ended: Ended) -> Vec<String> {
        let counts = &report["counts"];
        let mut cells: Vec<String> = ["states", "choices", "transitions"].map(|k| cell(&counts[k])).to_vec();
        match self {
            Job::Check { levels } => {
                for kind in ["sasi", "spi"] {
                    let found = &report[kind]["levels"];
                    cells.extend((0..levels).map(|k| cell(&found[k])));
                    cells.push(cell(&report[kind]["unbounded"]));
                    cells.push(found.as_array().map_or(String::new(), |all| all.len().to_string()));
                }
                let first = &report["initial"][0];
                cells.extend(["sasi_rank", "spi_rank"].map(|k| cell(&first[k])));
            }
            Job::Reach => {
                let regions = ["target", "pmax_one", "pmax_positive", "pmin_one", "pmin_positive"];
                cells.extend(regions.map(|k| cell(&report[k])));
            }
            Job::Compare => {
                cells.push(cell(&report["equal"]));
                for name in ["symbolic", "explicit"] {
                    let engines = report["engines"].as_array().into_iter().flatten();
                    let own = engines.into_iter().find(|e| e["engine"] == name);
                    cells.push(own.map_or(String::new(), |e| cell(&e["time"]["total"])));
                }
                cells.push(cell(&report["prefer"]["engine"]));
            }
        }
        cells.push(cell(&report["time"]["total"]));
        cells.extend(["peak_nodes", "peak_rss_bytes"].map(|k| cell(&report["memory"][k])));
        cells.push(ended.word().to_owned());
        cells
    }
}

fn cell(value: &Json) -> String {
    match value {
        Json::Null => String::new(),
        Json::String(text) => text.clone(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_has_a_cell_for_every_column() {
        for kind in [Job::check(None), Job::check(Some(2)), Job::Reach, Job::Compare] {
            assert_eq!(kind.columns().len(), kind.cells(&Json::Null, Ended::Limit).len(), "{kind:?}");
        }
    }

    #[test]
    fn levels_stand_in_their_columns() {
        let report = serde_json::json!({
            "counts": {"states": "9", "choices": "8", "transitions": "7"},
            "sasi": {"levels": ["5", "3"], "unbounded": "0"}, "spi": {"levels": ["6"], "unbounded": "6"},
            "initial": [{"sasi_rank": 2, "spi_rank": "unbounded"}],
            "time": {"total": 0.5}, "memory": {"peak_nodes": 1, "peak_rss_bytes": 2}
        });
        let cells = Job::check(Some(2)).cells(&report, Ended::Done);
        let expected =
            ["9", "8", "7", "5", "3", "0", "2", "6", "", "6", "1", "2", "unbounded", "0.5", "1", "2", "done"];
        assert_eq!(cells, expected);
    }
}
