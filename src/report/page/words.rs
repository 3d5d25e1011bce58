//! Texts for verdicts and counts.

use super::super::ranks;
use super::super::text::{self, grouped};
use super::ShownRun;
use super::heat::digits;
use meliora_engine::Count;
use meliora_planning::StrategyKind;
use meliora_planning::result::Prospects;
use meliora_planning::tally::RunEnd;

/// Formats a count for a picture: `624`, `1.2 million`, `3.6e16`.
pub(super) fn short(n: &Count) -> String {
    let digits = n.to_string();
    match digits.len() {
        0..=6 => grouped(n),
        7..=9 => format!("{:.1} million", real(n) / 1e6),
        _ => format!("{:.1e}", real(n)),
    }
}

/// Returns the nearest floating-point number; for shares and lengths only.
pub(super) fn real(n: &Count) -> f64 {
    n.to_string().parse().unwrap_or(f64::INFINITY)
}

/// Returns the share of a whole in percent; 0 if the whole is 0.
pub(super) fn percent(part: &Count, whole: &Count) -> f64 {
    let whole = real(whole);
    if whole > 0.0 { (100.0 * real(part) / whole).min(100.0) } else { 0.0 }
}

/// Formats a share, so that small shares differ from 0.
pub(super) fn share(percent: f64) -> String {
    match percent {
        0.0 => "0 %".to_owned(),
        p if p < 0.1 => "< 0.1 %".to_owned(),
        p => format!("{p:.1} %"),
    }
}

/// Returns `1 improvement`, `2 improvements`.
pub(super) fn improvements(k: usize) -> String {
    text::plural(k, "improvement")
}

/// Returns `1 step`, `11.4 steps`.
pub(super) fn steps(x: f64) -> String {
    let number = digits(x);
    if number == "1" { "1 step".to_owned() } else { format!("{number} steps") }
}

/// Returns `first`, `second`, …, `11th`, …, `21st`.
pub(super) fn ordinal(k: usize) -> String {
    let words =
        ["first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth", "tenth"];
    let word = k.checked_sub(1).and_then(|index| words.get(index));
    let suffix = match (k % 10, k % 100) {
        (1, except) if except != 11 => "st",
        (2, except) if except != 12 => "nd",
        (3, except) if except != 13 => "rd",
        _ => "th",
    };
    word.map_or_else(|| format!("{k}{suffix}"), |&word| word.to_owned())
}

/// Joins names: `nothing`, `A`, `A and B`, `A, B and C`.
pub(super) fn all_of(names: &[String]) -> String {
    match names {
        [] => "nothing".to_owned(),
        [name] => name.clone(),
        [names @ .., last] => format!("{} and {last}", names.join(", ")),
    }
}

/// Returns one sentence for an initial state.
pub(super) fn verdict(initial: &Prospects) -> String {
    if initial.escape.is_some() {
        return "No strategy keeps the requirements.".to_owned();
    }
    ranks::verdict(initial.sasi.as_ref().map(|p| p.rank), initial.spi.as_ref().map(|p| p.rank))
}

/// Describes the end of a run.
pub(super) fn outcome(run: &ShownRun) -> String {
    let improved = run.trace.turns.iter().filter(|turn| turn.improves).count();
    let often = text::plural(improved, "improvement");
    let steps = text::plural(run.trace.turns.len(), "step");
    let last = run.trace.turns.last().map_or(run.trace.achieved.as_slice(), |turn| &turn.achieved);
    match (run.end, run.kind) {
        (RunEnd::CutOff, _) => format!("The run is cut off after {steps}, with {often} so far."),
        (RunEnd::Kept, StrategyKind::Plan | StrategyKind::Achieve) if !last.is_empty() => {
            format!("The run makes {often}, and achieves {} after {steps}.", all_of(last))
        }
        (RunEnd::Kept, StrategyKind::Spi) => {
            format!("A lucky run: every possible improvement happens ({often}).")
        }
        (RunEnd::Kept, _) if improved == 0 => {
            format!("No improvement is guaranteed; the run keeps the prospects for {steps}.")
        }
        (RunEnd::Kept, _) => format!("All guaranteed improvements happen: {often}."),
        (RunEnd::Failed, _) => {
            format!("No simulated run made all possible improvements; this one has {often}.")
        }
    }
}

/// Formats the most preferred objectives: `most preferred: A or B`; or `unsafe`.
pub(super) fn preferred(initial: &Prospects) -> String {
    match initial.escape {
        Some(_) => "unsafe".to_owned(),
        None => format!("most preferred: {}", text::either(&initial.most_preferred)),
    }
}

#[cfg(test)]
mod tests {
    use super::ordinal;

    #[test]
    fn ordinals_are_words_up_to_ten_and_then_numbers() {
        let found = [1, 10, 11, 12, 13, 21, 22, 23, 24, 101, 111].map(ordinal).join(" ");
        assert_eq!(found, "first tenth 11th 12th 13th 21st 22nd 23rd 24th 101st 111th");
    }
}
