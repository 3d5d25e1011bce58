//! The report of `meliora export`.

use serde::Serialize;

use super::envelope::{Envelope, Findings};
use super::header::Header;
use super::text::Grid;
use super::{Number, Style};
use crate::dump::Manifest;
use crate::escape;

/// The dump that `export` wrote.
#[derive(Debug, Clone, Default, Serialize)]
pub struct ExportFindings {
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
    pub fn to_directory(header: Header, directory: &str) -> Self {
        Envelope::of(header, ExportFindings { directory: directory.to_owned(), ..Default::default() })
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

    fn body(report: &ExportReport, style: Style) -> String {
        let mut out = String::new();
        let mut grid = Grid::new(&["region", "members", "nodes"], style);
        for region in &report.regions {
            grid.row(vec![region.name.clone(), region.count.grouped(), region.nodes.to_string()]);
        }
        if let Some(nodes) = report.nodes {
            out += &grid.text(style);
            out += &format!("\n{nodes} nodes in total, written to {}\n", escape::line(&report.directory));
        }
        if let Some(nodes) = report.certificate_nodes {
            out += &format!("{nodes} nodes in the certificate\n");
        }
        out
    }
}
