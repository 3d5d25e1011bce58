//! The qualitative regions of one temporal operator over sets of states: `X T` and `B U T`, with bounds
//! on the number of steps, under strategies and on paths.

use super::engine::{Engine, Region};
use super::regions::Which;
use meliora_base::error::Result;

/// The bounds on the number of steps of an until.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Bounds {
    /// The least number.
    pub least: u64,
    /// The greatest number; `None` without a bound.
    pub most: Option<u64>,
}

/// A formula over sets of states: `B U T`. Clones share the sets.
#[derive(Debug)]
pub struct Until<'s, S> {
    /// B
    pub through: &'s S,
    /// T
    pub target: &'s S,
    /// Bounds on the number of steps.
    pub bounds: Bounds,
}

impl<S> Clone for Until<'_, S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S> Copy for Until<'_, S> {}

/// Computes the states of a region of `X T`: those from which one step enters T so. Cost: one image.
///
/// # Errors
/// A limit of the engine is reached.
pub fn next<E: Engine>(engine: &E, which: Which, target: &E::States) -> Result<E::States> {
    let (all, choices) = (engine.all_states(), engine.all_choices());
    let outside = || engine.difference(&all, target);
    match which {
        Which::PmaxPositive => engine.can_choose(&engine.pre(&choices, target)?),
        Which::PmaxOne => engine.can_choose(&engine.pre_within(&choices, target)?),
        Which::PminPositive => {
            engine.difference(&all, &engine.can_choose(&engine.pre_within(&choices, &outside()?)?)?)
        }
        Which::PminOne => engine.difference(&all, &engine.can_choose(&engine.pre(&choices, &outside()?)?)?),
    }
}

/// Computes the states of a region of `B U T`. Cost: a backward fixpoint, and one image per step of the
/// bounds at most.
///
/// # Errors
/// A limit of the engine is reached.
pub fn until<E: Engine>(engine: &E, which: Which, formula: Until<'_, E::States>) -> Result<E::States> {
    stepwise(engine, formula, |x| next(engine, which, x), || unbounded(engine, which, formula))
}

/// Computes { s : every path of s satisfies `B U T` } if `all` is true, else { s : some path does }. Cost:
/// one image per step.
///
/// # Errors
/// A limit of the engine is reached.
pub fn until_on_paths<E: Engine>(engine: &E, all: bool, formula: Until<'_, E::States>) -> Result<E::States> {
    let step = |x: &E::States| next_on_paths(engine, all, x);
    stepwise(engine, formula, step, || {
        let unlimited = Until { bounds: Bounds { least: 0, most: Some(u64::MAX) }, ..formula };
        stepwise(engine, unlimited, step, || Ok(formula.target.clone()))
    })
}

/// Computes { s : every step of s enters T } if `all` is true, else { s : some step does }. Cost: one image.
///
/// # Errors
/// A limit of the engine is reached.
pub fn next_on_paths<E: Engine>(engine: &E, all: bool, target: &E::States) -> Result<E::States> {
    let states = engine.all_states();
    let some = |x: &E::States| engine.sources(&engine.pre(&engine.all_choices(), x)?);
    match all {
        false => some(target),
        true => engine.difference(&states, &some(&engine.difference(&states, target)?)?),
    }
}

/// Goes back step by step: X = T ∪ (B ∩ step(X)) while the target may come, from T or from the region
/// without bounds, and then X = B ∩ step(X) for the least number of steps. Ends early when nothing changes.
fn stepwise<E: Engine>(
    engine: &E,
    Until { through, target, bounds }: Until<'_, E::States>,
    step: impl Fn(&E::States) -> Result<E::States>,
    unbounded: impl FnOnce() -> Result<E::States>,
) -> Result<E::States> {
    let mut states = match bounds.most {
        None => unbounded()?,
        Some(_) => target.clone(),
    };
    for _ in bounds.least..bounds.most.unwrap_or(bounds.least) {
        let before = engine.intersection(through, &step(&states)?)?;
        let next = engine.union(target, &before)?;
        if engine.same(&next, &states)? {
            break;
        }
        states = next;
    }
    for _ in 0..bounds.least {
        let next = engine.intersection(through, &step(&states)?)?;
        if engine.same(&next, &states)? {
            break;
        }
        states = next;
    }
    Ok(states)
}

/// Computes a region of `B U T` without bounds on the number of steps.
fn unbounded<E: Engine>(engine: &E, which: Which, formula: Until<'_, E::States>) -> Result<E::States> {
    let Until { through, target, .. } = formula;
    let own = engine.choices_in(&engine.all_choices(), &engine.difference(through, target)?)?;
    match which {
        Which::PmaxPositive => engine.can_reach(target, &own, &[]),
        Which::PmaxOne => Ok(engine.almost_surely_reach(target, &own)?.states),
        Which::PminPositive if engine.is_markov_chain() => unbounded(engine, Which::PmaxPositive, formula),
        Which::PminOne if engine.is_markov_chain() => unbounded(engine, Which::PmaxOne, formula),
        Which::PminPositive => engine.difference(&engine.all_states(), &avoiding(engine, formula)?),
        Which::PminOne => match engine.exchanged()? {
            Some(opponent) => unbounded(&opponent, Which::PmaxOne, formula),
            None => {
                let losing = engine.can_reach(&avoiding(engine, formula)?, &own, &[])?;
                engine.difference(&engine.all_states(), &losing)
            }
        },
    }
}

/// Computes the states from which we surely avoid `B U T`: νZ. { s ∉ T : s ∉ B, or we can choose a pair
/// with all successors in Z }.
fn avoiding<E: Engine>(engine: &E, formula: Until<'_, E::States>) -> Result<E::States> {
    let Until { through, target, .. } = formula;
    let outside = engine.difference(&engine.all_states(), target)?;
    let over = engine.difference(&outside, through)?;
    let own = engine.choices_in(&engine.all_choices(), &engine.intersection(&outside, through)?)?;
    let left = Region { states: outside, choices: own.clone() };
    Ok(engine.remove_attractor(left, &own, &over, &[], target.clone())?.states)
}
