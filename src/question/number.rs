//! Exact counts in reports: decimal strings in JSON, grouped digits in text.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Serialize, Serializer};

use meliora_engine::Count;
use meliora_model::valuation::Decimal;

/// A count of states, choices or transitions. JSON has it as a string, since many readers lose
/// digits beyond 2^53.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Number(pub Count);

impl Number {
    /// Formats the number with a comma after every third digit: `1,234,567`.
    pub fn grouped(&self) -> String {
        grouped(&self.0)
    }
}

impl From<Count> for Number {
    fn from(count: Count) -> Self {
        Number(count)
    }
}

impl From<u64> for Number {
    fn from(count: u64) -> Self {
        Number(Count::from(count))
    }
}

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl JsonSchema for Number {
    fn schema_name() -> Cow<'static, str> {
        Decimal::schema_name()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        Decimal::json_schema(generator)
    }
}

impl Serialize for Number {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// Formats a number with a comma after every third digit: `1,234,567`.
pub fn grouped(number: impl fmt::Display) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_grouped_from_the_right() {
        for (n, text) in [(0, "0"), (999, "999"), (1000, "1,000"), (1_234_567, "1,234,567")] {
            assert_eq!(Number::from(n).grouped(), text);
        }
    }

    #[test]
    fn a_count_past_2_to_the_53_keeps_its_digits_in_json() {
        let count = Number(Count::from(u64::MAX) * 1000u32);
        assert_eq!(serde_json::to_string(&count).unwrap(), "\"18446744073709551615000\"");
    }
}
