//! The report of `meliora export`.

use serde::Serialize;

use super::report::{Failure, Memory, ModelSummary, Report, is_true, scope_name, scope_word};
use super::text::{self, Grid};
use super::{Number, Style};
use crate::dump::Manifest;
use crate::engine::Scope;
use crate::escape;

/// What `export` wrote.
#[derive(Debug, Clone, Serialize)]
pub struct ExportReport {
    /// `meliora.export/1`
    pub schema: &'static str,
    /// Whether the work ran to its end; written only where it did not.
    #[serde(skip_serializing_if = "is_true")]
    pub complete: bool,
    /// The model.
    pub model: ModelSummary,
    /// Which valuations are states.
    #[serde(serialize_with = "scope_name")]
    pub scope: Scope,
    /// What is kept of a choice that may weaken.
    pub safety: &'static str,
    /// The directory.
    pub directory: String,
    /// The regions, in the order of the roots; none before they are written.
    pub regions: Vec<ExportedRegion>,
    /// How many nodes `regions.dddmp` has.
    pub nodes: Option<usize>,
    /// How many nodes `certificate.dddmp` has, if it was written.
    pub certificate_nodes: Option<usize>,
    /// Seconds.
    pub time: Total,
    /// What was used.
    pub memory: Memory,
    /// Why the work ended early.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<Failure>,
}

/// A region in a dump.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ExportedRegion {
    /// Its name.
    pub name: String,
    /// `states` or `choices`.
    pub kind: crate::dump::manifest::Kind,
    /// How many members it has.
    pub count: Number,
    /// How many inner nodes it has.
    pub nodes: usize,
}

/// The seconds of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Total {
    /// Everything.
    pub total: f64,
}

impl ExportReport {
    /// A report of which nothing but the question is known.
    pub fn new(model: &str, scope: Scope, safety: &'static str, directory: &str) -> Self {
        ExportReport {
            schema: "meliora.export/1",
            complete: true,
            model: ModelSummary::of_path(model),
            scope,
            safety,
            directory: directory.to_owned(),
            regions: Vec::new(),
            nodes: None,
            certificate_nodes: None,
            time: Total::default(),
            memory: Memory::default(),
            error: None,
        }
    }

    /// Notes what was written.
    pub fn set(&mut self, manifest: &Manifest) {
        let region = |r: &crate::dump::manifest::Root| ExportedRegion {
            name: r.name.clone(),
            kind: r.kind,
            count: Number(r.count.parse().unwrap_or_default()),
            nodes: r.nodes,
        };
        self.regions = manifest.regions.roots.iter().map(region).collect();
        self.nodes = Some(manifest.regions.nodes);
        self.certificate_nodes = manifest.certificate.as_ref().map(|file| file.nodes);
    }
}

impl Report for ExportReport {
    fn fail(&mut self, failure: Failure) {
        self.complete = false;
        self.error = Some(failure);
    }

    fn finish(&mut self, seconds: f64, peak_rss_bytes: u64) {
        self.time.total = seconds;
        self.memory.peak_rss_bytes = peak_rss_bytes;
    }

    fn text(&self, style: Style) -> String {
        let settings = [("scope", scope_word(self.scope)), ("safety", self.safety)];
        let mut out = text::title(&[&self.model.path], &settings, style);
        let mut grid = Grid::new(&["region", "members", "nodes"], style);
        for region in &self.regions {
            grid.row(vec![region.name.clone(), region.count.grouped(), region.nodes.to_string()]);
        }
        if let Some(nodes) = self.nodes {
            out.push_str(&grid.text(style));
            out.push_str(&format!(
                "\n{nodes} nodes together, written to {}\n",
                escape::line(&self.directory)
            ));
        }
        if let Some(nodes) = self.certificate_nodes {
            out.push_str(&format!("{nodes} nodes in the certificate\n"));
        }
        out.push_str(&text::incomplete(self.error.as_ref(), style));
        out.push_str(&text::footer(self.time.total, &[], self.memory, style));
        out
    }
}
