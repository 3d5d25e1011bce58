//! States with the actions that a strategy permits, and the reasons.

use std::sync::Arc;

use crate::embed::Task;
use meliora_base::error::{Limit, Result};
use meliora_engine::{Count, Engine};
use meliora_model::State;
use meliora_planning::induced_model::{Node, Unfolding};
use meliora_planning::{Analysis, FiniteMemoryStrategy, InducedModel, Kind, Rank, Scheduler};
use meliora_quantities::ValuedRule;
use meliora_report::choose::{Attains, Choosing};
use meliora_report::cycle::Cycle;
use meliora_report::reason::Words;
use meliora_report::state::{Place, StateReport};
use meliora_report::{Number, strategy_table};

/// Maximum number of nodes of the induced model of a state.
const MOST_NODES: usize = 60;

/// A strategy that is explained.
pub struct Explaining<'a, E: Engine> {
    /// The model and the preferences.
    pub task: &'a Task,
    /// The analysis, with the levels of both kinds.
    pub analysis: &'a Analysis<E>,
    /// The strategy.
    pub strategy: FiniteMemoryStrategy<E>,
    /// Its choice among permitted actions.
    pub choosing: Choosing,
    /// Its decision rule, if it depends on values.
    pub chooser: Option<Arc<dyn ValuedRule>>,
}

impl<'a, E: Engine> Explaining<'a, E> {
    /// Returns the texts of the model and the preferences.
    pub fn words(&self) -> Words<'a> {
        let (program, preferences) = (&*self.task.program, &*self.task.preferences);
        Words { program, preferences, kind: self.strategy.kind(), levels: self.strategy.levels() }
    }

    /// Explains a state where paths start, with its induced model and the cycle behind an unbounded rank if `unfold` says
    /// so. Cost: that of [`FiniteMemoryStrategy::explain`], for each node of the induced model.
    ///
    /// # Errors
    /// A command has no meaning in a state; a limit is reached.
    pub fn state(&mut self, state: &[i64], unfold: bool) -> Result<StateReport<'a>> {
        let ranks = [self.analysis.rank(Kind::Sasi, state)?, self.analysis.rank(Kind::Spi, state)?];
        let memory = self.strategy.start(state)?;
        let at = self.strategy.explain(state, memory)?;
        let mut unfolded = None;
        if unfold && (memory.level != Rank::Finite(0) || !at.aims.is_empty()) {
            let (starts, scheduler) = ([state.to_vec()], Scheduler::Progress);
            unfolded = Some(InducedModel::unfold(&mut self.strategy, &starts, scheduler, MOST_NODES)?);
        }
        let cycle = match unfolded.is_some() && memory.level == Rank::Unbounded {
            true => Cycle::of_kind(self.analysis, &self.task.program, self.strategy.levels(), state)?,
            false => None,
        };
        let attains = self.chooser.as_ref().and_then(|rule| rule.attained(state));
        Ok(StateReport {
            words: self.words(),
            at,
            ranks,
            choosing: self.choosing.clone(),
            attains: attains.as_ref().map(Attains::new),
            unfolded,
            cycle,
            place: None,
        })
    }

    /// Explains some states with all memories that paths from them may have: the whole strategy. `each` gets them one by
    /// one. Cost: that of [`FiniteMemoryStrategy::explain`] per state with memory.
    ///
    /// # Errors
    /// There are more than `limit`; other limits; the errors of `each`.
    pub fn everywhere(
        &mut self,
        starts: &[State],
        limit: usize,
        each: &mut dyn FnMut(&StateReport<'a>) -> Result<()>,
    ) -> Result<()> {
        // A rule takes one action; without one, all permitted actions may be taken.
        let scheduler = if self.chooser.is_some() { Scheduler::Progress } else { Scheduler::Permissive };
        let (words, analysis) = (self.words(), self.analysis);
        let mut unfolding = Unfolding::new(&mut self.strategy, starts, scheduler, limit)?;
        let mut number = 0;
        while let Some(Node { at, next }) = unfolding.next_node()? {
            if !unfolding.complete {
                return Err(Limit::Listed(limit as u64).into());
            }
            let rank = |kind| analysis.rank(kind, &at.state);
            let attains = self.chooser.as_ref().and_then(|rule| rule.attained(&at.state));
            each(&StateReport {
                words,
                ranks: [rank(Kind::Sasi)?, rank(Kind::Spi)?],
                choosing: self.choosing.clone(),
                attains: attains.as_ref().map(Attains::new),
                unfolded: None,
                cycle: None,
                place: Some(Place { node: number, is_start: number < starts.len(), next }),
                at,
            })?;
            number += 1;
        }
        Ok(())
    }

    /// Draws the paths from some states under the permissive strategy, as a graph in the language DOT with at most `limit`
    /// nodes. Returns it with whether it is complete.
    ///
    /// # Errors
    /// A command has no meaning in a state; a limit is reached.
    pub fn graph(&mut self, states: &[State], limit: usize) -> Result<(String, bool)> {
        let unfolded = InducedModel::unfold(&mut self.strategy, states, Scheduler::Permissive, limit)?;
        Ok((strategy_table::dot(self.words(), &unfolded, states.len()), unfolded.complete))
    }
}

/// Refuses a scope with more states than the limit.
///
/// # Errors
/// [`Limit::Size`] with the number of states.
pub fn refuse_more(count: &Count, limit: usize) -> Result<()> {
    if *count <= Count::from(limit) {
        return Ok(());
    }
    let grouped = Number(count.clone()).grouped();
    let what = format!(
        "the scope has {grouped} states, more than `--limit {limit}`; `--limit {count}` or more covers all"
    );
    Err(Limit::Size { what }.into())
}
