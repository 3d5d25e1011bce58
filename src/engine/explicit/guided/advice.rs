//! Paths of the policy that are tried from other states, too.
//!
//! A path needs the values of some variables only: those that its commands read on the way, unless they wrote them
//! before, and those of the target. From a state with the same values of these, the same outcomes of the same commands
//! lead to the target, whatever else is true (the regression of PRP). The steps are taken one by one as those of a
//! search, so a path that fails is only left.

use std::sync::Arc;

use ahash::{AHashMap, RandomState};

use super::Guided;
use super::relaxation::outcomes;
use meliora_base::error::Result;
use meliora_model::{Branch, CommandId, Program, VarId};
use meliora_space::expand::Expand;
use meliora_space::index::{self, NOBODY};

/// The states of paths by the variables and values that they need.
pub(super) struct Advice {
    /// For each state the variables that its path needs.
    pub(super) needs: AHashMap<u32, Arc<[VarId]>>,
    lists: Vec<Similar>,
    /// The positions of the lists by their variables.
    numbers: AHashMap<Arc<[VarId]>, usize>,
    /// The lists that were looked at.
    pub(super) looks: u64,
    /// The work spent with advice.
    work: u64,
    hasher: RandomState,
}

/// The states whose paths need the same variables.
struct Similar {
    needed: Arc<[VarId]>,
    /// The states by a hash of the values of these variables.
    states: AHashMap<u64, u32>,
}

/// Returns the hash of the values of some variables.
fn hash(hasher: &RandomState, needed: &[VarId], values: &[i64]) -> u64 {
    index::hash(hasher, needed.iter().map(|variable| values[variable.index()] as u64))
}

impl Advice {
    pub(super) fn new() -> Self {
        let (lists, hasher) = (Vec::new(), index::hasher());
        Advice { needs: AHashMap::new(), lists, numbers: AHashMap::new(), looks: 0, work: 0, hasher }
    }

    /// Adds a state whose path needs some variables.
    fn add(&mut self, state: u32, needed: Arc<[VarId]>, values: &[i64]) {
        let next = self.lists.len();
        let at = *self.numbers.entry(Arc::clone(&needed)).or_insert(next);
        if at == next {
            self.lists.push(Similar { needed: Arc::clone(&needed), states: AHashMap::new() });
        }
        self.lists[at].states.insert(hash(&self.hasher, &needed, values), state);
        self.needs.insert(state, needed);
    }

    /// Returns a state that agrees with these values in all that its path needs.
    pub(super) fn find(&mut self, values: &[i64]) -> Option<u32> {
        self.lists.iter().rev().find_map(|similar| {
            self.looks += 1;
            similar.states.get(&hash(&self.hasher, &similar.needed, values)).copied()
        })
    }
}

impl Guided {
    /// Adds what the states of a path need, the last one first.
    pub(super) fn learn(&mut self, path: &[(u32, u32, u32)]) {
        let program = self.task.program.clone();
        for &(state, choice, to) in path {
            let after = match self.part.standing[to as usize].is_target {
                true => Some(self.target.support.clone().into()),
                false => self.advice.needs.get(&to).cloned(),
            };
            let (values, later) = (self.values(state), self.values(to));
            let id = CommandId(self.part.command_of(choice));
            let branch = branch(&program, id, &values, &later);
            let (Some(after), Some(branch)) = (after, branch) else { return };
            self.advice.add(state, before(&program, id, branch, &after), &values);
        }
    }

    /// Follows advice from a state without a choice, unless that has taken more work than all else so far. Returns whether
    /// a path becomes part of the policy.
    pub(super) fn is_led(&mut self, stepper: &mut dyn Expand, start: u32) -> Result<bool> {
        let before = self.work();
        if self.advice.work > before / 2 {
            return Ok(false);
        }
        let is_led = self.follow_advice(stepper, start)?;
        self.advice.work += self.work() - before;
        Ok(is_led)
    }

    /// Follows the path of a similar state from a state without a choice. Returns whether it becomes part of the policy.
    fn follow_advice(&mut self, stepper: &mut dyn Expand, start: u32) -> Result<bool> {
        let program = self.task.program.clone();
        let (mut state, mut edge, mut values) = (start, NOBODY, self.values(start));
        let mut like = self.advice.find(&values);
        while let Some(similar) = like {
            let Some(step) = self.part.step(similar) else { break };
            self.search.enter(state, edge)?;
            let standing = self.part.standing[state as usize];
            if standing.is_lost || !standing.is_expanded && !self.expand(stepper, state)? {
                break;
            }
            let id = CommandId(self.part.command_of(step.choice));
            let is_same = |&choice: &u32| self.part.is_open(choice) && self.part.command_of(choice) == id.0;
            let choice = self.part.choices_of(state).find(is_same);
            let branch = branch(&program, id, &self.values(similar), &self.values(step.next));
            let (Some(choice), Some(branch)) = (choice, branch) else { break };
            let leads =
                |&edge: &u32| leads(&program, id, branch, &values, &self.values(self.part.successor(edge)));
            let Some(next) = self.part.edges_of(choice).find(leads) else { break };
            let to = self.part.successor(next);
            if self.part.leads_on(to) {
                self.adopt(stepper, state, choice, to)?;
                return Ok(true);
            }
            if self.search.has_entered(to) {
                break;
            }
            (state, edge, values, like) = (to, next, self.values(to), Some(step.next));
        }
        Ok(false)
    }

    fn values(&self, state: u32) -> Vec<i64> {
        let mut values = vec![0; self.task.program.variables.len()];
        self.task.layout.decode(self.part.index.code(state as usize), &mut values);
        values
    }
}

/// Returns an outcome of a command that leads from some values to others; `None` also for several commands.
fn branch<'p>(program: &'p Program, id: CommandId, values: &[i64], later: &[i64]) -> Option<&'p Branch> {
    let is_one = id.0 != NOBODY;
    is_one.then(|| outcomes(program, id).find(|branch| leads(program, id, branch, values, later))).flatten()
}

fn leads(program: &Program, id: CommandId, branch: &Branch, values: &[i64], later: &[i64]) -> bool {
    program.new_values(id, branch, values).is_ok_and(|new| {
        let mut found = values.to_vec();
        new.into_iter().for_each(|(variable, value)| found[variable] = value);
        found == later
    })
}

/// Returns the variables that matter before an outcome of a command, if some matter after it.
fn before(program: &Program, id: CommandId, branch: &Branch, after: &[VarId]) -> Arc<[VarId]> {
    let written = |variable: &VarId| branch.updates.iter().any(|(own, _)| own == variable);
    let mut needed: Vec<VarId> = after.iter().copied().filter(|variable| !written(variable)).collect();
    needed.extend(program.pool.support(program.commands[id.index()].guard));
    for &(variable, new) in &branch.updates {
        if after.binary_search(&variable).is_ok() {
            needed.extend(program.pool.support(new));
        }
    }
    needed.sort_unstable();
    needed.dedup();
    needed.into()
}
