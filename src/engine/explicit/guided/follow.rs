//! The states of a closed policy.

use std::collections::VecDeque;

use super::{Guided, Guiding};
use ahash::{AHashMap, AHashSet};
use meliora_base::error::Result;
use meliora_base::progress::Poll;
use meliora_model::CommandId;
use meliora_model::step::Choice;
use meliora_space::expand::{self, Expand};

/// The states that a policy visits outside of the target, in the order in which it does.
#[derive(Default)]
pub(super) struct Visited {
    /// The states with a choice.
    states: Vec<u32>,
    /// The states without one.
    pub(super) open: Vec<u32>,
    /// The work: states and successors.
    pub(super) steps: u64,
}

impl Guided {
    /// Returns the states that the policy visits outside of the target, initial states first. The answer must be known to
    /// be yes.
    ///
    /// # Errors
    /// A limit is reached.
    pub fn policy(&self) -> Result<Vec<Guiding>> {
        let mut poll = Poll::new(&*self.task.limits.sink);
        let mut stepper = expand::stepper(&self.task.prepared, self.task.layout.words());
        let states = self.visited(VecDeque::pop_front).states;
        let distances = self.distances(&states);
        let mut policy = Vec::new();
        for state in states {
            poll.step()?;
            let Some(step) = self.part.step(state) else { continue };
            let code = self.part.index.code(state as usize);
            stepper.enter(&self.task.layout, code);
            stepper.expand().map_err(|broken| self.task.broken(broken, code))?;
            let (choice, name) = self.named(&*stepper, self.part.place_of(step.choice));
            let distance = distances.get(&state).copied().unwrap_or_default();
            policy.push(Guiding { state: self.task.values(code), choice, name, distance });
        }
        Ok(policy)
    }

    /// Follows the policy from the initial states; `next` takes a state out of those that are to be visited.
    pub(super) fn visited(&self, next: fn(&mut VecDeque<u32>) -> Option<u32>) -> Visited {
        let (mut waiting, mut seen) = (VecDeque::from(self.initial.clone()), AHashSet::new());
        let mut found = Visited::default();
        while let Some(state) = next(&mut waiting) {
            found.steps += 1;
            if self.part.standing[state as usize].is_target || !seen.insert(state) {
                continue;
            }
            let Some(step) = self.part.step(state) else {
                found.open.push(state);
                continue;
            };
            found.states.push(state);
            let edges = self.part.edges_of(step.choice);
            found.steps += edges.len() as u64;
            waiting.extend(edges.map(|edge| self.part.successor(edge)));
        }
        found
    }

    /// Returns the least number of steps of the policy from each of the states that it visits to the target.
    fn distances(&self, visited: &[u32]) -> AHashMap<u32, usize> {
        let (mut before, mut known, mut open) =
            (AHashMap::<u32, Vec<u32>>::new(), AHashMap::new(), VecDeque::new());
        for &state in visited {
            let Some(step) = self.part.step(state) else { continue };
            for to in self.part.edges_of(step.choice).map(|edge| self.part.successor(edge)) {
                before.entry(to).or_default().push(state);
                if self.part.standing[to as usize].is_target && known.insert(to, 0).is_none() {
                    open.push_back(to);
                }
            }
        }
        while let Some(state) = open.pop_front() {
            let next = known.get(&state).map_or(0, |distance: &usize| distance + 1);
            for &earlier in before.get(&state).into_iter().flatten() {
                if let std::collections::hash_map::Entry::Vacant(entry) = known.entry(earlier) {
                    entry.insert(next);
                    open.push_back(earlier);
                }
            }
        }
        known
    }

    /// Returns a choice of the state that was expanded last, and its name.
    fn named(&self, stepper: &dyn Expand, place: [usize; 2]) -> (Choice, String) {
        let program = &self.task.program;
        let [own, number] = place;
        let action = program.synchronisations[own].action;
        // Only choices with the same label decide how it is called.
        let is_alike = |index: &&usize| {
            **index == own || action.is_some() && program.synchronisations[**index].action == action
        };
        let (mut alike, mut at) = (Vec::new(), 0);
        for &index in stepper.active().iter().filter(is_alike) {
            for combination in 0..stepper.combinations(index) {
                if [index, combination] == [own, number] {
                    at = alike.len();
                }
                let commands = stepper.combination(index, combination).into_iter().map(CommandId);
                alike.push((index, commands.collect::<Vec<_>>()));
            }
        }
        let name = program.names(&alike).swap_remove(at);
        let (synchronisation, commands) = alike.swap_remove(at);
        (Choice::Combination { synchronisation, commands }, name)
    }
}
