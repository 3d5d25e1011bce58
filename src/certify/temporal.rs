//! Checks of the regions `secured:A:d`, for objectives over whole paths.
//!
//! The monitors run in product with the model. A formula in disjunctive normal form has cases d.
//! Case d requires that from some step on certain marks stay on or off in all steps (P_d are the
//! states that satisfy this), and that other marks (R_d1, …, R_dm) recur infinitely often. U_d is
//! the set of states from which some strategy satisfies both almost surely from now on.
//!
//! Inside: each state has a choice that stays in U_d ⊆ P_d, and under such choices layers lead to
//! each R_di. The strategy that takes them all at random never leaves U_d, and almost surely visits
//! each R_di infinitely often.
//!
//! Outside: consider a state of P_d that is removed in a round. In a round with a trend, each of
//! its choices may lead to a state removed earlier, or by a step of the trend to one of the round.
//! In any other round, each of its choices may lead to a state removed earlier, or stays in the
//! round; and for some R_di, no state of the round in R_di has a choice of the second sort. So no
//! removed state can be in U_d: the first round with one would contain paths that stay in the round
//! and never visit R_di. Without any R_di, all states count as one.

use super::checker::Checker;
use super::condition::Condition;
use super::error::CheckResult;
use meliora_engine::symbolic::{ChoiceSet, StateSet};
use meliora_engine::{Algebra, Engine};
use meliora_model::region::RegionName;
use meliora_model::temporal::{Condition as Temporal, Disjunct};

/// Checks the region of each disjunct of a condition; returns ⋃_d U_d.
pub(super) fn secured(
    checker: &mut Checker<'_>,
    objective: &str,
    condition: &Temporal,
) -> CheckResult<StateSet> {
    let mut all = checker.engine.no_states();
    for (case, disjunct) in condition.disjuncts()?.iter().enumerate() {
        let secured =
            SecuredRegion::new(checker, RegionName::Secured(objective.to_owned(), case + 1), disjunct)?;
        secured.inside(checker)?;
        secured.outside(checker)?;
        all = checker.engine.union(&all, &secured.region)?;
        checker.passed(&secured.name);
        checker.passed(&secured.name.strategy());
    }
    Ok(all)
}

/// U_d, with the conditions that it must satisfy.
struct SecuredRegion {
    name: RegionName,
    region: StateSet,
    /// The choices that stay in it.
    strategy: ChoiceSet,
    /// P_d
    allowed: StateSet,
    /// R_d1, …, R_dm
    again: Vec<StateSet>,
}

impl SecuredRegion {
    fn new(checker: &Checker<'_>, name: RegionName, disjunct: &Disjunct) -> CheckResult<Self> {
        let engine = &checker.engine;
        let mut allowed = engine.all_states();
        for (mark, sign) in &disjunct.always {
            let marked = engine.states_where(mark)?;
            let wrong = if *sign { engine.difference(&engine.all_states(), &marked)? } else { marked };
            allowed = engine.difference(&allowed, &wrong)?;
        }
        let again = disjunct.again.iter().map(|mark| engine.states_where(mark));
        let again = again.collect::<Result<_, _>>()?;
        let region = checker.regions.states(&name)?;
        let strategy = checker.regions.choices(&name.strategy())?;
        Ok(SecuredRegion { name, region, strategy, allowed, again })
    }

    fn inside(&self, checker: &Checker<'_>) -> CheckResult {
        let (engine, name) = (&checker.engine, &self.name);
        let condition = Condition::Always { region: name.clone() };
        checker.subset(&self.region, &self.allowed, condition)?;
        let staying =
            engine.choices_in(&engine.pre_within(&engine.all_choices(), &self.region)?, &self.region)?;
        let condition = Condition::StayingChoices { region: name.clone() };
        checker.equal_choices(&self.strategy, &staying, condition)?;
        let condition = Condition::StaysIn { region: name.clone() };
        checker.subset(&self.region, &engine.can_choose(&staying)?, condition)?;
        for (index, mark) in self.again.iter().enumerate() {
            let start = engine.intersection(mark, &self.region)?;
            checker.leading_to(&name.recurring(index + 1), &self.region, &start, &staying)?;
        }
        Ok(())
    }

    fn outside(&self, checker: &Checker<'_>) -> CheckResult {
        let (engine, name) = (&checker.engine, &self.name);
        let left = checker.rounds(name, &engine.all_states(), &|round| {
            let j = round.number;
            let open = engine.intersection(round.lost, &self.allowed)?;
            let safe = engine.pre_within(&engine.choices_in(&engine.all_choices(), &open)?, round.left)?;
            let saved = match round.within {
                Some(within) => engine.difference(&safe, &within.pre(&safe, round.lost)?)?,
                None => engine.pre(&safe, round.rest)?,
            };
            let condition = Condition::RoundSafeStep { round: j, region: name.clone() };
            checker.subset(&engine.can_choose(&saved)?, &engine.no_states(), condition)?;
            if round.within.is_some() {
                return Ok(());
            }
            let moving = engine.can_choose(&safe)?;
            for mark in &self.again {
                if engine.is_empty(&engine.intersection(mark, &moving)?)? {
                    return Ok(());
                }
            }
            let condition = Condition::RoundAgain { round: j, region: name.clone() };
            checker.subset(&moving, &engine.no_states(), condition)
        })?;
        checker.subset(&left, &self.region, Condition::OutsideLost { region: name.clone() })
    }
}
