//! Games against an opponent: who chooses in a state, and the fixpoints for both sides.
//!
//! A state of ours wins with one good choice, a state of the opponent if all its enabled choices are
//! good. Each fixpoint is a work list that counts the choices a state still needs.

use std::sync::Arc;

use super::almost_sure::Rules;
use super::fixpoint::Removal;
use super::frontier::Frontier;
use super::{ExplicitEngine, StateSet};
use crate::engine::Region;
use meliora_base::error::{Error, Result};
use meliora_space::meter::Array;
use meliora_space::set::{BitSet, clear, set, test};

/// The players of a game, and the coalition that we are.
#[derive(Clone)]
pub(super) struct Game {
    /// The player of each state; [`NOBODY`] for deadlocks.
    players: Arc<Array<u32>>,
    /// For each player, whether it is one of us.
    pub(super) coalition: Vec<bool>,
    /// The states of the opponent; `None` if there are none.
    pub(super) theirs: Option<BitSet>,
}

impl Game {
    /// Creates a game from the player of each state.
    pub(super) fn new(players: Arc<Array<u32>>, coalition: Vec<bool>, empty: BitSet) -> Self {
        let is_theirs = |player: u32| coalition.get(player as usize).is_some_and(|ours| !ours);
        let theirs = select(&players, empty, is_theirs);
        Game { players, theirs: (!theirs.is_empty()).then_some(theirs), coalition }
    }
}

/// Adds the states of selected players to an empty set.
fn select(players: &Array<u32>, mut states: BitSet, is_selected: impl Fn(u32) -> bool) -> BitSet {
    let words = states.words_mut();
    (0..players.len()).filter(|&s| is_selected(players[s])).for_each(|s| set(words, s));
    states
}

impl ExplicitEngine {
    /// Returns the states of the opponent, if there are some.
    pub(super) fn opponent(&self) -> Option<&BitSet> {
        self.game.as_ref()?.theirs.as_ref()
    }

    /// See [`crate::Engine::player_states`].
    pub(super) fn states_by_player(&self) -> Vec<StateSet> {
        let Some(game) = &self.game else { return Vec::new() };
        let empty = || BitSet::empty(&self.meter, self.graph.states());
        let of = |at: usize| StateSet(select(&game.players, empty(), |player| player as usize == at));
        (0..game.coalition.len()).map(of).collect()
    }

    /// See [`crate::Engine::with_coalition`].
    pub(super) fn played_by(&self, coalition: &[bool]) -> Result<Self> {
        let players = self.game.as_ref().filter(|game| game.coalition.len() == coalition.len());
        let Some(game) = players else {
            return Err(Error::Usage("a coalition has one entry per player of a game".to_owned()));
        };
        let empty = BitSet::empty(&self.meter, self.graph.states());
        let game = Game::new(Arc::clone(&game.players), coalition.to_vec(), empty);
        Ok(ExplicitEngine { game: Some(game), ..self.clone() })
    }

    /// Returns the choices that the engine admits in a state.
    fn admitted(&self, state: usize) -> impl Iterator<Item = usize> {
        self.graph.choices_of(state).filter(|&choice| self.every_choice.has(choice))
    }

    /// Removes from the sources of C the states of the opponent with an enabled choice that is not in
    /// C.
    pub(super) fn without_escapes(&self, mut sources: BitSet, c: &BitSet) -> Result<BitSet> {
        let Some(theirs) = self.opponent() else { return Ok(sources) };
        let found = sources.zip(theirs, |x, y| x & y)?;
        let words = sources.words_mut();
        for state in found.iter() {
            if self.admitted(state).any(|choice| !c.has(choice)) {
                clear(words, state);
            }
        }
        Ok(sources)
    }

    /// Computes μX. T ∪ { s : we can choose a pair of C that is in W, or has an edge into X that is not
    /// dropped }.
    pub(super) fn attract_in_game(
        &self,
        target: &BitSet,
        winning: Option<&BitSet>,
        within: &BitSet,
        rules: &impl Rules,
    ) -> Result<BitSet> {
        let graph = self.graph.predecessors()?;
        let mut attracted = Attracted {
            found: target.copy()?,
            good: BitSet::empty(&self.meter, self.graph.choices()),
            needed: self.needed()?,
            work: Frontier::new(&self.meter, self.graph.states())?,
        };
        target.iter().for_each(|state| attracted.work.add(state));
        if let Some(winning) = winning {
            for choice in winning.zip(within, |x, y| x & y)?.iter() {
                self.tick()?;
                attracted.add(graph.owner(choice as u32) as usize, choice);
            }
        }
        while let Some(state) = attracted.work.take() {
            self.tick()?;
            for &choice in graph.of(state) {
                let from = graph.owner(choice) as usize;
                if test(within.words(), choice as usize) && rules.keeps(from, state) {
                    attracted.add(from, choice as usize);
                }
            }
        }
        Ok(attracted.found)
    }

    /// Returns for each state the number of good choices that it needs: 1 if it is ours, all of them if
    /// it is the opponent's.
    fn needed(&self) -> Result<Array<u32>> {
        let mut needed = Array::filled(&self.meter, self.graph.states(), 1)?;
        for state in self.opponent().iter().flat_map(|theirs| theirs.iter()) {
            needed[state] = (self.admitted(state).count() as u32).max(1);
        }
        Ok(needed)
    }

    /// Returns for each state the number of choices in C that it can lose before it is lost: all of
    /// them if it is ours; if it is the opponent's, one, and none if some choice is not in C.
    pub(super) fn removable(&self, c: &BitSet) -> Result<Array<u32>> {
        let mut left = Array::filled(&self.meter, self.graph.states(), 0u32)?;
        for (state, left) in left.iter_mut().enumerate() {
            *left = self.graph.choices_of(state).filter(|&choice| c.has(choice)).count() as u32;
        }
        for state in self.opponent().iter().flat_map(|theirs| theirs.iter()) {
            left[state] = u32::from(left[state] > 0 && left[state] as usize == self.admitted(state).count());
        }
        Ok(left)
    }

    /// Computes [`ExplicitEngine::pursue`] in a game: losing states are removed with their attractor
    /// until the others can all win.
    pub(super) fn pursue_in_game<R: Rules>(
        &self,
        states: &BitSet,
        choices: BitSet,
        rules: &R,
        lost: &BitSet,
    ) -> Result<Region<BitSet, BitSet>> {
        let graph = self.graph.predecessors()?;
        let mut removal = Removal::new(self, graph, states.copy()?, choices)?;
        removal.lose(lost, rules)?;
        removal.remove_where(states, |left| left == 0, rules)?;
        let nothing = BitSet::empty(&self.meter, self.graph.states());
        loop {
            let winning = self.with_goal_edges(&removal.choices, rules)?;
            let reaching = self.attract_in_game(&nothing, Some(&winning), &removal.choices, rules)?;
            let lost = removal.states.zip(&reaching, |x, y| x & !y)?;
            if lost.is_empty() {
                let choices = self.choices_of_states(&removal.choices, &removal.states)?;
                return Ok(Region { states: removal.states, choices });
            }
            removal.remove_where(&lost, |_| true, rules)?;
        }
    }

    /// Returns the pairs of C with a goal edge.
    fn with_goal_edges(&self, c: &BitSet, rules: &impl Rules) -> Result<BitSet> {
        let graph = self.graph.predecessors()?;
        let mut found = BitSet::empty(&self.meter, self.graph.choices());
        let words = found.words_mut();
        for choice in c.iter() {
            self.tick()?;
            let from = graph.owner(choice as u32) as usize;
            if self.graph.successors_of(choice).iter().any(|&to| rules.wins(from, to as usize)) {
                set(words, choice);
            }
        }
        Ok(found)
    }
}

/// The states found by a search backwards, and the choices that lead to them.
struct Attracted {
    found: BitSet,
    /// The choices known to be good.
    good: BitSet,
    /// For each state the number of good choices that it still needs.
    needed: Array<u32>,
    /// The states found whose predecessors are not yet visited.
    work: Frontier,
}

impl Attracted {
    /// Adds a good choice of a state.
    fn add(&mut self, state: usize, choice: usize) {
        if test(self.found.words(), state) || test(self.good.words(), choice) {
            return;
        }
        set(self.good.words_mut(), choice);
        self.needed[state] -= 1;
        if self.needed[state] == 0 {
            set(self.found.words_mut(), state);
            self.work.add(state);
        }
    }
}
