//! The report of `meliora export`.

use serde::Serialize;

use super::envelope::{Envelope, Findings, Total};
use super::report::ModelSummary;
use super::text::{self, Grid};
use super::{Number, Style};
use crate::dump::Manifest;
use crate::engine::Scope;
use crate::escape;

/// The dump that `export` wrote.
#[derive(Debug, Clone, Serialize)]
pub struct ExportFindings {
    /// The model.
    pub model: ModelSummary,
    /// The valuations that are states.
    pub scope: Scope,
    /// The name of the safety filter.
    pub safety: &'static str,
    /// The directory.
    pub directory: String,
    /// The regions, in the order of the roots; empty until they are written.
    pub regions: Vec<ExportedRegion>,
    /// Number of nodes in `regions.dddmp`.
    pub nodes: Option<usize>,
    /// Number of nodes in `certificate.dddmp`, if it was written.
    pub certificate_nodes: Option<usize>,
}

/// The report with times and memory.
pub type ExportReport = Envelope<ExportFindings>;

/// A region in a dump.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ExportedRegion {
    /// Its name.
    pub name: String,
    /// `states` or `choices`.
    pub kind: crate::dump::manifest::RootKind,
    /// Number of members.
    pub count: Number,
    /// Number of inner nodes.
    pub nodes: usize,
}

impl ExportReport {
    /// Creates a report without results.
    pub fn new(model: &str, scope: Scope, safety: &'static str, directory: &str) -> Self {
        Envelope::of(ExportFindings {
            model: ModelSummary::of_path(model),
            scope,
            safety,
            directory: directory.to_owned(),
            regions: Vec::new(),
            nodes: None,
            certificate_nodes: None,
        })
    }

    /// Adds the regions that were written.
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

impl Findings for ExportFindings {
    const SCHEMA: &str = "meliora.export/1";
    type Time = Total;

    fn text(report: &ExportReport, style: Style) -> String {
        let settings = [("scope", report.scope.name()), ("safety", report.safety)];
        let mut out = text::title(&[&report.model.path], &settings, style);
        let mut grid = Grid::new(&["region", "members", "nodes"], style);
        for region in &report.regions {
            grid.row(vec![region.name.clone(), region.count.grouped(), region.nodes.to_string()]);
        }
        if let Some(nodes) = report.nodes {
            out.push_str(&grid.text(style));
            out.push_str(&format!(
                "\n{nodes} nodes in total, written to {}\n",
                escape::line(&report.directory)
            ));
        }
        if let Some(nodes) = report.certificate_nodes {
            out.push_str(&format!("{nodes} nodes in the certificate\n"));
        }
        out.push_str(&text::incomplete(report.error.as_ref(), style));
        out.push_str(&text::footer(report.time.total, &[], report.memory, style));
        out
    }
}
