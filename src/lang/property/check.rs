//! The checker of properties: names, types and bounds.

use std::sync::Arc;

use super::operators::{Accumulated, Operator, OperatorKind};
use super::strategies::Strategies;
use super::term::{self, Filter, FilterFunction, Measure, Measured, TermKind};
use super::{Named, Term};
use crate::ast::{BinaryOp, Expr, Function, Node, NodeKind, Span};
use crate::check::lower_value;
use meliora_base::error::{Diagnostic, Error, Result, SourceFile};
use meliora_base::exact::Exact;
use meliora_base::stack;
use meliora_base::value::Type;
use meliora_model::Program;
use meliora_model::predicate::Predicates;

/// Checks properties of one text.
pub(crate) struct Checker<'a> {
    pub(super) program: &'a Program,
    pub(super) source: &'a Arc<SourceFile>,
    named: &'a Named,
    pub(super) predicates: Predicates,
    /// The names of the properties that are being checked.
    open: Vec<String>,
}

impl<'a> Checker<'a> {
    pub(crate) fn new(program: &'a Program, source: &'a Arc<SourceFile>, named: &'a Named) -> Self {
        Checker { program, source, named, predicates: Predicates::over(program), open: Vec::new() }
    }

    pub(super) fn wrong(&self, span: Span, message: impl Into<String>) -> Diagnostic {
        Diagnostic::new(self.source, span.range(), message)
    }

    /// Returns whether a node is an operator, or refers to a property.
    fn is_nested(&self, node: &Node) -> bool {
        match &node.kind {
            NodeKind::Operator(_) => true,
            NodeKind::Label(name) => self.refers(name),
            _ => false,
        }
    }

    fn refers(&self, name: &str) -> bool {
        let is_label = || self.program.labels.iter().any(|(label, _)| label == name);
        self.named.contains_key(name) && !is_label()
    }

    /// Returns whether an expression has operators of properties.
    pub(super) fn has_operators(&self, e: &Expr) -> bool {
        e.nodes.iter().any(|node| self.is_nested(node))
    }

    pub(super) fn term(&mut self, e: &Expr) -> Result<Term> {
        stack::level(|| self.part(&e.nodes))
    }

    /// Checks a condition.
    pub(super) fn condition(&mut self, e: &Expr) -> Result<Term> {
        let term = self.term(e)?;
        self.typed(term, true)
    }

    /// Checks that a term is a condition, or a number.
    fn typed(&self, term: Term, condition: bool) -> Result<Term> {
        if term.is_condition() == condition {
            return Ok(term);
        }
        let (wanted, found) =
            if condition { ("a condition", "a number") } else { ("a number", "a condition") };
        Err(self.wrong(term.span, format!("type error: expected {wanted}")).label(found).into())
    }

    /// Checks a part of an expression, which ends with its root.
    fn part(&mut self, nodes: &[Node]) -> Result<Term> {
        let Some(root) = nodes.last() else { return Err(Error::Usage("an empty expression".to_owned())) };
        let span = root.span;
        if !nodes.iter().any(|node| self.is_nested(node)) {
            let e = Expr { nodes: nodes.to_vec() };
            let id = lower_value(self.program, self.predicates.pool(), self.source, &e)?;
            let ty = self.predicates.pool().ty(id);
            return Ok(Term { kind: TermKind::State(self.predicates.get(id)), ty, span });
        }
        match &root.kind {
            NodeKind::Operator(operator) => self.operator(operator),
            NodeKind::Label(name) => self.reference(name, span),
            kind => {
                let mut operands = Vec::new();
                for part in parts(nodes) {
                    operands.push(stack::level(|| self.part(part))?);
                }
                self.combined(kind, operands, span)
            }
        }
    }

    /// Checks the property that a name refers to.
    fn reference(&mut self, name: &str, span: Span) -> Result<Term> {
        if self.open.iter().any(|open| open == name) {
            let message = format!("the property \"{name}\" refers to itself");
            return Err(self.wrong(span, message).label("its own value is needed here").into());
        }
        let Some(property) = self.named.get(name) else {
            return Err(Error::Usage(format!("unknown property \"{name}\"")));
        };
        self.open.push(name.to_owned());
        let term = self.term(&property.expression);
        self.open.pop();
        Ok(Term { span, ..term? })
    }

    /// Checks the operands of an operator of expressions.
    fn combined(&mut self, kind: &NodeKind, operands: Vec<Term>, span: Span) -> Result<Term> {
        let of = |kind, ty| Ok(Term { kind, ty, span });
        match kind {
            NodeKind::Not => {
                let [a] = self.all_typed(operands, true)?;
                of(TermKind::Not(Box::new(a)), Type::Bool)
            }
            NodeKind::Neg => {
                let [a] = self.all_typed(operands, false)?;
                let ty = a.ty;
                of(TermKind::Neg(Box::new(a)), ty)
            }
            NodeKind::Join(op, _) => {
                let all = operands.into_iter().map(|a| self.typed(a, true)).collect::<Result<_>>()?;
                of(TermKind::Join(*op == BinaryOp::And, all), Type::Bool)
            }
            NodeKind::Binary(op) => self.binary(*op, operands, span),
            NodeKind::Ite => {
                let [c, a, b] = exactly(operands)?;
                let c = self.typed(c, true)?;
                let b = self.typed(b, a.is_condition())?;
                let ty = joined(a.ty, b.ty);
                of(TermKind::Ite(Box::new([c, a, b])), ty)
            }
            NodeKind::Call(name, _) => match Function::named(&name.name) {
                Some(function) => self.function(function, operands, span),
                None => Err(self.wrong(name.span, format!("unknown function `{}`", name.name)).into()),
            },
            NodeKind::Apply(function, _) => self.function(*function, operands, span),
            _ => Err(self.wrong(span, "an operator of properties cannot stand here").into()),
        }
    }

    fn binary(&mut self, op: BinaryOp, operands: Vec<Term>, span: Span) -> Result<Term> {
        let [a, b] = exactly(operands)?;
        let (op, condition) = match op {
            BinaryOp::Eq | BinaryOp::Ne if a.is_condition() => (op, true),
            BinaryOp::Implies | BinaryOp::Iff | BinaryOp::And | BinaryOp::Or => (op, true),
            _ => (op, false),
        };
        let (a, b) = (self.typed(a, condition)?, self.typed(b, condition)?);
        let ty = match op {
            BinaryOp::Add | BinaryOp::Sub | BinaryOp::Mul | BinaryOp::Pow => joined(a.ty, b.ty),
            BinaryOp::Div => Type::Real,
            _ => Type::Bool,
        };
        let both = Box::new([a, b]);
        if condition && matches!(op, BinaryOp::Eq | BinaryOp::Ne) {
            let same = Term { kind: TermKind::Binary(BinaryOp::Iff, both), ty, span };
            let kind = if op == BinaryOp::Eq { same.kind } else { TermKind::Not(Box::new(same)) };
            return Ok(Term { kind, ty, span });
        }
        Ok(Term { kind: TermKind::Binary(op, both), ty, span })
    }

    fn function(&mut self, function: Function, operands: Vec<Term>, span: Span) -> Result<Term> {
        let (wanted, ty) = match function {
            Function::Min | Function::Max => {
                (operands.len().max(1), operands.iter().fold(Type::Int, |ty, a| joined(ty, a.ty)))
            }
            Function::Floor | Function::Ceil | Function::Round => (1, Type::Int),
            Function::Pow => (2, operands.iter().fold(Type::Int, |ty, a| joined(ty, a.ty))),
            Function::Mod => (2, Type::Int),
            Function::Log => (2, Type::Real),
            _ => (1, operands.first().map_or(Type::Real, |a| a.ty)),
        };
        if operands.len() != wanted {
            let message = format!("the function has {} arguments, not {wanted}", operands.len());
            return Err(self.wrong(span, message).into());
        }
        let all = operands.into_iter().map(|a| self.typed(a, false)).collect::<Result<_>>()?;
        Ok(Term { kind: TermKind::Apply(function, all), ty, span })
    }

    fn all_typed<const N: usize>(&self, operands: Vec<Term>, condition: bool) -> Result<[Term; N]> {
        exactly(operands.into_iter().map(|a| self.typed(a, condition)).collect::<Result<_>>()?)
    }

    fn operator(&mut self, operator: &Operator) -> Result<Term> {
        let span = operator.span;
        let measured = match &operator.kind {
            OperatorKind::Filter(function, of, states) => {
                self.without_players(operator)?;
                return self.filter(function, of, states.as_ref(), span);
            }
            OperatorKind::Multi(all) => {
                self.without_players(operator)?;
                return self.multi(all, span);
            }
            OperatorKind::Paths(all, formula) => {
                self.without_players(operator)?;
                let path = Box::new(self.path(formula)?);
                return Ok(Term { kind: TermKind::Paths(*all, path), ty: Type::Bool, span });
            }
            OperatorKind::Probability(asked, formula) => {
                let strategies = self.strategies(operator, asked, true)?;
                (strategies, Measure::Probability(Box::new(self.path(formula)?)))
            }
            OperatorKind::LongRun(asked, states) => {
                let strategies = self.strategies(operator, asked, true)?;
                (strategies, Measure::LongRun(self.condition(states)?))
            }
            OperatorKind::Reward(rewards, asked, accumulated) => {
                self.known_rewards(rewards, operator.head)?;
                let strategies = self.strategies(operator, asked, false)?;
                (strategies, Measure::Reward(rewards.clone(), self.accumulated(accumulated)?))
            }
        };
        let (strategies, measure) = measured;
        let optimum = self.sure_optimum(&strategies, operator)?;
        let Strategies { coalition, bound, .. } = strategies;
        let ty = if bound.is_some() { Type::Bool } else { Type::Real };
        let measured = Measured { coalition, measure, optimum, bound };
        Ok(Term { kind: TermKind::Operator(Box::new(measured)), ty, span })
    }

    fn without_players(&self, operator: &Operator) -> Result<()> {
        match &operator.coalition {
            Some(coalition) => {
                let message = "players choose for `P`, `R` and `S` alone";
                Err(self.wrong(coalition.span, message).help("write `<<p1>> P>=1 [ … ]`").into())
            }
            None => Ok(()),
        }
    }

    fn accumulated(&mut self, accumulated: &Accumulated) -> Result<term::Accumulated> {
        Ok(match accumulated {
            Accumulated::Until(formula) => term::Accumulated::Until(Box::new(self.path(formula)?)),
            Accumulated::Anyway(states) => term::Accumulated::Anyway(self.condition(states)?),
            Accumulated::IfReached(states) => term::Accumulated::IfReached(self.condition(states)?),
            Accumulated::Within(steps) => term::Accumulated::Within(self.steps(steps)?),
            Accumulated::Total => term::Accumulated::Total,
            Accumulated::At(steps) => term::Accumulated::At(self.steps(steps)?),
            Accumulated::LongRun => term::Accumulated::LongRun,
        })
    }

    /// Returns the value of an expression without variables.
    pub(super) fn constant(&mut self, e: &Expr) -> Result<Option<Exact>> {
        if self.has_operators(e) {
            return Ok(None);
        }
        let id = lower_value(self.program, self.predicates.pool(), self.source, e)?;
        Ok(self.predicates.pool().exact_literal(id))
    }

    /// Returns a number of steps.
    pub(super) fn steps(&mut self, e: &Expr) -> Result<u64> {
        if let Some(Exact::Int(steps)) = self.constant(e)?
            && let Ok(steps) = u64::try_from(steps)
        {
            return Ok(steps);
        }
        let message = "a number of steps must be a constant of type `int`, and cannot be negative";
        Err(self.wrong(e.span(), message).into())
    }

    fn filter(
        &mut self,
        name: &crate::ast::Ident,
        of: &Expr,
        states: Option<&Expr>,
        span: Span,
    ) -> Result<Term> {
        let Ok(function) = name.name.parse::<FilterFunction>() else {
            let message = format!("unknown function `{}` of a filter", name.name);
            let help = "the functions are min, max, sum, avg, count, range, forall, exists, state, first, argmin, \
                argmax, print and printall";
            return Err(self.wrong(name.span, message).help(help).into());
        };
        let of = self.term(of)?;
        use FilterFunction::*;
        let of = match function {
            Count | Forall | Exists => self.typed(of, true)?,
            Min | Max | Sum | Avg | Range | Argmin | Argmax => self.typed(of, false)?,
            State | First | Print | Printall => of,
        };
        let ty = match function {
            Argmin | Argmax | Forall | Exists => Type::Bool,
            Count => Type::Int,
            Avg => Type::Real,
            _ => of.ty,
        };
        let states = states.map(|states| self.condition(states)).transpose()?;
        Ok(Term { kind: TermKind::Filter(Box::new(Filter { function, of, states })), ty, span })
    }

    fn multi(&mut self, all: &[Expr], span: Span) -> Result<Term> {
        let terms = all.iter().map(|e| self.term(e)).collect::<Result<Vec<_>>>()?;
        if let Some(other) = terms.iter().find(|term| !matches!(term.kind, TermKind::Operator(_))) {
            let message =
                "the objectives of `multi` are operators such as `P>=0.5 [ … ]` or `R{…}max=? [ C ]`";
            return Err(self.wrong(other.span, message).into());
        }
        let ty = if terms.iter().all(Term::is_condition) { Type::Bool } else { Type::Real };
        Ok(Term { kind: TermKind::Multi(terms), ty, span })
    }
}

/// Returns the operands of the root of an expression in post-order.
pub(crate) fn parts(nodes: &[Node]) -> Vec<&[Node]> {
    let mut starts: Vec<usize> = Vec::with_capacity(nodes.len());
    let mut open: Vec<usize> = Vec::new();
    for (at, node) in nodes.iter().enumerate() {
        let first = open.len().saturating_sub(node.kind.operands());
        let start = open.get(first).copied().unwrap_or(at);
        open.truncate(first);
        open.push(start);
        starts.push(start);
    }
    let (mut end, mut all) = (nodes.len().saturating_sub(1), Vec::new());
    while end > 0 {
        all.push(&nodes[starts[end - 1]..end]);
        end = starts[end - 1];
    }
    all.reverse();
    all
}

fn exactly<const N: usize>(operands: Vec<Term>) -> Result<[Term; N]> {
    operands.try_into().map_err(|_| Error::Usage("an operator has another number of operands".to_owned()))
}

/// Returns the type of a value of one of two types.
fn joined(a: Type, b: Type) -> Type {
    if a == b { a } else { Type::Real }
}
