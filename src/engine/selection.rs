//! The choice between the two engines for a model.

use std::sync::Arc;

use super::any::AnyEngine;
use super::engine::{Algebra, Engine};
use super::explicit::{ExplicitEngine, Exploration};
use super::settings::{Count, Settings, Storage};
use super::symbolic;
use super::trial::Trial;
use meliora_model::error::{Error, Limit, Result};
use meliora_model::{ModelKind, Program};

/// The most valuations of a model for which the explicit engine is selected.
///
/// Measured: of 198 models of the PRISM benchmark suite and PRISM's tests, the explicit engine
/// answers all that have at most 4,096 valuations faster; the first for which it is slower has
/// 8,192. On grid worlds of the generator it is faster up to about 50,000.
const MOST_VALUATIONS: u64 = 1 << 12;

/// The most transitions that the commands of a model may have in all valuations for which the
/// explicit engine is selected.
const MOST_TRANSITIONS: u64 = 1 << 24;

/// The most states of a model whose diagrams are given up for the explicit engine.
const MOST_STATES: u64 = 1_000_000;

/// The same, where a question lists the states anyway. Its equations take longer than another exploration.
const MOST_STATES_TO_LIST: u64 = 8_000_000;

/// The most states for which the explicit engine is taken whatever the diagrams are, where a question
/// lists the states anyway.
///
/// Measured on properties of the Quantitative Verification Benchmark Set that ask for a number: up to
/// about this many, the explicit engine answers faster, up to 190 times.
const MOST_LISTED: u64 = 400_000;

/// The explicit engine replaces diagrams with fewer states for each of their nodes.
///
/// Measured on 50 models of the PRISM benchmark suite, PRISM's examples and tests and the
/// Quantitative Verification Benchmark Set, exploration by diagrams included: below this bound the
/// explicit engine saves up to 5 s in `mdp` models and costs up to 0.2 s; above it costs up to 0.6 s. Half of it
/// counts for more states than [`MOST_STATES`]: to explore them once more takes long.
const STATES_PER_NODE: u64 = 80;

/// The same, where recursions over parts are fast, as in grid worlds.
const STATES_PER_NODE_OF_FEW_PARTS: u64 = 20;

/// The most states of a game whose diagrams are given up for the explicit engine, where levels are asked for.
const MOST_STATES_OF_GAMES: u64 = 4_000_000;

/// The explicit engine replaces the diagrams of such a game with fewer states for each of their nodes.
///
/// Measured on grid worlds and pursuits against an opponent: with 10 to 40 states for each node, `check` takes 0.4 to
/// 1.2 times as long, diagrams included; from 78 states on, the explicit engine alone takes 2.5 to 500 times as long. If
/// the opponent depends on all of our variables, the steps of diagrams are about as many as the transitions, and each
/// takes ten times as long.
const STATES_PER_NODE_OF_GAMES: u64 = 48;

/// The engine for a model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Selection {
    /// The engine.
    pub storage: Storage,
    /// The reason, such as "at most 3600 states"; `None` if the user has named the engine.
    pub reason: Option<String>,
    /// True if the states may still select the explicit engine: the text does not show which engine
    /// is faster.
    pub is_open: bool,
}

impl Selection {
    /// Selects the explicit engine for programs that are so small that it is known to be faster,
    /// else the symbolic engine; the largest of the programs decides.
    ///
    /// Both bounds are read off the text: ∏ |range of x| valuations over the variables x, and for
    /// each of them Σ ∏ (branches of the commands of a module) transitions over the
    /// synchronisations and the modules that take part. No state is explored.
    pub fn of<'a>(programs: impl IntoIterator<Item = &'a Program>) -> Self {
        let (mut most, mut dense) = (Some(1), false);
        for program in programs {
            let valuations = valuations(program);
            let transitions = valuations.zip(branches(program)).and_then(|(v, b)| v.checked_mul(b));
            most = most.zip(valuations).map(|(most, v)| most.max(v));
            dense |= transitions.is_none_or(|n| n > MOST_TRANSITIONS);
        }
        let small = most.filter(|&n| n <= MOST_VALUATIONS);
        let (storage, reason) = match small {
            Some(n) if !dense => (Storage::Explicit, format!("at most {n} states")),
            Some(_) => (Storage::Symbolic, format!("over {MOST_TRANSITIONS} transitions possible")),
            None => (Storage::Symbolic, format!("over {MOST_VALUATIONS} states possible")),
        };
        Selection { storage, reason: Some(reason), is_open: storage == Storage::Symbolic }
    }

    /// Builds the engine for some questions and updates the selection. As long as it is open, the
    /// states decide: both engines explore them in turns (`Trial`).
    ///
    /// - If the explicit engine is the first to know all states, it is selected. It begins if a question
    ///   lists the states anyway, such as one for a number, and takes most turns then.
    /// - If it is the symbolic engine, the explicit one is selected if there are few states, also for
    ///   each node of the diagrams: then these hardly share anything, and long fixpoints cost more than
    ///   it takes to store the states.
    ///
    /// # Errors
    /// The errors of [`AnyEngine::new`].
    pub fn build(
        &mut self,
        program: &Arc<Program>,
        settings: Settings,
        lists_states: bool,
    ) -> Result<AnyEngine> {
        if !self.is_open {
            return AnyEngine::new(Arc::clone(program), Settings { storage: self.storage, ..settings });
        }
        let trial = Arc::new(Trial::new(program, &settings, lists_states));
        if let Some(all) = trial.take_all() {
            return self.found_by(&trial, *all?, settings.memory);
        }
        let symbolic = symbolic::Explored::new(Arc::clone(program), trial.settings(&settings));
        if let Some(all) = trial.take_all() {
            return self.found_by(&trial, *all?, settings.memory);
        }
        let (symbolic, rest) = (symbolic?, trial.end());
        match sparse(program.kind, &symbolic, lists_states)? {
            Some(reason) => self.replace(symbolic, reason, rest, (program, settings)),
            None => Ok(symbolic.engine()?.into()),
        }
    }

    /// Builds the engine for the levels of preferences and updates the selection. As long as it is open,
    /// the diagrams of a game against an opponent decide: levels need many fixpoints, so it can pay off to explore
    /// the states again.
    ///
    /// # Errors
    /// The errors of [`AnyEngine::new`].
    pub fn build_for_levels(&mut self, program: &Arc<Program>, settings: Settings) -> Result<AnyEngine> {
        let has_opponent =
            program.players.as_ref().is_some_and(|players| players.coalition().contains(&false));
        if !self.is_open || !has_opponent {
            return AnyEngine::new(Arc::clone(program), Settings { storage: self.storage, ..settings });
        }
        let symbolic = symbolic::Explored::new(Arc::clone(program), settings.clone())?;
        match crowded(&symbolic)? {
            Some(reason) => self.replace(symbolic, reason, None, (program, settings)),
            None => Ok(symbolic.engine()?.into()),
        }
    }

    /// Takes the explicit engine, which was the first to know all states.
    fn found_by(&mut self, trial: &Trial, mut all: Exploration, memory: u64) -> Result<AnyEngine> {
        all.set_memory(memory);
        let engine = ExplicitEngine::explored(all)?;
        let states = engine.count(&engine.all_states())?;
        let first = if trial.is_alone() { "" } else { ", before diagrams found them" };
        self.take(format!("{states} states found{first}"));
        Ok(engine.into())
    }

    /// Explores the rest of a trial by the explicit engine, and takes it for a reason; keeps the
    /// symbolic engine if the memory does not suffice for both.
    fn replace(
        &mut self,
        symbolic: symbolic::Explored,
        reason: String,
        rest: Option<Box<Exploration>>,
        (program, settings): (&Arc<Program>, Settings),
    ) -> Result<AnyEngine> {
        let memory = settings.memory.saturating_sub(symbolic.bytes());
        let states = usize::try_from(symbolic.count()?).unwrap_or(0);
        let exploration = match rest {
            Some(mut exploration) => {
                exploration.set_memory(memory);
                Ok(*exploration)
            }
            None => {
                let settings = Settings { memory, storage: Storage::Explicit, ..settings.clone() };
                Exploration::new(Arc::clone(program), settings)
            }
        };
        let explored = exploration.and_then(|mut exploration| {
            if !exploration.has_begun() {
                // Diagrams know the initial states. The search for them may take much longer.
                exploration.begin_with(&symbolic.beginnings()?)?;
            }
            exploration.expect(states);
            ExplicitEngine::explored(exploration)
        });
        match explored {
            Ok(mut engine) => {
                engine.set_memory(settings.memory);
                self.take(reason);
                Ok(engine.into())
            }
            Err(Error::Limit(Limit::Memory { .. } | Limit::Size { .. })) => Ok(symbolic.engine()?.into()),
            Err(error) => Err(error),
        }
    }

    /// Selects the explicit engine.
    fn take(&mut self, reason: String) {
        *self = Selection { storage: Storage::Explicit, reason: Some(reason), is_open: false };
    }
}

/// Returns the reason why the explicit engine suits a model better than these diagrams, if it does.
/// It does not for the regions of a Markov chain, which are fast, as they need no search for lost
/// states.
fn sparse(kind: ModelKind, explored: &symbolic::Explored, lists_states: bool) -> Result<Option<String>> {
    let states = explored.count()?;
    let bound = if lists_states { MOST_STATES_TO_LIST } else { MOST_STATES };
    if (kind == ModelKind::Dtmc && !lists_states) || states > Count::from(bound) {
        return Ok(None);
    }
    if lists_states && states <= Count::from(MOST_LISTED) {
        return Ok(Some(format!("{states} states found")));
    }
    let nodes = explored.nodes()?;
    let usual = if explored.has_few_parts()? { STATES_PER_NODE_OF_FEW_PARTS } else { STATES_PER_NODE };
    let most = if states > Count::from(MOST_STATES) { usual / 2 } else { usual };
    let few = states < Count::from(most) * nodes;
    Ok(few.then(|| fewer(&states, most)))
}

/// Returns the reason why the explicit engine suits the levels of a game better than these diagrams, if it does.
fn crowded(explored: &symbolic::Explored) -> Result<Option<String>> {
    let states = explored.count()?;
    let most = STATES_PER_NODE_OF_GAMES;
    let few = states <= Count::from(MOST_STATES_OF_GAMES) && states < Count::from(most) * explored.nodes()?;
    Ok(few.then(|| fewer(&states, most)))
}

fn fewer(states: &Count, most: u64) -> String {
    format!("{states} states found, fewer than {most} for each node of the diagrams")
}

/// Returns ∏ |range of x| over the variables x, or `None` if it passes 2^64.
fn valuations(program: &Program) -> Option<u64> {
    let size = |low: i64, high: i64| (high.wrapping_sub(low) as u64).checked_add(1);
    program.variables.iter().try_fold(1_u64, |n, v| n.checked_mul(size(v.low, v.high)?))
}

/// Returns the most transitions that a state can have, or `None` if this passes 2^64.
fn branches(program: &Program) -> Option<u64> {
    program.synchronisations.iter().try_fold(0_u64, |sum, synchronisation| {
        let product = synchronisation.factors.iter().try_fold(1_u64, |product, factor| {
            let branches = factor.iter().map(|c| program.commands[c.0 as usize].branches.len() as u64).sum();
            product.checked_mul(branches)
        })?;
        sum.checked_add(product)
    })
}
