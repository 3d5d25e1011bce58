//! Properties: those that ask for the probability to reach a state set, or for the expected reward
//! until it is reached, and reasons against the others.

use super::super::ast::{Expr, ExprKind, Property, Reach, Reward};
use super::super::json::Node;
use super::reader::{Object, Reader, Value};
use crate::lang::ast::BinaryOp;
use crate::lang::property::Extreme;
use crate::model::value;

/// The question of a property, or the reason why a well-formed property is not a reachability.
type Asks<T> = Option<Result<T, String>>;

const NO_REACHABILITY: &str = "it does not ask for a probability or a reward to reach a set of states";

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
            "Pmin" | "Pmax" | "Emin" | "Emax" => self.value(&object, &op, None),
            "≥" | ">" | "≤" | "<" => self.comparison(&object, &op),
            "Smin" | "Smax" => Some(Err("it asks for a steady-state probability".to_owned())),
            _ => Some(Err(NO_REACHABILITY.to_owned())),
        }
    }

    /// Reads a comparison such as `Pmax ≥ 1`.
    fn comparison(&mut self, object: &Object<'a>, op: &str) -> Asks<Reach> {
        let left = self.required(object, "a comparison", "left")?;
        let right = self.required(object, "a comparison", "right")?;
        let Value::Object(inner) = self.any(left)? else { return Some(Err(NO_REACHABILITY.to_owned())) };
        let Some(asked) = inner.get("op") else { return Some(Err(NO_REACHABILITY.to_owned())) };
        let asked = self.name(asked, "an operator")?.name;
        if !matches!(asked.as_str(), "Pmin" | "Pmax" | "Emin" | "Emax") {
            return Some(Err(NO_REACHABILITY.to_owned()));
        }
        let value = match self.expression(right)?.kind {
            ExprKind::Literal(v @ (value::Value::Int(_) | value::Value::Real(_))) => v.to_f64(),
            _ => return Some(Err("its bound is not a number".to_owned())),
        };
        let comparison = match op {
            "≥" => BinaryOp::Ge,
            ">" => BinaryOp::Gt,
            "<" => BinaryOp::Lt,
            _ => BinaryOp::Le,
        };
        self.value(&inner, &asked, Some((comparison, value)))
    }

    /// Reads `Pmin`, `Pmax`, `Emin` or `Emax`.
    fn value(&mut self, object: &Object<'a>, op: &str, bound: Option<(BinaryOp, f64)>) -> Asks<Reach> {
        let extreme = if op.ends_with("max") { Extreme::Max } else { Extreme::Min };
        if op.starts_with('P') {
            let target = self.path(object)?;
            return Some(target.map(|target| Reach { target, extreme, reward: None, bound }));
        }
        let others = ["step-instant", "time-instant", "reward-instants"];
        if let Some(other) = others.iter().find(|o| object.get(o).is_some()) {
            return Some(Err(format!("it has a {other}")));
        }
        let (Some(target), Some(accumulated)) = (object.get("reach"), object.get("accumulate")) else {
            return Some(Err(
                "it asks for an expected value without accumulating it until a set of states is reached"
                    .to_owned(),
            ));
        };
        let moments =
            self.items(Some(accumulated), "the moments of rewards", |r, n| r.name(n, "a moment"))?;
        let at = |moment: &str| moments.iter().any(|m| m.name == moment);
        let (steps, exit) = (at("steps"), at("exit"));
        if self.is_temporal(target)? {
            return Some(Err("its formula is nested".to_owned()));
        }
        let target = self.expression(target);
        let value = self.operand(object, "an expected value", "exp");
        let reward = Some(Reward { value: value?, steps, exit });
        Some(Ok(Reach { target: target?, extreme, reward, bound }))
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
