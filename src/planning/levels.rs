//! Levels: from where k improvements can be made, almost surely (SASI) or possibly (SPI).
//!
//! W_0 = S and W_{k+1} = the states from which a goal edge of level k+1 is taken almost surely
//! (SASI) or with positive probability (SPI); a goal edge of level k+1 improves and enters W_k.
//! This is the paper's Algorithm "Level set" on the symmetric halves of V.

use std::fmt;

use serde::{Serialize, Serializer};

use super::classes::Classes;
use super::improvement::{Arena, Improvement, Safety};
use crate::engine::edge_labels::{pairs_into, winning};
use crate::engine::{EdgeLabels, Engine, Region};
use crate::error::Result;

/// Which of the paper's two solution concepts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Safe and almost-surely improving.
    Sasi,
    /// Safe and positively improving.
    Spi,
}

impl Kind {
    /// Both.
    pub const ALL: [Kind; 2] = [Kind::Sasi, Kind::Spi];

    /// The name in regions, reports and options.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Sasi => "sasi",
            Kind::Spi => "spi",
        }
    }

    /// The kind of a name.
    pub fn named(name: &str) -> Option<Kind> {
        Kind::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Kind::Sasi => "SASI",
            Kind::Spi => "SPI",
        })
    }
}

/// How many improvements a state has before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Rank {
    /// Exactly so many.
    Finite(usize),
    /// So many, and perhaps more: the search ended there.
    AtLeast(usize),
    /// Any number.
    Unbounded,
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

/// What is won in one arena at one level.
pub struct Game<E: Engine> {
    /// Those of the arena, where improving steps must enter W_{k-1} to win.
    pub edge_labels: Vec<EdgeLabels<E::States>>,
    /// The winning states.
    pub states: E::States,
    /// Of the kept choices of the winning states: for SASI those whose kept edges all are goal edges
    /// or stay in the winning states; for SPI all.
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

/// One level: W_k with the games it was won in, one an arena.
pub struct Level<E: Engine> {
    /// W_k
    pub states: E::States,
    /// In the order of [`Improvement::arenas`].
    pub games: Vec<Game<E>>,
}

/// Why there are no more levels.
pub enum End<E: Engine> {
    /// The next level is empty.
    Empty,
    /// The next level has the states of the last one: from these any number of improvements can be
    /// made. Its games have that fixpoint as their goal; the last level's games need not.
    Unbounded(Level<E>),
    /// The greatest level asked for was reached.
    Cut,
}

/// The levels of one kind, found one after the other.
pub struct Levels<E: Engine> {
    /// Which kind.
    pub kind: Kind,
    /// W_1 ⊋ W_2 ⊋ …, none of them empty.
    pub found: Vec<Level<E>>,
    /// Why there are no more; none while there may be.
    pub end: Option<End<E>>,
}

impl<E: Engine> Levels<E> {
    /// No level yet.
    pub fn new(kind: Kind) -> Self {
        Levels { kind, found: Vec::new(), end: None }
    }

    /// Finds the next level or the end, and says whether a level was added to `found`.
    ///
    /// # Errors
    /// A limit of the engine; nothing is changed then. Cost: see [`next_level`].
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
        if engine.is_empty(&next.states) {
            self.end = Some(End::Empty);
        } else if last.is_some_and(|last| engine.same(&last.states, &next.states)) {
            self.end = Some(End::Unbounded(next));
        } else {
            self.found.push(next);
            return Ok(true);
        }
        Ok(false)
    }

    /// rank(s) = max { k : s ∈ W_k }, unbounded in the fixpoint; at least that where the search for levels
    /// has not come to its end. Cost: one membership a level.
    pub fn rank(&self, engine: &E, state: &[i64]) -> Rank {
        let holds = |level: &Level<E>| engine.contains(&level.states, state);
        if matches!(&self.end, Some(End::Unbounded(fixpoint)) if holds(fixpoint)) {
            return Rank::Unbounded;
        }
        let rank = self.found.iter().take_while(|level| holds(level)).count();
        let open = rank == self.found.len() && !matches!(self.end, Some(End::Empty | End::Unbounded(_)));
        if open { Rank::AtLeast(rank) } else { Rank::Finite(rank) }
    }

    /// The level that a state of this rank plays: none for rank 0, the fixpoint where unbounded.
    pub fn level(&self, rank: Rank) -> Option<&Level<E>> {
        match rank {
            Rank::Finite(k) | Rank::AtLeast(k) => self.found.get(k.checked_sub(1)?),
            Rank::Unbounded => self.unbounded(),
        }
    }

    /// The fixpoint W_k = W_{k+1} ≠ ∅, if it was reached: from there any number of improvements can be made.
    pub fn unbounded(&self) -> Option<&Level<E>> {
        match &self.end {
            Some(End::Unbounded(level)) => Some(level),
            _ => None,
        }
    }
}

/// W_{k+1} from W_k (`last`; none for k = 0, where W_0 = S).
///
/// Levels decrease, by induction: fewer goals, fewer wins. So each game starts from the states and
/// choices left by its game of the level before.
///
/// # Errors
/// A limit of the engine. Cost, an arena: a pre-image a part for the goal edges; then for SPI one
/// `can_reach`, for SASI one `almost_surely_win`.
pub fn next_level<E: Engine>(
    engine: &E,
    classes: &Classes<E>,
    improvement: &Improvement<E>,
    kind: Kind,
    last: Option<&Level<E>>,
) -> Result<Level<E>> {
    let entered = last.map_or_else(|| engine.all_states(), |level| level.states.clone());
    let (mut states, mut games) = (engine.no_states(), Vec::new());
    for (index, arena) in improvement.arenas.iter().enumerate() {
        let before = last.and_then(|level| level.games.get(index));
        let game = play(engine, arena, kind, &entered, before)?;
        let won = match arena.reference.filter(|_| improvement.safety == Safety::Prefix) {
            // Each state is its own reference when planning starts or an improvement is made.
            Some(class) => match classes.list.get(class) {
                Some(class) => engine.intersection(&game.states, &class.states)?,
                None => engine.no_states(),
            },
            None => game.states.clone(),
        };
        states = engine.union(&states, &won)?;
        games.push(game);
    }
    Ok(Level { states, games })
}

fn play<E: Engine>(
    engine: &E,
    arena: &Arena<E>,
    kind: Kind,
    entered: &E::States,
    before: Option<&Game<E>>,
) -> Result<Game<E>> {
    let edge_labels = entering(engine, arena, entered)?;
    match before {
        Some(game)
            if game.edge_labels.iter().zip(&edge_labels).all(|(x, y)| engine.same(&x.goal, &y.goal)) =>
        {
            Ok(game.clone())
        }
        _ => match kind {
            Kind::Sasi => almost_surely(engine, arena, edge_labels, before),
            Kind::Spi => positively(engine, arena, edge_labels, before),
        },
    }
}

/// The edge labels of an arena, of which improving steps must enter X to win.
///
/// # Errors
/// A limit of the engine. Cost: no image.
pub(crate) fn entering<E: Engine>(
    engine: &E,
    arena: &Arena<E>,
    x: &E::States,
) -> Result<Vec<EdgeLabels<E::States>>> {
    let within =
        |m: &EdgeLabels<E::States>| Ok(EdgeLabels { goal: engine.intersection(&m.goal, x)?, ..m.clone() });
    arena.edge_labels.iter().map(within).collect()
}

/// μX. { s : some kept choice has a goal edge or a kept edge into X }.
///
/// Starting with the choices of the states won before is sound: W_{k+1} ⊆ W_k, arena by arena.
fn positively<E: Engine>(
    engine: &E,
    arena: &Arena<E>,
    edge_labels: Vec<EdgeLabels<E::States>>,
    before: Option<&Game<E>>,
) -> Result<Game<E>> {
    let within = before.map_or(&arena.choices, |game| &game.choices);
    let goals = winning(engine, &engine.all_choices(), &edge_labels)?;
    let seeds = engine.sources(&engine.intersection(within, &goals)?)?;
    let states = engine.can_reach(&seeds, within, &edge_labels)?;
    let choices = engine.choices_in(within, &states)?;
    Ok(Game { edge_labels, states, choices })
}

/// νY. μX. { s : some kept choice has every kept edge in Y or a goal edge, and one in X or a goal
/// edge }.
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
    let Region { states, choices } = engine.almost_surely_win(start, &edge_labels)?;
    Ok(Game { edge_labels, states, choices })
}

/// The choices of the last level's game that are not lost at once at the next level.
///
/// A choice that was lost stays lost: its bad edge left W_k and was no goal edge, and now both the
/// winning states and the goals are fewer. Of the others, those are lost that have an edge which was
/// a goal edge, is none any more and ends outside of W_k.
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
