//! The players of a game in reports.

use schemars::JsonSchema;
use serde::Serialize;

use super::text::Grid;
use super::{Number, Style};
use meliora_base::error::Result;
use meliora_engine::Engine;
use meliora_model::Program;

/// A player of a game.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
#[schemars(rename = "player")]
pub struct PlayerSummary {
    /// Its name.
    pub name: String,
    /// It is one of us.
    pub ours: bool,
    /// The number of states of the scope in which it chooses.
    pub states: Number,
}

impl PlayerSummary {
    /// Returns all players of a game; empty for other models. Cost: counting, no image.
    ///
    /// # Errors
    /// A limit is reached.
    pub fn all<E: Engine>(program: &Program, engine: &E) -> Result<Vec<Self>> {
        let players = program.players.iter().flat_map(|players| &players.list);
        let all = players.zip(engine.player_states()).zip(engine.coalition());
        let one = |((player, states), ours): ((&meliora_model::players::Player, _), bool)| {
            Ok(PlayerSummary { name: player.name.clone(), ours, states: engine.count(&states)?.into() })
        };
        all.map(one).collect()
    }
}

/// Lists the players of a game; empty for other models.
pub(super) fn text(players: &[PlayerSummary], style: Style) -> String {
    if players.is_empty() {
        return String::new();
    }
    let mut grid = Grid::new(&["", "side", "states"]);
    for PlayerSummary { name, ours, states } in players {
        let side = if *ours { "ours" } else { "opponent" };
        grid.row(vec![name.clone(), side.to_owned(), states.grouped()]);
    }
    grid.titled("Players", style)
}
