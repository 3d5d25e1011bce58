//! Strategies for several objectives at once, as JSON: one is drawn at the start, and followed.

use std::sync::Arc;

use meliora_base::error::{Diagnostic, Error, Result, SourceFile};
use meliora_base::exact::Ratio;
use meliora_model::valuation::Valuation;
use meliora_model::{Program, State, fault};
use meliora_quantities::answer::PRECISION;
use meliora_quantities::several::{Node, Taking};
use num_traits::ToPrimitive;
use serde::{Deserialize, Serialize};

use super::policy_file::place;

/// A strategy of a mix.
pub struct Mixed<'m> {
    /// The probability with which it is drawn; `None` for a point of a front.
    pub share: Option<&'m Ratio>,
    /// The values of the objectives that it guarantees.
    pub values: &'m [Ratio],
    /// The states that it visits with its memory, the start first.
    pub nodes: &'m [(State, Node)],
}

/// A strategy of a file.
pub struct ReadStrategy {
    /// The probability with which it is drawn; `None` for a point of a front.
    pub share: Option<f64>,
    /// The values of the objectives that it claims.
    pub values: Vec<f64>,
    /// The states that it visits, the start first, and the choices that it takes there.
    pub nodes: Vec<(State, Vec<Taking>)>,
}

#[derive(Serialize, Deserialize)]
struct File {
    property: String,
    strategies: Vec<StrategyEntry>,
}

#[derive(Serialize, Deserialize)]
struct StrategyEntry {
    share: Option<f64>,
    values: Vec<f64>,
    nodes: Vec<NodeEntry>,
}

#[derive(Serialize, Deserialize)]
struct NodeEntry {
    state: Valuation,
    /// The positions of the objectives that the path has decided.
    decided: Vec<u32>,
    steps: u32,
    /// The actions, each of which is taken with the same probability.
    actions: Vec<ActionEntry>,
}

#[derive(Serialize, Deserialize)]
struct ActionEntry {
    action: String,
    /// The position among the choices of the state.
    position: usize,
    successors: Vec<SuccessorEntry>,
}

#[derive(Serialize, Deserialize)]
struct SuccessorEntry {
    node: usize,
    probability: f64,
}

/// Returns the strategies of a property as an object in JSON.
///
/// # Errors
/// A command has no meaning in some state.
pub fn json(property: &str, strategies: &[Mixed<'_>], program: &Program) -> Result<String> {
    let strategy = |own: &Mixed<'_>| {
        let nodes = own.nodes.iter().map(|(state, node)| entry(program, state, node));
        Ok(StrategyEntry {
            share: own.share.map(number),
            // Rounding outwards may lead below 0, where no probability and no reward is.
            values: own.values.iter().map(|x| number(x).max(0.0)).collect(),
            nodes: nodes.collect::<Result<_>>()?,
        })
    };
    let strategies = strategies.iter().map(strategy).collect::<Result<_>>()?;
    let text = serde_json::to_string_pretty(&File { property: property.to_owned(), strategies });
    text.map_err(|e| Error::Usage(e.to_string()))
}

fn number(x: &Ratio) -> f64 {
    x.to_f64().unwrap_or(f64::NAN)
}

fn entry(program: &Program, state: &State, node: &Node) -> Result<NodeEntry> {
    let steps = program.steps(state).map_err(|f| fault::error(program, &f, state))?;
    let action = |taking: &Taking| ActionEntry {
        action: steps.get(taking.position).map(|step| step.name.clone()).unwrap_or_default(),
        position: taking.position,
        successors: taking
            .successors
            .iter()
            .map(|(node, p)| SuccessorEntry { node: *node, probability: number(p) })
            .collect(),
    };
    Ok(NodeEntry {
        state: Valuation::of(program, state),
        decided: (0..u32::BITS).filter(|at| node.decided >> at & 1 == 1).collect(),
        steps: node.steps,
        actions: node.choices.iter().map(action).collect(),
    })
}

/// Returns whether a text is that of strategies for several objectives, and not of another policy.
pub fn is_mix(source: &SourceFile) -> bool {
    source.text.trim_start().starts_with('{')
}

/// Reads strategies for several objectives; returns the text of the property and the strategies.
///
/// # Errors
/// The text is wrong; a state or an action is none of the model; the shares do not sum to 1.
pub fn read(source: &Arc<SourceFile>, program: &Program) -> Result<(String, Vec<ReadStrategy>)> {
    let file: File = serde_json::from_str(&source.text).map_err(|error| {
        let wrong = Diagnostic::new(source, place(source, &error), error.to_string());
        wrong.help("expected a file of `reach --policy` for a property `multi(…)`")
    })?;
    let wrong = |message: String| Error::from(Diagnostic::new(source, 0..0, message));
    let shares: Vec<Option<f64>> = file.strategies.iter().map(|own| own.share).collect();
    let is_front = shares.iter().all(Option::is_none) && !shares.is_empty();
    let sum: f64 = shares.iter().flatten().sum();
    let is_mixed = shares.iter().all(|share| share.is_some_and(|share| (0.0..=1.0).contains(&share)));
    if !(is_front || is_mixed && (sum - 1.0).abs() <= PRECISION) {
        return Err(wrong(format!(
            "the shares of the strategies are probabilities that sum to 1: here the sum is {sum}"
        )));
    }
    let mut strategies = Vec::new();
    for (number, own) in (1..).zip(file.strategies) {
        if own.nodes.is_empty() {
            return Err(wrong(format!("strategy {number} visits no state")));
        }
        let mut nodes = Vec::new();
        for node in own.nodes {
            let state = node.state.state(program).ok_or_else(|| {
                wrong(format!("strategy {number}: `{}` is not a state of the model", node.state))
            })?;
            let choices = taken(program, &state, node.actions)
                .map_err(|message| wrong(format!("strategy {number}: in `{}`, {message}", node.state)))?;
            nodes.push((state, choices));
        }
        strategies.push(ReadStrategy { share: own.share, values: own.values, nodes });
    }
    Ok((file.property, strategies))
}

/// Returns the choices of some actions, or a message about a wrong one.
fn taken(
    program: &Program,
    state: &State,
    actions: Vec<ActionEntry>,
) -> std::result::Result<Vec<Taking>, String> {
    let steps = program.steps(state).unwrap_or_default();
    let mut choices = Vec::new();
    for ActionEntry { action, position, successors } in actions {
        if steps.get(position).is_none_or(|step| step.name != action) {
            return Err(format!("the choice with the position {position} is not `{action}`"));
        }
        let mut after = Vec::new();
        for SuccessorEntry { node, probability } in successors {
            let p = Ratio::from_float(probability);
            after.push((node, p.ok_or_else(|| format!("`{action}` has an infinite probability"))?));
        }
        choices.push(Taking { position, successors: after });
    }
    Ok(choices)
}
