//! Where improvements are looked for: kept choices, goal edges, dropped edges.

use super::checker::{Check, Checker, Stop};
use super::outcomes::members;
use crate::engine::Engine;
use crate::engine::symbolic::{ChoiceSet, StateSet};
use crate::model::preference::Change;

/// States of one class (or, under `prefix`, of all) with what their steps mean.
pub(super) struct Part {
    /// The states.
    pub(super) from: StateSet,
    /// A step into these improves.
    pub(super) better: StateSet,
    /// A step into these is dropped.
    pub(super) dropped: StateSet,
}

/// The safe choices, with the edges that improve.
pub(super) struct Arena {
    /// What the names of its sets end in: `@C` under `prefix`.
    pub(super) suffix: String,
    /// The states that count for a level; under `prefix` those of the reference class.
    pub(super) start: StateSet,
    /// The states that plays may be in.
    pub(super) states: StateSet,
    /// The kept choices.
    pub(super) kept: ChoiceSet,
    /// Which edges improve and which are dropped.
    pub(super) parts: Vec<Part>,
}

/// A class with what steps into others mean.
struct Class {
    name: String,
    states: StateSet,
    better: StateSet,
    worse: StateSet,
}

/// The arenas for the safety of the dump.
pub(super) fn arenas(checker: &mut Checker<'_>) -> Check<Vec<Arena>> {
    let classes = classes(checker)?;
    match checker.dump.manifest.safety.as_str() {
        "action" => Ok(vec![single(checker, classes, false)?]),
        "transition" => Ok(vec![single(checker, classes, true)?]),
        "prefix" => prefix(checker, classes),
        other => Err(Stop::violated(format!("`{other}` is a kind of safety"), None)),
    }
}

fn classes(checker: &Checker<'_>) -> Check<Vec<Class>> {
    let engine = &checker.engine;
    let named = checker.named("class:");
    let mut classes = Vec::new();
    for (name, states) in &named {
        let from = members(checker, name)?;
        let (mut better, mut worse) = (engine.no_states(), engine.no_states());
        for (other, there) in &named {
            match checker.preferences.change(&from, &members(checker, other)?) {
                Change::Improving => better = engine.union(&better, there)?,
                Change::Weakening => worse = engine.union(&worse, there)?,
                Change::Lateral => {}
            }
        }
        classes.push(Class { name: name.clone(), states: states.clone(), better, worse });
    }
    Ok(classes)
}

/// `action`: no choice with a weakening edge is kept. `transition`: weakening edges are dropped, and
/// choices that have no others.
fn single(checker: &Checker<'_>, classes: Vec<Class>, drops: bool) -> Check<Arena> {
    let engine = &checker.engine;
    let mut kept = engine.all_choices();
    let mut parts = Vec::new();
    for class in classes {
        let refused = if drops {
            engine.every_successor_in(&class.worse)?
        } else {
            engine.some_successor_in(&class.worse)?
        };
        kept = engine.without_choices(&kept, &engine.choices_in(&refused, &class.states)?)?;
        let dropped = if drops { class.worse } else { engine.no_states() };
        parts.push(Part { from: class.states, better: class.better, dropped });
    }
    let all = engine.all_states();
    Ok(Arena { suffix: String::new(), start: all.clone(), states: all, kept, parts })
}

/// One arena a class: the states from which it need never be weakened.
fn prefix(checker: &mut Checker<'_>, classes: Vec<Class>) -> Check<Vec<Arena>> {
    let mut arenas = Vec::new();
    for class in classes {
        if checker.engine.is_empty(&class.states) {
            continue;
        }
        let name = format!("safe:{}", class.name);
        let safe = checker.states(&name)?;
        let engine = &checker.engine;
        let kept = engine.choices_in(&engine.every_successor_in(&safe)?, &safe)?;
        let weaker = engine.intersection(&safe, &class.worse)?;
        let condition = || format!("no state of `{name}` weakens the class");
        checker.subset(&weaker, &engine.no_states(), condition)?;
        let condition = || format!("each state of `{name}` has a choice that stays in it");
        checker.subset(&safe, &engine.sources(&kept)?, condition)?;
        unsafe_rounds(checker, &name, &safe, &class.worse)?;
        let engine = &checker.engine;
        let better = engine.intersection(&class.better, &safe)?;
        let part = Part { from: safe.clone(), better, dropped: engine.no_states() };
        let start = engine.intersection(&class.states, &safe)?;
        let empty = engine.is_empty(&start);
        checker.passed(&name, true, true);
        if !empty {
            let suffix = format!("@{}", class.name);
            arenas.push(Arena { suffix, start, states: safe, kept, parts: vec![part] });
        }
    }
    Ok(arenas)
}

/// Round 0 weakens; from each later round, every choice may step into an earlier one.
fn unsafe_rounds(checker: &Checker<'_>, name: &str, safe: &StateSet, worse: &StateSet) -> Check {
    let engine = &checker.engine;
    let mut left = engine.all_states();
    for (j, lost) in checker.sequence(&format!("refuted:{name}")).iter().enumerate() {
        let staying = engine.sources(&engine.every_successor_in(&left)?)?;
        let condition =
            || format!("each state lost in round {j} of `{name}` weakens, or must risk an earlier round");
        let kept = engine.difference(&engine.intersection(lost, &staying)?, worse)?;
        checker.subset(&kept, &engine.no_states(), condition)?;
        left = engine.difference(&left, lost)?;
    }
    checker.subset(&left, safe, || format!("each state outside of `{name}` is lost in some round"))
}

impl Arena {
    /// The choices with an edge from a part into what belongs to the part.
    pub(super) fn into(
        &self,
        checker: &Checker<'_>,
        target: impl Fn(usize, &Part) -> Check<StateSet>,
    ) -> Check<ChoiceSet> {
        let engine = &checker.engine;
        let mut all = engine.no_choices();
        for (index, part) in self.parts.iter().enumerate() {
            let entering = engine.some_successor_in(&target(index, part)?)?;
            all = engine.union_choices(&all, &engine.choices_in(&entering, &part.from)?)?;
        }
        Ok(all)
    }
}
