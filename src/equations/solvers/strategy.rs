//! Strategies for weighted sums of objectives, node by node.

use std::sync::Arc;

use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_model::Optimum;

use super::components::EndComponents;
use super::pairs::{Counted, Pairs, Taken};
use crate::graphs::arena::Arena;
use crate::graphs::graph::NONE;
use crate::graphs::meter::Meter;

/// A state that a strategy visits, with its memory.
#[derive(Debug, Clone)]
pub struct Node {
    /// The number of the state in the arena.
    pub state: usize,
    /// The objectives that the path has decided, as bits.
    pub decided: u32,
    /// The number of steps, as far as objectives count it.
    pub steps: u32,
    /// The choices that are taken, each with the same probability.
    pub choices: Vec<Taking>,
}

/// A choice that a strategy takes.
#[derive(Debug, Clone)]
pub struct Taking {
    /// Its position among the choices of the state in the program.
    pub position: usize,
    /// The nodes after it, with their probabilities.
    pub successors: Vec<(usize, Arc<Ratio>)>,
}

/// Returns the choices that each pair takes if its group takes an action: where a path stays for the sake of sets that
/// recur, all choices that stay, each with the same probability; else one. Cost: some sweeps over the pairs.
///
/// # Errors
/// The work is cancelled.
pub(super) fn picks(
    pairs: &Pairs,
    resting: &EndComponents,
    taken: &[Taken],
    objectives: &[(Counted<'_>, Optimum)],
    meter: &mut Meter<'_>,
) -> Result<Vec<Vec<usize>>> {
    let mut picks: Vec<Vec<usize>> = vec![Vec::new(); pairs.list.len()];
    let recurs = objectives.iter().any(|own| matches!(own.0, Counted::Recur(_)));
    let owner = pairs.choices.reversed().owner;
    for &taken in taken {
        match taken {
            Taken::Choice(choice) => picks[owner[choice] as usize].push(choice),
            Taken::Stay(end) => {
                for (pair, mut choices) in pairs.staying(objectives, &resting.inside, end, meter)? {
                    choices.truncate(if recurs { usize::MAX } else { 1 });
                    picks[pair as usize] = choices;
                }
            }
            Taken::Nothing => {}
        }
    }
    // The others of a group come closer to these.
    let mut open: Vec<u32> = (0..pairs.list.len() as u32).collect();
    let mut before = usize::MAX;
    while open.len() < before {
        before = open.len();
        meter.step()?;
        open.retain(|&pair| {
            let known = |&to: &u32| !picks[to as usize].is_empty();
            let leads = |&choice: &usize| {
                resting.inside[choice] && pairs.choices.successors(choice).iter().any(known)
            };
            if picks[pair as usize].is_empty() {
                let closer = pairs.choices.of(pair).find(leads);
                picks[pair as usize].extend(closer);
            }
            picks[pair as usize].is_empty()
        });
        open.reverse();
    }
    Ok(picks)
}

/// Returns the nodes that a strategy visits, beginning with the start.
pub(super) fn followed(pairs: &Pairs, picks: &[Vec<usize>], arena: &Arena<'_>) -> Vec<Node> {
    let (mut order, mut numbers, mut nodes) = (vec![0u32], vec![NONE; pairs.list.len()], Vec::new());
    let fractions = arena.shared_fractions();
    numbers[0] = 0;
    while let Some(&pair) = order.get(nodes.len()) {
        let (state, memory) = pairs.list[pair as usize];
        let (first, own) = (pairs.choices.of(pair).start, arena.choices.of(state).start);
        let taking = |&choice: &usize| {
            let mut successors = Vec::new();
            for (&to, &p) in pairs.choices.successors(choice).iter().zip(pairs.weights(choice)) {
                if numbers[to as usize] == NONE {
                    numbers[to as usize] = order.len() as u32;
                    order.push(to);
                }
                successors.push((numbers[to as usize] as usize, Arc::clone(&fractions[p as usize])));
            }
            Taking { position: arena.position(own + choice - first), successors }
        };
        let choices = picks[pair as usize].iter().map(taking).collect();
        nodes.push(Node { state: state as usize, decided: memory.decided, steps: memory.steps, choices });
    }
    nodes
}
