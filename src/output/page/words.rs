//! Verdicts in words.

use super::super::Number;
use super::super::check::{InitialReport, Rank};
use super::super::text;
use super::Play;
use crate::planning;
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

/// `2`, `2+`, `∞`
pub(super) fn mark(rank: planning::Rank) -> String {
    match rank {
        planning::Rank::Finite(k) => k.to_string(),
        planning::Rank::AtLeast(k) => format!("{k}+"),
        planning::Rank::Unbounded => "∞".to_owned(),
    }
}

/// The same for a rank of a report.
pub(super) fn rank_mark(rank: Option<Rank>) -> String {
    match rank {
        Some(Rank::Exactly(k)) => k.to_string(),
        Some(Rank::AtLeast(k)) => format!("{k}+"),
        Some(Rank::Unbounded) => "∞".to_owned(),
        None => "?".to_owned(),
    }
}

/// `2 improvements are guaranteed`, `any number of improvements is possible`
pub(super) fn claim(rank: Option<Rank>, how: &str) -> String {
    match rank {
        None => format!("it is not known how many improvements are {how}"),
        Some(Rank::Exactly(0)) => format!("no improvement is {how}"),
        Some(Rank::Exactly(1)) => format!("one improvement is {how}"),
        Some(Rank::Exactly(k)) => format!("{k} improvements are {how}"),
        Some(Rank::AtLeast(k)) => format!("{k} or more improvements are {how}"),
        Some(Rank::Unbounded) => format!("any number of improvements is {how}"),
    }
}

/// One sentence for an initial state.
pub(super) fn verdict(initial: &InitialReport) -> String {
    let guaranteed = claim(initial.sasi_rank, "guaranteed");
    let possible = claim(initial.spi_rank, "possible");
    let joined = if initial.sasi_rank == initial.spi_rank {
        format!("{guaranteed}, and no more than that {}", {
            match initial.sasi_rank {
                Some(Rank::Exactly(0 | 1)) => "is possible",
                _ => "are possible",
            }
        })
    } else {
        format!("{guaranteed}, {possible}")
    };
    let joined = match initial.sasi_rank {
        Some(Rank::Exactly(0)) if initial.spi_rank == initial.sasi_rank => {
            "no improvement is possible".to_owned()
        }
        Some(Rank::Unbounded) if initial.spi_rank == initial.sasi_rank => guaranteed,
        _ => joined,
    };
    let mut letters = joined.chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    format!("{first}{}.", letters.as_str())
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

#[cfg(test)]
mod tests {
    use super::*;

    fn initial(sasi: Rank, spi: Rank) -> InitialReport {
        InitialReport {
            state: serde_json::Map::new(),
            most_preferred: Vec::new(),
            sasi_rank: Some(sasi),
            spi_rank: Some(spi),
            sasi_actions: None,
            spi_actions: None,
        }
    }

    #[test]
    fn verdicts_are_sentences() {
        use Rank::{Exactly, Unbounded};
        for (sasi, spi, text) in [
            (Exactly(2), Unbounded, "2 improvements are guaranteed, any number of improvements is possible."),
            (Exactly(0), Exactly(1), "No improvement is guaranteed, one improvement is possible."),
            (Exactly(0), Exactly(0), "No improvement is possible."),
            (Exactly(2), Exactly(2), "2 improvements are guaranteed, and no more than that are possible."),
            (Unbounded, Unbounded, "Any number of improvements is guaranteed."),
        ] {
            assert_eq!(verdict(&initial(sasi, spi)), text);
        }
    }
}
