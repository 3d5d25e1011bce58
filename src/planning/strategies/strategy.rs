//! Strategies: the permitted choices and the progress choices of each level.
//!
//! A strategy has a part for each arena. Under `action` and `transition` there is one arena; under
//! `prefix` there is one per reference class. Under `prefix`, planning starts in the part of the
//! state's own class and stays there during steps that do not improve on it. After an improving
//! step into W_{k-1}, the class of the entered state is the new reference and k-1 is the new level.
//!
//! In a game, a strategy has choices of our states only. At a state of the opponent nothing is
//! permitted or forbidden: a layer contains it if *every* choice comes closer.

use crate::analysis::classes::Classes;
use crate::analysis::improvement::{Arena, Improvement};
use crate::analysis::levels::{Game, Kind, Level};
use meliora_base::error::Result;
use meliora_engine::edge_labels::{keeping, winning};
use meliora_engine::{EdgeLabels, Engine, Region, position};

/// The two strategies of one level in one arena.
pub struct ArenaStrategy<E: Engine> {
    /// The class that steps are compared with; `None` if each step is compared with the state it
    /// leaves.
    pub reference: Option<usize>,
    /// The winning states.
    pub states: E::States,
    /// The permitted choices of our states; see `permissive`.
    pub permissive: E::Choices,
    /// The winning states by their distance from the goal; the layers are disjoint. A state in
    /// layer 0 has a permitted choice with a goal edge. A state in layer i+1 has one with a kept
    /// edge into layer i and none with an edge into an earlier layer. A state of the opponent is in
    /// the first layer in which each of its choices has a goal edge or an edge into an earlier layer.
    pub layers: Vec<E::States>,
    /// The permitted choices that move one layer closer with positive probability; in layer 0 those
    /// with a goal edge. The progress strategy takes the first one of a state in the order of the
    /// program.
    pub progress: E::Choices,
}

/// Returns the pairs of C in our states: all of them if the model is not a game. Cost: no image.
///
/// # Errors
/// A limit of the engine is reached.
pub fn ours<E: Engine>(engine: &E, c: &E::Choices) -> Result<E::Choices> {
    match engine.theirs() {
        None => Ok(c.clone()),
        Some(theirs) => engine.choices_in(c, &engine.difference(&engine.all_states(), &theirs)?),
    }
}

/// Computes the permitted choices of a level in one arena: those of [`winning_choices`] in our states.
///
/// # Errors
/// A limit of the engine is reached.
pub fn permissive<E: Engine>(engine: &E, kind: Kind, game: &Game<E>) -> Result<E::Choices> {
    ours(engine, &winning_choices(engine, kind, game)?)
}

/// Computes the choices of a level in one arena with which it can still be won. At a state of the
/// opponent, these are all of its choices.
///
/// For SASI, these are the kept choices of the winning states whose kept edges all are goal edges
/// or stay in the winning states. For SPI, these are the kept choices with a goal edge or a kept
/// edge into the winning states. Cost: none for SASI; two pre-images per part for SPI.
///
/// # Errors
/// A limit of the engine is reached.
pub fn winning_choices<E: Engine>(engine: &E, kind: Kind, game: &Game<E>) -> Result<E::Choices> {
    winning_among(engine, kind, game, &game.choices)
}

/// Computes the choices of [`winning_choices`] among some choices of the game.
fn winning_among<E: Engine>(
    engine: &E,
    kind: Kind,
    game: &Game<E>,
    among: &E::Choices,
) -> Result<E::Choices> {
    match kind {
        Kind::Sasi => Ok(among.clone()),
        Kind::Spi => {
            let staying = keeping(engine, among, &game.edge_labels, &game.states)?;
            engine.union(&staying, &winning(engine, among, &game.edge_labels)?)
        }
    }
}

/// Computes both strategies of a level in one arena, layer by layer. Cost: one pre-image per layer
/// and part.
///
/// # Errors
/// A limit of the engine is reached.
pub fn strategy<E: Engine>(
    engine: &E,
    kind: Kind,
    arena: &Arena<E>,
    game: &Game<E>,
) -> Result<ArenaStrategy<E>> {
    let (all, choices) = (engine.all_choices(), winning_choices(engine, kind, game)?);
    let first = engine.intersection(&choices, &winning(engine, &all, &game.edge_labels)?)?;
    let goal = engine.can_choose(&first)?;
    let (layers, progress) = layered(engine, &game.states, goal, first, |layer| {
        engine.intersection(&choices, &keeping(engine, &all, &game.edge_labels, layer)?)
    })?;
    let (states, permissive) = (game.states.clone(), ours(engine, &choices)?);
    Ok(ArenaStrategy { reference: arena.reference, states, permissive, layers, progress })
}

/// Computes the strategy that approaches a goal within a region whose choices stay in it. `first` are
/// the progress choices of the goal itself. Cost: one pre-image per layer.
pub(crate) fn approach<E: Engine>(
    engine: &E,
    region: &Region<E::States, E::Choices>,
    goal: &E::States,
    first: E::Choices,
) -> Result<ArenaStrategy<E>> {
    let goal = engine.intersection(goal, &region.states)?;
    let (layers, progress) =
        layered(engine, &region.states, goal, first, |layer| engine.pre(&region.choices, layer))?;
    let (states, permissive) = (region.states.clone(), ours(engine, &region.choices)?);
    Ok(ArenaStrategy { reference: None, states, permissive, layers, progress })
}

/// Returns the states by their distance from `layer`, and our choices that come one layer closer: those
/// of `first`, and those that `closer` returns for a layer. A state of the opponent is in a layer once
/// each of its choices comes closer.
fn layered<E: Engine>(
    engine: &E,
    states: &E::States,
    mut layer: E::States,
    first: E::Choices,
    closer: impl Fn(&E::States) -> Result<E::Choices>,
) -> Result<(Vec<E::States>, E::Choices)> {
    let mut open = engine.difference(states, &layer)?;
    let (mut layers, mut progress, theirs) = (Vec::new(), first, engine.theirs());
    while !engine.is_empty(&layer)? {
        if let Some(limit) = engine.settings().sink.stop() {
            return Err(limit.into());
        }
        let closer = engine.choices_in(&closer(&layer)?, &open)?;
        progress = engine.union(&progress, &closer)?;
        layers.push(layer);
        layer = match &theirs {
            None => engine.can_choose(&closer)?,
            // Choices of the opponent may have come closer to earlier layers.
            Some(_) => engine.can_choose(&engine.choices_in(&progress, &open)?)?,
        };
        open = engine.difference(&open, &layer)?;
    }
    Ok((layers, ours(engine, &progress)?))
}

/// Computes the strategies of all arenas of a level, in the order of [`Improvement::arenas`]. Cost:
/// that of `strategy` per arena.
pub fn strategies<E: Engine>(
    engine: &E,
    kind: Kind,
    improvement: &Improvement<E>,
    level: &Level<E>,
) -> Result<Vec<ArenaStrategy<E>>> {
    let pairs = improvement.arenas.iter().zip(&level.games);
    pairs.map(|(arena, game)| strategy(engine, kind, arena, game)).collect()
}

/// Computes the permitted choices of all our states of a level when planning starts there. Cost: that
/// of [`winning_choices`] per arena.
///
/// # Errors
/// A limit of the engine is reached.
pub fn permitted_at_start<E: Engine>(
    engine: &E,
    kind: Kind,
    classes: &Classes<E>,
    improvement: &Improvement<E>,
    level: &Level<E>,
) -> Result<E::Choices> {
    permitted_in(engine, kind, classes, improvement, level, &engine.all_states())
}

/// Computes the permitted choices of our states of X in a level when planning starts there. Cost: that
/// of [`winning_choices`] for these states alone, per arena with one of them.
pub(crate) fn permitted_in<E: Engine>(
    engine: &E,
    kind: Kind,
    classes: &Classes<E>,
    improvement: &Improvement<E>,
    level: &Level<E>,
    x: &E::States,
) -> Result<E::Choices> {
    let mut all = engine.no_choices();
    for (arena, game) in improvement.arenas.iter().zip(&level.games) {
        let own = match arena.reference.and_then(|c| classes.list.get(c)) {
            Some(class) => engine.intersection(x, &class.states)?,
            None => x.clone(),
        };
        if !engine.is_empty(&own)? {
            let among = engine.choices_in(&game.choices, &own)?;
            all = engine.union(&all, &winning_among(engine, kind, game, &among)?)?;
        }
    }
    ours(engine, &all)
}

/// Returns whether a step between two states is a goal edge of a game: it improves and enters the
/// level below.
///
/// # Errors
/// The game belongs to another engine.
pub fn is_goal<E: Engine>(engine: &E, game: &Game<E>, from: &[i64], to: &[i64]) -> Result<bool> {
    let holds = |labels: &EdgeLabels<E::States>| {
        Ok(engine.contains(&labels.from, from)? && engine.contains(&labels.goal, to)?)
    };
    Ok(position(&game.edge_labels, holds)?.is_some())
}
