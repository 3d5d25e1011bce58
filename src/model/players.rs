//! The players of a game, and which of them we are.

use std::borrow::Borrow;
use std::ops::Range;

use super::{Command, Program, Synchronisation};
use crate::step::Choice;
use meliora_base::error::{Diagnostic, Result, Severity};

/// The players of a turn-based game. Each choice belongs to one player: that of its action, or for an
/// unlabelled command that of its module. If no player lists these, see [`Unlisted`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Players {
    /// The players in the order of declaration.
    pub list: Vec<Player>,
    /// The player of each module; `None` for a module that no player lists, and for monitors.
    pub of_module: Vec<Option<usize>>,
    /// The player of each action; `None` if no player lists it, or if a choice with the action belongs to the
    /// player of its module, as in models that list their states.
    pub of_action: Vec<Option<usize>>,
    /// The position of `smg` in the text.
    pub span: Range<usize>,
}

/// A player.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Player {
    /// Its name.
    pub name: String,
    /// True if we choose its moves, false if the opponent does.
    pub ours: bool,
}

/// The player of a choice whose action or module no player lists. Such a command stands in the program
/// once for each case, with the case in its guard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unlisted {
    /// The player at this position, who has another choice in the state.
    With(u32),
    /// The first player's in a state where it is the only choice.
    Alone,
}

/// The player who chooses in a state of a game.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Owner {
    /// The player, by its position in [`Players::list`].
    pub player: usize,
    /// True if it is one of us.
    pub ours: bool,
}

impl Players {
    /// Returns for each player whether we choose its moves.
    pub fn coalition(&self) -> Vec<bool> {
        self.list.iter().map(|player| player.ours).collect()
    }

    /// Returns the coalition of these players, each given by its name or its number from 1 on.
    ///
    /// # Errors
    /// The position of a word that is not a player.
    pub fn named(&self, words: &[impl Borrow<str>]) -> std::result::Result<Vec<bool>, usize> {
        let mut coalition = vec![false; self.list.len()];
        for (at, word) in words.iter().enumerate() {
            *coalition.get_mut(self.find(word.borrow()).ok_or(at)?).ok_or(at)? = true;
        }
        Ok(coalition)
    }

    /// Returns the position of a player, given by its name or its number from 1 on.
    fn find(&self, word: &str) -> Option<usize> {
        let by_name = self.list.iter().position(|player| player.name == word);
        by_name.or_else(|| word.parse::<usize>().ok()?.checked_sub(1)).filter(|&at| at < self.list.len())
    }

    /// Returns the names of all players, as in "`p1`, `p2`".
    pub fn names(&self) -> String {
        self.list.iter().map(|player| format!("`{}`", player.name)).collect::<Vec<_>>().join(", ")
    }
}

impl Program {
    /// Refuses a game, for work that knows one player only; `what` names the work, as in "`values`".
    ///
    /// # Errors
    /// The model is a game; the error points at `smg`.
    pub fn of_one_player(&self, what: &str) -> Result<()> {
        let help = "`values` computes the probabilities and costs against an opponent, and `export --format umb --values` writes them";
        self.refuse_game(what, help)
    }

    /// Does the same as [`Program::of_one_player`] with other advice.
    ///
    /// # Errors
    /// See [`Program::of_one_player`].
    pub fn refuse_game(&self, what: &str, help: &str) -> Result<()> {
        let Some(players) = &self.players else { return Ok(()) };
        let message = format!("{what} of a game is not supported");
        let diagnostic = Diagnostic::new(&self.source, players.span.clone(), message);
        Err(diagnostic.severity(Severity::Unsupported).label("a game").help(help).into())
    }

    /// Lets us be the players of a coalition of a game, as [`Players::coalition`] returns it.
    pub fn play_as(&mut self, coalition: &[bool]) {
        let players = self.players.iter_mut().flat_map(|players| &mut players.list);
        players.zip(coalition).for_each(|(player, &ours)| player.ours = ours);
    }

    /// Returns the player to which a choice belongs; `None` if the model is not a game, and for the
    /// self-loops of deadlocks.
    pub fn player_of_choice(&self, choice: &Choice) -> Option<usize> {
        match choice {
            Choice::Combination { synchronisation, .. } => {
                self.player_of(self.synchronisations.get(*synchronisation)?)
            }
            Choice::Uniform | Choice::Deadlock => None,
        }
    }

    /// Returns the player to which the choices of a synchronisation belong; `None` if the model is not
    /// a game, and for the self-loops that monitors give to deadlocks.
    pub fn player_of(&self, synchronisation: &Synchronisation) -> Option<usize> {
        let command = &self.commands[synchronisation.factors.first()?.first()?.index()];
        self.owner(synchronisation.action, command)
    }

    /// Returns the case for which the choices of a synchronisation stand in the program, if no player lists them.
    pub fn unlisted(&self, synchronisation: &Synchronisation) -> Option<Unlisted> {
        self.commands[synchronisation.factors.first()?.first()?.index()].unlisted
    }

    /// Returns the player whose choices execute a command; `None` if the model is not a game.
    pub fn player_of_command(&self, command: &Command) -> Option<usize> {
        self.owner(command.action, command)
    }

    /// Returns the owner of an action or, if it has none, of a command that has it.
    fn owner(&self, action: Option<usize>, command: &Command) -> Option<usize> {
        let players = self.players.as_ref()?;
        match command.unlisted {
            Some(Unlisted::With(player)) => Some(player as usize),
            Some(Unlisted::Alone) => Some(0),
            None => action
                .and_then(|action| *players.of_action.get(action)?)
                .or_else(|| *players.of_module.get(command.module)?),
        }
    }
}
