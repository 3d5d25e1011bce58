//! The regions of a finished analysis, with the names that `meliora query` knows.

use super::{Named, whole_paths};
use meliora_base::error::Result;
use meliora_engine::symbolic::SymbolicEngine;
use meliora_engine::{Algebra, Engine};
use meliora_model::preference::{ObjectiveSet, Preferences};
use meliora_model::region::{LevelNumber, NOTHING, RegionName, members};
use meliora_planning::levels::{End, Level};
use meliora_planning::{Analysis, Kind, strategy};

type Of<'a> = Analysis<SymbolicEngine>;

/// Returns all regions and strategies.
pub(super) fn all(analysis: &Of<'_>) -> Result<Vec<Named>> {
    let (whole, engine) = (analysis.whole_engine(), analysis.engine());
    let mut named = vec![
        Named::states(RegionName::Reachable, &whole.all_states()),
        Named::states(RegionName::Initial, &whole.initial_states()),
        Named::states(RegionName::Deadlock, &whole.deadlock_states()),
        Named::choices(RegionName::Choices, &whole.all_choices()),
    ];
    named.extend(players(whole));
    named.extend(analysis.requirements().map(|r| Named::states(RegionName::Unsafe, &r.unsafe_states)));
    let preferences = analysis.preferences();
    if let Some(outcomes) = analysis.outcomes() {
        for (index, objective) in preferences.objectives.iter().enumerate() {
            let Some(outcome) = outcomes.get(index) else { continue };
            let name = || objective.name.clone();
            let outside = engine.difference(&outcome.almost_sure, &outcome.target)?;
            let staying = engine.pre_within(&engine.all_choices(), &outcome.almost_sure)?;
            named.extend(whole_paths::regions(analysis, index));
            named.push(Named::states(RegionName::Target(name()), &outcome.target));
            let sure = RegionName::AlmostSure(name());
            named.push(Named::states(sure.clone(), &outcome.almost_sure));
            named.push(Named::states(RegionName::Positive(name()), &outcome.positive));
            let strategy = strategy::ours(engine, &engine.choices_in(&staying, &outside)?)?;
            named.push(Named::choices(sure.strategy(), &strategy));
        }
    }
    for class in analysis.classes().iter().flat_map(|c| &c.list) {
        let name = class_name(preferences, &class.most_preferred);
        named.push(Named::states(RegionName::Class(name), &class.states));
    }
    let complete = analysis.classes().is_some();
    let nothing = RegionName::Class(NOTHING.to_owned());
    if complete && !named.iter().any(|n| n.name == nothing) {
        // Scripts ask for it by name, so it is in the dump even if it is empty.
        named.push(Named::states(nothing, &engine.no_states()));
    }
    named.extend(analysis.bad().map(|states| Named::states(RegionName::Bad, states)));
    for &kind in Kind::ALL {
        levels(engine, analysis, kind, &mut named)?;
    }
    Ok(named)
}

/// Returns the states in which each player of a game chooses; nothing for other models.
pub(super) fn players(engine: &SymbolicEngine) -> impl Iterator<Item = Named> {
    let players = engine.program().players.iter().flat_map(|players| &players.list);
    let states = players.zip(engine.player_states());
    states.map(|(player, states)| Named::states(RegionName::Player(player.name.clone()), &states))
}

/// Returns the name of a class: `A+B`, or `nothing`.
pub(super) fn class_name(preferences: &Preferences, class: &ObjectiveSet) -> String {
    members(&preferences.names(class))
}

fn levels(engine: &SymbolicEngine, analysis: &Of<'_>, kind: Kind, named: &mut Vec<Named>) -> Result<()> {
    let (Some(classes), Some(improvement)) = (analysis.classes(), analysis.improvement()) else {
        return Ok(());
    };
    for (number, level) in numbered(analysis, kind) {
        let name = RegionName::Level(kind, number);
        named.push(Named::states(name.clone(), &level.states));
        let permitted = strategy::permitted_at_start(engine, kind, classes, improvement, level)?;
        named.push(Named::choices(name.strategy(), &permitted));
    }
    if matches!(analysis.levels(kind).end, Some(End::Empty)) {
        let name = RegionName::Level(kind, LevelNumber::Unbounded);
        named.push(Named::states(name.clone(), &engine.no_states()));
        named.push(Named::choices(name.strategy(), &engine.no_choices()));
    }
    Ok(())
}

/// Returns the levels with their numbers; the fixpoint is unbounded.
pub(super) fn numbered<'a>(
    analysis: &'a Of<'_>,
    kind: Kind,
) -> Vec<(LevelNumber, &'a Level<SymbolicEngine>)> {
    let levels = analysis.levels(kind);
    let found = (1..).map(LevelNumber::Finite).zip(&levels.found);
    found.chain(levels.unbounded().map(|level| (LevelNumber::Unbounded, level))).collect()
}
