//! Properties: those that ask for the probability to reach a state set, and reasons against the
//! others.

use super::super::ast::{Expr, ExprKind, Property, Reach};
use super::super::json::Node;
use super::reader::{Object, Reader, Value};
use crate::lang::ast::BinaryOp;
use crate::lang::property::{self, Extreme};
use crate::model::value;

/// The question of a property, or the reason why a well-formed property is not a reachability.
type Asks<T> = Option<Result<T, String>>;

const NO_REACHABILITY: &str = "it does not ask for the probability to reach a set of states";

impl<'a> Reader<'a> {
    /// Reads a property.
    pub(super) fn property(&mut self, node: Node<'a>) -> Option<Property> {
        let object = self.object(node, "a property", &["name", "expression"])?;
        let name = self.named(&object, "a property", "name");
        let expression = self.required(&object, "a property", "expression");
        let asks = self.asked(expression?);
        Some(Property { name: name?, asks: asks? })
    }

    fn asked(&mut self, node: Node<'a>) -> Asks<Reach> {
        let Value::Object(object) = self.any(node)? else { return Some(Err(NO_REACHABILITY.to_owned())) };
        let Some(op) = object.get("op") else { return Some(Err(NO_REACHABILITY.to_owned())) };
        let op = self.name(op, "an operator")?.name;
        match op.as_str() {
            "filter" => {
                self.known(&object, "a filter", &["op", "fun", "values", "states"])?;
                let values = self.required(&object, "a filter", "values")?;
                self.asked(values)
            }
            "Pmin" | "Pmax" => Some(self.path(&object)?.map(|target| Reach { target, compared: None })),
            "≥" | ">" | "≤" | "<" => self.comparison(&object, &op),
            "Emin" | "Emax" => Some(Err("it asks for an expected value".to_owned())),
            "Smin" | "Smax" => Some(Err("it asks for a steady-state probability".to_owned())),
            _ => Some(Err(NO_REACHABILITY.to_owned())),
        }
    }

    /// Reads a comparison such as `Pmax ≥ 1`.
    fn comparison(&mut self, object: &Object<'a>, op: &str) -> Asks<Reach> {
        let left = self.required(object, "a comparison", "left")?;
        let right = self.required(object, "a comparison", "right")?;
        let Value::Object(inner) = self.any(left)? else { return Some(Err(NO_REACHABILITY.to_owned())) };
        let Some(extreme) = inner.get("op") else { return Some(Err(NO_REACHABILITY.to_owned())) };
        let extreme = self.name(extreme, "an operator")?.name;
        if !matches!(extreme.as_str(), "Pmin" | "Pmax") {
            return Some(Err(NO_REACHABILITY.to_owned()));
        }
        let value = match self.expression(right)?.kind {
            ExprKind::Literal(v @ (value::Value::Int(_) | value::Value::Real(_))) => Some(v.to_f64()),
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
            return Some(Err("its bound is neither 0 nor 1".to_owned()));
        }
        Some(self.path(&inner)?.map(|target| Reach { target, compared }))
    }

    /// Reads the target of `F e` or `true U e`.
    fn path(&mut self, object: &Object<'a>) -> Asks<Expr> {
        let path = self.required(object, "a property", "exp")?;
        let Value::Object(path) = self.any(path)? else { return Some(Err(NO_REACHABILITY.to_owned())) };
        let Some(op) = path.get("op") else { return Some(Err(NO_REACHABILITY.to_owned())) };
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
                Value::Bool(true) => {}
                _ => return Some(Err("it restricts the states on the way".to_owned())),
            }
        }
        let Some(target) = target else { return self.fail(path.start(), "this formula has no target") };
        if self.is_temporal(target)? {
            return Some(Err("its formula is nested".to_owned()));
        }
        self.expression(target).map(Ok)
    }

    /// Returns true if a formula has a temporal operator at its top or below Boolean operators.
    fn is_temporal(&mut self, node: Node<'a>) -> Option<bool> {
        let Value::Object(object) = self.any(node)? else { return Some(false) };
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
