//! Recognition of a question about a single formula in a property, which is read as an expression over states.

use super::property::{Expressed, Question, Reward};
use crate::ast::{BinaryOp, Expr, Node, NodeKind};
use crate::ltl::{Formula, FormulaKind};
use crate::property::check::parts;
use crate::property::operators::{Accumulated, OperatorKind};
use crate::property::{Inequality, Operator, Over, Rewards};
use meliora_base::stack;

impl Expressed {
    /// Returns the question, if the property is one about a single formula on paths. Its part of the initial states is
    /// unknown if they do not answer the filter around it.
    pub(super) fn question(&self) -> Option<Question> {
        self.asked(&self.expression.nodes)
    }

    fn asked(&self, nodes: &[Node]) -> Option<Question> {
        match (&nodes.last()?.kind, parts(nodes).as_slice()) {
            (NodeKind::Operator(operator), _) => match &operator.kind {
                OperatorKind::Filter(function, values, Some(states)) => {
                    let asked = stack::level(|| self.asked(&values.nodes))?;
                    let over = over(&function.name, asked.bound.is_some()).filter(|_| is_initial(states));
                    Some(Question { over: asked.over.and(over), ..asked })
                }
                _ => self.value(operator, None),
            },
            (NodeKind::Not, &[operand]) if !is_filter(operand) => {
                let asked = stack::level(|| self.asked(operand))?;
                let (comparison, bound) = asked.bound?;
                Some(Question { bound: Some((negated(comparison), bound)), ..asked })
            }
            (&NodeKind::Binary(op), &[a, b]) => {
                let comparison = inequality(op)?;
                match (a, b) {
                    ([Node { kind: NodeKind::Operator(operator), .. }], bound) => {
                        self.value(operator, Some((comparison, plain(bound)?)))
                    }
                    (bound, [Node { kind: NodeKind::Operator(operator), .. }]) => {
                        self.value(operator, Some((comparison.mirrored(), plain(bound)?)))
                    }
                    _ => None,
                }
            }
            _ => None,
        }
    }

    /// Returns the question of a probability, or of a reward until a set of states is reached.
    fn value(&self, operator: &Operator, bound: Option<(Inequality, Expr)>) -> Option<Question> {
        let (asked, formula, reward) = match &operator.kind {
            OperatorKind::Probability(asked, formula) => (asked, formula, None),
            OperatorKind::Reward(Rewards::Numbered(at), asked, Accumulated::Until(formula)) => {
                let reward = self.rewards.get(at.checked_sub(1)?).filter(|reward| reward.reaches)?;
                (asked, formula, Some(reward.clone()))
            }
            _ => return None,
        };
        let is_plain = reward.as_ref().is_none_or(|reward: &Reward| is_plain(&reward.value.nodes));
        let on_paths = !matches!(formula.kind, FormulaKind::State(_)) && is_single(formula.clone());
        let (formula, extreme, over) = (formula.clone(), asked.extreme, Some(Over::All));
        (on_paths && is_plain).then_some(Question { formula, extreme, reward, bound, over })
    }
}

/// Returns an expression without operators of properties.
fn plain(nodes: &[Node]) -> Option<Expr> {
    is_plain(nodes).then(|| Expr { nodes: nodes.to_vec() })
}

/// Returns whether an expression has no operators of properties and names no states that only properties name.
pub(in crate::jani) fn is_plain(nodes: &[Node]) -> bool {
    !nodes.iter().any(|node| matches!(node.kind, NodeKind::Operator(_) | NodeKind::Label(_)))
}

/// Returns whether the conditions and bounds of a formula have no operators of properties.
fn is_single(mut formula: Formula) -> bool {
    let mut open = vec![&mut formula];
    while let Some(part) = open.pop() {
        let of_state = matches!(&part.kind, FormulaKind::State(e) if !is_plain(&e.nodes));
        if of_state || part.bounds_mut().iter().any(|bound| !is_plain(&bound.nodes)) {
            return false;
        }
        open.extend(part.operands_mut());
    }
    true
}

/// Returns the comparison that an operator makes, if it makes one of sizes.
pub(in crate::jani) fn inequality(op: BinaryOp) -> Option<Inequality> {
    Some(match op {
        BinaryOp::Ge => Inequality::Ge,
        BinaryOp::Gt => Inequality::Gt,
        BinaryOp::Le => Inequality::Le,
        BinaryOp::Lt => Inequality::Lt,
        _ => return None,
    })
}

fn is_filter(nodes: &[Node]) -> bool {
    let [Node { kind: NodeKind::Operator(operator), .. }] = nodes else { return false };
    matches!(operator.kind, OperatorKind::Filter(..))
}

fn is_initial(states: &Expr) -> bool {
    matches!(states.nodes.as_slice(), [Node { kind: NodeKind::Label(name), .. }] if **name == *"init")
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

/// Returns the part of the initial states whose answer is the value of a function of the values in all of
/// them.
fn over(function: &str, is_verdict: bool) -> Option<Over> {
    match (function, is_verdict) {
        ("forall", true) => Some(Over::All),
        ("min", false) => Some(Over::Least),
        ("max", false) => Some(Over::Greatest),
        _ => None,
    }
}
