//! The common frame of all reports: header, completeness, times and memory.

use std::ops::{Deref, DerefMut};

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Serialize, Serializer};
use serde_json::{Map, Value as Json, json};

use super::columns::{Column, Heading, Place, Row};
use super::header::Header;
use super::report::{Failure, MemoryUse, Report};
use super::style::Style;
use super::text;
use meliora_engine::{Count, Usage};
use meliora_planning::result::ModelCounts;

/// The results of a command.
pub trait Findings: Serialize + JsonSchema + Sized {
    /// The name and version of the report, such as `meliora.check/1`.
    const SCHEMA: &'static str;
    /// The fields of the header that all these reports have, and those that some of them have.
    const HEADER: (&'static [&'static str], &'static [&'static str]);
    /// The timed phases.
    const PHASES: &'static [Phase] = &[];

    /// Returns the settings of this command, which precede those of the header.
    fn settings(&self) -> Vec<(&'static str, String)> {
        Vec::new()
    }

    /// Renders the results as text.
    fn body(report: &Envelope<Self>, style: Style) -> String;

    /// Renders the whole report as text.
    fn text(report: &Envelope<Self>, style: Style) -> String {
        report.full_text(style)
    }

    /// Returns the sizes of the model for a sweep.
    fn counts(&self) -> Option<&ModelCounts> {
        None
    }

    /// Returns the columns of a sweep in addition to those of all commands, for these settings.
    fn columns(&self) -> Vec<Column<Envelope<Self>>> {
        Vec::new()
    }

    /// Returns the answers to properties for a sweep, each with the reason if there is none.
    fn answers(&self) -> Vec<(String, Option<String>)> {
        Vec::new()
    }

    /// Returns whether the question was a yes/no question and the answer is no.
    fn is_no(&self) -> bool {
        false
    }

    /// Returns whether there were questions, and none could be read.
    fn is_unread(&self) -> bool {
        false
    }
}

/// A timed part of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Phase {
    /// Its name in JSON.
    pub name: &'static str,
    /// Its name in text.
    pub label: &'static str,
    /// The work that is done in it.
    pub meaning: &'static str,
}

impl Phase {
    /// Encoding the model.
    pub const BUILD: Phase = Phase::new("build", "Encoding the model and finding the states");
    /// Reading all inputs of a command about states.
    pub const PARSE_STATES: Phase = Phase::new("parse", "Reading model, preferences and states");
    /// The analysis as one phase.
    pub const LEVELS: Phase = Phase::new("levels", "Winning regions, improvement MDP and levels");
    /// Computing quantities for the choice of actions.
    pub const VALUES: Phase = Phase::new("values", "Computing the values for `choose`");

    /// Describes a phase with the same name in JSON and in text.
    pub const fn new(name: &'static str, meaning: &'static str) -> Self {
        Phase { name, label: name, meaning }
    }

    /// Changes the name in text.
    #[must_use]
    pub const fn labelled(self, label: &'static str) -> Self {
        Phase { label, ..self }
    }
}

/// Seconds by phase; `None` for an unfinished phase.
#[derive(Debug, Clone, PartialEq)]
pub struct Times {
    phases: Vec<(Phase, Option<f64>)>,
    /// The total.
    pub total: f64,
}

impl Times {
    /// Creates the times of a report in which no phase is finished.
    pub fn unfinished<F: Findings>() -> Self {
        Times { phases: F::PHASES.iter().map(|&phase| (phase, None)).collect(), total: 0.0 }
    }

    /// Adds seconds to a phase. Phases that the report does not list are not timed.
    pub fn add(&mut self, phase: &str, seconds: f64) {
        if let Some((_, sum)) = self.phases.iter_mut().find(|(own, _)| own.name == phase) {
            *sum = Some(sum.unwrap_or(0.0) + seconds);
        }
    }

    /// Returns the phases with their labels in text.
    pub fn phases(&self) -> impl Iterator<Item = (&'static str, Option<f64>)> {
        self.phases.iter().map(|&(phase, seconds)| (phase.label, seconds))
    }

    /// Returns the schema of the times of a report.
    pub(super) fn schema<F: Findings>(_: &mut SchemaGenerator) -> Schema {
        let phase = |phase: &Phase| {
            let description = format!("{}; `null` if not finished.", phase.meaning);
            (phase.name.to_owned(), json!({"description": description, "type": ["number", "null"]}))
        };
        let mut properties: Map<String, Json> = F::PHASES.iter().map(phase).collect();
        let total = json!({"description": "Seconds of the whole run.", "type": "number"});
        properties.insert("total".to_owned(), total);
        let required: Vec<&String> = properties.keys().collect();
        json_schema!({"type": "object", "required": required, "properties": properties})
    }
}

impl Serialize for Times {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let phases = self.phases.iter().map(|&(phase, seconds)| (phase.name, seconds));
        serializer.collect_map(phases.chain([("total", Some(self.total))]))
    }
}

/// A report, in the order of the JSON fields.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[schemars(rename = "{F}", transform = described::<F>)]
pub struct Envelope<F: Findings> {
    /// The kind and version of the object.
    pub schema: &'static str,
    /// `false`: the run hit a limit or was interrupted, and the object has the results so far; absent
    /// in complete reports.
    #[serde(skip_serializing_if = "is_true")]
    pub complete: bool,
    /// The model and the settings.
    #[serde(flatten)]
    pub header: Header,
    /// The results.
    #[serde(flatten)]
    pub findings: F,
    /// Seconds by phase; a phase that did not end is `null`.
    #[schemars(schema_with = "Times::schema::<F>")]
    pub time: Times,
    /// The memory used.
    pub memory: MemoryUse,
    /// Why the run is not complete; absent in complete reports.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<Failure>,
}

/// Adds to the schema of a report its name, and removes the fields of the header that it never has.
fn described<F: Findings>(schema: &mut Schema) {
    let (always, sometimes) = F::HEADER;
    let is_other = |name: &str| !always.contains(&name) && !sometimes.contains(&name);
    let others: Vec<&str> = Header::FIELDS.iter().copied().filter(|name| is_other(name)).collect();
    if let Some(Json::Object(properties)) = schema.get_mut("properties") {
        properties.retain(|name, _| !others.contains(&name.as_str()));
        properties["schema"] =
            json!({"description": "The kind and version of the object.", "const": F::SCHEMA});
    }
    if let Some(Json::Array(required)) = schema.get_mut("required") {
        required.extend(always.iter().map(|&name| Json::from(name)));
    }
    schema.insert("title".to_owned(), F::SCHEMA.into());
}

impl<F: Findings> Envelope<F> {
    /// Creates a report with these results.
    pub(crate) fn with(header: Header, findings: F) -> Self {
        let (time, memory) = (Times::unfinished::<F>(), MemoryUse::default());
        Envelope { schema: F::SCHEMA, complete: true, header, findings, time, memory, error: None }
    }
}

impl<F: Findings> Envelope<F> {
    /// Renders the inputs and settings, the results, times and memory.
    pub(super) fn full_text(&self, style: Style) -> String {
        let mut out = self.header.title(self.settings(), style);
        out += &F::body(self, style);
        out + &self.tail(style)
    }

    /// Renders the text after the results: whether they are all, times and memory.
    pub(super) fn tail(&self, style: Style) -> String {
        self.incomplete(style) + &self.footer(style)
    }

    /// Renders the note for work that ended early.
    pub(super) fn incomplete(&self, style: Style) -> String {
        incomplete(self.error.as_ref(), style)
    }

    /// Renders the last lines: seconds by phase, nodes and memory.
    fn footer(&self, style: Style) -> String {
        let phases = self.time.phases();
        let phases = phases.filter_map(|(name, took)| Some(format!("{name} {}", text::seconds(took?))));
        let (phases, total) = (phases.collect::<Vec<_>>().join(", "), text::seconds(self.time.total));
        let colon = if phases.is_empty() { "" } else { ": " };
        let mut out = format!("\n{}\n", style.dim(&format!("{total} in all{colon}{phases}")));
        let mut used = Vec::new();
        if self.memory.peak_nodes > 0 {
            used.push(format!("{} nodes at most", text::grouped(self.memory.peak_nodes)));
        }
        if self.memory.peak_rss_bytes > 0 {
            used.push(format!("{} of memory at most", text::bytes(self.memory.peak_rss_bytes)));
        }
        if !used.is_empty() {
            out += &format!("{}\n", style.dim(&used.join(", ")));
        }
        out
    }
}

impl<F: Findings> Envelope<F> {
    /// Returns the columns of the table, which depend on the settings and not on the results. The answers to
    /// properties stand before the columns of the second list.
    fn columns(&self) -> [Vec<Column<Envelope<F>>>; 2] {
        let counts = |name, place, of: fn(&ModelCounts) -> &Count| {
            Column::new(name, move |r: &Envelope<F>| r.findings.counts().map(|counts| of(counts).to_string()))
                .at(place)
        };
        let mut first = vec![
            counts("states", Place::Always, |counts| &counts.states),
            counts("choices", Place::File, |counts| &counts.choices),
            counts("transitions", Place::Room(2), |counts| &counts.transitions),
        ];
        first.extend(self.findings.columns());
        let used = vec![
            Column::new("seconds", |r: &Envelope<F>| Some(r.time.total.to_string())),
            Column::new("peak_nodes", |r: &Envelope<F>| Some(r.memory.peak_nodes.to_string()))
                .at(Place::Room(1)),
            Column::new("peak_rss_bytes", |r: &Envelope<F>| Some(r.memory.peak_rss_bytes.to_string()))
                .at(Place::File),
        ];
        [first, used]
    }

    /// Returns the headings of the table: those before and after the answers to properties.
    pub fn headings(&self) -> [Vec<Heading>; 2] {
        self.columns().map(|columns| columns.into_iter().map(|column| column.heading).collect())
    }

    /// Returns the row of the table.
    pub(super) fn row_of_sweep(&self) -> Row {
        let known = |column: Column<Envelope<F>>| Some((column.heading.name, (column.cell)(self)?));
        let cells = self.columns().into_iter().flatten().filter_map(known).collect();
        let problem = self.error.as_ref().map(|failure| failure.message.clone());
        let (answers, notes) = self.findings.answers().into_iter().unzip();
        let notes: Vec<Option<String>> = notes;
        Row { cells, answers, notes: notes.into_iter().flatten().collect(), problem }
    }
}

impl<F: Findings> Envelope<F> {
    /// Adds the nodes that an engine has used.
    pub fn used(&mut self, usage: Usage) {
        self.memory.peak_nodes = self.memory.peak_nodes.max(usage.peak_nodes);
    }
}

impl<F: Findings + Default> Envelope<F> {
    /// Creates a report without results.
    pub fn new(header: Header) -> Self {
        Envelope::with(header, F::default())
    }
}

impl<F: Findings> Deref for Envelope<F> {
    type Target = F;

    fn deref(&self) -> &F {
        &self.findings
    }
}

impl<F: Findings> DerefMut for Envelope<F> {
    fn deref_mut(&mut self) -> &mut F {
        &mut self.findings
    }
}

impl<F: Findings> Report for Envelope<F> {
    fn fail(&mut self, failure: Failure) {
        self.complete = false;
        self.error = Some(failure);
    }

    fn finish(&mut self, seconds: f64, peak_rss_bytes: u64) {
        self.time.total = seconds;
        self.memory.peak_rss_bytes = peak_rss_bytes;
    }

    fn text(&self, style: Style) -> String {
        style.finished(&F::text(self, style))
    }

    fn row(&self) -> Row {
        self.row_of_sweep()
    }

    fn is_no(&self) -> bool {
        self.findings.is_no()
    }

    fn is_unread(&self) -> bool {
        self.findings.is_unread()
    }
}

/// Renders the note for work that ended early.
pub(super) fn incomplete(failure: Option<&Failure>, style: Style) -> String {
    let note = "Incomplete: these are the partial results when the work stopped.";
    failure.map_or_else(String::new, |_| format!("\n{}\n", style.warn(note)))
}

/// Returns true for `complete` fields that are left out of JSON.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands out references")]
pub(super) fn is_true(flag: &bool) -> bool {
    *flag
}

#[cfg(test)]
mod tests {
    use meliora_model::valuation::Valuation;
    use meliora_planning::Rank;
    use meliora_planning::result::{LevelCounts, LevelsEnd, Plan, Prospects};
    use meliora_quantities::state_values::Bound;

    use crate::properties;
    use crate::{CheckReport, Header};
    use meliora_question::answers::PropertyAnswer;

    #[test]
    fn levels_stand_in_their_columns() {
        let mut report = CheckReport::new(Header::of_model("m"));
        let sizes = |levels: &[u32]| levels.iter().map(|&n| n.into()).collect();
        report.result.sasi = LevelCounts { levels: sizes(&[5, 3]), end: LevelsEnd::Empty };
        report.result.spi = LevelCounts { levels: sizes(&[6]), end: LevelsEnd::Unbounded(6u32.into()) };
        let plan = |rank| Some(Plan { rank, actions: Vec::new(), gains: Vec::new() });
        let (sasi, spi) = (plan(Rank::Finite(2)), plan(Rank::Unbounded));
        report.initial = vec![Prospects {
            state: Vec::new(),
            owner: None,
            values: Valuation::default(),
            escape: None,
            sure: None,
            possible: None,
            most_preferred: Vec::new(),
            jointly: None,
            sasi,
            spi,
        }];
        report.time.total = 0.5;
        let row = report.row_of_sweep();
        let cell = |name: &str| row.cells.iter().find(|(own, _)| own == name).map(|(_, cell)| cell.as_str());
        for (name, expected) in [
            ("states", None),
            ("sasi_1", Some("5")),
            ("sasi_2", Some("3")),
            ("sasi_3", None),
            ("sasi_unbounded", Some("0")),
            ("sasi_levels", Some("2")),
            ("spi_unbounded", Some("6")),
            ("sasi_rank", Some("2")),
            ("spi_rank", Some("unbounded")),
            ("seconds", Some("0.5")),
        ] {
            assert_eq!(cell(name), expected, "{name}");
        }
        report.levels = 2;
        let names: Vec<String> = report.headings()[0].iter().skip(3).map(|h| h.name.clone()).collect();
        assert_eq!(names[..4], ["sasi_1", "sasi_2", "sasi_unbounded", "sasi_levels"]);
        assert_eq!(names[8..], ["sasi_rank", "spi_rank"]);
    }

    /// The cell of a Pareto front was empty, although the property was answered.
    #[test]
    fn answers_are_verdicts_or_bounds_and_never_empty_without_a_limit() {
        let open =
            |reason: Option<&str>| PropertyAnswer::open(None, "p".to_owned(), reason.map(str::to_owned));
        let answer = |holds, bounds: Option<(f64, f64)>| {
            let value = bounds.map(|(lower, upper)| Some(Bound { lower, upper, exact: None }));
            PropertyAnswer { holds, value, ..open(None) }
        };
        for (property, expected) in [
            (answer(Some(true), None), "true"),
            (answer(Some(false), Some((0.5, 0.5))), "false"),
            (answer(None, Some((0.5, 0.5))), "0.5"),
            (answer(None, Some((0.25, f64::INFINITY))), "0.25..inf"),
            (answer(None, Some((f64::INFINITY, f64::INFINITY))), "inf"),
            (
                PropertyAnswer { front: Some(vec![vec![0.0, 1.0], vec![0.5, 0.25]]), ..open(None) },
                "(0, 1) (0.5, 0.25)",
            ),
            (PropertyAnswer { value: Some(None), ..open(Some("unsafe")) }, "no value"),
            (open(Some("unknown name")), "not answered"),
            (open(None), ""),
        ] {
            assert_eq!(properties::cell(&property), expected, "{property:?}");
        }
    }
}
