//! Layers: the states of a region in an order that leads to its goal.
//!
//! Layers by distance are many, and in a product of modules each of them mixes the moves of all
//! modules. Here a layer has all states that lead to earlier layers by steps of one trend: it is a
//! fixpoint, as cheap as the region itself. Falling and rising steps take turns, and together they
//! are all steps, so there are at most twice as many layers as distances.

use super::Named;
use meliora_base::error::Result;
use meliora_engine::edge_labels::{dropped, kept_into};
use meliora_engine::symbolic::{ChoiceSet, Side, StateSet, SymbolicEngine};
use meliora_engine::{Algebra, EdgeLabels, Engine};
use meliora_model::region::RegionName;
use meliora_model::trend::{Digit, Trend};

/// An engine, with the engines that have only its falling or rising edges.
pub(super) struct Trends {
    /// The order of the variables that defines the trends.
    pub(super) order: Vec<Digit>,
    engines: [(Trend, SymbolicEngine); 2],
    /// The trends of rounds, if they have their own. In layers of a game we choose the steps that lead on, in
    /// rounds the opponent does. Without an opponent, each choice needs one step in rounds.
    rounds: Option<Box<Trends>>,
    /// True if these are trends of rounds alone.
    pub(super) is_apart: bool,
}

/// Layers of a game up to this one are all closed by a trend.
const FIRST_TRIED: usize = 6;

/// Layers or rounds, each with the trend of the steps inside it that count.
pub(super) type Proof = Vec<(StateSet, Option<Trend>)>;

impl Trends {
    pub(super) fn new(engine: &SymbolicEngine) -> Result<Self> {
        let order = match engine.theirs() {
            Some(_) => Some(engine.falling_order(Side::Opponent)?),
            None => engine.order_of_falling_choices()?,
        };
        let rounds = order.map(|order| Trends::of_order(engine, order, true)).transpose()?.map(Box::new);
        let order = engine.falling_order(Side::We)?;
        Ok(Trends { rounds, ..Trends::of_order(engine, order, false)? })
    }

    fn of_order(engine: &SymbolicEngine, order: Vec<Digit>, is_apart: bool) -> Result<Self> {
        let [falling, rising] = Trend::ALL.map(|trend| engine.with_trend(&order, trend));
        let engines = [(Trend::Falling, falling?), (Trend::Rising, rising?)];
        Ok(Trends { order, engines, rounds: None, is_apart })
    }

    /// Returns the trends of rounds.
    pub(super) fn of_rounds(&self) -> &Self {
        self.apart().unwrap_or(self)
    }

    /// Returns the trends of rounds, if rounds have an order of their own.
    pub(super) fn apart(&self) -> Option<&Self> {
        self.rounds.as_deref()
    }

    /// Returns the engines with their trends.
    pub(super) fn all(&self) -> &[(Trend, SymbolicEngine); 2] {
        &self.engines
    }

    /// Returns the engines of a game in which we choose for all players.
    pub(super) fn of_all_players(&self) -> Result<Self> {
        let [falling, rising] = self.engines.each_ref().map(|(_, by)| of_all_players(by));
        let engines = [(Trend::Falling, falling?), (Trend::Rising, rising?)];
        Ok(Trends { order: self.order.clone(), engines, rounds: None, is_apart: false })
    }

    /// Computes the layers of the states that are reached from the start states of paths.
    pub(super) fn forward(&self, engine: &SymbolicEngine, start: StateSet) -> Result<Proof> {
        let step = |reached: &StateSet| engine.post(&engine.choices_in(&engine.all_choices(), reached)?);
        self.grow(engine, start, |by, reached| by.reached_from(reached), step)
    }

    /// Computes the layers of the states that reach a target by the given choices.
    pub(super) fn backward(
        &self,
        engine: &SymbolicEngine,
        target: &StateSet,
        within: &ChoiceSet,
    ) -> Result<Proof> {
        self.towards(engine, target, &engine.no_choices(), within, &[])
    }

    /// Computes the layers of the states that reach a target by the given choices, or take one of the
    /// winning ones on the way. The target has the states in which we can take a winning choice.
    ///
    /// In a game, the choices of one state of the opponent may lead on by steps of different trends.
    /// There, a layer has also all steps into earlier layers.
    pub(super) fn towards(
        &self,
        engine: &SymbolicEngine,
        target: &StateSet,
        winning: &ChoiceSet,
        within: &ChoiceSet,
        edge_labels: &[EdgeLabels<StateSet>],
    ) -> Result<Proof> {
        let dropped = dropped(engine, edge_labels)?;
        if engine.theirs().is_none() {
            let close = |by: &SymbolicEngine, reached: &StateSet| by.can_reach(reached, within, edge_labels);
            let step = |reached: &StateSet| engine.sources(&kept_into(engine, within, &dropped, reached)?);
            return self.grow(engine, target.clone(), close, step);
        }
        if engine.is_empty(target)? {
            return Ok(Vec::new());
        }
        let (mut reached, mut layers) = (target.clone(), vec![(target.clone(), None)]);
        loop {
            let earlier = engine.union(winning, &kept_into(engine, within, &dropped, &reached)?)?;
            let near = engine.difference(&engine.can_choose(&earlier)?, &reached)?;
            if engine.is_empty(&near)? {
                // Then no step of a trend leads on, either: paths of such steps end.
                return Ok(layers);
            }
            let trend = self.tried(layers.len());
            let layer = match trend {
                Some((_, by)) => engine.difference(&by.can_win(&earlier, within, edge_labels)?, &reached)?,
                None => near,
            };
            reached = engine.union(&reached, &layer)?;
            layers.push((layer, trend.map(|(trend, _)| *trend)));
        }
    }

    /// Returns the trend by which a layer or round of a game is closed; `None` if it has only steps into
    /// earlier ones. Where the players move back and forth, trends shorten little, and each costs a
    /// fixpoint. So they are tried in the first layers, and then more and more rarely.
    pub(super) fn tried(&self, number: usize) -> Option<&(Trend, SymbolicEngine)> {
        let is_tried = number <= FIRST_TRIED || number.is_power_of_two() || (number - 1).is_power_of_two();
        is_tried.then(|| &self.engines[number % 2])
    }

    /// Closes a set under the steps of both trends, one after the other, until nothing is new. In a
    /// game some steps have neither trend; `step` then adds those of one step.
    fn grow(
        &self,
        engine: &SymbolicEngine,
        start: StateSet,
        close: impl Fn(&SymbolicEngine, &StateSet) -> Result<StateSet>,
        step: impl Fn(&StateSet) -> Result<StateSet>,
    ) -> Result<Proof> {
        if engine.is_empty(&start)? {
            return Ok(Vec::new());
        }
        let (mut reached, mut unchanged) = (start.clone(), 0);
        let mut layers = vec![(start, None)];
        for (trend, by) in self.engines.iter().cycle() {
            let is_closed = unchanged > 1;
            if is_closed && !engine.is_game() {
                break;
            }
            let more = if is_closed { step(&reached)? } else { close(by, &reached)? };
            let layer = engine.difference(&more, &reached)?;
            unchanged += 1;
            if !engine.is_empty(&layer)? {
                layers.push((layer, (!is_closed).then_some(*trend)));
                reached = engine.union(&reached, &more)?;
                unchanged = usize::from(!is_closed);
            } else if is_closed {
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
pub(super) fn layers(named: &mut Vec<Named>, region: &RegionName, sets: Proof) {
    named.extend(sets.into_iter().enumerate().map(|(j, (x, trend))| Named::proof(region.layer(j), x, trend)));
}

/// Names the rounds of a region.
pub(super) fn rounds(named: &mut Vec<Named>, region: &RegionName, sets: Proof) {
    named.extend(sets.into_iter().enumerate().map(|(j, (x, trend))| Named::proof(region.round(j), x, trend)));
}
