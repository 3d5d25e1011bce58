//! The sets of the certificate, which let a checker confirm regions one step at a time.
//!
//! Layers confirm the states inside: each has a step to an earlier layer. Removal rounds refute the
//! states outside: each can only reach states removed earlier, or never reaches the goal.

use super::layers::{backward, forward, layers, rounds};
use super::regions::{class_name, numbered};
use super::{Named, whole_paths};
use meliora_engine::edge_labels::{plain_edges_into, winning};
use meliora_engine::symbolic::{StateSet, SymbolicEngine};
use meliora_engine::{Algebra, EdgeLabels, Engine};
use meliora_model::error::Result;
use meliora_model::names;
use meliora_planning::improvement::Arena;
use meliora_planning::levels::{End, entering};
use meliora_planning::winning_regions::ObjectiveRegions;
use meliora_planning::{Analysis, Kind, strategy};

type Of<'a> = Analysis<SymbolicEngine>;

/// Returns all roots of the certificate.
pub(super) fn all(analysis: &Of<'_>) -> Result<Vec<Named>> {
    let (whole, engine) = (analysis.whole_engine(), analysis.engine());
    let mut named = Vec::new();
    if let Some(start) = whole.beginnings()? {
        layers(&mut named, names::REACHABLE, &forward(whole, start)?);
    }
    if let Some(requirements) = analysis.requirements() {
        let violating = whole.difference(&whole.all_states(), &requirements.kept)?;
        rounds(&mut named, names::UNSAFE, &risk_rounds(whole, violating)?.1);
    }
    for objective in 0..analysis.preferences().objectives.len() {
        whole_paths::witnesses(engine, analysis, objective, &mut named)?;
    }
    for (index, objective) in analysis.preferences().objectives.iter().enumerate() {
        if let Some(outcome) = analysis.outcomes().and_then(|o| o.get(index)) {
            outcome_layers(engine, &objective.name, outcome, &mut named)?;
        }
    }
    if analysis.improvement().is_some_and(|i| i.safety.has_reference()) {
        safe_regions(engine, analysis, &mut named)?;
    }
    for &kind in Kind::ALL {
        levels(engine, analysis, kind, &mut named)?;
    }
    Ok(named)
}

fn outcome_layers(
    engine: &SymbolicEngine,
    name: &str,
    outcome: &ObjectiveRegions<SymbolicEngine>,
    named: &mut Vec<Named>,
) -> Result<()> {
    let positive = backward(engine, &outcome.target, &engine.all_choices())?;
    layers(named, &names::positive(name), &positive);
    let staying = engine.pre_within(&engine.all_choices(), &outcome.almost_sure)?;
    let staying = engine.choices_in(&staying, &outcome.almost_sure)?;
    let almost_sure = backward(engine, &outcome.target, &staying)?;
    let region = names::almost_sure(name);
    layers(named, &region, &almost_sure);
    rounds(named, &region, &lost_rounds(engine, &outcome.target)?);
    Ok(())
}

/// Computes the states that do not reach a target almost surely, in rounds of attractor removal.
/// Each round removes the states that cannot reach the target with the choices that avoid all
/// removed states.
fn lost_rounds(engine: &SymbolicEngine, target: &StateSet) -> Result<Vec<StateSet>> {
    let (mut left, mut choices, mut rounds) = (engine.all_states(), engine.all_choices(), Vec::new());
    loop {
        let reaching = engine.can_reach(target, &choices, &Vec::new())?;
        let lost = engine.difference(&left, &reaching)?;
        if engine.is_empty(&lost)? {
            return Ok(rounds);
        }
        choices = engine.difference(&choices, &engine.pre(&choices, &lost)?)?;
        left = engine.difference(&left, &lost)?;
        rounds.push(lost);
    }
}

/// Adds, under `prefix`, the states from which a strategy can avoid weakening each class forever,
/// and the rounds that remove all others.
fn safe_regions(engine: &SymbolicEngine, analysis: &Of<'_>, named: &mut Vec<Named>) -> Result<()> {
    for class in analysis.classes().iter().flat_map(|c| &c.list) {
        let name = names::safe(&class_name(analysis.preferences(), &class.most_preferred));
        let (safe, lost) = risk_rounds(engine, class.worse.clone())?;
        named.push(Named::states(&name, &safe));
        rounds(named, &name, &lost);
    }
    Ok(())
}

/// Computes the states from which a strategy avoids the bad states forever, and the other states in
/// rounds: the bad states first, then those in which every choice may lead to an earlier round.
fn risk_rounds(engine: &SymbolicEngine, bad: StateSet) -> Result<(StateSet, Vec<StateSet>)> {
    let mut left = engine.difference(&engine.all_states(), &bad)?;
    let mut choices = engine.all_choices();
    let mut lost = vec![bad];
    while let Some(last) = lost.last() {
        if engine.is_empty(last)? {
            break;
        }
        choices = engine.difference(&choices, &engine.pre(&choices, last)?)?;
        let next = engine.difference(&left, &engine.can_choose(&choices)?)?;
        left = engine.difference(&left, &next)?;
        lost.push(next);
    }
    lost.pop();
    Ok((left, lost))
}

fn levels(engine: &SymbolicEngine, analysis: &Of<'_>, kind: Kind, named: &mut Vec<Named>) -> Result<()> {
    let Some(improvement) = analysis.improvement() else { return Ok(()) };
    let all = numbered(analysis, kind);
    for (index, arena) in improvement.arenas.iter().enumerate() {
        let mut before = arena.states.clone();
        for (label, level) in &all {
            let Some(game) = level.games.get(index) else { continue };
            let name = name_in(analysis, arena, kind, label);
            let strategy = strategy::strategy(engine, kind, arena, game)?;
            if arena.reference.is_some() {
                named.push(Named::states(&name, &game.states));
                named.push(Named::choices(names::strategy(&name), &strategy.permissive));
            }
            layers(named, &name, &strategy.layers);
            if kind == Kind::Sasi {
                rounds(named, &name, &level_rounds(engine, arena, &game.edge_labels, &before)?);
                before = game.states.clone();
            }
        }
        if matches!(analysis.levels(kind).end, Some(End::Empty)) {
            last_level(engine, analysis, kind, arena, &before, named)?;
        }
    }
    Ok(())
}

/// Adds the proof that the level after the last one is empty. Under `prefix`, states of other
/// classes may win it in an arena without counting for it; those states get a root of their own.
fn last_level(
    engine: &SymbolicEngine,
    analysis: &Of<'_>,
    kind: Kind,
    arena: &Arena<SymbolicEngine>,
    before: &StateSet,
    named: &mut Vec<Named>,
) -> Result<()> {
    let found = &analysis.levels(kind).found;
    let name = name_in(analysis, arena, kind, found.len() + 1);
    let entered = found.last().map_or_else(|| engine.all_states(), |level| level.states.clone());
    let edge_labels = entering(engine, arena, &entered)?;
    let left = match kind {
        Kind::Sasi => {
            let lost = level_rounds(engine, arena, &edge_labels, before)?;
            rounds(named, &name, &lost);
            lost.iter().try_fold(before.clone(), |x, lost| engine.difference(&x, lost))?
        }
        Kind::Spi => {
            let winning = winning(engine, &engine.all_choices(), &edge_labels)?;
            let seeds = engine.can_choose(&engine.intersection(&arena.choices, &winning)?)?;
            engine.can_reach(&seeds, &arena.choices, &edge_labels)?
        }
    };
    if arena.reference.is_some() {
        named.push(Named::states(name, &left));
    }
    Ok(())
}

/// Returns the name of a level in an arena, with the reference class if there is one.
fn name_in(
    analysis: &Of<'_>,
    arena: &Arena<SymbolicEngine>,
    kind: Kind,
    label: impl std::fmt::Display,
) -> String {
    let level = names::level(kind.name(), label);
    match arena.reference.and_then(|c| analysis.classes()?.list.get(c)) {
        Some(class) => names::against(&level, &class_name(analysis.preferences(), &class.most_preferred)),
        None => level,
    }
}

/// Computes the rounds that remove the states of `before` that do not win a SASI level. States
/// outside of `before` count as removed.
fn level_rounds(
    engine: &SymbolicEngine,
    arena: &Arena<SymbolicEngine>,
    edge_labels: &[EdgeLabels<StateSet>],
    before: &StateSet,
) -> Result<Vec<StateSet>> {
    let winning = winning(engine, &engine.all_choices(), edge_labels)?;
    let (mut left, mut rounds) = (before.clone(), Vec::new());
    let mut lost = engine.difference(&engine.all_states(), before)?;
    let mut choices = arena.choices.clone();
    loop {
        choices = engine.difference(&choices, &plain_edges_into(engine, &choices, edge_labels, &lost)?)?;
        choices = engine.choices_in(&choices, &left)?;
        let seeds = engine.can_choose(&engine.intersection(&choices, &winning)?)?;
        let reaching = engine.can_reach(&seeds, &choices, edge_labels)?;
        lost = engine.difference(&left, &reaching)?;
        if engine.is_empty(&lost)? {
            return Ok(rounds);
        }
        left = engine.difference(&left, &lost)?;
        rounds.push(lost.clone());
    }
}
