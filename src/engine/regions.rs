//! The four qualitative regions of one target.

use serde::Serialize;
use strum::IntoStaticStr;

use super::engine::Engine;
use meliora_base::error::{Error, Result};
use meliora_model::property::{Bound, Strategies};

/// The regions of a target T as sets of states, or something for each of them: a size, for example.
///
/// In a game, those of `pmax` hold against every strategy of the opponent; those of `pmin` hold if the
/// opponent has a strategy with which they hold against every strategy of ours.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct Regions<S> {
    /// Some strategy reaches T with probability one.
    pub pmax_one: S,
    /// Some strategy reaches T with positive probability.
    pub pmax_positive: S,
    /// Every strategy reaches T with probability one.
    pub pmin_one: S,
    /// Every strategy reaches T with positive probability.
    pub pmin_positive: S,
}

impl<S> Regions<Option<S>> {
    /// Returns a region.
    ///
    /// # Errors
    /// [`Error::Usage`] if it is not known.
    pub fn known(&self, which: Which) -> Result<&S> {
        let unknown = || Error::Usage(format!("the region {} is not known", which.name()));
        self.get(which).as_ref().ok_or_else(unknown)
    }

    /// Returns whether there is a region.
    pub fn any(&self) -> bool {
        Which::ALL.into_iter().any(|which| self.get(which).is_some())
    }
}

impl<S> Regions<S> {
    /// Returns the region of a name.
    pub fn get(&self, which: Which) -> &S {
        match which {
            Which::PmaxPositive => &self.pmax_positive,
            Which::PmaxOne => &self.pmax_one,
            Which::PminPositive => &self.pmin_positive,
            Which::PminOne => &self.pmin_one,
        }
    }

    /// Returns the region of a name.
    pub fn get_mut(&mut self, which: Which) -> &mut S {
        match which {
            Which::PmaxPositive => &mut self.pmax_positive,
            Which::PmaxOne => &mut self.pmax_one,
            Which::PminPositive => &mut self.pmin_positive,
            Which::PminOne => &mut self.pmin_one,
        }
    }

    /// Converts each region.
    pub fn map<T>(self, mut convert: impl FnMut(S) -> T) -> Regions<T> {
        Regions {
            pmax_one: convert(self.pmax_one),
            pmax_positive: convert(self.pmax_positive),
            pmin_one: convert(self.pmin_one),
            pmin_positive: convert(self.pmin_positive),
        }
    }
}

/// Computes { s : Pmax(◇T) > 0 } = μX. T ∪ { s : some a has succ(s,a) ∩ X ≠ ∅ }. Cost: one backward
/// fixpoint.
pub fn pmax_positive<E: Engine>(engine: &E, target: &E::States) -> Result<E::States> {
    engine.can_reach(target, &engine.all_choices(), &[])
}

/// Computes { s : Pmax(◇T) = 1 } = νY. μX. T ∪ { s : some a has succ(s,a) ⊆ Y and succ(s,a) ∩ X ≠ ∅
/// }. Cost: one backward fixpoint per round, usually two rounds.
pub fn pmax_one<E: Engine>(engine: &E, target: &E::States) -> Result<E::States> {
    Ok(engine.almost_surely_reach(target, &engine.all_choices())?.states)
}

/// Computes { s : Pmin(◇T) > 0 } = S \ νZ. { s ∉ T : some a has succ(s,a) ⊆ Z }, the states from
/// which no strategy surely stays outside T. Cost: one fixpoint of pre-images.
pub fn pmin_positive<E: Engine>(engine: &E, target: &E::States) -> Result<E::States> {
    let outside = engine.difference(&engine.all_states(), target)?;
    let avoiding = engine.surely_staying(&outside, &engine.all_choices())?;
    engine.difference(&engine.all_states(), &avoiding)
}

/// Computes { s : Pmin(◇T) = 1 }: the states from which no strategy can reach, without visiting T,
/// a state where T can surely be avoided. `positive` must be the result of [`pmin_positive`] (Baier
/// and Katoen, section 10.6.2). Cost: one backward fixpoint.
///
/// In a game, that is [`pmax_one`] of the opponent: what remains has to be searched again after states
/// are lost, as the opponent cannot take every choice.
pub fn pmin_one<E: Engine>(engine: &E, target: &E::States, positive: &E::States) -> Result<E::States> {
    if let Some(opponent) = engine.exchanged()? {
        return pmax_one(&opponent, target);
    }
    let avoiding = engine.difference(&engine.all_states(), positive)?;
    let outside = engine.difference(&engine.all_states(), target)?;
    let losing = engine.can_reach_through(&avoiding, &outside)?;
    engine.difference(&engine.all_states(), &losing)
}

/// The names of the four regions, in the order of their usual cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
pub enum Which {
    /// Pmax > 0
    PmaxPositive,
    /// Pmax = 1
    PmaxOne,
    /// Pmin > 0
    PminPositive,
    /// Pmin = 1
    PminOne,
}

impl Which {
    /// All names, in their order.
    pub const ALL: [Which; 4] = [Which::PmaxPositive, Which::PmaxOne, Which::PminPositive, Which::PminOne];

    /// Returns whether the region is contained in another one, whatever the target is. In a game, what
    /// the opponent can enforce says nothing of what we can.
    fn is_within(self, other: Which, is_game: bool) -> bool {
        match (self, other) {
            (Which::PmaxOne, Which::PmaxPositive) | (Which::PminOne, Which::PminPositive) => true,
            (Which::PminOne, _) | (_, Which::PmaxPositive) => self == other || !is_game,
            _ => self == other,
        }
    }

    /// Returns the formula that the states of the region satisfy, for progress.
    pub fn formula(self) -> &'static str {
        match self {
            Which::PmaxPositive => "Pmax > 0",
            Which::PmaxOne => "Pmax = 1",
            Which::PminPositive => "Pmin > 0",
            Which::PminOne => "Pmin = 1",
        }
    }

    /// Returns the name in reports.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// Computes all four regions. Cost: that of [`pmax_positive`], [`pmax_one`], [`pmin_positive`] and
/// [`pmin_one`]; in a Markov chain, where Pmin = Pmax, that of the first two.
pub fn regions<E: Engine>(engine: &E, target: &E::States) -> Result<Regions<E::States>> {
    let (pmax_positive, pmax_one) = (pmax_positive(engine, target)?, pmax_one(engine, target)?);
    let (pmin_positive, pmin_one) = if engine.is_markov_chain() {
        (pmax_positive.clone(), pmax_one.clone())
    } else {
        let positive = pmin_positive(engine, target)?;
        let one = pmin_one(engine, target, &positive)?;
        (positive, one)
    };
    Ok(Regions { pmax_one, pmax_positive, pmin_one, pmin_positive })
}

/// Returns the region that decides a property, and whether the initial states must be inside or
/// outside.
pub fn deciding(strategies: Strategies, bound: Bound) -> (Which, bool) {
    match (strategies, bound) {
        (Strategies::Some, Bound::One) => (Which::PmaxOne, true),
        (Strategies::Some, Bound::Positive) => (Which::PmaxPositive, true),
        (Strategies::All, Bound::One) => (Which::PminOne, true),
        (Strategies::All, Bound::Positive) => (Which::PminPositive, true),
        // A property is true for every strategy if no strategy violates it, and vice versa.
        (Strategies::Some, Bound::BelowOne) => (Which::PminOne, false),
        (Strategies::Some, Bound::Zero) => (Which::PminPositive, false),
        (Strategies::All, Bound::BelowOne) => (Which::PmaxOne, false),
        (Strategies::All, Bound::Zero) => (Which::PmaxPositive, false),
    }
}

/// Returns whether a property is true in all initial states; `None` if the known regions do not
/// decide it. A region that contains the deciding one, or is contained in it, may decide, too.
///
/// # Errors
/// A limit is reached.
pub fn holds<E: Engine>(
    engine: &E,
    (strategies, bound): (Strategies, Bound),
    known: &Regions<Option<E::States>>,
) -> Result<Option<bool>> {
    let (deciding, inside) = deciding(strategies, bound);
    let (initial, is_game) = (engine.initial_states(), engine.is_game());
    for which in Which::ALL {
        let Some(region) = known.get(which) else { continue };
        let violating = match inside {
            true => engine.difference(&initial, region)?,
            false => engine.intersection(&initial, region)?,
        };
        let truth = engine.is_empty(&violating)?;
        let contains = deciding.is_within(which, is_game);
        let is_contained = which.is_within(deciding, is_game);
        if (contains && truth != inside) || (is_contained && truth == inside) {
            return Ok(Some(truth));
        }
    }
    Ok(None)
}
