//! The regions of questions, as diagrams.

use std::sync::Arc;

use crate::answering::Answering;
use crate::listener::Listener;
use crate::questions::{Options, Questions};
use crate::race::started;
use meliora_base::error::Result;
use meliora_engine::regions::Which;
use meliora_engine::symbolic::StateSet;
use meliora_engine::{Settings, Storage, SymbolicEngine};
use meliora_model::Program;

/// The regions that were computed, by the requests that need them.
pub type KnownRegions<S> = Vec<(usize, Which, S)>;

/// The result for a property.
pub enum Part {
    /// The regions of the paths of a request.
    Paths(usize),
    /// The states that satisfy the condition.
    Satisfied(StateSet),
}

/// The regions of all properties.
pub struct Computed {
    /// The engine.
    pub engine: Arc<SymbolicEngine>,
    /// The properties by their places in the plan.
    pub parts: Vec<(usize, Part)>,
    /// The regions of the requests.
    pub regions: KnownRegions<StateSet>,
    /// The states from which no strategy keeps the requirements; `None` without requirements.
    pub unsafe_states: Option<StateSet>,
}

/// Answers all questions with one engine of diagrams, and returns the regions. All requests are about one program. Cost:
/// that of the answers.
///
/// # Errors
/// A limit is reached; a question of one.
pub fn compute(listener: &dyn Listener, options: &Options, asked: &Questions) -> Result<Computed> {
    let requests = Vec::from_iter(0..asked.plan.requests.len());
    let first = asked.plan.requests.first();
    let program = first.map_or(&asked.program, |first| first.asking.goal.program(&asked.program));
    let symbolic = |program: &Arc<Program>| {
        let settings = Settings { storage: Storage::Symbolic, ..options.settings.clone() };
        let build = || started(SymbolicEngine::in_some_order(Arc::clone(program), settings)?, program);
        listener.timed(("build", "build"), build)
    };
    let engine = symbolic(program)?;
    let answering = Answering::new(listener, options, asked, vec![None; requests.len()]);
    let mut kept = Some(Vec::new());
    let unsafe_states = answering.requests(&*engine, &requests, &mut kept)?;
    let mut parts = Vec::new();
    for request in requests {
        parts.extend(asked.plan.alone(request).map(|at| (at, Part::Paths(request))));
    }
    answering.satisfied(&engine, &symbolic, &mut |at, states| parts.push((at, Part::Satisfied(states))))?;
    Ok(Computed { engine, parts, regions: kept.unwrap_or_default(), unsafe_states })
}
