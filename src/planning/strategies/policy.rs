//! Policies of planners: one action for each state that they visit, and strong plans.

use ahash::AHashMap;

use meliora_base::error::{Error, Limit, Result};
use meliora_base::progress::Poll;
use meliora_base::value::Value;
use meliora_engine::Engine;
use meliora_model::predicate::Predicate;
use meliora_model::step::Step;
use meliora_model::{Program, State};

/// A policy: the states that it visits outside the goal, each with its action.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Policy {
    /// The entries, initial states first, then in the order in which they are visited.
    pub entries: Vec<PolicyEntry>,
}

/// A state with the action of a policy.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PolicyEntry {
    /// The state.
    pub state: State,
    /// The name of the choice; see [`Program::choices`].
    pub action: String,
    /// The least number of steps to the goal, among all actions that keep the goal sure.
    pub distance: usize,
}

/// A reason why a policy does not surely reach its goal.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PolicyFault {
    /// The policy has no action in a state that it visits.
    #[error("the policy visits the state {0}, for which it has no action")]
    Open(String),
    /// The action is not enabled in the state.
    #[error("the policy takes `{1}` in the state {0}, where it is not enabled")]
    Disabled(String, String),
    /// The goal is not reachable from the state by the policy.
    #[error("no path of the policy leads from the state {0} to the goal")]
    Lost(String),
}

/// Returns μX. G ∪ { s : we can choose a pair with all successors in X }: the states from which every
/// path of some strategy reaches the goal within a bound. Cost: one pre-image per layer.
///
/// # Errors
/// A limit.
pub fn strong_region<E: Engine>(engine: &E, goal: &E::States) -> Result<E::States> {
    let (choices, mut region) = (engine.all_choices(), goal.clone());
    loop {
        let sure = engine.can_choose(&engine.pre_within(&choices, &region)?)?;
        let next = engine.union(&region, &sure)?;
        if engine.same(&next, &region)? {
            return Ok(region);
        }
        region = next;
    }
}

impl Policy {
    /// Returns a policy that almost surely reaches the goal from each initial state, and visits at most
    /// `limit` states outside of it; `None` if there is none for some initial state. In each state it
    /// takes the first action that keeps the goal sure and may lead nearer.
    ///
    /// # Errors
    /// A limit.
    pub fn find<E: Engine>(
        engine: &E,
        program: &Program,
        goal: &E::States,
        limit: usize,
    ) -> Result<Option<Self>> {
        let region = engine.almost_surely_reach(goal, &engine.all_choices())?;
        if !engine.is_empty(&engine.difference(&engine.initial_states(), &region.states)?)? {
            return Ok(None);
        }
        let mut layers = vec![engine.intersection(goal, &region.states)?];
        while let Some(last) = layers.last() {
            let nearer = engine.sources(&engine.pre(&region.choices, last)?)?;
            let next = engine.union(last, &nearer)?;
            if engine.same(&next, last)? {
                break;
            }
            layers.push(next);
        }
        let found = Layers { engine, program, choices: &region.choices, layers: &layers };
        let initial = engine.list_states(&engine.initial_states(), limit)?;
        found.unfold(initial, limit).map(Some)
    }

    /// Checks that every path of the policy from the initial states stays in its states until it reaches
    /// the goal, and that the goal is reachable from each of them: then it is reached almost surely. Uses
    /// the program alone, state by state.
    ///
    /// # Errors
    /// The first fault in the order of the entries.
    pub fn check(
        &self,
        program: &Program,
        initial: &[State],
        goal: &Predicate,
    ) -> std::result::Result<(), PolicyFault> {
        let known: AHashMap<&State, usize> =
            self.entries.iter().zip(0..).map(|(e, at)| (&e.state, at)).collect();
        let is_goal = |state: &State| goal.eval(state) == Ok(Value::Bool(true));
        let open = |state: &State| PolicyFault::Open(program.show_state(state));
        if let Some(state) = initial.iter().find(|state| !known.contains_key(state) && !is_goal(state)) {
            return Err(open(state));
        }
        let mut before: Vec<Vec<usize>> = vec![Vec::new(); self.entries.len()];
        let mut near: Vec<usize> = Vec::new();
        for (at, entry) in self.entries.iter().enumerate() {
            let steps = program.exact_steps(&entry.state).unwrap_or_default();
            let Some(step) = steps.into_iter().find(|step| step.name == entry.action) else {
                return Err(PolicyFault::Disabled(program.show_state(&entry.state), entry.action.clone()));
            };
            for (next, _) in &step.successors {
                match known.get(next) {
                    _ if is_goal(next) => near.push(at),
                    Some(&next) => before[next].push(at),
                    None => return Err(open(next)),
                }
            }
        }
        let mut reaches = vec![false; self.entries.len()];
        while let Some(at) = near.pop() {
            if !std::mem::replace(&mut reaches[at], true) {
                near.extend(&before[at]);
            }
        }
        match reaches.iter().position(|reaches| !reaches) {
            Some(at) => Err(PolicyFault::Lost(program.show_state(&self.entries[at].state))),
            None => Ok(()),
        }
    }
}

/// The states by their distance to the goal.
struct Layers<'e, E: Engine> {
    engine: &'e E,
    program: &'e Program,
    /// The choices that keep the goal sure.
    choices: &'e E::Choices,
    /// The states at most this far from the goal.
    layers: &'e [E::States],
}

impl<E: Engine> Layers<'_, E> {
    /// Returns the least number of steps to the goal.
    fn distance(&self, state: &[i64]) -> Result<usize> {
        let (mut low, mut high) = (0, self.layers.len() - 1);
        while low < high {
            let middle = usize::midpoint(low, high);
            match self.engine.contains(&self.layers[middle], state)? {
                true => high = middle,
                false => low = middle + 1,
            }
        }
        Ok(low)
    }

    fn unfold(&self, initial: Vec<State>, limit: usize) -> Result<Policy> {
        let mut poll = Poll::new(&*self.engine.settings().sink);
        let mut seen: ahash::AHashSet<State> = initial.iter().cloned().collect();
        let (mut open, mut entries) = (std::collections::VecDeque::from(initial), Vec::new());
        while let Some(state) = open.pop_front() {
            poll.step()?;
            let distance = self.distance(&state)?;
            if distance == 0 {
                continue;
            }
            if entries.len() == limit {
                return Err(Limit::Listed(limit as u64).into());
            }
            let step = self.step(&state, distance)?;
            for (next, _) in step.successors {
                if seen.insert(next.clone()) {
                    open.push_back(next);
                }
            }
            entries.push(PolicyEntry { state, action: step.name, distance });
        }
        Ok(Policy { entries })
    }

    /// Returns the first step of a state that keeps the goal sure and may lead nearer.
    fn step(&self, state: &[i64], distance: usize) -> Result<Step> {
        let lost = || Error::Usage("a state of the policy has no action that leads to the goal".to_owned());
        for step in self.program.steps(state).map_err(|_| lost())? {
            if !self.engine.contains_choice(self.choices, state, &step.choice)? {
                continue;
            }
            for (next, _) in &step.successors {
                if self.engine.contains(&self.layers[distance - 1], next)? {
                    return Ok(step);
                }
            }
        }
        Err(lost())
    }
}
