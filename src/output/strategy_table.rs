//! Strategies as CSV and as DOT.

use std::fmt::Write;

use super::ranks;
use super::reason::Words;
use super::strategy::StateReport;
use super::strategy_text::Probability;
use crate::model::Program;
use crate::model::preference::Preferences;
use crate::planning::induced_model::Node;
use crate::planning::{InducedModel, Kind};

/// Returns the heading: the variables, then the columns for each action.
pub fn csv_heading(program: &Program) -> String {
    let variables = program.variables.iter().map(|v| v.name.as_str());
    let columns = [
        "most_preferred",
        "sasi_rank",
        "spi_rank",
        "action",
        "kept",
        "permitted",
        "progress",
        "pick",
        "reason",
    ];
    line(variables.chain(columns).map(str::to_owned))
}

/// Returns the lines of a state, one per action.
pub fn csv_rows(state: &StateReport) -> String {
    let mut text = String::new();
    for action in &state.actions {
        let pick = state.progress_action.as_deref() == Some(action.name.as_str());
        let flags = [action.kept, action.permitted, action.progress, pick].map(|f| f.to_string());
        let mut cells: Vec<String> = state.state.values().map(ToString::to_string).collect();
        cells.push(state.most_preferred.join("+"));
        cells.extend([ranks::cell(state.sasi_rank), ranks::cell(state.spi_rank), action.name.clone()]);
        cells.extend(flags);
        cells.push(action.reason.clone());
        text.push_str(&line(cells.into_iter()));
    }
    text
}

/// Joins cells with commas as in RFC 4180, except for the end of the line.
pub(super) fn line(cells: impl Iterator<Item = String>) -> String {
    let quoted = |cell: String| match cell.contains([',', '"', '\n']) {
        true => format!("\"{}\"", cell.replace('"', "\"\"")),
        false => cell,
    };
    cells.map(quoted).collect::<Vec<_>>().join(",") + "\n"
}

/// Draws the states that are reachable under a strategy: boxes are states, points are actions.
///
/// Double boxes are starts. Actions of the progress strategy are bold, improvements green,
/// weakenings red, and successors past the limit are `…`.
pub fn dot(
    program: &Program,
    preferences: &Preferences,
    kind: Kind,
    course: &InducedModel,
    starts: usize,
) -> String {
    let words = Words { program, preferences, kind };
    let mut out = "digraph strategy {\n  node [shape=box, fontname=\"sans-serif\"];\n".to_owned();
    out.push_str("  edge [fontname=\"sans-serif\"];\n");
    for (index, node) in course.nodes.iter().enumerate() {
        let label = format!(
            "{}\n{}\n{kind} {}",
            program.show_state(&node.at.state).replace(',', ", "),
            words.list(&node.at.most_preferred),
            ranks::cell(node.at.memory.level)
        );
        let double = if index < starts { ", peripheries=2" } else { "" };
        let _ = writeln!(out, "  s{index} [label={}{double}];", quote(&label));
        moves(words, index, node, &mut out);
    }
    out.push_str("}\n");
    out
}

/// Draws the permitted actions of a state, with their branches.
fn moves(words: Words<'_>, index: usize, node: &Node, out: &mut String) {
    for (number, (action, next)) in node.at.actions.iter().zip(&node.next).enumerate() {
        if !action.permitted {
            continue;
        }
        let bold = if node.at.pick == Some(number) { ", style=bold" } else { "" };
        let _ = writeln!(out, "  a{index}_{number} [shape=point];");
        let name = quote(&action.name);
        let _ = writeln!(out, "  s{index} -> a{index}_{number} [label={name}, arrowhead=none{bold}];");
        for (branch, (successor, to)) in action.successors.iter().zip(next).enumerate() {
            let mut label = Probability(successor.probability).to_string();
            let mut color = "";
            if successor.improves {
                let _ = write!(label, "\n{} gained", words.list(&successor.gained));
                color = ", color=darkgreen, fontcolor=darkgreen";
            } else if !successor.lost.is_empty() {
                let _ = write!(label, "\n{} lost", words.list(&successor.lost));
                color = ", color=red, fontcolor=red";
            }
            let target = match to {
                Some(to) => format!("s{to}"),
                None => {
                    let _ = writeln!(out, "  m{index}_{number}_{branch} [label=\"…\", shape=none];");
                    format!("m{index}_{number}_{branch}")
                }
            };
            let _ = writeln!(out, "  a{index}_{number} -> {target} [label={}{color}];", quote(&label));
        }
    }
}

/// Quotes a string for DOT.
fn quote(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_with_commas_and_quotes_are_quoted() {
        let cells = ["a", "b,c", "say \"d\""].map(str::to_owned);
        assert_eq!(line(cells.into_iter()), "a,\"b,c\",\"say \"\"d\"\"\"\n");
    }
}
