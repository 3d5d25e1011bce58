//! The quantities of states as plain data.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Serialize, Serializer};

use crate::by_goal::GainValues;
use crate::{Aim, ChoiceValues, Node, Values};
use meliora_base::error::Result;
use meliora_base::interval::{Bounds, Interval};
use meliora_engine::{Engine, NoProgress};
use meliora_model::valuation::Valuation;
use meliora_model::{Program, State};
use meliora_planning::{Analysis, Kind, Rank};
use meliora_space::weighted::Walker;

/// The values of a state.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct StateValues {
    /// The values of its variables.
    pub state: Valuation,
    /// `true`: no strategy keeps the requirements from it; absent for other states.
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
    /// The greatest expected number of improvements; `null` for an unsafe state.
    pub number: Option<Bound>,
    /// The greatest probability of an improvement within 0, 1, 2, … steps; `null` if steps were not
    /// given (`--within`), and for an unsafe state.
    pub within: Option<Vec<f64>>,
    /// The gains of the first improvement with their probabilities, under the strategy that makes it most likely;
    /// absent if they were not asked for (`--by-goal`), and for an unsafe state.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by_goal: Option<Vec<GainValues>>,
}

/// The values of a state for one number of improvements.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct LevelValues {
    /// The number of improvements.
    pub improvements: usize,
    /// The greatest probability of these improvements.
    pub probability: Bound,
    /// The least expected cost until the last of them; `null` where they are not certain.
    pub cost: Option<Bound>,
    /// The kept actions, best first; empty where no improvement is possible.
    pub actions: Vec<ActionValues>,
    /// The greatest probability of these improvements within 0, 1, 2, … steps; `null` if steps were
    /// not given (`--within`).
    pub within: Option<Vec<f64>>,
}

/// The values of an action for one number of improvements.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ActionValues {
    /// Its name.
    pub action: String,
    /// The greatest probability of the improvements after this action.
    pub probability: Bound,
    /// The least expected cost after this action; `null` if the improvements do not stay certain.
    pub cost: Option<Bound>,
}

/// Bounds of a number.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "bounds")]
pub struct Bound {
    /// The lower bound.
    #[serde(serialize_with = "finite")]
    #[schemars(with = "Extended")]
    pub lower: f64,
    /// The upper bound, infinite if none is known.
    #[serde(serialize_with = "finite")]
    #[schemars(with = "Extended")]
    pub upper: f64,
    /// The value as a fraction, such as `1/3`; absent if fractions were not asked for (`--exact`).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exact: Option<String>,
}

impl Bound {
    /// Copies bounds; `exact` says whether fractions were asked for.
    pub fn new(bounds: &Bounds, exact: bool) -> Self {
        let fraction = bounds.exact.as_ref().filter(|_| exact).map(ToString::to_string);
        Bound { exact: fraction, ..Bound::from(bounds.interval) }
    }

    /// Returns the width, divided by the value where that is above 1; 0 of a fraction, which may exceed all doubles.
    pub fn width(&self) -> f64 {
        let Bound { lower, upper, .. } = *self;
        if self.exact.is_some() { 0.0 } else { Interval { lower, upper }.relative_width() }
    }
}

impl From<Interval> for Bound {
    fn from(Interval { lower, upper }: Interval) -> Self {
        Bound { lower, upper, exact: None }
    }
}

/// The schema of a number that may be infinite.
struct Extended;

impl JsonSchema for Extended {
    fn schema_name() -> Cow<'static, str> {
        "bound".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A number, or infinity.",
            "anyOf": [{"type": "number"}, {"const": "inf"}, {"const": "-inf"}],
        })
    }
}

/// Serialises a number; infinity is `"inf"`.
fn finite<S: Serializer>(x: &f64, serializer: S) -> std::result::Result<S::Ok, S::Error> {
    match x {
        _ if x.is_finite() => serializer.serialize_f64(*x),
        _ if *x < 0.0 => serializer.serialize_str("-inf"),
        _ => serializer.serialize_str("inf"),
    }
}

/// A bound that is wider than others.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Width {
    /// The width, divided by the value where that is above 1.
    pub width: f64,
    /// The quantity that is bounded.
    quantity: Option<(char, usize)>,
}

impl Width {
    /// Returns the wider one of two bounds.
    pub fn or(self, other: Width) -> Width {
        if other.width > self.width { other } else { self }
    }

    /// Returns the name of the quantity: `P_k`, `C_k` or `N`.
    pub fn quantity(&self) -> String {
        self.quantity.map_or_else(|| "N".to_owned(), |(letter, k)| format!("{letter}_{k}"))
    }
}

impl StateValues {
    /// Returns the widest bound of the state.
    pub fn widest(&self) -> Width {
        let wide = |bound: &Bound, quantity| Width { width: bound.width(), quantity };
        let number = self.number.as_ref().map_or_else(Width::default, |number| wide(number, None));
        self.levels.iter().fold(number, |widest, level| {
            let k = level.improvements;
            let cost = level.cost.as_ref().map_or(widest, |cost| widest.or(wide(cost, Some(('C', k)))));
            cost.or(wide(&level.probability, Some(('P', k))))
        })
    }

    /// Collects the values of some states of the scope, except for those that were not reached before
    /// a limit. Unsafe states are listed without values.
    ///
    /// # Errors
    /// A command has no meaning in a state.
    pub fn all<E: Engine>(
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
    pub fn each<E: Engine>(
        analysis: &Analysis<E>,
        program: &Program,
        values: &Values,
        states: &[State],
        each: &mut dyn FnMut(Self),
    ) -> Result<()> {
        let walker = Walker::new(program, &NoProgress)?;
        let codec = walker.codec().clone();
        let mut walk = walker.walk();
        for state in states {
            if analysis.is_unsafe(state)? {
                each(StateValues::without(analysis, program, state)?);
            } else if let (Some(node), Some(code)) = (values.start(state), codec.encode(state)) {
                each(StateValues::at(analysis, program, values, node, state, walk.names(&code)?)?);
            }
        }
        Ok(())
    }

    fn at<E: Engine>(
        analysis: &Analysis<E>,
        program: &Program,
        values: &Values,
        node: Node,
        state: &State,
        names: &[String],
    ) -> Result<Self> {
        let options = values.options();
        Ok(StateValues {
            levels: (1..=options.levels).map(|k| level(values, node, k, names)).collect(),
            number: Some(Bound::new(&values.number(node), options.exact)),
            within: values.within(node, 1).map(<[f64]>::to_vec),
            ..StateValues::without(analysis, program, state)?
        })
    }

    /// Returns a state with its ranks, without values.
    fn without<E: Engine>(analysis: &Analysis<E>, program: &Program, state: &State) -> Result<Self> {
        let most_preferred = analysis.most_preferred(state)?;
        Ok(StateValues {
            state: Valuation::new(program, state),
            is_unsafe: analysis.is_unsafe(state)?,
            most_preferred: most_preferred.into_iter().map(str::to_owned).collect(),
            sasi_rank: analysis.rank(Kind::Sasi, state)?,
            spi_rank: analysis.rank(Kind::Spi, state)?,
            levels: Vec::new(),
            number: None,
            within: None,
            by_goal: None,
        })
    }
}

fn level(values: &Values, node: Node, k: usize, names: &[String]) -> LevelValues {
    let exact = values.options().exact;
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
