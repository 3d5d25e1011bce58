//! Values, states and counts as JSON.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error as _, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::{Map, Value as Json};

use super::{Program, State, Variable};
use meliora_base::decimal;
use meliora_base::escape;
use meliora_base::exact::{Exact, Ratio, Real, shortest};
use meliora_base::value::{Type, Value};

/// The text of the only state of a model without variables.
pub(super) const NO_VARIABLES: &str = "(no variables)";

/// A state as an object from variables to values.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct Valuation(Map<String, Json>);

impl Valuation {
    /// Names the values of a state.
    pub fn new(program: &Program, state: &[i64]) -> Self {
        Valuation::of_variables(&program.variables, state)
    }

    /// Names the values of some variables.
    pub fn of_variables(variables: &[Variable], values: &[i64]) -> Self {
        let value = |v: &Variable, x: i64| match (v.ty, v.value_name(x)) {
            (_, Some(name)) => Json::from(name),
            (Type::Bool, None) => Json::Bool(x != 0),
            _ => Json::from(x),
        };
        let named = variables.iter().zip(values).map(|(v, &x)| (v.name.clone(), value(v, x)));
        Valuation(named.collect())
    }

    /// Returns the state with these values; `None` if a variable has none or another one, or a name is unknown.
    pub fn state(&self, program: &Program) -> Option<State> {
        self.values(&program.variables)
    }

    /// Returns the values of some variables, if it has these and no others; `None` if one is wrong.
    pub fn values(&self, variables: &[Variable]) -> Option<State> {
        let value = |v: &Variable| {
            let found = match (self.0.get(&v.name)?, v.ty) {
                (Json::Bool(holds), Type::Bool) => i64::from(*holds),
                (Json::String(name), _) => {
                    v.low + i64::try_from(v.values.iter().position(|x| x == name)?).ok()?
                }
                (number, Type::Int) if v.values.is_empty() => number.as_i64()?,
                _ => return None,
            };
            (v.low..=v.high).contains(&found).then_some(found)
        };
        (self.0.len() == variables.len()).then_some(())?;
        variables.iter().map(value).collect()
    }

    /// Returns the values as texts, in the order of the variables: names as they are, without quotes.
    pub fn cells(&self) -> impl Iterator<Item = String> {
        self.0.values().map(|value| value.as_str().map_or_else(|| value.to_string(), str::to_owned))
    }
}

/// Reads an object in which no variable occurs twice.
impl<'de> Deserialize<'de> for Valuation {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Once;
        impl<'de> Visitor<'de> for Once {
            type Value = Valuation;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object from variables to values")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Valuation, A::Error> {
                let mut values = Map::new();
                while let Some((name, value)) = entries.next_entry::<String, Json>()? {
                    if values.insert(name.clone(), value).is_some() {
                        let message = format!("the variable `{}` occurs twice", escape::line(&name));
                        return Err(A::Error::custom(message));
                    }
                }
                Ok(Valuation(values))
            }
        }
        from.deserialize_map(Once)
    }
}

impl fmt::Display for Valuation {
    /// Formats a state as `x=1,b=false`, which is read back as this state.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() {
            return f.write_str(NO_VARIABLES);
        }
        for (index, (name, value)) in self.0.iter().enumerate() {
            let comma = if index > 0 { "," } else { "" };
            match value.as_str() {
                Some(text) => write!(f, "{comma}{name}={}", escape::value(text))?,
                None => write!(f, "{comma}{name}={value}")?,
            }
        }
        Ok(())
    }
}

/// Converts the value of a constant; a value that JSON numbers cannot represent becomes text.
pub fn json(value: &Exact) -> Json {
    match value.rounded() {
        Value::Bool(b) => Json::from(b),
        Value::Int(i) => Json::from(i),
        Value::Real(x) => {
            serde_json::Number::from_f64(x).map_or_else(|| Json::from(x.to_string()), Json::Number)
        }
    }
}

/// Returns the exact value of a real that its nearest double does not give.
pub fn long(value: &Exact) -> Option<String> {
    beyond_double(value).map(decimal::text)
}

/// Same as [`long`], as users write it: `1/3`.
pub fn long_plain(value: &Exact) -> Option<String> {
    beyond_double(value).map(decimal::plain)
}

fn beyond_double(value: &Exact) -> Option<&Ratio> {
    let Exact::Real(Real::Finite(exact)) = value else { return None };
    let near = shortest(Real::Finite(exact.clone()).to_f64());
    (near.as_ref() != Some(exact)).then_some(exact)
}

/// The schema of a state.
impl JsonSchema for Valuation {
    fn schema_name() -> Cow<'static, str> {
        "state".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "The value of each variable.",
            "type": "object",
            "additionalProperties": {"type": ["integer", "boolean", "string"]},
        })
    }
}

/// The schema of a count that [`decimal()`] has written.
pub struct Decimal;

impl JsonSchema for Decimal {
    fn schema_name() -> Cow<'static, str> {
        "count".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "An exact number as a decimal string.",
            "type": "string",
            "pattern": "^[0-9]+$",
        })
    }
}

/// Serialises a count as a string: many readers of JSON lose digits beyond 2^53.
pub fn decimal<S: Serializer>(count: &impl fmt::Display, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(count)
}
