//! The chain that the nodes of a strategy leave, and its text as a program of PRISM.

use std::fmt::Write as _;

use num_traits::Zero;

use super::exact::exact;
use super::explore::{column, distinct, of_model};
use super::graph::{Column, Graph, Row};
use meliora_base::decimal;
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_base::progress::ProgressSink;
use meliora_model::{Program, State};

/// The name of the variable that numbers the nodes.
const NODE: &str = "node";

/// Builds the graph of some nodes: their states of the model, and their choices. The first `starts` are initial. The
/// variables are those of the model and the number of the node; the labels are those of the model.
///
/// # Errors
/// A label has no value in some state.
pub fn chain(program: &Program, nodes: Vec<(State, Vec<Row>)>, starts: usize) -> Result<Graph> {
    let mut columns: Vec<Column> = program.variables.iter().map(column).collect();
    let last = i64::try_from(nodes.len()).unwrap_or(i64::MAX) - 1;
    let mut name = NODE.to_owned();
    while columns.iter().any(|column| column.name == name) {
        name.insert(0, '_');
    }
    columns.push(Column { name, is_bool: false, range: Some((0, last)) });
    let (mut states, mut rows) = (Vec::with_capacity(nodes.len()), Vec::with_capacity(nodes.len()));
    for (number, (mut state, own)) in (0..).zip(nodes) {
        state.push(number);
        states.push(state);
        rows.push(own);
    }
    let labels = distinct(of_model(program, &states)?);
    let is_dtmc = rows.iter().all(|own| own.len() == 1);
    Ok(Graph { is_dtmc, players: None, columns, states, rows, initial: (0..starts).collect(), labels })
}

/// Writes the state rewards of each structure in PRISM's explicit format; those of choices are added in a Markov chain, and
/// left out else. Cost: one step of the program per state.
///
/// # Errors
/// The program has no meaning in a state; a limit is reached.
pub fn state_rewards(graph: &Graph, program: &Program, sink: &dyn ProgressSink) -> Result<Vec<String>> {
    let text = |own: Vec<Ratio>| {
        let given: Vec<(usize, &Ratio)> =
            own.iter().enumerate().filter(|(_, reward)| !reward.is_zero()).collect();
        let mut text = format!("{} {}\n", own.len(), given.len());
        for (state, reward) in given {
            let _ = writeln!(text, "{state} {}", decimal::plain(reward));
        }
        text
    };
    Ok(rewards(graph, program, sink)?.into_iter().map(|(_, states, _)| text(states)).collect())
}

/// The name of a structure, its rewards of states, and of choices.
type Earned = (String, Vec<Ratio>, Vec<Ratio>);

/// Returns the rewards; in a Markov chain, states have those of their choice.
fn rewards(graph: &Graph, program: &Program, sink: &dyn ProgressSink) -> Result<Vec<Earned>> {
    let own = exact(graph, program, sink)?.rewards.into_iter().map(|own| {
        if !graph.is_dtmc {
            return (own.name, own.states, own.choices);
        }
        let both = own.states.iter().zip(&own.choices).map(|(state, choice)| state + choice).collect();
        (own.name, both, Vec::new())
    });
    Ok(own.collect())
}

/// Writes a graph as a program of PRISM. Its variables are the number of the node, and those of the model whose names PRISM
/// accepts. Cost: one step of the program per state.
///
/// # Errors
/// The program has no meaning in a state; a limit is reached.
pub fn program_text(graph: &Graph, program: &Program, sink: &dyn ProgressSink) -> Result<String> {
    let numbers = exact(graph, program, sink)?;
    let (node, known) = (graph.columns.len() - 1, shown(graph));
    let mut text = String::from(if graph.is_dtmc { "dtmc\n\n" } else { "mdp\n\n" });
    text.push_str("module strategy\n");
    for &at in &known {
        let Column { name, is_bool, range } = &graph.columns[at];
        let (low, high) = range.unwrap_or_default();
        let ty = if *is_bool { "bool".to_owned() } else { format!("[{low}..{high}]") };
        let init = match graph.initial.as_slice() {
            [only] => format!(" init {}", graph.columns[at].show(graph.states[*only][at])),
            _ => String::new(),
        };
        let _ = writeln!(text, "  {name} : {ty}{init};");
    }
    let mut probabilities = numbers.probabilities.iter();
    for (number, rows) in graph.rows.iter().enumerate() {
        for (choice, row) in rows.iter().enumerate() {
            let label = if graph.is_dtmc { String::new() } else { format!("c{choice}") };
            let mut branches = Vec::with_capacity(row.successors.len());
            for (to, _) in &row.successors {
                let p = probabilities.next().map_or_else(String::new, decimal::plain);
                let update = |&at: &usize| {
                    let column = &graph.columns[at];
                    format!("({}'={})", column.name, column.show(graph.states[*to][at]))
                };
                branches.push(format!("{p}:{}", known.iter().map(update).collect::<Vec<_>>().join("&")));
            }
            let _ = writeln!(
                text,
                "  [{label}] {}={number} -> {};",
                graph.columns[node].name,
                branches.join(" + ")
            );
        }
    }
    text.push_str("endmodule\n");
    if graph.initial.len() > 1 {
        let start = |number: &usize| {
            let equal = |&at: &usize| {
                format!("{}={}", graph.columns[at].name, graph.columns[at].show(graph.states[*number][at]))
            };
            known.iter().map(equal).collect::<Vec<_>>().join("&")
        };
        let all: Vec<String> = graph.initial.iter().map(start).collect();
        let _ = write!(text, "\ninit\n  {}\nendinit\n", all.join(" |\n  "));
    }
    add_rewards(&mut text, graph, rewards(graph, program, sink)?);
    add_labels(&mut text, graph);
    Ok(text)
}

/// Returns the columns that PRISM can have as variables.
fn shown(graph: &Graph) -> Vec<usize> {
    let is_name = |name: &str| {
        name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
            && !name.starts_with(|c: char| c.is_ascii_digit())
    };
    (0..graph.columns.len())
        .filter(|&at| is_name(&graph.columns[at].name) && graph.columns[at].range.is_some())
        .collect()
}

fn add_rewards(text: &mut String, graph: &Graph, all: Vec<Earned>) {
    let node = &graph.columns[graph.columns.len() - 1].name;
    for (name, states, choices) in all {
        let _ = write!(text, "\nrewards \"{name}\"\n");
        for (state, reward) in states.iter().enumerate().filter(|(_, reward)| !reward.is_zero()) {
            let _ = writeln!(text, "  {node}={state} : {};", decimal::plain(reward));
        }
        let of =
            graph.rows.iter().enumerate().flat_map(|(state, rows)| (0..rows.len()).map(move |c| (state, c)));
        for ((state, choice), reward) in of.zip(&choices).filter(|(_, reward)| !reward.is_zero()) {
            let _ = writeln!(text, "  [c{choice}] {node}={state} : {};", decimal::plain(reward));
        }
        text.push_str("endrewards\n");
    }
}

fn add_labels(text: &mut String, graph: &Graph) {
    let node = &graph.columns[graph.columns.len() - 1].name;
    for (name, states) in &graph.labels {
        let all: Vec<String> = states.iter().map(|state| format!("{node}={state}")).collect();
        let condition = if all.is_empty() { "false".to_owned() } else { all.join(" | ") };
        let _ = write!(text, "\nlabel \"{name}\" = {condition};");
    }
    text.push('\n');
}
