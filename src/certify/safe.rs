//! Checks of the states from which a strategy avoids bad states forever, and of the requirements.

use super::checker::Checker;
use super::error::CheckResult;
use meliora_engine::symbolic::{ChoiceSet, StateSet};
use meliora_engine::{Algebra, Engine, Region};
use meliora_model::region::RegionName;

/// Bad states, and the words for them and for the states from which they are avoided.
pub(super) struct Avoided<'a> {
    /// The region whose rounds are in the certificate.
    pub(super) name: &'a RegionName,
    /// The states from which a strategy avoids the bad states, in words.
    pub(super) safe: &'a str,
    /// The bad states.
    pub(super) bad: &'a StateSet,
    /// A verb for a bad state.
    pub(super) does: &'a str,
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
        condition: impl FnOnce() -> String,
    ) -> CheckResult<ChoiceSet> {
        let (engine, name) = (&checker.engine, self.name);
        checker.subset(&engine.intersection(safe, self.bad)?, &engine.no_states(), condition)?;
        let staying = engine.choices_in(&engine.pre_within(&engine.all_choices(), safe)?, safe)?;
        let condition = || format!("each state of {} has a choice that stays in it", self.safe);
        checker.subset(safe, &engine.can_choose(&staying)?, condition)?;
        let left = checker.rounds(name, &engine.all_states(), |round| {
            let choices = engine.choices_in(&engine.all_choices(), round.lost)?;
            let mut staying = engine.pre_within(&choices, round.left)?;
            if let Some(within) = round.within {
                staying = engine.difference(&staying, &within.pre(&staying, round.lost)?)?;
            }
            let condition = || {
                let (j, does) = (round.number, self.does);
                format!("each state lost in round {j} of `{name}` {does}, or must risk an earlier round")
            };
            let saved = engine.difference(&engine.can_choose(&staying)?, self.bad)?;
            checker.subset(&saved, &engine.no_states(), condition)
        })?;
        checker
            .subset(&left, safe, || format!("each state outside of {} is lost in some round", self.safe))?;
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
    let condition = || "each state that violates a requirement is in `unsafe`".to_string();
    let (safe, does) = ("the complement of `unsafe`", "violates a requirement");
    let avoided = Avoided { name: &RegionName::Unsafe, safe, bad: &bad, does };
    let choices = avoided.check(checker, &states, condition)?;
    checker.engine = checker.engine.restricted_to(&Region { states, choices })?;
    checker.passed(&RegionName::Unsafe);
    Ok(())
}
