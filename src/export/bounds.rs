//! Bounds of quantities for dumps, and for models state by state.

use meliora_base::error::{Error, Limit, Result};
use meliora_dump::Dump;
use meliora_dump::manifest::{VALUES, ValuesFile};
use meliora_engine::symbolic::SymbolicEngine;
use meliora_engine::{Count, Engine};
use meliora_model::Program;
use meliora_planning::Analysis;
use meliora_quantities::confirmed::widest;
use meliora_quantities::{Cost, ValueOptions, Values};

use super::regions::class_name;

/// The quantities of an export.
pub struct Wanted<'a> {
    /// The greatest number of improvements; at least 1.
    pub levels: usize,
    /// The name of the cost of a step.
    pub reward: &'a str,
    /// The cost of a step.
    pub costs: &'a dyn Cost,
    /// The maximum number of states.
    pub limit: usize,
}

/// Computes the quantities of all states from which an improvement is possible. Cost: see
/// [`Values::compute`].
///
/// # Errors
/// There are too many states, a limit is reached, or no levels are wanted.
pub fn compute<E: Engine>(analysis: &Analysis<E>, program: &Program, wanted: &Wanted<'_>) -> Result<Values> {
    let engine = analysis.engine();
    if wanted.levels == 0 {
        return Err(Error::Usage("no improvement is possible, so there are no values".to_owned()));
    }
    let possible = analysis.levels(meliora_planning::Kind::Spi).found.first();
    let possible = possible.map_or_else(|| engine.no_states(), |level| level.states.clone());
    let count = engine.count(&possible)?;
    if count > Count::from(wanted.limit) {
        let what = format!(
            "`--values` would write the values of {count} states; a larger `--limit` than {} allows it",
            wanted.limit
        );
        return Err(Limit::Size { what }.into());
    }
    let starts = engine.list_states(&possible, wanted.limit)?;
    let options = ValueOptions { levels: wanted.levels, exact: false, within: None };
    Values::compute(options, analysis, program, &starts, wanted.costs)
}

/// Returns the number of levels whose bounds can be proved, at most `levels`. In a game with reference classes, a state
/// that counts for no further level may lead to others that would win one against this class, if the opponent let us go
/// there: the levels do not show where P_k is 0.
fn proved<E: Engine>(analysis: &Analysis<E>, levels: usize) -> usize {
    let spi = analysis.levels(meliora_planning::Kind::Spi);
    let is_open = analysis.engine().is_game() && analysis.options().safety.has_reference();
    if is_open && spi.unbounded().is_none() { levels.min(spi.found.len()) } else { levels }
}

/// Adds the bounds of P_k and C_k to a dump, for all states from which an improvement is possible. In a game with reference
/// classes, there are at most as many levels as were found.
/// Returns the greatest width of a bound. Cost: see [`Values::compute`] and [`Values::confirmed`].
///
/// # Errors
/// There are too many states, a limit is reached, or no levels are wanted.
pub fn add(dump: &mut Dump, analysis: &Analysis<SymbolicEngine>, wanted: &Wanted<'_>) -> Result<f64> {
    let engine = analysis.engine();
    let wanted = &Wanted { levels: proved(analysis, wanted.levels), ..*wanted };
    let values = compute(analysis, engine.program(), wanted)?;
    let shows_ones = analysis.options().safety.drops_successors();
    let confirmed = values.confirmed(engine, shows_ones)?;
    let arena = |number: usize| {
        let reference = analysis.improvement().and_then(|i| i.arenas.get(number)?.reference);
        let class = reference.and_then(|class| analysis.classes()?.list.get(class));
        class.map_or_else(String::new, |class| class_name(analysis.preferences(), &class.most_preferred))
    };
    let rows = values.rows(&confirmed, shows_ones, &arena)?;
    let width = widest(&rows);
    dump.manifest.values = Some(ValuesFile {
        path: VALUES.to_owned(),
        sha256: String::new(),
        levels: wanted.levels,
        reward: wanted.reward.to_owned(),
        rows: rows.len(),
    });
    dump.values = Some(rows);
    Ok(width)
}
