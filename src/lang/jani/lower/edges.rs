//! Commands from edges: from one edge, or from several that are synchronised.

use ahash::AHashMap;

use super::super::read::model::{Assignment, Destination, Edge};
use super::arrays::Element;
use super::rewards::ways;
use super::scope::{EdgeOf, Place, Slot};
use super::state::Lowering;
use crate::ast::{BinaryOp, Span};
use meliora_base::value::{Type, Value};
use meliora_model::expr::{ExprId, Node};
use meliora_model::{Branch, Branches, Command, VarId};

/// An assignment with its element, target and type.
pub(super) struct Step<'e> {
    instance: usize,
    pub(super) assignment: &'e Assignment,
    pub(super) slot: Slot,
    ty: Type,
    /// The position of the element in each array around it, with the length of this array.
    path: Vec<(usize, usize)>,
}

/// Values after the assignments so far.
#[derive(Default)]
struct Values {
    given: AHashMap<Slot, ExprId>,
    /// Index and place of the last assignment to each target, and its condition.
    last: AHashMap<Slot, (i64, Span, Option<ExprId>)>,
}

impl<'a> Lowering<'a> {
    /// Combines edges into one command, with a branch for each combination of their destinations.
    pub(super) fn command(&mut self, parts: &[EdgeOf<'a>]) -> Option<Command> {
        let guard = self.guard(parts);
        let branches: Vec<_> = ways(parts).iter().map(|c| self.branch(parts, c)).collect();
        let branches: Branches = branches.into_iter().collect::<Option<_>>()?;
        let first = parts.first()?.1;
        Some(Command {
            module: 0,
            action: None,
            number: 0,
            unlisted: None,
            guard: guard?,
            branches,
            span: first.span,
        })
    }

    /// Returns the guard: every element is in the location of its edge, and the guard of the edge
    /// holds.
    fn guard(&mut self, parts: &[EdgeOf<'a>]) -> Option<ExprId> {
        let mut conditions = Vec::new();
        for &(instance, edge) in parts {
            if let Some(here) = self.at(instance, &edge.location)? {
                conditions.push((here, edge.location.span));
            }
        }
        for &(instance, edge) in parts {
            if let Some(guard) = &edge.guard {
                let guard_id = self.typed(&guard.exp, Place::new(instance), Type::Bool, "a guard")?;
                conditions.push((guard_id, guard.exp.span()));
            }
        }
        self.lowerer.balanced(BinaryOp::And, conditions)
    }

    fn branch(&mut self, parts: &[EdgeOf<'a>], destinations: &[&'a Destination]) -> Option<Branch> {
        let mut probability: Option<(ExprId, Span)> = None;
        for (&(instance, _), destination) in parts.iter().zip(destinations) {
            let own = match &destination.probability {
                Some(e) => self.typed(&e.exp, Place::new(instance), Type::Real, "a probability")?,
                None => self.lowerer.literal(Value::Real(1.0))?,
            };
            let own = (own, destination.span);
            probability = Some(match probability {
                Some(before) => (self.lowerer.binary(BinaryOp::Mul, before, own, own.1)?, own.1),
                None => own,
            });
        }
        let mut updates = self.assigned(parts, destinations)?;
        for (&(instance, edge), destination) in parts.iter().zip(destinations) {
            updates.extend(self.moved(instance, edge, destination)?);
        }
        Some(Branch { probability: probability?.0, updates: updates.into() })
    }

    /// Returns the update of the location, if it changes.
    #[allow(clippy::option_option)]
    fn moved(&mut self, instance: usize, edge: &Edge, to: &Destination) -> Option<Option<(VarId, ExprId)>> {
        self.at(instance, &to.location)?;
        let Some(variable) = self.instances[instance].location else { return Some(None) };
        let (from, to) = (self.position(instance, &edge.location), self.position(instance, &to.location)?);
        if from == Some(to) {
            return Some(None);
        }
        Some(Some((variable, self.lowerer.literal(Value::Int(to))?)))
    }

    /// Returns the updates of all destinations. Assignments are ordered by index; those of one
    /// index are simultaneous. Transient variables matter only if later assignments may read them;
    /// the others are rewards.
    fn assigned(
        &mut self,
        parts: &[EdgeOf<'a>],
        destinations: &[&'a Destination],
    ) -> Option<Vec<(VarId, ExprId)>> {
        let mut steps = self.assignments(parts, destinations)?;
        let last = steps.iter().map(|s| s.assignment.index).max();
        steps.retain(|s| matches!(s.slot, Slot::Variable(_)) || Some(s.assignment.index) < last);
        let values = self.values_after(steps)?;
        let changed = |(slot, id): (&Slot, &ExprId)| match slot {
            Slot::Variable(v) if self.lowerer.pool.node(*id) != Node::Var(*v) => Some((*v, *id)),
            _ => None,
        };
        let mut updates: Vec<_> = values.iter().filter_map(changed).collect();
        updates.sort_unstable();
        Some(updates)
    }

    /// Returns all assignments of some destinations.
    pub(super) fn assignments(
        &mut self,
        parts: &[EdgeOf<'a>],
        destinations: &[&'a Destination],
    ) -> Option<Vec<Step<'a>>> {
        let mut steps = Vec::new();
        for (&(instance, _), destination) in parts.iter().zip(destinations) {
            for assignment in &destination.assignments {
                for Element { slot, ty, path } in self.targets(instance, &assignment.variable)? {
                    steps.push(Step { instance, assignment, slot, ty, path });
                }
            }
        }
        Some(steps)
    }

    /// Returns the values of the assigned variables after assignments in the order of their indices.
    pub(super) fn values_after(&mut self, mut steps: Vec<Step<'a>>) -> Option<AHashMap<Slot, ExprId>> {
        steps.sort_by_key(|s| s.assignment.index);
        let mut values = Values::default();
        for row in steps.chunk_by(|a, b| a.assignment.index == b.assignment.index) {
            self.stage = if values.given.is_empty() { 0 } else { self.next_stage() };
            let read: Vec<_> = row.iter().map(|step| self.change(step, &values)).collect();
            self.stage = 0;
            for (step, change) in row.iter().zip(read) {
                if let Some((hit, id)) = change? {
                    self.assign(step, hit, id, &mut values)?;
                }
            }
        }
        Some(values.given)
    }

    /// Returns the condition under which a step changes its target, if there is one, and the new value; `None`
    /// in it if another element is changed.
    #[allow(clippy::option_option)]
    fn change(&mut self, step: &Step<'_>, values: &Values) -> Option<Option<(Option<ExprId>, ExprId)>> {
        let current = (!values.given.is_empty()).then_some(&values.given);
        let place = Place { instance: Some(step.instance), parameters: None, current };
        let (assignment, target) = (step.assignment, &step.assignment.variable);
        let hit = match self.hits(assignment, &step.path, place)? {
            Some(hit) => match self.lowerer.pool.literal(hit) {
                Some(Value::Bool(true)) => None,
                Some(_) => return Some(None),
                None => Some(hit),
            },
            None => None,
        };
        let what = format!("the new value of `{}`", target.name.name);
        let (read, span) = self.value(&assignment.value, place);
        let id = self.part(&read?, &step.path[target.indices.len()..], (&what, span))?;
        Some(Some((hit, self.lowerer.finished((Some(id), span), step.ty, &what)?)))
    }

    fn assign(
        &mut self,
        step: &Step<'_>,
        hit: Option<ExprId>,
        id: ExprId,
        values: &mut Values,
    ) -> Option<()> {
        let (index, span) = (step.assignment.index, step.assignment.variable.name.span);
        let before = values.last.get(&step.slot).filter(|(i, ..)| *i == index).copied();
        let (mut condition, mut either) = (hit, hit);
        match before {
            Some((_, first, None)) if hit.is_none() && values.given.get(&step.slot) != Some(&id) => {
                return self.twice(step, first);
            }
            Some((_, _, None)) if hit.is_none() => {}
            Some((_, _, other)) => {
                let always = self.lowerer.literal(Value::Bool(true))?;
                condition = Some(self.apart(hit.unwrap_or(always), other, span)?);
                either = match (hit, other) {
                    (Some(a), Some(b)) => {
                        Some(self.lowerer.balanced(BinaryOp::Or, vec![(a, span), (b, span)])?)
                    }
                    _ => None,
                };
            }
            None => {}
        }
        let old = match step.slot {
            Slot::Variable(v) => Some(self.lowerer.pool.var(v, step.ty)),
            Slot::Transient(t) => self.transients[t].element,
        };
        let old = values.given.get(&step.slot).copied().or(old);
        let value = match (condition, old) {
            (Some(condition), Some(old)) => self.lowerer.ite(condition, (id, span), (old, span))?,
            _ => id,
        };
        values.last.insert(step.slot, (index, span, either));
        values.given.insert(step.slot, value);
        Some(())
    }

    /// Reports two assignments to a target at the same time.
    fn twice(&mut self, step: &Step<'_>, first: Span) -> Option<()> {
        let (name, index) = (&step.assignment.variable.name, step.assignment.index);
        let message = format!("`{}` is assigned twice with the index {index}", name.name);
        let diagnostic = self.lowerer.wrong(name.span, message).label("assigned again");
        let diagnostic = diagnostic.help("assignments of different indices follow each other");
        self.lowerer.report(diagnostic.related(first.range(), "assigned here at the same time"));
        None
    }

    /// Returns a new key for the results of functions evaluated after some assignments.
    fn next_stage(&mut self) -> usize {
        self.stages += 1;
        self.stages
    }
}
