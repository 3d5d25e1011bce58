//! Properties without the parts that say nothing, so that an operator in them is recognised however it is written:
//! `!!(P>=1 [ φ ])`, `true & P>=1 [ φ ]`, `!(P<1 [ φ ])`.

use super::Inequality;
use super::term::{Filter, Term, TermKind};
use meliora_base::value::Value;

/// Returns a property with the same value in each state: without double negations, without constants in joins, and
/// with the opposite bound in place of the negation of an operator.
pub(super) fn simplified(term: Term) -> Term {
    let Term { kind, ty, span } = term;
    let kind = match kind {
        TermKind::Not(operand) => match simplified(*operand).kind {
            TermKind::Not(operand) => operand.kind,
            TermKind::Operator(mut measured) => {
                match &mut measured.bound {
                    Some((comparison, _)) => *comparison = negated(*comparison),
                    None => return Term { kind: TermKind::Operator(measured), ty, span },
                }
                TermKind::Operator(measured)
            }
            kind => TermKind::Not(Box::new(Term { kind, ty, span })),
        },
        TermKind::Join(all, parts) => {
            let mut parts: Vec<Term> = parts.into_iter().map(simplified).collect();
            let last = parts.pop();
            parts.retain(|part| part.constant() != Some(all));
            // One part is left, whatever its value is.
            parts.extend(last.filter(|last| parts.is_empty() || last.constant() != Some(all)));
            match parts.pop() {
                Some(only) if parts.is_empty() => only.kind,
                last => {
                    parts.extend(last);
                    TermKind::Join(all, parts)
                }
            }
        }
        TermKind::Filter(filter) => {
            let Filter { function, of, states } = *filter;
            TermKind::Filter(Box::new(Filter { function, of: simplified(of), states }))
        }
        kind => kind,
    };
    Term { kind, ty, span }
}

impl Term {
    /// Returns the truth of a condition that is `true` or `false`.
    fn constant(&self) -> Option<bool> {
        let TermKind::State(predicate) = &self.kind else { return None };
        match predicate.pool().literal(predicate.id()) {
            Some(Value::Bool(truth)) => Some(truth),
            _ => None,
        }
    }
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
