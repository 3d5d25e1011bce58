//! Formulas on paths: `F`, `G`, `U`, `W`, `R` and `X` with bounds on steps, joined by `∧`, `∨`, `¬` and
//! `⇒`, over state formulas.

use super::super::json::{Node, Object, Shape};
use super::property::{Asks, no};
use super::reader::Reader;
use super::record::Read;
use crate::ast::Expr;
use crate::ltl::{Formula, FormulaKind, MOST_OPERATORS, Steps};
use meliora_base::stack;

/// Operators on paths.
const TEMPORAL: &[&str] = &["F", "G", "X", "U", "W", "R"];

/// Operators that quantify over paths or strategies.
const NESTED: &[&str] = &["Pmin", "Pmax", "Emin", "Emax", "Smin", "Smax", "∀", "∃", "filter"];

/// Sets of states that only properties name.
const STATES: &[&str] = &["initial", "deadlock", "timelock"];

/// Operators that join formulas on paths.
const JOINING: &[&str] = &["∧", "∨", "¬", "⇒"];

/// Bounds on the number of steps.
const BOUNDS: &str = "step-bounds";

/// Bounds on other quantities than steps.
const OTHER_BOUNDS: &[&str] = &["time-bounds", "reward-bounds"];

/// Returns true for an operator that occurs in properties only.
pub(super) fn is_of_properties(op: &str) -> bool {
    [TEMPORAL, NESTED, STATES].iter().any(|known| known.contains(&op))
}

/// Returns `F target`.
pub(super) fn eventually(target: Option<Expr>) -> Option<Formula> {
    let target = target?;
    let span = target.span();
    let state = Box::new(Formula { kind: FormulaKind::State(target), span });
    Some(Formula { kind: FormulaKind::Eventually(Steps::default(), state), span })
}

impl<'a> Reader<'a> {
    /// Reads a formula on paths; a condition is one on the first state.
    pub(super) fn formula(&mut self, node: Node<'a>, operators: &mut usize) -> Asks<Formula> {
        if !self.is_temporal(node)? {
            let e = Expr::read(self, node, "a state formula")?;
            return Some(Ok(Formula { kind: FormulaKind::State(e), span: node.span() }));
        }
        *operators += 1;
        if *operators > MOST_OPERATORS {
            return Some(Err(format!("its formula has more than {MOST_OPERATORS} operators")));
        }
        let Shape::Object(object) = self.any(node)? else { return no("its formula is not an object") };
        let op = self.required(&object, "a formula", "op")?;
        let op = self.name(op, "an operator")?.name;
        if let Some(bounds) = OTHER_BOUNDS.iter().find(|key| object.get(key).is_some()) {
            return Some(Err(format!("it has {bounds}")));
        }
        let kind = stack::level(|| match op.as_str() {
            "F" | "G" | "X" | "¬" => self.unary(&object, &op, operators),
            "U" | "W" | "R" | "∧" | "∨" | "⇒" => self.binary(&object, &op, operators),
            _ => Some(Err(format!("its operator is \"{op}\""))),
        })?;
        Some(kind.map(|kind| Formula { kind, span: node.span() }))
    }

    fn unary(&mut self, object: &Object<'a>, op: &str, operators: &mut usize) -> Asks<FormulaKind> {
        self.known(object, "a formula", &["op", "exp", "right", BOUNDS])?;
        // Some tools write the operand of `F` and `G` where `U` has its right one.
        let operand = match (object.get("exp"), object.get("right")) {
            (None, Some(right)) if op != "¬" => right,
            (Some(_), Some(_)) => return self.fail(object.key_span("right"), "a second operand"),
            _ => self.required(object, "a formula", "exp")?,
        };
        let (steps, operand) = (self.steps(object, op)?, self.formula(operand, operators)?);
        Some(steps.and_then(|steps| {
            let operand = Box::new(operand?);
            Ok(match op {
                "F" => FormulaKind::Eventually(steps, operand),
                "G" => FormulaKind::Always(steps, operand),
                "X" => FormulaKind::Next(operand),
                _ => FormulaKind::Not(operand),
            })
        }))
    }

    fn binary(&mut self, object: &Object<'a>, op: &str, operators: &mut usize) -> Asks<FormulaKind> {
        self.known(object, "a formula", &["op", "left", "right", BOUNDS])?;
        let left = self.required(object, "a formula", "left")?;
        let right = self.required(object, "a formula", "right")?;
        let is_all = matches!(self.any(left)?, Shape::Bool(true));
        let (left, right) = (self.formula(left, operators)?, self.formula(right, operators)?);
        let steps = self.steps(object, op)?;
        Some(steps.and_then(|steps| {
            let (left, right) = (left?, right?);
            Ok(match op {
                "∧" => FormulaKind::And(vec![left, right]),
                "∨" => FormulaKind::Or(vec![left, right]),
                "U" if is_all => FormulaKind::Eventually(steps, Box::new(right)),
                "U" => FormulaKind::Until(steps, Box::new(left), Box::new(right)),
                "W" => FormulaKind::Weak(Steps::default(), Box::new(left), Box::new(right)),
                "R" => FormulaKind::Release(Steps::default(), Box::new(left), Box::new(right)),
                _ => FormulaKind::Implies(Box::new(left), Box::new(right)),
            })
        }))
    }

    /// Reads the bounds on the number of steps of an operator.
    fn steps(&mut self, object: &Object<'a>, op: &str) -> Asks<Steps> {
        let Some(bounds) = object.get(BOUNDS) else { return Some(Ok(Steps::default())) };
        if !matches!(op, "F" | "G" | "U") {
            return Some(Err(format!("it has \"{op}\" with step-bounds")));
        }
        let keys = ["lower", "lower-exclusive", "upper", "upper-exclusive"];
        let bounds = self.object(bounds, "bounds", &keys, &[])?;
        let least = self.bound(&bounds, "lower", "lower-exclusive")?;
        let most = self.bound(&bounds, "upper", "upper-exclusive")?;
        Some(Ok(Steps { least, most }))
    }

    /// Reads a bound and whether it is excluded itself.
    #[allow(clippy::option_option)]
    fn bound(&mut self, bounds: &Object<'a>, key: &str, strict: &str) -> Option<Option<(Expr, bool)>> {
        let strict = bounds.get(strict).map_or(Some(false), |node| self.truth(node, "a flag"))?;
        let Some(bound) = bounds.get(key) else { return Some(None) };
        Some(Some((Expr::read(self, bound, "a bound")?, strict)))
    }

    /// Returns true if a formula has an operator of properties at its top or below Boolean
    /// operators.
    pub(super) fn is_temporal(&mut self, node: Node<'a>) -> Option<bool> {
        let mut open = vec![node];
        while let Some(node) = open.pop() {
            let Shape::Object(object) = self.any(node)? else { continue };
            let Some(op) = object.get("op") else { continue };
            let op = self.name(op, "an operator")?.name;
            // Other operators of properties are conditions in formulas, where they may stand.
            if TEMPORAL.contains(&op.as_str()) {
                return Some(true);
            }
            if JOINING.contains(&op.as_str()) {
                open.extend(["exp", "right", "left"].into_iter().filter_map(|key| object.get(key)));
            }
        }
        Some(false)
    }
}
