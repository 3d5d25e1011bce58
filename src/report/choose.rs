//! The choice among permitted actions, and the value that it attains.

use schemars::JsonSchema;
use serde::Serialize;

use super::text::plural;
use super::values_text::{amount, digits, number};
use meliora_planning::Sample;
use meliora_planning::estimate::CONFIDENCE;
use meliora_quantities::choose::Attained;
use meliora_quantities::state_values::Bound;
use meliora_quantities::{Choose, Steps};

/// The choice among permitted actions, in the order of the JSON fields.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Choosing {
    /// The choice among permitted actions.
    pub choose: Choose,
    /// The cost of a step: `steps`, or the name of a reward structure; `null` with `first`.
    pub reward: Option<String>,
}

impl Choosing {
    /// Returns the settings for the heading of a report; none for `first`.
    pub(super) fn settings(&self) -> Option<(&'static str, String)> {
        let reward = self.reward.as_ref()?;
        let cost = if reward == Steps::NAME { String::new() } else { format!(" ({reward})") };
        Some(("choose", format!("{}{cost}", self.choose.name())))
    }

    /// Returns the name of the cost.
    pub(super) fn cost(&self) -> &str {
        self.reward.as_deref().unwrap_or(Steps::NAME)
    }
}

/// The value that a strategy attains from a state.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Attains {
    /// The objective that it achieves with this probability; absent unless it does nothing else.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub objective: Option<String>,
    /// The number of improvements that it aims at.
    pub improvements: usize,
    /// The probability of these improvements, or of the objective.
    pub probability: Bound,
    /// The expected cost until the last of them; `null` where the probability is below 1.
    pub cost: Option<Bound>,
}

impl Attains {
    /// Copies a value.
    pub fn new(attained: &Attained) -> Self {
        Attains {
            objective: attained.objective.clone(),
            improvements: attained.improvements,
            probability: Bound::new(&attained.probability, false),
            cost: attained.cost.as_ref().map(|cost| Bound::new(cost, false)),
        }
    }

    /// Returns `2 improvements`, or the name of the objective.
    fn aim(&self) -> String {
        self.objective.clone().unwrap_or_else(|| plural(self.improvements, "improvement"))
    }

    /// Returns `2 improvements with probability 0.25`, or with the expected cost.
    pub(super) fn line(&self, cost_name: &str) -> String {
        let improvements = plural(self.improvements, "improvement");
        let p = number(&self.probability);
        match &self.cost {
            _ if self.objective.is_some() => format!("{} with probability {p}", self.aim()),
            _ if self.improvements == 0 => "no improvement".to_owned(),
            Some(cost) => {
                format!("{improvements} with probability {p}, {} expected", amount(cost, cost_name))
            }
            None => format!("{improvements} with probability {p}"),
        }
    }
}

/// The value of a strategy, computed and measured.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(into = "Compared")]
#[schemars(with = "Compared")]
pub struct Comparison {
    /// The computed value.
    pub value: Attains,
    /// The simulated runs.
    pub sample: Sample,
}

impl Comparison {
    /// Returns whether the confidence intervals and the computed bounds overlap.
    pub(crate) fn agrees(&self) -> bool {
        let overlaps = |computed: &Bound, (lower, upper): (f64, f64)| {
            // A mean of doubles is rounded.
            let slack = 1e-9 * upper.abs().max(1.0);
            computed.lower <= upper + slack && lower - slack <= computed.upper
        };
        let cost = self.value.cost.as_ref().zip(self.sample.cost());
        overlaps(&self.value.probability, self.sample.probability())
            && cost.is_none_or(|(computed, measured)| overlaps(computed, measured))
    }

    /// Renders the computed and the measured numbers.
    pub(super) fn text(&self, cost_name: &str) -> String {
        let (value, sample) = (&self.value, &self.sample);
        if value.improvements == 0 && value.objective.is_none() {
            return String::new();
        }
        let percent = 100.0 * CONFIDENCE;
        let interval = |(lower, upper): (f64, f64)| {
            format!("{percent} % interval {} to {}", digits(lower), digits(upper))
        };
        let mut out = format!(
            "  Probability of {}: {} computed,\n    {} measured ({}).\n",
            value.aim(),
            number(&value.probability),
            digits(sample.share()),
            interval(sample.probability()),
        );
        if let (Some(computed), Some(measured)) = (&value.cost, sample.cost()) {
            let (computed, mean) = (number(computed), digits(sample.mean_cost));
            out += &format!(
                "  Expected {cost_name}: {computed} computed,\n    {mean} measured ({}).\n",
                interval(measured)
            );
        }
        if !self.agrees() {
            out += "  The computed value is outside of the interval.\n";
        }
        out
    }
}

/// The value of a strategy in JSON.
#[derive(Serialize, JsonSchema)]
struct Compared {
    /// The computed value.
    #[serde(flatten)]
    value: Attains,
    /// The confidence of the intervals.
    confidence: f64,
    /// The share of the paths with these improvements.
    measured_probability: f64,
    /// The confidence interval (Wilson); open paths count as failures in `lower`, as successes in
    /// `upper`.
    probability_interval: Bound,
    /// The mean cost until the last of these improvements; `null` without `cost`, for fewer than 10
    /// paths, or if a path did not make them.
    measured_cost: Option<f64>,
    /// The confidence interval (Student); `null` as `measured_cost`.
    cost_interval: Option<Bound>,
    /// The paths that were given up, and could still have made these improvements.
    open: u64,
    /// The computed bounds and the intervals overlap.
    agrees: bool,
}

impl From<Comparison> for Compared {
    fn from(of: Comparison) -> Self {
        let bound = |(lower, upper)| Bound { lower, upper, exact: None };
        let (agrees, sample) = (of.agrees(), of.sample);
        let cost = sample.cost().filter(|_| of.value.cost.is_some());
        Compared {
            value: of.value,
            confidence: CONFIDENCE,
            measured_probability: sample.share(),
            probability_interval: bound(sample.probability()),
            measured_cost: cost.map(|_| sample.mean_cost),
            cost_interval: cost.map(bound),
            open: sample.open,
            agrees,
        }
    }
}
