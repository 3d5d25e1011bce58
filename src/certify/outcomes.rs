//! Checks of targets, positive and almost-sure regions, and classes.

use super::checker::{Checker, Round};
use super::condition::Condition;
use super::error::CheckResult;
use super::temporal;
use meliora_engine::symbolic::StateSet;
use meliora_engine::{Algebra, Engine};
use meliora_model::preference::{Goal, ObjectiveSet};
use meliora_model::region::{NOTHING, RegionName, members as members_of};

/// The states with the same most preferred objectives.
pub(super) struct Class {
    /// `A+B`, or `nothing`.
    pub(super) name: String,
    /// The most preferred objectives.
    pub(super) members: ObjectiveSet,
    /// The states of the class; at least one.
    pub(super) states: StateSet,
}

/// Checks the winning regions of all objectives; returns the classes. Returns `None` if the certificate
/// leaves out an objective: then nothing shows the classes.
pub(super) fn check(checker: &mut Checker<'_>) -> CheckResult<Option<Vec<Class>>> {
    let mut sure = Vec::new();
    for objective in &checker.preferences.objectives {
        if checker.lacks(|name| name.is_of_objective(&objective.name)) {
            continue;
        }
        let (target, is_secured) = match &objective.goal {
            Goal::Reach(target) => (checker.engine.states_where(target)?, false),
            Goal::Satisfy { condition, .. } => {
                (temporal::secured(checker, &objective.name, condition)?, true)
            }
        };
        let own = || objective.name.clone();
        let name = RegionName::Target(own());
        let condition = match is_secured {
            true => Condition::SecuredStates { region: name.clone() },
            false => Condition::TargetStates { region: name.clone() },
        };
        checker.equal(&checker.regions.states(&name)?, &target, condition)?;
        checker.passed(&name);
        positive(checker, &RegionName::Positive(own()), &target)?;
        sure.push(almost_sure(checker, &RegionName::AlmostSure(own()), &target)?);
    }
    if sure.len() < checker.preferences.objectives.len() {
        return Ok(None);
    }
    classes(checker, &sure).map(Some)
}

/// Checks P = μX. F ∪ pre(X): no choice enters P from outside, and inside layers lead to F.
fn positive(checker: &mut Checker<'_>, region: &RegionName, target: &StateSet) -> CheckResult {
    let engine = &checker.engine;
    let x = checker.regions.states(region)?;
    checker.subset(target, &x, Condition::HasTarget { region: region.clone() })?;
    let entering = engine.can_choose(&engine.pre(&engine.all_choices(), &x)?)?;
    checker.subset(&entering, &x, Condition::HasSteps { region: region.clone() })?;
    checker.leading_to(region, &x, target, &engine.all_choices())?;
    checker.passed(region);
    Ok(())
}

/// Checks an almost-sure region, and returns it. Inside: the strategy stays in it, and under it
/// each layer leads to an earlier one. Outside: each choice of a state removed in a round may lead
/// to a state removed earlier, or does not enter the rest; in a round with a trend, it may lead to
/// a state removed earlier, or by a step of the trend to one of the round.
fn almost_sure(checker: &mut Checker<'_>, region: &RegionName, target: &StateSet) -> CheckResult<StateSet> {
    let engine = &checker.engine;
    let x = checker.regions.states(region)?;
    checker.subset(target, &x, Condition::HasTarget { region: region.clone() })?;
    let staying =
        engine.choices_in(&engine.pre_within(&engine.all_choices(), &x)?, &engine.difference(&x, target)?)?;
    let strategy = region.strategy();
    let condition = Condition::StayingChoices { region: region.clone() };
    checker.equal_choices(&checker.regions.choices(&strategy)?, &checker.ours(&staying)?, condition)?;
    checker.leading_to(region, &x, target, &staying)?;
    let left = checker.rounds(region, &engine.all_states(), &|round| {
        let &Round { number, lost, .. } = round;
        let condition = Condition::RoundTarget { round: number, region: region.clone() };
        checker.subset(&engine.intersection(lost, target)?, &engine.no_states(), condition)?;
        let safe = engine.pre_within(&engine.choices_in(&engine.all_choices(), lost)?, round.left)?;
        let saved = match round.within {
            Some(within) => engine.difference(&safe, &within.pre(&safe, lost)?)?,
            None => engine.pre(&safe, round.rest)?,
        };
        let condition = Condition::RoundSafeStep { round: number, region: region.clone() };
        checker.subset(&engine.can_choose(&saved)?, &engine.no_states(), condition)
    })?;
    checker.subset(&left, &x, Condition::OutsideLost { region: region.clone() })?;
    checker.passed(region);
    checker.passed(&strategy);
    Ok(x)
}

/// Checks that each class is in the dump, with the states that follow from the almost-sure regions.
fn classes(checker: &mut Checker<'_>, sure: &[StateSet]) -> CheckResult<Vec<Class>> {
    let classes = most_preferred(checker, sure)?;
    for class in &classes {
        let name = RegionName::Class(class.name.clone());
        let condition = Condition::ClassStates { region: name.clone() };
        checker.equal(&checker.regions.states(&name)?, &class.states, condition)?;
        checker.passed(&name);
    }
    let nothing = RegionName::Class(NOTHING.to_owned());
    if !classes.iter().any(|c| c.members.is_empty()) {
        let condition = Condition::EmptyClass { region: nothing.clone() };
        checker.subset(&checker.regions.states(&nothing)?, &checker.engine.no_states(), condition)?;
        checker.passed(&nothing);
    }
    Ok(classes)
}

/// Partitions the states by MP(s), by splitting the scope at one objective after the other: i ∈
/// MP(s) if and only if s ∈ ASWin(F_i) and s ∉ ASWin(F_j) for all j strictly preferred to i.
fn most_preferred(checker: &Checker<'_>, sure: &[StateSet]) -> CheckResult<Vec<Class>> {
    let (engine, preferences) = (&checker.engine, checker.preferences);
    let mut parts = vec![(ObjectiveSet::new(), engine.all_states())];
    for (i, own) in sure.iter().enumerate() {
        let mut undominated = own.clone();
        for (j, above) in sure.iter().enumerate() {
            if preferences.order.strictly(j, i) {
                undominated = engine.difference(&undominated, above)?;
            }
        }
        let mut split = Vec::new();
        for (without, states) in parts {
            let mut with = without.clone();
            with.insert(i);
            for part in [
                (with, engine.intersection(&states, &undominated)?),
                (without, engine.difference(&states, &undominated)?),
            ] {
                if !engine.is_empty(&part.1)? {
                    split.push(part);
                }
            }
        }
        parts = split;
    }
    let named = |(members, states)| Class { name: members_of(&preferences.names(&members)), members, states };
    Ok(parts.into_iter().map(named).collect())
}
