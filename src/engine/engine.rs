//! The interface of an engine: two sorts of sets and the operators on them.

use super::edge_labels::{self, EdgeLabels};
use super::membership::{self, Membership};
use super::settings::{Count, Settings, Usage};
use meliora_base::error::{Error, Result};
use meliora_model::predicate::Predicate;
use meliora_model::step::Choice;
use meliora_model::{State, VarId};

/// A winning region together with the choices that stay winning.
#[derive(Debug, Clone)]
pub struct Region<S, C> {
    /// The winning states.
    pub states: S,
    /// The pairs of winning states that cannot leave the winning states.
    pub choices: C,
}

/// The result of [`Engine::almost_surely_win`].
#[derive(Debug, Clone)]
pub struct Won<S, C> {
    /// The region that wins almost surely.
    pub region: Region<S, C>,
    /// The states from which winning is possible, if the search has found them.
    pub possible: Option<S>,
}

/// The Boolean algebra of one sort of sets.
pub trait Algebra<X> {
    /// Returns X ∪ Y.
    fn union(&self, x: &X, y: &X) -> Result<X>;
    /// Returns X ∩ Y.
    fn intersection(&self, x: &X, y: &X) -> Result<X>;
    /// Returns X \ Y.
    fn difference(&self, x: &X, y: &X) -> Result<X>;
    /// Returns whether X = ∅.
    ///
    /// # Errors
    /// The set belongs to another engine.
    fn is_empty(&self, x: &X) -> Result<bool>;
    /// Returns whether X = Y.
    ///
    /// # Errors
    /// A set belongs to another engine.
    fn same(&self, x: &X, y: &X) -> Result<bool>;
    /// Returns |X|.
    fn count(&self, x: &X) -> Result<Count>;
}

/// Returns the position of the first item for which `holds` returns true.
///
/// # Errors
/// The first error of `holds`.
pub fn position<T>(items: &[T], mut holds: impl FnMut(&T) -> Result<bool>) -> Result<Option<usize>> {
    for (at, item) in items.iter().enumerate() {
        if holds(item)? {
            return Ok(Some(at));
        }
    }
    Ok(None)
}

/// The state sets and choice sets of one model, with the operators on them. The Boolean operations
/// on each sort are its [`Algebra`].
///
/// The operators of one step are one family. A set of choices C has the states
/// [`Engine::sources`], where it has a pair, and [`Engine::can_choose`], where the one who chooses can
/// take one; a set of states X has the choices [`Engine::choices_in`] that start in it. From targets
/// back to choices leads `pre`, and from choices on to targets leads `post`: [`Engine::pre`] may
/// enter a set, [`Engine::pre_within`] cannot leave it, [`Engine::post`] is what choices may enter.
/// Fixpoints are composed of these: `can_choose(pre(C, X))` are the states from which we may enter
/// X in one step.
///
/// An operation that returns a `Result` fails with [`meliora_base::error::Error::Limit`] if a limit of the
/// engine is reached: memory, time, a fixed size or a cancellation by [`Settings::sink`]. It fails
/// with [`meliora_base::error::Error::ForeignSet`] if a set belongs to another engine, even to one of the
/// same model. Engines and sets can be sent between threads.
pub trait Engine:
    Algebra<<Self as Engine>::States> + Algebra<<Self as Engine>::Choices> + Send + Sync
{
    /// A set of states of the scope.
    type States: Clone + Send + Sync;
    /// A set of pairs of a state of the scope and a choice enabled in it.
    type Choices: Clone + Send + Sync;

    /// Returns S, all states of the scope; after [`Engine::restricted_to`], those of the region.
    fn all_states(&self) -> Self::States;
    /// Returns the empty state set.
    fn no_states(&self) -> Self::States;
    /// Returns the initial states of the model.
    fn initial_states(&self) -> Self::States;
    /// Returns the states in which no command of the model is enabled; the only choice of each is a
    /// self-loop.
    fn deadlock_states(&self) -> Self::States;
    /// Returns true if each state has exactly one choice, as in a dtmc: then all strategies coincide.
    fn is_markov_chain(&self) -> bool {
        false
    }
    /// Returns the number of states of a `dtmc` in which several choices are enabled, one of which is
    /// drawn; `None` if the engine has not counted them.
    fn drawing_states(&self) -> Option<Count> {
        None
    }
    /// Returns a state of the scope in which the probabilities of an enabled command sum to 1 only
    /// after rounding, or `None` if all sums are exact. [`meliora_model::Program::rounded_in`] finds
    /// the command.
    fn rounded_state(&self) -> Option<&State> {
        None
    }
    /// Returns the states of the scope in which a condition is true.
    ///
    /// # Errors
    /// The condition was made for another program; a limit of the engine is reached; the expression
    /// has no value in some state of the scope.
    fn states_where(&self, predicate: &Predicate) -> Result<Self::States>;
    /// Returns all enabled choices, including the self-loops of deadlock states; after
    /// [`Engine::restricted_to`], those of the region.
    fn all_choices(&self) -> Self::Choices;
    /// Returns the empty choice set.
    fn no_choices(&self) -> Self::Choices;
    /// Returns an engine for the model that has only the states and choices of a region, such as a
    /// result of [`Engine::stay_within`]. It shares the sets of this engine. Its initial states and
    /// deadlock states remain those of the whole model.
    ///
    /// Every state of the region must have a choice of the region, and these choices must not leave
    /// the region.
    ///
    /// # Errors
    /// A set belongs to another engine.
    fn restricted_to(&self, region: &Region<Self::States, Self::Choices>) -> Result<Self>
    where
        Self: Sized;

    /// Returns { (s,a) ∈ C : s ∈ X }.
    fn choices_in(&self, c: &Self::Choices, x: &Self::States) -> Result<Self::Choices>;
    /// Returns { s : (s,a) ∈ C for some a }, whoever chooses in s.
    fn sources(&self, c: &Self::Choices) -> Result<Self::States>;
    /// Returns the states in which the play surely takes a pair of C if we want it to: { our s : (s,a) ∈
    /// C for some a } ∪ { their s : (s,a) ∈ C for every enabled a }. The only operator of one step whose
    /// result depends on who chooses in s; here, every state is ours.
    fn can_choose(&self, c: &Self::Choices) -> Result<Self::States> {
        self.sources(c)
    }

    /// Returns the states of X outside [`Engine::can_choose`] of C. Cost: no image.
    fn cannot_choose(&self, x: &Self::States, c: &Self::Choices) -> Result<Self::States> {
        self.difference(x, &self.can_choose(&self.choices_in(c, x)?)?)
    }

    /// Returns the states of a game in which the opponent chooses; `None` if every state is ours, as
    /// in an `mdp`.
    fn theirs(&self) -> Option<Self::States> {
        None
    }
    /// Returns for each player of a game the states in which it chooses; empty for other models.
    /// Deadlocks belong to nobody.
    fn player_states(&self) -> Vec<Self::States> {
        Vec::new()
    }
    /// Returns for each player of a game whether it is one of us; empty for other models.
    fn coalition(&self) -> Vec<bool> {
        Vec::new()
    }
    /// Returns whether the model is a game, even one in which every state is ours.
    fn is_game(&self) -> bool {
        !self.coalition().is_empty()
    }
    /// Returns an engine for the same game in which we are the players of another coalition. It shares
    /// the sets of this engine.
    ///
    /// # Errors
    /// [`Error::Usage`] if the coalition does not have one entry per player.
    fn with_coalition(&self, _coalition: &[bool]) -> Result<Self>
    where
        Self: Sized,
    {
        Err(Error::Usage("a model with one player has no coalitions".to_owned()))
    }
    /// Returns an engine for the same game seen by the opponent: their states are ours, and ours are
    /// theirs. `None` if every state is ours.
    fn exchanged(&self) -> Result<Option<Self>>
    where
        Self: Sized,
    {
        let others: Vec<bool> = self.coalition().into_iter().map(|ours| !ours).collect();
        self.theirs().map(|_| self.with_coalition(&others)).transpose()
    }

    /// Returns { (s,a) ∈ C : succ(s,a) ∩ X ≠ ∅ }.
    fn pre(&self, c: &Self::Choices, x: &Self::States) -> Result<Self::Choices>;
    /// Computes [`Engine::can_choose`] of [`Engine::pre`] of C and X.
    fn can_enter(&self, c: &Self::Choices, x: &Self::States) -> Result<Self::States> {
        self.can_choose(&self.pre(c, x)?)
    }
    /// Returns { (s,a) ∈ C : succ(s,a) ⊆ Y }.
    fn pre_within(&self, c: &Self::Choices, y: &Self::States) -> Result<Self::Choices> {
        let outside = self.difference(&self.all_states(), y)?;
        self.difference(c, &self.pre(c, &outside)?)
    }
    /// Returns { s' : s' ∈ succ(s,a) for some (s,a) ∈ C }.
    fn post(&self, c: &Self::Choices) -> Result<Self::States>;

    /// Computes μX. T ∪ { s : we can choose a pair of C with an edge into X that is not dropped }; see
    /// [`Engine::can_choose`].
    fn can_reach(
        &self,
        target: &Self::States,
        within: &Self::Choices,
        edge_labels: &[EdgeLabels<Self::States>],
    ) -> Result<Self::States>;

    /// Computes μX. T ∪ { s ∈ B : we can choose a pair with an edge into X }, among all pairs of the engine.
    ///
    /// Cost: that of [`Engine::can_reach`].
    ///
    /// # Errors
    /// A limit of the engine is reached.
    fn can_reach_through(&self, target: &Self::States, bound: &Self::States) -> Result<Self::States> {
        self.can_reach(target, &self.choices_in(&self.all_choices(), bound)?, &[])
    }

    /// Computes μX. { s : we can choose a pair of C that is in W, or has an edge into X that is not
    /// dropped }. W are the pairs with a goal edge; see [`edge_labels::winning`].
    ///
    /// Cost: that of [`Engine::can_reach`].
    fn can_win(
        &self,
        winning: &Self::Choices,
        within: &Self::Choices,
        edge_labels: &[EdgeLabels<Self::States>],
    ) -> Result<Self::States>
    where
        Self: Sized,
    {
        edge_labels::reach_winning(self, winning, within, edge_labels)
    }

    /// Removes the attractor of `lost` from the game `left` and returns the rest. Removes every
    /// pair that may step into a lost state by an edge that is not safe. States that have no pair
    /// left and are not in `won` are lost too, and so on until nothing changes. A state of the opponent
    /// is lost with its first pair; more of its pairs may be removed then.
    ///
    /// The caller has already removed `lost` from `left.states`. The pairs of `left` are those of
    /// `within` that were not removed before; no pair of a state lost before leads to a state that
    /// can still win. Goal edges and dropped edges are safe: either every state of a pair is in one
    /// of `edge_labels`, or `edge_labels` is empty and no edge is safe.
    ///
    /// Cost: one pre-image per part and layer of lost states.
    fn remove_attractor(
        &self,
        left: Region<Self::States, Self::Choices>,
        within: &Self::Choices,
        won: &Self::States,
        edge_labels: &[EdgeLabels<Self::States>],
        lost: Self::States,
    ) -> Result<Region<Self::States, Self::Choices>>
    where
        Self: Sized,
    {
        edge_labels::remove_attractor(self, left, within, won, edge_labels, lost)
    }

    /// Computes the greatest Z ⊆ X in which every state of ours has a pair of C with all successors in
    /// Z, and every pair of the opponent's states is such a pair, together with these pairs.
    ///
    /// Cost: one pre-image of the removed states per round.
    fn stay_within(
        &self,
        x: &Self::States,
        within: &Self::Choices,
    ) -> Result<Region<Self::States, Self::Choices>>
    where
        Self: Sized,
    {
        let (left, lost) = edge_labels::confined_to(self, x, within)?;
        let Region { states, choices } = self.remove_attractor(left, within, &self.no_states(), &[], lost)?;
        Ok(Region { choices: self.choices_in(&choices, &states)?, states })
    }

    /// Computes the states of [`Engine::stay_within`].
    fn surely_staying(&self, x: &Self::States, within: &Self::Choices) -> Result<Self::States>
    where
        Self: Sized,
    {
        Ok(self.stay_within(x, within)?.states)
    }

    /// Computes νY. μX. T ∪ { s : we can choose a pair of C with all successors in Y and one in X },
    /// together with the pairs of C outside T that stay inside the result.
    ///
    /// Removes losing states first (Baier and Katoen, Principles of Model Checking, Algorithm 45,
    /// on sets). A state is lost if it has no pair, or if it cannot reach T with the pairs still
    /// allowed. Pairs that may step into a lost state are removed; states without a pair are lost
    /// immediately; repeat. Only pairs that may step into a lost state are removed: the pairs of a
    /// lost state lead to no state that can still win, and cached results for unchanged sets remain
    /// valid.
    ///
    /// Cost: per round one `can_reach`, and before it one pre-image per layer of lost states.
    fn almost_surely_reach(
        &self,
        target: &Self::States,
        within: &Self::Choices,
    ) -> Result<Region<Self::States, Self::Choices>>
    where
        Self: Sized,
    {
        let mut left =
            Region { states: self.union(&self.can_choose(within)?, target)?, choices: within.clone() };
        let mut lost = self.difference(&self.all_states(), &left.states)?;
        loop {
            if !self.is_empty(&lost)? {
                left = self.remove_attractor(left, within, target, &[], lost)?;
            }
            let reaching = self.can_reach(target, &left.choices, &[])?;
            lost = self.difference(&left.states, &reaching)?;
            left.states = self.intersection(&left.states, &reaching)?;
            if self.is_empty(&lost)? {
                left.choices = self.choices_in(&left.choices, &self.difference(&left.states, target)?)?;
                return Ok(left);
            }
        }
    }

    /// Computes νY. μX. { s ∈ S : we can choose a pair of C that has only goal edges and edges into Y,
    /// and one goal edge or edge into X }, ignoring dropped edges, together with the pairs of C that
    /// stay. `start` contains S and C.
    ///
    /// Every pair of C must have its state in S, and each of its edges must be a goal edge or lead
    /// into S. Then the first search finds μX. { s : we can choose a pair of C with a goal edge, or with an edge into X that
    /// is not dropped }, the states from which winning is possible.
    ///
    /// Cost: per round one `can_reach`, and one pre-image per part and layer of losing states.
    fn almost_surely_win(
        &self,
        start: Region<Self::States, Self::Choices>,
        edge_labels: &[EdgeLabels<Self::States>],
    ) -> Result<Won<Self::States, Self::Choices>>
    where
        Self: Sized,
    {
        edge_labels::almost_surely_win(self, start, edge_labels)
    }

    /// Returns the number of model states in X, ignoring the states of monitors; `None` without
    /// monitors.
    fn count_model_states(&self, x: &Self::States) -> Result<Option<Count>>;
    /// Returns the number of triples (s, a, s') with (s,a) ∈ C and s' ∈ succ(s,a) ∩ X.
    fn count_transitions(&self, c: &Self::Choices, x: &Self::States) -> Result<Count>;

    /// Returns the first `limit` states of X (all if X has fewer), ordered by their values, first
    /// variable first.
    fn list_states(&self, x: &Self::States, limit: usize) -> Result<Vec<State>>;
    /// Returns the set that contains only `state`, or the empty set if `state` is not in the scope.
    fn singleton(&self, state: &[i64]) -> Result<Self::States>;
    /// Returns the given states that are in the scope. Cost: no image.
    fn set_of(&self, states: &mut dyn Iterator<Item = State>) -> Result<Self::States> {
        // As in a binary counter, sets of 2^n states are united with each other.
        let mut parts: Vec<(u32, Self::States)> = Vec::new();
        for state in states {
            let mut part = (0, self.singleton(&state)?);
            while let Some((level, other)) = parts.pop_if(|(level, _)| *level == part.0) {
                part = (level + 1, self.union(&other, &part.1)?);
            }
            parts.push(part);
        }
        parts.into_iter().rev().try_fold(self.no_states(), |all, (_, part)| self.union(&all, &part))
    }
    /// Returns the states of the scope in which some variables have the given values. Cost: no image.
    fn slice(&self, fixed: &[(VarId, i64)]) -> Result<Self::States>;
    /// Returns whether s ∈ X.
    ///
    /// # Errors
    /// The set belongs to another engine.
    fn contains(&self, x: &Self::States, state: &[i64]) -> Result<bool>;
    /// Creates a test of states for membership in some sets, at most [`membership::MOST`]. Pays off for
    /// many states.
    ///
    /// # Errors
    /// A limit is reached.
    fn membership<'e>(&'e self, sets: &[&Self::States]) -> Result<Box<dyn Membership + 'e>>
    where
        Self: Sized,
    {
        Ok(Box::new(membership::Each::new(self, sets)))
    }
    /// Returns whether (s,a) ∈ C, for a choice that the program lists for the state.
    ///
    /// # Errors
    /// The set belongs to another engine.
    fn contains_choice(&self, c: &Self::Choices, state: &[i64], choice: &Choice) -> Result<bool>;

    /// Returns the resources used so far.
    fn usage(&self) -> Usage;
    /// Returns the settings that the engine was created with.
    fn settings(&self) -> &Settings;
}
