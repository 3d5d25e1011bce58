//! Properties: formulas and expressions over states, whose conditions become expressions in the pool of the program.

use super::super::read::property::Expressed;
use super::NO_MEANING;
use super::scope::Place;
use super::state::Lowering;
use crate::ast::{BinaryOp, Expr, Node, NodeKind};
use crate::ltl::{Formula, FormulaKind};
use crate::property::check::parts;
use crate::property::operators::{self, Accumulated, OperatorKind};
use crate::property::{Inequality, Operator, Property, Rewards};
use crate::refusal::Refusal;
use meliora_base::value::Type;
use meliora_model::expr::ExprId;
use meliora_model::rewards::RewardStructure;

impl Lowering<'_> {
    /// Returns the target of a property that asks about reaching one, in whatever states.
    pub(super) fn target(&mut self, property: &str, expressed: &Expressed) -> Option<ExprId> {
        let target = reached(&expressed.expression.nodes)?.reachability().filter(|e| is_plain(&e.nodes))?;
        let told = self.lowerer.diagnostics.len();
        let what = format!("a state formula of the property `{property}`");
        let lowered = self.typed(target, Place::default(), Type::Bool, &what);
        self.lowerer.diagnostics.truncate(told);
        lowered
    }

    /// Returns an expression over states with its conditions and numbers in the pool of the program.
    pub(super) fn expressed(
        &mut self,
        name: &str,
        Expressed { expression, rewards }: &Expressed,
        structures: &mut Vec<RewardStructure>,
    ) -> Result<Property, Refusal> {
        let told = self.lowerer.diagnostics.len();
        let numbers = rewards.iter().map(|reward| self.structure(name, reward, structures));
        let numbers = numbers.collect::<Result<Vec<_>, _>>()?;
        let lowered = self.known(expression, &numbers).map(|expression| Property { expression });
        self.refused(told).map_or_else(|| lowered.ok_or_else(|| Refusal::without_place(NO_MEANING)), Err)
    }

    fn known(&mut self, e: &Expr, rewards: &[usize]) -> Option<Expr> {
        let mut nodes = Vec::with_capacity(e.nodes.len());
        self.known_nodes(&e.nodes, rewards, &mut nodes)?;
        Some(Expr { nodes })
    }

    /// Adds the nodes of an expression, in which each part without operators of properties is one node.
    fn known_nodes(&mut self, nodes: &[Node], rewards: &[usize], out: &mut Vec<Node>) -> Option<()> {
        let Node { kind, span } = nodes.last()?;
        let span = *span;
        if is_plain(nodes) {
            out.push(Node { kind: NodeKind::Known(self.plain(nodes)?), span });
            return Some(());
        }
        let kind = match kind {
            NodeKind::Operator(operator) => {
                NodeKind::Operator(Box::new(self.known_operator(operator, rewards, None)?))
            }
            NodeKind::Label(_) => kind.clone(),
            kind => {
                let parts = parts(nodes);
                if let Some(operator) = self.compared(kind, &parts, rewards) {
                    out.push(Node { kind: NodeKind::Operator(Box::new(operator?)), span });
                    return Some(());
                }
                meliora_base::stack::level(|| {
                    parts.into_iter().try_for_each(|part| self.known_nodes(part, rewards, out))
                })?;
                kind.clone()
            }
        };
        out.push(Node { kind, span });
        Some(())
    }

    /// Lowers a part without operators of properties.
    fn plain(&mut self, nodes: &[Node]) -> Option<ExprId> {
        let read = self.value(&Expr { nodes: nodes.to_vec() }, Place::default());
        let (id, span) = self.scalar(read);
        self.lowerer.whole(id?, span)
    }

    /// Returns an operator that is compared with a constant, if an expression is such a comparison.
    fn compared(
        &mut self,
        kind: &NodeKind,
        parts: &[&[Node]],
        rewards: &[usize],
    ) -> Option<Option<Operator>> {
        let (&NodeKind::Binary(op), &[a, b]) = (kind, parts) else { return None };
        let comparison = inequality(op)?;
        let (operator, bound, comparison) = match (a, b) {
            ([Node { kind: NodeKind::Operator(operator), .. }], bound) => (operator, bound, comparison),
            (bound, [Node { kind: NodeKind::Operator(operator), .. }]) => {
                (operator, bound, comparison.mirrored())
            }
            _ => return None,
        };
        if !is_plain(bound) || matches!(operator.kind, OperatorKind::Filter(..) | OperatorKind::Paths(..)) {
            return None;
        }
        let Some(id) = self.plain(bound) else { return Some(None) };
        self.lowerer.pool.exact_literal(id)?;
        let bound = Expr::new(NodeKind::Known(id), bound.last()?.span);
        Some(self.known_operator(operator, rewards, Some((comparison, bound))))
    }

    fn known_operator(
        &mut self,
        operator: &Operator,
        rewards: &[usize],
        bound: Option<(Inequality, Expr)>,
    ) -> Option<Operator> {
        let asked = |asked: &operators::Asked| operators::Asked { bound, ..asked.clone() };
        let kind = match &operator.kind {
            OperatorKind::Probability(own, formula) => {
                OperatorKind::Probability(asked(own), self.known_formula(formula, rewards)?)
            }
            OperatorKind::Reward(Rewards::Numbered(at), own, accumulated) => {
                let own = asked(own);
                let accumulated = match accumulated {
                    Accumulated::Until(formula) => Accumulated::Until(self.known_formula(formula, rewards)?),
                    Accumulated::Within(steps) => Accumulated::Within(self.known(steps, rewards)?),
                    Accumulated::At(steps) => Accumulated::At(self.known(steps, rewards)?),
                    other => other.clone(),
                };
                OperatorKind::Reward(Rewards::Numbered(*rewards.get(at.checked_sub(1)?)?), own, accumulated)
            }
            OperatorKind::LongRun(own, states) => {
                let own = asked(own);
                OperatorKind::LongRun(own, self.known(states, rewards)?)
            }
            OperatorKind::Paths(all, formula) => {
                OperatorKind::Paths(*all, self.known_formula(formula, rewards)?)
            }
            OperatorKind::Filter(function, of, states) => {
                let of = self.known(of, rewards)?;
                let states = match states {
                    Some(states) => Some(self.known(states, rewards)?),
                    None => None,
                };
                OperatorKind::Filter(function.clone(), of, states)
            }
            OperatorKind::Reward(..) | OperatorKind::Multi(_) => return None,
        };
        Some(Operator { kind, ..operator.clone() })
    }

    fn known_formula(&mut self, formula: &Formula, rewards: &[usize]) -> Option<Formula> {
        let state = |own: &mut Self, e: &Expr| own.known(e, rewards).map(FormulaKind::State);
        self.replaced(formula, |own, bound| own.known(bound, rewards), state)
    }

    /// Returns a formula with other bounds and state formulas.
    fn replaced(
        &mut self,
        formula: &Formula,
        bound: impl Fn(&mut Self, &Expr) -> Option<Expr>,
        state: impl Fn(&mut Self, &Expr) -> Option<FormulaKind>,
    ) -> Option<Formula> {
        let mut formula = formula.clone();
        let mut open = vec![&mut formula];
        while let Some(part) = open.pop() {
            for own in part.bounds_mut() {
                *own = bound(self, own)?;
            }
            if let FormulaKind::State(e) = &part.kind {
                part.kind = state(self, e)?;
            }
            open.extend(part.operands_mut());
        }
        Some(formula)
    }
}

/// Returns the formula of a property that is one operator, its negation, its comparison or a filter over these.
fn reached(nodes: &[Node]) -> Option<&Formula> {
    match (&nodes.last()?.kind, parts(nodes).as_slice()) {
        (NodeKind::Operator(operator), _) => match &operator.kind {
            OperatorKind::Filter(_, of, _) => meliora_base::stack::level(|| reached(&of.nodes)),
            OperatorKind::Probability(_, formula)
            | OperatorKind::Reward(_, _, Accumulated::Until(formula)) => Some(formula),
            _ => None,
        },
        (NodeKind::Not, &[operand]) => meliora_base::stack::level(|| reached(operand)),
        (&NodeKind::Binary(op), &[a, b]) => {
            inequality(op)?;
            match (is_plain(a), is_plain(b)) {
                (false, true) => reached(a),
                (true, false) => reached(b),
                _ => None,
            }
        }
        _ => None,
    }
}

/// Returns whether an expression has no operators of properties and names no states that only properties name.
fn is_plain(nodes: &[Node]) -> bool {
    !nodes.iter().any(|node| matches!(node.kind, NodeKind::Operator(_) | NodeKind::Label(_)))
}

/// Returns the comparison that an operator makes, if it makes one of sizes.
fn inequality(op: BinaryOp) -> Option<Inequality> {
    Some(match op {
        BinaryOp::Ge => Inequality::Ge,
        BinaryOp::Gt => Inequality::Gt,
        BinaryOp::Le => Inequality::Le,
        BinaryOp::Lt => Inequality::Lt,
        _ => return None,
    })
}
