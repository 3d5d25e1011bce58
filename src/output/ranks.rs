//! What a rank says and promises, in words.

use super::text;
use crate::planning::{Kind, Rank};

/// `2`, `2+`, `∞`; `?` where it is not known.
pub(super) fn mark(rank: Option<Rank>) -> String {
    match rank {
        None => "?".to_owned(),
        Some(Rank::Finite(k)) => k.to_string(),
        Some(Rank::AtLeast(k)) => format!("{k}+"),
        Some(Rank::Unbounded) => "∞".to_owned(),
    }
}

/// A rank in a table.
pub(super) fn cell(rank: Rank) -> String {
    match rank {
        Rank::Finite(k) => k.to_string(),
        Rank::AtLeast(k) => format!("{k} or more"),
        Rank::Unbounded => "unbounded".to_owned(),
    }
}

/// `once`, `2 times`, …
pub(super) fn times(rank: Rank) -> String {
    match rank {
        Rank::Finite(0) => "not".to_owned(),
        Rank::Finite(1) => "once".to_owned(),
        Rank::Finite(k) => format!("{k} times"),
        Rank::AtLeast(k) => format!("{k} times or more"),
        Rank::Unbounded => "any number of times".to_owned(),
    }
}

/// `1 improvement`, `2 improvements`, `any number of improvements`.
pub(super) fn improvements(rank: Rank) -> String {
    match rank {
        Rank::Finite(k) => text::plural(k, "improvement"),
        Rank::AtLeast(k) => format!("{} or more", text::plural(k, "improvement")),
        Rank::Unbounded => "any number of improvements".to_owned(),
    }
}

/// Whether a level is about one improvement.
pub(super) fn is_one(rank: Rank) -> bool {
    matches!(rank, Rank::Finite(1) | Rank::AtLeast(1))
}

/// `cannot surely improve`, `surely improves 2 times`
pub(super) fn ability(rank: Rank, how: &str) -> String {
    match rank {
        Rank::Finite(0) => format!("cannot {how} improve"),
        Rank::AtLeast(_) => format!("{how} improves {} (the search ends there)", times(rank)),
        _ => format!("{how} improves {}", times(rank)),
    }
}

/// `2 improvements are guaranteed`, `any number of improvements is possible`
pub(super) fn claim(rank: Option<Rank>, how: &str) -> String {
    match rank {
        None => format!("it is not known how many improvements are {how}"),
        Some(Rank::Finite(0)) => format!("no improvement is {how}"),
        Some(Rank::Finite(1)) => format!("one improvement is {how}"),
        Some(Rank::Finite(k)) => format!("{k} improvements are {how}"),
        Some(Rank::AtLeast(k)) => format!("{k} or more improvements are {how}"),
        Some(Rank::Unbounded) => format!("any number of improvements is {how}"),
    }
}

/// What both ranks of a state say, in a sentence or two.
pub(super) fn both(sasi: Rank, spi: Rank) -> String {
    match (sasi, spi) {
        (_, Rank::Finite(0)) => "No improvement is possible.".to_owned(),
        (Rank::Finite(0), spi) => {
            format!("No improvement is sure (SASI). Improves {} possibly (SPI).", times(spi))
        }
        _ => format!("Improves {} surely (SASI), {} possibly (SPI).", times(sasi), times(spi)),
    }
}

/// Both ranks of a state that starts plays, as one sentence.
pub(super) fn verdict(sasi: Option<Rank>, spi: Option<Rank>) -> String {
    let sentence = match (sasi, spi) {
        (Some(Rank::Finite(0)), Some(Rank::Finite(0))) => "no improvement is possible".to_owned(),
        (Some(Rank::Unbounded), Some(Rank::Unbounded)) => claim(sasi, "guaranteed"),
        _ if sasi == spi => {
            let verb = if sasi == Some(Rank::Finite(1)) { "is" } else { "are" };
            format!("{}, and no more than that {verb} possible", claim(sasi, "guaranteed"))
        }
        _ => format!("{}, {}", claim(sasi, "guaranteed"), claim(spi, "possible")),
    };
    let mut letters = sentence.chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    format!("{first}{}.", letters.as_str())
}

/// How a kind is sure of improvements: as an adjective and as an adverb.
pub(super) fn how(kind: Kind) -> (&'static str, &'static str) {
    match kind {
        Kind::Sasi => ("sure", "surely"),
        Kind::Spi => ("possible", "possibly"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verdicts_are_sentences() {
        use Rank::{Finite, Unbounded};
        for (sasi, spi, text) in [
            (Finite(2), Unbounded, "2 improvements are guaranteed, any number of improvements is possible."),
            (Finite(0), Finite(1), "No improvement is guaranteed, one improvement is possible."),
            (Finite(0), Finite(0), "No improvement is possible."),
            (Finite(1), Finite(1), "One improvement is guaranteed, and no more than that is possible."),
            (Finite(2), Finite(2), "2 improvements are guaranteed, and no more than that are possible."),
            (Unbounded, Unbounded, "Any number of improvements is guaranteed."),
        ] {
            assert_eq!(verdict(Some(sasi), Some(spi)), text);
        }
    }
}
