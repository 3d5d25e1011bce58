//! Shields by value: each action has the probability of a formula after it, and a threshold says which are permitted.
//!
//! The *safety* of an action with the value v is v for `Pmax`, and 1 - v for `Pmin`: the formula is then a bad event. With
//! the threshold x, the actions of a state with a safety of at least x are permitted; with a relative one, those of at least
//! x times the best safety in the state. If there is none, those with the best safety are.

use serde::{Deserialize, Serialize};

use super::fault::{Check, in_range};
use super::{Shield, ShieldAction, ShieldNode, ShieldVariable};
use meliora_base::error::ensure;
use meliora_base::interval::Interval;
use meliora_model::Program;

/// The kind of shields by value.
pub const SAFETY: &str = "safety";

/// The rule of a shield by value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ValueRule {
    /// The property whose values are listed.
    pub property: String,
    /// True for `Pmax`: values are to be great; false for `Pmin`.
    pub maximises: bool,
    /// The least safety of a permitted action.
    pub threshold: f64,
    /// True if the threshold is a factor of the best safety of the state.
    pub relative: bool,
    /// The number of steps that the property looks ahead, if it is bounded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub horizon: Option<u64>,
}

/// Bounds of a value, or of a safety.
type Range = [f64; 2];

impl ValueRule {
    /// Returns the safety of a value.
    fn safety(&self, [low, high]: Range) -> Range {
        let rest = Interval { lower: low, upper: high }.complement();
        if self.maximises { [low, high] } else { [rest.lower, rest.upper] }
    }

    /// Returns the least safety of a permitted action of a state with this best safety. The number in a file is rounded.
    fn least(&self, best: Range) -> Range {
        let [low, high] = if self.relative { best.map(|x| x * self.threshold) } else { [self.threshold; 2] };
        [low.next_down().next_down(), high.next_up().next_up()]
    }
}

impl ShieldNode {
    /// Returns the safety of each action.
    fn safeties(&self, rule: &ValueRule) -> Vec<Range> {
        self.actions.iter().map(|action| rule.safety(action.value.unwrap_or([0.0, 1.0]))).collect()
    }
}

/// Returns the bounds of the greatest number, or of the least.
fn extreme(all: &[Range], greatest: bool) -> Range {
    let of = |at: usize| {
        let numbers = all.iter().map(|range| range[at]);
        if greatest { numbers.fold(0.0, f64::max) } else { numbers.fold(1.0, f64::min) }
    };
    [of(0), of(1)]
}

impl Shield {
    /// Checks the promises about values: the permitted actions are those of the rule, and the value of an action lies
    /// between those of the states that it may enter.
    pub(super) fn check_values(&self, rule: &ValueRule) -> Check {
        let range = 0.0..=1.0;
        ensure(range.contains(&rule.threshold), || "the threshold is not between 0 and 1".to_owned())?;
        self.each(Self::check_value)?;
        let values: Vec<Range> =
            self.nodes.iter().map(|node| extreme(&node.safeties(rule), !node.theirs)).collect();
        self.each(|shield, v| shield.check_permitted(rule, v))?;
        self.each(|shield, v| match rule.horizon {
            // The values of the states that are entered look one step further.
            Some(_) => Ok(()),
            None => shield.check_mean(rule, v, &values),
        })
    }

    /// Checks the form of the values of a node.
    fn check_value(&self, v: usize) -> Check {
        let node = &self.nodes[v];
        let is_plain = node.class == Some(0) && node.reference == 0 && node.ahead == Some(0);
        ensure(is_plain && node.pursues.is_empty() && !node.achieved, || {
            "improvements or objectives are promised, in a shield by value".to_owned()
        })?;
        let is_wrong = |action: &&ShieldAction| {
            !action.value.is_some_and(|[low, high]| 0.0 <= low && low <= high && high <= 1.0)
        };
        node.actions.iter().find(is_wrong).map_or(Ok(()), |action| {
            Err(format!("the action `{}` has no value between 0 and 1", self.name(action)))
        })
    }

    /// Checks that the permitted actions are those of the rule.
    fn check_permitted(&self, rule: &ValueRule, v: usize) -> Check {
        let node = &self.nodes[v];
        let all = node.safeties(rule);
        let best = extreme(&all, true);
        let of_node = if node.theirs { extreme(&all, false) } else { best };
        let least = rule.least(best);
        let [is_above, is_below] = [of_node[0] > least[1], of_node[1] < least[0]];
        ensure(!(node.secure && is_below && !(node.theirs && rule.relative)), || {
            "the permitted actions are said to reach the threshold, and do not".to_owned()
        })?;
        ensure(node.secure || !is_above, || {
            "the permitted actions are said to miss the threshold, and reach it".to_owned()
        })?;
        if node.theirs {
            return Ok(());
        }
        in_range("pick", node.pick, all.len())?;
        ensure(all[node.pick][1] >= best[0], || {
            "another action is better than the one that is picked".to_owned()
        })?;
        for (action, [low, high]) in node.actions.iter().zip(all) {
            let may_be_best = high >= best[0];
            let wrong = match action.permitted {
                true => high < least[0] && (node.secure || !may_be_best),
                false => low > least[1],
            };
            ensure(!wrong, || {
                let is = if action.permitted { "permitted" } else { "forbidden" };
                format!("the action `{}` is {is} against the threshold", self.name(action))
            })?;
        }
        Ok(())
    }

    /// Checks that the value of each action is a mean of those of the states that it may enter.
    fn check_mean(&self, rule: &ValueRule, v: usize, values: &[Range]) -> Check {
        let node = &self.nodes[v];
        if node.decided {
            let all = node.safeties(rule);
            let is_known = all.iter().all(|range| *range == all[0] && (range[0] == range[1]));
            return ensure(is_known && (all[0][0] == 0.0 || all[0][0] == 1.0), || {
                "the formula is said to be decided, and is neither sure nor impossible".to_owned()
            });
        }
        for (action, [low, high]) in node.actions.iter().zip(node.safeties(rule)) {
            let next: Vec<Range> = action.next.iter().map(|&to| values[to]).collect();
            let (least, greatest) = (extreme(&next, false)[0], extreme(&next, true)[1]);
            ensure(high >= least.next_down() && low <= greatest.next_up(), || {
                let name = self.name(action);
                format!("the value of `{name}` does not lie between those of its successors")
            })?;
        }
        Ok(())
    }
}

impl Shield {
    /// Returns the action labels of a program, without those that only monitors have.
    pub fn labels(program: &Program) -> Vec<String> {
        super::labels(program)
    }
}

impl ShieldVariable {
    /// Returns the variables of a program, those of monitors included.
    pub fn all(program: &Program) -> Vec<Self> {
        super::variables(program)
    }
}
