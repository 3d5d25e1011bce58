//! The report of `meliora report`: the results of `check`, and the written file.

use std::fmt::Write;

use schemars::JsonSchema;
use serde::Serialize;

use super::super::envelope::{incomplete, is_true};
use super::super::report::{Failure, MemoryUse, Report};
use super::super::{CheckReport, Header, Style, text, unsafe_start};
use super::words;
use meliora_base::escape;

/// The results of `report`.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[schemars(rename = "report")]
pub struct PageReport {
    /// The kind and version of the object.
    #[schemars(extend("const" = "meliora.report/1"))]
    pub schema: &'static str,
    /// `false`: the run hit a limit or was interrupted, and the object has the results so far; absent
    /// in complete reports.
    #[serde(skip_serializing_if = "is_true")]
    pub complete: bool,
    /// The file; `null` if not written.
    pub written: Option<Written>,
    /// The object of `check`.
    pub check: CheckReport,
    /// The memory used.
    pub memory: MemoryUse,
    /// The text for stdout if no file was named.
    #[serde(skip)]
    pub drawing: Option<String>,
    /// Why the run is not complete; absent in complete reports.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<Failure>,
}

/// A file that was written.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Written {
    /// The path.
    pub path: String,
    /// Its format.
    #[schemars(extend("enum" = ["html", "svg", "dot"]))]
    pub format: &'static str,
    /// The size in bytes.
    pub bytes: u64,
    /// The variables of the maps, rows first; empty without maps.
    pub grid: Vec<String>,
    /// The number of nodes of the regions in the page.
    pub nodes: u64,
    /// The maps had to be projected, so there are no sliders.
    pub projected: bool,
}

impl PageReport {
    /// Creates a report without a written file.
    pub fn new(check: CheckReport) -> Self {
        PageReport {
            schema: "meliora.report/1",
            complete: true,
            written: None,
            check,
            memory: MemoryUse::default(),
            drawing: None,
            error: None,
        }
    }
}

impl Report for PageReport {
    fn fail(&mut self, failure: Failure) {
        self.complete = false;
        self.check.complete = false;
        self.error = Some(failure);
    }

    fn finish(&mut self, seconds: f64, peak_rss_bytes: u64) {
        self.check.finish(seconds, peak_rss_bytes);
        self.memory = self.check.memory;
    }

    fn text(&self, style: Style) -> String {
        if let Some(drawing) = &self.drawing {
            return drawing.clone();
        }
        let check = &self.check;
        let shown = Header { engine: None, history: None, ..check.header.clone() };
        let mut out = shown.title(Vec::new(), style);
        let escape = check.initial.iter().find_map(|initial| initial.escape.as_ref());
        out += &unsafe_start::text(escape, style);
        for initial in &check.initial {
            let _ = writeln!(out, "\n{}", style.bold(&words::verdict(initial)));
            let _ = writeln!(out, "  at {}, {}", initial.values, words::preferred(initial));
        }
        if let Some(written) = &self.written {
            let _ = write!(out, "\n{}: {}", style.good("written"), escape::line(&written.path));
            if !written.grid.is_empty() {
                let _ = write!(out, ", with maps over {}", written.grid.join(" × "));
                let _ = write!(out, " ({} diagram nodes)", text::grouped(written.nodes));
            }
            if written.projected {
                let _ = write!(out, ", without sliders: the diagrams exceed `--nodes`");
            }
            out.push('\n');
        }
        out.push_str(&incomplete(self.error.as_ref(), style));
        style.finished(&out)
    }
}
