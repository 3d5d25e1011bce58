//! The strategy of the outermost operator of a property: as JSON, one strategy with one value; as a table and a drawing.

use std::fmt::Write;
use std::sync::Arc;

use meliora_base::csv::Lines;
use meliora_base::error::{Diagnostic, Error, Result, SourceFile};
use meliora_base::escape;
use meliora_base::exact::{Exact, Ratio, Real, shortest};
use meliora_model::valuation::Valuation;
use meliora_model::{Program, Variable};
use meliora_question::evaluate::{Number, PolicyNode, PropertyPolicy};
use num_traits::One;

use super::mix::{self, ActionEntry, Claim, File, Fraction, NodeEntry, Side};
use super::node_lines::{Names, NodeLines, Source, text};

/// A strategy of a file.
pub struct ReadPolicy {
    /// The value that it claims; `None` for infinity.
    pub value: Option<Ratio>,
    /// The nodes.
    pub nodes: Vec<PolicyNode>,
    /// The number of nodes in which paths may start.
    pub starts: usize,
    /// True if the nodes state the memory of monitors.
    pub is_watched: bool,
}

/// Returns the value that a strategy claims: a short decimal that its value surely attains; `None` for infinity.
pub fn claim(policy: &PropertyPolicy) -> Option<Ratio> {
    let Number { interval, exact } = &policy.value;
    let bound = if policy.is_great { interval.lower } else { interval.upper };
    match exact {
        Some(Exact::Int(x)) => Some(Ratio::from_integer((*x).into())),
        Some(Exact::Real(Real::Finite(x))) => Some(short(x, policy.is_great)),
        _ => shortest(bound).map(|x| match Ratio::from_float(bound) {
            Some(exact) if x != exact => short(&exact, policy.is_great),
            _ => x,
        }),
    }
}

fn short(x: &Ratio, is_great: bool) -> Ratio {
    if *x < Ratio::default() { x.clone() } else { mix::short(x, is_great) }
}

/// Writes the strategy of a property as an object in JSON, with one line for each node, piece by piece.
///
/// # Errors
/// A command has no meaning in some state; the errors of `write`.
pub fn json(
    property: &str,
    policy: &PropertyPolicy,
    program: &Program,
    write: &mut dyn FnMut(&str) -> Result<()>,
) -> Result<()> {
    let side = if policy.of_opponent { ",\n  \"side\": \"opponent\"" } else { "" };
    let starts = if policy.starts == 1 { String::new() } else { format!("\"starts\": {}, ", policy.starts) };
    let mut out = format!(
        "{{\n  \"property\": {}{side},\n  \"strategies\": [{{\"share\": {}, \"values\": [{}], {starts}\"nodes\": [",
        text(&property),
        text(&Fraction(Ratio::one())),
        text(&Claim(claim(policy))),
    );
    let source = Source::of_policy(policy, program)?;
    let memory = policy.watched.as_deref().map(|watched| monitors(program, Some(watched)));
    let mut lines = NodeLines::new(source.names(), &program.variables, memory);
    policy.nodes.each(|number, node| {
        if out.len() > PIECE {
            write(&out)?;
            out.clear();
        }
        out.push_str(if number > 0 { ",\n    " } else { "\n    " });
        lines.push(number, node, &mut out)
    })?;
    out.push_str("\n  ]}]\n}\n");
    write(&out)
}

/// The length from which a piece of a text is written.
const PIECE: usize = 1 << 16;

/// Returns the strategy of a property as a table: one row for each node, with the values of the variables, the memory and
/// the actions. A node without actions decides the path.
///
/// # Errors
/// A command has no meaning in some state.
pub fn csv(policy: &PropertyPolicy, program: &Program) -> Result<String> {
    let monitors = monitors(program, policy.watched.as_deref());
    let variables = program.variables.iter().chain(monitors).map(|variable| variable.name.clone());
    let heading = ["node".to_owned()].into_iter().chain(variables);
    let last = ["steps", "round", "action", "position", "next"].map(str::to_owned);
    let source = Source::of_policy(policy, program)?;
    let (mut names, mut lines) = (source.names(), Lines::default());
    lines.push(heading.chain(last));
    policy.nodes.each(|number, node| {
        let entry = entry(program, (&mut names, number), policy.watched.as_deref(), node)?;
        let memory = entry.memory.unwrap_or_default();
        let all =
            |text: fn(&ActionEntry) -> String| entry.actions.iter().map(text).collect::<Vec<_>>().join(" | ");
        let next = |own: &ActionEntry| {
            own.successors.iter().map(|to| to.node.to_string()).collect::<Vec<_>>().join(" ")
        };
        let action = if node.theirs { String::new() } else { all(|own| own.action.clone()) };
        let position = if node.theirs { String::new() } else { all(|own| own.position.to_string()) };
        let last = [node.steps.to_string(), node.round.to_string(), action, position, all(next)];
        lines.push(
            [number.to_string()].into_iter().chain(entry.state.cells()).chain(memory.cells()).chain(last),
        );
        Ok(())
    })?;
    Ok(lines.text())
}

/// Returns the strategy of a property as a graph in DOT, of at most 1000 nodes.
///
/// # Errors
/// There are more nodes; a command has no meaning in some state.
pub fn dot(policy: &PropertyPolicy, program: &Program) -> Result<String> {
    let count = policy.nodes.count();
    if count > MOST_DRAWN {
        let message = format!(
            "the strategy has {count} nodes, and a drawing at most {MOST_DRAWN}: write .json or .csv"
        );
        return Err(Error::Usage(message));
    }
    let source = Source::of_policy(policy, program)?;
    let mut names = source.names();
    let mut out = String::from("digraph strategy {\n  node [shape=box];\n");
    policy.nodes.each(|number, node| {
        let entry = entry(program, (&mut names, number), policy.watched.as_deref(), node)?;
        let memory = entry.memory.filter(|_| !node.memory.is_empty());
        let memory = memory.map_or_else(String::new, |memory| format!("\n{memory}"));
        let label = escape::dot(&format!("{}{memory}", entry.state));
        let style = if node.theirs { ", style=dashed" } else { "" };
        let _ = writeln!(out, "  {number} [label={label}{style}];");
        for own in &entry.actions {
            for to in &own.successors {
                let p = if own.successors.len() > 1 { format!(" {}", to.probability) } else { String::new() };
                let label = escape::dot(&format!("{}{p}", own.action));
                let _ = writeln!(out, "  {number} -> {} [label={label}];", to.node);
            }
        }
        Ok(())
    })?;
    out.push_str("}\n");
    Ok(out)
}

/// Maximum number of nodes of a drawing.
const MOST_DRAWN: usize = 1000;

/// Returns the variables of the monitors.
fn monitors<'p>(program: &Program, watched: Option<&'p Program>) -> &'p [Variable] {
    watched.map_or(&[], |watched| &watched.variables[program.variables.len()..])
}

fn entry(
    program: &Program,
    (names, number): (&mut Names<'_>, usize),
    watched: Option<&Program>,
    node: &PolicyNode,
) -> Result<NodeEntry> {
    let monitors = monitors(program, watched);
    Ok(NodeEntry {
        state: Valuation::new(program, &node.state),
        memory: watched.map(|_| Valuation::of_variables(monitors, &node.memory)),
        decided: None,
        steps: (node.steps > 0).then_some(node.steps),
        round: (node.round > 0).then_some(node.round),
        other: node.theirs,
        actions: mix::actions(names.of(number, &node.state)?, &node.choices),
    })
}

impl File {
    /// Returns whether it is the strategy of the opponent.
    pub fn is_of_opponent(&self) -> bool {
        self.side == Some(Side::Opponent)
    }

    /// Returns the strategy of one operator; `watched` is the program with the monitors of its formula.
    ///
    /// # Errors
    /// There are several strategies; a state or an action is none of the model.
    pub fn policy(
        &self,
        source: &Arc<SourceFile>,
        program: &Program,
        watched: Option<&Program>,
    ) -> Result<ReadPolicy> {
        let wrong = |message: String| Error::from(Diagnostic::new(source, 0..0, message));
        let [own] = &self.strategies[..] else {
            return Err(wrong("expected one strategy for one operator".to_owned()));
        };
        if own.share.as_ref().is_some_and(|share| !share.0.is_one()) {
            return Err(wrong("the share of the only strategy is 1".to_owned()));
        }
        let [Claim(value)] = &own.values[..] else {
            return Err(wrong("expected one value for one operator".to_owned()));
        };
        let starts = own.starts.unwrap_or(1);
        if starts == 0 || starts > own.nodes.len() {
            return Err(wrong(format!("{starts} starts of {} nodes", own.nodes.len())));
        }
        let is_watched = watched.is_some() && own.nodes.iter().any(|node| node.memory.is_some());
        let monitors = if is_watched { monitors(program, watched) } else { &[] };
        let mut nodes = Vec::with_capacity(own.nodes.len());
        for (number, node) in own.nodes.iter().enumerate() {
            let wrong = |message| wrong(format!("node {number}: in `{}`: {message}", node.state));
            let state =
                node.state.state(program).ok_or_else(|| wrong("not a state of the model".to_owned()))?;
            let memory = node.memory.clone().unwrap_or_default().values(monitors);
            let memory = memory.ok_or_else(|| {
                wrong("the memory does not have the states of the monitors of the formula".to_owned())
            })?;
            let choices = mix::taken(program, &state, &node.actions).map_err(wrong)?;
            let (steps, round) = (node.steps.unwrap_or_default(), node.round.unwrap_or_default());
            nodes.push(PolicyNode { state, memory, steps, round, theirs: node.other, choices });
        }
        Ok(ReadPolicy { value: value.clone(), nodes, starts, is_watched })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meliora_equations::several::Taking;

    #[test]
    fn lines_of_nodes_are_their_json() -> Result<()> {
        let model = "mdp module m x : [0..200000] init 0; b : bool init false; \
                     [go] x=0 -> 1/3: (x'=100000) + 2/3: (x'=2) & (b'=true); [] x=0 -> true; [go] x>1 -> true; endmodule";
        let read = |name, text: &str| SourceFile::new(name, text);
        let program = meliora_lang::load(&read("m.prism", model), &read("constants", ""))?.program;
        let third = |parts: i64| Arc::new(Ratio::new(parts.into(), 3.into()));
        let taking = |position, successors| Taking { position, successors };
        let node = |state: &[i64], steps, theirs, choices| PolicyNode {
            state: state.to_vec(),
            memory: Vec::new(),
            steps,
            round: steps / 2,
            theirs,
            choices,
        };
        let both = vec![taking(0, vec![(10, third(1)), (2, third(2))]), taking(1, vec![(0, third(3))])];
        let nodes = [
            node(&[0, 0], 0, true, both),
            node(&[100_000, 0], 1, false, vec![taking(0, vec![(1, third(3))])]),
            node(&[2, 1], 12, false, Vec::new()),
        ];
        let source = Source::new(&program)?;
        let mut names = source.names();
        for watched in [None, Some(&program)] {
            let memory = watched.map(|watched| monitors(&program, Some(watched)));
            let mut lines = NodeLines::new(source.names(), &program.variables, memory);
            for (number, node) in nodes.iter().enumerate() {
                let mut line = String::new();
                lines.push(number, node, &mut line)?;
                assert_eq!(line, text(&entry(&program, (&mut names, number), watched, node)?));
            }
        }
        Ok(())
    }
}
