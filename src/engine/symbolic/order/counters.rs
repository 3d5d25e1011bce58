//! Counters, and the guards that test them, found in the expressions of commands.

use ahash::{AHashMap, AHashSet};

use meliora_base::value::Type;
use meliora_model::expr::{Binary, ExprId, Node};
use meliora_model::{Command, Program, VarId};

/// Returns the integer variables that some update changes by a sum or difference.
pub(super) fn counters(program: &Program, commands: &[&Command]) -> AHashSet<VarId> {
    let updates = commands.iter().flat_map(|c| &c.branches).flat_map(|b| &b.updates);
    let counted =
        updates.filter(|(v, e)| program.variables[v.index()].ty == Type::Int && counts(program, *v, *e));
    counted.map(|(v, _)| *v).collect()
}

/// Returns the counters that guards only compare by `<` and `<=`, or with an end of their range.
pub(super) fn thresholds(
    program: &Program,
    commands: &[&Command],
    counters: &AHashSet<VarId>,
) -> AHashSet<VarId> {
    let mut counters = counters.clone();
    // Shared subexpressions of guards are visited once.
    let mut seen = AHashSet::new();
    for command in commands {
        let mut stack = vec![command.guard];
        while let Some(e) = stack.pop() {
            if !seen.insert(e) {
                continue;
            }
            match program.pool.node(e) {
                Node::Binary(Binary::Eq, a, b) if is_inner(program, a, b) => {
                    for v in program.pool.support(e) {
                        counters.remove(&v);
                    }
                }
                Node::Binary(_, a, b) => stack.extend([a, b]),
                Node::Unary(_, a) => stack.push(a),
                Node::Ite(c, a, b) => stack.extend([c, a, b]),
                Node::Literal(_) | Node::Var(_) => {}
            }
        }
    }
    counters
}

/// Returns true if the value of the expression may be a sum or difference of the variable itself: below choices, `min`,
/// `max` and `mod`.
pub(super) fn counts(program: &Program, variable: VarId, e: ExprId) -> bool {
    let (mut stack, mut seen) = (vec![e], AHashSet::new());
    while let Some(e) = stack.pop() {
        if !seen.insert(e) {
            continue;
        }
        match program.pool.node(e) {
            Node::Binary(Binary::Add | Binary::Sub, a, b)
                if [a, b].iter().any(|&o| program.pool.node(o) == Node::Var(variable)) =>
            {
                return true;
            }
            Node::Binary(Binary::Min | Binary::Max | Binary::Mod, a, b) | Node::Ite(_, a, b) => {
                stack.extend([a, b]);
            }
            _ => {}
        }
    }
    false
}

/// Returns true if a variable counts the rounds of an outer loop: each branch that changes it adds a
/// constant, always of one sign, and sets another counter to a constant.
pub(super) fn is_stage(
    program: &Program,
    commands: &[&Command],
    counters: &AHashSet<VarId>,
    variable: VarId,
) -> bool {
    let mut signs = AHashSet::new();
    for branch in commands.iter().flat_map(|c| &c.branches) {
        let changes = |(v, e): &&(VarId, ExprId)| *v == variable && program.pool.node(*e) != Node::Var(*v);
        let Some(&(_, update)) = branch.updates.iter().find(changes) else { continue };
        let resets = |(v, e): &(VarId, ExprId)| {
            *v != variable && counters.contains(v) && program.pool.literal(*e).is_some()
        };
        let Some(grows) = grows(program, variable, update) else { return false };
        if !branch.updates.iter().any(resets) {
            return false;
        }
        signs.insert(grows);
    }
    signs.len() == 1
}

/// Returns true if all updates that add a constant to a variable add one of the same sign, and some do.
pub(super) fn is_one_way(program: &Program, commands: &[&Command], variable: VarId) -> bool {
    let updates = commands.iter().flat_map(|c| &c.branches).flat_map(|b| &b.updates);
    let own = updates.filter(|(v, _)| *v == variable).filter_map(|(v, e)| grows(program, *v, *e));
    own.collect::<AHashSet<bool>>().len() == 1
}

/// Returns whether an update adds a positive constant to a variable (true) or a negative one (false);
/// `None` for other updates.
fn grows(program: &Program, variable: VarId, update: ExprId) -> Option<bool> {
    let (adds, constant) = match program.pool.node(update) {
        Node::Binary(Binary::Add, a, b) if program.pool.node(a) == Node::Var(variable) => (true, b),
        Node::Binary(Binary::Add, a, b) if program.pool.node(b) == Node::Var(variable) => (true, a),
        Node::Binary(Binary::Sub, a, b) if program.pool.node(a) == Node::Var(variable) => (false, b),
        _ => return None,
    };
    let positive = program.pool.literal(constant)?.to_f64() > 0.0;
    Some(positive == adds)
}

/// Returns true if an equation compares something other than a variable and an end of its range:
/// two variables, or a variable and an inner value. Counters are not used that way.
fn is_inner(program: &Program, a: ExprId, b: ExprId) -> bool {
    let end = |v: ExprId, c: ExprId| match (program.pool.node(v), program.pool.literal(c)) {
        (Node::Var(v), Some(c)) => {
            let variable = &program.variables[v.index()];
            c.to_f64() == variable.low as f64 || c.to_f64() == variable.high as f64
        }
        _ => false,
    };
    !end(a, b) && !end(b, a)
}

pub(super) fn operands(node: Node) -> Vec<ExprId> {
    match node {
        Node::Literal(_) | Node::Var(_) => vec![],
        Node::Unary(_, a) => vec![a],
        Node::Binary(_, a, b) => vec![a, b],
        Node::Ite(c, a, b) => vec![c, a, b],
    }
}

/// Returns the variables of `among` that occur in an expression.
pub(super) fn support(
    program: &Program,
    e: ExprId,
    among: &[VarId],
    known: &mut AHashMap<ExprId, AHashSet<VarId>>,
) -> AHashSet<VarId> {
    // Operands come before the nodes built from them, without recursion: guards may be deep.
    let mut stack = vec![(e, false)];
    while let Some((e, ready)) = stack.pop() {
        if known.contains_key(&e) {
            continue;
        }
        match program.pool.node(e) {
            Node::Var(v) => drop(known.insert(e, among.iter().copied().filter(|w| *w == v).collect())),
            node if ready => {
                let parts = operands(node);
                let all = parts.iter().filter_map(|p| known.get(p)).flatten().copied().collect();
                known.insert(e, all);
            }
            node => {
                stack.push((e, true));
                stack.extend(operands(node).into_iter().map(|p| (p, false)));
            }
        }
    }
    known.get(&e).cloned().unwrap_or_default()
}
