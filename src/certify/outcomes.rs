//! Targets, positive and almost-sure regions, classes.

use super::checker::{Check, Checker, Stop};
use crate::engine::Engine;
use crate::engine::symbolic::StateSet;
use crate::model::preference::ObjectiveSet;

/// Checks what the outcomes are said to be.
pub(super) fn check(checker: &mut Checker<'_>) -> Check {
    for objective in &checker.preferences.objectives {
        let (name, target) = (&objective.name, checker.engine.states_where(objective.target)?);
        let condition = || format!("`target:{name}` are the states in which the target holds");
        checker.equal(&checker.states(&format!("target:{name}"))?, &target, condition)?;
        checker.passed(&format!("target:{name}"), true, true);
        positive(checker, name, &target)?;
        almost_sure(checker, name, &target)?;
    }
    classes(checker)
}

/// P = F ∪ pre(P) is the least: from outside no choice enters; inside, layers lead to F.
fn positive(checker: &mut Checker<'_>, name: &str, target: &StateSet) -> Check {
    let engine = &checker.engine;
    let region = format!("positive:{name}");
    let x = checker.states(&region)?;
    checker.subset(target, &x, || format!("each state of the target is in `{region}`"))?;
    let entering = engine.sources(&engine.some_successor_in(&x)?)?;
    checker.subset(&entering, &x, || format!("each state with a step into `{region}` is in it"))?;
    let step = |layer: &StateSet| Ok(engine.sources(&engine.some_successor_in(layer)?)?);
    checker.layers(&region, &x, target, step)?;
    checker.passed(&region, true, true);
    Ok(())
}

/// Inside: the strategy stays, and from each layer some permitted choice enters the one before.
/// Outside: in each round, every choice of a lost state either may step into states lost before, or
/// does not enter what is left.
fn almost_sure(checker: &mut Checker<'_>, name: &str, target: &StateSet) -> Check {
    let engine = &checker.engine;
    let region = format!("almost-sure:{name}");
    let x = checker.states(&region)?;
    checker.subset(target, &x, || format!("each state of the target is in `{region}`"))?;
    let staying = engine.choices_in(&engine.every_successor_in(&x)?, &engine.difference(&x, target)?)?;
    let condition = || format!("`strategy:{region}` are the choices that stay in `{region}`");
    checker.equal_choices(&checker.choices(&format!("strategy:{region}"))?, &staying, condition)?;
    let step = |layer: &StateSet| {
        let entering = engine.entering(&staying, layer)?;
        Ok(engine.sources(&entering)?)
    };
    checker.layers(&region, &x, target, step)?;
    let mut left = engine.all_states();
    for (j, lost) in checker.sequence(&format!("refuted:{region}")).iter().enumerate() {
        let condition = || format!("no state lost in round {j} of `{region}` is in the target");
        checker.subset(&engine.intersection(lost, target)?, &engine.no_states(), condition)?;
        let rest = engine.difference(&left, lost)?;
        let safe = engine.choices_in(&engine.every_successor_in(&left)?, lost)?;
        let saved = engine.sources(&engine.entering(&safe, &rest)?)?;
        let condition =
            || format!("no state lost in round {j} of `{region}` has a safe step out of the round");
        checker.subset(&saved, &engine.no_states(), condition)?;
        left = rest;
    }
    checker.subset(&left, &x, || format!("each state outside of `{region}` is lost in some round"))?;
    checker.passed(&region, true, true);
    Ok(())
}

/// The classes are disjoint, are all there, and each has the states that the regions say.
fn classes(checker: &mut Checker<'_>) -> Check {
    let named = checker.named("class:");
    let mut seen = checker.engine.no_states();
    for (name, states) in &named {
        let class = members(checker, name)?;
        let expected = most_preferred(checker, &class)?;
        let condition = || format!("`class:{name}` are the states with these most preferred outcomes");
        checker.equal(states, &expected, condition)?;
        seen = checker.engine.union(&seen, states)?;
    }
    let all = checker.engine.all_states();
    checker.subset(&all, &seen, || "each state is in a class".to_owned())?;
    for (name, _) in named {
        checker.passed(&format!("class:{name}"), true, true);
    }
    Ok(())
}

/// The objectives of a class's name.
pub(super) fn members(checker: &Checker<'_>, name: &str) -> Check<ObjectiveSet> {
    let mut class = ObjectiveSet::new();
    for part in name.split('+').filter(|_| name != "nothing") {
        let Some(index) = checker.preferences.objectives.iter().position(|o| o.name == part) else {
            return Err(Stop::violated(format!("`class:{name}` is named by objectives"), None));
        };
        class.insert(index);
    }
    Ok(class)
}

/// The states s with MP(s) = `class`: those that have each member, undominated, and no other so.
fn most_preferred(checker: &Checker<'_>, class: &ObjectiveSet) -> Check<StateSet> {
    let (engine, preferences) = (&checker.engine, checker.preferences);
    let mut states = engine.all_states();
    for (i, objective) in preferences.objectives.iter().enumerate() {
        let mut undominated = checker.states(&format!("almost-sure:{}", objective.name))?;
        for (j, other) in preferences.objectives.iter().enumerate() {
            if preferences.order.strictly(j, i) {
                let above = checker.states(&format!("almost-sure:{}", other.name))?;
                undominated = engine.difference(&undominated, &above)?;
            }
        }
        states = if class.contains(i) {
            engine.intersection(&states, &undominated)?
        } else {
            engine.difference(&states, &undominated)?
        };
    }
    Ok(states)
}
