//! The answers to questions, as plain data.

use schemars::JsonSchema;
use serde::Serialize;

use crate::answer::Answer;
use crate::number::Number;
use meliora_engine::regions::Regions;
use meliora_model::valuation::Valuation;
pub use meliora_planning::result::Share;
use meliora_planning::result::{Escape, ModelCounts};
use meliora_quantities::state_values::Bound;

/// The answers to questions about a model, as far as they are known.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
pub struct Answers {
    /// The sizes of the model; `null` if unknown.
    pub counts: Option<ModelCounts>,
    /// The states that decide the question are not left (`--stop-at-target`): all counts are those of the
    /// part explored; absent otherwise.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub stops_at_target: bool,
    /// A property, or an operator of one, was decided over all combinations of values, before the reachable states
    /// were known: the sizes of its regions are `null`, and so is `counts` unless another one needs all states; absent
    /// otherwise.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub over_all_valuations: bool,
    /// A property, or an operator of one, was decided by a guided search, before the reachable states were known: the
    /// sizes of its regions are `null`, and so is `counts` unless another one needs all states; absent otherwise.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub by_guided_search: bool,
    /// An initial state from which no strategy keeps `--require`: no property holds, and no quantity
    /// has a value; absent without such a state.
    #[serde(rename = "unsafe", skip_serializing_if = "Option::is_none")]
    pub escape: Option<Escape>,
    /// The fields of one question; absent with several properties.
    #[serde(flatten)]
    pub one: Option<OneQuestion>,
    /// The questions in their order: the properties, or the target.
    pub properties: Vec<PropertyAnswer>,
}

/// The fields of a run with one question, a target or a property.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
pub struct OneQuestion {
    /// The number of target states; absent with several properties, `null` if unknown or not a
    /// reachability question.
    pub target: Option<Number>,
    /// The sizes of the regions; `None` if unknown, or not needed by the property.
    #[serde(flatten)]
    pub sizes: Sizes,
    /// The share of the initial states in each region; absent with several properties.
    pub initial: Regions<Option<Share>>,
    /// The property holds in all initial states; absent with `--target`, with several properties, or
    /// if unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub holds: Option<bool>,
    /// The plans for the target; absent without `--strong` and `--policy`, if the question is not the goal
    /// of a planning problem.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plan: Option<Plan>,
    /// True for a target, which has no verdict.
    #[serde(skip)]
    pub is_target: bool,
}

/// Plans for a target, as planners ask for them.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
#[schemars(inline)]
pub struct Plan {
    /// A strong cyclic plan exists from all initial states: it reaches the target almost surely if every
    /// outcome of an action has a positive probability; `null` if unknown.
    pub strong_cyclic: Option<bool>,
    /// A strong plan exists from all initial states: every path reaches the target within a bound; `null`
    /// without `--strong`, or if unknown.
    pub strong: Option<bool>,
    /// The number of states with a strong plan; `null` without `--strong`, or if unknown.
    pub strong_states: Option<Number>,
    /// The number of states outside the target that the policy of `--policy` visits; `null` without it, and if
    /// no plan exists.
    pub policy_states: Option<Number>,
}

/// The numbers of states of the four regions; `None` while a region is not known.
pub type Sizes = Regions<Option<Number>>;

/// A property with its answer, or the reason for no answer.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PropertyAnswer {
    /// Its name in the file; `null` without a name.
    pub name: Option<String>,
    /// Its text.
    pub property: String,
    /// It holds in all initial states; `null` if not answered.
    pub holds: Option<bool>,
    /// The probability or the expected reward over the initial states: in each of them, the value lies
    /// between these bounds; for the filter `min` or `max` of a JANI model, bounds of the least or the
    /// greatest of them; `null` if an initial state is unsafe, absent if not asked for, or unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("nullable" = true))]
    pub value: Option<Option<Bound>>,
    /// The values of the states that the filter of the property lists; absent without such a filter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub values: Option<Vec<ListedState>>,
    /// Points of the Pareto front of several objectives, each with their values: one strategy attains them, and
    /// no strategy attains values that are better than the means of points by more than the precision; absent
    /// for other properties.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub front: Option<Vec<Vec<f64>>>,
    /// A strong cyclic plan exists for the goal of the planning problem, about which the property asks; absent if
    /// it is about something else, and with one question, which has `plan`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strong_cyclic: Option<bool>,
    /// The sizes of its regions.
    #[serde(flatten)]
    pub sizes: Sizes,
    /// The reason for no answer, or for no value; absent if there are both.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// The line of the file of properties, or of the JANI model, that the reason is about, from 1; absent
    /// if it is about no place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line: Option<usize>,
    /// The column, from 1; absent if `line` is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<usize>,
}

/// The value of a property in a state.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ListedState {
    /// The values of its variables.
    pub state: Valuation,
    /// True if the condition holds there; absent for a number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub holds: Option<bool>,
    /// The number; absent for a condition.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<Bound>,
}

impl PropertyAnswer {
    /// Creates a property without an answer; `reason` says why it will have none.
    pub fn open(name: Option<String>, property: String, reason: Option<String>) -> Self {
        PropertyAnswer {
            name,
            property,
            holds: None,
            value: None,
            values: None,
            front: None,
            strong_cyclic: None,
            sizes: Sizes::default(),
            reason,
            line: None,
            column: None,
        }
    }

    /// Adds the place of the reason, a line and a column.
    #[must_use]
    pub fn at(mut self, place: Option<(usize, usize)>) -> Self {
        (self.line, self.column) = place.unzip();
        self
    }

    /// Takes the answer to the same property.
    pub fn take(&mut self, other: PropertyAnswer) {
        let (name, property) = (self.name.take(), std::mem::take(&mut self.property));
        *self = PropertyAnswer { name, property, ..other };
    }

    /// Adds the answer; so far, it may be incomplete.
    pub fn answer(&mut self, answer: &Answer) {
        self.holds = answer.holds;
        self.value = answer.value.clone().map(Some).or(answer.no_value.as_ref().map(|_| None));
        self.reason = answer.no_value.clone();
    }

    /// Returns whether there is neither an answer nor a reason for none: a limit was hit.
    pub fn is_open(&self) -> bool {
        self.holds.is_none() && self.value.is_none() && self.front.is_none() && self.reason.is_none()
    }
}

impl Answers {
    /// Adds the answer to a question; so far, it may be incomplete.
    pub fn answer(&mut self, position: usize, answer: &Answer) {
        self.properties[position].answer(answer);
        if let Some(one) = &mut self.one {
            one.holds = answer.holds;
        }
    }
}
