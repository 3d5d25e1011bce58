//! What a strategy that chooses by value attains from a state, in one sentence.

use std::collections::{BTreeSet, VecDeque};
use std::sync::Arc;

use ahash::AHashSet;

use super::heat::{Heat, digits};
use super::words;
use crate::engine::Engine;
use crate::error::Result;
use crate::model::{Program, State};
use crate::output::text;
use crate::planning::{Analysis, FiniteMemoryStrategy, Kind, Memory};
use crate::quantities::{Aim, Choose, Chooser};

/// Maximum number of nodes that are searched for the objectives that improvements lead to.
const MOST_NODES: usize = 4096;
/// Maximum number of initial states with a sentence.
pub(super) const LISTED: usize = 3;

/// The values of all states, and the outlook of the first initial states.
#[derive(Debug)]
pub struct Outlook {
    pub(super) heat: Heat,
    pub(super) promises: Vec<Promise>,
}

/// What can be attained from a state.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Promise {
    /// The most preferred objectives of the state.
    pub(super) from: Vec<String>,
    /// For each certain improvement the most preferred objectives after it, one list per outcome;
    /// empty if they are too many to search.
    pub(super) after: Vec<BTreeSet<Vec<String>>>,
    /// The number of improvements that are certain.
    pub(super) certain: usize,
    /// The expected number of steps until the last of them.
    pub(super) steps: Option<f64>,
    /// The probability of one more.
    pub(super) next: f64,
    /// The action that the strategy takes first.
    pub(super) first: Option<String>,
}

impl Outlook {
    /// Computes the values of all states and what the first initial states promise; returns `None` if
    /// there are too many states for a page.
    ///
    /// # Errors
    /// The levels are not known; a limit is reached.
    pub fn of<E: Engine>(analysis: &Analysis<E>, program: &Arc<Program>) -> Result<Option<Self>> {
        let Some(heat) = Heat::of(analysis, program)? else { return Ok(None) };
        let engine = analysis.engine();
        let mut promises = Vec::new();
        for state in engine.list_states(&engine.initial_states(), LISTED)? {
            promises.extend(Promise::of(analysis, program, &heat, &state)?);
        }
        Ok(Some(Outlook { heat, promises }))
    }

    /// Lets a strategy choose by value while it improves: `cheap` for SASI, `likely` for SPI.
    pub fn attach<E: Engine>(&self, strategy: &mut FiniteMemoryStrategy<E>) -> Choose {
        let (aim, choose) = match strategy.levels() {
            Kind::Sasi => (Aim::Cheap, Choose::Cheap),
            Kind::Spi => (Aim::Likely, Choose::Likely),
        };
        strategy.choose_by(Arc::new(Chooser::new(Arc::clone(&self.heat.values), aim)));
        choose
    }
}

impl Promise {
    fn of<E: Engine>(
        analysis: &Analysis<E>,
        program: &Arc<Program>,
        heat: &Heat,
        state: &State,
    ) -> Result<Option<Self>> {
        let values = &heat.values;
        let Some(node) = values.start(state) else { return Ok(None) };
        let certain = values.aimed(node, Aim::Cheap);
        let kind = if certain > 0 { (Kind::Sasi, Aim::Cheap) } else { (Kind::Spi, Aim::Likely) };
        let Some(mut book) = FiniteMemoryStrategy::new(analysis, program, kind.0) else { return Ok(None) };
        book.choose_by(Arc::new(Chooser::new(Arc::clone(values), kind.1)));
        let memory = book.start(state)?;
        let at = book.explain(state, memory)?;
        let more = certain < values.setup().levels;
        let next = if more { values.probability(node, certain + 1).middle() } else { 0.0 };
        Ok(Some(Promise {
            from: analysis.preferences().owned_names(&at.most_preferred),
            first: at.pick.map(|pick| at.actions[pick].name.clone()),
            after: after(&mut book, (state, memory), certain)?,
            certain,
            steps: values.cost(node, certain).map(|cost| cost.middle()),
            next,
        }))
    }

    /// Returns the sentence: `From nothing to D, then to F: guaranteed, 11.4 steps on average; a third
    /// improvement with probability 0.41.`
    pub(super) fn sentence(&self) -> String {
        let from = text::either(&self.from);
        let next = match self.next > 0.0 {
            true => {
                let which = words::ordinal(self.certain + 1);
                format!("a {which} improvement with probability {}", digits(self.next))
            }
            false => String::new(),
        };
        if self.certain == 0 {
            return match next.is_empty() {
                true => format!("From {from}: no improvement is possible."),
                false => format!("From {from}: none guaranteed, {next}."),
            };
        }
        let ways: Vec<String> = self.after.iter().map(words::one_of).collect();
        let ways = match ways.is_empty() {
            true => format!(": {} guaranteed", words::improvements(self.certain)),
            false => format!(" to {}: guaranteed", ways.join(", then to ")),
        };
        let steps =
            self.steps.map(|steps| format!(", {} on average", words::steps(steps))).unwrap_or_default();
        let next = if next.is_empty() { next } else { format!("; {next}") };
        format!("From {from}{ways}{steps}{next}.")
    }
}

/// Returns for each improvement the most preferred objectives of the states that it leads to; nothing
/// if the search is too large.
fn after<E: Engine>(
    book: &mut FiniteMemoryStrategy<E>,
    (start, memory): (&State, Memory),
    certain: usize,
) -> Result<Vec<BTreeSet<Vec<String>>>> {
    let first = (start.clone(), memory, 0);
    let (mut seen, mut queue) = (AHashSet::from([first.clone()]), VecDeque::from([first]));
    let mut found = vec![BTreeSet::new(); certain];
    while let Some((state, memory, made)) = queue.pop_front() {
        if made == certain {
            continue;
        }
        if seen.len() > MOST_NODES {
            return Ok(Vec::new());
        }
        let at = book.explain(&state, memory)?;
        let Some(pick) = at.pick else { continue };
        for successor in &at.actions[pick].successors {
            if successor.improves {
                found[made].insert(book.preferences().owned_names(&successor.most_preferred));
            }
            let next = (successor.state.clone(), successor.next, made + usize::from(successor.improves));
            if seen.insert(next.clone()) {
                queue.push_back(next);
            }
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn promise(after: &[&[&str]], certain: usize, next: f64) -> Promise {
        let one = |names: &&[&str]| BTreeSet::from([names.iter().map(|&n| n.to_owned()).collect()]);
        let after = after.iter().map(one).collect();
        Promise { from: Vec::new(), after, certain, steps: Some(11.44), next, first: None }
    }

    #[test]
    fn the_sentence_says_what_how_sure_and_how_soon() {
        let sentence = |after: &[&[&str]], certain, next| promise(after, certain, next).sentence();
        assert_eq!(
            sentence(&[&["D"], &["F"]], 2, 0.41),
            "From nothing to D, then to F: guaranteed, 11.4 steps on average; \
             a third improvement with probability 0.41."
        );
        assert_eq!(
            sentence(&[&["A", "B"]], 1, 0.0),
            "From nothing to A or B: guaranteed, 11.4 steps on average."
        );
        assert_eq!(
            sentence(&[], 0, 0.26),
            "From nothing: none guaranteed, a first improvement with probability 0.26."
        );
        assert_eq!(sentence(&[], 0, 0.0), "From nothing: no improvement is possible.");
        assert_eq!(
            sentence(&[], 12, 0.0),
            "From nothing: 12 improvements guaranteed, 11.4 steps on average."
        );
    }
}
