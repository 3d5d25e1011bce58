//! Strategies of properties, as JSON. Of several for several objectives at once, one is drawn at the start, and followed.

use std::sync::Arc;

use meliora_base::decimal;
use meliora_base::error::{Diagnostic, Error, Result, SourceFile};
use meliora_base::exact::Ratio;
use meliora_base::exact::shortest;
use meliora_equations::several::{Node, Taking};
use meliora_model::valuation::Valuation;
use meliora_model::{Program, State};
use meliora_question::evaluate::{Mix, MixedStrategy};
use num_traits::{One, Signed, ToPrimitive};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::value::RawValue;

use super::node_lines::{Names, Source};
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

/// The word for a value without a bound.
const INFINITE: &str = "infinity";

/// A value: a fraction or, for `None`, infinity.
pub(super) struct Claim(pub(super) Option<Ratio>);

impl Serialize for Claim {
    fn serialize<S: Serializer>(&self, to: S) -> std::result::Result<S::Ok, S::Error> {
        match &self.0 {
            Some(x) => Fraction(x.clone()).serialize(to),
            None => INFINITE.serialize(to),
        }
    }
}

impl<'de> Deserialize<'de> for Claim {
    fn deserialize<D: Deserializer<'de>>(from: D) -> std::result::Result<Self, D::Error> {
        let raw = Box::<RawValue>::deserialize(from)?;
        if serde_json::from_str::<String>(raw.get()).is_ok_and(|text| text == INFINITE) {
            return Ok(Claim(None));
        }
        serde_json::from_str::<Fraction>(raw.get()).map(|x| Claim(Some(x.0))).map_err(D::Error::custom)
    }
}

/// A fraction. It is a number in JSON if it is one of at most 17 digits, else a text such as `"1/3"`; both are read exactly.
pub(super) struct Fraction(pub(super) Ratio);

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

/// A file of strategies.
#[derive(Serialize, Deserialize)]
pub struct File {
    /// The property.
    pub property: String,
    /// The side whose strategy it is; absent for ours.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) side: Option<Side>,
    pub(super) strategies: Vec<StrategyEntry>,
}

/// The other side of a game.
#[derive(Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Side {
    Opponent,
}

#[derive(Serialize, Deserialize)]
pub(super) struct StrategyEntry {
    pub(super) share: Option<Fraction>,
    pub(super) values: Vec<Claim>,
    /// The number of nodes in which paths may start, the first ones; absent for one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) starts: Option<usize>,
    pub(super) nodes: Vec<NodeEntry>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct NodeEntry {
    pub(super) state: Valuation,
    /// The states of the monitors of the formula.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) memory: Option<Valuation>,
    /// The positions of the objectives that the path has decided; absent for one operator.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) decided: Option<Vec<u32>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) steps: Option<u32>,
    /// The number of the set that is visited next; absent for the first one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) round: Option<u32>,
    /// True if the other side chooses: all of its choices are listed.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub(super) other: bool,
    /// The actions, each of which is taken with the same probability.
    pub(super) actions: Vec<ActionEntry>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct ActionEntry {
    pub(super) action: String,
    /// The position among the choices of the state.
    pub(super) position: usize,
    pub(super) successors: Vec<SuccessorEntry>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct SuccessorEntry {
    pub(super) node: usize,
    pub(super) probability: f64,
}

/// Returns the strategies of a property as an object in JSON.
///
/// # Errors
/// A command has no meaning in some state.
pub fn json(property: &str, mix: &Mix, program: &Program) -> Result<String> {
    let source = Source::new(program)?;
    let mut names = source.names();
    let strategy = |own: &MixedStrategy| {
        let nodes = own.nodes.iter().map(|(state, node)| entry(program, &mut names, state, node));
        Ok(StrategyEntry {
            share: own.share.clone().map(Fraction),
            values: own
                .values
                .iter()
                .zip(&mix.great)
                .map(|(x, great)| Claim(Some(short(x, *great))))
                .collect(),
            starts: None,
            nodes: nodes.collect::<Result<_>>()?,
        })
    };
    let strategies = mix.strategies.iter().map(strategy).collect::<Result<_>>()?;
    let text = serde_json::to_string_pretty(&File { property: property.to_owned(), side: None, strategies });
    text.map_err(|e| Error::Usage(e.to_string()))
}

/// Returns a short decimal next to a value: not above one that is to be great, not below one that is to be small.
pub(super) fn short(value: &Ratio, is_great: bool) -> Ratio {
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

pub(super) fn number(x: &Ratio) -> f64 {
    x.to_f64().unwrap_or(f64::NAN)
}

fn entry(program: &Program, names: &mut Names<'_>, state: &State, node: &Node) -> Result<NodeEntry> {
    Ok(NodeEntry {
        state: Valuation::new(program, state),
        memory: None,
        decided: Some((0..u32::BITS).filter(|at| node.decided >> at & 1 == 1).collect()),
        steps: Some(node.steps),
        round: None,
        other: false,
        actions: actions(names.of(0, state)?, &node.choices),
    })
}

/// Returns the actions of a node, given the names of the choices of its state.
pub(super) fn actions(names: &[String], choices: &[Taking]) -> Vec<ActionEntry> {
    let action = |taking: &Taking| ActionEntry {
        action: names.get(taking.position).cloned().unwrap_or_default(),
        position: taking.position,
        successors: taking
            .successors
            .iter()
            .map(|(node, p)| SuccessorEntry { node: *node, probability: number(p) })
            .collect(),
    };
    choices.iter().map(action).collect()
}

/// Returns whether a text is that of strategies for several objectives, and not of another policy.
pub fn is_mix(source: &SourceFile) -> bool {
    source.text.trim_start().starts_with('{')
}

impl File {
    /// Reads the text of a file, without the model.
    ///
    /// # Errors
    /// The text is wrong.
    pub fn new(source: &Arc<SourceFile>) -> Result<Self> {
        serde_json::from_str(&source.text).map_err(|error| {
            let wrong = Diagnostic::new(source, place(source, &error), error.to_string());
            wrong.help("expected a file of `reach --policy`").into()
        })
    }

    /// Returns the strategies for several objectives.
    ///
    /// # Errors
    /// A state or an action is none of the model; the shares do not sum to 1.
    pub fn mix(self, source: &Arc<SourceFile>, program: &Program) -> Result<Vec<ReadStrategy>> {
        let wrong = |message: String| Error::from(Diagnostic::new(source, 0..0, message));
        check_shares(&self.strategies).map_err(wrong)?;
        let mut strategies = Vec::new();
        for (number, own) in (1..).zip(self.strategies) {
            if own.nodes.is_empty() {
                return Err(wrong(format!("strategy {number} visits no state")));
            }
            let mut nodes = Vec::new();
            for node in own.nodes {
                let state = node.state.state(program).ok_or_else(|| {
                    wrong(format!("strategy {number}: `{}` is not a state of the model", node.state))
                })?;
                let wrong = |message| wrong(format!("strategy {number}: in `{}`, {message}", node.state));
                let missing = || wrong("`decided` or `steps` is missing".to_owned());
                let decided = bits(&node.decided.ok_or_else(missing)?).map_err(wrong)?;
                let steps = node.steps.ok_or_else(missing)?;
                let choices = taken(program, &state, &node.actions).map_err(wrong)?;
                nodes.push((state, Node { state: 0, decided, steps, choices }));
            }
            let infinite = || wrong(format!("strategy {number}: a value is not finite"));
            let values = own.values.into_iter().map(|value| value.0.ok_or_else(infinite));
            let values = values.collect::<Result<_>>()?;
            strategies.push(ReadStrategy { share: own.share.map(|share| share.0), values, nodes });
        }
        Ok(strategies)
    }
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
pub(super) fn taken(
    program: &Program,
    state: &State,
    actions: &[ActionEntry],
) -> std::result::Result<Vec<Taking>, String> {
    let names = program.choices(state).unwrap_or_default();
    let mut choices = Vec::new();
    for ActionEntry { action, position, successors } in actions {
        let position = *position;
        if names.get(position).is_none_or(|(_, name)| name != action) {
            return Err(format!("the choice with the position {position} is not `{action}`"));
        }
        let mut after = Vec::new();
        for &SuccessorEntry { node, probability } in successors {
            let p = Ratio::from_float(probability);
            let p = p.ok_or_else(|| format!("`{action}` has an infinite probability"))?;
            after.push((node, Arc::new(p)));
        }
        choices.push(Taking { position, successors: after });
    }
    Ok(choices)
}
