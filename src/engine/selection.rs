//! The choice between the two engines for a model.

use std::sync::Arc;

use super::any::AnyEngine;
use super::engine::{Algebra, Engine};
use super::explicit::ExplicitEngine;
use super::settings::{Settings, Storage};
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

/// The engine for a model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Selection {
    /// The engine.
    pub storage: Storage,
    /// The reason, such as "at most 3600 states"; `None` if the user has named the engine.
    pub reason: Option<String>,
    /// True if the explicit engine may be tried: the text does not show which engine is faster.
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

    /// Builds the engine for a question that lists the states anyway, such as one for a number: if
    /// the selection is open and the explicit engine needs few bytes, that one is selected.
    ///
    /// # Errors
    /// The errors of [`AnyEngine::new`].
    pub fn build(&mut self, program: &Arc<Program>, settings: Settings) -> Result<AnyEngine> {
        if self.is_open
            && let Some(engine) = ExplicitEngine::within(Arc::clone(program), settings.clone(), TRIED)?
        {
            let reason = Some(format!("{} states found", engine.count(&engine.all_states())?));
            *self = Selection { storage: Storage::Explicit, reason, is_open: false };
            return Ok(engine.into());
        }
        AnyEngine::new(Arc::clone(program), Settings { storage: self.storage, ..settings })
    }
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
