//! Commands from edges: from one edge, or from several that are synchronised.

use ahash::AHashMap;

use super::super::read::model::{Assignment, Destination, Edge};
use super::rewards::ways;
use super::scope::{EdgeOf, Meaning, Place, Slot};
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
}

/// Values after the assignments so far.
#[derive(Default)]
struct Values {
    given: AHashMap<Slot, ExprId>,
    /// Index and place of the last assignment to each target.
    last: AHashMap<Slot, (i64, Span)>,
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
                let guard_id = self.typed(&guard.exp, Place::of(instance), Type::Bool, "a guard")?;
                conditions.push((guard_id, guard.exp.span()));
            }
        }
        self.lowerer.balanced(BinaryOp::And, conditions)
    }

    fn branch(&mut self, parts: &[EdgeOf<'a>], destinations: &[&'a Destination]) -> Option<Branch> {
        let mut probability: Option<(ExprId, Span)> = None;
        for (&(instance, _), destination) in parts.iter().zip(destinations) {
            let own = match &destination.probability {
                Some(e) => self.typed(&e.exp, Place::of(instance), Type::Real, "a probability")?,
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
                let (slot, ty) = self.slot(instance, assignment)?;
                steps.push(Step { instance, assignment, slot, ty });
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
            let read: Vec<_> = row.iter().map(|step| self.value(step, &values)).collect();
            self.stage = 0;
            for (step, id) in row.iter().zip(read) {
                self.assign(step, id?, &mut values)?;
            }
        }
        Some(values.given)
    }

    /// Returns the target of an assignment, with its type.
    pub(super) fn slot(&mut self, instance: usize, assignment: &Assignment) -> Option<(Slot, Type)> {
        let name = &assignment.variable;
        match self.meaning(&name.name, Some(instance)) {
            Some(Meaning::Variable(v, ty)) => Some((Slot::Variable(v), ty)),
            Some(Meaning::Transient(t)) => Some((Slot::Transient(t), self.transients[t].variable.ty.ty)),
            Some(Meaning::Constant(_)) => {
                self.lowerer.fail(name.span, format!("`{}` cannot be assigned: it is a constant", name.name))
            }
            None => {
                self.lowerer.fail(name.span, format!("`{}` cannot be assigned: it is unknown", name.name))
            }
        }
    }

    fn value(&mut self, step: &Step<'_>, values: &Values) -> Option<ExprId> {
        let current = (!values.given.is_empty()).then_some(&values.given);
        let place = Place { instance: Some(step.instance), parameters: None, current };
        let what = format!("the new value of `{}`", step.assignment.variable.name);
        self.typed(&step.assignment.value, place, step.ty, &what)
    }

    fn assign(&mut self, step: &Step<'_>, id: ExprId, values: &mut Values) -> Option<()> {
        let (index, span) = (step.assignment.index, step.assignment.variable.span);
        let before = values.last.insert(step.slot, (index, span));
        if let Some((_, first)) = before.filter(|(i, _)| *i == index)
            && values.given.get(&step.slot) != Some(&id)
        {
            let name = &step.assignment.variable.name;
            let message = format!("`{name}` is assigned twice with the index {index}");
            let diagnostic = self.lowerer.wrong(span, message).label("assigned again");
            let diagnostic = diagnostic.help("assignments of different indices follow each other");
            self.lowerer.report(diagnostic.related(first.range(), "assigned here at the same time"));
            return None;
        }
        values.given.insert(step.slot, id);
        Some(())
    }

    /// Returns a new key for the results of functions evaluated after some assignments.
    fn next_stage(&mut self) -> usize {
        self.stages += 1;
        self.stages
    }
}
