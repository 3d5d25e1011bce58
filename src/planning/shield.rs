//! Shields: the permitted actions of all states with memory, as a table that needs no model.
//!
//! A node is a state with the memory of a finite-memory strategy. While improvements are ahead, a
//! shield permits the actions of the permissive strategy. At level 0 it permits the kept actions
//! that lead to secure nodes only. A node is *secure* if no permitted step ever weakens from it on:
//!
//! Secure = νZ. { v : v permits an action, each of them enters Z only, weakens nothing, and changes
//! the reference by an improvement only }, where a node of level 0 permits the actions that do.
//!
//! In a node that is not secure, a shield permits the actions of the permissive strategy or the
//! kept ones, and all actions if there are none.
//!
//! In a game, a shield permits all actions of a state of the opponent: it forbids nothing there, and an
//! episode follows the step that the opponent takes. So these nodes are secure if each of their actions
//! enters secure nodes and weakens nothing, and where improvements are ahead or an objective is pursued,
//! each of them leads on. What the shield of a game promises holds against every strategy of the
//! opponent, as long as we take permitted actions and the real system has only the steps of the model.
//!
//! While a plan, or a strategy of the kind `achieve`, pursues an objective, a shield permits the actions
//! with which it stays sure. Permitted steps then lead to nodes that pursue one, too, and can achieve it.

mod fault;

use std::collections::VecDeque;

use ahash::AHashMap;
use serde::{Deserialize, Deserializer, Serialize};

use super::explain::{Action, Explanation};
use super::finite_memory::{FiniteMemoryStrategy, Memory};
use super::levels::Rank;
use super::safety::Safety;
use meliora_engine::Engine;
use meliora_model::error::{Error, Limit, Result};
use meliora_model::preference::{Change, ObjectiveSet};
use meliora_model::value::Type;
use meliora_model::{Program, State};

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
    #[serde(deserialize_with = "present")]
    pub monitor: Option<i64>,
}

/// A state with memory.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShieldNode {
    /// The values of the variables.
    pub state: State,
    /// True if the opponent of a game chooses here.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub theirs: bool,
    /// The class of the state; `None` if it is unsafe under the requirements.
    #[serde(deserialize_with = "present")]
    pub class: Option<usize>,
    /// The class that steps are compared with.
    pub reference: usize,
    /// The number of improvements ahead; `None` if it is unbounded.
    #[serde(deserialize_with = "present")]
    pub ahead: Option<usize>,
    /// True if no permitted step ever weakens from here on.
    pub secure: bool,
    /// The objectives that are pursued here, together if there are several.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pursues: Vec<String>,
    /// True if they are achieved or, if no step achieves them, kept from here on without a further
    /// condition.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub achieved: bool,
    /// The enabled actions.
    pub actions: Vec<ShieldAction>,
    /// The permitted action that a correction takes, a position in `actions`.
    pub pick: usize,
}

impl ShieldNode {
    /// Returns whether we choose here and nothing is ahead: no improvement, and no objective.
    fn is_at_rest(&self) -> bool {
        self.ahead == Some(0) && self.pursues.is_empty() && !self.theirs
    }
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

/// Reads a field that may be `null`, and may not be left out: without `ahead`, a table would promise
/// any number of improvements.
fn present<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
    from: D,
) -> std::result::Result<Option<T>, D::Error> {
    Option::deserialize(from)
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
    /// Computes the shield of a strategy, for episodes that start in any state of the scope. Cost: that
    /// of [`FiniteMemoryStrategy::explain`] per node.
    ///
    /// # Errors
    /// The errors of [`FiniteMemoryStrategy::explain`]; [`Limit::Size`] if there are more than
    /// `limit` nodes; [`Error::Usage`] for strategies that choose by value, with `safety = transition`,
    /// and if choices with one label cannot be permitted together.
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
        let together = |fault| {
            let advice = "a shield permits choices with one label together; give them different labels";
            Error::Usage(format!("{fault}: {advice}"))
        };
        shield.check_pursuit().map_err(together)?;
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
            let enters = |action| self.enters(v, action, |to| secure[to]);
            let keeps: Vec<bool> = self.nodes[v].actions.iter().map(enters).collect();
            let node = &mut self.nodes[v];
            node.secure = secure[v];
            if node.secure && node.is_at_rest() {
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
        // An unsafe state belongs to no class; nothing is promised there.
        if node.class.is_none() {
            return false;
        }
        let permitted = || node.actions.iter().filter(|action| action.permitted);
        let enters = |action| self.enters(v, action, |to| secure[to]);
        match node.is_at_rest() {
            true => permitted().any(enters),
            false => permitted().count() > 0 && permitted().all(enters),
        }
    }

    /// Returns whether an action enters secure nodes only, weakens nothing, and keeps the reference
    /// until an improvement.
    fn enters(&self, v: usize, action: &ShieldAction, secure: impl Fn(usize) -> bool) -> bool {
        let node = &self.nodes[v];
        action.next.iter().all(|&to| {
            let weakens = self.weakens(node.reference, self.nodes[to].class);
            secure(to) && !weakens && self.keeps_reference(node, to)
        })
    }
}

impl<E: Engine> FiniteMemoryStrategy<E> {
    fn fits_shields(&self) -> Result<()> {
        let safety = self.improvement.safety;
        let wrong = if !safety.never_weakens() {
            let others = fault::either(&safe_modes());
            format!(
                "under safety `{safety}`, permitted actions may weaken, so there is no shield; choose {others}"
            )
        } else if self.rule.is_some() {
            "a shield permits all actions of the strategy; it does not choose by value".to_owned()
        } else {
            return Ok(());
        };
        Err(Error::Usage(wrong))
    }
}

/// Returns the names of the safety modes that shields are for.
fn safe_modes() -> Vec<&'static str> {
    let safe = Safety::ALL.iter().filter(|mode| mode.never_weakens());
    safe.map(|mode| mode.name()).collect()
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
        let mut labels = Vec::<Labelled>::new();
        for action in &at.actions {
            let number = self.label(&action.name);
            let place =
                position_or_push(&mut labels, |known| known.action == number, || Labelled::new(number));
            labels[place].add(&at, action);
            for successor in &action.successors {
                labels[place].next.push(self.enter(successor.state.clone(), successor.next)?);
            }
        }
        let theirs = at.is_theirs();
        if !theirs && ahead != Some(0) && !labels.iter().any(|label| label.progress && label.keeps) {
            return Err(self.inseparable(&at));
        }
        let (mut actions, pick) = together(labels);
        if theirs {
            actions.iter_mut().for_each(|action| action.permitted = true);
        }
        let class = (!at.is_unsafe).then(|| self.class(&at.most_preferred));
        let reference = self.class(&at.reference);
        let pursues = self.strategy.preferences.owned_names(&at.aims);
        let kept = memory.pursuit.is_some_and(|pursuit| self.strategy.keeps(pursuit));
        let (secure, achieved) = (false, kept || at.is_achieved());
        let state = at.state;
        Ok(ShieldNode { state, theirs, class, reference, ahead, secure, pursues, achieved, actions, pick })
    }

    /// Returns the error of a state in which every label with a choice that makes progress also has one
    /// that violates the requirements.
    fn inseparable(&self, at: &Explanation) -> Error {
        let state = self.strategy.program.show_state(&at.state);
        let choices: Vec<&str> =
            at.actions.iter().filter(|action| action.progress).map(|action| action.name.as_str()).collect();
        Error::Usage(format!(
            "a shield permits choices with one label together: in the state {state}, `{}` makes progress, and \
             another choice with its label violates the requirements; give them different labels",
            choices.join("` or `")
        ))
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

/// The choices of a node with one label.
struct Labelled {
    action: usize,
    /// True if all are permitted.
    all: bool,
    /// True if some are permitted.
    some: bool,
    /// True if some permitted one makes progress.
    progress: bool,
    /// True if none enters an unsafe state.
    keeps: bool,
    next: Vec<usize>,
}

impl Labelled {
    fn new(action: usize) -> Self {
        Labelled { action, all: true, some: false, progress: false, keeps: true, next: Vec::new() }
    }

    fn add(&mut self, at: &Explanation, action: &Action) {
        let permits = permits(at, action);
        self.all &= permits;
        self.some |= permits;
        self.progress |= permits && action.progress;
        self.keeps &= action.successors.iter().all(|s| !s.is_unsafe);
    }

    /// Returns the rank of the label: 0 if all choices are permitted or, where no such label makes
    /// progress (`stuck`), a permitted one does; 1 if some choice is permitted; 2 if none is. A label
    /// that violates the requirements comes last, unless all its choices are permitted.
    fn rank(&self, stuck: bool) -> usize {
        let usual = self.all || stuck && self.progress && self.keeps;
        let ways = [usual, self.some && self.keeps, self.keeps, self.some];
        ways.iter().position(|applies| *applies).unwrap_or(ways.len())
    }
}

/// Permits the labels of the least rank; none if no choice is permitted, and [`Shield::secure`]
/// decides. Returns the actions, and the position of one to pick: it makes progress if any does.
fn together(labels: Vec<Labelled>) -> (Vec<ShieldAction>, usize) {
    let stuck = !labels.iter().any(|label| label.all && label.progress);
    let ranks = Vec::from_iter(labels.iter().map(|label| label.rank(stuck)));
    let least = ranks.iter().copied().min().filter(|_| labels.iter().any(|label| label.some));
    let permitted = |at: &usize| Some(ranks[*at]) == least;
    let pick = (0..labels.len()).filter(permitted).min_by_key(|&at| !labels[at].progress);
    let action = |(at, label): (usize, Labelled)| ShieldAction {
        action: label.action,
        permitted: permitted(&at),
        next: label.next,
    };
    let pick = pick.unwrap_or_default();
    (labels.into_iter().enumerate().map(action).collect(), pick)
}

/// Permits the wanted actions; all, if none is wanted.
fn permit(actions: &mut [ShieldAction], wanted: &[bool]) {
    let none = !wanted.contains(&true);
    actions.iter_mut().zip(wanted).for_each(|(action, wanted)| action.permitted = *wanted || none);
}

/// Returns whether a shield may permit an action: one of the permissive strategy, or a kept one at
/// level 0 if no objective is pursued.
fn permits(at: &Explanation, action: &Action) -> bool {
    match at.memory.level {
        Rank::Finite(0) if at.aims.is_empty() => action.kept,
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
        let of = |command: &&meliora_model::Command| command.action == Some(action);
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
