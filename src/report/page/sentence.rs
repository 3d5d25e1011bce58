//! The improvements from an initial state, in one sentence.

use super::heat::digits;
use super::words;
use crate::text;
use meliora_quantities::outlook::{More, Promise};

/// Maximum number of certain improvements whose objectives are named.
const MOST_GOALS: usize = 3;

/// Returns the sentence: `Can improve from nothing to D, then to F with probability one, in 11.4 steps
/// on average; a third time, to E, with probability 0.41.`
pub(super) fn sentence(promise: &Promise) -> String {
    let from = text::either(&promise.from);
    let more = promise.more.as_ref().map(|more| (better(&more.to), probability(more, promise.is_against)));
    if promise.certain == Some(0) {
        return match more {
            Some((goal, probability)) => {
                format!("Can improve from {from} to {goal} with {probability}; no improvement is guaranteed.")
            }
            None if promise.from.is_empty() => "Nothing is sure, and no improvement is possible.".to_owned(),
            None => format!("No improvement is possible from {from}."),
        };
    }
    let most = if promise.is_against { "at most " } else { "" };
    let steps = promise.steps.map(|steps| format!(", in {most}{} on average", words::steps(steps)));
    let steps = steps.unwrap_or_default();
    let more = match (promise.certain, more) {
        (None, _) => ", and then any number of times".to_owned(),
        (Some(_), None) => String::new(),
        (Some(certain), Some((goal, probability))) => {
            format!("; a {} time, to {goal}, with {probability}", words::ordinal(certain + 1))
        }
    };
    format!("Can improve from {from}{} with probability one{steps}{more}.", goals(promise))
}

/// Returns what the certain improvements lead to: ` to D, then to F`.
fn goals(promise: &Promise) -> String {
    let certain = promise.certain.unwrap_or(1);
    let mut goals: Vec<String> =
        promise.after.iter().take(MOST_GOALS).map(|goal| format!("to {}", better(goal))).collect();
    match certain - goals.len() {
        0 => {}
        1 if goals.is_empty() => goals.push(format!("to {}", better(&[]))),
        left if goals.is_empty() => return format!(" {}", text::plural(left, "time")),
        left => goals.push(text::plural(left, "more time")),
    }
    format!(" {}", goals.join(", then "))
}

/// Returns what an improvement gains, if it is known.
fn better(gains: &[String]) -> String {
    if gains.is_empty() { "something better".to_owned() } else { text::goal(gains) }
}

/// Returns the probability of an improvement in words.
fn probability(more: &More, is_against: bool) -> String {
    let least = if is_against { "at least " } else { "" };
    let known = |p| format!("probability {least}{}", digits(p));
    more.probability.map_or_else(|| "positive probability".to_owned(), known)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(names: &[&str]) -> Vec<String> {
        names.iter().map(|&name| name.to_owned()).collect()
    }

    fn promise(after: &[&[&str]], certain: Option<usize>, more: Option<(&[&str], Option<f64>)>) -> Promise {
        let after = after.iter().map(|goal| names(goal)).collect();
        let more = more.map(|(to, probability)| More { to: names(to), probability });
        Promise { after, certain, more, ..Promise::default() }
    }

    #[test]
    fn the_sentence_says_what_how_sure_and_how_soon() {
        let steps = |promise| Promise { steps: Some(11.44), ..promise };
        assert_eq!(
            sentence(&steps(promise(&[&["D"], &["F"]], Some(2), Some((&["E"], Some(0.41)))))),
            "Can improve from nothing to D, then to F with probability one, in 11.4 steps on average; \
             a third time, to E, with probability 0.41."
        );
        assert_eq!(
            sentence(&promise(&[&["A", "B"]], Some(1), None)),
            "Can improve from nothing to A or B with probability one."
        );
        let far = sentence(&promise(&[&["A"], &["B"], &["C"], &["D"], &["E"]], Some(5), None));
        assert_eq!(
            far,
            "Can improve from nothing to A, then to B, then to C, then 2 more times with probability one."
        );
        assert_eq!(
            sentence(&promise(&[], Some(12), None)),
            "Can improve from nothing 12 times with probability one."
        );
        assert_eq!(
            sentence(&promise(&[], Some(1), None)),
            "Can improve from nothing to something better with probability one."
        );
        assert_eq!(
            sentence(&promise(&[&["A"]], None, None)),
            "Can improve from nothing to A with probability one, and then any number of times."
        );
    }

    #[test]
    fn the_sentence_says_what_is_possible_where_nothing_is_certain() {
        let some = |to, probability| sentence(&promise(&[], Some(0), Some((to, probability))));
        assert_eq!(
            some(&["A"], Some(0.26)),
            "Can improve from nothing to A with probability 0.26; no improvement is guaranteed."
        );
        assert_eq!(
            some(&[], None),
            "Can improve from nothing to something better with positive probability; \
             no improvement is guaranteed."
        );
        let game = promise(&[&["D"]], Some(1), Some((&["E"], Some(0.41))));
        assert_eq!(
            sentence(&Promise { steps: Some(2.0), is_against: true, ..game }),
            "Can improve from nothing to D with probability one, in at most 2 steps on average; \
             a second time, to E, with probability at least 0.41."
        );
        let none = promise(&[], Some(0), None);
        assert_eq!(sentence(&none), "Nothing is sure, and no improvement is possible.");
        let none = Promise { from: names(&["A", "B"]), ..none };
        assert_eq!(sentence(&none), "No improvement is possible from A or B.");
    }
}
