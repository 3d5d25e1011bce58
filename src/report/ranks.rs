//! Texts for ranks.

use super::text;
use meliora_planning::result::{Plan, Prospects};
use meliora_planning::{Kind, Rank};

/// Maximum number of improvements whose gains are named.
const MOST_GAINS: usize = 3;

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

/// Returns `2 improvements over A are guaranteed: to D, then to F`, with the most preferred objectives of
/// the state and the gains, if they are known, and a note if the search for levels stopped.
pub(super) fn ability(plan: &Plan, from: &[String], how: &str) -> String {
    let over = format!(" over {}", text::goal(from));
    let stopped = if matches!(plan.rank, Rank::AtLeast(_)) { " (search stopped)" } else { "" };
    let known = plan.gains.iter().take_while(|gain| !gain.is_empty());
    let steps: Vec<String> = known.take(MOST_GAINS).map(|gain| format!("to {}", text::goal(gain))).collect();
    let more = if plan.gains.len() > MOST_GAINS { ", …" } else { "" };
    let gains = match steps.is_empty() {
        true => String::new(),
        false => format!(": {}{more}", steps.join(", then ")),
    };
    format!("{}{gains}{stopped}", claim_over(Some(plan.rank), &over, how))
}

/// Returns what `--safety action` says of a state if it differs from `--safety prefix`.
pub(super) fn differing(state: &Prospects, by_step: Option<&[Rank; 2]>) -> Option<String> {
    let &[sasi, spi] = by_step?;
    let own = [&state.sasi, &state.spi].map(|plan| plan.as_ref().map(|plan| plan.rank));
    (own != [Some(sasi), Some(spi)]).then(|| {
        let [sasi, spi] = [sasi, spi].map(cell);
        format!(
            "`--safety action` counts {sasi} (SASI) and {spi} (SPI): it compares each step with the state \
             before it, and not with the start."
        )
    })
}

/// Returns `2 improvements are guaranteed`, `any number of improvements is possible`, …
pub(super) fn claim(rank: Option<Rank>, how: &str) -> String {
    claim_over(rank, "", how)
}

/// Returns a claim that also names the state that is improved on.
fn claim_over(rank: Option<Rank>, over: &str, how: &str) -> String {
    match rank {
        None => format!("it is not known how many improvements{over} are {how}"),
        Some(Rank::Finite(0)) => format!("no improvement{over} is {how}"),
        Some(Rank::Finite(1)) => format!("one improvement{over} is {how}"),
        Some(Rank::Finite(k)) => format!("{k} improvements{over} are {how}"),
        Some(Rank::AtLeast(k)) => format!("{k} or more improvements{over} are {how}"),
        Some(Rank::Unbounded) => format!("any number of improvements{over} is {how}"),
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
