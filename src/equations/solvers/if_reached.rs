//! Rewards until a set is reached, which are lost on paths that do not reach it: `F0 t` of PRISM-games.
//!
//! A strategy needs the reward c of the path so far. Let p(s) be the probability to reach the set, and let w(s) be the
//! reward of later steps, each weighted by p, under choices that attain p. Where c is large, no other choice is better, so
//! the value is c·p(s) + w(s): it satisfies the equation of each choice from some bound B of c on. Below B, the pairs of a
//! state and a reward are a finite game, which ends with these values. T. Chen et al., "Automatic verification of
//! competitive stochastic systems" (Formal Methods in System Design 43, 2013), section 5.

use ahash::AHashMap;
use bitvec::vec::BitVec;
use meliora_base::error::{Error, Result};
use meliora_base::exact::Ratio;
use meliora_space::weighted::Fractions;
use num_traits::{One, Zero};

use super::reaching::{Collected, Reaching, Vector};
use super::sides::Sides;
use crate::graphs::builder::Builder;
use crate::graphs::game_graph::{Edge, Extremes, GameGraph, Rewards};
use crate::graphs::meter::Meter;
use meliora_base::number::Number;

/// Computes the values of all states; those without bound have none. Cost: two systems of equations with fractions, and
/// one of the pairs of a state and a reward below B.
///
/// # Errors
/// Delays raise the reward without end while the probability stays the same, and only one side wants that; a limit is
/// reached before anything is known.
pub(crate) fn values<N: Number>(
    game: &GameGraph,
    rewards: &Rewards,
    target: &BitVec,
    goal: Extremes,
    meter: &mut Meter<'_>,
) -> Result<Vector<N>> {
    let maximisers = game.maximisers(goal);
    let (finite, infinite) = finite(game, rewards, target, &maximisers, meter)?;
    let game = subgame(game, rewards, &finite, meter)?;
    let asked = Asked { game: &game, target, infinite: &infinite, goal, maximisers: &maximisers };
    let late = asked.late(meter)?;
    let (pairs, starts) = Pairs::starting(&asked, &late);
    let (pairs, payments) = pairs.explored(meter)?;
    let [left, end] = [|_| true, |node| node == 0]
        .map(|inside: fn(usize) -> bool| (0..pairs.states()).map(inside).collect());
    let found =
        Reaching { game: &pairs, target: &end, left: &left, collected: Collected::Always(&payments), goal }
            .values::<N>(meter)?;
    let value =
        |state: usize| if infinite[state] { None } else { found.values[starts[state] as usize].clone() };
    Ok(Vector { values: (0..starts.len()).map(value).collect(), end: found.end })
}

/// Returns the choices from which the value is finite, and the states with an infinite one: those from which maximisers
/// can earn again and again, with positive probability, where the set can still be reached.
fn finite(
    game: &GameGraph,
    rewards: &Rewards,
    target: &BitVec,
    maximisers: &BitVec,
    meter: &mut Meter<'_>,
) -> Result<(BitVec, BitVec)> {
    let gains: BitVec = (0..game.choices_in_all()).map(|choice| !rewards.is_free(choice)).collect();
    let mut allowed = BitVec::repeat(true, game.choices_in_all());
    let mut infinite = BitVec::repeat(false, game.states());
    let everywhere = BitVec::repeat(true, game.states());
    loop {
        let before = meter.bytes();
        let sides = Sides::new(&game.choices, maximisers, &allowed, meter)?;
        let hopeful = sides.positive(target, &everywhere) & !target.clone() & !infinite.clone();
        let more = sides.recurring(&gains, &hopeful, meter)?;
        meter.release_to(before);
        if more.not_any() {
            return Ok((allowed, infinite));
        }
        infinite |= more;
        for choice in 0..allowed.len() {
            let stays = game.choices.successors(choice).iter().all(|&to| !infinite[to as usize]);
            allowed.set(choice, stays);
        }
    }
}

/// A game whose choices have rewards.
type Earning = (GameGraph, Rewards);

/// Returns the game with some of the choices.
fn subgame(game: &GameGraph, rewards: &Rewards, allowed: &BitVec, meter: &mut Meter<'_>) -> Result<Earning> {
    meter.take(game.choices.bytes() + 5 * game.edges_in_all())?;
    let mut builder = Builder::new(game);
    for state in 0..game.states() as u32 {
        for choice in game.choices(state).filter(|&choice| allowed[choice as usize]) {
            game.edges(choice).for_each(|edge| builder.edge(edge));
            builder.end_choice(rewards.choice(choice as usize).clone());
        }
        builder.end_state(game.is_theirs(state));
    }
    Ok(builder.built())
}

/// A game whose choices lead from states with a finite value to such states.
struct Asked<'a> {
    game: &'a Earning,
    target: &'a BitVec,
    /// The states with an infinite value.
    infinite: &'a BitVec,
    goal: Extremes,
    maximisers: &'a BitVec,
}

/// The value where the reward of the path so far is large.
struct Late {
    probability: Vec<Ratio>,
    weighted: Vec<Ratio>,
    /// The least reward that is large.
    bound: Ratio,
}

impl Late {
    /// Returns c·p(s) + w(s).
    fn value(&self, state: usize, so_far: &Ratio) -> Ratio {
        so_far * &self.probability[state] + &self.weighted[state]
    }
}

impl Asked<'_> {
    /// Solves the game for large rewards.
    fn late(&self, meter: &mut Meter<'_>) -> Result<Late> {
        let (game, rewards) = self.game;
        let everywhere = BitVec::repeat(true, game.states());
        let reaching = |game, collected, meter: &mut Meter<'_>| {
            Reaching { game, target: self.target, left: &everywhere, collected, goal: self.goal }
                .values::<Ratio>(meter)
        };
        let found = reaching(game, Collected::Target, meter)?;
        let probability: Vec<Ratio> = found.values.into_iter().map(Option::unwrap_or_default).collect();
        let mean = |choice: u32, of: &[Ratio]| {
            let part = |edge: Edge| &game.fractions()[edge.probability() as usize] * &of[edge.to as usize];
            game.edges(choice).map(part).fold(Ratio::zero(), |sum, part| sum + part)
        };
        let mut best = Builder::new(game);
        for state in 0..game.states() {
            for choice in game.choices(state as u32) {
                meter.step()?;
                if mean(choice, &probability) == probability[state] {
                    game.edges(choice).for_each(|edge| best.edge(edge));
                    best.end_choice(rewards.choice(choice as usize) * &probability[state]);
                }
            }
            best.end_state(game.is_theirs(state as u32));
        }
        let (best, weighted) = best.built();
        let found = reaching(&best, Collected::Always(&weighted), meter)?;
        let endless =
            (0..game.states()).find(|&state| found.values[state].is_none() && !self.infinite[state]);
        if endless.is_some() {
            let message = "`F0` is not supported for this game: the reward grows by delays that leave the probability \
                           of the target as it is, and the other side pays for it with a greater probability";
            return Err(Error::Usage(message.to_owned()));
        }
        let weighted: Vec<Ratio> = found.values.into_iter().map(Option::unwrap_or_default).collect();
        let mut late = Late { probability, weighted, bound: Ratio::zero() };
        for state in (0..game.states()).filter(|&state| !self.target[state] && !self.infinite[state]) {
            for choice in game.choices(state as u32) {
                meter.step()?;
                let p = mean(choice, &late.probability);
                let w = rewards.choice(choice as usize) * &p + mean(choice, &late.weighted);
                let (less, more) = (&late.probability[state] - p, w - &late.weighted[state]);
                // From the reward at which both lines meet, the choice is not better.
                if !less.is_zero() && (less > Ratio::zero()) == self.maximisers[state] {
                    late.bound = late.bound.max(more / less);
                }
            }
        }
        Ok(late)
    }
}

/// A node of the game below the bound.
#[derive(Clone, Copy)]
enum Node {
    /// The end, which is node 0.
    End,
    /// The payment with this number, before the end.
    Payment(u32),
    /// A state, and the number of the reward so far.
    Pair(u32, u32),
}

/// The nodes below the bound, in the order of their numbers. The game ends in a state of the target and where the reward
/// is large, with a payment of the value.
struct Pairs<'a> {
    asked: &'a Asked<'a>,
    late: &'a Late,
    /// Rewards and payments.
    amounts: Fractions,
    nodes: Vec<Node>,
    pairs: AHashMap<(u32, u32), u32>,
    payments: AHashMap<u32, u32>,
}

impl<'a> Pairs<'a> {
    /// Returns the nodes of all states with the reward 0, which is the number of their node.
    fn starting(asked: &'a Asked<'a>, late: &'a Late) -> (Self, Vec<u32>) {
        let (pairs, payments) = Default::default();
        let mut all =
            Pairs { asked, late, amounts: Fractions::default(), nodes: vec![Node::End], pairs, payments };
        let states = 0..asked.game.0.states() as u32;
        let starts = states.map(|state| all.node(state, Ratio::zero())).collect();
        (all, starts)
    }

    /// Returns the node of a state with a reward.
    fn node(&mut self, state: u32, so_far: Ratio) -> u32 {
        let at = state as usize;
        let value = match self.asked.target[at] {
            true => so_far,
            false if self.asked.infinite[at] || self.late.probability[at].is_zero() => return 0,
            false if so_far >= self.late.bound => self.late.value(at, &so_far),
            false => {
                let key = (state, self.amounts.number(so_far));
                let nodes = &mut self.nodes;
                return *self.pairs.entry(key).or_insert_with(|| added(nodes, Node::Pair(key.0, key.1)));
            }
        };
        if value.is_zero() {
            return 0;
        }
        let (payment, nodes) = (self.amounts.number(value), &mut self.nodes);
        *self.payments.entry(payment).or_insert_with(|| added(nodes, Node::Payment(payment)))
    }

    /// Explores the nodes. Cost: one step of the game per pair.
    fn explored(mut self, meter: &mut Meter<'_>) -> Result<Earning> {
        let (game, rewards) = self.asked.game;
        let mut builder = Builder::new(game);
        let certain = builder.number(One::one());
        let mut number = 0;
        while let Some(&node) = self.nodes.get(number) {
            number += 1;
            meter.take(size_of::<(Node, [u32; 8])>())?;
            let Node::Pair(state, so_far) = node else {
                if let Node::Payment(payment) = node {
                    builder.edge(Edge::new(0, certain, false));
                    builder.end_choice(self.amounts.list()[payment as usize].clone());
                }
                builder.end_state(false);
                continue;
            };
            for choice in game.choices(state) {
                let then = &self.amounts.list()[so_far as usize] + rewards.choice(choice as usize);
                meter.take(game.edges(choice).count() * size_of::<Edge>())?;
                let enter =
                    |edge: Edge| Edge::new(self.node(edge.to, then.clone()), edge.probability(), false);
                game.edges(choice).map(enter).for_each(|edge| builder.edge(edge));
                builder.end_choice(Ratio::zero());
            }
            builder.end_state(game.is_theirs(state));
        }
        Ok(builder.built())
    }
}

fn added(nodes: &mut Vec<Node>, node: Node) -> u32 {
    nodes.push(node);
    nodes.len() as u32 - 1
}
