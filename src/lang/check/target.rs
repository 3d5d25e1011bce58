//! Targets: expressions over a finished program, with its labels.

use std::borrow::Cow;
use std::sync::Arc;

use ahash::AHashMap;

use super::lowerer::Lowerer;
use super::scope::{NO_RENAMING, Scope, Symbol};
use crate::ast::{BinaryOp, Expr, Node, NodeKind, Span};
use crate::atoms;
use meliora_base::error::{Error, Result, SourceFile};
use meliora_base::progress::NoProgress;
use meliora_base::value::Value;
use meliora_model::expr::{Binary, ExprId, ExprPool, Unary};
use meliora_model::planning::Named;
use meliora_model::predicate::{Predicate, Predicates};
use meliora_model::{Program, VarId};

/// The label of the states in which no command is enabled.
const DEADLOCK: &str = "deadlock";

/// Checks a target, such as that of an objective. Names are the variables, constants and formulas of
/// the model. Names in quotes are its labels, "init" (the initial states) and "deadlock" (no command
/// is enabled).
///
/// # Errors
/// Unknown names and wrong types; the target must be of type `bool`.
pub fn lower_target(program: &Program, source: &Arc<SourceFile>, target: &Expr) -> Result<Predicate> {
    let mut predicates = Predicates::over(program);
    let id = lower_condition(program, predicates.pool(), source, target)?;
    Ok(predicates.get(id))
}

/// Same as [`lower_target`], in a pool with the expressions of the program.
///
/// # Errors
/// Unknown names and wrong types.
pub(crate) fn lower_condition(
    program: &Program,
    pool: &mut ExprPool,
    source: &Arc<SourceFile>,
    target: &Expr,
) -> Result<ExprId> {
    let target = &*with_names(program, source, target);
    lowered(program, pool, target, source, |lowerer| lowerer.condition(target, NO_RENAMING, "a target"))
}

/// Same as [`lower_condition`], for an expression of any type.
///
/// # Errors
/// Unknown names and wrong types.
pub(crate) fn lower_value(
    program: &Program,
    pool: &mut ExprPool,
    source: &Arc<SourceFile>,
    value: &Expr,
) -> Result<ExprId> {
    let value = &*with_names(program, source, value);
    lowered(program, pool, value, source, |lowerer| {
        let id = lowerer.expr(value, NO_RENAMING)?;
        lowerer.whole(id, value.span())
    })
}

/// Lowers an expression over a finished program into a pool with its expressions. The condition of the
/// label "deadlock" is as large as the program, and made only where it is needed.
fn lowered(
    program: &Program,
    pool: &mut ExprPool,
    expression: &Expr,
    source: &Arc<SourceFile>,
    lower: impl FnOnce(&mut Lowerer<'_>) -> Option<ExprId>,
) -> Result<ExprId> {
    let scope = scope(program, pool);
    let mut lowerer = Lowerer::new(source, scope, std::mem::take(pool), &NoProgress);
    let mut labels: AHashMap<String, ExprId> = program.labels.iter().cloned().collect();
    labels.insert("init".to_owned(), program.initial);
    let is_deadlock = |node: &Node| matches!(&node.kind, NodeKind::Label(name) if **name == *DEADLOCK);
    let with_deadlock = expression.nodes.iter().any(is_deadlock);
    // Errors list the label in any case.
    let deadlock = if with_deadlock { deadlock(program, &mut lowerer) } else { Some(program.initial) };
    labels.extend(deadlock.map(|deadlock| (DEADLOCK.to_owned(), deadlock)));
    labels.extend(named_values(program, &mut lowerer.pool));
    labels.extend(named_atoms(program, expression, &mut lowerer.pool));
    lowerer.labels = Some(labels);
    let lowered = lower(&mut lowerer);
    *pool = lowerer.pool;
    pool.inexact = pool.inexact.take().or(lowerer.inexact);
    lowered.ok_or(Error::Input(lowerer.diagnostics))
}

/// Returns the names of a finished program.
fn scope(program: &Program, pool: &mut ExprPool) -> Scope<'static> {
    let mut scope = Scope::default();
    let mut add = |name: &str, symbol| {
        scope.symbols.insert(Cow::Owned(name.to_owned()), (symbol, Span::default()));
    };
    for (name, value) in &program.constants {
        add(name, Symbol::Expression(pool.exact_value(value.clone())));
    }
    for (name, id) in &program.formulas {
        add(name, Symbol::Expression(*id));
    }
    for (index, variable) in program.variables.iter().enumerate() {
        let id = VarId(u32::try_from(index).unwrap_or(u32::MAX));
        add(&variable.name, Symbol::Variable(id, variable.ty));
    }
    scope
}

/// Returns a label `"variable=value"` for each named value; values of locations have names.
fn named_values(program: &Program, pool: &mut ExprPool) -> Vec<(String, ExprId)> {
    let mut all = Vec::new();
    for (id, variable) in program.variable_ids().zip(&program.variables) {
        for (value, name) in (variable.low..).zip(&variable.values) {
            let (of, value) = (pool.var(id, variable.ty), pool.value(Value::Int(value)));
            all.push((format!("{}={name}", variable.name), pool.binary(Binary::Eq, of, value)));
        }
    }
    all
}

/// Returns an expression with labels in place of the atoms of a planning problem, and numbers in place of
/// the names of values.
fn with_names<'e>(program: &Program, source: &Arc<SourceFile>, expression: &'e Expr) -> Cow<'e, Expr> {
    let mut expression = match &program.planning {
        Some(planning) => Cow::Owned(atoms::as_labels(expression, source, planning)),
        None => Cow::Borrowed(expression),
    };
    for at in 2..expression.nodes.len() {
        if let Some(value) = value_named(program, &expression.nodes[at - 2..=at]) {
            expression.to_mut().nodes[at - 1].kind = NodeKind::Literal(Value::Int(value));
        }
    }
    expression
}

/// Returns the number of a value in a comparison `variable = name`, unless the name has another meaning.
fn value_named(program: &Program, nodes: &[Node]) -> Option<i64> {
    let [NodeKind::Name(variable), NodeKind::Name(value), NodeKind::Binary(BinaryOp::Eq | BinaryOp::Ne)] =
        [&nodes[0].kind, &nodes[1].kind, &nodes[2].kind]
    else {
        return None;
    };
    let is_known = |name: &str| {
        program.variables.iter().any(|v| v.name == name)
            || program.constants.iter().any(|(known, _)| known == name)
            || program.formulas.iter().any(|(known, _)| known == name)
    };
    if is_known(value) {
        return None;
    }
    let variable = program.variables.iter().find(|v| *v.name == **variable)?;
    (variable.low..).zip(&variable.values).find_map(|(number, name)| (**name == **value).then_some(number))
}

/// Returns a label for each atom of a planning problem in an expression.
fn named_atoms(program: &Program, expression: &Expr, pool: &mut ExprPool) -> Vec<(String, ExprId)> {
    let Some(planning) = &program.planning else { return Vec::new() };
    let mut all = Vec::new();
    for node in &expression.nodes {
        let NodeKind::Label(name) = &node.kind else { continue };
        match planning.named(name) {
            Some(Named::Atom(id)) => all.push((name.to_string(), id)),
            Some(Named::Never) => all.push((name.to_string(), pool.value(Value::Bool(false)))),
            None => {}
        }
    }
    all
}

/// Returns the condition that no synchronisation has an enabled command in each of its factors.
fn deadlock(program: &Program, lowerer: &mut Lowerer<'_>) -> Option<ExprId> {
    let here = Span::default();
    let mut some = Vec::new();
    for synchronisation in &program.synchronisations {
        let mut all = Vec::new();
        for factor in &synchronisation.factors {
            let guards: Vec<_> = factor.iter().map(|c| (program.commands[c.index()].guard, here)).collect();
            all.push((lowerer.balanced(BinaryOp::Or, guards)?, here));
        }
        some.push((lowerer.balanced(BinaryOp::And, all)?, here));
    }
    let enabled = lowerer.balanced(BinaryOp::Or, some)?;
    Some(lowerer.pool.unary(Unary::Not, enabled))
}
