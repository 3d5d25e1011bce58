//! The choice among permitted actions, and the value that it attains.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use super::text::plural;
use super::values_text::{amount, digits, number};
use meliora_planning::Sample;
use meliora_planning::estimate::CONFIDENCE;
use meliora_quantities::choose::Attained;
use meliora_quantities::state_values::Bound;
use meliora_quantities::{Choose, Steps};

/// The choice among permitted actions, in the order of the JSON fields.
#[derive(Debug, Clone, Serialize)]
pub struct Choosing {
    /// `first`, `likely` or `cheap`.
    pub choose: Choose,
    /// The name of the cost: `steps`, or that of a reward structure; `None` for `first`.
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
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Attains {
    /// The number of improvements that it aims at.
    pub improvements: usize,
    /// Their probability.
    pub probability: Bound,
    /// The expected cost until the last of them, if they are certain.
    pub cost: Option<Bound>,
}

impl Attains {
    /// Copies a value.
    pub fn new(attained: &Attained) -> Self {
        Attains {
            improvements: attained.improvements,
            probability: Bound::new(&attained.probability, false),
            cost: attained.cost.as_ref().map(|cost| Bound::new(cost, false)),
        }
    }

    /// Returns `2 improvements with probability 0.25`, or with the expected cost.
    pub(super) fn line(&self, cost_name: &str) -> String {
        let improvements = plural(self.improvements, "improvement");
        let p = number(&self.probability);
        match &self.cost {
            _ if self.improvements == 0 => "no improvement".to_owned(),
            Some(cost) => {
                format!("{improvements} with probability {p}, {} expected", amount(cost, cost_name))
            }
            None => format!("{improvements} with probability {p}"),
        }
    }
}

/// The value of a strategy, computed and measured.
#[derive(Debug, Clone, PartialEq)]
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
        if value.improvements == 0 {
            return String::new();
        }
        let percent = 100.0 * CONFIDENCE;
        let interval = |(lower, upper): (f64, f64)| {
            format!("{percent} % interval {} to {}", digits(lower), digits(upper))
        };
        let mut out = format!(
            "  Probability of {}: {} computed,\n    {} measured ({}).\n",
            plural(value.improvements, "improvement"),
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

/// The computed value, then `measured` with estimates and intervals.
impl Serialize for Comparison {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let bound = |(lower, upper)| Bound { lower, upper, exact: None };
        let (value, sample) = (&self.value, &self.sample);
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("improvements", &value.improvements)?;
        map.serialize_entry("probability", &value.probability)?;
        map.serialize_entry("cost", &value.cost)?;
        map.serialize_entry("confidence", &CONFIDENCE)?;
        map.serialize_entry("measured_probability", &sample.share())?;
        map.serialize_entry("probability_interval", &bound(sample.probability()))?;
        let cost = sample.cost().filter(|_| value.cost.is_some());
        map.serialize_entry("measured_cost", &cost.map(|_| sample.mean_cost))?;
        map.serialize_entry("cost_interval", &cost.map(bound))?;
        map.serialize_entry("open", &sample.open)?;
        map.serialize_entry("agrees", &self.agrees())?;
        map.end()
    }
}
