//! The projections of a game: who chooses, where each player stands, and what the opponent's moves lead
//! to.

use super::Plane;
use meliora_base::diagram::Edge;
use meliora_base::error::Result;
use meliora_engine::edge_labels::pairs_into;
use meliora_engine::symbolic::{ChoiceSet, StateSet, SymbolicEngine};
use meliora_engine::{Algebra, Engine};
use meliora_model::{Program, VarId};

/// A game over a plane.
#[derive(Debug, Clone)]
pub struct GameView {
    /// The players, in the order of declaration.
    pub players: Vec<PlayerView>,
    /// The positions that variables of the model give, that of the plane first, each with the player that
    /// moves it.
    pub positions: Vec<(usize, Plane)>,
    /// The moves of the opponent; empty if there are too many.
    pub moves: Vec<MoveView>,
}

/// A player of a game.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlayerView {
    /// Its name.
    pub name: String,
    /// True if we choose its moves.
    pub ours: bool,
    /// The states in which it chooses.
    pub states: Edge,
}

/// A choice of the opponent: the states in which it is enabled, and those from which it leads to certain
/// states.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MoveView {
    /// Its position in [`super::Projections::choices`].
    pub choice: usize,
    /// The states in which it is enabled.
    pub enabled: Edge,
    /// The states that it may improve.
    pub may_improve: Edge,
    /// The states that each of its successors improves.
    pub improves: Edge,
    /// The states that it may weaken.
    pub may_weaken: Edge,
    /// The states that each of its successors weakens.
    pub weakens: Edge,
    /// The states from which it may lead to a state of SASI rank 0, 1, …; the last entry also stands for
    /// greater ranks.
    pub sasi: Vec<Edge>,
    /// The states from which it may lead to each SPI rank, likewise.
    pub spi: Vec<Edge>,
}

/// The sets of a [`GameView`].
pub(super) struct GameSets {
    players: Vec<StateSet>,
    moves: Vec<MoveSets>,
}

/// The sets of a [`MoveView`].
struct MoveSets {
    choice: usize,
    /// In the order of the fields: from `enabled` to `weakens`, `sasi`, `spi`.
    sets: Vec<StateSet>,
    /// The number of SASI ranks.
    sasi: usize,
}

/// The states of a class, of those that improve it, and of those that weaken it.
pub(super) struct Neighbours {
    pub(super) class: StateSet,
    pub(super) better: StateSet,
    pub(super) worse: StateSet,
}

impl GameSets {
    /// Finds the players' states and what the first `choices` choices lead to. `engine` is that of the
    /// safe states, `whole` that of all states, `levels` are those of SASI and SPI. Cost: one pre-image per
    /// rank of both kinds, and four per class.
    pub(super) fn compute(
        whole: &SymbolicEngine,
        engine: &SymbolicEngine,
        classes: &[Neighbours],
        levels: [&[StateSet]; 2],
        choices: usize,
    ) -> Result<Option<Self>> {
        if !whole.is_game() {
            return Ok(None);
        }
        let moves = match engine.theirs() {
            Some(theirs) if choices > 0 => moves(engine, &theirs, classes, levels, choices)?,
            _ => Vec::new(),
        };
        Ok(Some(GameSets { players: whole.player_states(), moves }))
    }

    /// Returns all sets; [`GameSets::view`] takes the roots in this order.
    pub(super) fn all(&self) -> impl Iterator<Item = &StateSet> {
        self.players.iter().chain(self.moves.iter().flat_map(|m| &m.sets))
    }

    /// Returns the sets that a projection onto the plane keeps.
    pub(super) fn projected(&mut self) -> impl Iterator<Item = &mut StateSet> {
        self.players.iter_mut()
    }

    /// Leaves out the moves.
    pub(super) fn without_moves(&mut self) {
        self.moves.clear();
    }

    pub(super) fn view(
        self,
        program: &Program,
        plane: Plane,
        coalition: &[bool],
        next: &mut impl FnMut() -> Edge,
    ) -> GameView {
        let names = program.players.iter().flat_map(|players| &players.list);
        let player = |(player, &ours): (&meliora_model::players::Player, _)| PlayerView {
            name: player.name.clone(),
            ours,
            states: next(),
        };
        GameView {
            players: names.zip(coalition).map(player).collect(),
            positions: positions(program, plane),
            moves: self.moves.into_iter().map(|of| of.view(next)).collect(),
        }
    }
}

impl MoveSets {
    fn view(self, next: &mut impl FnMut() -> Edge) -> MoveView {
        let MoveSets { choice, sets, sasi } = self;
        let spi = sets.len() - 5 - sasi;
        MoveView {
            choice,
            enabled: next(),
            may_improve: next(),
            improves: next(),
            may_weaken: next(),
            weakens: next(),
            sasi: (0..sasi).map(|_| next()).collect(),
            spi: (0..spi).map(|_| next()).collect(),
        }
    }
}

/// Computes the sets of the opponent's moves.
fn moves(
    engine: &SymbolicEngine,
    theirs: &StateSet,
    classes: &[Neighbours],
    levels: [&[StateSet]; 2],
    choices: usize,
) -> Result<Vec<MoveSets>> {
    let all = engine.choices_in(&engine.all_choices(), theirs)?;
    let mut kinds = vec![all.clone()];
    let targets: [fn(&Neighbours) -> &StateSet; 2] = [|n| &n.better, |n| &n.worse];
    for target in targets {
        kinds.extend(entering(engine, &all, classes, target)?);
    }
    for levels in levels {
        for rank in ranks(engine, levels)? {
            kinds.push(engine.pre(&all, &rank)?);
        }
    }
    let mut moves = Vec::new();
    for choice in 0..choices {
        let sets = kinds.iter().map(|kind| engine.numbered(kind, choice)).collect::<Result<Vec<_>>>()?;
        if !engine.is_empty(&sets[0])? {
            moves.push(MoveSets { choice, sets, sasi: levels[0].len() + 1 });
        }
    }
    Ok(moves)
}

/// Returns the choices of which some successor, and of which every successor, is in the target of the
/// class of the state.
fn entering(
    engine: &SymbolicEngine,
    all: &ChoiceSet,
    classes: &[Neighbours],
    target: fn(&Neighbours) -> &StateSet,
) -> Result<[ChoiceSet; 2]> {
    let (mut into, mut elsewhere) = (Vec::new(), Vec::new());
    for class in classes {
        let others = engine.difference(&engine.all_states(), target(class))?;
        into.push((class.class.clone(), target(class).clone()));
        elsewhere.push((class.class.clone(), others));
    }
    let leaving = pairs_into(engine, all, elsewhere)?;
    Ok([pairs_into(engine, all, into)?, engine.difference(all, &leaving)?])
}

/// Returns the states of each rank from 0 on, given the states of each level.
fn ranks(engine: &SymbolicEngine, levels: &[StateSet]) -> Result<Vec<StateSet>> {
    let all = engine.all_states();
    let least: Vec<&StateSet> = [&all].into_iter().chain(levels).collect();
    let more = levels.iter().map(Some).chain([None]);
    let rank = |(states, more): (&StateSet, Option<&StateSet>)| match more {
        Some(more) => engine.difference(states, more),
        None => Ok(states.clone()),
    };
    least.into_iter().zip(more).map(rank).collect()
}

/// Returns the position of the plane and those of other pairs of variables, each with the one player
/// whose commands change it; none if several players do.
fn positions(program: &Program, plane: Plane) -> Vec<(usize, Plane)> {
    let all = [plane].into_iter().chain(plane.others(program));
    all.filter_map(|plane| Some((mover(program, plane)?, plane))).collect()
}

/// Returns the player whose commands change a position; `None` if there is not exactly one.
fn mover(program: &Program, plane: Plane) -> Option<usize> {
    let own = |v: VarId| Some(v) == plane.row || v == plane.column;
    let changes = |c: &&meliora_model::Command| c.branches.iter().any(|b| b.updates.iter().any(|u| own(u.0)));
    let mut movers =
        program.commands.iter().filter(changes).map(|command| program.player_of_command(command));
    let first = movers.next()??;
    movers.all(|other| other == Some(first)).then_some(first)
}
