//! The probability with which the first improvement gains each objective.

use std::collections::BTreeMap;
use std::sync::Arc;

use ahash::AHashMap;
use schemars::JsonSchema;
use serde::Serialize;

use crate::cost::Cost;
use crate::state_values::Bound;
use crate::{Aim, Chooser};
use meliora_base::error::{Error, Result};
use meliora_engine::Engine;
use meliora_model::preference::ObjectiveSet;
use meliora_model::{Program, State};
use meliora_planning::{Analysis, FiniteMemoryStrategy, Kind, Memory};

/// The probability that the first improvement gains these objectives.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "gain")]
pub struct GainValues {
    /// The objectives that are preferred to most preferred ones of the state, and none of which is sure
    /// there.
    pub gained: Vec<String>,
    /// The probability.
    pub probability: Bound,
}

/// Returns the gains of the first improvement from a state, and how likely each is under the strategy that
/// `--choose likely` takes for one improvement; empty where none is possible. The bounds are at most
/// `precision` apart. Cost: that of [`Chooser::compute`], and one explanation per state that the strategy
/// visits.
///
/// # Errors
/// The model is a game, in which the opponent decides on the gain; the levels are not known; a limit is
/// reached.
pub fn by_goal<E: Engine>(
    analysis: &Analysis<E>,
    program: &Arc<Program>,
    state: &State,
    costs: &dyn Cost,
    precision: f64,
) -> Result<Vec<GainValues>> {
    if analysis.whole_engine().is_game() {
        let message = "`--by-goal` of a game is not supported: the opponent decides on the gain";
        return Err(Error::Usage(message.to_owned()));
    }
    let Some(mut strategy) = FiniteMemoryStrategy::new(analysis, program, Kind::Spi) else {
        return Ok(Vec::new());
    };
    let rule =
        Chooser::compute(analysis, program, std::slice::from_ref(state), (Aim::Likely, Some(1)), costs)?;
    strategy.choose_by(Arc::new(rule));
    let chain = Chain::explore(analysis, &mut strategy, state)?;
    let (absorbed, open) = chain.absorbed(analysis, precision)?;
    let mut shares = BTreeMap::<Vec<String>, f64>::new();
    for (names, share) in analysis.names_of_gains(state, &chain.gains)?.into_iter().zip(absorbed) {
        *shares.entry(names).or_default() += share;
    }
    let value = |(gained, lower): (Vec<String>, f64)| {
        let upper = (lower + open).min(1.0);
        GainValues { gained, probability: Bound { lower, upper, exact: None } }
    };
    Ok(shares.into_iter().map(value).collect())
}

/// The end of an edge.
enum End {
    Node(usize),
    /// A position in [`Chain::gains`].
    Gain(usize),
}

/// The Markov chain of a strategy until its first improvement.
struct Chain {
    edges: Vec<Vec<(End, f64)>>,
    /// The objectives that improvements gain, each set once.
    gains: Vec<ObjectiveSet>,
}

impl Chain {
    /// Explores the states and memories that the strategy visits.
    fn explore<E: Engine>(
        analysis: &Analysis<E>,
        strategy: &mut FiniteMemoryStrategy<E>,
        start: &State,
    ) -> Result<Self> {
        let sink = Arc::clone(&analysis.engine().settings().sink);
        let mut places: AHashMap<(State, Memory), usize> = AHashMap::new();
        let mut queue = vec![(start.clone(), strategy.start(start)?)];
        places.insert(queue[0].clone(), 0);
        let (mut edges, mut gains) = (Vec::<Vec<(End, f64)>>::new(), Vec::<ObjectiveSet>::new());
        while let Some((state, memory)) = queue.get(edges.len()).cloned() {
            if let Some(limit) = sink.stop() {
                return Err(limit.into());
            }
            let at = strategy.explain(&state, memory)?;
            let mut own = Vec::new();
            for to in at.pick.iter().flat_map(|&pick| &at.actions[pick].successors).filter(|s| !s.dropped) {
                let end = match to.improves {
                    true => {
                        let known = gains.iter().position(|gain| *gain == to.gained);
                        if known.is_none() {
                            gains.push(to.gained.clone());
                        }
                        End::Gain(known.unwrap_or(gains.len() - 1))
                    }
                    false => {
                        let (next, new) = ((to.state.clone(), to.next), places.len());
                        let place = *places.entry(next.clone()).or_insert(new);
                        if place == new {
                            queue.push(next);
                        }
                        End::Node(place)
                    }
                };
                own.push((end, to.probability));
            }
            edges.push(own);
        }
        Ok(Chain { edges, gains })
    }

    /// Moves the probability along the edges until at most `precision` of it can still gain something.
    /// Returns the gains with their probabilities so far, and the rest.
    fn absorbed<E: Engine>(&self, analysis: &Analysis<E>, precision: f64) -> Result<(Vec<f64>, f64)> {
        let sink = Arc::clone(&analysis.engine().settings().sink);
        let hopeful = self.hopeful();
        let mut shares = vec![0.0; self.gains.len()];
        let mut mass = vec![0.0; self.edges.len()];
        mass[0] = f64::from(hopeful[0]);
        loop {
            let open: f64 = mass.iter().sum();
            if open <= precision / 2.0 {
                return Ok((shares, open));
            }
            if let Some(limit) = sink.stop() {
                return Err(limit.into());
            }
            let mut next = vec![0.0; mass.len()];
            for (edges, own) in self.edges.iter().zip(&mass).filter(|(_, own)| **own > 0.0) {
                for (end, p) in edges {
                    match end {
                        End::Node(to) => next[*to] += own * p * f64::from(hopeful[*to]),
                        End::Gain(gained) => shares[*gained] += own * p,
                    }
                }
            }
            mass = next;
        }
    }

    /// Returns the nodes from which a gain can be reached.
    fn hopeful(&self) -> Vec<bool> {
        let mut into = vec![Vec::new(); self.edges.len()];
        let mut queue = Vec::new();
        for (from, edges) in self.edges.iter().enumerate() {
            for (end, _) in edges {
                match end {
                    End::Node(to) => into[*to].push(from),
                    End::Gain(_) => queue.push(from),
                }
            }
        }
        let mut hopeful = vec![false; self.edges.len()];
        while let Some(node) = queue.pop() {
            if !std::mem::replace(&mut hopeful[node], true) {
                queue.extend(&into[node]);
            }
        }
        hopeful
    }
}
