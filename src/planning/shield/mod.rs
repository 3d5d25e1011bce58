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
//! kept ones. If there are none, it permits those that keep the requirements, and in an unsafe state,
//! where none does, all actions.
//!
//! An action is a label, and stands for each choice with this label: the system may take any of them.
//! An action is permitted only if all its choices are. Where the strategy makes progress, some
//! action makes progress with each of its choices. Everything that a node says then holds for every
//! choice of every permitted action. A strategy that has no such actions in some state has no shield.
//!
//! In a game, a shield permits all actions of a state of the opponent: it forbids nothing there, and an
//! episode follows the step that the opponent takes. So these nodes are secure if each of their actions
//! enters secure nodes and weakens nothing, and where improvements are ahead or an objective is pursued,
//! each of them leads on. What the shield of a game promises holds against every strategy of the
//! opponent, as long as we take permitted actions and the real system has only the steps of the model.
//!
//! While a plan, or a strategy of the kind `achieve`, pursues an objective, a shield permits the actions
//! with which it stays sure. Permitted steps then lead to nodes that pursue one, too, and can achieve it.

pub mod by_value;
mod fault;

use std::collections::VecDeque;

use ahash::AHashMap;
pub use by_value::ValueRule;
use serde::{Deserialize, Deserializer, Serialize};

use crate::analysis::Safety;
use crate::analysis::levels::Rank;
use crate::strategies::explain::{Action, Explanation};
use crate::strategies::finite_memory::{FiniteMemoryStrategy, Memory};
use meliora_base::error::{Error, Limit, Result};
use meliora_base::value::Type;
use meliora_engine::Engine;
use meliora_model::preference::{Change, ObjectiveSet};
use meliora_model::{Program, State};

/// A table of permitted actions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shield {
    /// The kind of the strategy, or [`by_value::SAFETY`].
    pub kind: String,
    /// The safety mode.
    pub safety: String,
    /// The rule of a shield by value; `None` for that of a strategy.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rule: Option<ValueRule>,
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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
    /// True if no permitted step ever weakens from here on; by value, if the permitted actions reach the threshold.
    pub secure: bool,
    /// The objectives that are pursued here, together if there are several.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pursues: Vec<String>,
    /// True if they are achieved or, if no step achieves them, kept from here on without a further
    /// condition.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub achieved: bool,
    /// By value, true if the formula is true or false here whatever follows.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub decided: bool,
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

/// An enabled action of a node: all choices with one label; by value, one choice.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShieldAction {
    /// A position in [`Shield::actions`].
    pub action: usize,
    /// True if the shield permits it.
    pub permitted: bool,
    /// By value, the bounds of its value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<[f64; 2]>,
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
    /// and if in some state choices with one label would have to be told apart.
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
            let enters = |action| self.enters(v, action, |to| secure[to]);
            let keeps: Vec<bool> = self.nodes[v].actions.iter().map(enters).collect();
            let node = &mut self.nodes[v];
            node.secure = secure[v];
            if node.secure && node.is_at_rest() {
                node.actions.iter_mut().zip(keeps).for_each(|(action, keeps)| action.permitted &= keeps);
            }
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
        for (position, action) in at.actions.iter().enumerate() {
            let number = self.label(&action.name);
            let place =
                position_or_push(&mut labels, |known| known.action == number, || Labelled::new(number));
            labels[place].choices.push(position);
            for successor in &action.successors {
                labels[place].next.push(self.enter(successor.state.clone(), successor.next)?);
            }
        }
        let theirs = at.is_theirs();
        let (permitted, pick) = self.permitted(&at, &labels)?;
        let action = |(label, permitted): (Labelled, bool)| ShieldAction {
            action: label.action,
            permitted,
            value: None,
            next: label.next,
        };
        let actions = labels.into_iter().zip(permitted).map(action).collect();
        let class = (!at.is_unsafe).then(|| self.class(&at.most_preferred));
        let reference = self.class(&at.reference);
        let pursues = self.strategy.preferences.owned_names(&at.aims);
        let kept = memory.pursuit.is_some_and(|pursuit| self.strategy.keeps(pursuit));
        let (secure, achieved) = (false, kept || at.is_achieved());
        let state = at.state;
        let decided = false;
        Ok(ShieldNode {
            state,
            theirs,
            class,
            reference,
            ahead,
            secure,
            pursues,
            achieved,
            decided,
            actions,
            pick,
        })
    }

    /// Returns which labels are permitted, and the position of one to pick: it makes progress if any
    /// does.
    fn permitted(&self, at: &Explanation, labels: &[Labelled]) -> Result<(Vec<bool>, usize)> {
        let all = vec![true; labels.len()];
        if at.is_theirs() {
            return Ok((all, 0));
        }
        let permits = |action: &Action| permits(at, action);
        let first = |labels: &[bool]| labels.iter().position(|fits| *fits);
        let permitted = self.told_apart(at, labels, permits, "is permitted")?;
        let progress =
            self.told_apart(at, labels, |action| permits(action) && action.progress, "makes progress")?;
        if let Some(pick) = first(&progress).or(first(&permitted)) {
            return Ok((permitted, pick));
        }
        let keeping = match at.is_unsafe {
            // Nothing is promised there.
            true => labels.iter().map(|label| label.all(at, keeps)).collect(),
            false => self.told_apart(at, labels, keeps, "keeps the requirements")?,
        };
        Ok(first(&keeping).map_or((all, 0), |pick| (keeping, pick)))
    }

    /// Returns the labels of which all choices fit.
    ///
    /// # Errors
    /// Some choice fits, but each label has one that does not.
    fn told_apart(
        &self,
        at: &Explanation,
        labels: &[Labelled],
        fits: impl Fn(&Action) -> bool,
        said: &str,
    ) -> Result<Vec<bool>> {
        let found = labels.iter().map(|label| label.all(at, &fits)).collect::<Vec<_>>();
        let fitting = at.actions.iter().find(|action| fits(action));
        let Some(action) = fitting.filter(|_| !found.contains(&true)) else { return Ok(found) };
        let state = self.strategy.program.show_state(&at.state);
        Err(Error::Usage(format!(
            "a shield permits choices with one label together: in the state {state}, `{}` {said}, but not \
             every choice with its label; give them different labels",
            action.name
        )))
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
            rule: None,
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
    /// Their positions in [`Explanation::actions`].
    choices: Vec<usize>,
    next: Vec<usize>,
}

impl Labelled {
    fn new(action: usize) -> Self {
        Labelled { action, choices: Vec::new(), next: Vec::new() }
    }

    fn all(&self, at: &Explanation, fits: impl Fn(&Action) -> bool) -> bool {
        self.choices.iter().all(|&choice| fits(&at.actions[choice]))
    }
}

/// Returns whether an action keeps the requirements: no successor is unsafe.
fn keeps(action: &Action) -> bool {
    action.successors.iter().all(|successor| !successor.is_unsafe)
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
