//! Layers: the states of a region in an order that leads to its goal.
//!
//! Layers by distance are many, and in a product of modules each of them mixes the moves of all
//! modules. Here a layer has all states that lead to earlier layers by steps of one trend: it is a
//! fixpoint, as cheap as the region itself. Falling and rising steps take turns, and together they
//! are all steps, so there are at most twice as many layers as distances.

use super::Named;
use meliora_engine::edge_labels::{dropped, kept_into};
use meliora_engine::symbolic::{ChoiceSet, StateSet, SymbolicEngine};
use meliora_engine::{Algebra, EdgeLabels, Engine};
use meliora_model::error::Result;
use meliora_model::names;
use meliora_model::trend::{Digit, Trend};

/// An engine, with the engines that have only its falling or rising edges.
pub(super) struct Trends {
    /// The order of the variables that defines the trends.
    pub(super) order: Vec<Digit>,
    engines: [(Trend, SymbolicEngine); 2],
}

/// Layers or rounds, each with the trend of the steps inside it that count.
pub(super) type Proof = Vec<(StateSet, Option<Trend>)>;

impl Trends {
    pub(super) fn new(engine: &SymbolicEngine) -> Result<Self> {
        let order = engine.falling_order()?;
        let [falling, rising] = Trend::ALL.map(|trend| engine.with_trend(&order, trend));
        let engines = [(Trend::Falling, falling?), (Trend::Rising, rising?)];
        Ok(Trends { order, engines })
    }

    /// Returns the engines with their trends.
    pub(super) fn all(&self) -> &[(Trend, SymbolicEngine); 2] {
        &self.engines
    }

    /// Returns the engines of a game in which we choose for all players.
    pub(super) fn of_all_players(&self) -> Result<Self> {
        let [falling, rising] = self.engines.each_ref().map(|(_, by)| of_all_players(by));
        let engines = [(Trend::Falling, falling?), (Trend::Rising, rising?)];
        Ok(Trends { order: self.order.clone(), engines })
    }

    /// Computes the layers of the states that are reached from the start states of paths.
    pub(super) fn forward(&self, engine: &SymbolicEngine, start: StateSet) -> Result<Proof> {
        self.grow(engine, start, |by, reached| by.reached_from(reached))
    }

    /// Computes the layers of the states that reach a target by the given choices.
    pub(super) fn backward(
        &self,
        engine: &SymbolicEngine,
        target: &StateSet,
        within: &ChoiceSet,
    ) -> Result<Proof> {
        self.towards(engine, (target, &engine.no_choices()), within, &[])
    }

    /// Computes the layers of the states that reach a target by the given choices, or take one of the
    /// winning ones on the way. The target has the states in which we can take a winning choice.
    ///
    /// In a game, the choices of one state of the opponent may lead on by steps of different trends.
    /// There, a layer has also all steps into earlier layers.
    pub(super) fn towards(
        &self,
        engine: &SymbolicEngine,
        (target, winning): (&StateSet, &ChoiceSet),
        within: &ChoiceSet,
        edge_labels: &[EdgeLabels<StateSet>],
    ) -> Result<Proof> {
        let has_opponent = engine.theirs().is_some();
        self.grow(engine, target.clone(), |by, reached| {
            if !has_opponent {
                return by.can_reach(reached, within, edge_labels);
            }
            let earlier = kept_into(engine, within, &dropped(engine, edge_labels)?, reached)?;
            let winning = engine.union(winning, &earlier)?;
            engine.union(reached, &by.can_win(&winning, within, edge_labels)?)
        })
    }

    /// Closes a set under the steps of both trends, one after the other, until nothing is new.
    fn grow(
        &self,
        engine: &SymbolicEngine,
        start: StateSet,
        close: impl Fn(&SymbolicEngine, &StateSet) -> Result<StateSet>,
    ) -> Result<Proof> {
        if engine.is_empty(&start)? {
            return Ok(Vec::new());
        }
        let (mut reached, mut unchanged) = (start.clone(), 0);
        let mut layers = vec![(start, None)];
        for (trend, by) in self.engines.iter().cycle() {
            let more = close(by, &reached)?;
            let layer = engine.difference(&more, &reached)?;
            unchanged += 1;
            if !engine.is_empty(&layer)? {
                layers.push((layer, Some(*trend)));
                (reached, unchanged) = (more, 1);
            } else if unchanged > 1 {
                break;
            }
        }
        Ok(layers)
    }
}

/// Returns an engine of a game in which we choose for all players.
pub(super) fn of_all_players(engine: &SymbolicEngine) -> Result<SymbolicEngine> {
    engine.with_coalition(&vec![true; engine.coalition().len()])
}

/// Names the layers of a region.
pub(super) fn layers(named: &mut Vec<Named>, region: &str, sets: Proof) {
    named.extend(sets.into_iter().enumerate().map(|(j, set)| Named::proof(names::layer(region, j), set)));
}

/// Names the rounds of a region.
pub(super) fn rounds(named: &mut Vec<Named>, region: &str, sets: Proof) {
    named.extend(sets.into_iter().enumerate().map(|(j, set)| Named::proof(names::refuted(region, j), set)));
}
