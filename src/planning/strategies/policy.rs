//! Policies of planners: one action for each state that they visit, and strong plans.

use meliora_base::error::{Error, Limit, Result};
use meliora_base::progress::Poll;
use meliora_engine::{Engine, Guided, Guiding};
use meliora_model::planning::plain;
use meliora_model::step::{Choice, Step};
use meliora_model::{Program, State};

/// A policy: the states that it visits outside the goal, each with its action.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Policy {
    /// The initial states of the model.
    pub initial: Vec<State>,
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
    /// The position among the choices of the state, if another one has the same name.
    pub position: Option<usize>,
    /// The least number of steps to the goal, among all actions that keep the goal sure; for a policy of a guided
    /// search, among those of the policy.
    pub distance: usize,
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
    /// Returns the policy of a guided search whose answer is yes; it visits at most `limit` states outside of the goal.
    ///
    /// # Errors
    /// A limit.
    pub fn of_search(search: &Guided, program: &Program, limit: usize) -> Result<Self> {
        let policy = search.policy()?;
        if policy.len() > limit {
            return Err(Limit::Listed(limit as u64).into());
        }
        let may_double = has_doubled_names(program);
        let entry = |Guiding { state, choice, name: action, distance }: Guiding| {
            let choices = if may_double { program.choices(&state).unwrap_or_default() } else { Vec::new() };
            let position = position(program, choices.iter().map(|(own, name)| (own, name.as_str())), &choice);
            PolicyEntry { state, action, position, distance }
        };
        Ok(Policy { initial: search.initial_states(), entries: policy.into_iter().map(entry).collect() })
    }

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
}

/// Returns whether two choices of a state may have one name.
fn has_doubled_names(program: &Program) -> bool {
    let mut known = ahash::AHashSet::new();
    program.planning.is_none() || !program.actions.iter().all(|action| known.insert(plain(action)))
}

/// Returns the position of a choice among those of its state, if another one has the same name.
fn position<'c>(
    program: &Program,
    choices: impl Iterator<Item = (&'c Choice, &'c str)> + Clone,
    choice: &Choice,
) -> Option<usize> {
    let at = choices.clone().position(|(own, _)| own == choice)?;
    let (_, name) = choices.clone().nth(at)?;
    (choices.filter(|(_, other)| program.is_same_name(name, other)).count() > 1).then_some(at)
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
        let (mut open, mut entries) = (std::collections::VecDeque::from(initial.clone()), Vec::new());
        while let Some(state) = open.pop_front() {
            poll.step()?;
            let distance = self.distance(&state)?;
            if distance == 0 {
                continue;
            }
            if entries.len() == limit {
                return Err(Limit::Listed(limit as u64).into());
            }
            // The commands of a state are work, for an engine that has turns.
            self.engine.settings().sink.advance(self.program.commands.len() as u64);
            let (step, position) = self.step(&state, distance)?;
            for (next, _) in step.successors {
                if seen.insert(next.clone()) {
                    open.push_back(next);
                }
            }
            entries.push(PolicyEntry { state, action: step.name, position, distance });
        }
        Ok(Policy { initial, entries })
    }

    /// Returns the first step of a state that keeps the goal sure and may lead nearer, with its position if another one has
    /// its name.
    fn step(&self, state: &[i64], distance: usize) -> Result<(Step, Option<usize>)> {
        let lost = || Error::Usage("a state of the policy has no action that leads to the goal".to_owned());
        let steps = self.program.steps(state).map_err(|_| lost())?;
        for step in &steps {
            if !self.engine.contains_choice(self.choices, state, &step.choice)? {
                continue;
            }
            for (next, _) in &step.successors {
                if self.engine.contains(&self.layers[distance - 1], next)? {
                    let choices = steps.iter().map(|own| (&own.choice, own.name.as_str()));
                    return Ok((step.clone(), position(self.program, choices, &step.choice)));
                }
            }
        }
        Err(lost())
    }
}
