//! Counters, and the variables of guards, found in the expressions of commands.

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

/// Returns true if the value of the expression may be a sum or difference of the variable itself: below choices, `min`,
/// `max` and `mod`.
fn counts(program: &Program, variable: VarId, e: ExprId) -> bool {
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
            _ if ready => {
                let parts = program.pool.operands(e);
                let all = parts.filter_map(|p| known.get(&p)).flatten().copied().collect();
                known.insert(e, all);
            }
            _ => {
                stack.push((e, true));
                stack.extend(program.pool.operands(e).map(|p| (p, false)));
            }
        }
    }
    known.get(&e).cloned().unwrap_or_default()
}
