//! The report of `meliora values`.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use serde_json::Value as Json;

use super::envelope::Envelope;
use super::header::Header;
use super::ranks;
use crate::engine::explicit::weighted::Walker;
use crate::engine::{Engine, NoProgress};
use crate::error::Result;
use crate::model::valuation::Valuation;
use crate::model::{Program, State};
use crate::planning::result::ModelCounts;
use crate::planning::{Analysis, Kind, Rank};
use crate::quantities::{Aim, Bounds, ChoiceValues, Node, Values};

/// The results of `values`, in the order of the JSON fields.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct ValuesFindings {
    /// Sizes of the model.
    pub counts: Option<ModelCounts>,
    /// The name of the cost: `steps`, or that of a reward structure.
    pub reward: String,
    /// The largest width of a result.
    pub precision: f64,
    /// The states.
    pub states: Vec<StateValues>,
    /// The number of states that only a file lists.
    #[serde(skip)]
    pub more: usize,
}

/// The report with times and memory.
pub(crate) type ValuesReport = Envelope<ValuesFindings>;

/// The values of a state.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StateValues {
    /// Its values by variable.
    pub state: Valuation,
    /// True if no strategy keeps the requirements from it.
    #[serde(rename = "unsafe", skip_serializing_if = "std::ops::Not::not")]
    pub is_unsafe: bool,
    /// The most preferred objectives that are certain there.
    pub most_preferred: Vec<String>,
    /// Number of improvements that are certain (SASI rank).
    pub sasi_rank: Rank,
    /// Number of improvements that are possible (SPI rank).
    pub spi_rank: Rank,
    /// The values for 1, 2, … improvements; none for an unsafe state.
    pub levels: Vec<LevelValues>,
    /// The largest expected number of improvements; `None` for an unsafe state.
    pub number: Option<Bound>,
    /// The greatest probability of an improvement within 0, 1, 2, … steps.
    pub within: Option<Vec<f64>>,
}

/// The values of a state for one number of improvements.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LevelValues {
    /// The number of improvements.
    pub improvements: usize,
    /// The greatest probability of these improvements.
    pub probability: Bound,
    /// The least expected cost until the last of them, where they are certain.
    pub cost: Option<Bound>,
    /// The kept actions, best first.
    pub actions: Vec<ActionValues>,
    /// The greatest probability of these improvements within 0, 1, 2, … steps.
    pub within: Option<Vec<f64>>,
}

/// The values of an action for one number of improvements.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ActionValues {
    /// Its name.
    pub action: String,
    /// The greatest probability of the improvements after this action.
    pub probability: Bound,
    /// The least expected cost after this action, if the improvements stay certain.
    pub cost: Option<Bound>,
}

/// Bounds of a number.
#[derive(Debug, Clone, PartialEq)]
pub struct Bound {
    /// The lower bound.
    pub lower: f64,
    /// The upper bound; may be infinite.
    pub upper: f64,
    /// The fraction, if fractions were asked for.
    pub exact: Option<String>,
}

impl Bound {
    /// Copies bounds; `exact` says whether fractions were asked for.
    pub(crate) fn new(bounds: &Bounds, exact: bool) -> Self {
        let fraction = bounds.exact.as_ref().filter(|_| exact).map(ToString::to_string);
        Bound { lower: bounds.interval.lower, upper: bounds.interval.upper, exact: fraction }
    }

    /// Returns the width, divided by the value where that is above 1.
    pub(crate) fn width(&self) -> f64 {
        if self.lower == self.upper { 0.0 } else { (self.upper - self.lower) / self.lower.max(1.0) }
    }
}

/// An object with `lower`, `upper` and perhaps `exact`; infinity is `"inf"`.
impl Serialize for Bound {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for (name, x) in [("lower", self.lower), ("upper", self.upper)] {
            match x.is_finite() {
                true => map.serialize_entry(name, &x)?,
                false => map.serialize_entry(name, "inf")?,
            }
        }
        if let Some(exact) = &self.exact {
            map.serialize_entry("exact", exact)?;
        }
        map.end()
    }
}

impl ValuesReport {
    /// Creates a report without results.
    pub(crate) fn of_cost(header: Header, reward: &str, precision: f64) -> Self {
        let findings = ValuesFindings {
            counts: None,
            reward: reward.to_owned(),
            precision,
            states: Vec::new(),
            more: 0,
        };
        Envelope::of(header, findings)
    }
}

/// A bound that is wider than others.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Width {
    /// The width, divided by the value where that is above 1.
    pub width: f64,
    /// The quantity that is bounded.
    quantity: Option<(char, usize)>,
}

impl Width {
    /// Returns the wider one of two bounds.
    pub(crate) fn or(self, other: Width) -> Width {
        if other.width > self.width { other } else { self }
    }

    /// Returns the name of the quantity: `P_k`, `C_k` or `N`.
    pub(crate) fn quantity(&self) -> String {
        self.quantity.map_or_else(|| "N".to_owned(), |(letter, k)| format!("{letter}_{k}"))
    }
}

/// Returns the heading of [`StateValues::rows`]; `required` says whether there are requirements.
pub(crate) fn heading(program: &Program, required: bool) -> impl Iterator<Item = &str> {
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

/// Formats a value of a variable without quotes.
fn plain(value: &Json) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

impl StateValues {
    /// Returns the widest bound of the state.
    pub(crate) fn widest(&self) -> Width {
        let wide = |bound: &Bound, quantity| Width { width: bound.width(), quantity };
        let number = self.number.as_ref().map_or_else(Width::default, |number| wide(number, None));
        self.levels.iter().fold(number, |widest, level| {
            let k = level.improvements;
            let cost = level.cost.as_ref().map_or(widest, |cost| widest.or(wide(cost, Some(('C', k)))));
            cost.or(wide(&level.probability, Some(('P', k))))
        })
    }

    /// Returns the cells of all lines about the state: one for each number of improvements and action.
    /// A line without an action has the values of the state. An unsafe state has one line without
    /// values. `required` says whether there are requirements.
    pub(crate) fn rows(&self, required: bool) -> Vec<Vec<String>> {
        let mut first: Vec<String> = self.state.values().map(plain).collect();
        first.push(self.most_preferred.join("+"));
        first.extend([self.sasi_rank, self.spi_rank].map(ranks::cell));
        let mut rows = Vec::new();
        for level in &self.levels {
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
        if self.is_unsafe {
            first.extend(std::iter::repeat_n(String::new(), 6));
            rows.push(first);
        }
        if required {
            rows.iter_mut().for_each(|cells| cells.push(self.is_unsafe.to_string()));
        }
        rows
    }

    /// Collects the values of some states of the scope, except for those that were not reached before
    /// a limit. Unsafe states are listed without values.
    ///
    /// # Errors
    /// A command has no meaning in a state.
    pub(crate) fn all<E: Engine>(
        analysis: &Analysis<E>,
        program: &Program,
        values: &Values,
        states: &[State],
    ) -> Result<Vec<Self>> {
        let mut found = Vec::with_capacity(states.len());
        StateValues::each(analysis, program, values, states, &mut |state| found.push(state))?;
        Ok(found)
    }

    /// Calls `each` with the values of some states, one after the other; see [`StateValues::all`].
    ///
    /// # Errors
    /// A command has no meaning in a state.
    pub(crate) fn each<E: Engine>(
        analysis: &Analysis<E>,
        program: &Program,
        values: &Values,
        states: &[State],
        each: &mut dyn FnMut(Self),
    ) -> Result<()> {
        let mut walker = Walker::new(program, &NoProgress)?;
        let codec = walker.codec().clone();
        let mut walk = walker.walk();
        for state in states {
            if analysis.is_unsafe(state)? {
                each(StateValues::without(analysis, program, state)?);
            } else if let (Some(node), Some(code)) = (values.start(state), codec.encode(state)) {
                each(StateValues::at(analysis, program, (values, node), state, &walk.names(&code)?)?);
            }
        }
        Ok(())
    }

    fn at<E: Engine>(
        analysis: &Analysis<E>,
        program: &Program,
        (values, node): (&Values, Node),
        state: &State,
        names: &[String],
    ) -> Result<Self> {
        let setup = values.setup();
        Ok(StateValues {
            levels: (1..=setup.levels).map(|k| level(values, node, k, names)).collect(),
            number: Some(Bound::new(&values.number(node), setup.exact)),
            within: values.within(node, 1).map(<[f64]>::to_vec),
            ..StateValues::without(analysis, program, state)?
        })
    }

    /// Returns a state with its ranks, without values.
    fn without<E: Engine>(analysis: &Analysis<E>, program: &Program, state: &State) -> Result<Self> {
        let most_preferred = analysis.most_preferred(state)?;
        Ok(StateValues {
            state: Valuation::of(program, state),
            is_unsafe: analysis.is_unsafe(state)?,
            most_preferred: most_preferred.into_iter().map(str::to_owned).collect(),
            sasi_rank: analysis.rank(Kind::Sasi, state)?,
            spi_rank: analysis.rank(Kind::Spi, state)?,
            levels: Vec::new(),
            number: None,
            within: None,
        })
    }
}

fn level(values: &Values, node: Node, k: usize, names: &[String]) -> LevelValues {
    let exact = values.setup().exact;
    let bound = |b: &Bounds| Bound::new(b, exact);
    let action = |choice: &ChoiceValues| ActionValues {
        action: names.get(choice.position).cloned().unwrap_or_default(),
        probability: bound(&choice.probability),
        cost: choice.cost.as_ref().map(bound),
    };
    LevelValues {
        improvements: k,
        probability: bound(&values.probability(node, k)),
        cost: values.cost(node, k).as_ref().map(bound),
        actions: values.choices(node, k, Aim::Likely).iter().map(action).collect(),
        within: values.within(node, k).map(<[f64]>::to_vec),
    }
}
