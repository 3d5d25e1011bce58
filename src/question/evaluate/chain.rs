//! The model that the nodes of a strategy leave: a Markov chain, or the choices of the opponent. Its values are those of
//! the strategy.
//!
//! It is a program of its own, whose states are the variables of the model and the number of the node. So the conditions,
//! labels and rewards of the model keep their meaning there, and each property can be asked about it.

use std::collections::BTreeMap;
use std::sync::Arc;

use ahash::{AHashMap, AHashSet};
use meliora_base::error::Result;
use meliora_base::exact::{Exact, Ratio, Real};
use meliora_base::value::{Type, Value};
use meliora_equations::several::Taking;
use meliora_model::expr::{Binary, ExprId, ExprPool};
use meliora_model::rewards::{Earner, RewardItem, RewardStructure};
use meliora_model::step::{Choice, Step};
use meliora_model::{
    Branch, Command, CommandId, ModelKind, Program, State, Synchronisation, Updates, VarId, Variable, fault,
};
use meliora_quantities::optimal::Nodes;
use meliora_space::enabled::Enabled;

use super::condition::condition_of;
use super::following::{StrategyFault, StrategyFaultKind};
use meliora_quantities::followed::NodeFault;

/// A state that a strategy visits, with its memory.
#[derive(Debug, Clone)]
pub struct PolicyNode {
    /// The state of the model.
    pub state: State,
    /// The states of the monitors of the formula; none if they are not stated, or if there are none.
    pub memory: State,
    /// The number of steps so far, as far as a bound counts it.
    pub steps: u32,
    /// The number of the set that is visited next, of those that are visited again and again.
    pub round: u32,
    /// True if the other side chooses: all of its choices are listed.
    pub theirs: bool,
    /// The choices, of which each is taken with the same probability, or all of the other side; none if the path is
    /// decided.
    pub choices: Vec<Taking>,
}

impl PolicyNode {
    /// Returns the values of the variables of the model and of the monitors.
    pub(super) fn whole(&self) -> State {
        [&self.state[..], &self.memory].concat()
    }
}

/// A node whose successors are those of the model.
pub(super) struct Linked {
    /// The successors of each choice: one choice in a node of ours.
    pub(super) choices: Vec<Vec<(usize, Ratio)>>,
    /// The rewards of the state by structure.
    pub(super) state_rewards: Vec<Ratio>,
    /// The rewards of each choice, without the ones of the state.
    pub(super) rewards: Vec<Vec<Ratio>>,
}

/// The nodes of a strategy that was found. They stay in the compact form of the arena until they are visited.
#[derive(Debug)]
pub struct PolicyNodes {
    nodes: Nodes,
    /// The number of variables of the model; those of monitors follow.
    variables: usize,
    /// True with monitors.
    is_watched: bool,
}

impl PolicyNodes {
    pub(super) fn new(nodes: Nodes, (variables, is_watched): (usize, bool)) -> Self {
        PolicyNodes { nodes, variables, is_watched }
    }

    /// Returns the number of nodes.
    pub fn count(&self) -> usize {
        self.nodes.count()
    }

    /// Returns the choices of the states of the model by their commands, and the number of the list of each node there; `None`
    /// if the commands that are enabled in a state are not known.
    pub fn kept_choices(&self) -> Option<(&Enabled, &[u32])> {
        self.nodes.kept_choices().filter(|_| !self.is_watched)
    }

    /// Visits all nodes with their numbers, in this order.
    ///
    /// # Errors
    /// The errors of the visits.
    pub fn each(&self, mut visit: impl FnMut(usize, &PolicyNode) -> Result<()>) -> Result<()> {
        let (state, memory, choices) = (State::new(), State::new(), Vec::new());
        let mut node = PolicyNode { state, memory, steps: 0, round: 0, theirs: false, choices };
        for number in 0..self.count() {
            self.nodes.state_into(number, &mut node.state);
            node.memory.clear();
            node.memory.extend(node.state.drain(self.variables..));
            (node.steps, node.round) = self.nodes.memory(number);
            node.theirs = self.nodes.is_theirs(number);
            self.nodes.choices_into(number, &mut node.choices);
            visit(number, &node)?;
        }
        Ok(())
    }
}

type Checked<T> = Result<std::result::Result<T, StrategyFault>>;

/// Compares nodes with the steps of a program, which has the monitors if the nodes state these. Returns their links, or the
/// first fault. Cost: one step of the program per node.
///
/// # Errors
/// A command or a reward has no meaning in a state.
pub(super) fn linked(program: &Program, nodes: &[PolicyNode], structures: &[usize]) -> Checked<Vec<Linked>> {
    let mut all = Vec::with_capacity(nodes.len());
    for node in nodes {
        let whole = node.whole();
        let wrong = |kind| StrategyFault { state: node.state.clone(), kind: StrategyFaultKind::Node(kind) };
        let steps = program.exact_steps(&whole).map_err(|f| fault::error(program, &f, &whole))?;
        let (mut choices, mut rewards) = (Vec::new(), Vec::new());
        let own = |choice: Option<&Choice>| -> Result<Vec<Ratio>> {
            structures.iter().map(|&at| reward(program, at, &whole, choice)).collect()
        };
        let state_rewards = own(None)?;
        let mut taken = vec![false; steps.len()];
        for taking in &node.choices {
            let Some(step) = steps.get(taking.position).filter(|_| !taken[taking.position]) else {
                return Ok(Err(wrong(NodeFault::Disabled(taking.position))));
            };
            taken[taking.position] = true;
            let Some(successors) = successors(step, nodes, taking) else {
                return Ok(Err(wrong(NodeFault::Successors(taking.position))));
            };
            choices.push(successors);
            let earned = own(Some(&step.choice))?;
            rewards.push(earned.iter().zip(&state_rewards).map(|(all, state)| all - state).collect());
        }
        let is_whole = node.choices.is_empty() || taken.iter().all(|taken| *taken);
        if node.theirs && !is_whole {
            return Ok(Err(wrong(NodeFault::Open)));
        }
        if !node.theirs && choices.len() > 1 {
            choices = vec![merged(&choices)];
            rewards = vec![mean(&rewards)];
        }
        all.push(Linked { choices, state_rewards, rewards });
    }
    Ok(Ok(all))
}

/// Returns what a choice earns, or the state alone.
fn reward(program: &Program, structure: usize, state: &[i64], choice: Option<&Choice>) -> Result<Ratio> {
    let combinations = match choice {
        Some(Choice::Combination { synchronisation, commands }) => vec![(*synchronisation, commands.clone())],
        _ => Vec::new(),
    };
    program.signed_reward_of(&program.rewards[structure], state, &combinations)
}

/// Returns the nodes after a step with its probabilities; `None` if they are not its successors.
fn successors(step: &Step<Ratio>, nodes: &[PolicyNode], taking: &Taking) -> Option<Vec<(usize, Ratio)>> {
    use num_traits::ToPrimitive;
    let mut expected: BTreeMap<&[i64], &Ratio> = step.successors.iter().map(|(s, p)| (&s[..], p)).collect();
    let mut found = Vec::with_capacity(expected.len());
    for (to, said) in &taking.successors {
        let p = expected.remove(&nodes.get(*to)?.whole()[..])?;
        if p.to_f64() != said.to_f64() {
            return None;
        }
        found.push((*to, p.clone()));
    }
    expected.is_empty().then_some(found)
}

/// Returns the mean of choices.
fn merged(choices: &[Vec<(usize, Ratio)>]) -> Vec<(usize, Ratio)> {
    let share = Ratio::from_integer(choices.len().into());
    let mut sums: BTreeMap<usize, Ratio> = BTreeMap::new();
    for (to, p) in choices.iter().flatten() {
        *sums.entry(*to).or_default() += p / &share;
    }
    sums.into_iter().collect()
}

fn mean(rewards: &[Vec<Ratio>]) -> Vec<Ratio> {
    let share = Ratio::from_integer(rewards.len().into());
    let sum = |at: usize| rewards.iter().map(|own| &own[at]).sum::<Ratio>() / &share;
    (0..rewards.first().map_or(0, Vec::len)).map(sum).collect()
}

/// Returns the least number of steps to each node from the first ones; `None` for those that are not visited.
pub(super) fn distances(links: &[Linked], starts: usize) -> Vec<Option<u64>> {
    let mut distances = vec![None; links.len()];
    let mut open: std::collections::VecDeque<usize> = (0..starts.min(links.len())).collect();
    open.iter().for_each(|&start| distances[start] = Some(0));
    while let Some(at) = open.pop_front() {
        let next = distances[at].map(|steps: u64| steps + 1);
        for (to, _) in links[at].choices.iter().flatten() {
            if distances[*to].is_none() {
                distances[*to] = next;
                open.push_back(*to);
            }
        }
    }
    distances
}

/// Returns the first node whose memory is not that of all paths to it, or that no path visits. `most` is the number of
/// steps that a bound counts. The steps of the program have compared the memory of monitors, save in the starts.
pub(super) fn misremembered(
    (nodes, links, starts): (&[PolicyNode], &[Linked], usize),
    distances: &[Option<u64>],
    most: u64,
) -> Option<usize> {
    let counts = nodes.iter().any(|node| node.steps > 0);
    let is_fresh = |node: &PolicyNode| node.steps == 0 && node.memory.iter().all(|&value| value == 0);
    let follows = |at: usize, to: usize| {
        let (before, after) = (u64::from(nodes[at].steps), u64::from(nodes[to].steps));
        !counts || after == most.min(before + 1)
    };
    let is_right = |at: usize| {
        distances[at].is_some()
            && (at >= starts || is_fresh(&nodes[at]))
            && links[at].choices.iter().flatten().all(|(to, _)| follows(at, *to))
    };
    (0..nodes.len()).find(|&at| !is_right(at))
}

/// Returns the first node with the state and the memory of one before it.
pub(super) fn doubled(nodes: &[PolicyNode]) -> Option<usize> {
    let mut known = AHashSet::with_capacity(nodes.len());
    nodes.iter().position(|node| !known.insert((&node.state, &node.memory, node.steps, node.round)))
}

/// Builds the program of some nodes, the first of which are initial. Its pool rests on `pool`, and its rewards are those of
/// `structures`; the others have no items.
pub(super) fn program(
    of: &Program,
    pool: Arc<ExprPool>,
    (nodes, links, starts): (&[PolicyNode], &[Linked], usize),
    structures: &[usize],
) -> Program {
    let mut own = ExprPool::over(&pool);
    let node = VarId(of.variables.len() as u32);
    let (variables, literals) = (&of.variables[..], AHashMap::new());
    let mut builder = Builder { pool: &mut own, node, variables, literals };
    let (commands, synchronisations) = builder.commands(nodes, links);
    let rewards = of.rewards.iter().enumerate().map(|(at, structure)| {
        let items = structures.iter().position(|&own| own == at).map(|own| builder.rewards(links, own));
        RewardStructure { items: items.unwrap_or_default(), errors: Vec::new(), ..structure.clone() }
    });
    let rewards = rewards.collect();
    let mut chain = Program { rewards, commands, synchronisations, ..of.clone() };
    chain.actions = (0..chain.synchronisations.len()).map(|at| format!("choice{at}")).collect();
    (chain.kind, chain.players, chain.planning) = (ModelKind::Mdp, None, None);
    chain.variables.push(node_variable(of, nodes.len()));
    chain.modules = vec!["strategy".to_owned()];
    chain.variables.iter_mut().for_each(|variable| variable.module = Some(0));
    let mut initial: Vec<State> =
        nodes[..starts].iter().zip(0..).map(|(node, at)| with(&node.state, at)).collect();
    initial.sort_unstable();
    let only = if let [only] = &initial[..] { Some(only.clone()) } else { None };
    for (at, variable) in chain.variables.iter_mut().enumerate() {
        variable.initial = only.as_ref().map(|state| state[at]);
    }
    chain.initial = condition_of(&chain, &mut own, &initial);
    chain.pool = own.into();
    chain
}

/// Returns a state of the chain.
fn with(state: &State, node: i64) -> State {
    state.iter().copied().chain([node]).collect()
}

fn node_variable(of: &Program, count: usize) -> Variable {
    let mut name = "node".to_owned();
    while of.variables.iter().any(|variable| variable.name == name) {
        name.push('_');
    }
    let high = i64::try_from(count).unwrap_or(i64::MAX) - 1;
    Variable {
        name,
        ty: Type::Int,
        low: 0,
        high,
        module: None,
        initial: None,
        values: Vec::new(),
        span: 0..0,
    }
}

/// Builds the parts of the program.
struct Builder<'a> {
    pool: &'a mut ExprPool,
    node: VarId,
    variables: &'a [Variable],
    literals: AHashMap<Ratio, ExprId>,
}

impl Builder<'_> {
    fn number(&mut self, x: &Ratio) -> ExprId {
        if let Some(&known) = self.literals.get(x) {
            return known;
        }
        let id = self.pool.exact_value(Exact::Real(Real::Finite(x.clone())));
        self.literals.insert(x.clone(), id);
        id
    }

    /// Returns one command for each choice of each node; the k-th ones of all nodes have the k-th action.
    fn commands(&mut self, nodes: &[PolicyNode], links: &[Linked]) -> (Vec<Command>, Vec<Synchronisation>) {
        let (mut commands, mut of_action): (Vec<Command>, Vec<Vec<CommandId>>) = (Vec::new(), Vec::new());
        let own = self.pool.var(self.node, Type::Int);
        for (at, link) in links.iter().enumerate() {
            let here = self.pool.value(Value::Int(at as i64));
            let guard = self.pool.binary(Binary::Eq, own, here);
            let stays = [vec![(at, Ratio::from_integer(1.into()))]];
            let choices = if link.choices.is_empty() { &stays[..] } else { &link.choices };
            for (number, choice) in choices.iter().enumerate() {
                let branches = choice.iter().map(|(to, p)| self.branch((at, *to), p, nodes)).collect();
                if of_action.len() == number {
                    of_action.push(Vec::new());
                }
                of_action[number].push(CommandId(commands.len() as u32));
                let action = Some(number);
                commands.push(Command {
                    module: 0,
                    action,
                    number: at + 1,
                    unlisted: None,
                    guard,
                    branches,
                    span: Default::default(),
                });
            }
        }
        let one = |(action, all)| Synchronisation { action: Some(action), factors: vec![all] };
        let synchronisations = of_action.into_iter().enumerate().map(one).collect();
        (commands, synchronisations)
    }

    fn branch(&mut self, (from, to): (usize, usize), p: &Ratio, nodes: &[PolicyNode]) -> Branch {
        let probability = self.number(p);
        let (before, after) = (&nodes[from].state, &nodes[to].state);
        let mut updates = Updates::new();
        for (at, &value) in after.iter().enumerate().filter(|(at, value)| before[*at] != **value) {
            let value = match self.variables[at].ty {
                Type::Bool => Value::Bool(value != 0),
                _ => Value::Int(value),
            };
            updates.push((VarId(at as u32), self.pool.value(value)));
        }
        if from != to {
            updates.push((self.node, self.pool.value(Value::Int(to as i64))));
        }
        Branch { probability, updates }
    }

    /// Returns the rewards of a structure: those of states, and those of the k-th choices.
    fn rewards(&mut self, links: &[Linked], at: usize) -> Vec<RewardItem> {
        let most = links.iter().map(|link| link.rewards.len()).max().unwrap_or_default();
        let zero = Ratio::default();
        let of_state = links.iter().map(|link| link.state_rewards[at].clone()).collect();
        let mut all = vec![(Earner::State, of_state)];
        for number in 0..most {
            let own = |link: &Linked| link.rewards.get(number).map_or(zero.clone(), |own| own[at].clone());
            all.push((Earner::Action(Some(number)), links.iter().map(own).collect::<Vec<Ratio>>()));
        }
        all.retain(|(_, values)| values.iter().any(|value| *value != zero));
        let item = |(earner, values): (Earner, Vec<Ratio>)| {
            let leaves: Vec<ExprId> = values.iter().map(|value| self.number(value)).collect();
            let value = self.tree(0, &leaves);
            let guard = self.pool.value(Value::Bool(true));
            RewardItem { earner, guard, value, span: Default::default() }
        };
        all.into_iter().map(item).collect()
    }

    /// Returns the value of the node among leaves that begin with the number `first`.
    fn tree(&mut self, first: usize, leaves: &[ExprId]) -> ExprId {
        let middle = leaves.len() / 2;
        if middle == 0 {
            return leaves[0];
        }
        let (low, high) = (self.tree(first, &leaves[..middle]), self.tree(first + middle, &leaves[middle..]));
        if low == high {
            return low;
        }
        let own = self.pool.var(self.node, Type::Int);
        let last = self.pool.value(Value::Int((first + middle) as i64 - 1));
        let is_low = self.pool.binary(Binary::Le, own, last);
        self.pool.ite(is_low, low, high)
    }
}
