//! The report of `meliora values`.

use schemars::JsonSchema;
use serde::Serialize;

use super::envelope::Envelope;
use super::header::Header;
use super::ranks;
use meliora_model::Program;
use meliora_planning::result::ModelCounts;
use meliora_quantities::state_values::{Bound, StateValues};

/// The results of `values`, in the order of the JSON fields.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[schemars(rename = "values")]
pub struct ValuesFindings {
    /// The sizes of the model; `null` if unknown.
    pub counts: Option<ModelCounts>,
    /// The cost of a step: `steps`, or the name of a reward structure.
    pub reward: String,
    /// The largest width of the bounds.
    pub precision: f64,
    /// The states; empty before the levels are known.
    pub states: Vec<StateValues>,
    /// The number of states that only a file lists.
    #[serde(skip)]
    pub more: usize,
}

/// The report with times and memory.
pub type ValuesReport = Envelope<ValuesFindings>;

impl ValuesReport {
    /// Creates a report without results.
    pub fn of_cost(header: Header, reward: &str, precision: f64) -> Self {
        let findings = ValuesFindings {
            counts: None,
            reward: reward.to_owned(),
            precision,
            states: Vec::new(),
            more: 0,
        };
        Envelope::with(header, findings)
    }
}

/// Returns the heading of [`rows`]; `required` says whether there are requirements.
pub fn heading(program: &Program, required: bool) -> impl Iterator<Item = &str> {
    let columns = [
        "most_preferred",
        "sasi_rank",
        "spi_rank",
        "improvements",
        "action",
        "probability_lower",
        "probability_upper",
        "cost_lower",
        "cost_upper",
    ];
    let last = required.then_some("unsafe");
    program.variables.iter().map(|v| v.name.as_str()).chain(columns).chain(last)
}

/// Returns the cells of all lines about the state: one for each number of improvements and action.
/// A line without an action has the values of the state. An unsafe state has one line without values.
/// `required` says whether there are requirements.
pub fn rows(of: &StateValues, required: bool) -> Vec<Vec<String>> {
    let mut first: Vec<String> = of.state.cells().collect();
    first.push(of.most_preferred.join("+"));
    first.extend([of.sasi_rank, of.spi_rank].map(ranks::cell));
    let mut rows = Vec::new();
    for level in &of.levels {
        let own = ("", &level.probability, &level.cost);
        let actions = level.actions.iter().map(|a| (a.action.as_str(), &a.probability, &a.cost));
        for (action, probability, cost) in std::iter::once(own).chain(actions) {
            let mut cells = first.clone();
            cells.extend([level.improvements.to_string(), action.to_owned()]);
            cells.extend([probability.lower, probability.upper].map(|x| x.to_string()));
            let cost = |x: fn(&Bound) -> f64| cost.as_ref().map_or(String::new(), |c| x(c).to_string());
            cells.extend([cost(|c| c.lower), cost(|c| c.upper)]);
            rows.push(cells);
        }
    }
    if of.is_unsafe {
        first.extend(std::iter::repeat_n(String::new(), 6));
        rows.push(first);
    }
    if required {
        rows.iter_mut().for_each(|cells| cells.push(of.is_unsafe.to_string()));
    }
    rows
}
