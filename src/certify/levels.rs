//! Checks of levels and their strategies. The bounds of quantities are checked with the levels that
//! are returned here, which are proved; they look up no set of the dump.

use super::arena::{Arena, arenas};
use super::checker::Checker;
use super::condition::Condition;
use super::error::{CheckError, CheckResult};
use super::outcomes::Class;
use meliora_engine::symbolic::{ChoiceSet, StateSet, SymbolicEngine};
use meliora_engine::{Algebra, Engine};
use meliora_model::region::{Kind, LevelNumber, RegionName};

/// The levels of one kind in all arenas, proved.
pub(super) struct Levels {
    /// For each arena the states of level 1, 2, …, exactly.
    found: Vec<Vec<StateSet>>,
    rest: Rest,
}

/// The levels after the last one that a dump has, in all arenas.
enum Rest {
    /// The search was cut: nothing is known.
    Cut,
    /// Each has these states, exactly.
    Same(Vec<StateSet>),
    /// The next one has no other states than these, and none that counts. No state wins a later one.
    AtMost(Vec<StateSet>),
}

/// The knowledge of a level in an arena.
pub(super) enum Known<'l> {
    /// Its states.
    Exactly(&'l StateSet),
    /// States that contain all of its states.
    AtMost(&'l StateSet),
    /// It has no state.
    Empty,
    /// Nothing.
    Nothing,
}

impl Levels {
    /// Returns the knowledge of level k, from 1, in an arena.
    pub(super) fn known(&self, arena: usize, k: usize) -> Known<'_> {
        let found = &self.found[arena];
        match (found.get(k - 1), &self.rest) {
            (Some(states), _) => Known::Exactly(states),
            (None, Rest::Same(all)) => Known::Exactly(&all[arena]),
            (None, Rest::AtMost(all)) if k == found.len() + 1 => Known::AtMost(&all[arena]),
            (None, Rest::AtMost(_)) => Known::Empty,
            (None, Rest::Cut) => Known::Nothing,
        }
    }
}

/// The arenas, and the levels of SASI and of SPI.
pub(super) type Proved = (Vec<Arena>, [Levels; 2]);

/// Checks the levels of both kinds; returns the arenas, and the levels of SASI and of SPI. Returns `None` if the
/// certificate leaves out some.
pub(super) fn check(checker: &mut Checker<'_>, classes: Vec<Class>) -> CheckResult<Option<Proved>> {
    let kinds =
        [Kind::Sasi, Kind::Spi].map(|kind| (kind, checker.lacks(|name| name.level_kind() == Some(kind))));
    if kinds.iter().all(|(_, is_open)| *is_open) {
        return Ok(None);
    }
    let arenas = arenas(checker, classes)?;
    let mut found = Vec::new();
    for (kind, _) in kinds.into_iter().filter(|(_, is_open)| !is_open) {
        found.push(levels(checker, &arenas, kind)?);
    }
    let Ok([(sasi, sasi_levels), (spi, spi_levels)]) = <[_; 2]>::try_from(found) else { return Ok(None) };
    match checker.manifest.max_level {
        Some(max) if sasi.max(spi) != max => Err(CheckError::violated(Condition::MaxLevel { max }, None)),
        _ => Ok(Some((arenas, [sasi_levels, spi_levels]))),
    }
}

/// One level of one kind.
struct Level {
    kind: Kind,
    number: LevelNumber,
    /// The level below, which a goal edge must enter.
    entered: StateSet,
    /// For each arena the states of the level below.
    below: Vec<StateSet>,
}

/// Checks the levels of one kind; returns their number, and the proved levels.
fn levels(checker: &mut Checker<'_>, arenas: &[Arena], kind: Kind) -> CheckResult<(usize, Levels)> {
    let is_found = |k: &u64| checker.regions.has(&RegionName::Level(kind, LevelNumber::Finite(*k)));
    let number = (1..).take_while(is_found).count();
    let mut entered = checker.engine.all_states();
    let mut below: Vec<StateSet> = arenas.iter().map(|arena| arena.states.clone()).collect();
    let mut found = vec![Vec::new(); arenas.len()];
    for k in 1..=number {
        let level = Level { kind, number: LevelNumber::Finite(k as u64), entered, below };
        let name = level.name();
        let states = checker.regions.states(&name)?;
        let condition = Condition::LevelSmaller { region: name.clone() };
        if checker.engine.is_empty(&states)? || checker.engine.same(&states, &level.entered)? && k > 1 {
            return Err(CheckError::violated(condition, None));
        }
        checker.subset(&states, &level.entered, Condition::LevelWithin { region: name.clone() })?;
        below = whole(checker, arenas, &level, &states)?;
        found.iter_mut().zip(&below).for_each(|(own, states)| own.push(states.clone()));
        entered = states;
    }
    let rest = if checker.manifest.max_level == Some(number) {
        Rest::Cut
    } else {
        let unbounded = Level { kind, number: LevelNumber::Unbounded, entered, below };
        ending(checker, arenas, number, unbounded)?
    };
    Ok((number, Levels { found, rest }))
}

/// Checks the end of the sequence: the last level is the fixpoint of unbounded ranks, or the next
/// one is empty.
fn ending(checker: &mut Checker<'_>, arenas: &[Arena], found: usize, unbounded: Level) -> CheckResult<Rest> {
    let name = &unbounded.name();
    let states = checker.regions.states(name)?;
    if !checker.engine.is_empty(&states)? {
        checker.equal(&states, &unbounded.entered, Condition::LastLevel { region: name.clone() })?;
        return Ok(Rest::Same(whole(checker, arenas, &unbounded, &states)?));
    }
    let nobody = checker.engine.no_states();
    let strategy = name.strategy();
    let condition = Condition::NoChoices { region: name.clone() };
    checker.equal_choices(&checker.regions.choices(&strategy)?, &checker.engine.no_choices(), condition)?;
    checker.passed(name);
    checker.passed(&strategy);
    let next = Level { number: LevelNumber::Finite(found as u64 + 1), ..unbounded };
    let mut most = Vec::new();
    for (arena, below) in arenas.iter().zip(&next.below) {
        let upper = match &arena.reference {
            Some(_) => checker.proof.states(&arena.name(next.kind, next.number))?,
            None => nobody.clone(),
        };
        outside(checker, arena, &next, below, &upper)?;
        let winning = checker.engine.intersection(&upper, &arena.start)?;
        checker.subset(&winning, &nobody, Condition::NoWinner { region: next.name() })?;
        most.push(upper);
    }
    Ok(Rest::AtMost(most))
}

/// Checks a level in all arenas; returns its states in each of them.
fn whole(
    checker: &mut Checker<'_>,
    arenas: &[Arena],
    level: &Level,
    states: &StateSet,
) -> CheckResult<Vec<StateSet>> {
    let name = &level.name();
    let mut won = checker.engine.no_states();
    let mut permitted = checker.engine.no_choices();
    let mut regions = Vec::new();
    for (arena, below) in arenas.iter().zip(&level.below) {
        let own = arena.name(level.kind, level.number);
        let region = arena.sets(checker).states(&own)?;
        let strategy = arena.sets(checker).choices(&own.strategy())?;
        inside(checker, arena, level, &own, &region, &strategy)?;
        outside(checker, arena, level, below, &region)?;
        let engine = &checker.engine;
        won = engine.union(&won, &engine.intersection(&region, &arena.start)?)?;
        permitted = engine.union(&permitted, &engine.choices_in(&strategy, &arena.start)?)?;
        regions.push(region);
    }
    checker.equal(states, &won, Condition::WonByClasses { region: name.clone() })?;
    let strategy = name.strategy();
    let condition = Condition::PermittedByClasses { region: strategy.clone() };
    checker.equal_choices(&checker.regions.choices(&strategy)?, &permitted, condition)?;
    checker.passed(name);
    checker.passed(&strategy);
    Ok(regions)
}

impl Level {
    /// Returns its name as a region: `sasi:1`, `sasi:2`, … or `sasi:unbounded`.
    fn name(&self) -> RegionName {
        RegionName::Level(self.kind, self.number)
    }

    /// Returns the choices of C with a goal edge: an edge that improves and enters the level below.
    fn goals(&self, checker: &Checker<'_>, arena: &Arena, c: &ChoiceSet) -> CheckResult<ChoiceSet> {
        let engine = &checker.engine;
        arena.into(checker, engine, c, |part| Ok(engine.intersection(&part.goal, &self.entered)?))
    }

    /// Returns the choices of C with a kept edge of the engine `by` into X that is not a goal edge.
    fn straying(
        &self,
        checker: &Checker<'_>,
        arena: &Arena,
        by: &SymbolicEngine,
        c: &ChoiceSet,
        x: &StateSet,
    ) -> CheckResult<ChoiceSet> {
        let engine = &checker.engine;
        arena.into(checker, by, c, |part| {
            let goal = engine.intersection(&part.goal, &self.entered)?;
            Ok(engine.difference(&engine.difference(x, &goal)?, &part.dropped)?)
        })
    }
}

/// Returns `goals`, and the choices of C with a kept edge of the engine `by` into X.
fn ahead(
    checker: &Checker<'_>,
    arena: &Arena,
    goals: &ChoiceSet,
    by: &SymbolicEngine,
    c: &ChoiceSet,
    x: &StateSet,
) -> CheckResult<ChoiceSet> {
    let moving = arena.into(checker, by, c, |part| Ok(checker.engine.difference(x, &part.dropped)?))?;
    Ok(checker.engine.union(goals, &moving)?)
}

/// Checks that the strategy is the permissive one, and that under it layers lead to a goal edge.
fn inside(
    checker: &Checker<'_>,
    arena: &Arena,
    level: &Level,
    name: &RegionName,
    region: &StateSet,
    strategy: &ChoiceSet,
) -> CheckResult {
    let engine = &checker.engine;
    let kept = engine.choices_in(&arena.kept, region)?;
    let expected = if level.kind == Kind::Sasi {
        let out = engine.difference(&engine.all_states(), region)?;
        engine.difference(&kept, &level.straying(checker, arena, engine, &kept, &out)?)?
    } else {
        let goals = level.goals(checker, arena, &kept)?;
        ahead(checker, arena, &goals, engine, &kept, region)?
    };
    let condition = Condition::KeptChoices { region: name.clone() };
    checker.equal_choices(strategy, &checker.ours(&expected)?, condition)?;
    let goals = level.goals(checker, arena, &expected)?;
    checker.layers(name, region, &engine.can_choose(&goals)?, &|layer| {
        let permitted = engine.choices_in(&expected, layer.states)?;
        let goals = engine.choices_in(&goals, layer.states)?;
        checker.leading(layer, &|by, x| ahead(checker, arena, &goals, by, &permitted, x))
    })
}

/// Checks the states outside of a level. SASI: rounds remove the states of the level below that are
/// not in this one. SPI: no kept choice of an outside state enters the region or has a goal edge.
fn outside(
    checker: &Checker<'_>,
    arena: &Arena,
    level: &Level,
    below: &StateSet,
    region: &StateSet,
) -> CheckResult {
    let engine = &checker.engine;
    let name = arena.name(level.kind, level.number);
    let ahead = |c: &ChoiceSet, x: &StateSet| {
        let goals = level.goals(checker, arena, c)?;
        ahead(checker, arena, &goals, engine, c, x)
    };
    if level.kind == Kind::Spi {
        let entering = engine.can_choose(&ahead(&arena.kept, region)?)?;
        return checker.subset(&entering, region, Condition::HasStepsTowards { region: name.clone() });
    }
    let left = checker.rounds(&name, below, &|round| {
        let gone = engine.difference(&engine.all_states(), round.left)?;
        let own = engine.choices_in(&arena.kept, round.lost)?;
        let safe = engine.difference(&own, &level.straying(checker, arena, engine, &own, &gone)?)?;
        let saved = match round.within {
            Some(by) => engine.difference(&safe, &level.straying(checker, arena, by, &safe, round.lost)?)?,
            None => ahead(&safe, round.rest)?,
        };
        let condition = Condition::RoundSafeStep { round: round.number, region: name.clone() };
        checker.subset(&engine.can_choose(&saved)?, &engine.no_states(), condition)
    })?;
    checker.subset(&left, region, Condition::OutsideLost { region: name.clone() })
}
