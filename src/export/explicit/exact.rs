//! The numbers of a model state by state, as exact fractions: probabilities and rewards.

use num_rational::BigRational;
use num_traits::{One, Zero};

use super::graph::Graph;
use super::label::unique;
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_base::progress::ProgressSink;
use meliora_model::step::{Choice, Step};
use meliora_model::{Program, fault};

/// The exact numbers of a graph.
pub(super) struct Exact {
    /// The probability of each transition, in the order of the graph.
    pub(super) probabilities: Vec<Ratio>,
    /// The reward structures that have a value in all states.
    pub(super) rewards: Vec<Rewards>,
}

/// A reward structure.
pub(super) struct Rewards {
    pub(super) name: String,
    /// The reward of each state, with every choice.
    pub(super) states: Vec<Ratio>,
    /// The additional reward of each choice.
    pub(super) choices: Vec<Ratio>,
}

/// Computes the exact numbers of a graph whose states begin with the variables of the program. Cost:
/// one step of the program per state.
///
/// # Errors
/// The program has no meaning in a state; a limit is reached.
pub(super) fn exact(graph: &Graph, program: &Program, sink: &dyn ProgressSink) -> Result<Exact> {
    let of = |number: usize| &graph.states[number][..program.variables.len()];
    let mut found = Exact { probabilities: Vec::new(), rewards: structures(program) };
    let mut wrong = vec![false; program.rewards.len()];
    for (number, rows) in graph.rows.iter().enumerate() {
        if let Some(limit) = sink.stop() {
            return Err(limit.into());
        }
        let state = of(number);
        let steps = program.exact_steps(state).map_err(|e| fault::error(program, &e, state))?;
        let step_of = |action: &str| steps.iter().find(|step| step.name == action);
        for row in rows {
            let step = step_of(&row.action);
            for (to, rounded) in &row.successors {
                let exact = step.and_then(|s| probability(s, of(*to)));
                let rounded = || Ratio::from_float(*rounded).unwrap_or_else(Ratio::one);
                found.probabilities.push(exact.unwrap_or_else(rounded));
            }
        }
        for ((rewards, structure), wrong) in found.rewards.iter_mut().zip(&program.rewards).zip(&mut wrong) {
            // An error in a structure matters only where it is used.
            let earned = |choice: &Choice| program.reward(structure, state, choice);
            let Ok(always) = earned(&Choice::Deadlock) else {
                *wrong = true;
                continue;
            };
            for row in rows {
                let all = step_of(&row.action).map_or_else(|| Ok(always.clone()), |s| earned(&s.choice));
                *wrong |= all.is_err();
                rewards.choices.push(all.unwrap_or_else(|_| BigRational::zero()) - &always);
            }
            rewards.states.push(always);
        }
    }
    let mut wrong = wrong.into_iter();
    found.rewards.retain(|_| wrong.next() == Some(false));
    Ok(found)
}

fn structures(program: &Program) -> Vec<Rewards> {
    let name = |name: &Option<String>| name.clone().unwrap_or_else(|| "reward".to_owned());
    let empty = |name: String| Rewards { name, states: Vec::new(), choices: Vec::new() };
    let names: Vec<String> = program.rewards.iter().map(|structure| name(&structure.name)).collect();
    unique(names.iter().map(String::as_str), &[]).into_iter().map(empty).collect()
}

fn probability(step: &Step<Ratio>, to: &[i64]) -> Option<Ratio> {
    step.successors.iter().find(|(state, _)| state == to).map(|(_, p)| p.clone())
}
