//! Checks of the bounds of quantities in `values.csv`.
//!
//! Each bound is confirmed by one step, in fractions; see [`super::bellman`] and `docs/dumps.md`. The
//! levels say where a probability is 0 or 1. Under `transition` they do not say where it is 1: there,
//! lower bounds of 1 are confirmed like others, and all other upper bounds must be less than 1.
//!
//! This module looks up no set of the dump. It uses the levels that were proved before.

use super::arena::Arena;
use super::bellman::{self, Costs};
use super::checker::Checker;
use super::condition::Condition;
use super::error::{CheckError, CheckResult};
use super::levels::Levels;
use super::table::Table;
use meliora_model::region::RegionName;

/// The name of the cost that is 1 per step.
const STEPS: &str = "steps";

/// Checks all bounds of a dump; nothing if it has none. The levels are those of SASI and of SPI.
pub(super) fn check(checker: &mut Checker<'_>, arenas: &[Arena], known: &[Levels; 2]) -> CheckResult {
    let (file, rows) = match (&checker.manifest.values, checker.values) {
        (None, None) => return Ok(()),
        (Some(file), Some(rows)) => (file, rows),
        _ => return Err(CheckError::violated(Condition::ValuesNamed, None)),
    };
    if checker.manifest.max_level.is_some_and(|max| file.levels > max) {
        return Err(CheckError::violated(Condition::ValueLevels, None));
    }
    let program = std::sync::Arc::clone(checker.engine.program());
    let costs = match program.reward_structure(Some(&file.reward)) {
        _ if file.reward == STEPS => Costs::Steps,
        Some(at) => Costs::Rewards(&program.rewards[at]),
        None => {
            let condition = Condition::RewardStructure { name: file.reward.clone() };
            return Err(CheckError::violated(condition, None));
        }
    };
    let table = Table::new(checker, arenas, known, file.levels, rows)?;
    table.complete(checker)?;
    for entry in &table.entries {
        entry.consistent(&table)?;
    }
    bellman::check(checker, &table, &program, &costs)?;
    for k in 1..=file.levels {
        checker.passed(&RegionName::Other(format!("P_{k}")));
        checker.passed(&RegionName::Other(format!("C_{k}")));
    }
    Ok(())
}
