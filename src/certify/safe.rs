//! Checks of the states from which a strategy avoids bad states forever, and of the requirements.

use super::checker::Checker;
use super::condition::Condition;
use super::error::CheckResult;
use meliora_engine::symbolic::{ChoiceSet, StateSet};
use meliora_engine::{Algebra, Engine, Region};
use meliora_model::region::RegionName;

/// Bad states, and the region that says from where they are avoided.
pub(super) struct Avoided<'a> {
    /// The region whose rounds are in the certificate.
    pub(super) name: &'a RegionName,
    /// The bad states.
    pub(super) bad: &'a StateSet,
}

impl Avoided<'_> {
    /// Checks that `safe` are the states from which a strategy avoids the bad states forever.
    /// Returns the choices that stay in it.
    ///
    /// Inside: no state is bad, and each has a choice that stays in `safe`. Outside: each state
    /// removed in a round is bad, or each of its choices may lead to a state removed earlier or, by
    /// a step of the round's trend, to one of the round.
    pub(super) fn check(
        &self,
        checker: &Checker<'_>,
        safe: &StateSet,
        condition: Condition,
    ) -> CheckResult<ChoiceSet> {
        let (engine, name) = (&checker.engine, self.name);
        checker.subset(&engine.intersection(safe, self.bad)?, &engine.no_states(), condition)?;
        let staying = engine.choices_in(&engine.pre_within(&engine.all_choices(), safe)?, safe)?;
        let condition = Condition::StaysIn { region: name.clone() };
        checker.subset(safe, &engine.can_choose(&staying)?, condition)?;
        let left = checker.rounds(name, &engine.all_states(), &|round| {
            let choices = engine.choices_in(&engine.all_choices(), round.lost)?;
            let mut staying = engine.pre_within(&choices, round.left)?;
            if let Some(within) = round.within {
                staying = engine.difference(&staying, &within.pre(&staying, round.lost)?)?;
            }
            let condition = Condition::RoundAvoided { round: round.number, region: name.clone() };
            let saved = engine.difference(&engine.can_choose(&staying)?, self.bad)?;
            checker.subset(&saved, &engine.no_states(), condition)
        })?;
        checker.subset(&left, safe, Condition::OutsideLost { region: name.clone() })?;
        Ok(staying)
    }
}

/// Checks the unsafe states of the requirements, and restricts the engine to the others: all later
/// checks are about the restricted model.
pub(super) fn requirements(checker: &mut Checker<'_>) -> CheckResult {
    let requirements = &checker.preferences.requirements;
    if requirements.is_empty() {
        return Ok(());
    }
    let engine = &checker.engine;
    let all = engine.all_states();
    let mut bad = engine.no_states();
    for requirement in requirements {
        let violated = engine.difference(&all, &engine.states_where(&requirement.kept)?)?;
        bad = engine.union(&bad, &violated)?;
    }
    let states = engine.difference(&all, &checker.regions.states(&RegionName::Unsafe)?)?;
    let avoided = Avoided { name: &RegionName::Unsafe, bad: &bad };
    let choices = avoided.check(checker, &states, Condition::HasViolations)?;
    checker.engine = checker.engine.restricted_to(&Region { states, choices })?;
    checker.passed(&RegionName::Unsafe);
    Ok(())
}
