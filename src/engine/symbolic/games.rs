//! Games against an opponent: who chooses in a state, and the fixpoints for both sides.
//!
//! Both are one recursion ([`Store::lose`](super::store::Store)): it finds the states of which every
//! list has a step into the result. All choices of one side in one list ask for some choice, each
//! group of choices in a list of its own asks for every choice. So the search for the states that can
//! win has one list for us and many for the opponent, and the removal of losing states the reverse.

use std::sync::atomic::Ordering::Relaxed;
use std::sync::{Arc, OnceLock};

use super::encoding::Encoding;
use super::encoding::transitions::Transitions;
use super::fixpoints::parts::Part;
use super::relations::lists::RelationList;
use super::relations::partial_relation::PartialRelation;
use super::relations::tuples::{ListTuple, ListTuples};
use super::store::Store;
use super::store::diagram::Bdd;
use super::{ChoiceSet, StateSet, SymbolicEngine, pick};
use crate::edge_labels::{self, EdgeLabels};
use crate::engine::{Algebra, Engine};
use meliora_base::error::{Error, Result};
use meliora_model::{Program, fault};

/// The players of a game, and the coalition that we are.
#[derive(Clone)]
pub(super) struct Game {
    /// The states of each player; no two have a state in common.
    pub(super) players: Vec<Bdd>,
    /// The player of each group of choices.
    groups: Arc<Vec<Option<usize>>>,
    /// For each player, whether it is one of us.
    pub(super) coalition: Vec<bool>,
    /// The opponent; `None` if it has no states.
    opponent: Option<Arc<Opponent>>,
}

/// The opponent of a coalition.
pub(super) struct Opponent {
    states: Bdd,
    /// For each group of choices, whether the opponent chooses it.
    groups: Vec<bool>,
    /// The table of the tuples below.
    tuples: Arc<ListTuples>,
    /// All choices of the opponent as one list, once it is needed.
    list: OnceLock<Arc<RelationList>>,
    /// All enabled choices of ours as one list, once it is needed.
    ours: OnceLock<Arc<RelationList>>,
    /// The lists for the removal of losing states, once they are needed.
    removal: OnceLock<Arc<ListTuple>>,
}

impl Game {
    /// Finds the players of a game; `None` if the model is not a game. `enabled` has the states of each
    /// group.
    ///
    /// # Errors
    /// A limit; a state in which two players have a choice, or several choices have no player.
    pub(super) fn find(
        program: &Program,
        encoding: &Encoding,
        store: &Store,
        transitions: &Transitions,
        enabled: &[Bdd],
    ) -> Result<Option<Self>> {
        let Some(players) = &program.players else { return Ok(None) };
        let groups = transitions.players(program);
        let mut states = vec![store.zero(); players.list.len()];
        let mut taken = store.zero();
        for ((group, own), alone) in groups.iter().zip(enabled).zip(transitions.alone(program)) {
            let Some(player) = *group else { continue };
            let others = if alone { taken.clone() } else { store.minus(&taken, &states[player])? };
            let shared = store.and(own, &others)?;
            if !store.is_zero(&shared) {
                let state = pick::first(store, encoding, &shared)?;
                return Err(fault::of_two_players(program, &state)?);
            }
            states[player] = store.or(&states[player], own)?;
            taken = store.or(&taken, own)?;
        }
        Game::new(store, states, Arc::new(groups), players.coalition()).map(Some)
    }

    fn new(
        store: &Store,
        players: Vec<Bdd>,
        groups: Arc<Vec<Option<usize>>>,
        coalition: Vec<bool>,
    ) -> Result<Self> {
        let is_theirs = |player: usize| coalition.get(player).is_some_and(|ours| !ours);
        let theirs = players.iter().enumerate().filter(|(player, _)| is_theirs(*player));
        let states = store.any(theirs.map(|(_, states)| states.clone()))?;
        let opponent = (!store.is_zero(&states)).then(|| {
            let groups = groups.iter().map(|group| group.is_some_and(is_theirs)).collect();
            Arc::new(Opponent::new(store, states, groups))
        });
        Ok(Game { players, groups, coalition, opponent })
    }

    /// Returns the same game for another store, with the players' states of that store.
    pub(super) fn moved(&self, store: &Store, players: Vec<Bdd>) -> Result<Self> {
        Game::new(store, players, Arc::clone(&self.groups), self.coalition.clone())
    }
}

impl Opponent {
    fn new(store: &Store, states: Bdd, groups: Vec<bool>) -> Self {
        let tuples = ListTuples::new(store);
        let (list, ours, removal) = (OnceLock::new(), OnceLock::new(), OnceLock::new());
        Opponent { states, groups, tuples, list, ours, removal }
    }

    /// Returns whether the opponent chooses in a group; the last one has the self-loops of deadlocks.
    pub(super) fn has(&self, group: usize) -> bool {
        self.groups.get(group).is_some_and(|&theirs| theirs)
    }
}

impl SymbolicEngine {
    /// Returns the opponent, if it has states.
    pub(super) fn opponent(&self) -> Option<&Arc<Opponent>> {
        self.game.as_ref()?.opponent.as_ref()
    }

    /// Returns the states of the opponent, if there are some.
    pub(super) fn opponent_states(&self) -> Option<StateSet> {
        self.opponent().map(|opponent| StateSet(opponent.states.clone()))
    }

    /// See [`Engine::with_coalition`].
    pub(super) fn played_by(&self, coalition: &[bool]) -> Result<Self> {
        let Some(game) = self.game.as_ref().filter(|game| game.coalition.len() == coalition.len()) else {
            return Err(Error::Usage("a coalition has one entry per player of a game".to_owned()));
        };
        let (players, groups) = (game.players.clone(), Arc::clone(&game.groups));
        let game = Some(Game::new(&self.store, players, groups, coalition.to_vec())?);
        Ok(SymbolicEngine { game, ..self.clone() })
    }

    /// Removes from the sources of C the states of the opponent with an enabled choice that is not in
    /// C.
    pub(super) fn without_escapes(&self, sources: StateSet, c: &ChoiceSet) -> Result<StateSet> {
        let Some(opponent) = self.opponent() else { return Ok(sources) };
        let mut left = self.store.and(&sources.0, &opponent.states)?;
        for (group, (own, all)) in c.0.iter().zip(&*self.choices.0).enumerate() {
            if opponent.has(group) && own != all {
                let missing = self.store.minus(&self.store.and(&left, all)?, own)?;
                left = self.store.minus(&left, &missing)?;
            }
        }
        let ours = self.store.minus(&sources.0, &opponent.states)?;
        Ok(StateSet(self.store.or(&ours, &left)?))
    }

    /// Returns the choices of some groups as one list, in each group those of a set of states; `None` has
    /// all of its choices.
    fn merged(&self, states: impl Fn(usize) -> Option<Option<Bdd>>) -> Result<Arc<RelationList>> {
        let mut entries = Vec::new();
        for piece in &self.transitions.pieces {
            let PartialRelation { support, relation } = piece.steps.clone();
            match states(piece.group) {
                None => {}
                Some(None) => entries.push(PartialRelation { support, relation }),
                Some(Some(states)) => {
                    let relation = self.store.and(&relation, &states)?;
                    entries.push(PartialRelation { support, relation });
                }
            }
        }
        self.lists.of(&self.store, entries)
    }

    /// Returns for each group `None` if the opponent may take all its choices, else the states in which it may.
    /// Requirements of the other side rule some of them out.
    fn their_bounds(&self) -> Result<Vec<Option<Bdd>>> {
        let bound = |(choices, enabled): (&Bdd, &Bdd)| {
            let all = self.store.and(enabled, &self.states.0)?;
            Ok((*choices != all).then(|| choices.clone()))
        };
        self.choices.0.iter().zip(&*self.enabled).map(bound).collect()
    }

    /// Returns all choices of the opponent as one list.
    pub(super) fn their_list(&self, opponent: &Opponent) -> Result<Arc<RelationList>> {
        if let Some(found) = opponent.list.get() {
            return Ok(Arc::clone(found));
        }
        let bounds = self.their_bounds()?;
        let made = self.merged(|group| opponent.has(group).then(|| bounds[group].clone()))?;
        Ok(Arc::clone(opponent.list.get_or_init(|| made)))
    }

    /// Returns all enabled choices of ours as one list.
    fn our_list(&self, opponent: &Opponent) -> Result<Arc<RelationList>> {
        if let Some(found) = opponent.ours.get() {
            return Ok(Arc::clone(found));
        }
        let made = self.merged(|group| (!opponent.has(group)).then_some(None))?;
        Ok(Arc::clone(opponent.ours.get_or_init(|| made)))
    }

    /// Returns the lists for the removal of losing states: each group of ours is one, and all choices of
    /// the opponent are one.
    pub(super) fn removal_lists<'o>(&self, opponent: &'o Opponent) -> Result<&'o ListTuple> {
        if let Some(found) = opponent.removal.get() {
            return Ok(found);
        }
        let ours = self.groups.iter().enumerate().filter(|(group, _)| !opponent.has(*group));
        let mut lists: Vec<_> = ours.map(|(_, list)| Arc::clone(list)).collect();
        lists.push(self.their_list(opponent)?);
        let made = opponent.tuples.of_lists(&self.store, &lists)?;
        Ok(opponent.removal.get_or_init(|| made))
    }

    /// Computes μX. T ∪ { s : we can choose a pair of C that is in W, or has an edge into X that is not
    /// dropped }.
    pub(super) fn attract_in_game(
        &self,
        opponent: &Opponent,
        target: &StateSet,
        winning: &ChoiceSet,
        within: &ChoiceSet,
        edge_labels: &[EdgeLabels<StateSet>],
    ) -> Result<StateSet> {
        let winning = self.intersection(winning, within)?;
        let dropped = edge_labels::dropped(self, edge_labels)?;
        self.search_attractor(opponent, target, &winning, within, &dropped)
    }

    /// Computes [`SymbolicEngine::attract_in_game`] for W ⊆ C.
    ///
    /// The recursion over parts, where it is likely to pay off, and the recursion over lists take turns; the latter
    /// continues from the states that are found. Dropped edges depend on the state that they leave, so neither can
    /// have them: then the search goes layer by layer.
    fn search_attractor(
        &self,
        opponent: &Opponent,
        target: &StateSet,
        winning: &ChoiceSet,
        within: &ChoiceSet,
        dropped: &[(StateSet, StateSet)],
    ) -> Result<StateSet> {
        let mut found = self.union(target, &self.can_choose(winning)?)?;
        let loops = StateSet(within.0[self.groups.len()].clone());
        // A choice without edges is in no list, so the lists cannot tell that it enters nothing.
        let entering = self.union(winning, &self.with_edges(within)?)?;
        let candidates = self.difference(&self.can_choose(&entering)?, &loops)?;
        let has_parts = dropped.is_empty() && self.has_few_parts()?;
        let mut lists = None;
        self.store.in_turns(&self.store.leaders.attracted, usize::from(!has_parts)..2, |turn| {
            if turn.way == 0 {
                return self.search_parts(opponent, &found, &candidates, winning, within, turn.steps);
            }
            if !dropped.is_empty() {
                return self.search_layers(&mut found, winning, within, dropped, turn.steps);
            }
            let lists = match &lists {
                Some(lists) => lists,
                None => lists.insert(self.search_lists(opponent, winning, within)?),
            };
            let open = self.difference(&candidates, &found)?;
            let (all, done) = self.store.lose(&found.0, &open.0, lists, turn.steps)?;
            found = StateSet(all);
            Ok(done.then(|| found.clone()))
        })
    }

    /// Computes [`SymbolicEngine::attract_in_game`] layer by layer from the states found; `None` if it takes more than
    /// `steps` steps.
    fn search_layers(
        &self,
        found: &mut StateSet,
        winning: &ChoiceSet,
        within: &ChoiceSet,
        dropped: &[(StateSet, StateSet)],
        steps: u64,
    ) -> Result<Option<StateSet>> {
        let work = &self.store.work.steps;
        let until = work.load(Relaxed).saturating_add(steps);
        while work.load(Relaxed) < until {
            let entering = edge_labels::kept_into(self, within, dropped, found)?;
            let next = self.can_choose(&self.union(winning, &entering)?)?;
            let all = self.union(found, &next)?;
            if self.same(&all, found)? {
                return Ok(Some(all));
            }
            *found = all;
        }
        Ok(None)
    }

    /// Computes [`SymbolicEngine::attract_in_game`] by a recursion over parts: each has the candidates in
    /// which a step of its list is needed. Returns `None` if it takes more than `steps` steps.
    ///
    /// Bounds take the place of other relations where they can, so that searches share their results. Only the
    /// states of ours of which C has some choices, but not all, need a list of their own.
    fn search_parts(
        &self,
        opponent: &Opponent,
        found: &StateSet,
        candidates: &StateSet,
        winning: &ChoiceSet,
        within: &ChoiceSet,
        steps: u64,
    ) -> Result<Option<StateSet>> {
        let store = &self.store;
        let open = store.minus(&candidates.0, &found.0)?;
        let ours = store.minus(&open, &opponent.states)?;
        let missing = |group: usize| store.minus(&self.enabled[group], &within.0[group]);
        let our_groups = (0..self.groups.len()).filter(|&group| !opponent.has(group));
        let incomplete = store.any(our_groups.map(missing).collect::<Result<Vec<_>>>()?)?;
        let (some, all) = (store.and(&ours, &incomplete)?, store.minus(&ours, &incomplete)?);
        let mut parts = vec![(all, self.our_list(opponent)?)];
        if !store.is_zero(&some) {
            let few = within.0.iter().map(|own| store.and(own, &some)).collect::<Result<Vec<_>>>()?;
            let list = self.merged(|group| (!opponent.has(group)).then(|| Some(few[group].clone())))?;
            parts.push((some, list));
        }
        for (group, list) in self.groups.iter().enumerate().filter(|(group, _)| opponent.has(*group)) {
            let needed = store.minus(&self.choices.0[group], &winning.0[group])?;
            parts.push((store.and(&open, &needed)?, Arc::clone(list)));
        }
        let part = |(allowed, list)| Part { allowed, except: store.zero(), list };
        let parts: Vec<Part> = parts.into_iter().map(part).collect();
        let all = store.remove_attractor(&found.0, &parts, steps)?;
        Ok(all.map(|all| StateSet(all.lost)))
    }

    /// Returns the lists for the search of [`SymbolicEngine::attract_in_game`]: first all choices of ours
    /// that are in C as one, then each group of the opponent, without the pairs of W.
    fn search_lists(
        &self,
        opponent: &Opponent,
        winning: &ChoiceSet,
        within: &ChoiceSet,
    ) -> Result<Arc<ListTuple>> {
        let confined = |group: usize| Some(within.0[group].clone()).filter(|own| *own != self.enabled[group]);
        let mut lists = vec![self.merged(|group| (!opponent.has(group)).then(|| confined(group)))?];
        let bounds = self.their_bounds()?;
        for (group, list) in self.groups.iter().enumerate().filter(|(group, _)| opponent.has(*group)) {
            let (won, bound) = (&winning.0[group], &bounds[group]);
            lists.push(if self.store.is_zero(won) && bound.is_none() {
                Arc::clone(list)
            } else {
                let all = bound.as_ref().unwrap_or(&self.enabled[group]);
                let open = self.store.minus(all, won)?;
                self.merged(|other| (other == group).then(|| Some(open.clone())))?
            });
        }
        opponent.tuples.of_lists(&self.store, &lists)
    }
}
