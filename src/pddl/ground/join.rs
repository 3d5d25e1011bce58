//! Rules, and the plans by which their bodies are joined.

use std::sync::Arc;

use super::database::{Key, Range, Relation};
use crate::task::{Atom, Condition, Domain, Object, Term};
use meliora_base::error::Limit;
use meliora_base::progress::Poll;

/// A rule: the head holds for all values of the variables under which the body does.
pub(super) struct Rule {
    /// The domains of the variables.
    pub(super) variables: Vec<Arc<Domain>>,
    pub(super) head: Atom,
    /// Atoms that are joined.
    pub(super) body: Vec<Atom>,
    /// Literals over predicates that do not change, and equations.
    pub(super) filters: Vec<Condition>,
    /// Other conditions, which are checked last and again in later rounds.
    pub(super) rest: Vec<Condition>,
}

/// A step of a plan.
enum Step {
    /// Joins an atom of the body.
    Join {
        predicate: usize,
        range: Range,
        /// The index by the columns whose values are known; `None` if none is.
        index: Option<usize>,
        /// The terms of these columns.
        key: Vec<Term>,
        /// The other columns: each gives its variable a value, or repeats one.
        others: Vec<(usize, usize, bool)>,
    },
    /// Gives a variable all values of its domain.
    Enumerate(usize),
    /// Checks a filter.
    Filter(usize),
}

/// An order in which the body of a rule is joined.
pub(super) struct Plan(Vec<Step>);

impl Plan {
    /// Plans a rule, with the rows of the last round for one atom of the body, or all rows for all atoms.
    pub(super) fn new(rule: &Rule, delta: Option<usize>, relations: &mut [Relation]) -> Self {
        let mut bound = vec![false; rule.variables.len()];
        let (mut steps, mut open): (_, Vec<usize>) = (Vec::new(), (0..rule.body.len()).collect());
        let mut filters: Vec<usize> = (0..rule.filters.len()).collect();
        filter(rule, &bound, &mut filters, &mut steps);
        while !open.is_empty() {
            let first = delta.filter(|at| open.contains(at));
            let next = first.unwrap_or_else(|| cheapest(rule, &open, &bound, relations));
            open.retain(|&at| at != next);
            let range = match delta {
                Some(at) if at == next => Range::Delta,
                Some(at) if next < at => Range::Old,
                _ => Range::All,
            };
            steps.push(join(&rule.body[next], range, &mut bound, relations));
            filter(rule, &bound, &mut filters, &mut steps);
        }
        for variable in 0..bound.len() {
            if !bound[variable] {
                bound[variable] = true;
                steps.push(Step::Enumerate(variable));
                filter(rule, &bound, &mut filters, &mut steps);
            }
        }
        Plan(steps)
    }

    /// Calls a function for all values of the variables that satisfy the body and the filters.
    ///
    /// # Errors
    /// A limit.
    pub(super) fn run(
        &self,
        rule: &Rule,
        relations: &[Relation],
        poll: &mut Poll<'_>,
        found: &mut dyn FnMut(&[Object]),
    ) -> Result<(), Limit> {
        let values = vec![0; rule.variables.len()];
        let mut run = Run { rule, steps: &self.0, relations, poll, found, values };
        run.step(0)
    }
}

/// Adds the filters whose variables have values.
fn filter(rule: &Rule, bound: &[bool], open: &mut Vec<usize>, steps: &mut Vec<Step>) {
    let is_bound =
        |term: &Term| matches!(term, Term::Object(_)) || matches!(term, Term::Variable(v) if bound[*v]);
    let is_ready = |&at: &usize| match &rule.filters[at] {
        Condition::Literal(atom, _) => atom.arguments.iter().all(is_bound),
        Condition::Equal(left, right, _) => is_bound(left) && is_bound(right),
        _ => false,
    };
    steps.extend(open.iter().copied().filter(is_ready).map(Step::Filter));
    open.retain(|at| !is_ready(at));
}

/// Returns the atom that multiplies the partial results the least: by an estimate that takes each
/// known column as a division by the number of objects in it.
fn cheapest(rule: &Rule, open: &[usize], bound: &[bool], relations: &[Relation]) -> usize {
    let estimate = |&at: &usize| {
        let atom = &rule.body[at];
        let known = atom.arguments.iter().filter(|term| match term {
            Term::Object(_) => true,
            Term::Variable(variable) => bound[*variable],
        });
        let (known, rows) = (known.count(), relations[atom.predicate].len());
        let free = atom.arguments.len() - known;
        // The rows that are left by independent columns with equally many values.
        let left = (rows.max(1) as f64).powf(free as f64 / atom.arguments.len().max(1) as f64);
        (left * 1024.0) as u64
    };
    open.iter().copied().min_by_key(estimate).unwrap_or_default()
}

fn join(atom: &Atom, range: Range, bound: &mut [bool], relations: &mut [Relation]) -> Step {
    let (mut columns, mut key, mut others) = (Vec::new(), Vec::new(), Vec::new());
    let before = bound.to_vec();
    for (column, term) in atom.arguments.iter().enumerate() {
        match *term {
            Term::Variable(variable) if !before[variable] => {
                others.push((column, variable, bound[variable]));
                bound[variable] = true;
            }
            known => {
                columns.push(column);
                key.push(known);
            }
        }
    }
    let index = (!columns.is_empty()).then(|| relations[atom.predicate].index_by(&columns));
    Step::Join { predicate: atom.predicate, range, index, key, others }
}

struct Run<'r, 'p> {
    rule: &'r Rule,
    steps: &'r [Step],
    relations: &'r [Relation],
    poll: &'r mut Poll<'p>,
    found: &'r mut dyn FnMut(&[Object]),
    values: Vec<Object>,
}

impl Run<'_, '_> {
    fn step(&mut self, at: usize) -> Result<(), Limit> {
        self.poll.step()?;
        let steps = self.steps;
        match steps.get(at) {
            None => (self.found)(&self.values),
            Some(Step::Filter(filter)) => {
                if self.holds(&self.rule.filters[*filter]) {
                    return self.step(at + 1);
                }
            }
            Some(&Step::Enumerate(variable)) => {
                let rule = self.rule;
                for &object in &rule.variables[variable].objects {
                    self.values[variable] = object;
                    self.step(at + 1)?;
                }
            }
            Some(Step::Join { predicate, range, index, key, others }) => {
                let relation = &self.relations[*predicate];
                match index {
                    Some(index) => {
                        let key: Key = key.iter().map(|term| term.object(&self.values)).collect();
                        for &row in relation.with(*index, &key, *range) {
                            self.row(relation.row(row as usize), others, at)?;
                        }
                    }
                    None => {
                        for row in relation.positions(*range) {
                            self.row(relation.row(row), others, at)?;
                        }
                    }
                }
            }
        }
        Ok(())
    }

    fn row(&mut self, row: &[Object], others: &[(usize, usize, bool)], at: usize) -> Result<(), Limit> {
        for &(column, variable, repeats) in others {
            let object = row[column];
            if repeats {
                if self.values[variable] != object {
                    return Ok(());
                }
            } else if self.rule.variables[variable].member[object as usize] {
                self.values[variable] = object;
            } else {
                return Ok(());
            }
        }
        self.step(at + 1)
    }

    fn holds(&self, filter: &Condition) -> bool {
        match filter {
            Condition::Literal(atom, is_positive) => {
                let row: Key = atom.arguments.iter().map(|term| term.object(&self.values)).collect();
                self.relations[atom.predicate].contains(&row) == *is_positive
            }
            Condition::Equal(left, right, is_positive) => {
                (left.object(&self.values) == right.object(&self.values)) == *is_positive
            }
            _ => true,
        }
    }
}
