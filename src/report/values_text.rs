//! The text of the report of `meliora values`.

use std::fmt::Write;

use super::envelope::{Findings, Phase};
use super::text::{Grid, either, goal, names, plural, state_heading};
use super::values::{ValuesFindings, ValuesReport};
use super::{Style, ranks};
use meliora_planning::Safety;
use meliora_quantities::Steps;
use meliora_quantities::state_values::{Bound, LevelValues, StateValues};

/// Maximum number of characters of a fraction that is shown in full outside of tables.
const LONGEST: usize = 240;

/// Maximum number of columns of a success curve.
const CURVE: usize = 10;

/// Probabilities of success curves above this number are shown as 1.
const ALMOST: f64 = 1.0 - 1e-12;

impl Findings for ValuesFindings {
    const SCHEMA: &str = "meliora.values/1";
    const HEADER: (&[&str], &[&str]) =
        (&["model", "scope", "safety", "empty"], &["engine", "engine_reason", "history"]);
    const PHASES: &[Phase] = &[
        Phase::PARSE_STATES,
        Phase::BUILD,
        Phase::LEVELS,
        Phase::new("explore", "Finding the states that the values depend on"),
        Phase::new("solve", "Computing the values"),
    ];

    fn body(report: &ValuesReport, style: Style) -> String {
        let mut text = report.header.sizes(report.counts.as_ref(), style);
        if report.header.safety.is_some_and(Safety::drops_successors) && !report.states.is_empty() {
            text.push_str("\nProbabilities are those of improving before any step weakens.\n");
        }
        text.extend(report.states.iter().map(|state| one(state, &report.reward, style)));
        if report.more > 0 {
            let _ = writeln!(text, "\nThe file has {}.", plural(report.more, "more state"));
        }
        text
    }
}

fn one(state: &StateValues, reward: &str, style: Style) -> String {
    let mut text = format!("\n{}", state_heading("State", &state.state, style));
    if state.is_unsafe {
        let _ = writeln!(text, "  {}", style.bad("Unsafe: no strategy keeps the requirements"));
        return text;
    }
    let _ = writeln!(text, "  Most preferred: {}", either(&state.most_preferred));
    let _ = writeln!(
        text,
        "  Improvements: {} certain, {} possible, {} expected at most",
        ranks::cell(state.sasi_rank),
        ranks::cell(state.spi_rank),
        state.number.as_ref().map_or_else(|| "?".to_owned(), precise)
    );
    for level in state.levels.iter().filter(|level| level.probability.upper > 0.0) {
        text.push_str(&table(level, reward, style));
    }
    text + &by_goal(state, style)
}

/// Lists what the first improvement gains.
fn by_goal(state: &StateValues, style: Style) -> String {
    let Some(gains) = state.by_goal.as_ref().filter(|gains| !gains.is_empty()) else { return String::new() };
    let mut grid = Grid::new(&["first improvement gains", "probability"]);
    for gain in gains {
        grid.row(vec![names(&gain.gained), number(&gain.probability)]);
    }
    format!(
        "\n  Over {}, with the strategy that makes one improvement most likely:\n",
        goal(&state.most_preferred)
    ) + &grid.text(style)
}

fn table(level: &LevelValues, reward: &str, style: Style) -> String {
    let mut text = format!(
        "\n  {}: probability {}",
        plural(level.improvements, "improvement"),
        precise(&level.probability)
    );
    if let Some(cost) = &level.cost {
        let _ = write!(text, ", {} expected", unit(precise(cost), reward));
    }
    text.push('\n');
    let mut grid = Grid::new(&["action", "probability", reward]);
    for action in &level.actions {
        let cost = action.cost.as_ref().map_or_else(|| "-".to_owned(), number);
        grid.row(vec![action.action.clone(), number(&action.probability), cost]);
    }
    if !level.actions.is_empty() {
        text.push_str(&grid.text(style));
    }
    if let Some(curve) = &level.within {
        text.push_str(&success(curve));
    }
    text
}

/// Renders some points of a success curve, the last one among them.
fn success(curve: &[f64]) -> String {
    let last = curve.len().saturating_sub(1);
    let every = last.div_ceil(CURVE).max(1);
    let mut text = String::new();
    for n in (1..=last).filter(|n| n.is_multiple_of(every) || *n == last) {
        // The lower bounds of certain success are below 1 by rounding.
        let x = if curve[n] > ALMOST { 1.0 } else { curve[n] };
        let _ = writeln!(text, "  within {}: {}", plural(n, "step"), digits(x));
    }
    text
}

/// Formats a number in full if it is exact and fits some lines; a longer one is in the JSON report.
fn precise(bound: &Bound) -> String {
    match &bound.exact {
        Some(exact) if exact.len() <= LONGEST => exact.clone(),
        Some(exact) => format!("{} (a fraction of {} characters)", number(bound), exact.len()),
        None => number(bound),
    }
}

/// Formats bounds: a fraction, one number if the bounds agree in six digits, or both bounds.
pub(super) fn number(bound: &Bound) -> String {
    if let Some(exact) = &bound.exact
        && exact.len() <= 24
    {
        return exact.clone();
    }
    let [lower, upper] = [bound.lower, bound.upper].map(digits);
    // Bounds on both sides of a rounding limit look different although they are close.
    if lower == upper || bound.width() <= 1e-7 { upper } else { format!("{lower} to {upper}") }
}

/// Formats a cost with the name of its structure: `2 steps`, `1 step`.
pub(super) fn amount(cost: &Bound, name: &str) -> String {
    unit(number(cost), name)
}

fn unit(number: String, name: &str) -> String {
    match number {
        one if one == "1" && name == Steps::NAME => "1 step".to_owned(),
        text => format!("{text} {name}"),
    }
}

/// Formats a number with at most six significant digits. A probability below 1 is never shown as 1.
pub(super) fn digits(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return x.to_string();
    }
    if !(1e-4..1e9).contains(&x) {
        return format!("{x:.5e}");
    }
    if x < 1.0 && x > 0.999_999 {
        return format!("1 - {:.2e}", 1.0 - x);
    }
    let decimals = (5 - x.log10().floor() as i32).clamp(0, 9) as usize;
    let text = format!("{x:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_six_digits_and_one_is_exact() {
        for (x, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (1.0 / 3.0, "0.333333"),
            (12.5, "12.5"),
            (1e-12, "1.00000e-12"),
            (1.0 - 1e-12, "1 - 1.00e-12"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(digits(x), text);
        }
    }

    #[test]
    fn an_exact_number_is_shown_in_full_unless_it_is_very_long() {
        let bound = |digits: usize| {
            let exact = format!("1/{}3", "3".repeat(digits));
            Bound { lower: 1.0 / 3.0, upper: 1.0 / 3.0, exact: Some(exact) }
        };
        assert_eq!(precise(&bound(100)), bound(100).exact.unwrap());
        assert_eq!(precise(&bound(1000)), "0.333333 (a fraction of 1003 characters)");
        assert_eq!(number(&bound(100)), "0.333333");
    }

    #[test]
    fn bounds_that_differ_are_both_shown() {
        let bound = |lower, upper| Bound { lower, upper, exact: None };
        assert_eq!(number(&bound(0.25, 0.25)), "0.25");
        assert_eq!(number(&bound(0.25, 0.5)), "0.25 to 0.5");
    }
}
