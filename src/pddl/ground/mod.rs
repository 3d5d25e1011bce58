//! From a task to ground actions: the facts and actions that are reachable if nothing is ever
//! deleted, and their simplified conditions and effects.

pub(crate) mod action;
mod condition;
mod database;
mod derived;
mod earned;
mod join;
mod outcomes;
mod reach;
mod relevance;

pub(crate) use action::{GroundAction, GroundEffect, Outcome};
pub(crate) use condition::Ground;

use std::collections::BTreeSet;

use ahash::{AHashMap, AHashSet};

use crate::task::{Measure, Object, Task};
use database::Key;
use meliora_base::error::Result;
use meliora_base::progress::ProgressSink;
use reach::Reached;

/// A fact that can be true and can be false: its position in [`GroundTask::facts`].
pub(crate) type Fact = u32;

/// A predicate with its objects.
pub(crate) type GroundAtom = (usize, Vec<Object>);

/// A grounded task.
pub(crate) struct GroundTask {
    /// The facts that change.
    pub(crate) facts: Vec<GroundAtom>,
    /// For each initial state and each fact, whether it holds there.
    pub(crate) starts: Vec<Vec<bool>>,
    /// The derived facts, each with its condition over facts alone.
    pub(crate) derived: Vec<(GroundAtom, Ground)>,
    /// The facts that always hold, of predicates that actions change.
    pub(crate) constant: Vec<GroundAtom>,
    pub(crate) actions: Vec<GroundAction>,
    /// The measures of the problem; empty where only goals are asked about.
    pub(crate) measures: BTreeSet<Measure>,
    pub(crate) goal: Option<Ground>,
    pub(crate) preferences: Vec<(String, Ground)>,
}

/// The meaning of a ground atom.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Meaning {
    True,
    Fact(Fact),
    Derived(u32),
}

/// The atoms that hold in some state; all others never do.
pub(crate) struct Atoms {
    /// For each predicate, the meanings by the objects.
    known: Vec<AHashMap<Key, Meaning>>,
    /// For each predicate, whether actions change it or rules define it.
    changes: Vec<bool>,
}

impl Atoms {
    fn get(&self, predicate: usize, row: &[Object]) -> Option<Meaning> {
        self.known[predicate].get(row).copied()
    }

    fn insert(&mut self, predicate: usize, row: &[Object], meaning: Meaning) {
        self.known[predicate].insert(Key::from_slice(row), meaning);
    }
}

/// Grounds a task.
///
/// # Errors
/// A limit; an action with more than [`outcomes::MOST_OUTCOMES`] outcomes, or with an amount that has no value.
pub(crate) fn ground(task: &Task, sink: &dyn ProgressSink) -> Result<GroundTask> {
    sink.progress("grounding", &|| format!("{} actions", task.actions.len()));
    let reached = Reached::compute(task, sink)?;
    let deleted = reached.deleted(task, sink)?;
    let (mut atoms, facts, constant) = reached.facts(task, &deleted);
    let always: AHashSet<&GroundAtom> = task.initial.iter().collect();
    let holding = |more: &Vec<GroundAtom>| {
        let more: AHashSet<&GroundAtom> = more.iter().collect();
        facts.iter().map(|fact| always.contains(fact) || more.contains(fact)).collect()
    };
    let starts = task.starts.iter().map(holding).collect();
    let derived = derived::ground(task, &reached, &mut atoms, sink)?;
    let actions = action::ground(task, &reached, &atoms, sink)?;
    let condition = |condition: &crate::task::Condition| atoms.ground(condition, &mut Vec::new());
    Ok(GroundTask {
        goal: task.goal.as_ref().map(condition),
        preferences: task.preferences.iter().map(|(name, c)| (name.clone(), condition(c))).collect(),
        facts,
        starts,
        derived,
        constant,
        actions,
        measures: task.measures.clone(),
    })
}
