//! Operators of properties inside of expressions: probabilities, rewards, quantifiers over paths, and filters.

use super::super::json::{Node, Object};
use super::path;
use super::property::{Asks, Expressed, INSTANTS, Reward};
use super::reader::Reader;
use super::record::Read;
use crate::ast::{Expr, Ident, NodeKind, Span};
use crate::ltl::Formula;
use crate::property::operators::{Accumulated, Asked, OperatorKind};
use crate::property::{Extreme, Operator, Rewards};

impl<'a> Reader<'a> {
    /// Reads a property as an expression over states.
    pub(super) fn expressed(&mut self, node: Node<'a>) -> Asks<Expressed> {
        self.rewards = Some(Vec::new());
        let expression = Expr::read(self, node, "a property");
        let rewards = self.rewards.take().unwrap_or_default();
        let expression = expression?;
        if !expression.nodes.iter().any(|node| matches!(node.kind, NodeKind::Operator(_))) {
            return Some(Err(super::property::NO_PROBABILITY.to_owned()));
        }
        Some(Ok(Expressed { expression, rewards }))
    }

    /// Returns whether operators of properties may stand in expressions.
    pub(super) fn is_nesting(&self) -> bool {
        self.rewards.is_some()
    }

    /// Reads an operator of properties whose value is a condition or a number.
    pub(super) fn nested(&mut self, object: &Object<'a>, op: &str, span: Span) -> Option<NodeKind> {
        let what = format!("\"{op}\"");
        let extreme = if op.ends_with("max") { Extreme::Max } else { Extreme::Min };
        let asked = Asked { extreme, bound: None };
        let kind = match op {
            "initial" | "deadlock" => {
                self.known(object, &what, &["op"])?;
                let name = if op == "initial" { "init" } else { op };
                return Some(NodeKind::Label(name.into()));
            }
            "Pmin" | "Pmax" => {
                self.known(object, &what, &["op", "exp"])?;
                OperatorKind::Probability(asked, self.inner(object, &what, span)?)
            }
            "∀" | "∃" => {
                self.known(object, &what, &["op", "exp"])?;
                OperatorKind::Paths(op == "∀", self.inner(object, &what, span)?)
            }
            "Smin" | "Smax" if object.get("accumulate").is_none() => {
                self.known(object, &what, &["op", "exp"])?;
                OperatorKind::LongRun(asked, self.field(object, &what, "exp", None)?)
            }
            "Emin" | "Emax" | "Smin" | "Smax" => {
                let accumulated = self.accumulated(object, op, span)?;
                OperatorKind::Reward(self.earned(object, &what)?, asked, accumulated)
            }
            "filter" => {
                let (function, values, states) = self.filtered(object)?;
                OperatorKind::Filter(function, values, Some(states))
            }
            _ => {
                let message = format!("the operator \"{op}\" cannot stand here");
                let help = "formulas on paths stand in \"Pmin\", \"Pmax\", \"∀\" or \"∃\"";
                self.report(self.not_supported(span, message).help(help));
                return None;
            }
        };
        Some(NodeKind::Operator(Box::new(Operator { coalition: None, kind, head: span, span })))
    }

    /// Reads the formula on paths inside of an operator; a condition is one on the first state.
    fn inner(&mut self, object: &Object<'a>, what: &str, span: Span) -> Option<Formula> {
        let node = self.required(object, what, "exp")?;
        let formula = self.formula(node, &mut 0)?;
        formula.map_err(|reason| self.report(self.not_supported(span, reason))).ok()
    }

    /// Reads until when the rewards of an operator are accumulated.
    fn accumulated(&mut self, object: &Object<'a>, op: &str, span: Span) -> Option<Accumulated> {
        if let Some(other) = INSTANTS[1..].iter().find(|key| object.get(key).is_some()) {
            return self.unsupported(span, format!("it has a {other}"));
        }
        self.known(object, "an expected value", &["op", "exp", "accumulate", "reach", INSTANTS[0]])?;
        let steps = object.get(INSTANTS[0]).map(|steps| Expr::read(self, steps, "a number of steps"));
        let is_instant = steps.is_some() && object.get("reach").is_none();
        if object.get("accumulate").is_none() && !is_instant {
            let message = "it asks for an expected value without accumulating it";
            return self.unsupported(span, message);
        }
        Some(match (steps, object.get("reach")) {
            _ if op.starts_with('S') => Accumulated::LongRun,
            (Some(steps), None) if object.get("accumulate").is_some() => Accumulated::Within(steps?),
            (Some(steps), None) => Accumulated::At(steps?),
            (None, None) => Accumulated::Total,
            (None, Some(target)) if self.is_temporal(target)? => {
                let formula = self.formula(target, &mut 0)?;
                let formula = formula.map_err(|reason| self.report(self.not_supported(span, reason)));
                Accumulated::Until(formula.ok()?)
            }
            (None, Some(target)) => {
                Accumulated::Until(path::eventually(Expr::read(self, target, "a target"))?)
            }
            (Some(_), Some(_)) => return self.unsupported(span, "it has \"step-instant\" and \"reach\""),
        })
    }

    /// Reads the reward of an operator, and returns its number in the property.
    fn earned(&mut self, object: &Object<'a>, what: &str) -> Option<Rewards> {
        let value = self.field(object, what, "exp", None)?;
        let moments = match object.get("accumulate") {
            Some(moments) => self.moments(moments)?,
            None => vec!["exit".to_owned()],
        };
        let at = |moment: &str| moments.iter().any(|own| own == moment);
        let (steps, exit) = (at("steps"), at("exit"));
        let rewards = self.rewards.get_or_insert_default();
        rewards.push(Reward { value, steps, exit });
        Some(Rewards::Numbered(rewards.len()))
    }
}

/// Returns the name that PRISM's properties have for a function of filters.
pub(super) fn function(Ident { name, span }: Ident) -> Ident {
    let name = match name.as_str() {
        "∀" => "forall",
        "∃" => "exists",
        "values" => "printall",
        _ => return Ident { name, span },
    };
    Ident { name: name.to_owned(), span }
}
