//! Ground conditions.

use super::database::Key;
use super::reach::every;
use super::{Atoms, Fact, Meaning};
use crate::task::{Condition, Object};

/// A condition over facts, simplified.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Ground {
    True,
    False,
    /// A fact holds, or does not.
    Fact(Fact, bool),
    /// A derived fact holds, or does not.
    Derived(u32, bool),
    And(Vec<Ground>),
    Or(Vec<Ground>),
}

impl Ground {
    /// Returns the conjunction, or the disjunction, simplified.
    pub(super) fn join(is_and: bool, parts: impl IntoIterator<Item = Ground>) -> Ground {
        let (neutral, absorbing) =
            if is_and { (Ground::True, Ground::False) } else { (Ground::False, Ground::True) };
        let mut flat = Vec::new();
        for part in parts {
            match part {
                part if part == neutral => {}
                part if part == absorbing => return absorbing,
                Ground::And(inner) if is_and => flat.extend(inner),
                Ground::Or(inner) if !is_and => flat.extend(inner),
                other => flat.push(other),
            }
        }
        flat.sort_unstable();
        flat.dedup();
        // Literals are sorted by their fact, so opposite ones are neighbours.
        let opposite = |pair: &[Ground]| match pair {
            [Ground::Fact(a, _), Ground::Fact(b, _)] | [Ground::Derived(a, _), Ground::Derived(b, _)] => {
                a == b
            }
            _ => false,
        };
        if flat.windows(2).any(opposite) {
            return absorbing;
        }
        match flat.pop() {
            None => neutral,
            Some(only) if flat.is_empty() => only,
            Some(last) => {
                flat.push(last);
                if is_and { Ground::And(flat) } else { Ground::Or(flat) }
            }
        }
    }

    /// Returns the parts of a conjunction; a condition that is none is its only part.
    pub(crate) fn parts(&self) -> &[Ground] {
        match self {
            Ground::True => &[],
            Ground::And(parts) => parts,
            other => std::slice::from_ref(other),
        }
    }

    /// Returns the facts that the condition requires, as far as its outer conjunction shows.
    pub(crate) fn required(&self) -> impl Iterator<Item = Fact> {
        self.parts().iter().filter_map(|part| match part {
            Ground::Fact(fact, true) => Some(*fact),
            _ => None,
        })
    }
}

impl Atoms {
    /// Returns a condition under values of its variables, simplified.
    pub(super) fn ground(&self, condition: &Condition, values: &mut Vec<Object>) -> Ground {
        match condition {
            Condition::Literal(atom, is_positive) => {
                let row: Key = atom.arguments.iter().map(|term| term.object(values)).collect();
                self.literal(atom.predicate, &row, *is_positive)
            }
            Condition::Equal(left, right, is_positive) => {
                truth((left.object(values) == right.object(values)) == *is_positive)
            }
            Condition::And(all) | Condition::Or(all) => {
                let is_and = matches!(condition, Condition::And(_));
                let absorbing = truth(!is_and);
                let mut parts = Vec::with_capacity(all.len());
                for part in all {
                    let part = self.ground(part, values);
                    if part == absorbing {
                        return absorbing;
                    }
                    parts.push(part);
                }
                Ground::join(is_and, parts)
            }
            Condition::All(domains, inner) | Condition::Some(domains, inner) => {
                let mut parts = Vec::new();
                every(domains, values, &mut |values| parts.push(self.ground(inner, &mut values.to_vec())));
                Ground::join(matches!(condition, Condition::All(..)), parts)
            }
        }
    }

    fn literal(&self, predicate: usize, row: &[Object], is_positive: bool) -> Ground {
        match self.get(predicate, row) {
            None => truth(!is_positive),
            Some(Meaning::True) => truth(is_positive),
            Some(Meaning::Fact(fact)) => Ground::Fact(fact, is_positive),
            Some(Meaning::Derived(derived)) => Ground::Derived(derived, is_positive),
        }
    }
}

fn truth(holds: bool) -> Ground {
    if holds { Ground::True } else { Ground::False }
}
