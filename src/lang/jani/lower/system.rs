//! Synchronisation: vectors, and edges that are executed alone.

use ahash::{AHashMap, AHashSet};

use super::super::read::model::{Automaton, Edge, Vector};
use super::arrays::Element;
use super::scope::{EdgeOf, Meaning, Slot};
use super::state::{Lowering, MOST_FUNCTIONS_DEEP};
use crate::ast::{Expr, Ident, NodeKind, Span};
use crate::combinations::{combinations, product};
use meliora_model::{Command, CommandId, Synchronisation};

/// Maximum number of commands when edges are multiplied out.
const MOST_JOINT: usize = 100_000;

/// A vector with its elements, each with its action.
struct Move<'a> {
    vector: &'a Vector,
    /// Groups of elements with their actions; several elements are in one group if their edges
    /// depend on each other.
    groups: Vec<Vec<(usize, &'a str)>>,
}

/// Targets that the edges of one element with one action assign, and those that they read.
#[derive(Default)]
struct Effect {
    /// Assigned targets, each with the smallest index.
    writes: AHashMap<Slot, i64>,
    /// Targets read by assignments, each with the largest index.
    reads: AHashMap<Slot, i64>,
}

/// Commands by the edges that they are made of.
#[derive(Default)]
struct Made {
    commands: Vec<Option<Command>>,
    single: AHashMap<(usize, usize), CommandId>,
}

impl<'a> Lowering<'a> {
    /// Returns the elements of the system.
    pub(super) fn elements(&mut self) -> Vec<&'a Automaton> {
        let (model, mut elements) = (self.model, Vec::new());
        let mut known: AHashMap<&str, &'a Automaton> = AHashMap::new();
        for automaton in &model.automata {
            if let Some(first) = known.insert(&automaton.name.name, automaton) {
                let message = format!("the automaton `{}` is defined twice", automaton.name.name);
                let labels = ["defined again", "defined here first"];
                self.lowerer.again(automaton.name.span, message, first.name.span, labels);
            }
        }
        for element in model.system.automata() {
            let element = &element.automaton;
            match known.get(element.name.as_str()) {
                Some(automaton) => elements.push(*automaton),
                None => {
                    let message = format!("unknown automaton `{}`", element.name);
                    self.lowerer.fail::<()>(element.span, message);
                }
            }
        }
        if elements.is_empty() && self.lowerer.diagnostics.is_empty() {
            let start = model.system.span.start();
            self.lowerer.fail::<()>(Span::new(start, start + 1), "the system has no element");
        }
        elements
    }

    /// Returns all commands, and the synchronisations of the model.
    pub(super) fn moves(&mut self) -> Option<(Vec<Command>, Vec<Synchronisation>)> {
        let moves = self.vectors()?;
        let free = self.free();
        self.check_actions(&moves, &free);
        let mut made = Made::default();
        let groups = moves.iter().flat_map(|m| &m.groups).filter(|g| g.len() == 1);
        let used: AHashSet<(usize, &str)> =
            groups.map(|g| g[0]).chain(free.iter().map(|action| (0, *action))).collect();
        for instance in 0..self.instances.len() {
            self.alone(instance, &used, &mut made);
        }
        let mut synchronisations = self.silent(&made);
        for action in free {
            let (factors, action) = (vec![self.singles(0, Some(action), &made)], self.action(action));
            synchronisations.push(Synchronisation { action: Some(action), factors });
        }
        for moving in &moves {
            synchronisations.extend(self.together(moving, &mut made)?);
        }
        let commands: Vec<Command> = made.commands.into_iter().collect::<Option<_>>()?;
        self.lowerer.diagnostics.is_empty().then_some((commands, synchronisations))
    }

    /// Returns the actions that need no vector: those of the only element of a system without
    /// vectors.
    fn free(&self) -> Vec<&'a str> {
        let mut actions: Vec<&'a str> = Vec::new();
        if let (None, [alone]) = (&self.model.system.vectors, self.instances.as_slice()) {
            for action in alone.automaton.edges.iter().filter_map(|e| e.action.as_ref()) {
                if !actions.contains(&action.name.as_str()) {
                    actions.push(&action.name);
                }
            }
        }
        actions
    }

    /// Returns the vectors with their elements in groups.
    fn vectors(&mut self) -> Option<Vec<Move<'a>>> {
        let model = self.model;
        let mut moves = Vec::new();
        for vector in model.system.vectors.iter().flatten() {
            if vector.actions.len() != self.instances.len() {
                let (has, needs) = (vector.actions.len(), self.instances.len());
                let message = format!("this vector has {has} places, but the system has {needs} elements");
                self.lowerer.fail::<()>(vector.span, message);
                continue;
            }
            let named = vector.actions.iter().enumerate();
            let members: Vec<(usize, &'a str)> =
                named.filter_map(|(i, a)| a.0.as_ref().map(|a| (i, a.name.as_str()))).collect();
            if members.is_empty() {
                self.lowerer.fail::<()>(vector.span, "this vector has no action of any automaton");
                continue;
            }
            let groups = self.groups(&members)?;
            moves.push(Move { vector, groups });
        }
        Some(moves)
    }

    /// Groups the elements that must be multiplied out: both assign one variable, or one reads a
    /// variable that the other has assigned with a smaller index.
    fn groups(&mut self, members: &[(usize, &'a str)]) -> Option<Vec<Vec<(usize, &'a str)>>> {
        let mut effects = Vec::new();
        for &(instance, action) in members {
            effects.push(self.effect(instance, action)?);
        }
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for index in 0..members.len() {
            let depends = |g: &Vec<usize>| g.iter().any(|&o| effects[o].meets(&effects[index]));
            let (mut joined, apart): (Vec<_>, Vec<_>) = groups.into_iter().partition(depends);
            let mut group: Vec<usize> = joined.drain(..).flatten().chain([index]).collect();
            group.sort_unstable();
            groups = apart;
            groups.push(group);
        }
        groups.sort();
        Some(groups.into_iter().map(|g| g.into_iter().map(|i| members[i]).collect()).collect())
    }

    fn effect(&mut self, instance: usize, action: &str) -> Option<Effect> {
        let mut effect = Effect::default();
        for edge in edges(self.instances[instance].automaton, Some(action)) {
            for assignment in edge.destinations.iter().flat_map(|d| &d.assignments) {
                let index = assignment.index;
                for Element { slot, .. } in self.targets(instance, &assignment.variable)? {
                    effect.writes.entry(slot).and_modify(|i| *i = index.min(*i)).or_insert(index);
                }
                let mut read = AHashSet::new();
                for e in assignment.variable.indices.iter().chain([&assignment.value]) {
                    self.read(e, Some(instance), &mut read, &mut AHashSet::new());
                }
                for slot in read {
                    effect.reads.entry(slot).and_modify(|i| *i = index.max(*i)).or_insert(index);
                }
            }
        }
        Some(effect)
    }

    /// Collects the variables that an expression may read, also through functions.
    fn read(
        &self,
        e: &'a Expr,
        instance: Option<usize>,
        slots: &mut AHashSet<Slot>,
        called: &mut AHashSet<usize>,
    ) {
        for node in &e.nodes {
            match &node.kind {
                NodeKind::Name(name) => match self.meaning(name, instance) {
                    Some(Meaning::Variable(v, _)) => drop(slots.insert(Slot::Variable(v))),
                    Some(Meaning::Transient(t)) => drop(slots.insert(Slot::Transient(t))),
                    Some(Meaning::Array(array)) => {
                        slots.extend(self.elements_in(array).into_iter().map(|element| element.slot))
                    }
                    _ => {}
                },
                NodeKind::Comprehension(made) => {
                    self.read(&made.length, instance, slots, called);
                    self.read(&made.body, instance, slots, called);
                }
                NodeKind::Call(name, _) => {
                    let Some(f) = self.function_named(&name.name, instance) else { continue };
                    if called.len() < MOST_FUNCTIONS_DEEP && called.insert(f) {
                        let declared = &self.functions[f];
                        self.read(&declared.function.body, declared.instance, slots, called);
                    }
                }
                _ => {}
            }
        }
    }

    /// Makes commands for the edges of one element that are executed alone or as one participant.
    fn alone(&mut self, instance: usize, used: &AHashSet<(usize, &str)>, made: &mut Made) {
        for (index, edge) in self.instances[instance].automaton.edges.iter().enumerate() {
            let action = edge.action.as_ref().map(|a| self.action(&a.name));
            let number = self.actions.next_number(instance, action);
            let parts = [(instance, edge)];
            let command = self.command(&parts);
            let moves = match &edge.action {
                None => true,
                Some(action) => used.contains(&(instance, action.name.as_str())),
            };
            if moves {
                let id = CommandId(u32::try_from(made.commands.len()).unwrap_or(u32::MAX));
                made.single.insert((instance, index), id);
                self.earn(&parts, command.as_ref(), id);
                made.commands.push(command.map(|c| Command { module: instance, action, number, ..c }));
            }
        }
    }

    /// Returns the synchronisations of edges without an action, one per element.
    fn silent(&self, made: &Made) -> Vec<Synchronisation> {
        let of = |i: usize| self.singles(i, None, made);
        let all = (0..self.instances.len()).map(of).filter(|f| !f.is_empty());
        all.map(|f| Synchronisation { action: None, factors: vec![f] }).collect()
    }

    fn singles(&self, instance: usize, action: Option<&str>, made: &Made) -> Vec<CommandId> {
        let all = self.instances[instance].automaton.edges.iter().enumerate();
        let own = all.filter(|(_, e)| e.action.as_ref().map(|a| a.name.as_str()) == action);
        own.filter_map(|(index, _)| made.single.get(&(instance, index)).copied()).collect()
    }

    /// Returns the synchronisation of a vector; `Some(None)` if some element has no edge with its
    /// action.
    fn together(&mut self, moving: &Move<'a>, made: &mut Made) -> Option<Option<Synchronisation>> {
        let action = moving.vector.result.0.as_ref().map(|r| self.action(&r.name));
        let mut factors = Vec::new();
        for group in &moving.groups {
            let factor = match group.as_slice() {
                &[(instance, action)] => self.singles(instance, Some(action), made),
                several => self.joint(several, action, moving.vector, made)?,
            };
            factors.push(factor);
        }
        Some(factors.iter().all(|f| !f.is_empty()).then_some(Synchronisation { action, factors }))
    }

    /// Makes commands for all combinations of edges of several elements, in a module for the group.
    fn joint(
        &mut self,
        members: &[(usize, &'a str)],
        action: Option<usize>,
        vector: &Vector,
        made: &mut Made,
    ) -> Option<Vec<CommandId>> {
        let own = |&(instance, action): &(usize, &'a str)| -> Vec<EdgeOf<'a>> {
            let edges = edges(self.instances[instance].automaton, Some(action));
            edges.map(|edge| (instance, edge)).collect()
        };
        let lists: Vec<_> = members.iter().map(own).collect();
        if product(&lists).saturating_add(made.commands.len()) > MOST_JOINT {
            let message = "the edges of this vector depend on each other in more ways than can be listed";
            return self.lowerer.fail(vector.span, message);
        }
        let module = self.joint_module(members);
        let mut factor = Vec::new();
        for parts in combinations(lists.into_iter()) {
            let number = self.actions.next_number(module, action);
            let command = self.command(&parts).map(|c| Command { module, action, number, ..c });
            let id = CommandId(u32::try_from(made.commands.len()).ok()?);
            self.earn(&parts, command.as_ref(), id);
            factor.push(id);
            made.commands.push(command);
        }
        Some(factor)
    }

    /// Returns the module that represents several elements.
    fn joint_module(&mut self, members: &[(usize, &str)]) -> usize {
        let instances: Vec<usize> = members.iter().map(|m| m.0).collect();
        if let Some(at) = self.joint_modules.iter().position(|(of, _)| *of == instances) {
            return self.instances.len() + at;
        }
        let names: Vec<&str> = instances.iter().map(|&i| self.instances[i].name.as_str()).collect();
        let name = self.modules.distinct(&names.join("_"));
        self.joint_modules.push((instances, name));
        self.instances.len() + self.joint_modules.len() - 1
    }

    /// Checks that every action is declared; warns of an action in no vector, which never happens.
    fn check_actions(&mut self, moves: &[Move<'a>], free: &[&str]) {
        let model = self.model;
        let declared: AHashSet<&str> = model.actions.iter().map(|a| a.name.name.as_str()).collect();
        let in_vectors: AHashSet<(usize, &str)> =
            moves.iter().flat_map(|m| m.groups.iter().flatten().copied()).collect();
        let mut unknown: Vec<&Ident> = Vec::new();
        for vector in model.system.vectors.iter().flatten() {
            unknown.extend(vector.actions.iter().chain([&vector.result]).filter_map(|a| a.0.as_ref()));
        }
        let mut told = AHashSet::new();
        for (index, instance) in self.instances.iter().enumerate() {
            for action in instance.automaton.edges.iter().filter_map(|e| e.action.as_ref()) {
                unknown.push(action);
                if !in_vectors.contains(&(index, action.name.as_str()))
                    && !free.contains(&action.name.as_str())
                    && told.insert((index, action.name.as_str()))
                {
                    let message = format!("the action `{}` occurs in no synchronisation vector", action.name);
                    let diagnostic = self.lowerer.wrong(action.span, message);
                    let label = format!("edges of `{}` with it never happen", instance.name);
                    self.warnings
                        .push(diagnostic.severity(meliora_base::error::Severity::Warning).label(label));
                }
            }
        }
        for action in unknown {
            if !declared.contains(action.name.as_str()) {
                self.lowerer.fail::<()>(action.span, format!("unknown action `{}`", action.name));
            }
        }
    }
}

impl Effect {
    /// Returns true if the edges cannot be separate commands.
    fn meets(&self, other: &Effect) -> bool {
        let both =
            |(slot, _): (&Slot, &i64)| matches!(slot, Slot::Variable(_)) && other.writes.contains_key(slot);
        self.writes.iter().any(both) || self.feeds(other) || other.feeds(self)
    }

    /// Returns true if the other one reads a variable that this one has assigned before.
    fn feeds(&self, other: &Effect) -> bool {
        other.reads.iter().any(|(slot, last)| self.writes.get(slot).is_some_and(|first| first < last))
    }
}

/// Returns the edges of an automaton with an action, or without one.
fn edges<'a>(automaton: &'a Automaton, action: Option<&str>) -> impl Iterator<Item = &'a Edge> {
    automaton.edges.iter().filter(move |e| e.action.as_ref().map(|a| a.name.as_str()) == action)
}
