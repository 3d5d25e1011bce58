//! The report of `simulate` as text.

use std::fmt::Write;

use super::envelope::{Findings, Phase};
use super::simulate::{
    AchievedReport, CommitReport, GainReport, MovesReport, RunsReport, SimulateFindings, SimulateReport,
    TurnReport,
};
use super::text::{self, Grid, Probability};
use super::{Style, ranks};
use meliora_planning::tally::Achievements;
use meliora_planning::{Kind, Rank, Safety, StrategyKind};
use meliora_quantities::Choose;
use meliora_question::number::grouped;

/// Maximum number of steps of the trace that are shown.
const SHOWN: usize = 60;

impl Findings for SimulateFindings {
    const SCHEMA: &str = "meliora.simulate/1";
    const HEADER: (&[&str], &[&str]) = (&["model", "scope", "safety", "empty"], &["engine", "engine_reason"]);
    const PHASES: &[Phase] = &[
        Phase::PARSE_STATES,
        Phase::BUILD,
        Phase::LEVELS,
        Phase::VALUES,
        Phase::new("answer", "Simulating").labelled("runs"),
    ];

    fn settings(&self) -> Vec<(&'static str, String)> {
        let strategy = format!("{} {}", self.strategy.name(), self.kind);
        let mut settings = vec![("strategy", strategy)];
        settings.extend(self.choosing.settings());
        settings.extend(self.opponent.map(|opponent| ("opponent", opponent.name().to_owned())));
        settings.push(("seed", self.seed.to_string()));
        settings
    }

    fn body(report: &SimulateReport, style: Style) -> String {
        report.starts.iter().map(|found| one(report, found, style)).collect()
    }
}

fn one(report: &SimulateReport, found: &RunsReport, style: Style) -> String {
    if found.tally.is_unsafe {
        let title = style.bold(&format!("No run from {}", found.state));
        return format!("\n{title}\n  {}\n", style.bad("Unsafe: no strategy keeps the requirements"));
    }
    let runs = grouped(report.runs);
    let title = format!("{runs} runs from {}", found.state);
    let mut out = format!("\n{}\n", style.bold(&title));
    if report.kind != StrategyKind::Achieve {
        out.push_str(&promise(report, found, style));
    } else if found.tally.is_idle() {
        out.push_str(match report.choosing.choose {
            Choose::First => {
                "  No strategy achieves this almost surely from here.\n  \
                 `--choose likely` makes it as likely as possible.\n"
            }
            Choose::Likely | Choose::Cheap => "  No strategy achieves this from here.\n",
        });
    }
    if let Some(achieved) = &found.tally.achieved {
        out.push_str(&pursued(report, achieved, style));
        out.push_str(&commitments(found));
    }
    if let Some(value) = &found.value {
        out.push_str(&value.text(report.choosing.cost()));
    }
    out.push_str(&distribution(report, found, style));
    out.push_str(&gained(report, found, style));
    out.push_str(&achieved(report, found, style));
    out.push_str(&moves(found));
    out.push_str(&weakening(report, found, style));
    if found.tally.given_up > 0 {
        let (given_up, steps) = (plural_runs(found.tally.given_up), grouped(report.steps));
        let _ = writeln!(out, "  {given_up} stopped after {steps} steps; `--steps` raises this limit.");
    }
    out.push_str(&trace(found, style));
    out
}

/// States the rank, and how many runs made that number of improvements.
fn promise(report: &SimulateReport, found: &RunsReport, style: Style) -> String {
    let kind = report.choosing.choose.levels(report.kind);
    let how = ranks::how(kind);
    if found.tally.rank == Rank::Finite(0) {
        let advice = match (report.kind, kind) {
            (_, Kind::Sasi) if found.is_hopeless => ", and none is possible",
            (StrategyKind::Sasi, _) => "; try `--kind spi`",
            (StrategyKind::Plan, Kind::Sasi) => "; `--choose likely` tries possible ones",
            _ => "",
        };
        return format!("  No improvement is {how} here ({kind}){advice}.\n");
    }
    let fewer = found.tally.fewer_than_rank().unwrap_or(found.tally.undecided);
    let (kept, failed) = (report.runs - fewer, fewer - found.tally.undecided);
    let mut parts = Vec::new();
    if found.tally.fewer_than_rank().is_some() {
        parts.push(style.good(&format!(
            "{} reached this number",
            if fewer == 0 { "Every run".to_owned() } else { plural_runs(kept) }
        )));
    }
    if failed > 0 {
        let text = format!("{} did not", plural_runs(failed));
        parts.push(if kind == Kind::Sasi { style.warn(&text) } else { text });
    }
    if found.tally.undecided > 0 {
        let steps = grouped(report.steps);
        parts.push(format!("{} did not finish in {steps} steps", plural_runs(found.tally.undecided)));
    }
    let claim = ranks::capitalised(&ranks::claim(Some(found.tally.rank), how));
    let parts = if parts.is_empty() { String::new() } else { format!("  {}.\n", parts.join(", ")) };
    format!("  {claim} ({kind}).\n{parts}")
}

/// States how many runs achieved, or kept, the objective that they pursued.
fn pursued(report: &SimulateReport, achieved: &Achievements, style: Style) -> String {
    let which = match report.kind {
        StrategyKind::Achieve if achieved.together => "the objectives",
        StrategyKind::Achieve => "the objective",
        _ => "a most preferred objective of their last state",
    };
    let Achievements { runs, kept, .. } = *achieved;
    if runs == report.runs {
        return format!("  {} achieved {which}.\n", style.good("All runs"));
    }
    let mut parts = Vec::new();
    if runs > 0 || kept == 0 {
        parts.push(format!("{} achieved {which}", plural_runs(runs)));
    }
    if kept > 0 {
        let kept = if kept == report.runs { "All runs".to_owned() } else { plural_runs(kept) };
        let which = if runs > 0 && !achieved.together { "one" } else { which };
        parts.push(format!("{} kept {which}", style.good(&kept)));
    }
    if let Some(open) = report.runs.checked_sub(runs + kept).filter(|&open| open > 0) {
        parts.push(format!("{} did not", style.warn(&plural_runs(open))));
    }
    format!("  {}.\n", parts.join(", "))
}

/// States how many steps each player of a game chose.
fn moves(found: &RunsReport) -> String {
    let one = |MovesReport { name, ours, steps }: &MovesReport| {
        let side = if *ours { "ours" } else { "opponent" };
        format!("{name} ({side}) {}", grouped(*steps))
    };
    let all: Vec<String> = found.players.iter().map(one).collect();
    if all.is_empty() { String::new() } else { format!("  Steps of all runs: {}.\n", all.join(", ")) }
}

/// Lists the objectives to which runs commit, with those that they give up.
fn commitments(found: &RunsReport) -> String {
    let one = |commit: &CommitReport| {
        let CommitReport { objective, gives_up, runs } = commit;
        format!("  {}: {}.\n", plural_runs(*runs), commitment(objective, gives_up))
    };
    found.commits.iter().flatten().map(one).collect()
}

/// Formats a commitment: `commits to C, gives up D`.
pub(super) fn commitment(objective: &str, gives_up: &[String]) -> String {
    match gives_up.is_empty() {
        true => format!("commits to {objective}"),
        false => format!("commits to {objective}, gives up {}", text::names(gives_up)),
    }
}

/// Formats some runs as a share of all.
fn share(report: &SimulateReport, runs: u64) -> String {
    format!("{:.1} %", 100.0 * runs as f64 / report.runs as f64)
}

/// Lists the achieved objectives, with the number of steps until then.
fn achieved(report: &SimulateReport, found: &RunsReport, style: Style) -> String {
    let Some(all) = found.achieved.as_ref().filter(|all| !all.is_empty()) else { return String::new() };
    let mut grid = Grid::new(&["achieved", "runs", "share", "min steps", "mean", "max"]);
    for AchievedReport { objective, wait } in all {
        grid.row(vec![
            objective.clone(),
            grouped(wait.runs),
            share(report, wait.runs),
            wait.least.to_string(),
            format!("{:.2}", wait.mean()),
            wait.most.to_string(),
        ]);
    }
    format!("{}\n", grid.text(style))
}

fn distribution(report: &SimulateReport, found: &RunsReport, style: Style) -> String {
    let mut grid = Grid::new(&["improvements", "runs", "share"]);
    for (times, runs) in &found.tally.improvements {
        grid.row(vec![times.to_string(), grouped(runs), share(report, *runs)]);
    }
    let mut out = format!("\n{}", grid.text(style));
    if !found.tally.waits.is_empty() {
        let mut grid = Grid::new(&["steps to improvement", "min", "mean", "max", "runs"]);
        for (index, steps) in found.tally.waits.iter().enumerate() {
            grid.row(vec![
                (index + 1).to_string(),
                steps.least.to_string(),
                format!("{:.2}", steps.mean()),
                steps.most.to_string(),
                grouped(steps.runs),
            ]);
        }
        let _ = write!(out, "\n{}", grid.text(style));
    }
    out.push('\n');
    out
}

/// States how many runs improved on their start, and their gains.
fn gained(report: &SimulateReport, found: &RunsReport, style: Style) -> String {
    let start = text::goal(&found.most_preferred);
    let better = match found.tally.better_than_start {
        0 => return format!("  No run improved on its start ({start}).\n"),
        all if all == report.runs => "Every run".to_owned(),
        some => plural_runs(some),
    };
    let mut grid = Grid::new(&["gained", "runs", "share"]);
    for GainReport { objective, runs } in &found.gained {
        grid.row(vec![objective.clone(), grouped(runs), share(report, *runs)]);
    }
    format!("  {better} improved on its start ({start}).\n{}\n", grid.text(style))
}

fn weakening(report: &SimulateReport, found: &RunsReport, style: Style) -> String {
    let commits = found.commits.as_ref().is_some_and(|commits| !commits.is_empty());
    let when = if commits { " (until it committed)" } else { "" };
    let told = |count: u64, what: &str| match count {
        0 => format!("  {} {what}{when}.\n", style.good("No run weakened")),
        n => format!("  {} {what}{when}.\n", style.warn(&format!("{} weakened", plural_runs(n)))),
    };
    let mut out = told(found.tally.weakened_step, "the state of the step before");
    if report.header.safety.is_some_and(Safety::has_reference) {
        out += &told(
            found.tally.weakened_reference,
            "the state after its last improvement (at first its start)",
        );
    }
    out += &told(found.tally.weakened_start, "its start");
    if found.tally.entered_unsafe > 0 {
        let runs = style.bad(&format!("{} entered", plural_runs(found.tally.entered_unsafe)));
        let _ = writeln!(out, "  {runs} a state where no strategy keeps the requirements.");
    }
    out
}

fn plural_runs(count: u64) -> String {
    text::plural(usize::try_from(count).unwrap_or(usize::MAX), "run")
}

fn trace(found: &RunsReport, style: Style) -> String {
    let trace = &found.trace;
    let mut out = format!("\n  {}\n", style.bold(&format!("Run {} in full", trace.run)));
    if trace.turns.is_empty() {
        out.push_str("    The run ends in its start.\n");
        return out;
    }
    let is_game = !found.players.is_empty();
    let by: &[&str] = if is_game { &["by"] } else { &[] };
    let heading = [&["step"], by, &["action", "to", "chance", "most preferred", "rank", ""]].concat();
    let mut rows = vec![heading.into_iter().map(str::to_owned).collect::<Vec<_>>()];
    for (index, turn) in trace.turns.iter().take(SHOWN).enumerate() {
        let mut row = vec![(index + 1).to_string()];
        row.extend(is_game.then(|| turn.player.clone().unwrap_or_else(|| "nobody".to_owned())));
        row.extend([
            turn.action.clone(),
            turn.changed.clone(),
            Probability(turn.probability).to_string(),
            text::either(&turn.most_preferred),
            ranks::cell(turn.rank),
            remark(turn),
        ]);
        rows.push(row);
    }
    out += &text::listed(&rows, style);
    if let Some(more) = trace.turns.len().checked_sub(SHOWN).filter(|&n| n > 0) {
        let _ = writeln!(out, "    … and {} more (`--json` lists all)", text::plural(more, "step"));
    }
    out
}

/// Returns the remarks on a step.
fn remark(turn: &TurnReport) -> String {
    let mut remarks = Vec::new();
    if turn.is_unsafe {
        remarks.push("unsafe".to_owned());
    }
    if turn.improves {
        remarks.push(format!("improves: {} gained", text::either(&turn.gained)));
    }
    if !turn.improves && turn.change == "improving" {
        let gained = text::either(&turn.gained);
        remarks.push(format!("{gained} gained, but not counted: too few improvements can follow"));
    }
    if !turn.achieved.is_empty() {
        remarks.push(format!("achieves {}", text::names(&turn.achieved)));
    }
    remarks.extend(committed(turn));
    remarks.extend(weakened(turn));
    remarks.join("; ")
}

/// Returns the remark on a step that weakens the state before it or the start.
pub(super) fn weakened(turn: &TurnReport) -> Option<String> {
    match (turn.weakens_step, turn.weakens_start) {
        (true, true) => Some(format!("weakens: {} lost; weakens the start", text::names(&turn.lost))),
        (true, false) => Some(format!("weakens: {} lost", text::names(&turn.lost))),
        (false, true) => Some("weakens the start".to_owned()),
        (false, false) => None,
    }
}

/// Returns the remark on a commitment, or on what a step gives up later.
pub(super) fn committed(turn: &TurnReport) -> Option<String> {
    match &turn.commits {
        Some(objective) => Some(commitment(objective, &turn.gives_up)),
        None if turn.gives_up.is_empty() => None,
        None => Some(format!("gives up {}", text::names(&turn.gives_up))),
    }
}
