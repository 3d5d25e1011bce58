//! Policies as lists of rules, which are checked and run state by state with the program alone, without an
//! engine.

use std::collections::BTreeMap;
use std::fmt;

use ahash::{AHashMap, AHashSet};

use super::graph::Graph;
use meliora_base::error::{Limit, Result};
use meliora_base::exact::Ratio;
use meliora_base::progress::{Poll, ProgressSink};
use meliora_base::random::Draw;
use meliora_base::value::Value;
use meliora_model::planning::{Planning, plain};
use meliora_model::predicate::Predicate;
use meliora_model::step::Step;
use meliora_model::{Program, State, VarId};

/// A condition of a rule: a variable has a value, or has it not.
pub type Literal = (VarId, i64, bool);

/// A policy: rules in an order. In each state, the first rule whose conditions all hold gives the action.
#[derive(Debug, Clone, Default)]
pub struct Rules {
    rules: Vec<Rule>,
    /// The facts of a planning problem; for other models all values are facts.
    facts: Option<AHashSet<Fact>>,
    /// The first rule that names exactly these facts, and no others.
    exact: AHashMap<Vec<Fact>, usize>,
    /// The rules that name facts alone, by their number: they hold where more facts hold, too.
    fewer: BTreeMap<usize, Vec<usize>>,
    /// The rules with other conditions.
    others: Vec<usize>,
}

/// A variable with its value.
type Fact = (VarId, i64);

/// The conditions of a rule, and its action.
#[derive(Debug, Clone)]
struct Rule {
    conditions: Vec<Literal>,
    taken: Taken,
}

/// The action of a rule.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Taken {
    /// The name of the choice; see [`Program::choices`]. In planning problems, capitals do not count.
    pub action: String,
    /// The position among the choices of the state, which tells apart choices with one name.
    pub position: Option<usize>,
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
    /// Several choices have this name, and the policy gives no position.
    Ambiguous(String),
    /// The choice at this position has another name than this one, or there is none.
    Misplaced(String, usize),
    /// The goal is not reachable.
    Lost,
    /// The state may be visited again.
    Cycle,
    /// A node with memory contradicts the model, or its promise is not kept.
    Broken(String),
}

impl fmt::Display for FaultKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FaultKind::Open => f.write_str("the policy has no action in a state that it visits"),
            FaultKind::Disabled(action) => {
                write!(f, "the policy takes `{action}` in a state where this is not enabled")
            }
            FaultKind::Ambiguous(action) => write!(
                f,
                "the policy takes `{action}` in a state where several choices have this name; a position tells them \
                 apart: `/ position=0`, or \"position\": 0 in JSON"
            ),
            FaultKind::Misplaced(action, position) => write!(
                f,
                "the policy takes `{action}` at the position {position} in a state where this choice is not enabled"
            ),
            FaultKind::Lost => {
                f.write_str("no path of the policy leads from a state that it visits to the goal")
            }
            FaultKind::Cycle => {
                f.write_str("the policy may visit a state again, so no bound limits its paths")
            }
            FaultKind::Broken(what) => f.write_str(what),
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

impl Rule {
    fn holds(&self, state: &[i64]) -> bool {
        self.conditions.iter().all(|&(variable, value, is)| (state[variable.index()] == value) == is)
    }
}

impl Rules {
    /// Returns no rules, for the facts of a planning problem or the values of another model.
    pub fn new(program: &Program) -> Self {
        let facts = |planning: &Planning| planning.facts.iter().map(|f| (f.variable, f.value)).collect();
        Rules { facts: program.planning.as_deref().map(facts), ..Default::default() }
    }

    /// Adds a rule for one state.
    pub fn add_state(&mut self, state: &[i64], taken: Taken) {
        let conditions = (0..).zip(state).map(|(at, &value)| (VarId(at), value, true)).collect();
        self.add(conditions, taken);
    }

    /// Adds a rule for the states that satisfy all conditions.
    pub fn add(&mut self, conditions: Vec<Literal>, taken: Taken) {
        let number = self.rules.len();
        let mut facts: Vec<Fact> = conditions.iter().map(|&(variable, value, _)| (variable, value)).collect();
        facts.sort_unstable();
        facts.dedup();
        if conditions.iter().all(|literal| literal.2) && facts.iter().all(|fact| self.is_fact(fact)) {
            self.fewer.entry(facts.len()).or_default().push(number);
            self.exact.entry(facts).or_insert(number);
        } else {
            self.others.push(number);
        }
        self.rules.push(Rule { conditions, taken });
    }

    fn is_fact(&self, fact: &Fact) -> bool {
        self.facts.as_ref().is_none_or(|facts| facts.contains(fact))
    }

    /// Returns the action of the first rule that holds in a state. Rules with more facts than the state, or with as many
    /// others, do not hold: only those with fewer facts are tried one by one.
    fn action(&self, state: &State) -> Option<&Taken> {
        let all = (0..).zip(state).map(|(at, &value)| (VarId(at), value));
        let facts: Vec<Fact> = all.filter(|fact| self.is_fact(fact)).collect();
        let mut first = self.exact.get(&facts).copied().unwrap_or(self.rules.len());
        let tried = self.fewer.range(..facts.len()).map(|(_, rules)| rules).chain([&self.others]);
        for rules in tried {
            let mut before = rules.iter().take_while(|&&rule| rule < first);
            first = before.find(|&&rule| self.rules[rule].holds(state)).copied().unwrap_or(first);
        }
        self.rules.get(first).map(|rule| &rule.taken)
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
        if let Some(at) = walk.near(sink)?.iter().position(|near| !near) {
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

    /// Takes the step of the policy in a state. In a planning problem, names are those of actions: if the policy gives no
    /// position, only the commands of the action are evaluated.
    fn exact_step(
        &self,
        program: &Program,
        actions: &AHashMap<String, Vec<usize>>,
        state: &State,
    ) -> std::result::Result<Step<Ratio>, FaultKind> {
        let taken = self.action(state).ok_or(FaultKind::Open)?;
        let own = actions.get(&plain(&taken.action)).filter(|_| taken.position.is_none());
        if let Some(own) = own
            && let Ok(steps) = program.exact_steps_of(state, own)
            && let Ok(step) = step(program, taken, steps)
        {
            return Ok(step);
        }
        step(program, taken, program.exact_steps(state).unwrap_or_default())
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
            let all = || program.steps(&last).unwrap_or_default();
            match self.action(&last).ok_or(FaultKind::Open).and_then(|taken| step(program, taken, all())) {
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

/// Returns the step of an action among those of a state.
pub(super) fn step<W>(
    program: &Program,
    taken: &Taken,
    mut steps: Vec<Step<W>>,
) -> std::result::Result<Step<W>, FaultKind> {
    let Taken { action, position } = taken;
    let is_named = |step: &Step<W>| program.is_same_name(&step.name, action);
    if let Some(position) = *position {
        return match steps.get(position).is_some_and(is_named) {
            true => Ok(steps.swap_remove(position)),
            false => Err(FaultKind::Misplaced(action.clone(), position)),
        };
    }
    let mut named = steps.into_iter().filter(is_named);
    match (named.next(), named.next()) {
        (Some(step), None) => Ok(step),
        (Some(_), Some(_)) => Err(FaultKind::Ambiguous(action.clone())),
        (None, _) => Err(FaultKind::Disabled(action.clone())),
    }
}

/// Returns the synchronisations of each action of a planning problem by its name, without spaces and capitals.
fn synchronisations(program: &Program) -> AHashMap<String, Vec<usize>> {
    let mut of_actions: AHashMap<String, Vec<usize>> = AHashMap::new();
    // In other models, choices of several actions may have one name.
    let all = program.synchronisations.iter().enumerate().filter(|_| program.planning.is_some());
    for (index, synchronisation) in all {
        if let Some(action) = synchronisation.action {
            of_actions.entry(plain(&program.actions[action])).or_default().push(index);
        }
    }
    of_actions
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
    fn near(&self, sink: &dyn ProgressSink) -> Result<Vec<bool>, Limit> {
        let mut graph = Graph::new(sink);
        self.next.iter().for_each(|next| graph.add(false, [next.clone()]));
        graph.least(self.is_goal.clone(), |at, near| self.next[at].iter().any(|&to| near[to]))
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
