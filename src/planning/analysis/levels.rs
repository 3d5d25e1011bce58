//! Levels: the states from which k improvements can be made, almost surely (SASI) or with positive
//! probability (SPI).
//!
//! W_0 = S, and W_{k+1} is the set of states from which a goal edge of level k+1 is taken almost
//! surely (SASI) or with positive probability (SPI). A goal edge of level k+1 improves and enters
//! W_k. This is the paper's Algorithm "Level set" on the symmetric halves of V.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Serialize, Serializer};

use super::classes::Classes;
use super::improvement::{Arena, Improvement};
use super::run::Analysis;
use meliora_base::error::Result;
use meliora_engine::edge_labels::{pairs_into, possibly_win};
use meliora_engine::{EdgeLabels, Engine, Region, Won, position};
pub use meliora_model::region::Kind;

/// The number of improvements that can be made from a state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Rank {
    /// Exactly this number.
    Finite(usize),
    /// At least this number: the search for levels ended there.
    AtLeast(usize),
    /// Any number.
    Unbounded,
}

impl JsonSchema for Rank {
    fn schema_name() -> Cow<'static, str> {
        "rank".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "The number of improvements that can be made from a state.",
            "anyOf": [{"type": "integer", "minimum": 0}, {"const": "unbounded"}],
        })
    }
}

/// A number, or `unbounded`.
impl Serialize for Rank {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        match self {
            Rank::Finite(k) | Rank::AtLeast(k) => serializer.serialize_u64(*k as u64),
            Rank::Unbounded => serializer.serialize_str("unbounded"),
        }
    }
}

/// The result for one arena at one level.
pub struct Game<E: Engine> {
    /// The edge labels of the arena, restricted to goal edges that enter W_{k-1}.
    pub edge_labels: Vec<EdgeLabels<E::States>>,
    /// The winning states.
    pub states: E::States,
    /// The kept choices of the winning states. For SASI, only those whose kept edges all are goal
    /// edges or stay in the winning states; for SPI, all.
    pub choices: E::Choices,
}

impl<E: Engine> Clone for Game<E> {
    fn clone(&self) -> Self {
        Game {
            edge_labels: self.edge_labels.clone(),
            states: self.states.clone(),
            choices: self.choices.clone(),
        }
    }
}

/// One level: W_k with its games, one per arena.
pub struct Level<E: Engine> {
    /// W_k
    pub states: E::States,
    /// The games in the order of [`Improvement::arenas`].
    pub games: Vec<Game<E>>,
}

/// The reason why there are no more levels.
pub enum End<E: Engine> {
    /// The next level is empty.
    Empty,
    /// The next level equals the last one: any number of improvements can be made from its states.
    /// The games of this level have the fixpoint as their goal; the last level's games need not.
    Unbounded(Level<E>),
    /// The requested greatest level was reached.
    Cut,
}

/// The levels of one kind, computed one after the other.
pub struct Levels<E: Engine> {
    /// The kind.
    pub kind: Kind,
    /// W_1 ⊋ W_2 ⊋ …, all non-empty.
    pub found: Vec<Level<E>>,
    /// The reason why there are no more levels; `None` while there may be more.
    pub end: Option<End<E>>,
}

impl<E: Engine> Levels<E> {
    /// Creates an empty list of levels.
    pub fn new(kind: Kind) -> Self {
        Levels { kind, found: Vec::new(), end: None }
    }

    /// Computes the next level or the end; returns whether a level was added to `found`. Cost: see
    /// `next_level`.
    ///
    /// # Errors
    /// A limit of the engine is reached; nothing is changed.
    pub fn advance(
        &mut self,
        engine: &E,
        classes: &Classes<E>,
        improvement: &Improvement<E>,
        max_level: Option<usize>,
    ) -> Result<bool> {
        if self.end.is_some() {
            return Ok(false);
        }
        if max_level.is_some_and(|max| self.found.len() >= max) {
            self.end = Some(End::Cut);
            return Ok(false);
        }
        let last = self.found.last();
        let next = next_level(engine, classes, improvement, self.kind, last)?;
        if engine.is_empty(&next.states)? {
            self.end = Some(End::Empty);
        } else if last.map_or(Ok(false), |last| engine.same(&last.states, &next.states))? {
            self.end = Some(End::Unbounded(next));
        } else {
            self.found.push(next);
            return Ok(true);
        }
        Ok(false)
    }

    /// Returns rank(s) = max { k : s ∈ W_k }, unbounded in the fixpoint. The rank is a lower bound
    /// if the search for levels is not complete. Cost: one membership test per level.
    ///
    /// # Errors
    /// The levels belong to another engine.
    pub fn rank(&self, engine: &E, state: &[i64]) -> Result<Rank> {
        self.greatest(|level| engine.contains(&level.states, state))
    }

    /// Returns the greatest level that has a property, given that the levels below have it, too.
    pub(crate) fn greatest(&self, has: impl Fn(&Level<E>) -> Result<bool>) -> Result<Rank> {
        if let Some(fixpoint) = self.unbounded()
            && has(fixpoint)?
        {
            return Ok(Rank::Unbounded);
        }
        let above = position(&self.found, |level| Ok(!has(level)?))?;
        let rank = above.unwrap_or(self.found.len());
        let open = rank == self.found.len() && !matches!(self.end, Some(End::Empty | End::Unbounded(_)));
        Ok(if open { Rank::AtLeast(rank) } else { Rank::Finite(rank) })
    }

    /// Returns the level for states of this rank: `None` for rank 0, the fixpoint if unbounded or
    /// beyond the levels found.
    pub fn level(&self, rank: Rank) -> Option<&Level<E>> {
        match rank {
            Rank::Finite(k) | Rank::AtLeast(k) => self.found.get(k.checked_sub(1)?).or(self.unbounded()),
            Rank::Unbounded => self.unbounded(),
        }
    }

    /// Returns the fixpoint W_k = W_{k+1} ≠ ∅, if it was reached: any number of improvements can be
    /// made from its states.
    pub fn unbounded(&self) -> Option<&Level<E>> {
        match &self.end {
            Some(End::Unbounded(level)) => Some(level),
            _ => None,
        }
    }
}

/// Computes W_1 of SPI, the states from which an improvement is possible; `None` before the improvement
/// MDP is known. Cost: one `can_reach` per arena if no level of SPI is known.
///
/// # Errors
/// A limit of the engine is reached.
pub fn improvable<E: Engine>(analysis: &Analysis<E>) -> Result<Option<E::States>> {
    if let Some(first) = analysis.levels(Kind::Spi).found.first() {
        return Ok(Some(first.states.clone()));
    }
    let Some((classes, improvement)) = analysis.classes().zip(analysis.improvement()) else {
        return Ok(None);
    };
    let first = next_level(analysis.engine(), classes, improvement, Kind::Spi, None)?;
    Ok(Some(first.states))
}

/// Computes W_{k+1} from W_k (`last`; `None` for k = 0, where W_0 = S).
///
/// By induction, levels decrease: fewer goal edges mean fewer winning states. Each game of SASI therefore
/// starts from the states and choices left by the game of the last level. Cost per arena: one
/// pre-image per part for the goal edges, and one `can_reach` (SPI) or one `almost_surely_win`
/// (SASI).
pub(crate) fn next_level<E: Engine>(
    engine: &E,
    classes: &Classes<E>,
    improvement: &Improvement<E>,
    kind: Kind,
    last: Option<&Level<E>>,
) -> Result<Level<E>> {
    let entered = last.map_or_else(|| engine.all_states(), |level| level.states.clone());
    let mut games: Vec<Game<E>> = Vec::with_capacity(improvement.arenas.len());
    for (index, arena) in improvement.arenas.iter().enumerate() {
        let before = last.and_then(|level| level.games.get(index));
        let twin = arena.twin.and_then(|twin| games.get(twin)).cloned();
        games.push(match twin {
            Some(game) => game,
            None => next_game(engine, arena, &entered, before, kind)?,
        });
    }
    let mut states = engine.no_states();
    for (arena, game) in improvement.arenas.iter().zip(&games) {
        let won = match arena.reference {
            // Each state is its own reference when planning starts or after an improvement.
            Some(class) => match classes.list.get(class) {
                Some(class) => engine.intersection(&game.states, &class.states)?,
                None => engine.no_states(),
            },
            None => game.states.clone(),
        };
        states = engine.union(&states, &won)?;
    }
    Ok(Level { states, games })
}

/// Returns the game of an arena whose goal edges enter X, given that of the last level. Its result is that of the last
/// level if the goal edges are.
fn next_game<E: Engine>(
    engine: &E,
    arena: &Arena<E>,
    x: &E::States,
    before: Option<&Game<E>>,
    kind: Kind,
) -> Result<Game<E>> {
    let edge_labels = entering(engine, arena, x)?;
    if let Some(game) = before {
        let goals: Vec<_> = game.edge_labels.iter().zip(&edge_labels).collect();
        if position(&goals, |(x, y)| Ok(!engine.same(&x.goal, &y.goal)?))?.is_none() {
            return Ok(game.clone());
        }
    }
    if position(&edge_labels, |labels| Ok(!engine.is_empty(&labels.goal)?))?.is_none() {
        return Ok(Game { edge_labels, states: engine.no_states(), choices: engine.no_choices() });
    }
    match kind {
        Kind::Sasi => almost_surely(engine, arena, edge_labels, before),
        Kind::Spi => positively(engine, arena, edge_labels, before),
    }
}

/// Returns the edge labels of an arena, restricted to goal edges that enter X. Cost: no image.
pub fn entering<E: Engine>(
    engine: &E,
    arena: &Arena<E>,
    x: &E::States,
) -> Result<Vec<EdgeLabels<E::States>>> {
    let within = |labels: &EdgeLabels<E::States>| {
        Ok(EdgeLabels { goal: engine.intersection(&labels.goal, x)?, ..labels.clone() })
    };
    arena.edge_labels.iter().map(within).collect()
}

/// Computes μX. { s : some kept choice has a goal edge or a kept edge into X }.
///
/// All levels search the choices of the arena, though those of the last level's winning states would do: diagrams know
/// many results for them already. The first level needs no search if that of SASI has found it.
fn positively<E: Engine>(
    engine: &E,
    arena: &Arena<E>,
    edge_labels: Vec<EdgeLabels<E::States>>,
    before: Option<&Game<E>>,
) -> Result<Game<E>> {
    let states = match arena.possible.get().filter(|_| before.is_none()) {
        Some(known) => known.clone(),
        None => possibly_win(engine, &arena.choices, &edge_labels)?,
    };
    let choices = engine.choices_in(&arena.choices, &states)?;
    Ok(Game { edge_labels, states, choices })
}

/// Computes νY. μX. { s : some kept choice has only goal edges and kept edges into Y, and a goal
/// edge or a kept edge into X }.
fn almost_surely<E: Engine>(
    engine: &E,
    arena: &Arena<E>,
    edge_labels: Vec<EdgeLabels<E::States>>,
    before: Option<&Game<E>>,
) -> Result<Game<E>> {
    let start = match before {
        Some(game) => {
            let choices = still_good(engine, &edge_labels, game)?;
            Region { states: game.states.clone(), choices }
        }
        None => Region { states: arena.states.clone(), choices: arena.choices.clone() },
    };
    let Won { region: Region { states, choices }, possible } =
        engine.almost_surely_win(start, &edge_labels)?;
    if let (None, Some(possible)) = (before, possible) {
        arena.possible.get_or_init(|| possible);
    }
    Ok(Game { edge_labels, states, choices })
}

/// Returns the choices of the last level's game that are not lost immediately at the next level.
///
/// A lost choice stays lost: it has an edge that left W_k and was not a goal edge, and both the
/// winning states and the goal edges become fewer. A remaining choice is lost if it has an edge
/// that was a goal edge before, is not a goal edge any more and ends outside of W_k.
fn still_good<E: Engine>(
    engine: &E,
    edge_labels: &[EdgeLabels<E::States>],
    before: &Game<E>,
) -> Result<E::Choices> {
    let mut edges = Vec::with_capacity(edge_labels.len());
    for (new, old) in edge_labels.iter().zip(&before.edge_labels) {
        let gone = engine.difference(&engine.difference(&old.goal, &new.goal)?, &before.states)?;
        edges.push((engine.intersection(&new.from, &before.states)?, gone));
    }
    engine.difference(&before.choices, &pairs_into(engine, &before.choices, edges)?)
}
