//! The report of `meliora export`.

use schemars::JsonSchema;
use serde::Serialize;

use super::envelope::{Envelope, Findings};
use super::header::Header;
use super::text::{self, Grid};
use super::{Number, Style};
use meliora_base::escape;
use meliora_dump::Manifest;

/// The dump that `export` wrote.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
#[schemars(rename = "export")]
pub struct ExportFindings {
    /// The directory as given by `--out`.
    pub directory: String,
    /// The regions of the dump, in the order of the roots; empty if not written.
    pub regions: Vec<ExportedRegion>,
    /// The number of nodes of `regions.dddmp`; `null` if not written.
    pub nodes: Option<usize>,
    /// The number of nodes of `certificate.dddmp`; `null` if not written.
    pub certificate_nodes: Option<usize>,
    /// The regions that the certificate does not prove, because a limit ended a part of it; none without a
    /// certificate.
    pub uncertified: Vec<String>,
    /// The bounds of `--values`; absent without `--values`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub values: Option<ExportedValues>,
}

/// The bounds of quantities in a dump.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ExportedValues {
    /// The number of rows of `values.csv`, or of states in an archive.
    pub rows: usize,
    /// The greatest number of improvements.
    pub levels: usize,
    /// The reward structure that is the cost of a step, or `steps`.
    pub reward: String,
    /// The greatest width of a bound, absolute for probabilities, relative above 1 for costs; `null`
    /// if it is infinite.
    pub widest: Option<f64>,
    /// True if no bound is wider than `--precision`.
    pub narrow: bool,
}

/// The report with times and memory.
pub type ExportReport = Envelope<ExportFindings>;

/// A region in a dump.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct ExportedRegion {
    /// Its name.
    pub name: String,
    /// The sort of its members.
    pub kind: meliora_dump::manifest::RootKind,
    /// The number of members.
    pub count: Number,
    /// The number of inner nodes.
    pub nodes: usize,
}

/// The dump that `reach` wrote.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct WrittenRegions {
    /// The directory as given by `--out`.
    pub directory: String,
    /// The regions of the dump, in the order of the roots.
    pub regions: Vec<ExportedRegion>,
    /// The number of nodes of `regions.dddmp`.
    pub nodes: usize,
}

impl WrittenRegions {
    /// Describes a dump that was written.
    pub fn new(directory: &str, manifest: &Manifest) -> Self {
        let regions = manifest.regions.roots.iter().map(ExportedRegion::new).collect();
        WrittenRegions { directory: directory.to_owned(), regions, nodes: manifest.regions.nodes }
    }

    /// Says which regions are in which directory.
    pub(super) fn text(&self) -> String {
        let names: Vec<String> = self.regions.iter().map(|region| region.name.clone()).collect();
        let written = format!("Regions written to {}, without a certificate:", escape::line(&self.directory));
        let words = names.join(", ").split(' ').map(str::to_owned).collect::<Vec<_>>();
        format!("\n{written}\n{}", text::wrapped(&words, "  ", 78))
    }
}

impl ExportedRegion {
    fn new(root: &meliora_dump::manifest::Root) -> Self {
        ExportedRegion {
            name: root.name.clone(),
            kind: root.kind,
            count: Number(root.count.parse().unwrap_or_default()),
            nodes: root.nodes,
        }
    }
}

impl ExportReport {
    /// Creates a report without results.
    pub fn to_directory(header: Header, directory: &str) -> Self {
        Envelope::with(header, ExportFindings { directory: directory.to_owned(), ..Default::default() })
    }

    /// Adds the regions that were written.
    pub fn set(&mut self, manifest: &Manifest) {
        self.regions = manifest.regions.roots.iter().map(ExportedRegion::new).collect();
        self.nodes = Some(manifest.regions.nodes);
        self.certificate_nodes = manifest.certificate.as_ref().map(|file| file.nodes);
        self.uncertified = manifest.certificate.iter().flat_map(|file| file.uncertified.clone()).collect();
    }

    /// Adds the regions that were written before their certificate is known.
    pub fn set_uncertified(&mut self, manifest: &Manifest) {
        self.set(manifest);
        self.uncertified = manifest.regions.roots.iter().map(|root| root.name.clone()).collect();
    }
}

impl ExportReport {
    /// Adds the bounds that were written, with the greatest width of one.
    pub fn set_values(&mut self, manifest: &Manifest, width: Option<f64>, precision: f64) {
        let values = manifest.values.as_ref().zip(width);
        self.values = values
            .map(|(file, width)| ExportedValues::new(file.rows, file.levels, &file.reward, width, precision));
    }
}

impl Findings for ExportFindings {
    const SCHEMA: &str = "meliora.export/1";
    const HEADER: (&[&str], &[&str]) = (&["model", "scope", "safety"], &[]);

    fn body(report: &ExportReport, style: Style) -> String {
        let mut out = String::new();
        let mut grid = Grid::new(&["region", "members", "nodes"]);
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
        if !report.uncertified.is_empty() {
            out += "\nNot certified, because a limit ended the proof (--no-certificate tries none)\n";
            out.extend(report.uncertified.iter().map(|name| format!("  {}\n", escape::line(name))));
        }
        if let Some(values) = &report.values {
            out += &values.text();
        }
        out
    }
}

impl ExportedValues {
    pub(super) fn new(rows: usize, levels: usize, reward: &str, width: f64, precision: f64) -> Self {
        let (widest, narrow) = (width.is_finite().then_some(width), width <= precision);
        ExportedValues { rows, levels, reward: reward.to_owned(), widest, narrow }
    }

    pub(super) fn text(&self) -> String {
        let width = self.widest.map_or_else(|| "infinite".to_owned(), |width| format!("{width:.1e}"));
        let rows = Number(self.rows.into()).grouped();
        let warning = if self.narrow { "" } else { ", more than the precision" };
        format!(
            "values of {rows} states, k up to {}, cost {}; widest bounds {width}{warning}\n",
            self.levels,
            escape::line(&self.reward)
        )
    }
}
