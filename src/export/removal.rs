//! Rounds: the states outside of a region in an order that shows that they are lost.

use super::layers::{Proof, Trends};
use meliora_base::error::Result;
use meliora_engine::edge_labels::plain_edges_into;
use meliora_engine::symbolic::{ChoiceSet, StateSet, SymbolicEngine};
use meliora_engine::{Algebra, EdgeLabels, Engine, Region};

/// States that are removed in rounds.
pub(super) struct Removal<'a> {
    engine: &'a SymbolicEngine,
    trends: &'a Trends,
    edge_labels: &'a [EdgeLabels<StateSet>],
    /// States that are not lost if they have no choice left.
    won: StateSet,
    /// The states that are left.
    pub(super) left: StateSet,
    /// The choices that cannot step into a lost state.
    pub(super) choices: ChoiceSet,
    pub(super) rounds: Proof,
}

impl<'a> Removal<'a> {
    /// Creates the removal of states from all of an engine, with edges that are all plain.
    pub(super) fn new(engine: &'a SymbolicEngine, trends: &'a Trends) -> Self {
        let (left, choices, won) = (engine.all_states(), engine.all_choices(), engine.no_states());
        let trends = trends.of_rounds();
        Removal { engine, trends, edge_labels: &[], won, left, choices, rounds: Vec::new() }
    }

    /// Keeps states that are not lost if they have no choice left.
    pub(super) fn with_won(self, won: &StateSet) -> Self {
        Removal { won: won.clone(), ..self }
    }

    /// Continues with these states and choices, and with edge labels. All other states are lost.
    pub(super) fn within(
        mut self,
        states: &StateSet,
        choices: &ChoiceSet,
        edge_labels: &'a [EdgeLabels<StateSet>],
    ) -> Result<Self> {
        let others = self.engine.difference(&self.engine.all_states(), states)?;
        (self.left, self.choices, self.edge_labels) = (states.clone(), choices.clone(), edge_labels);
        self.withdraw(&others)?;
        self.choices = self.engine.choices_in(&self.choices, states)?;
        self.attract()?;
        Ok(self)
    }

    /// Removes lost states in one round, and in further rounds all states that must risk to enter
    /// them. Returns whether there are any.
    pub(super) fn remove(&mut self, lost: StateSet) -> Result<bool> {
        if self.engine.is_empty(&lost)? {
            return Ok(false);
        }
        self.left = self.engine.difference(&self.left, &lost)?;
        self.withdraw(&lost)?;
        self.rounds.push((lost, None));
        self.attract()?;
        Ok(true)
    }

    /// Removes the choices that may step into lost states.
    fn withdraw(&mut self, lost: &StateSet) -> Result<()> {
        let engine = self.engine;
        let gone = plain_edges_into(engine, &self.choices, self.edge_labels, lost)?;
        self.choices = engine.difference(&self.choices, &gone)?;
        Ok(())
    }

    /// Removes the states without a choice. Each round closes them under steps of one trend; if
    /// there are states without a choice after it, this continues with the other trend. In a game, later
    /// rounds have only these states; see [`Trends::tried`].
    fn attract(&mut self) -> Result<()> {
        let engine = self.engine;
        let in_game = engine.theirs().is_some();
        for (trend, by) in self.trends.all().iter().cycle() {
            let stuck = engine.difference(&self.left, &engine.can_choose(&self.choices)?)?;
            let stuck = engine.difference(&stuck, &self.won)?;
            if engine.is_empty(&stuck)? {
                break;
            }
            if in_game && self.trends.tried(self.rounds.len()).is_none() {
                self.left = engine.difference(&self.left, &stuck)?;
                self.withdraw(&stuck)?;
                self.rounds.push((stuck, None));
                continue;
            }
            // An order for the rounds of a model without an opponent is one in which each choice may fall.
            let at_once = self.trends.is_apart && !in_game;
            let all = if at_once { self.attracted_at_once(&stuck, by)? } else { None };
            let lost = all.map_or_else(|| self.attracted(by, &stuck), Ok)?;
            let alone = engine.same(&lost, &stuck)?;
            self.left = engine.difference(&self.left, &lost)?;
            self.withdraw(&lost)?;
            self.rounds.push((lost, (!alone).then_some(*trend)));
        }
        Ok(())
    }

    /// Returns the states without a choice, and those that they attract by the edges of an engine.
    fn attracted(&self, by: &SymbolicEngine, stuck: &StateSet) -> Result<StateSet> {
        let open = self.engine.difference(&self.left, stuck)?;
        let left = Region { states: open, choices: self.choices.clone() };
        let left = by.remove_attractor(left, &self.choices, &self.won, self.edge_labels, stuck.clone())?;
        self.engine.difference(&self.left, &left.states)
    }

    /// Returns all states that the states without a choice attract, if each choice of these states may fall
    /// into them or lost states. To check this takes one step. To search them by falling steps takes a fixpoint
    /// with fewer edges, which may be much harder than one with all edges.
    fn attracted_at_once(&self, stuck: &StateSet, by: &SymbolicEngine) -> Result<Option<StateSet>> {
        let engine = self.engine;
        let lost = self.attracted(engine, stuck)?;
        let own = engine.choices_in(&self.choices, &lost)?;
        let falling = plain_edges_into(by, &own, self.edge_labels, &lost)?;
        let others = engine.can_choose(&engine.difference(&own, &falling)?)?;
        Ok(engine.is_empty(&others)?.then_some(lost))
    }
}
