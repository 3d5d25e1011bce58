//! A strategy for several objectives as a Markov chain: the values of the objectives, and random runs.

use std::collections::BTreeMap;

use bitvec::vec::BitVec;
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_base::random::Draw;
use meliora_model::Optimum;
use num_traits::ToPrimitive;

use super::chain::Chain;
use meliora_base::interval::Bounds;
use meliora_base::number::Weight;
use meliora_equations::several::{Counted, Node, Taking, counted_steps, decided};
use meliora_equations::vector::{Accumulation, Until};
use meliora_equations::{Arena, Builder, Edge, Extremes, Rewards, Value};

/// The nodes of a strategy; each takes one step, with the chance of the strategy and of the model.
pub struct Followed<'a> {
    nodes: &'a [Node],
    chain: Chain<'a>,
}

/// A fault of a node that is none of a strategy of the model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NodeFault {
    /// It takes no action.
    Open,
    /// The model has no choice with this position in its state.
    Disabled(usize),
    /// The nodes after a choice are not those of its successors, or have other probabilities.
    Successors(usize),
}

/// Returns the first node whose memory is not that of all paths from the first node to it, or that no path visits, if there
/// is one. Cost: linear.
pub fn misremembered(objectives: &[(Counted<'_>, Optimum)], nodes: &[Node]) -> Option<usize> {
    let (most, first) = (counted_steps(objectives), nodes.first()?);
    let mut known = vec![false; nodes.len()];
    let mut open = vec![(0, decided(objectives, first.state).0, 0)];
    while let Some((at, bits, steps)) = open.pop() {
        let Some(node) = nodes.get(at) else { continue };
        if (node.decided, node.steps) != (bits, steps) {
            return Some(at);
        }
        if std::mem::replace(&mut known[at], true) {
            continue;
        }
        for (to, _) in node.choices.iter().flat_map(|taking| &taking.successors) {
            let new = nodes.get(*to).map_or(0, |after| decided(objectives, after.state).0);
            open.push((*to, bits | new, most.min(steps + 1)));
        }
    }
    known.iter().position(|known| !known)
}

/// The number that a path counts from a node on, if the node decides it.
type Rest = Option<f64>;

impl<'a> Followed<'a> {
    /// Creates the chain with the probabilities of the model, or returns the first node with a fault. Cost: linear.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub fn new(
        arena: &'a Arena<'a>,
        nodes: &'a [Node],
    ) -> Result<std::result::Result<Self, (usize, NodeFault)>> {
        let (mut meter, mut builder) = (arena.meter(), Builder::new(arena));
        for (number, node) in nodes.iter().enumerate() {
            let mut entered: BTreeMap<u32, Ratio> = BTreeMap::new();
            let share = Ratio::from_integer(node.choices.len().max(1).into());
            for taking in &node.choices {
                match successors(arena, nodes, node, taking) {
                    Ok(found) => found.into_iter().for_each(|(to, p)| {
                        *entered.entry(to).or_insert_with(Ratio::zero) += p / &share;
                    }),
                    Err(fault) => return Ok(Err((number, fault))),
                }
            }
            if entered.is_empty() {
                return Ok(Err((number, NodeFault::Open)));
            }
            meter.take(entered.len() * 8 + 16)?;
            for (to, p) in entered {
                let p = builder.number(p);
                builder.edge(Edge::new(to, p, false));
            }
            builder.end_choice(Ratio::zero());
            builder.end_state(false);
        }
        Ok(Ok(Followed { nodes, chain: Chain { arena, game: builder.built().0 } }))
    }

    /// Returns the nodes whose states are in a set.
    fn members(&self, set: &BitVec) -> BitVec {
        self.nodes.iter().map(|node| set[node.state]).collect()
    }

    /// Returns the mean reward of the choices of each node.
    fn rewards(&self, of: &Rewards) -> Rewards {
        let mean = |node: &Node| {
            let sum: Ratio = node.choices.iter().map(|taking| of.choice(self.choice(node, taking))).sum();
            sum / Ratio::from_integer(node.choices.len().into())
        };
        Rewards::of_choices(&self.chain.game, self.nodes.iter().map(mean))
    }

    /// Returns the number of a choice in the arena.
    fn choice(&self, node: &Node, taking: &Taking) -> usize {
        choice(self.chain.arena, node, taking).unwrap_or_default()
    }

    /// Returns the expected number of an objective from the first node, or 1 minus it if it is `negated`; with fractions if
    /// it is to be `exact`.
    ///
    /// # Errors
    /// A limit is reached.
    pub fn value(&self, counted: Counted<'_>, negated: bool, exact: bool) -> Result<Value> {
        let asked = self.chain.asked(Extremes::all(Optimum::Max), if exact { 0.0 } else { f64::INFINITY });
        let until = |left: BitVec, right: BitVec| asked.probability(&Until::unbounded(left, right));
        let earned = |rewards: &Rewards, accumulation: Accumulation| {
            asked.reward(&self.rewards(rewards), &accumulation)
        };
        let answer = match counted {
            Counted::Visit(right) => until(self.chain.all(true), self.members(right)),
            Counted::Until(left, right) => until(self.members(left), self.members(right)),
            Counted::Recur(set) => until(self.chain.all(true), self.ends(&self.members(set))),
            Counted::Total(rewards) => earned(rewards, Accumulation::Total),
            Counted::Within(rewards, steps) => earned(rewards, Accumulation::Within(steps.into())),
            Counted::Before(rewards, set) => earned(rewards, Accumulation::Until(self.members(set))),
        }?;
        answer.end?;
        let mut value = answer.values.into_iter().next().unwrap_or(Value::Finite(Bounds::point(0)));
        if negated {
            value.complement();
        }
        Ok(value)
    }

    /// Returns the nodes of the components that are never left and contain a node of a set.
    fn ends(&self, set: &BitVec) -> BitVec {
        self.chain.ends(|component| component.iter().any(|&node| set[node as usize]))
    }

    /// Returns what a path counts from each node on, where the node decides it.
    ///
    /// # Errors
    /// A limit is reached.
    pub fn rests(&self, counted: Counted<'_>) -> Result<Vec<Rest>> {
        let all = self.chain.all(true);
        let until = |left: &BitVec, right: BitVec, [done, lost]: [f64; 2]| {
            let near = self.chain.near(&right, left)?;
            Ok(rests(&right, done, &!near, lost))
        };
        match counted {
            Counted::Visit(right) => until(&all, self.members(right), [1.0, 0.0]),
            Counted::Until(left, right) => until(&self.members(left), self.members(right), [1.0, 0.0]),
            Counted::Recur(set) => until(&all, self.ends(&self.members(set)), [1.0, 0.0]),
            Counted::Before(_, set) => until(&all, self.members(set), [0.0, f64::INFINITY]),
            Counted::Total(rewards) | Counted::Within(rewards, _) => {
                let rewards = self.rewards(rewards);
                let earning: BitVec = (0..self.nodes.len()).map(|node| !rewards.is_free(node)).collect();
                let idle = !self.chain.near(&earning, &all)?;
                let is_total = matches!(counted, Counted::Total(_));
                let endless = if is_total { self.ends(&earning) } else { self.chain.all(false) };
                Ok(rests(&idle, 0.0, &endless, f64::INFINITY))
            }
        }
    }

    /// Returns the rewards of the choices of each node, by their positions in the node; none if nothing is collected.
    pub fn gains(&self, counted: Counted<'_>) -> Vec<Vec<f64>> {
        let (Counted::Total(rewards) | Counted::Within(rewards, _) | Counted::Before(rewards, _)) = counted
        else {
            return Vec::new();
        };
        let gain = |node: &Node, taking: &Taking| rewards.choice(self.choice(node, taking)).to_f64();
        let of =
            |node: &Node| node.choices.iter().map(|own| gain(node, own).unwrap_or(f64::INFINITY)).collect();
        self.nodes.iter().map(of).collect()
    }

    /// Draws the position of an action of a node, and the node after it.
    pub fn drawn(&self, node: usize, draw: &mut Draw) -> (usize, usize) {
        let choices = &self.nodes[node].choices;
        let at = draw.below(choices.len());
        let successors = &choices[at].successors;
        let next = draw.by_probability(successors.iter().map(|(_, p)| p.to_f64().unwrap_or_default()));
        (at, successors[next].0)
    }
}

fn rests(done: &BitVec, first: f64, lost: &BitVec, second: f64) -> Vec<Rest> {
    let both = done.iter().zip(lost.iter());
    both.map(|(done, lost)| if *done { Some(first) } else { lost.then_some(second) }).collect()
}

/// Returns the number of a choice in the arena.
fn choice(arena: &Arena<'_>, node: &Node, taking: &Taking) -> Option<usize> {
    arena.choices.of(node.state as u32).find(|&choice| arena.position(choice) == taking.position)
}

/// Returns the nodes after a choice with the probabilities of the model.
fn successors(
    arena: &Arena<'_>,
    nodes: &[Node],
    node: &Node,
    taking: &Taking,
) -> std::result::Result<Vec<(u32, Ratio)>, NodeFault> {
    let choice = choice(arena, node, taking).ok_or(NodeFault::Disabled(taking.position))?;
    let wrong = NodeFault::Successors(taking.position);
    let mut expected: BTreeMap<usize, Ratio> = BTreeMap::new();
    for (to, weight) in arena.outcomes(choice) {
        *expected.entry(to as usize).or_insert_with(Ratio::zero) += &arena.fractions()[weight as usize];
    }
    let mut found = Vec::new();
    for (to, said) in &taking.successors {
        let p = nodes.get(*to).and_then(|after| expected.remove(&after.state));
        match p.filter(|p| p.to_f64() == said.to_f64()) {
            Some(p) => found.push((*to as u32, p)),
            None => return Err(wrong),
        }
    }
    if expected.is_empty() { Ok(found) } else { Err(wrong) }
}
