//! Relaxed reachability: the facts and actions that are reachable if nothing is ever deleted, as a
//! Datalog program that is evaluated semi-naively.

use std::sync::Arc;

use ahash::{AHashMap, AHashSet};

use super::database::{Key, Relation};
use super::join::{Plan, Rule};
use super::{Atoms, GroundAtom, Meaning};
use crate::task::{Action, Atom, Condition, Domain, Effect, Object, Task, Term};
use meliora_base::error::Result;
use meliora_base::progress::{Poll, ProgressSink};

/// The facts, and the actions with the objects for which they are applicable.
pub(super) struct Reached {
    /// One relation for each predicate, then one for each action.
    relations: Vec<Relation>,
    predicates: usize,
}

/// The rules of a task, and the bodies that wait for further facts.
struct Evaluation<'t> {
    task: &'t Task,
    relations: Vec<Relation>,
    rules: Vec<Rule>,
    /// The values under which all but the last conditions of a rule hold.
    waiting: Vec<(usize, Vec<Object>)>,
    plans: AHashMap<(usize, usize), Plan>,
}

impl Reached {
    /// Computes the reachable facts and actions.
    ///
    /// # Errors
    /// A limit.
    pub(super) fn compute(task: &Task, sink: &dyn ProgressSink) -> Result<Self> {
        let predicates = task.predicates.iter().map(|p| p.parameters.len());
        let arities = predicates.chain(task.actions.iter().map(|a| a.parameters.len()));
        let mut relations: Vec<Relation> = arities.map(Relation::new).collect();
        for (predicate, arguments) in task.initial.iter().chain(task.starts.iter().flatten()) {
            relations[*predicate].add(arguments);
        }
        let mut evaluation =
            Evaluation { task, relations, rules: rules(task), waiting: Vec::new(), plans: AHashMap::new() };
        let mut poll = Poll::new(sink);
        evaluation.first_round(&mut poll)?;
        while evaluation.round(&mut poll)? {}
        Ok(Reached { relations: evaluation.relations, predicates: task.predicates.len() })
    }

    pub(super) fn contains(&self, predicate: usize, row: &[Object]) -> bool {
        self.relations[predicate].contains(row)
    }

    pub(super) fn rows(&self, predicate: usize) -> impl Iterator<Item = &[Object]> {
        self.relations[predicate].rows()
    }

    pub(super) fn applicable(&self, action: usize) -> impl Iterator<Item = &[Object]> {
        self.relations[self.predicates + action].rows()
    }

    /// Returns the facts that some reachable action can delete.
    ///
    /// # Errors
    /// A limit.
    pub(super) fn deleted(&self, task: &Task, sink: &dyn ProgressSink) -> Result<AHashSet<GroundAtom>> {
        let mut poll = Poll::new(sink);
        let mut deleted = AHashSet::new();
        for (number, action) in task.actions.iter().enumerate() {
            let mut literals = changes(action);
            literals.retain(|change| !change.is_added);
            // Many deletions may be of the same atom, under conditions that do not matter here.
            literals.sort_unstable_by(|x, y| (&x.atom, &x.variables).cmp(&(&y.atom, &y.variables)));
            literals.dedup_by(|x, y| (&x.atom, &x.variables) == (&y.atom, &y.variables));
            let is_same =
                |change: &Change| change.atom.arguments.iter().all(|t| matches!(t, Term::Object(_)));
            for change in &literals {
                let rows = if is_same(change) { 1 } else { usize::MAX };
                for row in self.applicable(number).take(rows) {
                    poll.step()?;
                    let mut values = row.to_vec();
                    every(&change.variables, &mut values, &mut |values| {
                        let arguments: Vec<Object> =
                            change.atom.arguments.iter().map(|t| t.object(values)).collect();
                        if self.contains(change.atom.predicate, &arguments) {
                            deleted.insert((change.atom.predicate, arguments));
                        }
                    });
                }
            }
        }
        Ok(deleted)
    }

    /// Returns the meanings of all reachable atoms of predicates that are not derived, the facts
    /// that change, and the changed predicates' facts that always hold.
    pub(super) fn facts(
        &self,
        task: &Task,
        deleted: &AHashSet<GroundAtom>,
    ) -> (Atoms, Vec<GroundAtom>, Vec<GroundAtom>) {
        let initial: AHashSet<&GroundAtom> = task.initial.iter().collect();
        let predicates = task.predicates.len();
        let changes = (0..predicates).map(|predicate| changes_at_all(task, predicate)).collect();
        let mut atoms = Atoms { known: vec![AHashMap::new(); predicates], changes };
        let (mut facts, mut constant) = (Vec::new(), Vec::new());
        for (number, predicate) in task.predicates.iter().enumerate().filter(|(_, p)| !p.is_derived) {
            for row in self.rows(number) {
                let atom = (number, row.to_vec());
                let meaning = if initial.contains(&atom) && !deleted.contains(&atom) {
                    constant.extend(predicate.is_changed.then(|| atom.clone()));
                    Meaning::True
                } else {
                    facts.push(atom.clone());
                    Meaning::Fact(u32::try_from(facts.len() - 1).unwrap_or(u32::MAX))
                };
                atoms.insert(number, row, meaning);
            }
        }
        (atoms, facts, constant)
    }
}

/// Calls a function for all values of further variables.
pub(super) fn every(domains: &[Arc<Domain>], values: &mut Vec<Object>, then: &mut dyn FnMut(&[Object])) {
    let Some((first, rest)) = domains.split_first() else { return then(values) };
    for &object in &first.objects {
        values.push(object);
        every(rest, values, then);
        values.pop();
    }
}

impl Evaluation<'_> {
    /// Evaluates all rules over the initial facts.
    fn first_round(&mut self, poll: &mut Poll<'_>) -> Result<()> {
        self.relations.iter_mut().for_each(|relation| {
            relation.advance();
        });
        for rule in 0..self.rules.len() {
            self.evaluate(rule, None, poll)?;
        }
        Ok(())
    }

    /// Evaluates the rules over the facts of the last round; returns false if it had none.
    fn round(&mut self, poll: &mut Poll<'_>) -> Result<bool> {
        let mut has_new = false;
        for relation in &mut self.relations {
            has_new |= relation.advance();
        }
        if !has_new {
            return Ok(false);
        }
        for rule in 0..self.rules.len() {
            for atom in 0..self.rules[rule].body.len() {
                if self.relations[self.rules[rule].body[atom].predicate].has_delta() {
                    self.evaluate(rule, Some(atom), poll)?;
                }
            }
        }
        self.wake();
        Ok(true)
    }

    /// Adds the heads of a rule.
    fn evaluate(&mut self, number: usize, delta: Option<usize>, poll: &mut Poll<'_>) -> Result<()> {
        let Evaluation { task, relations, rules, waiting, plans } = self;
        let rule = &rules[number];
        // The first round has a plan of its own, which is not used again.
        let first;
        let plan = match delta {
            Some(atom) => {
                plans.entry((number, atom)).or_insert_with(|| Plan::new(rule, Some(atom), relations))
            }
            None => {
                first = Plan::new(rule, None, relations);
                &first
            }
        };
        let mut heads: Vec<Key> = Vec::new();
        plan.run(rule, relations, poll, &mut |values| {
            if rule.rest.iter().all(|c| possible(task, relations, c, &mut values.to_vec())) {
                heads.push(rule.head.arguments.iter().map(|term| term.object(values)).collect());
            } else {
                waiting.push((number, values.to_vec()));
            }
        })?;
        heads.iter().for_each(|row| {
            relations[rule.head.predicate].add(row);
        });
        Ok(())
    }

    /// Adds the heads whose last conditions have become possible.
    fn wake(&mut self) {
        let Evaluation { task, relations, rules, waiting, .. } = self;
        waiting.retain(|(number, values)| {
            let rule = &rules[*number];
            let is_possible = rule.rest.iter().all(|c| possible(task, relations, c, &mut values.clone()));
            if is_possible {
                let row: Key = rule.head.arguments.iter().map(|term| term.object(values)).collect();
                relations[rule.head.predicate].add(&row);
            }
            !is_possible
        });
    }
}

/// Returns whether a condition may hold: a fact that can change may always be false.
fn possible(task: &Task, relations: &[Relation], condition: &Condition, values: &mut Vec<Object>) -> bool {
    may_hold(condition, values, &|predicate, row, is_positive| {
        let is_known = relations[predicate].contains(row);
        if is_positive { is_known } else { !is_known || changes_at_all(task, predicate) }
    })
}

/// Returns whether a condition may hold, given which literals may: `literal(predicate, objects, is_positive)`.
pub(super) fn may_hold(
    condition: &Condition,
    values: &mut Vec<Object>,
    literal: &dyn Fn(usize, &Key, bool) -> bool,
) -> bool {
    match condition {
        Condition::Literal(atom, is_positive) => {
            let row: Key = atom.arguments.iter().map(|term| term.object(values)).collect();
            literal(atom.predicate, &row, *is_positive)
        }
        Condition::Equal(left, right, is_positive) => {
            (left.object(values) == right.object(values)) == *is_positive
        }
        Condition::And(all) => all.iter().all(|c| may_hold(c, values, literal)),
        Condition::Or(all) => all.iter().any(|c| may_hold(c, values, literal)),
        Condition::All(domains, inner) => {
            let mut all = true;
            every(domains, values, &mut |values| {
                all = all && may_hold(inner, &mut values.to_vec(), literal);
            });
            all
        }
        Condition::Some(domains, inner) => {
            let mut any = false;
            every(domains, values, &mut |values| {
                any = any || may_hold(inner, &mut values.to_vec(), literal);
            });
            any
        }
    }
}

fn changes_at_all(task: &Task, predicate: usize) -> bool {
    let predicate = &task.predicates[predicate];
    predicate.is_changed || predicate.is_derived
}

/// An add or delete effect, with the variables and conditions around it.
pub(super) struct Change {
    pub(super) atom: Atom,
    pub(super) is_added: bool,
    /// The variables after the parameters of the action.
    pub(super) variables: Vec<Arc<Domain>>,
    /// Their quantified variables are numbered after the parameters and the variables.
    pub(super) conditions: Vec<Condition>,
}

/// Lists the changes of an effect of an action.
pub(super) fn changes(action: &Action) -> Vec<Change> {
    let mut all = Vec::new();
    listed(&action.effect, (action.parameters.len(), &mut Vec::new()), &mut Vec::new(), &mut all);
    all
}

/// Lists the changes of a part of an effect; `conditions` are those around it, each with the number of the
/// variables around it.
fn listed<'e>(
    effect: &'e Effect,
    (parameters, scope): (usize, &mut Vec<Arc<Domain>>),
    conditions: &mut Vec<(usize, &'e Condition)>,
    all: &mut Vec<Change>,
) {
    match effect {
        Effect::And(parts) | Effect::OneOf(parts) => {
            parts.iter().for_each(|part| listed(part, (parameters, scope), conditions, all));
        }
        Effect::Earn(_) => {}
        Effect::Probably(parts) => {
            parts.iter().for_each(|(_, part)| listed(part, (parameters, scope), conditions, all));
        }
        Effect::Literal(atom, is_added) => {
            let variables: Vec<Term> = (0..parameters + scope.len()).map(Term::Variable).collect();
            let placed = |(free, condition): &(usize, &Condition)| {
                condition.with(&variables[..*free], variables.len())
            };
            all.push(Change {
                atom: atom.clone(),
                is_added: *is_added,
                variables: scope.clone(),
                conditions: conditions.iter().map(placed).collect(),
            });
        }
        Effect::When(condition, inner) => {
            conditions.push((parameters + scope.len(), condition));
            listed(inner, (parameters, scope), conditions, all);
            conditions.pop();
        }
        Effect::All(domains, inner) => {
            let before = scope.len();
            scope.extend(domains.iter().cloned());
            listed(inner, (parameters, scope), conditions, all);
            scope.truncate(before);
        }
    }
}

/// Returns the rules of actions, of their effects and of derived predicates.
fn rules(task: &Task) -> Vec<Rule> {
    let mut rules = Vec::new();
    for (number, action) in task.actions.iter().enumerate() {
        let arguments: Vec<Term> = (0..action.parameters.len()).map(Term::Variable).collect();
        let applicable = Atom { predicate: task.predicates.len() + number, arguments };
        rules.push(rule(task, applicable.clone(), &action.parameters, [&action.precondition], Vec::new()));
        for change in changes(action).into_iter().filter(|change| change.is_added) {
            let variables: Vec<_> = action.parameters.iter().chain(&change.variables).cloned().collect();
            let body = vec![applicable.clone()];
            rules.push(rule(task, change.atom, &variables, &change.conditions, body));
        }
    }
    for axiom in &task.axioms {
        let arguments = (0..axiom.parameters.len()).map(Term::Variable).collect();
        let head = Atom { predicate: axiom.predicate, arguments };
        rules.push(rule(task, head, &axiom.parameters, [&axiom.condition], Vec::new()));
    }
    rules
}

/// Sorts conditions into those that are joined, those that filter, and the others.
fn rule<'c>(
    task: &Task,
    head: Atom,
    variables: &[Arc<Domain>],
    conditions: impl IntoIterator<Item = &'c Condition>,
    body: Vec<Atom>,
) -> Rule {
    let mut rule = Rule { variables: variables.to_vec(), head, body, filters: Vec::new(), rest: Vec::new() };
    let mut open: Vec<&Condition> = conditions.into_iter().collect();
    while let Some(condition) = open.pop() {
        match condition {
            Condition::And(all) => open.extend(all.iter().rev()),
            Condition::Literal(atom, true) => rule.body.push(atom.clone()),
            Condition::Literal(atom, false) if changes_at_all(task, atom.predicate) => {}
            Condition::Literal(..) | Condition::Equal(..) => rule.filters.push(condition.clone()),
            Condition::Or(_) | Condition::All(..) | Condition::Some(..) => rule.rest.push(condition.clone()),
        }
    }
    rule
}
