//! Strategies for several objectives at once, as JSON: one is drawn at the start, and followed.

use meliora_base::error::{Error, Result};
use meliora_base::exact::Ratio;
use meliora_model::valuation::Valuation;
use meliora_model::{Program, State, fault};
use meliora_quantities::several::{Node, Taking};
use num_traits::ToPrimitive;
use serde::Serialize;

/// A strategy of a mix.
pub struct Mixed<'m> {
    /// The probability with which it is drawn; `None` for a point of a front.
    pub share: Option<&'m Ratio>,
    /// The values of the objectives that it guarantees.
    pub values: &'m [Ratio],
    /// The states that it visits with its memory, the start first.
    pub nodes: &'m [(State, Node)],
}

#[derive(Serialize)]
struct File<'m> {
    property: &'m str,
    strategies: Vec<StrategyEntry>,
}

#[derive(Serialize)]
struct StrategyEntry {
    share: Option<f64>,
    values: Vec<f64>,
    nodes: Vec<NodeEntry>,
}

#[derive(Serialize)]
struct NodeEntry {
    state: Valuation,
    /// The positions of the objectives that the path has decided.
    decided: Vec<u32>,
    steps: u32,
    /// The actions, each of which is taken with the same probability.
    actions: Vec<ActionEntry>,
}

#[derive(Serialize)]
struct ActionEntry {
    action: String,
    /// The position among the choices of the state.
    position: usize,
    successors: Vec<SuccessorEntry>,
}

#[derive(Serialize)]
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
    let text = serde_json::to_string_pretty(&File { property, strategies });
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
