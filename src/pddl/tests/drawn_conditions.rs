//! Conditions of drawn tasks: their text, and their values by definition.

use std::collections::BTreeSet;

use super::drawn::{Atom, OBJECTS, State, TYPES};

/// The predicates that effects change or a rule defines, and the facts of all others, which do not change.
pub(super) struct Fixed {
    pub(super) changed: BTreeSet<&'static str>,
    pub(super) initial: State,
}

#[derive(Debug, Clone)]
pub(super) enum Cond {
    Atom(&'static str, Vec<usize>),
    Equal(usize, usize),
    Not(Box<Cond>),
    And(Vec<Cond>),
    Or(Vec<Cond>),
    Imply(Box<Cond>, Box<Cond>),
    All(usize, Box<Cond>),
    Some(usize, Box<Cond>),
}

/// A condition of an outcome, whose free variables have values. Equal ones are the same condition, whatever
/// the names of their variables: those of quantifiers are numbered after the objects, from the outside.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Closed {
    Atom(&'static str, Vec<usize>, bool),
    Equal(usize, usize, bool),
    And(Vec<Closed>),
    Or(Vec<Closed>),
    All(usize, Box<Closed>),
    Some(usize, Box<Closed>),
}

/// Returns the object of an argument: the variables in scope come first, then the objects.
pub(super) fn object(argument: usize, scope: &[usize]) -> usize {
    let at = argument % (scope.len() + OBJECTS.len());
    scope.get(at).copied().unwrap_or_else(|| at - scope.len())
}

pub(super) fn name(argument: usize, scope: usize) -> String {
    let at = argument % (scope + OBJECTS.len());
    if at < scope { format!("?v{at}") } else { OBJECTS[at - scope].to_owned() }
}

pub(super) fn names(arguments: &[usize], scope: usize) -> String {
    arguments.iter().map(|&argument| format!(" {}", name(argument, scope))).collect()
}

impl Cond {
    pub(super) fn text(&self, scope: usize) -> String {
        let list = |all: &[Cond]| all.iter().map(|c| format!(" {}", c.text(scope))).collect::<String>();
        match self {
            Cond::Atom(name, arguments) => format!("({name}{})", names(arguments, scope)),
            Cond::Equal(x, y) => format!("(= {} {})", name(*x, scope), name(*y, scope)),
            Cond::Not(inner) => format!("(not {})", inner.text(scope)),
            Cond::And(all) => format!("(and{})", list(all)),
            Cond::Or(all) => format!("(or{})", list(all)),
            Cond::Imply(x, y) => format!("(imply {} {})", x.text(scope), y.text(scope)),
            Cond::All(of, inner) => {
                format!("(forall (?v{scope} - {}) {})", TYPES[*of].0, inner.text(scope + 1))
            }
            Cond::Some(of, inner) => {
                format!("(exists (?v{scope} - {}) {})", TYPES[*of].0, inner.text(scope + 1))
            }
        }
    }

    pub(super) fn holds(&self, state: &State, scope: &mut Vec<usize>) -> bool {
        match self {
            Cond::Atom(name, arguments) => {
                state.contains(&(name, arguments.iter().map(|&x| object(x, scope)).collect()))
            }
            Cond::Equal(x, y) => object(*x, scope) == object(*y, scope),
            Cond::Not(inner) => !inner.holds(state, scope),
            Cond::And(all) => all.iter().all(|c| c.holds(state, scope)),
            Cond::Or(all) => all.iter().any(|c| c.holds(state, scope)),
            Cond::Imply(x, y) => !x.holds(state, scope) || y.holds(state, scope),
            Cond::All(of, inner) => TYPES[*of].1.iter().all(|&o| inner.under(o, state, scope)),
            Cond::Some(of, inner) => TYPES[*of].1.iter().any(|&o| inner.under(o, state, scope)),
        }
    }

    fn under(&self, object: usize, state: &State, scope: &[usize]) -> bool {
        self.holds(state, &mut scope.iter().copied().chain([object]).collect())
    }

    /// Returns the condition, or its negation, under values of the variables; `inner` quantifiers are open.
    pub(super) fn closed(&self, values: &[usize], inner: usize, is_positive: bool) -> Closed {
        let number = |argument: usize| match argument % (values.len() + inner + OBJECTS.len()) {
            at if at < values.len() => values[at],
            at if at < values.len() + inner => at - values.len() + OBJECTS.len(),
            at => at - values.len() - inner,
        };
        let each = |all: &[Cond]| all.iter().map(|c| c.closed(values, inner, is_positive)).collect();
        let under = |c: &Cond| Box::new(c.closed(values, inner + 1, is_positive));
        // `object` and `(either s t)` are the same objects.
        let of = |of: usize| of.min(2);
        match self {
            Cond::Atom(name, arguments) => {
                Closed::Atom(name, arguments.iter().map(|&x| number(x)).collect(), is_positive)
            }
            Cond::Equal(x, y) => Closed::Equal(number(*x), number(*y), is_positive),
            Cond::Not(c) => c.closed(values, inner, !is_positive),
            Cond::And(all) => Closed::join(is_positive, each(all)),
            Cond::Or(all) => Closed::join(!is_positive, each(all)),
            Cond::Imply(x, y) => {
                let parts = vec![x.closed(values, inner, !is_positive), y.closed(values, inner, is_positive)];
                Closed::join(!is_positive, parts)
            }
            Cond::All(t, c) if is_positive => Closed::All(of(*t), under(c)),
            Cond::Some(t, c) if !is_positive => Closed::All(of(*t), under(c)),
            Cond::All(t, c) | Cond::Some(t, c) => Closed::Some(of(*t), under(c)),
        }
    }
}

impl Closed {
    /// Returns a conjunction or a disjunction, of which the parts of the same kind are parts themselves.
    fn join(is_and: bool, parts: Vec<Closed>) -> Closed {
        let flat = |part| match part {
            Closed::And(parts) if is_and => parts,
            Closed::Or(parts) if !is_and => parts,
            other => vec![other],
        };
        let parts = parts.into_iter().flat_map(flat).collect();
        if is_and { Closed::And(parts) } else { Closed::Or(parts) }
    }

    pub(super) fn holds(&self, state: &State) -> bool {
        self.evaluate(&mut Vec::new(), &|atom, is_positive| state.contains(atom) == is_positive)
    }

    /// Returns whether the condition may hold, by the facts that nothing changes.
    pub(super) fn may_hold(&self, fixed: &Fixed) -> bool {
        self.evaluate(&mut Vec::new(), &|atom, is_positive| {
            fixed.changed.contains(atom.0) || fixed.initial.contains(atom) == is_positive
        })
    }

    fn evaluate(&self, inner: &mut Vec<usize>, literal: &dyn Fn(&Atom, bool) -> bool) -> bool {
        let object =
            |x: &usize, inner: &[usize]| if *x < OBJECTS.len() { *x } else { inner[*x - OBJECTS.len()] };
        let mut under = |objects: &[usize], closed: &Closed, all: bool| {
            let mut each = objects.iter().map(|&o| {
                inner.push(o);
                let holds = closed.evaluate(inner, literal);
                inner.pop();
                holds
            });
            if all { each.all(|holds| holds) } else { each.any(|holds| holds) }
        };
        match self {
            Closed::All(of, closed) => under(TYPES[*of].1, closed, true),
            Closed::Some(of, closed) => under(TYPES[*of].1, closed, false),
            Closed::Atom(name, arguments, is_positive) => {
                literal(&(name, arguments.iter().map(|x| object(x, inner)).collect()), *is_positive)
            }
            Closed::Equal(x, y, is_positive) => (object(x, inner) == object(y, inner)) == *is_positive,
            Closed::And(all) => all.iter().all(|c| c.evaluate(inner, literal)),
            Closed::Or(all) => all.iter().any(|c| c.evaluate(inner, literal)),
        }
    }
}
