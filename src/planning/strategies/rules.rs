//! Policies as lists of rules, which are checked and run state by state with the program alone, without an
//! engine.

use std::fmt;

use ahash::AHashMap;

use super::policy::Policy;
use meliora_base::error::{Limit, Result};
use meliora_base::exact::Ratio;
use meliora_base::progress::{Poll, ProgressSink};
use meliora_base::random::Draw;
use meliora_base::value::Value;
use meliora_model::planning::plain;
use meliora_model::predicate::Predicate;
use meliora_model::step::{Step, StepError};
use meliora_model::{ModelKind, Program, State, VarId};

/// A condition of a rule: a variable has a value, or has it not.
pub type Literal = (VarId, i64, bool);

/// A policy: actions for states and for conditions.
#[derive(Debug, Clone, Default)]
pub struct Rules {
    /// The actions of single states.
    states: AHashMap<State, String>,
    /// Conditions with their actions, for all other states; the first one that holds counts.
    conditions: Vec<(Vec<Literal>, String)>,
}

/// A reason why a policy does not reach its goal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PolicyFault {
    /// The first state with the fault.
    pub state: State,
    /// The fault.
    pub kind: FaultKind,
}

/// The faults of a policy in a state.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FaultKind {
    /// An action is missing.
    Open,
    /// This action is not enabled.
    Disabled(String),
    /// The goal is not reachable.
    Lost,
    /// The state may be visited again.
    Cycle,
}

impl fmt::Display for FaultKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FaultKind::Open => f.write_str("the policy has no action in a state that it visits"),
            FaultKind::Disabled(action) => {
                write!(f, "the policy takes `{action}` in a state where this is not enabled")
            }
            FaultKind::Lost => {
                f.write_str("no path of the policy leads from a state that it visits to the goal")
            }
            FaultKind::Cycle => {
                f.write_str("the policy may visit a state again, so no bound limits its paths")
            }
        }
    }
}

/// The states that a policy visits.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Visited {
    /// The number of states outside the goal.
    pub states: usize,
    /// The number of states of the goal.
    pub goals: usize,
    /// The number of steps of the longest path to the goal; `None` without a bound.
    pub longest: Option<usize>,
}

/// A run of a policy.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PolicyRun {
    /// The steps: each action with the state that it is taken in.
    pub steps: Vec<(State, String)>,
    /// The state in which the run ends.
    pub last: State,
    /// Why it ends there: the goal is reached, or the policy has no action that is enabled. Without either, the
    /// limit of steps ended it.
    pub end: Option<std::result::Result<(), FaultKind>>,
}

/// The states found so far, with their successors.
#[derive(Default)]
struct Walk {
    states: Vec<State>,
    number: AHashMap<State, usize>,
    is_goal: Vec<bool>,
    next: Vec<Vec<usize>>,
}

fn holds(goal: &Predicate, state: &State) -> bool {
    goal.eval(state) == Ok(Value::Bool(true))
}

impl Rules {
    /// Adds a rule for one state; an earlier one counts.
    pub fn add_state(&mut self, state: State, action: &str) {
        self.states.entry(state).or_insert_with(|| plain(action));
    }

    /// Adds a rule for all other states that satisfy some conditions.
    pub fn add_condition(&mut self, conditions: Vec<Literal>, action: &str) {
        self.conditions.push((conditions, plain(action)));
    }

    /// Returns the action of a state, without spaces and capitals.
    fn action(&self, state: &State) -> Option<&str> {
        let fits = |(conditions, _): &&(Vec<Literal>, String)| {
            conditions.iter().all(|&(variable, value, is)| (state[variable.index()] == value) == is)
        };
        let of_state = self.states.get(state);
        of_state.or_else(|| self.conditions.iter().find(fits).map(|(_, action)| action)).map(String::as_str)
    }

    /// Checks that every path of the policy from the initial states ends in the goal almost surely: each state
    /// that it visits outside the goal has an enabled action, and the goal stays reachable. `is_strong` asks
    /// for a bound on the length of the paths. Cost: one step of the program per state.
    ///
    /// # Errors
    /// A limit. A fault of the policy is a result.
    pub fn check(
        &self,
        program: &Program,
        goal: &Predicate,
        initial: &[State],
        is_strong: bool,
        sink: &dyn ProgressSink,
    ) -> Result<std::result::Result<Visited, PolicyFault>, Limit> {
        let walk = match self.walk(program, goal, initial, sink)? {
            Ok(walk) => walk,
            Err(fault) => return Ok(Err(fault)),
        };
        let fault = |at: usize, kind| Ok(Err(PolicyFault { state: walk.states[at].clone(), kind }));
        if let Some(at) = walk.near().iter().position(|near| !near) {
            return fault(at, FaultKind::Lost);
        }
        let longest = walk.longest();
        if let (Err(at), true) = (longest, is_strong) {
            return fault(at, FaultKind::Cycle);
        }
        let goals = walk.is_goal.iter().filter(|is| **is).count();
        Ok(Ok(Visited { states: walk.states.len() - goals, goals, longest: longest.ok() }))
    }

    /// Follows the policy from the initial states.
    fn walk(
        &self,
        program: &Program,
        goal: &Predicate,
        initial: &[State],
        sink: &dyn ProgressSink,
    ) -> Result<std::result::Result<Walk, PolicyFault>, Limit> {
        let (mut walk, mut poll) = (Walk::default(), Poll::new(sink));
        let actions = synchronisations(program);
        for state in initial {
            walk.add(state, goal);
        }
        let mut at = 0;
        while at < walk.states.len() {
            poll.step()?;
            let mut next = Vec::new();
            if !walk.is_goal[at] {
                let state = walk.states[at].clone();
                match self.exact_step(program, &actions, &state) {
                    Ok(step) => next.extend(step.successors.iter().map(|(state, _)| walk.add(state, goal))),
                    Err(kind) => return Ok(Err(PolicyFault { state, kind })),
                }
            }
            walk.next.push(next);
            at += 1;
        }
        Ok(Ok(walk))
    }

    /// Takes the step of the policy in a state: if an action has its name, among those of this action.
    fn exact_step(
        &self,
        program: &Program,
        actions: &AHashMap<String, Vec<usize>>,
        state: &State,
    ) -> std::result::Result<Step<Ratio>, FaultKind> {
        if let Some(own) = self.action(state).and_then(|action| actions.get(action))
            && let Ok(step) = self.step(state, program.exact_steps_of(state, own))
        {
            return Ok(step);
        }
        self.step(state, program.exact_steps(state))
    }

    /// Takes the step of the policy among those of a state.
    fn step<W>(
        &self,
        state: &State,
        steps: std::result::Result<Vec<Step<W>>, StepError>,
    ) -> std::result::Result<Step<W>, FaultKind> {
        let action = self.action(state).ok_or(FaultKind::Open)?;
        let step = steps.unwrap_or_default().into_iter().find(|step| plain(&step.name) == action);
        step.ok_or_else(|| FaultKind::Disabled(action.to_owned()))
    }

    /// Runs the policy from a state until it reaches the goal, at most for some steps.
    pub fn run(
        &self,
        program: &Program,
        goal: &Predicate,
        start: &State,
        most: u64,
        draw: &mut Draw,
    ) -> PolicyRun {
        let (mut steps, mut last, mut end) = (Vec::new(), start.clone(), None);
        while end.is_none() {
            if holds(goal, &last) {
                end = Some(Ok(()));
                break;
            }
            if steps.len() as u64 == most {
                break;
            }
            match self.step(&last, program.steps(&last)) {
                Err(fault) => end = Some(Err(fault)),
                Ok(step) => {
                    let drawn = draw.by_probability(step.successors.iter().map(|(_, p)| *p));
                    let next = step.successors[drawn].0.clone();
                    steps.push((std::mem::replace(&mut last, next), step.name));
                }
            }
        }
        PolicyRun { steps, last, end }
    }
}

/// Returns the synchronisations of each action by its name, without spaces and capitals.
fn synchronisations(program: &Program) -> AHashMap<String, Vec<usize>> {
    let mut of_actions: AHashMap<String, Vec<usize>> = AHashMap::new();
    // In a Markov chain, all combinations together are the one choice.
    let all = program.synchronisations.iter().enumerate().filter(|_| program.kind != ModelKind::Dtmc);
    for (index, synchronisation) in all {
        if let Some(action) = synchronisation.action {
            of_actions.entry(plain(&program.actions[action])).or_default().push(index);
        }
    }
    of_actions
}

impl From<&Policy> for Rules {
    fn from(policy: &Policy) -> Self {
        let mut rules = Rules::default();
        policy.entries.iter().for_each(|entry| rules.add_state(entry.state.clone(), &entry.action));
        rules
    }
}

impl Walk {
    fn add(&mut self, state: &State, goal: &Predicate) -> usize {
        if let Some(&known) = self.number.get(state) {
            return known;
        }
        self.number.insert(state.clone(), self.states.len());
        self.states.push(state.clone());
        self.is_goal.push(holds(goal, state));
        self.states.len() - 1
    }

    fn before(&self) -> Vec<Vec<usize>> {
        let mut before = vec![Vec::new(); self.states.len()];
        for (at, next) in self.next.iter().enumerate() {
            next.iter().for_each(|&to| before[to].push(at));
        }
        before
    }

    fn goals(&self) -> Vec<usize> {
        (0..self.states.len()).filter(|&at| self.is_goal[at]).collect()
    }

    /// Returns for each state whether the goal is reachable.
    fn near(&self) -> Vec<bool> {
        let (before, mut open) = (self.before(), self.goals());
        let mut near = self.is_goal.clone();
        while let Some(at) = open.pop() {
            open.extend(before[at].iter().filter(|&&earlier| !std::mem::replace(&mut near[earlier], true)));
        }
        near
    }

    /// Returns the length of the longest path, or a state of a cycle or before one.
    fn longest(&self) -> std::result::Result<usize, usize> {
        let (before, mut open) = (self.before(), self.goals());
        let mut left: Vec<usize> = self.next.iter().map(Vec::len).collect();
        let mut longest = vec![0; self.states.len()];
        while let Some(at) = open.pop() {
            for &earlier in &before[at] {
                longest[earlier] = longest[earlier].max(longest[at] + 1);
                left[earlier] -= 1;
                if left[earlier] == 0 {
                    open.push(earlier);
                }
            }
        }
        match left.iter().position(|&left| left > 0) {
            Some(at) => Err(at),
            None => Ok(longest.into_iter().max().unwrap_or(0)),
        }
    }
}
