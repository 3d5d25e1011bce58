//! Properties: those that ask for the probability to reach a state set, and reasons against the
//! others.

use super::super::json::{Node, Object, Shape};
use super::reader::Reader;
use super::record::{Read, records};
use crate::lang::ast::{BinaryOp, Expr, Ident, NodeKind};
use crate::lang::property::{self, Bound, Extreme, Strategies};
use crate::model::value;

/// The question of a property, or the reason why a well-formed property is not a reachability.
type Asks<T> = Option<Result<T, String>>;

const NO_REACHABILITY: &str = "it does not ask for the probability to reach a set of states";

records! {
    Property = "a property" {
        "name" => name: Ident,
        "expression" => asks: Asked,
    };
}

/// The question, or the reason why the property is not a reachability of a state set.
pub(crate) type Asked = Result<Reach, String>;

/// The probability to reach a target.
#[derive(Debug, Clone)]
pub(crate) struct Reach {
    pub(crate) target: Expr,
    /// The comparison with 0 or 1, if there is one.
    pub(crate) compared: Option<(Strategies, Bound)>,
}

impl<'a> Read<'a> for Asked {
    fn read(reader: &mut Reader<'a>, node: Node<'a>, _: &str) -> Option<Self> {
        reader.asked(node)
    }
}

/// Returns the reason why a property is not a reachability.
fn no<T>(reason: &str) -> Asks<T> {
    Some(Err(reason.to_owned()))
}

impl<'a> Reader<'a> {
    fn asked(&mut self, node: Node<'a>) -> Asks<Reach> {
        let Shape::Object(object) = self.any(node)? else { return no(NO_REACHABILITY) };
        let Some(op) = object.get("op") else { return no(NO_REACHABILITY) };
        let op = self.name(op, "an operator")?.name;
        match op.as_str() {
            "filter" => {
                self.known(&object, "a filter", &["op", "fun", "values", "states"])?;
                let values = self.required(&object, "a filter", "values")?;
                self.asked(values)
            }
            "Pmin" | "Pmax" => Some(self.path(&object)?.map(|target| Reach { target, compared: None })),
            "≥" | ">" | "≤" | "<" => self.comparison(&object, &op),
            "Emin" | "Emax" => no("it asks for an expected value"),
            "Smin" | "Smax" => no("it asks for a steady-state probability"),
            _ => no(NO_REACHABILITY),
        }
    }

    /// Reads a comparison such as `Pmax ≥ 1`.
    fn comparison(&mut self, object: &Object<'a>, op: &str) -> Asks<Reach> {
        let left = self.required(object, "a comparison", "left")?;
        let right = self.required(object, "a comparison", "right")?;
        let Shape::Object(inner) = self.any(left)? else { return no(NO_REACHABILITY) };
        let Some(extreme) = inner.get("op") else { return no(NO_REACHABILITY) };
        let extreme = self.name(extreme, "an operator")?.name;
        if !matches!(extreme.as_str(), "Pmin" | "Pmax") {
            return no(NO_REACHABILITY);
        }
        let value = match Expr::read(self, right, "a bound")?.nodes.as_slice() {
            [root] => match root.kind {
                NodeKind::Literal(v @ (value::Value::Int(_) | value::Value::Real(_))) => Some(v.to_f64()),
                _ => None,
            },
            _ => None,
        };
        let comparison = match op {
            "≥" => BinaryOp::Ge,
            ">" => BinaryOp::Gt,
            "<" => BinaryOp::Lt,
            _ => BinaryOp::Le,
        };
        let extreme = if extreme == "Pmax" { Extreme::Max } else { Extreme::Min };
        let compared = value.and_then(|value| property::meaning(extreme, comparison, value));
        if compared.is_none() {
            return no("its bound is neither 0 nor 1");
        }
        Some(self.path(&inner)?.map(|target| Reach { target, compared }))
    }

    /// Reads the target of `F e` or `true U e`.
    fn path(&mut self, object: &Object<'a>) -> Asks<Expr> {
        let path = self.required(object, "a property", "exp")?;
        let Shape::Object(path) = self.any(path)? else { return no(NO_REACHABILITY) };
        let Some(op) = path.get("op") else { return no(NO_REACHABILITY) };
        let op = self.name(op, "an operator")?.name;
        let bounds = ["step-bounds", "time-bounds", "reward-bounds"];
        if let Some(bound) = bounds.iter().find(|b| path.get(b).is_some()) {
            return Some(Err(format!("it has {bound}")));
        }
        let (target, before) = match op.as_str() {
            "F" => (path.get("exp").or_else(|| path.get("right")), None),
            "U" => (path.get("right"), path.get("left")),
            _ => return Some(Err(format!("its operator is \"{op}\""))),
        };
        if let Some(before) = before {
            match self.any(before)? {
                Shape::Bool(true) => {}
                _ => return no("it restricts the states on the way"),
            }
        }
        let Some(target) = target else { return self.fail(path.start(), "this formula has no target") };
        if self.is_temporal(target)? {
            return no("its formula is nested");
        }
        Expr::read(self, target, "a target").map(Ok)
    }

    /// Returns true if a formula has a temporal operator at its top or below Boolean operators.
    fn is_temporal(&mut self, node: Node<'a>) -> Option<bool> {
        let Shape::Object(object) = self.any(node)? else { return Some(false) };
        let Some(op) = object.get("op") else { return Some(false) };
        match self.name(op, "an operator")?.name.as_str() {
            "F" | "G" | "U" | "W" | "R" | "X" | "Pmin" | "Pmax" | "Emin" | "Emax" | "Smin" | "Smax" | "∀"
            | "∃" | "filter" | "initial" | "deadlock" | "timelock" => Some(true),
            "∧" | "∨" | "¬" | "⇒" => {
                let mut found = false;
                for part in ["left", "right", "exp"].into_iter().filter_map(|key| object.get(key)) {
                    found = found || self.is_temporal(part)?;
                }
                Some(found)
            }
            _ => Some(false),
        }
    }
}
