//! Checks of levels and their strategies.

use super::arena::{Arena, arenas};
use super::checker::Checker;
use super::error::{CheckError, CheckResult};
use super::outcomes::Class;
use meliora_engine::symbolic::{ChoiceSet, StateSet, SymbolicEngine};
use meliora_engine::{Algebra, Engine};
use meliora_model::names;

/// Checks the levels of both kinds; returns the arenas.
pub(super) fn check(checker: &mut Checker<'_>, classes: Vec<Class>) -> CheckResult<Vec<Arena>> {
    let arenas = arenas(checker, classes)?;
    let found = [levels(checker, &arenas, "sasi")?, levels(checker, &arenas, "spi")?];
    match checker.manifest.max_level {
        Some(max) if found.iter().max() != Some(&max) => Err(CheckError::violated(
            format!("the search for levels stopped at the maximum level {max}"),
            None,
        )),
        _ => Ok(arenas),
    }
}

/// One level of one kind.
struct Level<'n> {
    kind: &'n str,
    /// `sasi:1`, `sasi:2`, … or `sasi:unbounded`.
    name: String,
    /// The level below, which a goal edge must enter, and its name if it has one.
    entered: StateSet,
    below: Option<String>,
}

/// Checks the levels of one kind; returns their number.
fn levels(checker: &mut Checker<'_>, arenas: &[Arena], kind: &str) -> CheckResult<usize> {
    let found = (1..).take_while(|k| checker.regions.has(&names::level(kind, k))).count();
    let (mut entered, mut below) = (checker.engine.all_states(), None);
    for k in 1..=found {
        let level = Level { kind, name: names::level(kind, k), entered, below };
        let states = checker.regions.states(&level.name)?;
        let condition = || format!("`{}` has a state, and fewer than the level below", level.name);
        if checker.engine.is_empty(&states)? || checker.engine.same(&states, &level.entered)? && k > 1 {
            return Err(CheckError::violated(condition(), None));
        }
        checker.subset(&states, &level.entered, || {
            format!("each state of `{}` is in the level below", level.name)
        })?;
        whole(checker, arenas, &level, &states)?;
        (entered, below) = (states, Some(level.name));
    }
    if checker.manifest.max_level != Some(found) {
        ending(
            checker,
            arenas,
            kind,
            found,
            Level { kind, name: names::level(kind, names::UNBOUNDED), entered, below },
        )?;
    }
    Ok(found)
}

/// Checks the end of the sequence: the last level is the fixpoint of unbounded ranks, or the next
/// one is empty.
fn ending(
    checker: &mut Checker<'_>,
    arenas: &[Arena],
    kind: &str,
    found: usize,
    unbounded: Level<'_>,
) -> CheckResult {
    let name = &unbounded.name;
    let states = checker.regions.states(name)?;
    if !checker.engine.is_empty(&states)? {
        checker.equal(&states, &unbounded.entered, || format!("`{name}` is the last level"))?;
        return whole(checker, arenas, &unbounded, &states);
    }
    let nobody = checker.engine.no_states();
    let strategy = names::strategy(name);
    let condition = || format!("`{strategy}` has no choice, as `{name}` has no state");
    checker.equal_choices(&checker.regions.choices(&strategy)?, &checker.engine.no_choices(), condition)?;
    checker.passed(name);
    checker.passed(&strategy);
    let next = Level { name: names::level(kind, found + 1), ..unbounded };
    for arena in arenas {
        let upper = match &arena.reference {
            Some(_) => checker.proof.states(&arena.name(&next.name))?,
            None => nobody.clone(),
        };
        outside(checker, arena, &next, &upper)?;
        let winning = checker.engine.intersection(&upper, &arena.start)?;
        checker.subset(&winning, &nobody, || format!("no state wins `{}`", next.name))?;
    }
    Ok(())
}

/// Checks a level in all arenas.
fn whole(checker: &mut Checker<'_>, arenas: &[Arena], level: &Level<'_>, states: &StateSet) -> CheckResult {
    let name = &level.name;
    let mut won = checker.engine.no_states();
    let mut permitted = checker.engine.no_choices();
    for arena in arenas {
        let own = arena.name(name);
        let region = arena.sets(checker).states(&own)?;
        let strategy = arena.sets(checker).choices(&names::strategy(&own))?;
        inside(checker, arena, level, &own, &region, &strategy)?;
        outside(checker, arena, level, &region)?;
        let engine = &checker.engine;
        won = engine.union(&won, &engine.intersection(&region, &arena.start)?)?;
        permitted = engine.union(&permitted, &engine.choices_in(&strategy, &arena.start)?)?;
    }
    checker.equal(states, &won, || format!("`{name}` is what its reference classes win"))?;
    let strategy = names::strategy(name);
    let condition = || format!("`{strategy}` is what its reference classes permit");
    checker.equal_choices(&checker.regions.choices(&strategy)?, &permitted, condition)?;
    checker.passed(name);
    checker.passed(&strategy);
    Ok(())
}

/// Edges of an engine, from a set of choices.
type Edges<'a> = (&'a SymbolicEngine, &'a ChoiceSet);

impl Level<'_> {
    /// Returns the choices of C with a goal edge: an edge that improves and enters the level below.
    fn goals(&self, checker: &Checker<'_>, arena: &Arena, c: &ChoiceSet) -> CheckResult<ChoiceSet> {
        let engine = &checker.engine;
        arena.into(checker, (engine, c), |part| Ok(engine.intersection(&part.goal, &self.entered)?))
    }

    /// Returns the choices with a kept edge into X that is not a goal edge.
    fn straying(
        &self,
        checker: &Checker<'_>,
        arena: &Arena,
        edges: Edges<'_>,
        x: &StateSet,
    ) -> CheckResult<ChoiceSet> {
        let engine = &checker.engine;
        arena.into(checker, edges, |part| {
            let goal = engine.intersection(&part.goal, &self.entered)?;
            Ok(engine.difference(&engine.difference(x, &goal)?, &part.dropped)?)
        })
    }
}

/// Returns the choices with a kept edge into X.
fn moving(checker: &Checker<'_>, arena: &Arena, edges: Edges<'_>, x: &StateSet) -> CheckResult<ChoiceSet> {
    arena.into(checker, edges, |part| Ok(checker.engine.difference(x, &part.dropped)?))
}

/// Checks that the strategy is the permissive one, and that under it layers lead to a goal edge.
fn inside(
    checker: &Checker<'_>,
    arena: &Arena,
    level: &Level<'_>,
    name: &str,
    region: &StateSet,
    strategy: &ChoiceSet,
) -> CheckResult {
    let engine = &checker.engine;
    let kept = engine.choices_in(&arena.kept, region)?;
    let expected = if level.kind == "sasi" {
        let out = engine.difference(&engine.all_states(), region)?;
        engine.difference(&kept, &level.straying(checker, arena, (engine, &kept), &out)?)?
    } else {
        let goals = level.goals(checker, arena, &kept)?;
        engine.union(&goals, &moving(checker, arena, (engine, &kept), region)?)?
    };
    let condition = || format!("`strategy:{name}` are the kept choices that keep winning");
    checker.equal_choices(strategy, &checker.ours(&expected)?, condition)?;
    let goals = level.goals(checker, arena, &expected)?;
    checker.layers(name, region, &engine.can_choose(&goals)?, |layer| {
        let permitted = engine.choices_in(&expected, layer.states)?;
        let goals = engine.choices_in(&goals, layer.states)?;
        checker
            .leading(layer, |by, x| Ok(engine.union(&goals, &moving(checker, arena, (by, &permitted), x)?)?))
    })
}

/// Checks the states outside of a level. SASI: rounds remove the states of the level below that are
/// not in this one. SPI: no kept choice of an outside state enters the region or has a goal edge.
fn outside(checker: &Checker<'_>, arena: &Arena, level: &Level<'_>, region: &StateSet) -> CheckResult {
    let engine = &checker.engine;
    let name = arena.name(&level.name);
    let ahead = |c: &ChoiceSet, x: &StateSet| -> CheckResult<ChoiceSet> {
        let goals = level.goals(checker, arena, c)?;
        Ok(engine.union(&goals, &moving(checker, arena, (engine, c), x)?)?)
    };
    if level.kind == "spi" {
        let entering = engine.can_choose(&ahead(&arena.kept, region)?)?;
        return checker
            .subset(&entering, region, || format!("each state with a step towards `{name}` is in it"));
    }
    let below = match &level.below {
        Some(below) => arena.sets(checker).states(&arena.name(below))?,
        None => arena.states.clone(),
    };
    let left = checker.rounds(&name, &below, |round| {
        let gone = engine.difference(&engine.all_states(), round.left)?;
        let own = engine.choices_in(&arena.kept, round.lost)?;
        let safe = engine.difference(&own, &level.straying(checker, arena, (engine, &own), &gone)?)?;
        let saved = match round.within {
            Some(by) => {
                engine.difference(&safe, &level.straying(checker, arena, (by, &safe), round.lost)?)?
            }
            None => ahead(&safe, round.rest)?,
        };
        let condition = || {
            format!("no state lost in round {} of `{name}` has a safe step out of the round", round.number)
        };
        checker.subset(&engine.can_choose(&saved)?, &engine.no_states(), condition)
    })?;
    checker.subset(&left, region, || format!("each state outside of `{name}` is lost in some round"))
}
