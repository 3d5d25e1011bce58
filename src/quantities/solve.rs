//! The equations of probabilities, costs and expected numbers, level by level, component by
//! component.
//!
//! With v(s') = P_{k-1}(s') if the step to s' improves, P_k(s') if not, and 0 if it is lost:
//! P_k(s) = max over kept choices a of Σ p(s,a,s') · v(s'), the least solution. C_k is the least
//! cost + Σ p · w(s') over the choices that keep k improvements certain, with w from C_{k-1} and C_k
//! in the same way. N has 1 + N(s') on improving steps.

use ahash::AHashMap;

use super::component::{Action, Component, Optimum, Sense};
use super::components::{self, Successor, Successors};
use super::eliminate::Row;
use super::graph::{Edge, Graph, LOST};
use super::meter::Meter;
use super::number::Number;
use crate::error::{Limit, Result};

/// No choice.
pub(super) const NONE: u32 = u32::MAX;

/// The quantity of a system of equations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    /// P_k
    Probability(u32),
    /// C_k
    Cost(u32),
    /// N
    Number,
    /// The largest expected cost until a counted edge, where every strategy takes one almost surely.
    Reward,
}

/// The solution of one system of equations, as far as it is known.
#[derive(Debug)]
pub(super) struct Solution<N> {
    /// The value of each node; meaningless unless `known`.
    pub(super) values: Vec<N>,
    pub(super) known: Vec<bool>,
    /// The choice that attains the value, or [`NONE`].
    pub(super) picks: Vec<u32>,
}

impl<N: Number> Solution<N> {
    /// The bytes of a node in a solution.
    const BYTES: usize = N::BYTES + 5;

    /// Returns the value of a node.
    pub(super) fn get(&self, node: u32) -> Option<&N> {
        self.known[node as usize].then(|| &self.values[node as usize])
    }
}

/// A system of equations over a graph, with the solution of the level below.
pub(super) struct System<'a, N> {
    pub(super) graph: &'a Graph,
    pub(super) quantity: Quantity,
    /// The solution of level k-1; `None` for level 1 and for numbers.
    pub(super) below: Option<&'a Solution<N>>,
    /// The fractions of the graph as numbers.
    pub(super) fractions: &'a [N],
}

/// The value at the end of an edge.
enum End<N> {
    /// The unknown of a node, and 1 more for an improvement that is counted.
    Open(u32),
    /// A known value.
    Known(N),
}

impl<N: Number> System<'_, N> {
    fn sense(&self) -> Sense {
        match self.quantity {
            Quantity::Cost(_) => Sense::Min,
            Quantity::Probability(_) | Quantity::Number | Quantity::Reward => Sense::Max,
        }
    }

    /// Returns the value of a node that follows from its rank; `None` if it must be computed.
    fn fact(&self, node: u32) -> Option<N> {
        let rank = self.graph.ranks[node as usize];
        match self.quantity {
            Quantity::Probability(k) if rank.positive < k => Some(N::zero()),
            Quantity::Probability(k) if rank.sure >= k => Some(N::one()),
            Quantity::Number if rank.positive == 0 => Some(N::zero()),
            _ => None,
        }
    }

    /// Returns whether a node has an equation.
    fn is_open(&self, node: u32) -> bool {
        match self.quantity {
            Quantity::Cost(k) => self.graph.ranks[node as usize].sure >= k,
            Quantity::Reward => self.graph.ranks[node as usize].sure > 0,
            _ => self.fact(node).is_none(),
        }
    }

    /// Returns whether a choice may be taken: for costs, if the improvements stay certain.
    pub(super) fn permits(&self, choice: u32) -> bool {
        let Quantity::Cost(k) = self.quantity else { return true };
        let certain = |edge: &Edge| {
            edge.to != LOST && self.graph.ranks[edge.to as usize].sure >= k - u32::from(edge.counts)
        };
        self.graph.edges(choice).iter().all(certain)
    }

    /// Returns the value at the end of an edge.
    fn end(&self, edge: &Edge, solution: &Solution<N>) -> End<N> {
        if edge.to == LOST {
            return End::Known(N::zero());
        }
        if edge.counts && self.quantity != Quantity::Number {
            return End::Known(match (self.below, self.quantity) {
                (Some(below), _) => below.values[edge.to as usize].clone(),
                (None, Quantity::Cost(_) | Quantity::Reward) => N::zero(),
                (None, _) => N::one(),
            });
        }
        match solution.get(edge.to) {
            Some(value) => End::Known(value.clone()),
            None => End::Open(edge.to),
        }
    }

    /// Returns the constant part of a choice that does not depend on its successors.
    fn own_constant(&self, choice: u32) -> N {
        match self.quantity {
            Quantity::Cost(_) | Quantity::Reward => {
                self.fractions[self.graph.costs[choice as usize] as usize].clone()
            }
            _ => N::zero(),
        }
    }

    /// Returns an edge's constant for the expected number: 1 for an improvement.
    fn bonus(&self, edge: &Edge) -> bool {
        edge.counts && self.quantity == Quantity::Number
    }

    /// Returns the value of a choice under a solution; `None` if it is not permitted or a successor
    /// is not known.
    pub(super) fn value(&self, choice: u32, solution: &Solution<N>) -> Option<N> {
        if !self.permits(choice) {
            return None;
        }
        let mut sum = self.own_constant(choice);
        for edge in self.graph.edges(choice) {
            let End::Known(mut value) = self.end(edge, solution) else { return None };
            if self.bonus(edge) {
                value = value.plus(&N::one());
            }
            sum = sum.plus(&self.fractions[edge.probability as usize].times(&value));
        }
        Some(sum)
    }

    /// Creates a solution that contains only the facts.
    pub(super) fn start(&self, meter: &mut Meter<'_>) -> Result<Solution<N>> {
        let n = self.graph.nodes();
        meter.take(n * Solution::<N>::BYTES)?;
        let facts = (0..n as u32).map(|node| self.fact(node));
        let (mut values, mut known) = (Vec::with_capacity(n), Vec::with_capacity(n));
        for fact in facts {
            known.push(fact.is_some());
            values.push(fact.unwrap_or_else(N::zero));
        }
        Ok(Solution { values, known, picks: vec![NONE; n] })
    }

    /// Solves the equations of all open nodes, the components that others depend on first.
    ///
    /// # Errors
    /// A limit is reached; the components solved before it are known.
    pub(super) fn solve(&self, solution: &mut Solution<N>, meter: &mut Meter<'_>) -> Result<()> {
        let open: Vec<u32> = (0..self.graph.nodes() as u32).filter(|&node| self.is_open(node)).collect();
        let found = components::components(&Dependencies { system: self }, open.into_iter());
        let total = found.len();
        for (number, component) in found.into_iter().enumerate() {
            if !self.is_open(component[0]) {
                continue;
            }
            meter.step()?;
            meter.progress(&|| format!("component {} of {total}", number + 1));
            self.component(&component, solution, meter)?;
        }
        Ok(())
    }

    fn component(&self, nodes: &[u32], solution: &mut Solution<N>, meter: &mut Meter<'_>) -> Result<()> {
        let groups = Groups::new(self, nodes, solution);
        let component = Component { sense: self.sense(), actions: groups.actions(self, solution, meter)? };
        let bytes: usize =
            component.actions.iter().flatten().map(|a| (a.row.edges.len() + 4) * (N::BYTES + 4)).sum();
        meter.take(bytes)?;
        let chosen =
            component.actions.iter().map(|a| a.iter().map(|a| (a.choice, a.node)).collect()).collect();
        let optimum = component.solve(meter)?;
        meter.release(bytes);
        groups.store(self, optimum.as_ref(), chosen, solution)
    }

    /// Returns the bounds of a node of which nothing is known.
    ///
    /// # Errors
    /// There are none among exact numbers.
    fn anything(&self) -> Result<N> {
        let bounds = N::anything(matches!(self.quantity, Quantity::Probability(_)));
        let what = "no exact value was found; bounds are found without `--exact`".to_owned();
        bounds.ok_or(Limit::Size { what }.into())
    }
}

/// The dependencies between open nodes.
struct Dependencies<'a, 'b, N> {
    system: &'b System<'a, N>,
}

impl<N: Number> Successors for Dependencies<'_, '_, N> {
    fn nodes(&self) -> usize {
        self.system.graph.nodes()
    }

    fn successor(&self, node: u32, position: u32) -> Option<Successor> {
        let system = self.system;
        let choices = system.graph.choices(node);
        if choices.is_empty() || !system.is_open(node) {
            return None;
        }
        let (first, last) = system.graph.edge_range(choices.start, choices.end);
        let index = first.checked_add(position).filter(|&index| index < last)?;
        let (choice, edge) = system.graph.edge(index, &choices);
        let follows = edge.to != LOST && (!edge.counts || system.quantity == Quantity::Number);
        let node = follows && system.is_open(edge.to) && system.permits(choice);
        Some(if node { Successor::Node(edge.to) } else { Successor::None })
    }
}

/// The nodes of a component, grouped by end components in which nothing is gained or paid.
struct Groups<'n> {
    nodes: &'n [u32],
    /// The position of each node in `nodes`.
    position: AHashMap<u32, u32>,
    group: Vec<u32>,
    count: usize,
    /// For each node, its choices by their successors; `None` for those outside of end components.
    inside: Vec<Vec<Option<Vec<u32>>>>,
}

impl<'n> Groups<'n> {
    fn new<N: Number>(system: &System<'_, N>, nodes: &'n [u32], solution: &Solution<N>) -> Self {
        let position: AHashMap<u32, u32> = nodes.iter().zip(0..).map(|(&node, i)| (node, i)).collect();
        let free = |choice: u32| {
            if !system.permits(choice) || !system.own_constant(choice).is_zero() {
                return None;
            }
            let to = system.graph.edges(choice).iter().map(|edge| match system.end(edge, solution) {
                End::Open(to) if !edge.counts => position.get(&to).copied(),
                _ => None,
            });
            to.collect::<Option<Vec<u32>>>()
        };
        let inside: Vec<Vec<_>> =
            nodes.iter().map(|&node| system.graph.choices(node).map(free).collect()).collect();
        let (group, count) = match nodes {
            [_] => (vec![0], 1),
            _ => components::end_components(&inside),
        };
        Groups { nodes, position, group, count, inside }
    }

    /// Returns whether a choice stays in its group for certain.
    fn stays(&self, node: usize, number: usize) -> bool {
        let group = self.group[node];
        let all = |to: &Vec<u32>| to.iter().all(|&to| self.group[to as usize] == group);
        self.inside[node][number].as_ref().is_some_and(all)
    }

    /// Returns the actions of each group.
    fn actions<N: Number>(
        &self,
        system: &System<'_, N>,
        solution: &Solution<N>,
        meter: &mut Meter<'_>,
    ) -> Result<Vec<Vec<Action<N>>>> {
        let mut actions: Vec<Vec<Action<N>>> = (0..self.count).map(|_| Vec::new()).collect();
        for (index, &node) in self.nodes.iter().enumerate() {
            for (number, choice) in system.graph.choices(node).enumerate() {
                meter.step()?;
                if system.permits(choice) && !self.stays(index, number) {
                    let (row, high, whole) = self.row(system, choice, self.group[index], solution);
                    let action = Action::new(choice, node, (row, high), whole);
                    if action.leaves() {
                        actions[self.group[index] as usize].push(action);
                    }
                }
            }
        }
        Ok(actions)
    }

    /// Returns the row of a choice, the upper bound of its constant, and whether the row has all edges
    /// of the choice.
    fn row<N: Number>(
        &self,
        system: &System<'_, N>,
        choice: u32,
        own: u32,
        solution: &Solution<N>,
    ) -> (Row<N>, N, bool) {
        let mut whole = true;
        let constant = system.own_constant(choice);
        let (mut low, mut high) = (constant.low(), constant.high());
        let (mut edges, mut escape): (Vec<(u32, N)>, N) = (Vec::new(), N::zero());
        for edge in system.graph.edges(choice) {
            let p = &system.fractions[edge.probability as usize];
            if system.bonus(edge) {
                (low, high) = (low.plus(p).low(), high.plus(p).high());
            }
            match system.end(edge, solution) {
                End::Known(value) => {
                    let part = p.times(&value);
                    (low, high) = (low.plus(&part).low(), high.plus(&part).high());
                    escape = escape.plus(p);
                }
                End::Open(to) => match self.position.get(&to).map(|&i| self.group[i as usize]) {
                    Some(to) if to == own => whole = false,
                    Some(to) => match edges.iter_mut().find(|edge| edge.0 == to) {
                        Some((_, q)) => *q = q.plus(p),
                        None => edges.push((to, p.clone())),
                    },
                    None => escape = escape.plus(p),
                },
            }
        }
        edges.sort_unstable_by_key(|edge| edge.0);
        (Row { edges, escape, constant: low }, high, whole)
    }

    /// Stores the values of the groups for their nodes, and the choices that attain them.
    fn store<N: Number>(
        &self,
        system: &System<'_, N>,
        optimum: Option<&Optimum<N>>,
        chosen: Vec<Vec<(u32, u32)>>,
        solution: &mut Solution<N>,
    ) -> Result<()> {
        for (index, &node) in self.nodes.iter().enumerate() {
            let group = self.group[index] as usize;
            let bounds = optimum.map(|optimum| (&optimum.low[group], &optimum.high[group]));
            solution.values[node as usize] = match bounds {
                Some((low, Some(high))) => N::between(low, high),
                Some((low, None)) => N::between(low, &system.anything()?.high()),
                None => system.anything()?,
            };
            solution.known[node as usize] = true;
        }
        let Some(optimum) = optimum else { return Ok(()) };
        for (actions, &number) in chosen.iter().zip(&optimum.policy) {
            let Some(&(choice, node)) = actions.get(number) else { continue };
            solution.picks[node as usize] = choice;
        }
        self.approach(system, solution);
        Ok(())
    }

    /// Lets the other nodes of each group move towards the one that leaves it.
    fn approach<N: Number>(&self, system: &System<'_, N>, solution: &mut Solution<N>) {
        let mut layer: Vec<u32> = (0..self.nodes.len() as u32)
            .filter(|&i| solution.picks[self.nodes[i as usize] as usize] != NONE)
            .collect();
        let mut into: Vec<Vec<(u32, usize)>> = vec![Vec::new(); self.nodes.len()];
        for (index, choices) in self.inside.iter().enumerate() {
            for number in (0..choices.len()).filter(|&number| self.stays(index, number)) {
                let successors = choices[number].iter().flatten();
                successors.for_each(|&to| into[to as usize].push((index as u32, number)));
            }
        }
        while let Some(to) = layer.pop() {
            for &(index, number) in &into[to as usize] {
                let pick = &mut solution.picks[self.nodes[index as usize] as usize];
                if *pick == NONE {
                    *pick = system.graph.choices(self.nodes[index as usize]).start + number as u32;
                    layer.push(index);
                }
            }
        }
    }
}
