//! The value that a strategy attains: that of the chain that its nodes leave, or of the choices of the opponent there.
//!
//! Nodes remember the steps, so a bound is a set of nodes, and the chain has the equations of a formula without bounds.

use bitvec::vec::BitVec;
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_equations::vector::{Accumulation, Until};
use meliora_equations::{Arena, Builder, Edge, Extremes, Rewards, Value};

use super::nodes::Key;
use super::{Accepting, Aim, Nodes};
use crate::chain::Chain;

/// Computes the values of a strategy in its first nodes, against the best choices of the opponent; with fractions where
/// bounds are wider than the precision. Cost: that of the values of a model of this size.
///
/// # Errors
/// A limit is reached.
pub fn attained(
    arena: &Arena<'_>,
    aim: &Aim<'_>,
    goal: Extremes,
    (nodes, starts): (&Nodes, usize),
    precision: f64,
) -> Result<Vec<Value>> {
    let (chain, rewards) = chain(arena, aim, nodes)?;
    let asked = chain.asked(goal, precision);
    let members = |inside: &dyn Fn(&Key) -> bool| {
        let mut members: BitVec = nodes.keys.iter().map(inside).collect();
        members.resize(chain.game.states(), false);
        members
    };
    let of = |set: &BitVec| members(&|node| set[node.state as usize]);
    let mut found = match aim {
        Aim::Until(Until { left, right, least, .. }) => {
            let right = members(&|node| right[node.state as usize] && u64::from(node.steps) >= *least);
            asked.probability(&Until::unbounded(of(left), right))?
        }
        Aim::Recur(all_of) => {
            let ends = chain.ends(|component| accepts(all_of, &nodes.keys, component));
            asked.probability(&Until::unbounded(chain.all(true), ends))?
        }
        Aim::Reward(_, accumulation) => asked.reward(
            &rewards,
            &match accumulation {
                Accumulation::Until(target) => Accumulation::Until(of(target)),
                Accumulation::Anyway(target) => Accumulation::Anyway(of(target)),
                Accumulation::IfReached(target) => Accumulation::IfReached(of(target)),
                Accumulation::Within(_) | Accumulation::Total | Accumulation::At(_) => Accumulation::Total,
                Accumulation::LongRun => Accumulation::LongRun,
            },
        )?,
    };
    found.values.truncate(starts);
    found.end.map(|()| found.values)
}

/// Returns the nodes of a strategy as a game, with the rewards of the aim. Where a path is decided, it stays; with a last
/// node for the ends of paths that a reward is earned in.
fn chain<'a>(arena: &'a Arena<'a>, aim: &Aim<'_>, nodes: &Nodes) -> Result<(Chain<'a>, Rewards)> {
    let (of, at_end) = match aim {
        Aim::Reward(rewards, accumulation) => (Some(*rewards), matches!(accumulation, Accumulation::At(_))),
        Aim::Until(_) | Aim::Recur(_) => (None, false),
    };
    let (mut meter, mut builder) = (arena.meter(), Builder::new(arena));
    let sure = builder.number(Ratio::from_integer(1.into()));
    let last = nodes.count() as u32;
    for (number, key) in (0..).zip(&nodes.keys) {
        let choices = nodes.game.choices(number);
        for choice in choices.clone() {
            let edges = nodes.game.edges(choice);
            meter.take(8 * (edges.clone().count() + 1))?;
            edges.for_each(|edge| builder.edge(edge));
            let earned = of.filter(|_| !at_end).map(|of| of.choice(nodes.numbers[choice as usize] as usize));
            builder.end_choice(earned.cloned().unwrap_or_default());
        }
        meter.take(16)?;
        if choices.is_empty() {
            builder.edge(Edge::new(if at_end { last } else { number }, sure, false));
            let earned = of.filter(|_| at_end).map(|of| of.state(key.state as usize));
            builder.end_choice(earned.cloned().unwrap_or_default());
        }
        builder.end_state(nodes.game.is_theirs(number));
    }
    if at_end {
        builder.edge(Edge::new(last, sure, false));
        builder.end_choice(Ratio::default());
        builder.end_state(false);
    }
    let (game, rewards) = builder.built();
    Ok((Chain { arena, game }, rewards))
}

/// Returns whether a component that is never left satisfies one of some conditions.
fn accepts(all: &[Accepting], keys: &[Key], component: &[u32]) -> bool {
    let states = component.iter().map(|&node| keys[node as usize].state as usize);
    all.iter().any(|condition| {
        states.clone().all(|state| condition.always[state])
            && condition.again.iter().all(|set| states.clone().any(|state| set[state]))
    })
}
