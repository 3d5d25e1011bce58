//! Strategies as CSV and as DOT.

use std::fmt::Write;

use super::ranks;
use super::reason::Words;
use super::state::{Place, StateReport};
use super::text::Probability;
use meliora_base::{csv, escape};
use meliora_model::Program;
use meliora_model::valuation::Valuation;
use meliora_planning::InducedModel;
use meliora_planning::explain::{Action, Successor};
use meliora_planning::induced_model::Node;

/// The columns of a table of the whole strategy: the node of the state, whether paths start there, the
/// memory, and the nodes that follow.
const WHOLE: [&str; 6] = ["node", "start", "level", "reference", "pursues", "then"];

/// Returns the heading: the variables, then the columns for each action; for a game, also who chooses;
/// and for the whole strategy the columns with which other programs can follow it.
pub fn csv_heading(program: &Program, whole: bool) -> String {
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
    let of_games = program.players.iter().flat_map(|_| ["owner", "player"]);
    let places = if whole { &WHOLE[..] } else { &[] };
    csv::lines([variables.chain(columns).chain(of_games).chain(places.iter().copied())])
}

/// Returns the lines of a state, one per action.
pub fn csv_rows(state: &StateReport<'_>) -> String {
    let (words, at, picked) = (state.words, &state.at, state.picked_action());
    let row = |(position, action): (usize, &Action)| {
        let pick = picked.is_some_and(|picked| picked.name == action.name);
        let flag = |f: bool| if at.is_theirs() { String::new() } else { f.to_string() };
        let flags = [action.kept, action.permitted, action.progress, pick].map(flag);
        let mut cells: Vec<String> = Valuation::new(words.program, &at.state).cells().collect();
        cells.push(words.names(&at.most_preferred).join("+"));
        cells.extend(state.ranks.map(ranks::cell));
        cells.push(action.name.clone());
        cells.extend(flags);
        cells.push(words.reason(at, action));
        if words.program.players.is_some() {
            let owner = at.owner.map_or("", |owner| if owner.ours { "ours" } else { "opponent" });
            cells.extend([owner, words.player(at).unwrap_or_default()].map(str::to_owned));
        }
        cells.extend(state.place.iter().flat_map(|place| place_cells(state, place, position)));
        cells
    };
    csv::lines(at.actions.iter().enumerate().map(row))
}

/// Returns the cells of [`WHOLE`] for the action at this position. The last one has the probability and
/// the node of each successor, `0.5:12 0.5:13`; it is empty if the strategy does not take the action.
fn place_cells(state: &StateReport<'_>, place: &Place, position: usize) -> [String; 6] {
    let (words, at) = (state.words, &state.at);
    let successors = at.actions[position].successors.iter().zip(&place.next[position]);
    let step = |(successor, node): (&Successor, &Option<usize>)| {
        node.map(|node| format!("{}:{node}", successor.probability))
    };
    [
        place.node.to_string(),
        place.is_start.to_string(),
        ranks::cell(at.memory.level),
        words.names(&at.reference).join("+"),
        words.pursued(at).unwrap_or_default(),
        successors.filter_map(step).collect::<Vec<_>>().join(" "),
    ]
}

/// Draws the states that are reachable under a strategy: boxes are states, points are actions.
///
/// Double boxes are starts. Actions of the progress strategy are bold, improvements green,
/// weakenings red, and successors past the limit are `…`. States of an opponent are grey hexagons, with
/// dashed lines to all of its actions.
pub fn dot(words: Words<'_>, unfolded: &InducedModel, starts: usize) -> String {
    let mut out = "digraph strategy {\n  node [shape=box, fontname=\"sans-serif\"];\n".to_owned();
    out.push_str("  edge [fontname=\"sans-serif\"];\n");
    for (index, node) in unfolded.nodes.iter().enumerate() {
        let label = format!(
            "{}\n{}\n{}",
            words.program.show_values(&node.at.state, ", "),
            words.either(&node.at.most_preferred),
            match words.pursued(&node.at) {
                Some(name) => format!("to {name}"),
                None => format!("{} {}", words.levels, ranks::cell(node.at.memory.level)),
            }
        );
        let label = match words.player(&node.at) {
            Some(player) => format!("{player}: {label}"),
            None => label,
        };
        let double = if index < starts { ", peripheries=2" } else { "" };
        let theirs = ", shape=hexagon, style=filled, fillcolor=lightgrey";
        let theirs = if node.at.is_theirs() { theirs } else { "" };
        let _ = writeln!(out, "  s{index} [label={}{double}{theirs}];", escape::dot(&label));
        moves(words, index, node, &mut out);
    }
    out.push_str("}\n");
    out
}

/// Draws the permitted actions of a state, or all actions of the opponent, with their branches.
fn moves(words: Words<'_>, index: usize, node: &Node, out: &mut String) {
    for (number, (action, next)) in node.at.actions.iter().zip(&node.next).enumerate() {
        let theirs = node.at.is_theirs() && !node.at.is_over();
        if !action.permitted && !theirs {
            continue;
        }
        let bold = match node.at.pick == Some(number) {
            true => ", style=bold",
            false if theirs => ", style=dashed",
            false => "",
        };
        let _ = writeln!(out, "  a{index}_{number} [shape=point];");
        let name = escape::dot(&action.name);
        let _ = writeln!(out, "  s{index} -> a{index}_{number} [label={name}, arrowhead=none{bold}];");
        for (branch, (successor, to)) in action.successors.iter().zip(next).enumerate() {
            let mut label = Probability(successor.probability).to_string();
            let mut color = "";
            if successor.improves {
                let _ = write!(label, "\n{} gained", words.either(&successor.gained));
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
            let _ = writeln!(out, "  a{index}_{number} -> {target} [label={}{color}];", escape::dot(&label));
        }
    }
}
