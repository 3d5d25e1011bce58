//! The players of the states of a game, as they are explored.

use super::index::NOBODY;
use super::meter::Array;
use meliora_base::error::Result;

/// The players of the states of a game under exploration.
pub(crate) struct PlayersFound {
    /// The player of each synchronisation.
    of_synchronisation: Vec<u32>,
    /// For each synchronisation, whether its choices must be the only one of a state.
    alone: Vec<bool>,
    pub(crate) of_state: Array<u32>,
}

impl PlayersFound {
    pub(crate) fn new(of_synchronisation: Vec<u32>, alone: Vec<bool>, of_state: Array<u32>) -> Self {
        PlayersFound { of_synchronisation, alone, of_state }
    }

    /// Adds the player of the next state, in which some synchronisations have choices. Returns false if
    /// two players have choices, or several choices have no player.
    pub(crate) fn add(&mut self, active: &[usize], choices: usize) -> Result<bool> {
        let mut owner = NOBODY;
        for &index in active {
            if choices > 1 && self.alone[index] {
                return Ok(false);
            }
            let player = self.of_synchronisation[index];
            if player == NOBODY || player == owner {
                continue;
            }
            if owner != NOBODY {
                return Ok(false);
            }
            owner = player;
        }
        self.of_state.push(owner)?;
        Ok(true)
    }
}
