//! The greatest weighted sum of several objectives from one state of an arena without an opponent.
//!
//! States are paired with the sets that their path has visited, so that each objective is a sum of gains of choices;
//! a gain is negative if the objective is to be small. End components in which nothing is gained become one group, in
//! which a path may stop. Then every strategy stops almost surely, and the expected number T of steps until then bounds
//! all errors: if each equation is missed by at most d, values are missed by at most d · T.

use ahash::AHashMap;
use bitvec::vec::BitVec;
use meliora_base::error::{Error, Limit, Result};
use meliora_base::exact::Ratio;
use meliora_engine::explicit::weighted::Fractions;
use meliora_model::Optimum;
use num_traits::{One, Signed, ToPrimitive};

use super::components::{self, Choices};
use super::doubles::ROUNDS;
use super::eliminate::{self, Row};
use super::sparse::BETTER;
use crate::equations::arena::{Arena, Rewards};
use crate::equations::graph::{EVERY, Edge, Graph, Rank};
use crate::equations::meter::{Meter, Stop};
use crate::equations::number::{Interval, Weight};
use crate::equations::system::Quantity;
use crate::path_values::solved;

/// A number of a path.
#[derive(Debug, Clone, Copy)]
pub enum Counted<'a> {
    /// 1 if the path visits the set.
    Visit(&'a BitVec),
    /// The rewards of all steps.
    Total(&'a Rewards),
}

/// A choice of a group.
struct Action {
    /// The groups that are entered, with the numbers of the probabilities; also the own group.
    edges: Vec<(u32, u32)>,
    /// The numbers of the gains.
    gains: Vec<u32>,
}

/// The groups and their actions. An action without edges stops.
pub(crate) struct Weighted {
    groups: Vec<Vec<Action>>,
    fractions: Fractions,
    start: usize,
    /// The gains before the first step.
    first: Vec<Ratio>,
    /// An upper bound of the expected number of steps from the start.
    steps: f64,
}

/// A point that a strategy attains, and a half-space that contains all points.
pub(crate) struct Point {
    /// Lower bounds of the expected gains of a strategy.
    pub(crate) gains: Vec<Ratio>,
    /// An upper bound of the weighted sum of the gains of all strategies.
    pub(crate) most: Ratio,
}

/// States with the sets that were visited before.
struct Pairs {
    list: Vec<(u32, u32)>,
    numbers: AHashMap<(u32, u32), u32>,
    choices: Choices,
    /// The numbers of the probabilities of the successors, and of the gains of each choice.
    weights: Vec<u32>,
    gains: Vec<Vec<u32>>,
}

impl Pairs {
    fn number(&mut self, pair: (u32, u32)) -> u32 {
        let Pairs { list, numbers, .. } = self;
        *numbers.entry(pair).or_insert_with(|| {
            list.push(pair);
            list.len() as u32 - 1
        })
    }

    /// Explores the pairs that a state reaches.
    fn explored(
        arena: &Arena<'_>,
        start: usize,
        objectives: &[(Counted<'_>, Optimum)],
        fractions: &mut Fractions,
        meter: &mut Meter<'_>,
    ) -> Result<Self> {
        let mut pairs = Pairs {
            list: Vec::new(),
            numbers: AHashMap::new(),
            choices: Choices { first: vec![0], start: vec![0], to: Vec::new() },
            weights: Vec::new(),
            gains: Vec::new(),
        };
        pairs.number((start as u32, visited(objectives, start)));
        let mut next = 0;
        while let Some(&(state, mask)) = pairs.list.get(next) {
            meter.take(size_of::<(u32, u32)>() * 4)?;
            next += 1;
            for choice in arena.choices.of(state) {
                let mut gains: Vec<Ratio> = objectives
                    .iter()
                    .map(|(counted, _)| match counted {
                        Counted::Visit(_) => Ratio::default(),
                        Counted::Total(rewards) => rewards.choice(choice).clone(),
                    })
                    .collect();
                for (to, weight) in arena.edges(choice) {
                    let p = &arena.fractions.list()[weight as usize];
                    let own = visited(objectives, to as usize);
                    let new = own & !mask;
                    (0..objectives.len()).filter(|at| new >> at & 1 == 1).for_each(|at| gains[at] += p);
                    let to = pairs.number((to, mask | own));
                    pairs.choices.to.push(to);
                    pairs.weights.push(weight);
                }
                let signed = gains.into_iter().zip(objectives).map(|(gain, own)| signed(gain, own.1));
                pairs.gains.push(signed.map(|gain| fractions.number(gain)).collect());
                pairs.choices.start.push(pairs.choices.to.len() as u32);
                meter.take(12 * arena.choices.successors(choice).len() + 4 * objectives.len() + 28)?;
            }
            pairs.choices.first.push(pairs.choices.start.len() as u32 - 1);
        }
        Ok(pairs)
    }
}

/// Returns the objectives that a state satisfies, as bits.
fn visited(objectives: &[(Counted<'_>, Optimum)], state: usize) -> u32 {
    let is_in = |(at, (counted, _)): (usize, &(Counted<'_>, Optimum))| match counted {
        Counted::Visit(set) => u32::from(set[state]) << at,
        Counted::Total(_) => 0,
    };
    objectives.iter().enumerate().map(is_in).sum()
}

fn signed(gain: Ratio, optimum: Optimum) -> Ratio {
    if optimum == Optimum::Max { gain } else { -gain }
}

impl Weighted {
    /// Prepares objectives, each of which is to be great or small.
    ///
    /// # Errors
    /// A reward is earned in an end component; there are too many objectives; a limit is reached.
    pub(crate) fn new(
        arena: &Arena<'_>,
        start: usize,
        objectives: &[(Counted<'_>, Optimum)],
        meter: &mut Meter<'_>,
    ) -> Result<Self> {
        if objectives.len() > u32::BITS as usize {
            let what = format!("{} objectives; at most {} are supported", objectives.len(), u32::BITS);
            return Err(Limit::Size { what }.into());
        }
        let mut fractions = arena.fractions.clone();
        let zero = fractions.number(Ratio::default());
        let pairs = Pairs::explored(arena, start, objectives, &mut fractions, meter)?;
        let found = components::end_components(&pairs.choices, meter)?;
        let mut groups: Vec<Vec<Action>> = (0..found.count).map(|_| Vec::new()).collect();
        for pair in 0..pairs.list.len() as u32 {
            let own = &mut groups[found.group[pair as usize] as usize];
            for choice in pairs.choices.of(pair) {
                let edges = pairs.choices.start[choice] as usize..pairs.choices.start[choice + 1] as usize;
                if found.inside[choice] && pairs.gains[choice].iter().any(|&gain| gain != zero) {
                    let state = arena.program.show_state(&arena.state(pairs.list[pair as usize].0 as usize));
                    return Err(Error::Usage(format!(
                        "several objectives need rewards that end: a reward can be earned for all time from the state {state}"
                    )));
                }
                own.push(match found.inside[choice] {
                    true => Action { edges: Vec::new(), gains: vec![zero; objectives.len()] },
                    false => {
                        let group = |at: usize| found.group[pairs.choices.to[at] as usize];
                        let edges = edges.map(|at| (group(at), pairs.weights[at])).collect();
                        Action { edges, gains: pairs.gains[choice].clone() }
                    }
                });
            }
        }
        let mask = pairs.list[0].1;
        let first = objectives
            .iter()
            .enumerate()
            .map(|(at, own)| signed(Ratio::from_integer((mask >> at & 1).into()), own.1));
        let (first, start) = (first.collect(), found.group[0] as usize);
        let mut weighted = Weighted { groups, fractions, start, first, steps: f64::INFINITY };
        weighted.steps = weighted.steps_until_end(meter)?;
        Ok(weighted)
    }

    /// Returns an upper bound of the expected number of steps from the start until the path stops.
    fn steps_until_end(&self, meter: &mut Meter<'_>) -> Result<f64> {
        let before = meter.bytes();
        let mut graph = Graph::default();
        graph.known.clone_from(&self.fractions);
        let one = graph.fraction(Ratio::one());
        graph.add_node(Rank::default(), false, meter)?;
        for _ in &self.groups {
            graph.add_node(Rank { positive: EVERY, sure: EVERY }, false, meter)?;
        }
        for (node, actions) in (1..).zip(&self.groups) {
            graph.begin(node, meter)?;
            for (position, action) in (0..).zip(actions) {
                graph.add_choice(position, one);
                if action.edges.is_empty() {
                    graph.add_edge(Edge::new(0, one, true));
                }
                action.edges.iter().for_each(|&(to, p)| graph.add_edge(Edge::new(to + 1, p, false)));
            }
            graph.end(node, meter)?;
        }
        let (solution, end) = solved::<Interval>(&graph, Quantity::Reward, None, meter)?;
        end?;
        meter.release_to(before);
        Ok(solution.get(self.start as u32 + 1).map_or(f64::INFINITY, |steps| steps.upper))
    }

    /// Returns a point with nearly the greatest weighted sum, by doubles.
    ///
    /// # Errors
    /// A limit is reached.
    pub(crate) fn near(&self, weights: &[Ratio], meter: &mut Meter<'_>) -> Result<Point> {
        let numbers: Vec<f64> = self.fractions.list().iter().map(nearest).collect();
        let weights: Vec<f64> = weights.iter().map(nearest).collect();
        let better = |q: &f64, than: &f64| *q > than + BETTER * than.abs().max(1.0);
        let (policy, x) = self.improved(&numbers, &weights, better, ROUNDS, meter)?;
        Ok(self.bounded(&policy, &x, &weights, &numbers))
    }

    /// Returns the point of the best policy, exactly.
    ///
    /// # Errors
    /// A limit is reached.
    pub(crate) fn exact(&self, weights: &[Ratio], meter: &mut Meter<'_>) -> Result<Point> {
        let numbers = self.fractions.list();
        let (_, x) = self.improved(numbers, weights, |q, than| q > than, usize::MAX, meter)?;
        let gains: Vec<Ratio> = x[self.start].iter().zip(&self.first).map(|(x, y)| x + y).collect();
        let most = rate(&gains, weights);
        Ok(Point { gains, most })
    }

    /// Improves a policy until no other action is better, at most some times; returns it with its values.
    fn improved<N: Weight>(
        &self,
        numbers: &[N],
        weights: &[N],
        better: impl Fn(&N, &N) -> bool,
        rounds: usize,
        meter: &mut Meter<'_>,
    ) -> Result<(Vec<usize>, Vec<Vec<N>>)> {
        let mut policy = vec![0; self.groups.len()];
        let mut x = self.evaluated(&policy, numbers, meter)?;
        for _ in 0..rounds {
            let v: Vec<N> = x.iter().map(|x| rate(x, weights)).collect();
            let mut changed = false;
            for (group, actions) in self.groups.iter().enumerate() {
                let mut best = v[group].clone();
                for (number, action) in actions.iter().enumerate() {
                    meter.step()?;
                    let q = action.value(numbers, &v).plus(&rate(&action.gained(numbers), weights));
                    if better(&q, &best) {
                        (best, policy[group], changed) = (q, number, true);
                    }
                }
            }
            if !changed {
                break;
            }
            x = self.evaluated(&policy, numbers, meter)?;
        }
        Ok((policy, x))
    }

    /// Returns the expected gains of each group under a policy, by elimination.
    fn evaluated<N: Weight>(
        &self,
        policy: &[usize],
        numbers: &[N],
        meter: &mut Meter<'_>,
    ) -> Result<Vec<Vec<N>>> {
        let row = |(group, &number): (usize, &usize)| {
            let action = &self.groups[group][number];
            let mut edges: Vec<(u32, N)> = Vec::new();
            let mut sorted = action.edges.clone();
            sorted.sort_unstable_by_key(|edge| edge.0);
            for (to, p) in sorted.into_iter().filter(|edge| edge.0 as usize != group) {
                let p = &numbers[p as usize];
                match edges.last_mut() {
                    Some((last, sum)) if *last == to => *sum = sum.plus(p),
                    _ => edges.push((to, p.clone())),
                }
            }
            // To stop is to leave.
            let escape = if action.edges.is_empty() { self.one(numbers) } else { N::zero() };
            Row { edges, escape, constant: action.gained(numbers) }
        };
        let mut left = usize::MAX;
        let rows = policy.iter().enumerate().map(row).collect();
        let mut found = eliminate::solve(rows, &mut left, meter).map_err(|stop| match stop {
            Stop::Limit(error) => error,
            _ => Limit::Size { what: "the objectives of a strategy have no values".to_owned() }.into(),
        })?;
        found.iter_mut().for_each(|x| x.resize(self.first.len(), N::zero()));
        Ok(found)
    }

    fn one<N: Weight>(&self, numbers: &[N]) -> N {
        let one = self.fractions.list().iter().position(One::is_one);
        one.map_or_else(N::zero, |one| numbers[one].clone())
    }

    /// Returns bounds from the values of a policy, by how much they miss the equations.
    fn bounded(&self, policy: &[usize], x: &[Vec<f64>], weights: &[f64], numbers: &[f64]) -> Point {
        let v: Vec<f64> = x.iter().map(|x| x.iter().zip(weights).map(|(x, w)| x * w).sum()).collect();
        let (mut missed, mut more) = (vec![0.0f64; weights.len()], 0.0f64);
        for (group, actions) in self.groups.iter().enumerate() {
            for (number, action) in actions.iter().enumerate() {
                let error = (action.edges.len() + weights.len() + 8) as f64 * f64::EPSILON;
                let gains = action.gained(numbers);
                let size = |x: &dyn Fn(usize) -> f64, gain: f64| {
                    let terms = action.edges.iter();
                    let all: f64 = terms.map(|&(to, p)| numbers[p as usize] * x(to as usize).abs()).sum();
                    (all + gain.abs() + x(group).abs()) * 2.0 * error
                };
                let rated: f64 = gains.iter().zip(weights).map(|(x, w)| x * w).sum();
                let largest = gains.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
                let rounding = size(&|at| v[at], rated) + largest * error;
                more = more.max(action.value(numbers, &v) + rated - v[group] + rounding);
                if number != policy[group] {
                    continue;
                }
                for (at, missed) in missed.iter_mut().enumerate() {
                    let sum = action
                        .edges
                        .iter()
                        .fold(gains[at], |sum, &(to, p)| sum + numbers[p as usize] * x[to as usize][at]);
                    let rounding = size(&|to| x[to][at], gains[at]);
                    *missed = missed.max((sum - x[group][at]).abs() + rounding);
                }
            }
        }
        let exact = |x: f64| Ratio::from_float(x);
        let below = |at: usize| {
            exact((x[self.start][at] - missed[at] * self.steps * (1.0 + f64::EPSILON)).next_down())
        };
        let gains = (0..weights.len()).map(|at| below(at).map(|x| x + &self.first[at]));
        let first: Ratio = self.first.iter().zip(weights).filter_map(|(x, &w)| Some(x * exact(w)?)).sum();
        let most = exact((v[self.start] + more * self.steps * (1.0 + f64::EPSILON)).next_up());
        let unknown = || Ratio::from_float(f64::MAX).unwrap_or_default();
        Point {
            gains: gains.map(|gain| gain.unwrap_or_else(|| -unknown())).collect(),
            most: most.map_or_else(unknown, |most| most + first),
        }
    }
}

impl Action {
    /// Returns Σ p · v.
    fn value<N: Weight>(&self, numbers: &[N], v: &[N]) -> N {
        let term = |sum: N, &(to, p): &(u32, u32)| sum.plus(&numbers[p as usize].times(&v[to as usize]));
        self.edges.iter().fold(N::zero(), term)
    }

    fn gained<N: Clone>(&self, numbers: &[N]) -> Vec<N> {
        self.gains.iter().map(|&gain| numbers[gain as usize].clone()).collect()
    }
}

/// Returns a weighted sum.
fn rate<N: Weight>(gains: &[N], weights: &[N]) -> N {
    gains.iter().zip(weights).fold(N::zero(), |sum, (x, w)| sum.plus(&x.times(w)))
}

/// Returns the nearest double.
fn nearest(x: &Ratio) -> f64 {
    let size = x.abs().to_f64().unwrap_or(f64::MAX);
    if x.is_negative() { -size } else { size }
}
