//! Strategies for several objectives at once, as JSON: one is drawn at the start, and followed.

use std::sync::Arc;

use meliora_base::decimal;
use meliora_base::error::{Diagnostic, Error, Result, SourceFile};
use meliora_base::exact::Ratio;
use meliora_base::exact::shortest;
use meliora_model::valuation::Valuation;
use meliora_model::{Program, State, fault};
use meliora_quantities::several::{Node, Taking};
use meliora_question::evaluate::{Mix, MixedStrategy};
use num_traits::{One, Signed, ToPrimitive};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::value::RawValue;

use super::policy_file::place;

/// A strategy of a file.
pub struct ReadStrategy {
    /// The probability with which it is drawn; `None` for a point of a front.
    pub share: Option<Ratio>,
    /// The values of the objectives that it claims.
    pub values: Vec<Ratio>,
    /// The states that it visits, the start first, with its memory and the choices that it takes there. The number of the
    /// state in [`Node`] is not known.
    pub nodes: Vec<(State, Node)>,
}

/// A fraction. It is a number in JSON if it is one of at most 17 digits, else a text such as `"1/3"`; both are read exactly.
struct Fraction(Ratio);

impl Serialize for Fraction {
    fn serialize<S: Serializer>(&self, to: S) -> std::result::Result<S::Ok, S::Error> {
        match self.0.to_f64().filter(|&x| shortest(x).as_ref() == Some(&self.0)) {
            Some(x) => x.serialize(to),
            None => to.collect_str(&self.0),
        }
    }
}

impl<'de> Deserialize<'de> for Fraction {
    fn deserialize<D: Deserializer<'de>>(from: D) -> std::result::Result<Self, D::Error> {
        let raw = Box::<RawValue>::deserialize(from)?;
        let found = match serde_json::from_str::<String>(raw.get()) {
            Ok(text) => decimal::read(&text),
            Err(_) => decimal::decimal(raw.get()).ok(),
        };
        let wrong = || D::Error::custom("expected a decimal number, or a fraction such as \"1/3\"");
        found.map(Fraction).ok_or_else(wrong)
    }
}

#[derive(Serialize, Deserialize)]
struct File {
    property: String,
    strategies: Vec<StrategyEntry>,
}

#[derive(Serialize, Deserialize)]
struct StrategyEntry {
    share: Option<Fraction>,
    values: Vec<Fraction>,
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
pub fn json(property: &str, mix: &Mix, program: &Program) -> Result<String> {
    let strategy = |own: &MixedStrategy| {
        let nodes = own.nodes.iter().map(|(state, node)| entry(program, state, node));
        Ok(StrategyEntry {
            share: own.share.clone().map(Fraction),
            values: own.values.iter().zip(&mix.great).map(|(x, great)| Fraction(short(x, *great))).collect(),
            nodes: nodes.collect::<Result<_>>()?,
        })
    };
    let strategies = mix.strategies.iter().map(strategy).collect::<Result<_>>()?;
    let text = serde_json::to_string_pretty(&File { property: property.to_owned(), strategies });
    text.map_err(|e| Error::Usage(e.to_string()))
}

/// Returns a short decimal next to a value: not above one that is to be great, not below one that is to be small.
fn short(value: &Ratio, is_great: bool) -> Ratio {
    // Rounding outwards may lead below 0, where no probability and no reward is.
    let mut near = number(value).max(0.0);
    loop {
        match shortest(near) {
            Some(x) if near == 0.0 || if is_great { x <= *value } else { x >= *value } => return x,
            None => return value.clone(),
            Some(_) => near = if is_great { near.next_down() } else { near.next_up() },
        }
    }
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
        state: Valuation::new(program, state),
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
    check_shares(&file.strategies).map_err(wrong)?;
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
            let wrong = |message| wrong(format!("strategy {number}: in `{}`, {message}", node.state));
            let decided = bits(&node.decided).map_err(wrong)?;
            let choices = taken(program, &state, node.actions).map_err(wrong)?;
            nodes.push((state, Node { state: 0, decided, steps: node.steps, choices }));
        }
        let values = own.values.into_iter().map(|value| value.0).collect();
        strategies.push(ReadStrategy { share: own.share.map(|share| share.0), values, nodes });
    }
    Ok((file.property, strategies))
}

/// Checks that the shares are probabilities that sum to 1, or absent, as in a front.
fn check_shares(strategies: &[StrategyEntry]) -> std::result::Result<(), String> {
    let shares: Vec<&Ratio> = strategies.iter().flat_map(|own| &own.share).map(|share| &share.0).collect();
    if shares.is_empty() && !strategies.is_empty() {
        return Ok(());
    }
    let sum: Ratio = shares.iter().copied().sum();
    if shares.len() == strategies.len() && sum.is_one() && !shares.iter().any(|share| share.is_negative()) {
        return Ok(());
    }
    let sum = decimal::plain(&sum);
    Err(format!(
        "the shares of the strategies are probabilities that sum to 1: here the sum is {sum}; write thirds as \"1/3\""
    ))
}

/// Returns the set of some objectives as bits.
fn bits(decided: &[u32]) -> std::result::Result<u32, String> {
    let is_set = decided.is_sorted_by(|a, b| a < b) && decided.iter().all(|&at| at < u32::BITS);
    let message = || "`decided` is not a list of objectives in ascending order".to_owned();
    is_set.then(|| decided.iter().fold(0, |bits, at| bits | 1 << at)).ok_or_else(message)
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
