//! The four qualitative regions of one target.

use serde::Serialize;
use strum::IntoStaticStr;

use super::engine::Engine;
use meliora_model::error::Result;
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

impl<S> Regions<S> {
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
    let choices = engine.choices_in(&engine.all_choices(), &outside)?;
    let losing = engine.can_reach(&avoiding, &choices, &[])?;
    engine.difference(&engine.all_states(), &losing)
}

/// The names of the four regions.
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
    /// Returns the name in reports.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// A step of the search for four regions, for a listener.
#[derive(Debug, Clone, Copy)]
pub enum Step<'a, S> {
    /// The search for a region begins.
    Begun(Which),
    /// The region is known.
    Found(Which, &'a S),
}

/// Computes all four regions. Cost: that of [`pmin_positive`], [`pmax_one`], [`pmax_positive`] and
/// [`pmin_one`].
pub fn regions<E: Engine>(engine: &E, target: &E::States) -> Result<Regions<E::States>> {
    regions_by_step(engine, target, &mut |_| Ok(()))
}

/// Computes all four regions, and tells the listener each step. The region Pmin > 0 is computed once
/// and used twice. In a Markov chain, Pmin = Pmax, so two regions are computed.
///
/// # Errors
/// The errors of [`regions`] and of the listener.
pub fn regions_by_step<E: Engine>(
    engine: &E,
    target: &E::States,
    listener: &mut dyn FnMut(Step<'_, E::States>) -> Result<()>,
) -> Result<Regions<E::States>> {
    listener(Step::Begun(Which::PmaxPositive))?;
    let pmax_positive = pmax_positive(engine, target)?;
    listener(Step::Found(Which::PmaxPositive, &pmax_positive))?;
    listener(Step::Begun(Which::PmaxOne))?;
    let pmax_one = pmax_one(engine, target)?;
    listener(Step::Found(Which::PmaxOne, &pmax_one))?;
    if engine.is_markov_chain() {
        return of_markov_chain(pmax_positive, pmax_one, listener);
    }
    listener(Step::Begun(Which::PminPositive))?;
    let pmin_positive = pmin_positive(engine, target)?;
    listener(Step::Found(Which::PminPositive, &pmin_positive))?;
    listener(Step::Begun(Which::PminOne))?;
    let pmin_one = pmin_one(engine, target, &pmin_positive)?;
    listener(Step::Found(Which::PminOne, &pmin_one))?;
    Ok(Regions { pmax_one, pmax_positive, pmin_one, pmin_positive })
}

/// Returns the four regions of a Markov chain: those of Pmin are those of Pmax. Cost: no image.
///
/// # Errors
/// The errors of the listener.
pub fn of_markov_chain<S: Clone>(
    positive: S,
    one: S,
    listener: &mut dyn FnMut(Step<'_, S>) -> Result<()>,
) -> Result<Regions<S>> {
    for (which, region) in [(Which::PminPositive, &positive), (Which::PminOne, &one)] {
        listener(Step::Begun(which))?;
        listener(Step::Found(which, region))?;
    }
    Ok(Regions {
        pmax_one: one.clone(),
        pmax_positive: positive.clone(),
        pmin_one: one,
        pmin_positive: positive,
    })
}

/// Returns whether a property with these regions is true in all initial states.
pub fn holds<E: Engine>(
    engine: &E,
    (strategies, bound): (Strategies, Bound),
    found: &Regions<E::States>,
) -> Result<bool> {
    let initial = engine.initial_states();
    let inside = |region| engine.difference(&initial, region);
    let outside = |region| engine.intersection(&initial, region);
    let violating = match (strategies, bound) {
        (Strategies::Some, Bound::One) => inside(&found.pmax_one),
        (Strategies::Some, Bound::Positive) => inside(&found.pmax_positive),
        (Strategies::All, Bound::One) => inside(&found.pmin_one),
        (Strategies::All, Bound::Positive) => inside(&found.pmin_positive),
        // A property is true for every strategy if no strategy violates it, and vice versa.
        (Strategies::Some, Bound::BelowOne) => outside(&found.pmin_one),
        (Strategies::Some, Bound::Zero) => outside(&found.pmin_positive),
        (Strategies::All, Bound::BelowOne) => outside(&found.pmax_one),
        (Strategies::All, Bound::Zero) => outside(&found.pmax_positive),
    };
    engine.is_empty(&violating?)
}
