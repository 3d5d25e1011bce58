//! Shields: the permitted actions of all states with memory, as a table that needs no model.
//!
//! A node is a state with the memory of a finite-memory strategy. While improvements are ahead, a
//! shield permits the actions of the permissive strategy. At level 0 it permits the kept actions
//! that lead to secure nodes only. A node is *secure* if no permitted step ever weakens from it on:
//!
//! Secure = νZ. { v : v permits an action, each of them enters Z only and weakens nothing }, where a
//! node of level 0 permits the actions that do.
//!
//! In a node that is not secure, a shield permits the actions of the permissive strategy or the
//! kept ones, and all actions if there are none.

use std::collections::VecDeque;

use ahash::AHashMap;
use serde::{Deserialize, Serialize};

use super::explain::{Action, Explanation};
use super::finite_memory::{FiniteMemoryStrategy, Memory};
use super::levels::Rank;
use crate::engine::Engine;
use crate::error::{Error, Limit, Result};
use crate::model::preference::{Change, ObjectiveSet};
use crate::model::value::Type;
use crate::model::{Program, State};

/// A table of permitted actions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shield {
    /// The kind of the strategy.
    pub kind: String,
    /// The safety mode.
    pub safety: String,
    /// The variables of states, those of monitors included.
    pub variables: Vec<ShieldVariable>,
    /// The names of the actions: the labels of the model, then those of unlabelled commands.
    pub actions: Vec<String>,
    /// The most preferred objectives of each class that occurs.
    pub classes: Vec<Vec<String>>,
    /// For each class, the classes to which a step weakens, in ascending order.
    pub weakening: Vec<Vec<usize>>,
    /// The nodes. The first [`Shield::starts`] are those in which episodes may start.
    pub nodes: Vec<ShieldNode>,
    /// The number of states in which episodes may start.
    pub starts: usize,
}

/// A variable of a shield's states.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShieldVariable {
    /// Its name.
    pub name: String,
    /// True if its values are Booleans.
    pub boolean: bool,
    /// The smallest value.
    pub low: i64,
    /// The names of the values from `low` on, if they have names.
    pub values: Vec<String>,
    /// For the variable of a monitor, the value with which it starts.
    pub monitor: Option<i64>,
}

/// A state with memory.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShieldNode {
    /// The values of the variables.
    pub state: State,
    /// The class of the state; `None` if it is unsafe under the requirements.
    pub class: Option<usize>,
    /// The class that steps are compared with.
    pub reference: usize,
    /// The number of improvements ahead; `None` if it is unbounded.
    pub ahead: Option<usize>,
    /// True if no permitted step ever weakens from here on.
    pub secure: bool,
    /// The enabled actions.
    pub actions: Vec<ShieldAction>,
    /// The permitted action that a correction takes, a position in `actions`.
    pub pick: usize,
}

/// An enabled action of a node: all choices with one label.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShieldAction {
    /// A position in [`Shield::actions`].
    pub action: usize,
    /// True if the shield permits it.
    pub permitted: bool,
    /// The nodes that it may enter.
    pub next: Vec<usize>,
}

/// A shield under construction.
struct Builder<'s, E: Engine> {
    strategy: &'s mut FiniteMemoryStrategy<E>,
    index: AHashMap<(State, Memory), usize>,
    queue: VecDeque<(State, Memory)>,
    actions: Vec<String>,
    classes: Vec<ObjectiveSet>,
    /// Maximum number of nodes.
    limit: usize,
    nodes: Vec<ShieldNode>,
}

impl Shield {
    /// Computes the shield of a strategy of the kinds `sasi` and `spi`, for episodes that start in
    /// any state of the scope. Cost: that of [`FiniteMemoryStrategy::explain`] per node.
    ///
    /// # Errors
    /// The errors of [`FiniteMemoryStrategy::explain`]; [`Limit::Size`] if there are more than
    /// `limit` nodes; [`Error::Usage`] for other strategies, and with `safety = transition`.
    pub fn new<E: Engine>(strategy: &mut FiniteMemoryStrategy<E>, limit: usize) -> Result<Self> {
        strategy.fits_shields()?;
        let mut builder = Builder {
            actions: labels(&strategy.program),
            strategy,
            index: AHashMap::new(),
            queue: VecDeque::new(),
            classes: Vec::new(),
            limit,
            nodes: Vec::new(),
        };
        let starts = builder.enter_all()?;
        while let Some((state, memory)) = builder.queue.pop_front() {
            let node = builder.node(&state, memory)?;
            builder.nodes.push(node);
        }
        let mut shield = builder.finish(starts);
        shield.secure();
        Ok(shield)
    }

    /// Returns whether a step between classes weakens.
    fn weakens(&self, reference: usize, class: Option<usize>) -> bool {
        class.is_none_or(|class| self.weakening[reference].binary_search(&class).is_ok())
    }

    /// Finds the secure nodes, and permits their actions.
    fn secure(&mut self) {
        let mut secure = vec![true; self.nodes.len()];
        loop {
            let lost: Vec<usize> =
                (0..self.nodes.len()).filter(|&v| secure[v] && !self.stays(v, &secure)).collect();
            if lost.is_empty() {
                break;
            }
            lost.into_iter().for_each(|v| secure[v] = false);
        }
        for v in 0..self.nodes.len() {
            let keeps: Vec<bool> = self.nodes[v].actions.iter().map(|a| self.enters(v, a, &secure)).collect();
            let node = &mut self.nodes[v];
            node.secure = secure[v];
            if node.secure && node.ahead == Some(0) {
                node.actions.iter_mut().zip(keeps).for_each(|(action, keeps)| action.permitted &= keeps);
            }
            if node.actions.iter().all(|action| !action.permitted) {
                let nodes = &self.nodes;
                let keeps = |a: &ShieldAction| a.next.iter().all(|&to| nodes[to].class.is_some());
                let keeping: Vec<bool> = nodes[v].actions.iter().map(keeps).collect();
                permit(&mut self.nodes[v].actions, &keeping);
            }
            let node = &mut self.nodes[v];
            if !node.actions[node.pick].permitted {
                node.pick = node.actions.iter().position(|action| action.permitted).unwrap_or_default();
            }
        }
    }

    /// Returns whether a node is in the next approximation of the secure nodes.
    fn stays(&self, v: usize, secure: &[bool]) -> bool {
        let node = &self.nodes[v];
        let permitted = || node.actions.iter().filter(|action| action.permitted);
        let enters = |action| self.enters(v, action, secure);
        match node.ahead {
            Some(0) => permitted().any(enters),
            _ => permitted().count() > 0 && permitted().all(enters),
        }
    }

    /// Returns whether an action enters secure nodes only, and weakens nothing.
    fn enters(&self, v: usize, action: &ShieldAction, secure: &[bool]) -> bool {
        let reference = self.nodes[v].reference;
        action.next.iter().all(|&to| secure[to] && !self.weakens(reference, self.nodes[to].class))
    }

    /// Checks the table: its numbers are in range, every node permits an action, and the permitted
    /// steps of secure nodes enter secure nodes and weaken nothing. Returns the first fault.
    pub fn fault(&self) -> Option<String> {
        if self.starts > self.nodes.len() {
            return Some("there are more start states than nodes".to_owned());
        }
        if self.weakening.len() != self.classes.len() || !self.weakening.iter().all(|row| row.is_sorted()) {
            return Some("the weakening classes are not sorted, or not those of all classes".to_owned());
        }
        let found = (0..self.nodes.len()).find_map(|v| self.range_fault(v).map(|fault| (v, fault)));
        let secure: Vec<bool> = self.nodes.iter().map(|node| node.secure).collect();
        let weak = |v: usize| {
            let node = &self.nodes[v];
            let permitted = || node.actions.iter().filter(|a| a.permitted);
            let holds = permitted().count() > 0 && permitted().all(|a| self.enters(v, a, &secure));
            (node.secure && !holds).then(|| (v, "a permitted step weakens or ends the promise".to_owned()))
        };
        let found = found.or_else(|| (0..self.nodes.len()).find_map(weak));
        found.map(|(v, fault)| format!("node {v}: {fault}"))
    }

    fn range_fault(&self, v: usize) -> Option<String> {
        let node = &self.nodes[v];
        let classes = self.classes.len();
        let next = || node.actions.iter().flat_map(|action| &action.next);
        let wrong = node.state.len() != self.variables.len()
            || node.class.is_some_and(|class| class >= classes)
            || node.reference >= classes
            || next().any(|&to| to >= self.nodes.len())
            || node.actions.iter().any(|action| action.action >= self.actions.len())
            || !node.actions.get(node.pick).is_some_and(|action| action.permitted);
        wrong.then(|| "a number is out of range".to_owned())
    }
}

impl<E: Engine> FiniteMemoryStrategy<E> {
    fn fits_shields(&self) -> Result<()> {
        use super::{Safety, StrategyKind};
        let wrong = match (self.kind, self.improvement.safety, &self.rule) {
            (StrategyKind::Plan | StrategyKind::Achieve, ..) => "shields are for the kinds `sasi` and `spi`",
            (_, Safety::Transition, _) => {
                "under safety `transition`, permitted actions may weaken, so there is no shield; \
                 choose `action` or `prefix`"
            }
            (.., Some(_)) => "a shield permits all actions of the strategy; it does not choose by value",
            _ => return Ok(()),
        };
        Err(Error::Usage(wrong.to_owned()))
    }
}

impl<E: Engine> Builder<'_, E> {
    /// Enters all states of the scope. Returns their number.
    fn enter_all(&mut self) -> Result<usize> {
        let engine = self.strategy.whole.clone();
        for state in engine.list_states(&engine.all_states(), self.limit.saturating_add(1))? {
            let memory = self.strategy.start(&state)?;
            self.enter(state, memory)?;
        }
        Ok(self.index.len())
    }

    fn enter(&mut self, state: State, memory: Memory) -> Result<usize> {
        let number = self.index.len();
        if let Some(&found) = self.index.get(&(state.clone(), memory)) {
            return Ok(found);
        }
        if number >= self.limit {
            let what = format!("the shield has more than {} states with memory", self.limit);
            return Err(Limit::Size { what }.into());
        }
        self.index.insert((state.clone(), memory), number);
        self.queue.push_back((state, memory));
        Ok(number)
    }

    fn node(&mut self, state: &[i64], memory: Memory) -> Result<ShieldNode> {
        let at = self.strategy.explain(state, memory)?;
        let ahead = match memory.level {
            Rank::Finite(k) | Rank::AtLeast(k) => Some(k),
            Rank::Unbounded => None,
        };
        let (mut actions, mut pick) = (Vec::<ShieldAction>::new(), 0);
        // For each action: some of its choices is permitted; all of its choices keep the requirements.
        let (mut some, mut keeping) = (Vec::new(), Vec::new());
        for (position, action) in at.actions.iter().enumerate() {
            let label = self.label(&action.name);
            let place = actions.iter().position(|known| known.action == label).unwrap_or(actions.len());
            if place == actions.len() {
                actions.push(ShieldAction { action: label, permitted: true, next: Vec::new() });
                some.push(false);
                keeping.push(true);
            }
            let permits = permits(&at, action);
            some[place] |= permits;
            actions[place].permitted &= permits;
            keeping[place] &= action.successors.iter().all(|s| !s.is_unsafe);
            for successor in &action.successors {
                let next = self.enter(successor.state.clone(), successor.next)?;
                actions[place].next.push(next);
            }
            pick = if at.pick == Some(position) { place } else { pick };
        }
        // Choices with one label are permitted together; where none is, each permitted one counts.
        if actions.iter().all(|action| !action.permitted) && some.contains(&true) {
            let both: Vec<bool> = some.iter().zip(&keeping).map(|(some, keeps)| *some && *keeps).collect();
            let wanted = [&both, &keeping, &some].into_iter().find(|wanted| wanted.contains(&true));
            permit(&mut actions, wanted.unwrap_or(&some));
        }
        let class = (!at.is_unsafe).then(|| self.class(&at.most_preferred));
        let reference = self.class(&at.reference);
        Ok(ShieldNode { state: at.state, class, reference, ahead, secure: false, actions, pick })
    }

    /// Returns the number of the action of a choice `label` or `label(…)`.
    fn label(&mut self, name: &str) -> usize {
        let name = name.split('(').next().unwrap_or(name);
        position_or_push(&mut self.actions, |known| known == name, || name.to_owned())
    }

    fn class(&mut self, set: &ObjectiveSet) -> usize {
        position_or_push(&mut self.classes, |known| known == set, || set.clone())
    }

    fn finish(self, starts: usize) -> Shield {
        let strategy = self.strategy;
        let preferences = &strategy.preferences;
        let row = |from: &ObjectiveSet| {
            let weakens = |d: &usize| preferences.change(from, &self.classes[*d]) == Change::Weakening;
            (0..self.classes.len()).filter(weakens).collect()
        };
        let weakening = self.classes.iter().map(row).collect();
        let names = |set: &ObjectiveSet| preferences.names(set).into_iter().map(str::to_owned).collect();
        Shield {
            kind: strategy.kind.name().to_owned(),
            safety: strategy.improvement.safety.name().to_owned(),
            variables: variables(&strategy.program),
            classes: self.classes.iter().map(names).collect(),
            actions: self.actions,
            weakening,
            nodes: self.nodes,
            starts,
        }
    }
}

/// Permits the wanted actions; all, if none is wanted.
fn permit(actions: &mut [ShieldAction], wanted: &[bool]) {
    let none = !wanted.contains(&true);
    actions.iter_mut().zip(wanted).for_each(|(action, wanted)| action.permitted = *wanted || none);
}

/// Returns whether a shield may permit an action: one of the permissive strategy, or a kept one at
/// level 0.
fn permits(at: &Explanation, action: &Action) -> bool {
    match at.memory.level {
        Rank::Finite(0) => action.kept,
        _ => action.permitted,
    }
}

fn position_or_push<T>(all: &mut Vec<T>, is: impl Fn(&T) -> bool, new: impl FnOnce() -> T) -> usize {
    all.iter().position(is).unwrap_or_else(|| {
        all.push(new());
        all.len() - 1
    })
}

/// Returns the action labels of the model, without those that only monitors have.
fn labels(program: &Program) -> Vec<String> {
    let own = |action: usize| {
        let of = |command: &&crate::model::Command| command.action == Some(action);
        let monitor = program.monitors.as_ref().map(|monitors| monitors.module);
        program.commands.iter().filter(of).any(|command| Some(command.module) != monitor)
    };
    let named = program.actions.iter().enumerate();
    named.filter(|(action, _)| own(*action)).map(|(_, name)| name.clone()).collect()
}

fn variables(program: &Program) -> Vec<ShieldVariable> {
    let monitors = program.monitors.as_ref().map_or(&[][..], |monitors| &monitors.variables);
    let all = program.variables.iter().enumerate();
    all.map(|(index, variable)| ShieldVariable {
        name: variable.name.clone(),
        boolean: variable.ty == Type::Bool,
        low: variable.low,
        values: variable.values.clone(),
        monitor: variable.initial.filter(|_| monitors.iter().any(|id| id.index() == index)),
    })
    .collect()
}
