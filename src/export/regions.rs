//! The regions of a finished analysis, with the names that `meliora query` knows.

use super::{Named, whole_paths};
use meliora_base::error::Result;
use meliora_engine::symbolic::SymbolicEngine;
use meliora_engine::{Algebra, Engine};
use meliora_model::names;
use meliora_model::preference::{ObjectiveSet, Preferences};
use meliora_planning::levels::{End, Level};
use meliora_planning::{Analysis, Kind, strategy};

type Of<'a> = Analysis<SymbolicEngine>;

/// Returns all regions and strategies.
pub(super) fn all(analysis: &Of<'_>) -> Result<Vec<Named>> {
    let (whole, engine) = (analysis.whole_engine(), analysis.engine());
    let mut named = vec![
        Named::states(names::REACHABLE, &whole.all_states()),
        Named::states(names::INITIAL, &whole.initial_states()),
        Named::states(names::DEADLOCK, &whole.deadlock_states()),
        Named::choices(names::CHOICES, &whole.all_choices()),
    ];
    named.extend(players(whole));
    named.extend(analysis.requirements().map(|r| Named::states(names::UNSAFE, &r.unsafe_states)));
    let preferences = analysis.preferences();
    if let Some(outcomes) = analysis.outcomes() {
        for (index, objective) in preferences.objectives.iter().enumerate() {
            let Some(outcome) = outcomes.get(index) else { continue };
            let name = &objective.name;
            let outside = engine.difference(&outcome.almost_sure, &outcome.target)?;
            let staying = engine.pre_within(&engine.all_choices(), &outcome.almost_sure)?;
            named.extend(whole_paths::regions(analysis, index));
            named.push(Named::states(names::target(name), &outcome.target));
            let sure = names::almost_sure(name);
            named.push(Named::states(&sure, &outcome.almost_sure));
            named.push(Named::states(names::positive(name), &outcome.positive));
            let strategy = strategy::ours(engine, &engine.choices_in(&staying, &outside)?)?;
            named.push(Named::choices(names::strategy(&sure), &strategy));
        }
    }
    for class in analysis.classes().iter().flat_map(|c| &c.list) {
        let name = class_name(preferences, &class.most_preferred);
        named.push(Named::states(names::class(&name), &class.states));
    }
    let complete = analysis.classes().is_some();
    let nothing = names::class(names::NOTHING);
    if complete && !named.iter().any(|n| n.name == nothing) {
        // Scripts ask for it by name, so it is in the dump even if it is empty.
        named.push(Named::states(nothing, &engine.no_states()));
    }
    named.extend(analysis.bad().map(|states| Named::states(names::BAD, states)));
    for &kind in Kind::ALL {
        levels(engine, analysis, kind, &mut named)?;
    }
    Ok(named)
}

/// Returns the states in which each player of a game chooses; nothing for other models.
pub(super) fn players(engine: &SymbolicEngine) -> impl Iterator<Item = Named> {
    let players = engine.program().players.iter().flat_map(|players| &players.list);
    let states = players.zip(engine.player_states());
    states.map(|(player, states)| Named::states(names::player(&player.name), &states))
}

/// Returns the name of a class: `A+B`, or `nothing`.
pub(super) fn class_name(preferences: &Preferences, class: &ObjectiveSet) -> String {
    names::members(&preferences.names(class))
}

fn levels(engine: &SymbolicEngine, analysis: &Of<'_>, kind: Kind, named: &mut Vec<Named>) -> Result<()> {
    let (Some(classes), Some(improvement)) = (analysis.classes(), analysis.improvement()) else {
        return Ok(());
    };
    for (number, level) in numbered(analysis, kind) {
        let name = names::level(kind.name(), number);
        named.push(Named::states(&name, &level.states));
        let permitted = strategy::permitted_at_start(engine, kind, classes, improvement, level)?;
        named.push(Named::choices(names::strategy(&name), &permitted));
    }
    if matches!(analysis.levels(kind).end, Some(End::Empty)) {
        let name = names::level(kind.name(), names::UNBOUNDED);
        named.push(Named::states(&name, &engine.no_states()));
        named.push(Named::choices(names::strategy(&name), &engine.no_choices()));
    }
    Ok(())
}

/// Returns the levels with their numbers; the fixpoint is called `unbounded`.
pub(super) fn numbered<'a>(analysis: &'a Of<'_>, kind: Kind) -> Vec<(String, &'a Level<SymbolicEngine>)> {
    let levels = analysis.levels(kind);
    let found = levels.found.iter().enumerate().map(|(k, level)| ((k + 1).to_string(), level));
    found.chain(levels.unbounded().map(|level| (names::UNBOUNDED.to_owned(), level))).collect()
}
