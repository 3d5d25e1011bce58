//! Comparisons of probabilities and rewards with numbers.

use super::super::json::{Object, Shape};
use super::property::{Asks, NO_PROBABILITY, Question, no};
use super::reader::Reader;
use super::record::Read;
use crate::ast::Expr;
use crate::property::Inequality;
use meliora_base::stack;

/// Returns true for an operator whose value is a probability or a reward.
fn is_value(op: &str) -> bool {
    matches!(op, "Pmin" | "Pmax" | "Emin" | "Emax")
}

impl<'a> Reader<'a> {
    /// Reads a comparison such as `Pmax ≥ 1` or `1 ≤ Pmax`.
    pub(super) fn comparison(&mut self, object: &Object<'a>, op: &str) -> Asks<Question> {
        self.known(object, "a comparison", &["op", "left", "right"])?;
        let left = self.required(object, "a comparison", "left")?;
        let right = self.required(object, "a comparison", "right")?;
        let is_value = |reader: &mut Self, node| Some(reader.operator(node)?.is_some_and(|op| is_value(&op)));
        let (inner, bound, comparison) = match (is_value(self, left)?, is_value(self, right)?) {
            (true, false) => (left, right, inequality(op)),
            (false, true) => (right, left, inequality(op).mirrored()),
            _ => return no(NO_PROBABILITY),
        };
        let Shape::Object(inner) = self.any(inner)? else { return no(NO_PROBABILITY) };
        let asked = self.required(&inner, "a property", "op")?;
        let asked = self.name(asked, "an operator")?.name;
        let bound = Expr::read(self, bound, "a bound")?;
        self.value(&inner, &asked, Some((comparison, bound)))
    }

    /// Reads `¬(Pmax ≥ 1)`, which is `Pmax < 1`.
    pub(super) fn negation(&mut self, object: &Object<'a>) -> Asks<Question> {
        self.known(object, "a negation", &["op", "exp"])?;
        let exp = self.required(object, "a negation", "exp")?;
        if self.operator(exp)?.as_deref() == Some("filter") {
            return no(NO_PROBABILITY);
        }
        let asked = stack::level(|| self.asked(exp))?;
        Some(asked.and_then(|asked| match asked.bound {
            Some((comparison, bound)) => Ok(Question { bound: Some((negated(comparison), bound)), ..asked }),
            None => Err(NO_PROBABILITY.to_owned()),
        }))
    }
}

fn inequality(op: &str) -> Inequality {
    match op {
        "≥" => Inequality::Ge,
        ">" => Inequality::Gt,
        "<" => Inequality::Lt,
        _ => Inequality::Le,
    }
}

/// Returns the comparison that is true where another one is false.
fn negated(comparison: Inequality) -> Inequality {
    match comparison {
        Inequality::Ge => Inequality::Lt,
        Inequality::Gt => Inequality::Le,
        Inequality::Le => Inequality::Gt,
        Inequality::Lt => Inequality::Ge,
    }
}
