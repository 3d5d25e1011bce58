//! The improvements that strategies make from the initial states: what improves to what.

use std::sync::Arc;

use crate::all_states::{AllStates, MOST_STATES};
use crate::{Aim, Choose, Chooser, Steps};
use meliora_base::error::Result;
use meliora_engine::Engine;
use meliora_model::preference::ObjectiveSet;
use meliora_model::{Program, State};
use meliora_planning::{Analysis, FiniteMemoryStrategy, Kind, Rank};

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
    /// For each certain improvement the objectives that it gains, over all outcomes, without those that
    /// are sure at the start; empty if they are too many to search.
    pub after: Vec<Vec<String>>,
    /// The number of improvements that are certain; `None` for any number.
    pub certain: Option<usize>,
    /// The expected number of steps until the last of them.
    pub steps: Option<f64>,
    /// One more improvement, if it is possible.
    pub more: Option<More>,
    /// The actions with the best value, the first of which a strategy takes that chooses by value.
    pub first: Vec<String>,
    /// True in a game: the values are those against the opponent, who may also let us attain better ones.
    pub is_against: bool,
}

/// A possible improvement after the certain ones.
#[derive(Debug, Clone, PartialEq)]
pub struct More {
    /// The objectives that it gains, without those that are sure at the start; empty if they are too many
    /// to search.
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
            after: followed.after,
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
        let to = followed.after.last().cloned().unwrap_or_default();
        self.more = Some(More { to, probability });
        Ok(())
    }
}

/// The states and choices that a strategy meets while it makes improvements.
struct Followed {
    /// The most preferred objectives of the first state.
    from: ObjectiveSet,
    /// The best actions by the rule, the first of which it takes.
    first: Vec<String>,
    /// The objectives that each improvement gains, over all outcomes, without those that are sure in the
    /// first state; empty if they are too many to search.
    after: Vec<Vec<String>>,
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
        let mut found = Followed { from: ObjectiveSet::new(), first: Vec::new(), after: Vec::new() };
        let Some(mut strategy) = FiniteMemoryStrategy::new(analysis, program, kind) else { return Ok(found) };
        let best = rule.as_ref().map(|rule| rule.best(state)).unwrap_or_default();
        if let Some(rule) = rule {
            strategy.choose_by(Arc::new(rule));
        }
        let memory = strategy.start(state)?;
        let at = strategy.explain(state, memory)?;
        found.from = at.most_preferred.clone();
        let names = best.iter().filter(|_| at.pick.is_some()).filter_map(|&action| at.actions.get(action));
        found.first = names.map(|action| action.name.clone()).collect();
        let gains = strategy.gains(state, improvements, MOST_STATES)?.unwrap_or_default();
        found.after = analysis.names_of_gains(state, &gains)?;
        Ok(found)
    }
}
