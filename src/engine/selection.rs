//! The choice between the two engines for a model.

use std::sync::Arc;

use super::any::AnyEngine;
use super::engine::{Algebra, Engine};
use super::explicit::ExplicitEngine;
use super::settings::{Count, Settings, Storage};
use super::symbolic::SymbolicEngine;
use meliora_model::Program;
use meliora_model::error::Result;

/// The most valuations of a model for which the explicit engine is selected.
///
/// Measured: of 198 models of the PRISM benchmark suite and PRISM's tests, the explicit engine
/// answers all that have at most 4,096 valuations faster; the first for which it is slower has
/// 8,192. On grid worlds of the generator it is faster up to about 50,000.
const MOST_VALUATIONS: u64 = 1 << 12;

/// The most transitions that the commands of a model may have in all valuations for which the
/// explicit engine is selected.
const MOST_TRANSITIONS: u64 = 1 << 24;

/// The most bytes of the explicit engine for which it is taken after trying it, where a question
/// lists the states anyway.
///
/// Measured on properties of the Quantitative Verification Benchmark Set that ask for a number: up to
/// this size, about 300,000 states, the explicit engine answers faster, up to 190 times; a trial in
/// vain takes at most half a second.
const TRIED: u64 = 32 << 20;

/// The most states of a model whose diagrams are given up for the explicit engine.
const MOST_STATES: u64 = 1_000_000;

/// The explicit engine replaces diagrams with fewer states for each of their nodes.
///
/// Measured on 50 models of the PRISM benchmark suite, PRISM's examples and tests and the
/// Quantitative Verification Benchmark Set, exploration by diagrams included: below this bound the
/// explicit engine saves up to 5 s in `mdp` models and costs up to 0.2 s; above it costs up to 0.6 s.
const STATES_PER_NODE: u64 = 80;

/// The same, where recursions over parts are fast, as in grid worlds.
const STATES_PER_NODE_OF_FEW_PARTS: u64 = 20;

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
    /// states decide:
    ///
    /// - If a question lists the states anyway, such as one for a number, the explicit engine is
    ///   selected if it needs few bytes.
    /// - Otherwise the symbolic engine explores the states. The explicit engine is selected if there
    ///   are few of them, also for each node of the diagrams: then these hardly share anything, and
    ///   long fixpoints cost more than it takes to store the states.
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
        let explicit = |most| ExplicitEngine::within(Arc::clone(program), settings.clone(), most);
        if lists_states && let Some(engine) = explicit(TRIED)? {
            self.take(format!("{} states found", engine.count(&engine.all_states())?));
            return Ok(engine.into());
        }
        let symbolic = SymbolicEngine::new(Arc::clone(program), settings.clone())?;
        if !lists_states
            && let Some(reason) = sparse(&symbolic)?
            && let Some(engine) = explicit(settings.memory.saturating_sub(symbolic.usage().bytes))?
        {
            self.take(reason);
            return Ok(engine.into());
        }
        Ok(symbolic.into())
    }

    /// Selects the explicit engine.
    fn take(&mut self, reason: String) {
        *self = Selection { storage: Storage::Explicit, reason: Some(reason), is_open: false };
    }
}

/// Returns the reason why the explicit engine suits a model better than these diagrams, if it does.
/// It does not for a Markov chain, whose regions are fast, as they need no search for lost states.
fn sparse(engine: &SymbolicEngine) -> Result<Option<String>> {
    let states = engine.count(&engine.all_states())?;
    if engine.is_markov_chain() || states > Count::from(MOST_STATES) {
        return Ok(None);
    }
    let sizes = engine.sizes()?;
    let most = if engine.has_few_parts()? { STATES_PER_NODE_OF_FEW_PARTS } else { STATES_PER_NODE };
    let few = states < Count::from(most) * (sizes.states + sizes.transition);
    Ok(few.then(|| format!("{states} states found, fewer than {most} for each node of the diagrams")))
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
