//! From a ground task to a flat program: one variable for each group of facts, one command for each
//! ground action, one branch for each outcome.

use std::ops::Range;
use std::sync::Arc;

use ahash::{AHashMap, AHashSet};
use smallvec::SmallVec;

use crate::ground::{Fact, Ground, GroundAction, GroundEffect, GroundTask};
use crate::invariants::Group;
use crate::measures::Measures;
use crate::recursion::components;
use crate::task::Task;
use meliora_base::error::{Diagnostic, Result};
use meliora_base::exact::{Exact, Ratio, Real};
use meliora_base::progress::{Poll, ProgressSink};
use meliora_base::span::Span;
use meliora_base::value::{Type, Value};
use meliora_model::expr::{Binary, ExprId, ExprPool, Unary};
use meliora_model::planning::{GOAL, PlannedFact, Planning};
use meliora_model::{Branch, Command, CommandId, ModelKind, Program, Synchronisation, VarId, Variable};

/// The name of the value for none of the facts of a variable.
const NONE: &str = "none";
/// The only module.
const MODULE: &str = "problem";

pub(crate) struct Lowering<'t> {
    pub(crate) task: &'t Task,
    pub(crate) ground: &'t GroundTask,
    pub(crate) groups: &'t [Group],
    pub(crate) pool: ExprPool,
    /// The variable and the value of each fact.
    pub(crate) place: Vec<(VarId, i64)>,
    /// The expressions of the facts, and of the derived facts.
    pub(crate) facts: Vec<ExprId>,
    pub(crate) derived: Vec<ExprId>,
}

/// Lowers a ground task.
///
/// # Errors
/// A limit; a derived predicate depends on its own negation.
pub(crate) fn lower(
    task: &Task,
    ground: &GroundTask,
    groups: &[Group],
    sink: &dyn ProgressSink,
) -> Result<Program> {
    sink.progress("commands", &|| format!("{} ground actions", ground.actions.len()));
    let mut pool = ExprPool::default();
    let never = pool.value(Value::Bool(false));
    let (place, facts) = (vec![(VarId(0), 0); ground.facts.len()], vec![never; ground.facts.len()]);
    let derived = vec![never; ground.derived.len()];
    let mut lowering = Lowering { task, ground, groups, pool, place, facts, derived };
    let mut variables = lowering.variables();
    lowering.define_derived()?;
    let mut measures = Measures::new(&mut lowering, &mut variables);
    let initial = lowering.initial(&mut variables);
    let (actions, commands) = lowering.commands(&variables, &mut measures, &mut Poll::new(sink))?;
    let planning = lowering.planning(&variables);
    let labels = lowering.labels();
    Ok(Program {
        variables,
        modules: vec![MODULE.to_owned()],
        synchronisations: synchronisations(&commands),
        actions,
        commands,
        labels,
        rewards: measures.structures(&ground.measures),
        planning: Some(Arc::new(planning)),
        ..Program::empty(Arc::clone(&task.source), ModelKind::Mdp, lowering.pool.into(), initial)
    })
}

fn synchronisations(commands: &[Command]) -> Vec<Synchronisation> {
    let one = |(command, id): (&Command, u32)| Synchronisation {
        action: command.action,
        factors: vec![vec![CommandId(id)]],
    };
    commands.iter().zip(0..).map(one).collect()
}

impl Lowering<'_> {
    pub(crate) fn equals(&mut self, variable: VarId, ty: Type, value: i64) -> ExprId {
        let of = self.pool.var(variable, ty);
        self.is_value(of, ty, value)
    }

    /// Returns whether an expression has a value.
    pub(crate) fn is_value(&mut self, of: ExprId, ty: Type, value: i64) -> ExprId {
        match ty {
            Type::Bool if value != 0 => of,
            Type::Bool => self.pool.unary(Unary::Not, of),
            _ => {
                let value = self.pool.value(Value::Int(value));
                self.pool.binary(Binary::Eq, of, value)
            }
        }
    }

    /// Makes the variables, and the expressions of all facts.
    fn variables(&mut self) -> Vec<Variable> {
        let mut taken = AHashSet::new();
        let mut variables = Vec::with_capacity(self.groups.len());
        for (id, group) in (0..).map(VarId).zip(self.groups) {
            let is_single = group.facts.len() == 1;
            let ty = if is_single { Type::Bool } else { Type::Int };
            for (&fact, value) in group.facts.iter().zip(i64::from(is_single)..) {
                self.place[fact as usize] = (id, value);
                self.facts[fact as usize] = self.equals(id, ty, value);
            }
            let values = if is_single { Vec::new() } else { self.values(group) };
            variables.push(Variable {
                name: unique(self.name(group), &mut taken),
                ty,
                low: 0,
                high: if is_single { 1 } else { values.len() as i64 - 1 },
                module: Some(0),
                initial: Some(self.value_in(&self.ground.starts[0], group)),
                values,
                span: 0..0,
            });
        }
        variables
    }

    /// Returns the value of a variable in an initial state.
    fn value_in(&self, start: &[bool], group: &Group) -> i64 {
        let is_single = group.facts.len() == 1;
        let holds = group.facts.iter().position(|&fact| start[fact as usize]);
        let value = match holds {
            Some(at) => at + usize::from(is_single),
            None if is_single => 0,
            None => group.facts.len(),
        };
        value as i64
    }

    /// Returns the condition of the initial states. A variable in which they differ has no initial value of its own.
    fn initial(&mut self, variables: &mut [Variable]) -> ExprId {
        let (ground, groups) = (self.ground, self.groups);
        let mut starts = Vec::with_capacity(ground.starts.len());
        for start in &ground.starts {
            let mut all = Vec::with_capacity(variables.len());
            for (id, variable) in (0..).map(VarId).zip(variables.iter_mut()) {
                let value = groups.get(id.index()).map_or(0, |group| self.value_in(start, group));
                variable.initial = variable.initial.filter(|&first| first == value);
                all.push(self.equals(id, variable.ty, value));
            }
            starts.push(self.pool.joined(Binary::And, all));
        }
        self.pool.joined(Binary::Or, starts)
    }

    /// Returns `at(robot)` for the places of a robot, `held|on(a)` for several predicates, or the atom.
    fn name(&self, group: &Group) -> String {
        let names: Vec<&str> =
            group.predicates.iter().map(|&p| self.task.predicates[p].name.as_str()).collect();
        if let [fact] = group.facts.as_slice() {
            let (predicate, arguments) = &self.ground.facts[*fact as usize];
            return self.task.atom(*predicate, arguments);
        }
        self.task.called(&names.join("|"), &group.parameters)
    }

    /// Returns the names of the values: objects where one predicate has one counted argument.
    fn values(&self, group: &Group) -> Vec<String> {
        let mut taken = AHashSet::new();
        let named = |&fact: &Fact| {
            let (predicate, arguments) = &self.ground.facts[fact as usize];
            match group.counted {
                Some(counted) => self.task.objects[arguments[counted] as usize].clone(),
                None => self.task.atom(*predicate, arguments),
            }
        };
        let mut values: Vec<String> =
            group.facts.iter().map(named).map(|name| unique(name, &mut taken)).collect();
        if group.has_none {
            values.push(unique(NONE.to_owned(), &mut taken));
        }
        values
    }

    /// Returns the expression of a condition.
    pub(crate) fn condition(&mut self, condition: &Ground) -> ExprId {
        match condition {
            Ground::True => self.pool.value(Value::Bool(true)),
            Ground::False => self.pool.value(Value::Bool(false)),
            Ground::Fact(fact, holds) => self.literal(self.facts[*fact as usize], *holds),
            Ground::Derived(derived, holds) => self.literal(self.derived[*derived as usize], *holds),
            Ground::And(parts) => self.joined(Binary::And, parts),
            Ground::Or(parts) => self.joined(Binary::Or, parts),
        }
    }

    /// Joins conditions, halves first: the depth is the logarithm of their number.
    fn joined(&mut self, op: Binary, parts: &[Ground]) -> ExprId {
        match parts {
            [] => self.pool.value(Value::Bool(op == Binary::And)),
            [only] => self.condition(only),
            _ => {
                let (left, right) = parts.split_at(parts.len() / 2);
                let (left, right) = (self.joined(op, left), self.joined(op, right));
                self.pool.binary(op, left, right)
            }
        }
    }

    fn literal(&mut self, id: ExprId, holds: bool) -> ExprId {
        if holds { id } else { self.pool.unary(Unary::Not, id) }
    }

    /// Defines the derived facts, those that they depend on first. Facts that depend on each other get
    /// their least solution: as many rounds as there are such facts reach it.
    pub(crate) fn define_derived(&mut self) -> Result<()> {
        let ground = self.ground;
        let never = self.pool.value(Value::Bool(false));
        self.derived.fill(never);
        for component in components(&ground.derived) {
            if component.is_negated {
                return Err(self.not_stratified(component.members[0]));
            }
            let rounds = if component.is_cycle { component.members.len() } else { 1 };
            for _ in 0..rounds {
                let next: Vec<ExprId> = component
                    .members
                    .iter()
                    .map(|&d| self.condition(&ground.derived[d as usize].1))
                    .collect();
                for (&member, id) in component.members.iter().zip(next) {
                    self.derived[member as usize] = id;
                }
            }
        }
        Ok(())
    }

    fn not_stratified(&self, derived: u32) -> meliora_base::error::Error {
        let (predicate, arguments) = &self.ground.derived[derived as usize].0;
        let name = self.task.atom(*predicate, arguments);
        let message = format!("`{name}` depends on its own negation");
        let wrong = Diagnostic::new(&self.task.source, 0..0, message);
        wrong.help("a derived fact may depend on itself only without `not`").into()
    }

    /// Returns the names of the actions and the commands, and adds their amounts to the measures. Actions whose
    /// condition cannot hold are left out.
    ///
    /// # Errors
    /// A limit; a derived predicate depends on its own negation.
    fn commands(
        &mut self,
        variables: &[Variable],
        measures: &mut Measures,
        poll: &mut Poll<'_>,
    ) -> Result<(Vec<String>, Vec<Command>)> {
        let (ground, task) = (self.ground, self.task);
        let (mut actions, mut commands) = (Vec::new(), Vec::new());
        let called =
            |action: &GroundAction| task.called(&task.actions[action.schema].name, &action.arguments);
        // A text that two actions have names neither: each gets a number.
        let mut taken = if task.may_double_names() {
            doubled(ground.actions.iter().map(called))
        } else {
            AHashSet::new()
        };
        for action in &ground.actions {
            poll.step()?;
            let Some(fixed) = self.fixed(&action.precondition) else { continue };
            let schema = &task.actions[action.schema];
            let number = CommandId(u32::try_from(commands.len()).unwrap_or(u32::MAX));
            let mut branches = self.branches(action, &fixed, variables);
            measures.add(self, (number, action), &mut branches)?;
            let Range { start, end } = schema.span.clone();
            commands.push(Command {
                module: 0,
                action: Some(actions.len()),
                number: 1,
                unlisted: None,
                guard: self.condition(&action.precondition),
                branches,
                span: Span::new(start, end),
            });
            actions.push(unique(called(action), &mut taken));
        }
        Ok((actions, commands))
    }

    /// Returns the values that a condition fixes; `None` if it requires two values of one variable.
    fn fixed(&self, condition: &Ground) -> Option<AHashMap<VarId, i64>> {
        let mut fixed = AHashMap::new();
        for fact in condition.required() {
            let (variable, value) = self.place[fact as usize];
            if *fixed.entry(variable).or_insert(value) != value {
                return None;
            }
        }
        Some(fixed)
    }

    fn branches(
        &mut self,
        action: &GroundAction,
        fixed: &AHashMap<VarId, i64>,
        variables: &[Variable],
    ) -> SmallVec<[Branch; 1]> {
        let mut branches = SmallVec::new();
        for outcome in &action.outcomes {
            let mut effects: Vec<(VarId, &GroundEffect)> =
                outcome.effects.iter().map(|effect| (self.place[effect.fact as usize].0, effect)).collect();
            effects.sort_by_key(|(id, _)| *id);
            let mut updates = SmallVec::new();
            for effects in effects.chunk_by(|(left, _), (right, _)| left == right) {
                let id = effects[0].0;
                let (variable, known) = (&variables[id.index()], fixed.get(&id).copied());
                updates.extend(self.update(id, variable, effects, known).map(|new| (id, new)));
            }
            branches.push(Branch { probability: self.number(&outcome.probability), updates });
        }
        branches
    }

    pub(crate) fn number(&mut self, number: &Ratio) -> ExprId {
        self.pool.exact_value(Exact::Real(Real::Finite(number.clone())))
    }

    /// Returns the new value of a variable; `None` if it stays as it is.
    fn update(
        &mut self,
        id: VarId,
        variable: &Variable,
        effects: &[(VarId, &GroundEffect)],
        fixed: Option<i64>,
    ) -> Option<ExprId> {
        let literal = |pool: &mut ExprPool, value: i64| match variable.ty {
            Type::Bool => pool.value(Value::Bool(value != 0)),
            _ => pool.value(Value::Int(value)),
        };
        let old = match fixed {
            Some(value) => literal(&mut self.pool, value),
            None => self.pool.var(id, variable.ty),
        };
        let mut new = old;
        let (adds, deletes): (Vec<&GroundEffect>, Vec<&GroundEffect>) =
            effects.iter().map(|(_, effect)| *effect).partition(|effect| effect.is_added);
        for delete in deletes {
            let value = self.place[delete.fact as usize].1;
            // Boolean variables are false without their fact; others have a value for none, the last one.
            let without = if variable.ty == Type::Bool { 0 } else { variable.high };
            let condition = self.condition(&delete.condition);
            let holds = match fixed {
                Some(known) => self.pool.value(Value::Bool(known == value)),
                None => self.facts[delete.fact as usize],
            };
            let applies = self.pool.binary(Binary::And, condition, holds);
            let without = literal(&mut self.pool, without);
            new = self.pool.ite(applies, without, new);
        }
        for add in adds {
            let condition = self.condition(&add.condition);
            let value = literal(&mut self.pool, self.place[add.fact as usize].1);
            new = self.pool.ite(condition, value, new);
        }
        (new != old).then_some(new)
    }

    /// Returns the goal; one of preferences alone holds everywhere.
    pub(crate) fn goal(&mut self) -> ExprId {
        let ground = self.ground;
        self.condition(ground.goal.as_ref().unwrap_or(&Ground::True))
    }

    /// Returns the labels: the goal and the preferences. A problem of rewards alone has none.
    fn labels(&mut self) -> Vec<(String, ExprId)> {
        let ground = self.ground;
        if ground.goal.is_none() && ground.preferences.is_empty() {
            return Vec::new();
        }
        let mut labels = vec![(GOAL.to_owned(), self.goal())];
        for (name, condition) in &ground.preferences {
            labels.push((name.clone(), self.condition(condition)));
        }
        labels
    }

    fn planning(&mut self, variables: &[Variable]) -> Planning {
        let (task, ground) = (self.task, self.ground);
        let mut planning = Planning { assumes_uniform: task.has_oneof, ..Planning::default() };
        planning.objectives.extend(ground.goal.as_ref().map(|_| GOAL.to_owned()));
        planning.objectives.extend(ground.preferences.iter().map(|(name, _)| name.clone()));
        let always = self.pool.value(Value::Bool(true));
        let mut name = |predicate: usize, row: &[u32], id: ExprId| {
            let name = task.atom(predicate, row);
            planning.atoms.insert(name.to_lowercase(), id);
            name
        };
        let is_static = |predicate: usize| !task.predicates[predicate].is_changed;
        for (predicate, row) in task.initial.iter().filter(|(p, _)| is_static(*p)).chain(&ground.constant) {
            name(*predicate, row, always);
        }
        for (((predicate, row), _), &id) in ground.derived.iter().zip(&self.derived) {
            name(*predicate, row, id);
        }
        let mut facts = Vec::with_capacity(ground.facts.len());
        for ((predicate, row), (&id, &(variable, value))) in
            ground.facts.iter().zip(self.facts.iter().zip(&self.place))
        {
            facts.push(PlannedFact { name: name(*predicate, row, id), variable, value });
        }
        debug_assert!(facts.iter().all(|fact| fact.variable.index() < variables.len()));
        planning.facts = facts;
        for predicate in &task.predicates {
            let names = |objects: &[u32]| objects.iter().map(|&o| task.objects[o as usize].clone()).collect();
            let parameters = predicate.parameters.iter().map(|domain| names(&domain.objects)).collect();
            planning.predicates.insert(predicate.name.to_lowercase(), parameters);
        }
        planning
    }
}

/// Returns the names that occur twice.
fn doubled(names: impl Iterator<Item = String>) -> AHashSet<String> {
    let mut known = AHashSet::new();
    names.filter(|name| !known.insert(name.clone())).collect()
}

/// Returns a name that is not taken, and takes it.
pub(crate) fn unique(name: String, taken: &mut AHashSet<String>) -> String {
    let mut unique = name.clone();
    let mut number = 2;
    while !taken.insert(unique.clone()) {
        unique = format!("{name}_{number}");
        number += 1;
    }
    unique
}
