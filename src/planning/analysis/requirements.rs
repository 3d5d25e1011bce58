//! Requirements: the part of a model in which some strategy surely keeps them.
//!
//! Z is the greatest set of states from which some choices keep all requirements surely. The model
//! is restricted once, before the analysis: to the states of Z, and to the choices with all
//! successors in Z. All results are those of the restricted model. A deadlock state that violates
//! nothing keeps the requirements: its self-loop stays there.

use super::result::{Escape, EscapeStep};
use meliora_base::error::Result;
use meliora_engine::{Engine, Region};
use meliora_model::preference::Requirement;
use meliora_model::valuation::Valuation;
use meliora_model::{Program, State, fault};

/// The model of an analysis: as it is written, and restricted by the requirements.
pub struct Requirements<E: Engine> {
    /// P, the states in which no requirement is violated.
    pub kept: E::States,
    /// S \ Z, the states from which no strategy surely keeps all requirements.
    pub unsafe_states: E::States,
}

/// Computes P, the states in which no requirement is violated. Cost: no image.
///
/// # Errors
/// A limit of the engine is reached, or a state formula has no value.
pub(crate) fn kept<E: Engine>(engine: &E, requirements: &[Requirement]) -> Result<E::States> {
    requirements.iter().try_fold(engine.all_states(), |kept, requirement| {
        engine.intersection(&kept, &engine.states_where(&requirement.kept)?)
    })
}

impl<E: Engine> Requirements<E> {
    /// Restricts the model of an engine. Returns the engine of Z with the requirements, or `None`
    /// without requirements. Cost: one [`Engine::stay_within`].
    ///
    /// # Errors
    /// The errors of `kept`.
    pub fn restrict(engine: &E, requirements: &[Requirement]) -> Result<Option<(E, Self)>> {
        if requirements.is_empty() {
            return Ok(None);
        }
        let kept = kept(engine, requirements)?;
        let Region { states, choices } = engine.stay_within(&kept, &engine.all_choices())?;
        let unsafe_states = engine.difference(&engine.all_states(), &states)?;
        let restricted = engine.restricted_to(&Region { states, choices })?;
        Ok(Some((restricted, Requirements { kept, unsafe_states })))
    }

    /// Returns a shortest path from an unsafe state to a violation, through states from which the
    /// violation cannot be ruled out; `None` for other states. `engine` is that of the whole model.
    /// Cost: one pre-image per step of the path.
    ///
    /// # Errors
    /// A limit of the engine is reached, or a command has no meaning in a state.
    pub fn escape(
        &self,
        engine: &E,
        program: &Program,
        requirements: &[Requirement],
        start: &[i64],
    ) -> Result<Option<Escape>> {
        if !engine.contains(&self.unsafe_states, start)? {
            return Ok(None);
        }
        let mut layers = self.layers(engine, start)?;
        layers.pop();
        let mut path = vec![(start.to_vec(), None)];
        while let Some(layer) = layers.pop() {
            let Some((last, action)) = path.last_mut() else { break };
            let Some((name, next)) = step_into(engine, program, last, &layer)? else { break };
            *action = Some(name);
            path.push((next, None));
        }
        let violated = path.last().map(|(state, _)| violated(engine, requirements, state)).transpose()?;
        let step =
            |(state, action): (State, _)| EscapeStep { state: Valuation::new(program, &state), action };
        Ok(Some(Escape { violated: violated.flatten(), path: path.into_iter().map(step).collect() }))
    }

    /// Returns the unsafe states by their distance from a violation, up to that of `start`.
    fn layers(&self, engine: &E, start: &[i64]) -> Result<Vec<E::States>> {
        let within = engine.choices_in(&engine.all_choices(), &self.unsafe_states)?;
        let mut open = engine.intersection(&self.unsafe_states, &self.kept)?;
        let mut layers = vec![engine.difference(&self.unsafe_states, &self.kept)?];
        while let Some(last) = layers.last() {
            if engine.contains(last, start)? || engine.is_empty(last)? {
                break;
            }
            let next = engine.intersection(&engine.sources(&engine.pre(&within, last)?)?, &open)?;
            open = engine.difference(&open, &next)?;
            layers.push(next);
        }
        Ok(layers)
    }
}

/// Returns the first action of a state with a successor in a set, and that successor.
fn step_into<E: Engine>(
    engine: &E,
    program: &Program,
    state: &[i64],
    into: &E::States,
) -> Result<Option<(String, State)>> {
    for step in program.steps(state).map_err(|f| fault::error(program, &f, state))? {
        for (successor, _) in step.successors {
            if engine.contains(into, &successor)? {
                return Ok(Some((step.name, successor)));
            }
        }
    }
    Ok(None)
}

/// Returns the requirement that is violated in a state: the first `G p` where p is false there, else
/// the conjunction of all.
fn violated<E: Engine>(engine: &E, requirements: &[Requirement], state: &[i64]) -> Result<Option<String>> {
    let mut found = None;
    for requirement in requirements {
        if engine.contains(&engine.states_where(&requirement.kept)?, state)? {
            continue;
        }
        match requirement.monitor {
            None => return Ok(Some(requirement.text.clone())),
            Some(_) => found = Some(conjunction(requirements)),
        }
    }
    Ok(found)
}

/// Returns the text of the conjunction of all requirements.
fn conjunction(requirements: &[Requirement]) -> String {
    match requirements {
        [only] => only.text.clone(),
        all => all.iter().map(|r| format!("({})", r.text)).collect::<Vec<_>>().join(" & "),
    }
}
