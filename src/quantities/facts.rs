//! The facts about states that an analysis knows: their classes and the levels that contain them.

use std::cell::OnceCell;

use smallvec::SmallVec;

use crate::distances::Distances;
use meliora_base::error::{Error, Result};
use meliora_base::progress::ProgressSink;
use meliora_engine::Engine;
use meliora_engine::membership::{self, Membership};
use meliora_equations::{EVERY, Rank};
use meliora_model::Program;
use meliora_model::preference::Change;
use meliora_model::step::Choice;
use meliora_planning::improvement::Arena;
use meliora_planning::levels::Game;
use meliora_planning::{Analysis, Classes, Improvement, Kind, Levels, Safety};

/// The results of an analysis that the graph needs.
pub(crate) struct Facts<'a, E: Engine> {
    engine: &'a E,
    program: &'a Program,
    pub(crate) classes: &'a Classes<E>,
    improvement: &'a Improvement<E>,
    spi: &'a Levels<E>,
    /// The SASI levels.
    sasi: &'a Levels<E>,
    /// Under `transition`, the SASI levels of `action`, where P_k = 1.
    strict: Option<Levels<E>>,
    /// The states of which each arena does not keep all choices that the program lists: the safety
    /// mode or the requirements forbid some.
    restricted: Vec<E::States>,
    /// The states in which the opponent of a game chooses.
    theirs: Option<E::States>,
    /// The tests of the arenas in which states were looked up.
    tests: Vec<OnceCell<Test<'a>>>,
    /// The distances of each arena in which they were asked for.
    distances: Vec<OnceCell<Distances<'a, E>>>,
    /// The steps that the engine may have taken when distances are computed: those of the states asked for take no more steps
    /// than there were before, and those of other states a quarter of those.
    budgets: [OnceCell<u64>; 2],
}

/// A test for membership in any number of sets.
struct Joined<'e>(Vec<Box<dyn Membership + 'e>>);

impl<'e> Joined<'e> {
    fn new<E: Engine>(engine: &'e E, sets: &[&E::States]) -> Result<Self> {
        sets.chunks(membership::MOST).map(|sets| engine.membership(sets)).collect::<Result<_>>().map(Joined)
    }

    /// Returns the sets that contain a state: bit i % 64 of word i / 64 for set i.
    fn of(&self, state: &[i64]) -> Result<SmallVec<[u64; 1]>> {
        self.0.iter().map(|sets| sets.of(state)).collect()
    }
}

/// The class of a state, and what an arena knows about it.
#[derive(Clone, Copy, Default)]
pub(crate) struct Standing {
    pub(crate) class: Option<u32>,
    pub(crate) rank: Rank,
    /// True if the arena keeps every choice.
    pub(crate) unrestricted: bool,
}

/// The levels of one kind that count in an arena. Their sets are nested.
#[derive(Clone, Copy)]
struct Ladder {
    has_fixpoint: bool,
    levels: usize,
}

/// The test of the states of an arena for membership in the classes, in its restricted states, and in its levels of SPI and
/// of SASI, each with the fixpoint first.
struct Test<'e> {
    sets: Joined<'e>,
    classes: usize,
    ladders: [Ladder; 2],
}

impl Test<'_> {
    /// Returns the class of a state, and what the arena knows about it. Cost: one membership test.
    fn standing(&self, state: &[i64]) -> Result<Standing> {
        let marks = self.sets.of(state)?;
        let has = |set: usize| marks[set / membership::MOST] >> (set % membership::MOST) & 1 == 1;
        let class = (0..self.classes).find(|&class| has(class)).map(|class| class as u32);
        let unrestricted = !has(self.classes);
        let mut first = self.classes + 1;
        let [positive, sure] = self.ladders.map(|Ladder { has_fixpoint, levels }| {
            let own = first + usize::from(has_fixpoint)..first + usize::from(has_fixpoint) + levels;
            let is_endless = has_fixpoint && has(first);
            first = own.end;
            if is_endless { EVERY } else { own.take_while(|&level| has(level)).count() as u32 }
        });
        Ok(Standing { class, rank: Rank { positive, sure }, unrestricted })
    }
}

/// The questions of an exploration about states. They hide the engine, so that the exploration is compiled once.
pub(crate) trait Known {
    fn program(&self) -> &Program;

    fn sink(&self) -> &dyn ProgressSink;

    /// Returns the number of arenas.
    fn arenas(&self) -> usize;

    /// Returns the class with which the states of an arena are compared; `None` for their own ones.
    fn reference(&self, arena: usize) -> Option<u32>;

    /// Returns whether states are compared with those where planning started.
    fn has_reference(&self) -> bool;

    /// Returns the arena of the states of a class; see [`Improvement::arena_of`].
    fn arena_of(&self, class: Option<u32>) -> Option<u32>;

    /// Returns the effect of a step between two classes; see [`Classes::change`].
    fn change(&self, from: Option<u32>, to: Option<u32>) -> Change;

    /// Returns the class of a state. Cost: one membership test per class.
    fn class(&self, state: &[i64]) -> Result<Option<u32>>;

    /// Returns what an arena knows about a state. Cost: one membership test; the first one in an arena builds it.
    ///
    /// # Errors
    /// A limit is reached.
    fn standing(&self, arena: usize, state: &[i64]) -> Result<Standing>;

    /// Returns whether an arena keeps a choice of a state.
    fn keeps(&self, arena: usize, state: &[i64], choice: &Choice) -> Result<bool>;

    /// Returns a lower bound of the number of steps of a state of an arena to an improvement that is certain; 0 if none is
    /// known. Cost: see [`Distances::steps`].
    ///
    /// # Errors
    /// A limit is reached.
    fn steps(&self, arena: usize, state: &[i64]) -> Result<u32>;

    /// Returns whether such a bound remains as it is after [`Known::measure`].
    fn is_tight(&self, arena: usize, steps: u32) -> bool;

    /// Lets these bounds be tight for a state of an arena that is asked for, or another one, as far as that does not take too
    /// many steps of the engine. Cost: see [`Distances::widen`].
    ///
    /// # Errors
    /// A limit is reached.
    fn measure(&self, arena: usize, state: &[i64], is_asked: bool) -> Result<()>;

    /// Returns whether the model is a game.
    fn is_game(&self) -> bool;

    /// Returns whether the opponent chooses in a state of a game.
    fn is_theirs(&self, state: &[i64]) -> Result<bool>;
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
        let restricted: Vec<_> = improvement.arenas.iter().map(restricted).collect::<Result<_>>()?;
        let theirs = engine.theirs();
        let tests = improvement.arenas.iter().map(|_| OnceCell::new()).collect();
        let distances = improvement.arenas.iter().map(|_| OnceCell::new()).collect();
        let budgets = Default::default();
        Ok(Facts {
            engine,
            program,
            classes,
            improvement,
            spi,
            sasi,
            strict,
            restricted,
            theirs,
            tests,
            distances,
            budgets,
        })
    }

    /// Builds the test of the states of an arena.
    fn test(&self, arena: usize) -> Result<Test<'a>> {
        let mut sets: Vec<_> = self.classes.list.iter().map(|class| &class.states).collect();
        sets.push(&self.restricted[arena]);
        let ladders = [self.spi, self.sasi()].map(|levels| Self::add_levels(levels, arena, &mut sets));
        Ok(Test { sets: Joined::new(self.engine, &sets)?, classes: self.classes.list.len(), ladders })
    }

    /// Returns the levels where P_k = 1.
    fn sasi(&self) -> &Levels<E> {
        self.strict.as_ref().unwrap_or(self.sasi)
    }

    /// Adds the sets of the levels that count in an arena.
    fn add_levels<'s>(levels: &'s Levels<E>, arena: usize, sets: &mut Vec<&'s E::States>) -> Ladder {
        let of = |game: &'s Game<E>| &game.states;
        let fixpoint = levels.unbounded().and_then(|level| level.games.get(arena)).map(of);
        let has_fixpoint = fixpoint.is_some();
        sets.extend(fixpoint);
        let before = sets.len();
        sets.extend(levels.found.iter().filter_map(|level| level.games.get(arena)).map(of));
        Ladder { has_fixpoint, levels: sets.len() - before }
    }
}

impl<E: Engine> Known for Facts<'_, E> {
    fn program(&self) -> &Program {
        self.program
    }

    fn sink(&self) -> &dyn ProgressSink {
        &*self.engine.settings().sink
    }

    fn arenas(&self) -> usize {
        self.improvement.arenas.len()
    }

    fn reference(&self, arena: usize) -> Option<u32> {
        self.improvement.arenas[arena].reference.map(|class| class as u32)
    }

    fn has_reference(&self) -> bool {
        self.improvement.safety.has_reference()
    }

    fn arena_of(&self, class: Option<u32>) -> Option<u32> {
        let arena = self.improvement.arena_of(class.map(|class| class as usize));
        arena.map(|arena| arena as u32)
    }

    fn change(&self, from: Option<u32>, to: Option<u32>) -> Change {
        self.classes.change(from.map(|from| from as usize), to.map(|to| to as usize))
    }

    fn class(&self, state: &[i64]) -> Result<Option<u32>> {
        Ok(self.classes.of(self.engine, state)?.map(|class| class as u32))
    }

    fn standing(&self, arena: usize, state: &[i64]) -> Result<Standing> {
        let known = &self.tests[arena];
        let test = match known.get() {
            Some(test) => test,
            None => {
                let test = self.test(arena)?;
                known.get_or_init(|| test)
            }
        };
        test.standing(state)
    }

    fn keeps(&self, arena: usize, state: &[i64], choice: &Choice) -> Result<bool> {
        self.engine.contains_choice(&self.improvement.arenas[arena].choices, state, choice)
    }

    fn steps(&self, arena: usize, state: &[i64]) -> Result<u32> {
        self.distances[arena].get().map_or(Ok(0), |distances| distances.steps(state))
    }

    fn is_tight(&self, arena: usize, steps: u32) -> bool {
        self.distances[arena].get().is_none_or(|distances| distances.is_tight(steps))
    }

    fn measure(&self, arena: usize, state: &[i64], is_asked: bool) -> Result<()> {
        // The strict levels are owned by the facts; without them, those of the analysis are the certain ones.
        let levels = if self.strict.is_some() { None } else { self.sasi.found.first() };
        let Some(game) = levels.and_then(|level| level.games.get(arena)) else { return Ok(()) };
        let [first, other] = &self.budgets;
        let before = self.engine.usage().steps;
        let first = *first.get_or_init(|| 2 * before);
        let budget = if is_asked { first } else { *other.get_or_init(|| before + (before - first / 2) / 4) };
        let known = &self.distances[arena];
        let distances = match known.get() {
            Some(distances) => distances,
            None if self.engine.usage().steps >= budget => return Ok(()),
            None => {
                let distances = Distances::new(self.engine, game)?;
                known.get_or_init(|| distances)
            }
        };
        distances.widen(state, budget)
    }

    fn is_game(&self) -> bool {
        self.theirs.is_some()
    }

    fn is_theirs(&self, state: &[i64]) -> Result<bool> {
        self.theirs.as_ref().map_or(Ok(false), |theirs| self.engine.contains(theirs, state))
    }
}
