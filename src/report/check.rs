//! The report of `meliora check`.

use std::fmt::Write;

use schemars::JsonSchema;
use serde::Serialize;

use super::columns::{Column, Place};
use super::cycle::Cycle;
use super::envelope::{Envelope, Findings, Phase};
use super::players::{self, PlayerSummary};
use super::text::{self, Grid};
use super::{Header, Style, ranks, unsafe_start};
use meliora_base::error::Result;
use meliora_engine::{Engine, Storage};
use meliora_model::Program;
use meliora_model::preference::{Empty, History};
use meliora_planning::result::{ClassCount, LevelCounts, ModelCounts, Plan, Prospects};
use meliora_planning::{Analysis, AnalysisResult, Rank};
use meliora_question::number::grouped;

/// The results of `check`, in the order of the JSON fields.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
#[schemars(rename = "check")]
pub struct CheckFindings {
    /// The players of a game; absent for other models, and if unknown.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub players: Vec<PlayerSummary>,
    /// The results of the analysis.
    #[serde(flatten)]
    pub result: AnalysisResult,
    /// The first initial states, at most 16; empty if unknown.
    pub initial: Vec<Prospects>,
    /// The cycles behind unbounded ranks of these states, for texts; empty if they were not asked for.
    #[serde(skip)]
    pub cycles: Vec<Option<Cycle>>,
    /// The ranks [SASI, SPI] of these states under `--safety action`, for texts; empty if they were not
    /// asked for.
    #[serde(skip)]
    pub by_step: Vec<[Rank; 2]>,
    /// The largest level to compute, for the columns of a sweep; 0 without a limit.
    #[serde(skip)]
    pub levels: usize,
}

/// The report with times and memory.
pub type CheckReport = Envelope<CheckFindings>;

/// The maximum number of characters of a line of names.
const WIDTH: usize = 78;
/// The number of characters of a line of [`prospect`] next to the name, the verdict and the actions.
const PERMITTED: usize = 17;

/// The maximum number of listed initial states; `counts.initial` counts all.
pub const LISTED: usize = 16;

impl CheckReport {
    /// Creates the report of the results of an analysis so far; `preferences` is the name of the
    /// preference file. Cost: see [`Analysis::prospects`].
    ///
    /// # Errors
    /// A limit is reached.
    pub fn of_analysis<E: Engine>(
        analysis: &Analysis<E>,
        program: &Program,
        storage: Storage,
        preferences: &str,
    ) -> Result<Self> {
        let (engine, read) = (analysis.engine(), analysis.preferences());
        let header = Header::of_engine(program, storage, engine.settings().scope);
        let mut report = CheckReport::new(header.with_preferences(preferences, analysis.options().safety));
        report.read(program, read.empty, read.history);
        report.header.read_conditions(read.predicates());
        report.players = PlayerSummary::all(program, analysis.whole_engine())?;
        report.result = analysis.result().clone();
        report.initial = analysis.initial_prospects(program, LISTED)?;
        report.used(engine.usage());
        Ok(report)
    }

    /// Adds what the model and the preferences say.
    pub fn read(&mut self, program: &Program, empty: Empty, history: History) {
        self.header.read(program);
        self.header.empty = Some(Some(empty.name()));
        self.header.history = history.shown();
    }
}

/// Maximum number of levels with a column. The header of a sweep does not depend on the results, so
/// that the files of several sweeps fit together.
const LEVELS: usize = 16;

impl CheckFindings {
    /// Returns the columns of the levels of one kind.
    fn level_columns(
        &self,
        kind: &str,
        of: fn(&AnalysisResult) -> &LevelCounts,
    ) -> Vec<Column<Envelope<Self>>> {
        let levels = if self.levels == 0 { LEVELS } else { self.levels.min(LEVELS) };
        let level = |k: usize| {
            let cell = move |r: &CheckReport| of(&r.result).levels.get(k - 1).map(ToString::to_string);
            let column = Column::new(format!("{kind}_{k}"), cell);
            match k {
                1 => column.at(Place::Room(5)).plotted(),
                2 => column.at(Place::Room(3)),
                // A terminal has no room for more.
                _ => column.at(Place::File),
            }
        };
        let unbounded = move |r: &CheckReport| of(&r.result).unbounded().map(|count| count.to_string());
        let found = move |r: &CheckReport| {
            let levels = of(&r.result);
            levels.is_begun().then(|| levels.levels.len().to_string())
        };
        let last = [
            Column::new(format!("{kind}_unbounded"), unbounded).at(Place::Room(4)),
            Column::new(format!("{kind}_levels"), found),
        ];
        (1..=levels).map(level).chain(last).collect()
    }
}

impl Findings for CheckFindings {
    const SCHEMA: &str = "meliora.check/1";
    const HEADER: (&[&str], &[&str]) =
        (&["model", "scope", "safety", "empty"], &["engine", "engine_reason", "history"]);
    const PHASES: &[Phase] = &[
        Phase::new("parse", "Reading model and preferences"),
        Phase::BUILD,
        Phase::new("outcomes", "Winning regions of the objectives"),
        Phase::new("improvement", "Classes and improvement MDP"),
        Phase::new("sasi", "Levels of SASI").labelled("SASI"),
        Phase::new("spi", "Levels of SPI").labelled("SPI"),
    ];

    fn counts(&self) -> Option<&ModelCounts> {
        self.result.counts.as_ref()
    }

    fn columns(&self) -> Vec<Column<Envelope<Self>>> {
        let rank = |name: &str, of: fn(&Prospects) -> Option<&Plan>| {
            let cell = move |r: &CheckReport| {
                Some(match of(r.initial.first()?)?.rank {
                    Rank::Finite(k) | Rank::AtLeast(k) => k.to_string(),
                    Rank::Unbounded => "unbounded".to_owned(),
                })
            };
            Column::new(name, cell).wide("unbounded").plotted()
        };
        let mut columns = self.level_columns("sasi", |result| &result.sasi);
        columns.extend(self.level_columns("spi", |result| &result.spi));
        columns.push(rank("sasi_rank", |initial| initial.sasi.as_ref()));
        columns.push(rank("spi_rank", |initial| initial.spi.as_ref()));
        columns
    }

    fn body(report: &CheckReport, style: Style) -> String {
        let escape = report.initial.iter().find_map(|initial| initial.escape.as_ref());
        let mut out = unsafe_start::text(escape, style);
        out += &report.header.sizes(report.result.counts.as_ref(), style);
        out += &players::text(&report.players, style);
        out += &objectives(report, style);
        out += &classes(&report.result, style);
        out += &improvement(&report.result, style);
        out += &levels(&report.result, style);
        out + &initial(report, style)
    }
}

fn objectives(report: &CheckReport, style: Style) -> String {
    if report.result.objectives.is_empty() {
        return String::new();
    }
    let (target, heading) = match report.header.history {
        Some(_) => ("secured", "Objectives, and the number of states from which paths satisfy them"),
        None => ("target", "Objectives, and the number of states that reach them"),
    };
    // Of a single initial state, the lists below say it.
    let several = report.result.counts.as_ref().is_some_and(|counts| counts.initial > 1u32.into());
    let now: &[&str] = if several { &["initially sure", "possible"] } else { &[] };
    let mut grid = Grid::new(&[&["", target, "almost surely", "possibly"], now].concat());
    for objective in &report.result.objectives {
        let mut row = vec![objective.name.clone()];
        row.extend([&objective.target, &objective.almost_sure, &objective.positive].map(grouped));
        if several {
            row.extend([objective.sure, objective.possible].map(|share| share.to_string()));
        }
        grid.row(row);
    }
    grid.titled(heading, style)
}

fn classes(result: &AnalysisResult, style: Style) -> String {
    let Some(classes) = &result.classes else { return String::new() };
    let mut grid = Grid::new(&["", "states"]);
    for class in classes {
        grid.row(vec![text::either(&class.most_preferred), grouped(&class.states)]);
    }
    grid.titled("Classes: number of states by most preferred almost-sure objectives", style)
        + &jointly(classes, style)
}

/// Lists the objectives that can be achieved together.
fn jointly(classes: &[ClassCount], style: Style) -> String {
    if classes.iter().all(|class| class.jointly.is_none() && class.jointly_limit.is_none()) {
        return String::new();
    }
    let mut grid = Grid::new(&["class", "together", "states"]);
    let mut some = false;
    for class in classes {
        for joint in class.jointly.iter().flatten() {
            let together = joint.objectives.join(" and ");
            grid.row(vec![text::either(&class.most_preferred), together, grouped(&joint.states)]);
            some = true;
        }
        if let Some(limit) = class.jointly_limit {
            let why = format!("not computed: more than {limit} objectives");
            grid.row(vec![text::either(&class.most_preferred), why, String::new()]);
            some = true;
        }
    }
    let heading = "Jointly: number of states of a class that achieve several objectives in one path";
    if some { grid.titled(heading, style) } else { format!("\n{}\n  nowhere\n", style.bold(heading)) }
}

fn improvement(result: &AnalysisResult, style: Style) -> String {
    let Some(improvement) = &result.improvement else { return String::new() };
    let numbers = [
        ("states", &improvement.states),
        ("transitions", &improvement.transitions),
        ("dropped", &improvement.dropped),
    ];
    format!("\n{}\n{}", style.bold("Improvement MDP"), text::aligned(&numbers))
}

/// Shows the SASI and SPI levels side by side, one line per number of improvements.
fn levels(result: &AnalysisResult, style: Style) -> String {
    let both = [&result.sasi, &result.spi];
    if !both.iter().any(|levels| levels.is_begun()) {
        return String::new();
    }
    let mut grid = Grid::new(&["improvements", "SASI, almost surely", "SPI, possibly"]);
    for k in 1..=result.sasi.levels.len().max(result.spi.levels.len()) {
        let mut row = vec![format!("{k} or more")];
        row.extend(both.map(|levels| levels.size(k).map_or_else(String::new, grouped)));
        grid.row(row);
    }
    let unbounded = |levels: &LevelCounts| match levels.unbounded() {
        Some(n) => grouped(n),
        None if levels.is_begun() => "?".to_owned(),
        None => String::new(),
    };
    let mut last = vec!["any number".to_owned()];
    last.extend(both.map(unbounded));
    grid.row(last);
    grid.titled("Levels: number of states that can improve this many times", style)
}

fn initial(report: &CheckFindings, style: Style) -> String {
    let mut out = String::new();
    for (position, initial) in report.initial.iter().enumerate() {
        let _ = write!(out, "\n{}", text::state_heading("Initial state", &initial.values, style));
        if initial.escape.is_some() {
            let _ = writeln!(out, "  {}", style.bad("unsafe: no strategy keeps the requirements"));
            continue;
        }
        if let Some(owner) = initial.owner {
            let _ = writeln!(out, "  to move: the {owner}");
        }
        out += &objectives_of(initial);
        let several = initial.jointly.iter().flatten().filter(|set| set.len() > 1);
        let several: Vec<String> = several.map(|set| set.join(" and ")).collect();
        if !several.is_empty() {
            let _ = writeln!(out, "  jointly: {}", several.join("; or "));
        }
        out += &prospect("SASI", "guaranteed", initial, initial.sasi.as_ref(), style);
        out += &prospect("SPI ", "possible", initial, initial.spi.as_ref(), style);
        if let Some(note) = ranks::differing(initial, report.by_step.get(position)) {
            let words: Vec<String> = note.split(' ').map(str::to_owned).collect();
            out += &text::wrapped(&words, "  ", WIDTH);
        }
        if let Some(cycle) = report.cycles.get(position).and_then(Option::as_ref) {
            out += &cycle.text(style);
        }
    }
    if let Some(counts) = &report.result.counts {
        let listed = report.initial.len().into();
        if !report.initial.is_empty() && counts.initial > listed {
            let _ = writeln!(out, "\n  … and {} more initial states", grouped(&counts.initial - listed));
        }
    }
    out
}

/// Lists the objectives that are sure in a state, the most preferred of them if there are others, and
/// those that are possible without being sure.
fn objectives_of(initial: &Prospects) -> String {
    let most_preferred = text::either(&initial.most_preferred);
    let (Some(sure), Some(possible)) = (&initial.sure, &initial.possible) else {
        return format!("  most preferred: {most_preferred}\n");
    };
    if sure.is_empty() && possible.is_empty() {
        return "  sure: nothing\n".to_owned();
    }
    let listed = |what: &str, names: &[String]| {
        let words =
            format!("{what}: {}", text::names(names)).split(' ').map(str::to_owned).collect::<Vec<_>>();
        text::wrapped(&words, "  ", WIDTH)
    };
    let mut out = listed("sure", sure);
    if *sure != initial.most_preferred {
        let _ = writeln!(out, "  most preferred: {most_preferred}");
    }
    let others: Vec<String> = possible.iter().filter(|name| !sure.contains(name)).cloned().collect();
    if !others.is_empty() {
        out += &listed("possible", &others);
    }
    out
}

/// Returns one line: the improvements over a state, their gains, and the permitted actions.
fn prospect(name: &str, how: &str, initial: &Prospects, plan: Option<&Plan>, style: Style) -> String {
    let Some(plan) = plan else { return String::new() };
    let plain = ranks::ability(plan, &initial.most_preferred, how);
    let verdict = if plan.rank == Rank::Finite(0) { style.dim(&plain) } else { style.good(&plain) };
    let actions = plan.actions.join(", ");
    let all = [name, &plain, &actions].map(|text| text.chars().count()).iter().sum::<usize>();
    let actions = style.bold(&actions);
    match plan.actions.is_empty() {
        true => format!("  {name}  {verdict}\n"),
        false if all + PERMITTED <= WIDTH => format!("  {name}  {verdict}; permitted: {actions}\n"),
        false => format!("  {name}  {verdict}\n        permitted: {actions}\n"),
    }
}
