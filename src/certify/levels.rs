//! Levels and strategies.

use super::arena::{Arena, arenas};
use super::checker::{Check, Checker, Stop};
use crate::engine::Engine;
use crate::engine::symbolic::{ChoiceSet, StateSet};

/// Checks the levels of both kinds.
pub(super) fn check(checker: &mut Checker<'_>) -> Check {
    let arenas = arenas(checker)?;
    for kind in ["sasi", "spi"] {
        levels(checker, &arenas, kind)?;
    }
    Ok(())
}

/// One level of one kind.
struct Level<'n> {
    kind: &'n str,
    /// `1`, `2`, … or `unbounded`.
    label: String,
    /// The level below: what a goal edge must enter.
    entered: StateSet,
}

fn levels(checker: &mut Checker<'_>, arenas: &[Arena], kind: &str) -> Check {
    let found = (1..).take_while(|k| checker.has(&format!("{kind}:{k}"))).count();
    let mut entered = checker.engine.all_states();
    for k in 1..=found {
        let name = format!("{kind}:{k}");
        let states = checker.states(&name)?;
        checker.subset(&states, &entered, || format!("each state of `{name}` is in the level below"))?;
        let level = Level { kind, label: k.to_string(), entered };
        let before = if k == 1 { None } else { Some(k - 1) };
        whole(checker, arenas, &level, &states, before)?;
        entered = states;
    }
    let unbounded = format!("{kind}:unbounded");
    if checker.has(&unbounded) {
        ending(checker, arenas, kind, found, entered)
    } else if checker.dump.manifest.max_level == Some(found) {
        Ok(())
    } else {
        Err(Stop::violated(format!("the dump has `{unbounded}`, or its levels were cut"), None))
    }
}

/// The last level is the fixpoint of unbounded ranks, or the one after it is empty.
fn ending(checker: &mut Checker<'_>, arenas: &[Arena], kind: &str, found: usize, last: StateSet) -> Check {
    let name = format!("{kind}:unbounded");
    let states = checker.states(&name)?;
    if checker.engine.is_empty(&states) {
        let level = Level { kind, label: (found + 1).to_string(), entered: last };
        for arena in arenas {
            let nobody = checker.engine.no_states();
            let bound = format!("{kind}:{}{}", level.label, arena.suffix);
            let upper = if checker.has(&bound) { checker.states(&bound)? } else { nobody.clone() };
            outside(checker, arena, &level, &upper, (found > 0).then_some(found))?;
            let winning = checker.engine.intersection(&upper, &arena.start)?;
            checker.subset(&winning, &nobody, || format!("no state wins level {} of {kind}", found + 1))?;
        }
        checker.passed(&name, true, true);
        return Ok(());
    }
    checker.equal(&states, &last, || format!("`{name}` is the last level"))?;
    let level = Level { kind, label: "unbounded".to_owned(), entered: last };
    whole(checker, arenas, &level, &states, None)
}

/// A level in all arenas; `before` is the number of the level below where there is one.
fn whole(
    checker: &mut Checker<'_>,
    arenas: &[Arena],
    level: &Level<'_>,
    states: &StateSet,
    before: Option<usize>,
) -> Check {
    let name = format!("{}:{}", level.kind, level.label);
    let mut won = checker.engine.no_states();
    let mut permitted = checker.engine.no_choices();
    for arena in arenas {
        let own = format!("{name}{}", arena.suffix);
        let region = checker.states(&own)?;
        let strategy = checker.choices(&format!("strategy:{own}"))?;
        inside(checker, arena, level, &own, &region, &strategy)?;
        if level.label != "unbounded" {
            outside(checker, arena, level, &region, before)?;
        }
        let engine = &checker.engine;
        won = engine.union(&won, &engine.intersection(&region, &arena.start)?)?;
        permitted = engine.union_choices(&permitted, &engine.choices_in(&strategy, &arena.start)?)?;
    }
    checker.equal(states, &won, || format!("`{name}` is what its reference classes win"))?;
    let condition = || format!("`strategy:{name}` is what its reference classes permit");
    checker.equal_choices(&checker.choices(&format!("strategy:{name}"))?, &permitted, condition)?;
    checker.passed(&name, true, true);
    checker.passed(&format!("strategy:{name}"), true, true);
    Ok(())
}

impl Level<'_> {
    /// The choices of an arena with a goal edge: one that improves and enters the level below.
    fn goals(&self, checker: &Checker<'_>, arena: &Arena) -> Check<ChoiceSet> {
        arena.into(checker, |_, part| Ok(checker.engine.intersection(&part.better, &self.entered)?))
    }

    /// The choices with a kept edge into X that is no goal edge.
    fn straying(&self, checker: &Checker<'_>, arena: &Arena, x: &StateSet) -> Check<ChoiceSet> {
        let engine = &checker.engine;
        arena.into(checker, |_, part| {
            let goal = engine.intersection(&part.better, &self.entered)?;
            Ok(engine.difference(&engine.difference(x, &goal)?, &part.dropped)?)
        })
    }
}

/// The choices with a kept edge into X.
fn moving(checker: &Checker<'_>, arena: &Arena, x: &StateSet) -> Check<ChoiceSet> {
    arena.into(checker, |_, part| Ok(checker.engine.difference(x, &part.dropped)?))
}

/// The strategy is the permissive one, and layers lead to a goal edge under it.
fn inside(
    checker: &Checker<'_>,
    arena: &Arena,
    level: &Level<'_>,
    name: &str,
    region: &StateSet,
    strategy: &ChoiceSet,
) -> Check {
    let engine = &checker.engine;
    let kept = engine.choices_in(&arena.kept, region)?;
    let goals = level.goals(checker, arena)?;
    let expected = if level.kind == "sasi" {
        let out = engine.difference(&engine.all_states(), region)?;
        engine.without_choices(&kept, &level.straying(checker, arena, &out)?)?
    } else {
        let ahead = engine.union_choices(&goals, &moving(checker, arena, region)?)?;
        engine.common_choices(&kept, &ahead)?
    };
    let condition = || format!("`strategy:{name}` are the kept choices that keep winning");
    checker.equal_choices(strategy, &expected, condition)?;
    let start = engine.sources(&engine.common_choices(strategy, &goals)?)?;
    let step = |layer: &StateSet| {
        let entering = moving(checker, arena, layer)?;
        Ok(engine.sources(&engine.common_choices(strategy, &entering)?)?)
    };
    checker.layers(name, region, &start, step)
}

/// SASI: rounds in which the states outside are lost, after those outside of the level below. SPI: no
/// kept choice enters the region or a goal edge from outside.
fn outside(
    checker: &Checker<'_>,
    arena: &Arena,
    level: &Level<'_>,
    region: &StateSet,
    before: Option<usize>,
) -> Check {
    let engine = &checker.engine;
    let name = format!("{}:{}{}", level.kind, level.label, arena.suffix);
    let goals = level.goals(checker, arena)?;
    if level.kind == "spi" {
        let ahead = engine.union_choices(&goals, &moving(checker, arena, region)?)?;
        let entering = engine.sources(&engine.common_choices(&arena.kept, &ahead)?)?;
        return checker
            .subset(&entering, region, || format!("each state with a step towards `{name}` is in it"));
    }
    let mut left = match before {
        Some(k) => checker.states(&format!("{}:{k}{}", level.kind, arena.suffix))?,
        None => arena.states.clone(),
    };
    for (j, lost) in checker.sequence(&format!("refuted:{name}")).iter().enumerate() {
        let gone = engine.difference(&engine.all_states(), &left)?;
        let safe = engine.choices_in(&arena.kept, lost)?;
        let safe = engine.without_choices(&safe, &level.straying(checker, arena, &gone)?)?;
        left = engine.difference(&left, lost)?;
        let ahead = engine.union_choices(&goals, &moving(checker, arena, &left)?)?;
        let saved = engine.sources(&engine.common_choices(&safe, &ahead)?)?;
        let condition = || format!("no state lost in round {j} of `{name}` has a safe step out of the round");
        checker.subset(&saved, &engine.no_states(), condition)?;
    }
    checker.subset(&left, region, || format!("each state outside of `{name}` is lost in some round"))
}
