//! The arenas of the checker: kept choices, goal edges, dropped edges.

use super::checker::Checker;
use super::condition::Condition;
use super::error::CheckResult;
use super::outcomes::Class;
use super::safe::Avoided;
use super::safety;
use super::sets::Sets;
use meliora_engine::symbolic::{ChoiceSet, StateSet, SymbolicEngine};
use meliora_engine::{Algebra, EdgeLabels, Engine};
use meliora_model::preference::Change;
use meliora_model::region::{Kind, LevelNumber, RegionName};

/// The choices that the safety mode keeps, with the edges that improve.
pub(super) struct Arena {
    /// The name of the class that improvements are measured against; under `prefix` only.
    pub(super) reference: Option<String>,
    /// The states that count for a level; under `prefix` those of the reference class.
    pub(super) start: StateSet,
    /// The states that paths may visit.
    pub(super) states: StateSet,
    /// The kept choices.
    pub(super) kept: ChoiceSet,
    /// Edge labels by class; under `prefix` one entry for all states. An edge into `goal` improves.
    pub(super) edge_labels: Vec<EdgeLabels<StateSet>>,
}

/// A class with the states that are better and worse than it.
struct Side {
    name: String,
    states: StateSet,
    better: StateSet,
    worse: StateSet,
}

/// Builds the arenas for the safety mode of the dump.
pub(super) fn arenas(checker: &mut Checker<'_>, classes: Vec<Class>) -> CheckResult<Vec<Arena>> {
    let sides = sides(checker, classes)?;
    let mode = checker.manifest.safety;
    if safety::has_reference(mode) {
        return prefix(checker, sides);
    }
    Ok(vec![single(checker, sides, safety::drops_edges(mode))?])
}

fn sides(checker: &Checker<'_>, classes: Vec<Class>) -> CheckResult<Vec<Side>> {
    let engine = &checker.engine;
    let rated = Vec::from_iter(classes.iter().map(|class| checker.preferences.rated(&class.members)));
    let mut sides = Vec::new();
    for (class, from) in classes.iter().zip(&rated) {
        let (mut better, mut worse) = (engine.no_states(), engine.no_states());
        for (other, to) in classes.iter().zip(&rated) {
            match checker.preferences.change_between(from, to) {
                Change::Improving => better = engine.union(&better, &other.states)?,
                Change::Weakening => worse = engine.union(&worse, &other.states)?,
                Change::Lateral => {}
            }
        }
        sides.push(Side { name: class.name.clone(), states: class.states.clone(), better, worse });
    }
    Ok(sides)
}

/// Builds the one arena of `action` and `transition`. `action` keeps no choice with a weakening
/// edge. `transition` (`drops`) drops weakening edges, and removes the choices that have no other
/// edges.
///
/// In a game, `action` keeps no choice that may step into a bad state, and none in a bad state.
fn single(checker: &mut Checker<'_>, sides: Vec<Side>, drops: bool) -> CheckResult<Arena> {
    let engine = &checker.engine;
    let mut kept = engine.all_choices();
    let mut edge_labels = Vec::new();
    for class in sides {
        let refused = if drops {
            engine.pre_within(&engine.all_choices(), &class.worse)?
        } else {
            engine.pre(&engine.all_choices(), &class.worse)?
        };
        kept = engine.difference(&kept, &engine.choices_in(&refused, &class.states)?)?;
        let dropped = if drops { class.worse } else { engine.no_states() };
        edge_labels.push(EdgeLabels::new(class.states, class.better, dropped));
    }
    if engine.is_game() {
        kept = without_bad_states(checker, kept)?;
    }
    let all = checker.engine.all_states();
    Ok(Arena { reference: None, start: all.clone(), states: all, kept, edge_labels })
}

/// Checks the bad states of a game: those of the opponent where some choice is not in C, which has all
/// choices that do not weaken, or may step into a bad state. Returns the other choices of C without
/// those that may step into a bad state.
///
/// Not too small: no choice of the opponent leads into them from a state that is not bad, nor weakens
/// there. Not too large: from each layer some choice of the opponent may step into an earlier one, or by
/// a step of the layer's trend into the layer itself, and in the first layer some choice weakens.
fn without_bad_states(checker: &mut Checker<'_>, c: ChoiceSet) -> CheckResult<ChoiceSet> {
    let (engine, name) = (&checker.engine, &RegionName::Bad);
    let bad = checker.regions.states(name)?;
    let theirs = engine.theirs().unwrap_or_else(|| engine.no_states());
    let own = engine.choices_in(&engine.all_choices(), &theirs)?;
    let weakening = engine.sources(&engine.difference(&own, &c)?)?;
    let leading = engine.union(&weakening, &engine.sources(&engine.pre(&own, &bad)?)?)?;
    let condition = Condition::BadStates { region: name.clone() };
    checker.subset(&leading, &bad, condition)?;
    checker.layers(name, &bad, &weakening, &|layer| {
        let own = engine.choices_in(&own, layer.states)?;
        let (by, x) = layer.within.map_or((engine, layer.earlier), |by| (by, layer.until));
        Ok(engine.sources(&by.pre(&own, x)?)?)
    })?;
    let good = engine.difference(&engine.all_states(), &bad)?;
    let kept = engine.choices_in(&engine.difference(&c, &engine.pre(&c, &bad)?)?, &good)?;
    checker.passed(name);
    Ok(kept)
}

/// Builds one arena per class, over the states from which a strategy can avoid weakening the class
/// forever.
fn prefix(checker: &mut Checker<'_>, sides: Vec<Side>) -> CheckResult<Vec<Arena>> {
    let mut arenas = Vec::new();
    for class in sides {
        let name = RegionName::Safe(class.name.clone());
        let safe = checker.proof.states(&name)?;
        let condition = Condition::NotWeakening { region: name.clone() };
        let avoided = Avoided { name: &name, bad: &class.worse };
        let kept = avoided.check(checker, &safe, condition)?;
        let engine = &checker.engine;
        let goal = engine.intersection(&class.better, &safe)?;
        let edge_labels = EdgeLabels::new(safe.clone(), goal, engine.no_states());
        let start = engine.intersection(&class.states, &safe)?;
        if !engine.is_empty(&start)? {
            arenas.push(Arena {
                reference: Some(class.name),
                start,
                states: safe,
                kept,
                edge_labels: vec![edge_labels],
            });
        }
        checker.passed(&name);
    }
    Ok(arenas)
}

impl Arena {
    /// Returns the name of a level in this arena.
    pub(super) fn name(&self, kind: Kind, number: LevelNumber) -> RegionName {
        match &self.reference {
            Some(class) => RegionName::Against(kind, number, class.clone()),
            None => RegionName::Level(kind, number),
        }
    }

    /// Returns the file that contains the levels of this arena. Levels against a reference class
    /// are not regions; they are part of the proof.
    pub(super) fn sets<'c>(&self, checker: &'c Checker<'_>) -> &'c Sets {
        if self.reference.is_some() { &checker.proof } else { &checker.regions }
    }

    /// Returns the choices of C with an edge of the engine `by` from the states of a part into the
    /// target of that part.
    pub(super) fn into(
        &self,
        checker: &Checker<'_>,
        by: &SymbolicEngine,
        c: &ChoiceSet,
        target: impl Fn(&EdgeLabels<StateSet>) -> CheckResult<StateSet>,
    ) -> CheckResult<ChoiceSet> {
        let engine = &checker.engine;
        let mut all = engine.no_choices();
        for part in &self.edge_labels {
            let entering = by.pre(&engine.choices_in(c, &part.from)?, &target(part)?)?;
            all = engine.union(&all, &entering)?;
        }
        Ok(all)
    }
}
