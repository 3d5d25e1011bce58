//! The facts about states that an analysis knows: their classes and the levels that contain them.

use crate::equations::graph::{EVERY, Rank};
use meliora_base::error::{Error, Result};
use meliora_engine::Engine;
use meliora_model::Program;
use meliora_model::preference::Change;
use meliora_planning::improvement::Arena;
use meliora_planning::{Analysis, Classes, Improvement, Kind, Levels, Safety};

/// The results of an analysis that the graph needs.
pub(crate) struct Facts<'a, E: Engine> {
    pub(crate) engine: &'a E,
    pub(crate) program: &'a Program,
    pub(crate) classes: &'a Classes<E>,
    pub(crate) improvement: &'a Improvement<E>,
    spi: &'a Levels<E>,
    /// The SASI levels.
    sasi: &'a Levels<E>,
    /// Under `transition`, the SASI levels of `action`, where P_k = 1.
    strict: Option<Levels<E>>,
    /// The states of which each arena does not keep all choices that the program lists: the safety
    /// mode or the requirements forbid some.
    pub(crate) restricted: Vec<E::States>,
}

/// A state, with the sets of [`Facts::sets`] that contain it, if they are not too many.
#[derive(Clone, Copy)]
pub(crate) struct Seen<'s> {
    pub(crate) state: &'s [i64],
    pub(crate) marks: Option<u64>,
}

/// The numbers of the sets of an arena among [`Facts::sets`]: first its restricted states, then its levels
/// of SPI and of SASI, each with the fixpoint first.
#[derive(Clone, Copy)]
pub(crate) struct Numbers {
    arena: u32,
    pub(crate) restricted: usize,
    levels: [usize; 2],
}

impl<'a, E: Engine> Facts<'a, E> {
    /// Takes the results of an analysis. Under `transition`, computes the SASI levels of `action` up
    /// to the given one. Cost: that of the levels.
    ///
    /// # Errors
    /// The levels of the analysis are not known, or a limit is reached.
    pub(crate) fn new(analysis: &'a Analysis<E>, program: &'a Program, levels: usize) -> Result<Self> {
        let missing = || Error::Usage("quantities need the levels; run the analysis first".to_owned());
        let classes = analysis.classes().ok_or_else(missing)?;
        let improvement = analysis.improvement().ok_or_else(missing)?;
        let [sasi, spi] = [Kind::Sasi, Kind::Spi].map(|kind| analysis.levels(kind));
        if sasi.end.is_none() || spi.end.is_none() {
            return Err(missing());
        }
        let engine = analysis.engine();
        let mut strict = None;
        if !improvement.safety.never_weakens() {
            let action = Improvement::new(engine, classes, Safety::Action)?;
            let sure = strict.insert(Levels::new(Kind::Sasi));
            while sure.advance(engine, classes, &action, Some(levels))? {}
        }
        let restricted = |arena: &Arena<E>| analysis.partly_in(&arena.choices);
        let restricted = improvement.arenas.iter().map(restricted).collect::<Result<_>>()?;
        Ok(Facts { engine, program, classes, improvement, spi, sasi, strict, restricted })
    }

    /// Returns the levels where P_k = 1.
    fn sasi(&self) -> &Levels<E> {
        self.strict.as_ref().unwrap_or(self.sasi)
    }

    /// Returns the effect of a step between two classes; see [`Classes::change`].
    pub(crate) fn change(&self, from: Option<u32>, to: Option<u32>) -> Change {
        self.classes.change(from.map(|from| from as usize), to.map(|to| to as usize))
    }

    /// Returns the sets in which states are looked up: the classes, and for each arena its restricted
    /// states and the states of its levels.
    pub(crate) fn sets(&self) -> Vec<&E::States> {
        let mut sets: Vec<&E::States> = self.classes.list.iter().map(|class| &class.states).collect();
        for (arena, restricted) in self.restricted.iter().enumerate() {
            sets.push(restricted);
            for levels in [self.spi, self.sasi()] {
                let all = levels.unbounded().into_iter().chain(&levels.found);
                sets.extend(all.filter_map(|level| level.games.get(arena)).map(|game| &game.states));
            }
        }
        sets
    }

    /// Returns the numbers of the sets of an arena among [`Facts::sets`].
    pub(crate) fn numbers(&self, arena: u32) -> Numbers {
        let of = |levels: &Levels<E>, arena: usize| {
            let all = levels.unbounded().into_iter().chain(&levels.found);
            all.filter(|level| level.games.get(arena).is_some()).count()
        };
        let [spi, sasi] = [self.spi, self.sasi()];
        let before = (0..arena as usize).map(|arena| 1 + of(spi, arena) + of(sasi, arena)).sum::<usize>();
        let restricted = self.classes.list.len() + before;
        let first = restricted + 1;
        Numbers { arena, restricted, levels: [first, first + of(spi, arena as usize)] }
    }

    /// Returns whether a set contains a state.
    fn contains(&self, number: usize, set: &E::States, seen: Seen<'_>) -> Result<bool> {
        match seen.marks {
            Some(marks) => Ok(marks >> number & 1 == 1),
            None => self.engine.contains(set, seen.state),
        }
    }

    /// Returns the number of levels that contain a state in an arena, or [`EVERY`]; `first` is the number of
    /// their first set.
    fn rank_in(&self, first: usize, levels: &Levels<E>, arena: u32, seen: Seen<'_>) -> Result<u32> {
        let all = levels.unbounded().into_iter().chain(&levels.found);
        let games = all.map(|level| level.games.get(arena as usize));
        let (mut number, mut rank) = (first, 0);
        for (position, game) in games.enumerate() {
            let is_fixpoint = position == 0 && levels.unbounded().is_some();
            let holds = match game {
                Some(game) => self.contains(number, &game.states, seen)?,
                None => false,
            };
            number += usize::from(game.is_some());
            match (is_fixpoint, holds) {
                (true, true) => return Ok(EVERY),
                (true, false) => {}
                (false, true) => rank += 1,
                (false, false) => break,
            }
        }
        Ok(rank)
    }

    /// Returns what the levels say about a state in an arena.
    pub(crate) fn rank(&self, numbers: Option<Numbers>, seen: Seen<'_>) -> Result<Rank> {
        let Some(Numbers { arena, levels: [spi, sasi], .. }) = numbers else { return Ok(Rank::default()) };
        let positive = self.rank_in(spi, self.spi, arena, seen)?;
        // W_k of SASI is a subset of W_k of SPI.
        let sure = if positive == 0 { 0 } else { self.rank_in(sasi, self.sasi(), arena, seen)? };
        Ok(Rank { positive, sure })
    }

    /// Returns the arena of the states of a class; see [`Improvement::arena_of`].
    pub(crate) fn arena_of(&self, class: Option<u32>) -> Option<u32> {
        let arena = self.improvement.arena_of(class.map(|class| class as usize));
        arena.map(|arena| arena as u32)
    }

    /// Returns the class of a state; `guess` is tested first.
    pub(crate) fn class(&self, seen: Seen<'_>, guess: Option<u32>) -> Result<Option<u32>> {
        if let Some(class) = guess
            && self.contains(class as usize, &self.classes.list[class as usize].states, seen)?
        {
            return Ok(guess);
        }
        let class = match seen.marks {
            Some(marks) => {
                Some(marks.trailing_zeros() as usize).filter(|&class| class < self.classes.list.len())
            }
            None => self.classes.of(self.engine, seen.state)?,
        };
        Ok(class.map(|class| class as u32))
    }
}
