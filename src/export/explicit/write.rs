//! Writers of PRISM's `.tra`, `.sta` and `.lab`, and of Storm's `.drn`.
//!
//! Probabilities and rewards are written as the shortest decimals that read back as the same doubles.

use std::borrow::Cow;
use std::fmt::Write as _;

use num_traits::{ToPrimitive, Zero};

use super::exact::{Rewards, exact};
use super::graph::{Graph, Row};
use meliora_base::csv;
use meliora_base::error::Result;
use meliora_base::escape::{first_word, quoted, word};
use meliora_base::exact::Ratio;
use meliora_base::progress::ProgressSink;
use meliora_model::Program;

/// The three files of PRISM.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PrismFiles {
    /// Transitions.
    pub tra: String,
    /// Values of the states.
    pub sta: String,
    /// Labels.
    pub lab: String,
}

/// Writes a model in PRISM's explicit format.
pub fn prism(graph: &Graph) -> PrismFiles {
    PrismFiles { tra: tra(graph), sta: sta(graph), lab: lab(graph) }
}

fn tra(graph: &Graph) -> String {
    let (states, choices, transitions) = (graph.states.len(), graph.choices(), graph.transitions());
    let mut text = match (graph.is_dtmc, &graph.players) {
        (true, _) => format!("{states} {transitions}\n"),
        (false, None) => format!("{states} {choices} {transitions}\n"),
        (false, Some(players)) => format!("{states}:{} {choices} {transitions}\n", players.names.len()),
    };
    for (state, rows) in graph.rows.iter().enumerate() {
        let player = graph.players.as_ref().map_or_else(String::new, |p| format!(":{}", p.owners[state]));
        for (choice, row) in rows.iter().enumerate() {
            for (to, p) in &row.successors {
                let _ = match graph.is_dtmc {
                    true => writeln!(text, "{state} {to} {p}"),
                    false => writeln!(text, "{state}{player} {choice} {to} {p} {}", word(&row.action)),
                };
            }
        }
    }
    text
}

fn sta(graph: &Graph) -> String {
    let names: Vec<&str> = graph.columns.iter().map(|c| c.name.as_str()).collect();
    let mut text = format!("({})\n", names.join(","));
    for (number, values) in graph.states.iter().enumerate() {
        let _ = writeln!(text, "{number}:({})", shown(graph, values, |_, v| v));
    }
    text
}

/// Formats the values of a state, separated by commas.
fn shown(graph: &Graph, values: &[i64], show: impl Fn(&str, String) -> String) -> String {
    let cells = graph.columns.iter().zip(values).map(|(c, &v)| show(&c.name, c.show(v)));
    cells.collect::<Vec<_>>().join(",")
}

/// Returns the names of labels, "init" first, and for each state the indices of its labels.
fn labels_by_state(graph: &Graph) -> (Vec<&str>, Vec<Vec<usize>>) {
    let names = std::iter::once("init").chain(graph.labels.iter().map(|l| l.0.as_str())).collect();
    let mut of = vec![Vec::new(); graph.states.len()];
    let all = std::iter::once(&graph.initial).chain(graph.labels.iter().map(|l| &l.1));
    for (position, states) in all.enumerate() {
        states.iter().for_each(|&s| of[s].push(position));
    }
    (names, of)
}

fn lab(graph: &Graph) -> String {
    let (names, of) = labels_by_state(graph);
    let numbered = names.iter().enumerate().map(|(i, name)| format!("{i}={}", quoted(name)));
    let mut text = numbered.collect::<Vec<_>>().join(" ") + "\n";
    for (state, labels) in of.iter().enumerate().filter(|(_, labels)| !labels.is_empty()) {
        let labels: Vec<String> = labels.iter().map(usize::to_string).collect();
        let _ = writeln!(text, "{state}: {}", labels.join(" "));
    }
    text
}

/// Refuses the format DRN of a game.
///
/// # Errors
/// The model is a game.
pub fn refuse_drn(program: &Program) -> Result<()> {
    let help = "the format has no players: write `--format umb` or `explicit`, or add `--kind` and `--scheduler \
                progress` for the mdp that a strategy leaves to the opponent";
    program.refuse_game("`--format drn`", help)
}

/// Writes a model in Storm's explicit format, with the reward structures of the program that have a
/// value in all states. The values of the variables are comments. Cost: for rewards, one step of the
/// program per state.
///
/// # Errors
/// The program has no meaning in a state; a limit is reached; the model is a game, whose players the
/// format does not have.
pub fn drn(graph: &Graph, program: &Program, sink: &dyn ProgressSink) -> Result<String> {
    if graph.players.is_some() {
        refuse_drn(program)?;
    }
    let rewards = match program.rewards.is_empty() {
        true => Vec::new(),
        false => exact(graph, program, sink)?.rewards,
    };
    let earned = |of: &dyn Fn(&Rewards) -> String| match rewards.is_empty() {
        true => String::new(),
        false => format!(" [{}]", rewards.iter().map(of).collect::<Vec<_>>().join(", ")),
    };
    let models: Vec<Cow<'_, str>> = rewards.iter().map(|rewards| first_word(&rewards.name)).collect();
    let models = models.join(" ");
    let (names, of) = labels_by_state(graph);
    let kind = if graph.is_dtmc { "DTMC" } else { "MDP" };
    let (states, choices) = (graph.states.len(), graph.choices());
    let mut text = format!("@type: {kind}\n@parameters\n\n@reward_models\n{models}\n");
    let mut number = 0;
    let _ = write!(text, "@nr_states\n{states}\n@nr_choices\n{choices}\n@model\n");
    for (state, rows) in graph.rows.iter().enumerate() {
        let _ = write!(text, "state {state}{}", earned(&|rewards| decimal(&rewards.states[state])));
        for &label in &of[state] {
            let _ = write!(text, " {}", label_word(names[label]));
        }
        let _ = writeln!(text, "\n//[{}]", shown(graph, &graph.states[state], |n, v| format!("{n}={v}")));
        for (choice, row) in rows.iter().enumerate() {
            let earned = earned(&|rewards| decimal(&rewards.choices[number]));
            number += 1;
            let _ = match graph.is_dtmc {
                true => writeln!(text, "\taction {choice}{earned}"),
                false => writeln!(text, "\taction {}{earned}", word(&row.action)),
            };
            for (to, p) in &row.successors {
                let _ = writeln!(text, "\t\t{to} : {p}");
            }
        }
    }
    Ok(text)
}

/// Returns a label as a word of DRN: in double quotes where it could be read as something else.
fn label_word(name: &str) -> Cow<'_, str> {
    let is_plain = !name.contains(|c: char| c.is_whitespace() || matches!(c, '"' | '['));
    match is_plain && !name.starts_with(['!', '{']) && !name.is_empty() {
        true => Cow::Borrowed(name),
        false => Cow::Owned(quoted(name)),
    }
}

/// Formats a reward as the shortest decimal of the nearest double, or as a fraction where doubles
/// cannot tell it from 0 or infinity.
fn decimal(reward: &Ratio) -> String {
    let near = reward.to_f64().filter(|x| x.is_finite() && (*x != 0.0 || reward.is_zero()));
    near.map_or_else(|| reward.to_string(), |x| x.to_string())
}

/// Writes a CSV file with one row per state: its number, its values, and the names of its choices,
/// separated by ` | `.
pub fn action_table(graph: &Graph) -> String {
    let names = graph.columns.iter().map(|column| column.name.clone());
    let heading = std::iter::once("state".to_owned()).chain(names).chain(["actions".to_owned()]).collect();
    let row = |(number, (values, rows)): (usize, (&Vec<i64>, &Vec<Row>))| {
        let actions: Vec<&str> = rows.iter().map(|row| row.action.as_str()).collect();
        let values = graph.columns.iter().zip(values).map(|(column, &value)| column.show(value));
        [number.to_string()].into_iter().chain(values).chain([actions.join(" | ")]).collect()
    };
    let rows = graph.states.iter().zip(&graph.rows).enumerate().map(row);
    csv::lines(std::iter::once::<Vec<String>>(heading).chain(rows))
}
