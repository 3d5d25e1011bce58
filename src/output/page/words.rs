//! Verdicts in words.

use super::super::Number;
use super::super::check::InitialReport;
use super::super::{ranks, text};
use super::Play;
use crate::planning::Kind;
use crate::planning::simulate::PlayEnd;

/// A count for a picture: `624`, `1.2 million`, `3.6e16`.
pub(super) fn short(n: &Number) -> String {
    let digits = n.to_string();
    match digits.len() {
        0..=6 => n.grouped(),
        7..=9 => format!("{:.1} million", real(n) / 1e6),
        _ => format!("{:.1e}", real(n)),
    }
}

/// The nearest floating-point number; for shares and lengths only.
pub(super) fn real(n: &Number) -> f64 {
    n.to_string().parse().unwrap_or(f64::INFINITY)
}

/// Which share of a whole, in per cent; 0 of nothing.
pub(super) fn percent(part: &Number, whole: &Number) -> f64 {
    let whole = real(whole);
    if whole > 0.0 { (100.0 * real(part) / whole).min(100.0) } else { 0.0 }
}

/// A share as text that tells a little from nothing.
pub(super) fn share(percent: f64) -> String {
    match percent {
        0.0 => "0 %".to_owned(),
        p if p < 0.1 => "< 0.1 %".to_owned(),
        p => format!("{p:.1} %"),
    }
}

/// One sentence for an initial state.
pub(super) fn verdict(initial: &InitialReport) -> String {
    ranks::verdict(initial.sasi_rank, initial.spi_rank)
}

/// How a play ended.
pub(super) fn outcome(play: &Play) -> String {
    let improved = play.trace.turns.iter().filter(|turn| turn.improves).count();
    let often = text::plural(improved, "improvement");
    let steps = text::plural(play.trace.turns.len(), "step");
    match (play.end, play.kind) {
        (PlayEnd::Kept, Kind::Sasi) => format!("It keeps what is guaranteed: {often}."),
        (PlayEnd::Kept, Kind::Spi) => {
            format!("It has the luck that makes everything possible happen: {often}.")
        }
        (PlayEnd::CutOff, _) => format!("It is cut off here after {steps}, with {often} so far; it goes on."),
        (PlayEnd::Failed, _) => format!(
            "Of the plays tried, none made all the improvements that are possible; this one has {often}."
        ),
    }
}

/// What is known to be sure: `sure of A, B`.
pub(super) fn sure(initial: &InitialReport) -> String {
    format!("sure of {}", text::names(&initial.most_preferred))
}

/// `Begin with N`, or none where there is nothing to begin.
pub(super) fn begin(actions: Option<&Vec<String>>) -> Option<String> {
    let actions = actions.filter(|a| !a.is_empty())?;
    Some(actions.join(", "))
}
