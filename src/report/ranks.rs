//! Texts for ranks.

use super::text;
use meliora_planning::{Kind, Rank};

/// Formats a rank as `2`, `2+` or `∞`; `?` if it is not known.
pub(super) fn mark(rank: Option<Rank>) -> String {
    match rank {
        None => "?".to_owned(),
        Some(Rank::Finite(k)) => k.to_string(),
        Some(Rank::AtLeast(k)) => format!("{k}+"),
        Some(Rank::Unbounded) => "∞".to_owned(),
    }
}

/// Formats a rank for a table.
pub(super) fn cell(rank: Rank) -> String {
    match rank {
        Rank::Finite(k) => k.to_string(),
        Rank::AtLeast(k) => format!("{k} or more"),
        Rank::Unbounded => "unbounded".to_owned(),
    }
}

/// Returns `1 improvement`, `2 improvements`, `any number of improvements`.
pub(super) fn improvements(rank: Rank) -> String {
    match rank {
        Rank::Finite(k) => text::plural(k, "improvement"),
        Rank::AtLeast(k) => format!("{} or more", text::plural(k, "improvement")),
        Rank::Unbounded => "any number of improvements".to_owned(),
    }
}

/// Returns whether a rank is exactly or at least one improvement.
pub(super) fn is_one(rank: Rank) -> bool {
    matches!(rank, Rank::Finite(1) | Rank::AtLeast(1))
}

/// Returns `2 improvements are guaranteed`, with a note if the search for levels stopped.
pub(super) fn ability(rank: Rank, how: &str) -> String {
    match rank {
        Rank::AtLeast(_) => format!("{} (search stopped)", claim(Some(rank), how)),
        _ => claim(Some(rank), how),
    }
}

/// Returns `2 improvements are guaranteed`, `any number of improvements is possible`, …
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

/// Returns both ranks of a state in one or two sentences.
pub(super) fn both(sasi: Rank, spi: Rank) -> String {
    match (sasi, spi) {
        (_, Rank::Finite(0)) => "No improvement is possible.".to_owned(),
        _ => {
            let (sasi, spi) = (cell(sasi), cell(spi));
            format!("Guaranteed improvements (SASI): {sasi}. Possible improvements (SPI): {spi}.")
        }
    }
}

/// Returns both ranks of an initial state as one sentence.
pub(super) fn verdict(sasi: Option<Rank>, spi: Option<Rank>) -> String {
    let sentence = match (sasi, spi) {
        (Some(Rank::Finite(0)), Some(Rank::Finite(0))) => "no improvement is possible".to_owned(),
        (Some(Rank::Unbounded), Some(Rank::Unbounded)) => claim(sasi, "guaranteed"),
        (Some(Rank::Finite(_)), _) if sasi == spi => {
            let verb = if sasi == Some(Rank::Finite(1)) { "is" } else { "are" };
            format!("{}, and no more {verb} possible", claim(sasi, "guaranteed"))
        }
        _ => format!("{}, {}", claim(sasi, "guaranteed"), claim(spi, "possible")),
    };
    capitalised(&sentence) + "."
}

/// Returns a text with a capital first letter.
pub(super) fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    format!("{first}{}", letters.as_str())
}

/// Returns the adjective for the improvements of a kind.
pub(super) fn how(kind: Kind) -> &'static str {
    match kind {
        Kind::Sasi => "guaranteed",
        Kind::Spi => "possible",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_are_told_as_sentences() {
        use Rank::{Finite, Unbounded};
        for (sasi, spi, text) in [
            (Finite(2), Unbounded, "2 improvements are guaranteed, any number of improvements is possible."),
            (Finite(0), Finite(1), "No improvement is guaranteed, one improvement is possible."),
            (Finite(0), Finite(0), "No improvement is possible."),
            (Finite(1), Finite(1), "One improvement is guaranteed, and no more is possible."),
            (Finite(2), Finite(2), "2 improvements are guaranteed, and no more are possible."),
            (Unbounded, Unbounded, "Any number of improvements is guaranteed."),
        ] {
            assert_eq!(verdict(Some(sasi), Some(spi)), text);
        }
    }
}
