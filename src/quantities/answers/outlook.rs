//! The improvements that strategies make from the initial states: what improves to what.

use std::collections::VecDeque;
use std::sync::Arc;

use ahash::AHashSet;

use crate::answers::all_states::{AllStates, MOST_STATES};
use crate::{Aim, Choose, Chooser, Steps};
use meliora_base::error::Result;
use meliora_engine::Engine;
use meliora_model::preference::ObjectiveSet;
use meliora_model::{Program, State};
use meliora_planning::{Analysis, FiniteMemoryStrategy, Kind, Memory, Rank};

/// Maximum number of initial states with an outlook.
pub const LISTED: usize = 3;

/// The values of all states, and the outlook of the first initial states.
#[derive(Debug)]
pub struct Outlook {
    /// The values; `None` if there are too many states.
    pub all: Option<AllStates>,
    /// The outlooks; `None` where the levels do not tell what the model attains.
    pub promises: Vec<Option<Promise>>,
}

/// The best attainable values from a state.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Promise {
    /// The most preferred objectives of the state.
    pub from: Vec<String>,
    /// For each certain improvement the most preferred objectives after it, over all outcomes; empty
    /// if they are too many to search.
    pub after: Vec<Vec<String>>,
    /// The number of improvements that are certain; `None` for any number.
    pub certain: Option<usize>,
    /// The expected number of steps until the last of them.
    pub steps: Option<f64>,
    /// One more improvement, if it is possible.
    pub more: Option<More>,
    /// The action that a strategy takes first that chooses by value.
    pub first: Option<String>,
    /// True in a game: the values are those against the opponent, who may also let us attain better ones.
    pub is_against: bool,
}

/// A possible improvement after the certain ones.
#[derive(Debug, Clone, PartialEq)]
pub struct More {
    /// The most preferred objectives after it; empty if they are too many to search.
    pub to: Vec<String>,
    /// Its probability, if it is known.
    pub probability: Option<f64>,
}

impl Outlook {
    /// Computes the values of all states, if they are not too many, and what the first initial states
    /// promise.
    ///
    /// # Errors
    /// The levels are not known; a limit is reached.
    pub fn of<E: Engine>(analysis: &Analysis<E>, program: &Arc<Program>) -> Result<Self> {
        let all = AllStates::compute(analysis, program)?;
        let engine = analysis.engine();
        let mut promises = Vec::new();
        for state in engine.list_states(&engine.initial_states(), LISTED)? {
            promises.push(match &all {
                Some(all) => Promise::valued(analysis, program, all, &state)?,
                // The levels of `transition` count improvements that the model may not make.
                None if analysis.options().safety.drops_successors() => None,
                None => Promise::ranked(analysis, program, &state)?,
            });
        }
        Ok(Outlook { all, promises })
    }

    /// Returns whether the values of the states are known.
    pub fn has_values(&self) -> bool {
        self.all.is_some()
    }

    /// Lets a strategy choose by value while it improves, `cheap` for SASI and `likely` for SPI, if the
    /// values are known.
    pub fn attach<E: Engine>(&self, strategy: &mut FiniteMemoryStrategy<E>) -> Choose {
        let Some(all) = &self.all else { return Choose::First };
        let (aim, choose) = match strategy.levels() {
            Kind::Sasi => (Aim::Cheap, Choose::Cheap),
            Kind::Spi => (Aim::Likely, Choose::Likely),
        };
        strategy.choose_by(Arc::new(Chooser::new(Arc::clone(&all.values), aim)));
        choose
    }
}

impl Promise {
    /// Returns what a strategy attains that chooses by value.
    fn valued<E: Engine>(
        analysis: &Analysis<E>,
        program: &Arc<Program>,
        all: &AllStates,
        state: &State,
    ) -> Result<Option<Self>> {
        let values = &all.values;
        let Some(node) = values.start(state) else { return Ok(None) };
        let certain = values.aimed(node, Aim::Cheap);
        let rule = Chooser::new(Arc::clone(values), Aim::Cheap);
        let mut promise = Promise::certain(analysis, program, state, certain, Some(rule))?;
        promise.steps = values.cost(node, certain).map(|cost| cost.middle());
        let next = certain + 1;
        if next <= values.options().levels && values.probability(node, next).middle() > 0.0 {
            // The strategy that makes `next` improvements with the greatest probability, and aims at no more.
            let aim = (Aim::Likely, Some(next));
            let rule = Chooser::compute(analysis, program, std::slice::from_ref(state), aim, &Steps)?;
            let probability = Some(values.probability(node, next).middle());
            promise.possible(analysis, program, state, Some(rule), probability)?;
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
            promise.possible(analysis, program, state, None, None)?;
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
        let followed = Followed::new(analysis, program, Kind::Sasi, rule, state, certain)?;
        Ok(Promise {
            from: analysis.preferences().owned_names(&followed.from),
            first: followed.first,
            after: followed.after.iter().map(|set| analysis.preferences().owned_names(set)).collect(),
            certain: Some(certain),
            is_against: analysis.whole_engine().is_game(),
            ..Promise::default()
        })
    }

    /// Adds the possible improvement after the certain ones, with its probability.
    fn possible<E: Engine>(
        &mut self,
        analysis: &Analysis<E>,
        program: &Arc<Program>,
        state: &State,
        rule: Option<Chooser>,
        probability: Option<f64>,
    ) -> Result<()> {
        let certain = self.certain.unwrap_or_default();
        let followed = Followed::new(analysis, program, Kind::Spi, rule, state, certain + 1)?;
        if certain == 0 {
            self.first = followed.first;
        }
        let to = followed.after.last().map(|set| analysis.preferences().owned_names(set));
        self.more = Some(More { to: to.unwrap_or_default(), probability });
        Ok(())
    }
}

/// The states and choices that a strategy meets while it makes improvements.
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
    /// takes the first action that makes progress. The opponent takes any action. Cost: at most [`MOST_STATES`] states are explained.
    fn new<E: Engine>(
        analysis: &Analysis<E>,
        program: &Arc<Program>,
        kind: Kind,
        rule: Option<Chooser>,
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
        found.after = after(&mut strategy, state, memory, improvements)?;
        Ok(found)
    }
}

/// Returns for each improvement the most preferred objectives of the states that it leads to; nothing
/// if the search is too large.
fn after<E: Engine>(
    strategy: &mut FiniteMemoryStrategy<E>,
    start: &State,
    memory: Memory,
    improvements: usize,
) -> Result<Vec<ObjectiveSet>> {
    let first = (start.clone(), memory, 0);
    let (mut seen, mut queue) = (AHashSet::from([first.clone()]), VecDeque::from([first]));
    let mut found = vec![ObjectiveSet::new(); improvements];
    while let Some((state, memory, made)) = queue.pop_front() {
        if made == improvements {
            continue;
        }
        if seen.len() > MOST_STATES {
            return Ok(Vec::new());
        }
        let at = strategy.explain(&state, memory)?;
        let taken = |number: usize| at.is_theirs() || at.pick == Some(number);
        let actions = at.actions.iter().enumerate().filter(|(number, _)| taken(*number));
        for successor in actions.flat_map(|(_, action)| &action.successors) {
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
