//! What improves to what in the initial states, in one sentence.

use std::collections::VecDeque;
use std::sync::Arc;

use ahash::AHashSet;

use super::heat::{Heat, digits};
use super::words;
use crate::engine::Engine;
use crate::error::Result;
use crate::model::preference::ObjectiveSet;
use crate::model::{Program, State};
use crate::output::text;
use crate::planning::{Analysis, FiniteMemoryStrategy, Kind, Memory, Rank, Safety};
use crate::quantities::{Aim, Choose, Chooser, Steps};

/// Maximum number of nodes that are searched for the objectives that improvements lead to.
const MOST_NODES: usize = 4096;
/// Maximum number of certain improvements whose objectives are named.
const MOST_GOALS: usize = 3;
/// Maximum number of initial states with a sentence.
pub(super) const LISTED: usize = 3;

/// The values of all states, and the outlook of the first initial states.
#[derive(Debug)]
pub(crate) struct Outlook {
    /// The values; `None` if there are too many states.
    pub(super) heat: Option<Heat>,
    /// The outlooks; `None` where the levels do not tell what the model attains.
    pub(super) promises: Vec<Option<Promise>>,
}

/// What can be attained from a state.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Promise {
    /// The most preferred objectives of the state.
    from: Vec<String>,
    /// For each certain improvement the most preferred objectives after it, over all outcomes; empty
    /// if they are too many to search.
    after: Vec<Vec<String>>,
    /// The number of improvements that are certain; `None` for any number.
    certain: Option<usize>,
    /// The expected number of steps until the last of them.
    steps: Option<f64>,
    /// One more improvement, if it is possible.
    more: Option<More>,
    /// The action that a strategy takes first that chooses by value.
    pub(super) first: Option<String>,
}

/// A possible improvement after the certain ones.
#[derive(Debug, Clone, PartialEq)]
struct More {
    /// The most preferred objectives after it; empty if they are too many to search.
    to: Vec<String>,
    /// Its probability, if it is known.
    probability: Option<f64>,
}

impl Outlook {
    /// Computes the values of all states, if they are not too many, and what the first initial states
    /// promise.
    ///
    /// # Errors
    /// The levels are not known; a limit is reached.
    pub(crate) fn of<E: Engine>(analysis: &Analysis<E>, program: &Arc<Program>) -> Result<Self> {
        let heat = Heat::of(analysis, program)?;
        let engine = analysis.engine();
        let mut promises = Vec::new();
        for state in engine.list_states(&engine.initial_states(), LISTED)? {
            promises.push(match &heat {
                Some(heat) => Promise::valued(analysis, program, heat, &state)?,
                // The levels of `transition` count improvements that the model may not make.
                None if analysis.options().safety == Safety::Transition => None,
                None => Promise::ranked(analysis, program, &state)?,
            });
        }
        Ok(Outlook { heat, promises })
    }

    /// Returns whether the values of the states are known.
    pub(crate) fn has_values(&self) -> bool {
        self.heat.is_some()
    }

    /// Lets a strategy choose by value while it improves, `cheap` for SASI and `likely` for SPI, if the
    /// values are known.
    pub(crate) fn attach<E: Engine>(&self, strategy: &mut FiniteMemoryStrategy<E>) -> Choose {
        let Some(heat) = &self.heat else { return Choose::First };
        let (aim, choose) = match strategy.levels() {
            Kind::Sasi => (Aim::Cheap, Choose::Cheap),
            Kind::Spi => (Aim::Likely, Choose::Likely),
        };
        strategy.choose_by(Arc::new(Chooser::new(Arc::clone(&heat.values), aim)));
        choose
    }
}

impl Promise {
    /// Returns what a strategy attains that chooses by value.
    fn valued<E: Engine>(
        analysis: &Analysis<E>,
        program: &Arc<Program>,
        heat: &Heat,
        state: &State,
    ) -> Result<Option<Self>> {
        let values = &heat.values;
        let Some(node) = values.start(state) else { return Ok(None) };
        let certain = values.aimed(node, Aim::Cheap);
        let rule = Chooser::new(Arc::clone(values), Aim::Cheap);
        let mut promise = Promise::certain(analysis, program, state, certain, Some(rule))?;
        promise.steps = values.cost(node, certain).map(|cost| cost.middle());
        let next = certain + 1;
        if next <= values.setup().levels && values.probability(node, next).middle() > 0.0 {
            // The strategy that makes `next` improvements with the greatest probability, and aims at no more.
            let aim = (Aim::Likely, Some(next));
            let rule = Chooser::compute(analysis, program, std::slice::from_ref(state), aim, &Steps)?;
            let probability = Some(values.probability(node, next).middle());
            promise.possible(analysis, program, state, (Some(rule), probability))?;
        }
        Ok(Some(promise))
    }

    /// Returns what the ranks promise, without numbers.
    fn ranked<E: Engine>(
        analysis: &Analysis<E>,
        program: &Arc<Program>,
        state: &State,
    ) -> Result<Option<Self>> {
        let class = analysis.classes().map(|classes| classes.of(analysis.engine(), state));
        if class.transpose()?.flatten().is_none() {
            return Ok(None);
        }
        let rank = |kind| analysis.levels(kind).rank(analysis.engine(), state);
        let Rank::Finite(certain) = rank(Kind::Sasi)? else {
            let promise = Promise::certain(analysis, program, state, 1, None)?;
            return Ok(Some(Promise { certain: None, ..promise }));
        };
        let mut promise = Promise::certain(analysis, program, state, certain, None)?;
        if rank(Kind::Spi)? != Rank::Finite(certain) {
            promise.possible(analysis, program, state, (None, None))?;
        }
        Ok(Some(promise))
    }

    /// Returns a promise of certain improvements only.
    fn certain<E: Engine>(
        analysis: &Analysis<E>,
        program: &Arc<Program>,
        state: &State,
        certain: usize,
        rule: Option<Chooser>,
    ) -> Result<Self> {
        let followed = Followed::new(analysis, program, (Kind::Sasi, rule), state, certain)?;
        Ok(Promise {
            from: analysis.preferences().owned_names(&followed.from),
            first: followed.first,
            after: followed.after.iter().map(|set| analysis.preferences().owned_names(set)).collect(),
            certain: Some(certain),
            ..Promise::default()
        })
    }

    /// Adds the possible improvement after the certain ones, with its probability.
    fn possible<E: Engine>(
        &mut self,
        analysis: &Analysis<E>,
        program: &Arc<Program>,
        state: &State,
        (rule, probability): (Option<Chooser>, Option<f64>),
    ) -> Result<()> {
        let certain = self.certain.unwrap_or_default();
        let followed = Followed::new(analysis, program, (Kind::Spi, rule), state, certain + 1)?;
        if certain == 0 {
            self.first = followed.first;
        }
        let to = followed.after.last().map(|set| analysis.preferences().owned_names(set));
        self.more = Some(More { to: to.unwrap_or_default(), probability });
        Ok(())
    }

    /// Returns the sentence: `Can improve from nothing to D, then to F with probability one, in 11.4 steps
    /// on average; a third time, to E, with probability 0.41.`
    pub(super) fn sentence(&self) -> String {
        let from = text::either(&self.from);
        let more = self.more.as_ref().map(|more| (words::goal(&more.to), more.probability()));
        if self.certain == Some(0) {
            return match more {
                Some((goal, probability)) => {
                    format!(
                        "Can improve from {from} to {goal} with {probability}; no improvement is guaranteed."
                    )
                }
                None if self.from.is_empty() => "Nothing is sure, and no improvement is possible.".to_owned(),
                None => format!("No improvement is possible from {from}."),
            };
        }
        let steps =
            self.steps.map(|steps| format!(", in {} on average", words::steps(steps))).unwrap_or_default();
        let more = match (self.certain, more) {
            (None, _) => ", and then any number of times".to_owned(),
            (Some(_), None) => String::new(),
            (Some(certain), Some((goal, probability))) => {
                format!("; a {} time, to {goal}, with {probability}", words::ordinal(certain + 1))
            }
        };
        format!("Can improve from {from}{} with probability one{steps}{more}.", self.goals())
    }

    /// Returns what the certain improvements lead to: ` to D, then to F`.
    fn goals(&self) -> String {
        let certain = self.certain.unwrap_or(1);
        let mut goals: Vec<String> =
            self.after.iter().take(MOST_GOALS).map(|goal| format!("to {}", words::goal(goal))).collect();
        match certain - goals.len() {
            0 => {}
            1 if goals.is_empty() => goals.push(format!("to {}", words::goal(&[]))),
            left if goals.is_empty() => return format!(" {}", text::plural(left, "time")),
            left => goals.push(text::plural(left, "more time")),
        }
        format!(" {}", goals.join(", then "))
    }
}

impl More {
    fn probability(&self) -> String {
        let known = |p| format!("probability {}", digits(p));
        self.probability.map_or_else(|| "positive probability".to_owned(), known)
    }
}

/// What a strategy meets while it makes improvements.
struct Followed {
    /// The most preferred objectives of the first state.
    from: ObjectiveSet,
    /// The action that the rule takes first.
    first: Option<String>,
    /// The most preferred objectives after each improvement, over all outcomes; empty if they are too
    /// many to search.
    after: Vec<ObjectiveSet>,
}

impl Followed {
    /// Searches the states until the last of `improvements` improvements; without a rule, the strategy
    /// takes the first action that makes progress. Cost: at most [`MOST_NODES`] states are explained.
    fn new<E: Engine>(
        analysis: &Analysis<E>,
        program: &Arc<Program>,
        (kind, rule): (Kind, Option<Chooser>),
        state: &State,
        improvements: usize,
    ) -> Result<Self> {
        let mut found = Followed { from: ObjectiveSet::new(), first: None, after: Vec::new() };
        let Some(mut strategy) = FiniteMemoryStrategy::new(analysis, program, kind) else { return Ok(found) };
        let by_value = rule.map(|rule| strategy.choose_by(Arc::new(rule))).is_some();
        let memory = strategy.start(state)?;
        let at = strategy.explain(state, memory)?;
        found.from = at.most_preferred.clone();
        found.first = at.pick.filter(|_| by_value).map(|pick| at.actions[pick].name.clone());
        found.after = after(&mut strategy, (state, memory), improvements)?;
        Ok(found)
    }
}

/// Returns for each improvement the most preferred objectives of the states that it leads to; nothing
/// if the search is too large.
fn after<E: Engine>(
    strategy: &mut FiniteMemoryStrategy<E>,
    (start, memory): (&State, Memory),
    improvements: usize,
) -> Result<Vec<ObjectiveSet>> {
    let first = (start.clone(), memory, 0);
    let (mut seen, mut queue) = (AHashSet::from([first.clone()]), VecDeque::from([first]));
    let mut found = vec![ObjectiveSet::new(); improvements];
    while let Some((state, memory, made)) = queue.pop_front() {
        if made == improvements {
            continue;
        }
        if seen.len() > MOST_NODES {
            return Ok(Vec::new());
        }
        let at = strategy.explain(&state, memory)?;
        let Some(pick) = at.pick else { continue };
        for successor in &at.actions[pick].successors {
            if successor.improves {
                found[made].extend_with(&successor.most_preferred);
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
            steps(promise(&[&["D"], &["F"]], Some(2), Some((&["E"], Some(0.41))))).sentence(),
            "Can improve from nothing to D, then to F with probability one, in 11.4 steps on average; \
             a third time, to E, with probability 0.41."
        );
        assert_eq!(
            promise(&[&["A", "B"]], Some(1), None).sentence(),
            "Can improve from nothing to A or B with probability one."
        );
        let far = promise(&[&["A"], &["B"], &["C"], &["D"], &["E"]], Some(5), None).sentence();
        assert_eq!(
            far,
            "Can improve from nothing to A, then to B, then to C, then 2 more times with probability one."
        );
        assert_eq!(
            promise(&[], Some(12), None).sentence(),
            "Can improve from nothing 12 times with probability one."
        );
        assert_eq!(
            promise(&[], Some(1), None).sentence(),
            "Can improve from nothing to something better with probability one."
        );
        assert_eq!(
            promise(&[&["A"]], None, None).sentence(),
            "Can improve from nothing to A with probability one, and then any number of times."
        );
    }

    #[test]
    fn the_sentence_says_what_is_possible_where_nothing_is_certain() {
        let some = |to, probability| promise(&[], Some(0), Some((to, probability))).sentence();
        assert_eq!(
            some(&["A"], Some(0.26)),
            "Can improve from nothing to A with probability 0.26; no improvement is guaranteed."
        );
        assert_eq!(
            some(&[], None),
            "Can improve from nothing to something better with positive probability; \
             no improvement is guaranteed."
        );
        let none = promise(&[], Some(0), None);
        assert_eq!(none.sentence(), "Nothing is sure, and no improvement is possible.");
        let none = Promise { from: names(&["A", "B"]), ..none };
        assert_eq!(none.sentence(), "No improvement is possible from A or B.");
    }
}
