//! The symbolic engine: sets of states and partial relations as binary decision diagrams (OxiDD).
//!
//! Its parts build on each other in this order; each folder imports only those before it:
//!
//! - `store`: OxiDD's manager with limits and garbage collection, and the Boolean operations. They
//!   are written anew instead of calling those of OxiDD, so that every recursion counts its steps,
//!   can be cancelled, and ends before the node table is full.
//! - `relations`: partial relations, lists of them, and one step of a list.
//! - `order`: the order of the bits, from the program alone.
//! - `encoding`: states as bits ([`Encoding`]), expressions and commands as diagrams. Choices are
//!   grouped, so that in each state at most one choice of a group is enabled.
//! - `fixpoints`: reachability and the removal of losing states, as recursions over sets and lists of
//!   relations at once.
//!
//! The other files are the engine itself: how it is built and copied, with all edges or only some
//! (`trends`), which of the methods for a fixpoint it tries (`attempts`), the search for lost states by
//! states alone (`losing`), where monitors wait (`quiet`), and how its sets are listed and written.

mod algebra;
mod attempts;
mod build;
mod draft;
mod dump;
mod encoding;
mod falling_choices;
mod fixpoints;
mod games;
mod losing;
mod membership;
pub mod order;
mod pick;
mod quiet;
mod relations;
mod sizes;
pub(crate) mod store;
#[cfg(test)]
mod tests;
mod trends;

use std::sync::{Arc, OnceLock};

use build::Explored;
pub use dump::Set;
pub use encoding::Encoding;
pub use encoding::transitions::Numbered;
pub use order::{Bit, Order};
pub(crate) use order::{Ordered, candidates, large_first};
pub use pick::Listing;
pub use sizes::DiagramSizes;
pub use store::thresholds::{Thresholds, Ways};
pub use trends::Side;

use super::edge_labels::{self, EdgeLabels, plain_edges_into};
use super::engine::{Algebra, Engine, Region};
use super::membership::{Each, Membership};
use super::settings::{Count, Settings, Usage};
use encoding::transitions::Transitions;
use encoding::translate::Translator;
use games::Game;
use meliora_base::error::Result;
use meliora_model::predicate::Predicate;
use meliora_model::step::Choice;
use meliora_model::{ModelKind, Program, State, VarId, fault};
use membership::Marks;
use quiet::Quiet;
use relations::lists::{Lists, RelationList};
use relations::tuples::ListTuple;
use store::Store;
use store::diagram::Bdd;
use store::walk::{Direction, Pass};

/// A set of states: a diagram over the present bits.
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct StateSet(Bdd);

/// A set of (state, choice) pairs: one set of states per group of choices.
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct ChoiceSet(Arc<Vec<Bdd>>);

/// The symbolic engine. Clones share the diagrams.
#[derive(Clone)]
pub struct SymbolicEngine {
    program: Arc<Program>,
    settings: Settings,
    encoding: Arc<Encoding>,
    transitions: Arc<Transitions>,
    /// All lists of relations.
    lists: Arc<Lists>,
    /// The relations of each group.
    groups: Vec<Arc<RelationList>>,
    /// The relations of all groups as one operand, once [`SymbolicEngine::tuple`] made it.
    tuple: OnceLock<Arc<ListTuple>>,
    /// The result of [`SymbolicEngine::quiet`] once it has been computed.
    quiet: OnceLock<Arc<Quiet>>,
    /// The result of [`SymbolicEngine::has_few_parts`] once it has been computed.
    few_parts: OnceLock<bool>,
    /// The relations of all groups as one list, for reachability.
    list: Arc<RelationList>,
    domain: Bdd,
    states: StateSet,
    initial: StateSet,
    deadlocks: StateSet,
    rounded: Option<State>,
    /// The states in which each group is enabled; the last entry is for the self-loops of
    /// deadlocks.
    enabled: Arc<Vec<Bdd>>,
    /// The enabled choices that the engine admits; fewer than `enabled` after
    /// [`Engine::restricted_to`].
    choices: ChoiceSet,
    /// False if the self-loops of deadlocks are no edges; see [`SymbolicEngine::with_trend`].
    has_loops: bool,
    /// The players of a game; `None` for other models.
    game: Option<Game>,
    store: Arc<Store>,
}

impl SymbolicEngine {
    /// Encodes the program with the bits in the order of the settings and explores the scope.
    /// Checks that every command has a meaning in every state of the scope.
    ///
    /// Cost: one image fixpoint for the scope `reachable`.
    ///
    /// # Errors
    /// A limit. Input errors with an example state of the scope: an update that leaves its range,
    /// probabilities that are not a distribution, an expression without a value.
    pub fn new(program: Arc<Program>, settings: Settings) -> Result<Self> {
        Explored::new(program, settings)?.engine()
    }

    /// Creates the engine with the bits in this order, whatever the settings say.
    ///
    /// # Errors
    /// The errors of [`SymbolicEngine::new`].
    pub(crate) fn in_order(program: Arc<Program>, order: &Ordered, settings: Settings) -> Result<Self> {
        Explored::in_order(program, order, settings)?.engine()
    }

    /// Returns the encoding of states as bits.
    pub fn encoding(&self) -> &Encoding {
        &self.encoding
    }

    /// Returns the program.
    pub fn program(&self) -> &Arc<Program> {
        &self.program
    }

    /// Returns whether both engines share their diagrams, so that each accepts the sets of the other.
    pub fn shares(&self, other: &SymbolicEngine) -> bool {
        Arc::ptr_eq(&self.store, &other.store)
    }

    /// Returns the number of times that each method was used.
    pub fn ways(&self) -> Ways {
        self.store.work.ways()
    }

    /// Returns the states of X with a self-loop of deadlocks among the choices.
    fn loops_in(&self, choices: &[Bdd], x: &Bdd) -> Result<Bdd> {
        if self.has_loops { self.store.and(x, &choices[self.groups.len()]) } else { Ok(self.store.zero()) }
    }

    /// Returns for each group `None` if `within` contains all its enabled choices, else the states
    /// in which `within` allows it.
    fn confinement(&self, within: &[Bdd]) -> Vec<Option<Bdd>> {
        let differs = |(own, all): (&Bdd, &Bdd)| (own != all).then(|| own.clone());
        within.iter().zip(self.enabled.iter()).map(differs).collect()
    }

    /// Returns whether a state satisfies a function of the present bits.
    fn satisfies(&self, f: &Bdd, state: &[i64]) -> bool {
        self.encoding.is_valid(state)
            && self.store.holds(f, |level| self.encoding.bit_of(state, level as usize / 2))
    }
}

impl Engine for SymbolicEngine {
    type States = StateSet;
    type Choices = ChoiceSet;

    fn all_states(&self) -> StateSet {
        self.states.clone()
    }

    fn no_states(&self) -> StateSet {
        StateSet(self.store.zero())
    }

    fn initial_states(&self) -> StateSet {
        self.initial.clone()
    }

    fn deadlock_states(&self) -> StateSet {
        self.deadlocks.clone()
    }

    fn is_markov_chain(&self) -> bool {
        self.program.kind == ModelKind::Dtmc
    }

    fn rounded_state(&self) -> Option<&State> {
        self.rounded.as_ref()
    }

    fn states_where(&self, predicate: &Predicate) -> Result<StateSet> {
        predicate.check(&self.program)?;
        let translator = Translator::of(&self.program, predicate.pool(), &self.encoding, &self.store);
        let (holds, fails) = translator.condition(predicate.id())?;
        let bad = self.store.and(&fails, &self.states.0)?;
        if !self.store.is_zero(&bad) {
            let state = pick::first(&self.store, &self.encoding, &bad)?;
            return Err(fault::in_predicate(&self.program, predicate, &state));
        }
        Ok(StateSet(self.store.and(&holds, &self.states.0)?))
    }

    fn all_choices(&self) -> ChoiceSet {
        self.choices.clone()
    }

    fn no_choices(&self) -> ChoiceSet {
        ChoiceSet(Arc::new(vec![self.store.zero(); self.enabled.len()]))
    }

    fn restricted_to(&self, region: &Region<StateSet, ChoiceSet>) -> Result<Self> {
        self.diagram_of(&region.states)?;
        self.groups_of(&region.choices)?;
        let Region { states, choices } = region.clone();
        // The lists of the opponent's choices, too.
        let same = |game: &games::Game| game.moved(&self.store, game.players.clone());
        let game = self.game.as_ref().map(same).transpose()?;
        Ok(SymbolicEngine { states, choices, game, ..self.clone() })
    }

    fn choices_in(&self, c: &ChoiceSet, x: &StateSet) -> Result<ChoiceSet> {
        let (c, x) = (self.diagrams_of(c)?, self.diagram_of(x)?);
        let within = c.iter().map(|f| self.store.and(f, x));
        Ok(ChoiceSet(Arc::new(within.collect::<Result<_>>()?)))
    }

    fn sources(&self, c: &ChoiceSet) -> Result<StateSet> {
        Ok(StateSet(self.store.any(self.diagrams_of(c)?.iter().cloned())?))
    }

    fn can_choose(&self, c: &ChoiceSet) -> Result<StateSet> {
        self.without_escapes(self.sources(c)?, c)
    }

    /// Takes the states of one group after the other out of X, so that no intermediate result is larger
    /// than X; their union may be.
    fn cannot_choose(&self, x: &StateSet, c: &ChoiceSet) -> Result<StateSet> {
        if self.opponent().is_some() {
            return self.difference(x, &self.can_choose(&self.choices_in(c, x)?)?);
        }
        let mut left = self.diagram_of(x)?.clone();
        for states in self.diagrams_of(c)? {
            left = self.store.minus(&left, states)?;
        }
        Ok(StateSet(left))
    }

    fn theirs(&self) -> Option<StateSet> {
        self.opponent_states()
    }

    fn player_states(&self) -> Vec<StateSet> {
        self.game.iter().flat_map(|game| &game.players).cloned().map(StateSet).collect()
    }

    fn coalition(&self) -> Vec<bool> {
        self.game.as_ref().map_or_else(Vec::new, |game| game.coalition.clone())
    }

    fn with_coalition(&self, coalition: &[bool]) -> Result<Self> {
        self.played_by(coalition)
    }

    fn pre(&self, c: &ChoiceSet, x: &StateSet) -> Result<ChoiceSet> {
        let (store, c, x) = (&self.store, self.groups_of(c)?, self.diagram_of(x)?);
        let mut found = Vec::with_capacity(c.len());
        for (list, allowed) in self.groups.iter().zip(c) {
            found.push(store.step(Direction::Backward, list, x, allowed)?);
        }
        found.push(self.loops_in(c, x)?);
        Ok(ChoiceSet(Arc::new(found)))
    }

    /// Looks at the states of one group after the other for which no group before has a step into X.
    fn can_enter(&self, c: &ChoiceSet, x: &StateSet) -> Result<StateSet> {
        if self.opponent().is_some() {
            return self.can_choose(&self.pre(c, x)?);
        }
        let (store, sources) = (&self.store, self.sources(c)?);
        let (c, x) = (self.groups_of(c)?, self.diagram_of(x)?);
        let mut open = store.minus(&sources.0, &self.loops_in(c, x)?)?;
        for (list, own) in self.groups.iter().zip(c) {
            let own = store.and(&open, own)?;
            let spared = store.spare(Direction::Backward, list, x, &own)?;
            open = store.minus(&open, &store.minus(&own, &spared)?)?;
        }
        Ok(StateSet(store.minus(&sources.0, &open)?))
    }

    /// Uses the relations alone, without the states of the scope as a bound. Otherwise the check
    /// that a given scope is closed under steps would always succeed.
    fn post(&self, c: &ChoiceSet) -> Result<StateSet> {
        let c = self.groups_of(c)?;
        let anywhere = self.store.one();
        let mut images = vec![self.loops_in(c, &anywhere)?];
        for (list, sources) in self.groups.iter().zip(c) {
            images.push(self.store.step(Direction::Forward, list, sources, &anywhere)?);
        }
        Ok(StateSet(self.store.any(images)?))
    }

    fn can_reach(
        &self,
        target: &StateSet,
        within: &ChoiceSet,
        edge_labels: &[EdgeLabels<StateSet>],
    ) -> Result<StateSet> {
        self.check_owned(edge_labels)?;
        let bound = self.groups_of(within)?;
        if let Some(opponent) = self.opponent() {
            self.diagram_of(target)?;
            return self.attract_in_game(opponent, target, &self.no_choices(), within, edge_labels);
        }
        let dropped: Vec<(Bdd, Bdd)> = edge_labels::dropped(self, edge_labels)?
            .into_iter()
            .map(|(from, into)| (from.0, into.0))
            .collect();
        let from = self.diagram_of(target)?;
        if dropped.is_empty()
            && let Some(states) = self.states_of_all_choices(bound)?
        {
            let pass = Pass::backward("backward reachability");
            let within = self.store.or(&states, from)?;
            return Ok(StateSet(self.store.reach(pass, &self.list, from, &within)?));
        }
        attempts::can_reach(self, from, bound, &dropped).map(StateSet)
    }

    /// The bound is one for all relations at once, so no set of choices is needed.
    fn can_reach_through(&self, target: &StateSet, bound: &StateSet) -> Result<StateSet> {
        if self.opponent().is_some() || self.choices.0 != self.enabled {
            return self.can_reach(target, &self.choices_in(&self.choices, bound)?, &[]);
        }
        let (from, bound) = (self.diagram_of(target)?, self.diagram_of(bound)?);
        let (pass, within) = (Pass::backward("backward reachability"), self.store.or(bound, from)?);
        Ok(StateSet(self.store.reach(pass, &self.list, from, &within)?))
    }

    fn can_win(
        &self,
        winning: &ChoiceSet,
        within: &ChoiceSet,
        edge_labels: &[EdgeLabels<StateSet>],
    ) -> Result<StateSet> {
        if let Some(opponent) = self.opponent() {
            self.check_owned(edge_labels)?;
            self.groups_of(within).and(self.groups_of(winning))?;
            return self.attract_in_game(opponent, &self.no_states(), winning, within, edge_labels);
        }
        edge_labels::reach_winning(self, winning, within, edge_labels)
    }

    fn remove_attractor(
        &self,
        left: Region<StateSet, ChoiceSet>,
        within: &ChoiceSet,
        won: &StateSet,
        edge_labels: &[EdgeLabels<StateSet>],
        lost: StateSet,
    ) -> Result<Region<StateSet, ChoiceSet>> {
        for x in [&left.states, won, &lost] {
            self.diagram_of(x)?;
        }
        for c in [&left.choices, within] {
            self.groups_of(c)?;
        }
        self.check_owned(edge_labels)?;
        let (left, lost) = self.lose_states(left, within, won, edge_labels, lost)?;
        let Some(lost) = lost else { return Ok(left) };
        let gone = plain_edges_into(self, &left.choices, edge_labels, &lost)?;
        Ok(Region { choices: self.difference(&left.choices, &gone)?, ..left })
    }

    fn surely_staying(&self, x: &StateSet, within: &ChoiceSet) -> Result<StateSet> {
        let (left, lost) = edge_labels::confined_to(self, x, within)?;
        Ok(self.lose_states(left, within, &self.no_states(), &[], lost)?.0.states)
    }

    fn count_model_states(&self, x: &StateSet) -> Result<Option<Count>> {
        let x = self.diagram_of(x)?;
        let Some(monitors) = &self.program.monitors else { return Ok(None) };
        let plain = self.store.exists(x, &self.encoding.bits_of(&self.store, &monitors.variables)?)?;
        let unseen = monitors.variables.iter().map(|&v| self.encoding.positions(v).len());
        self.store.count(&plain, (self.encoding.width() + unseen.sum::<usize>()) as u32).map(Some)
    }

    fn count_transitions(&self, c: &ChoiceSet, x: &StateSet) -> Result<Count> {
        let (c, x) = (self.groups_of(c)?, self.diagram_of(x)?);
        let target = (*x != self.states.0).then_some(x);
        let loops = self.loops_in(c, x)?;
        let mut total = self.store.count(&loops, self.encoding.width() as u32)?;
        for piece in &self.transitions.pieces {
            total += self.count_piece(piece, &c[piece.group], target)?;
        }
        Ok(total)
    }

    fn list_states(&self, x: &StateSet, limit: usize) -> Result<Vec<State>> {
        pick::list(&self.store, &self.encoding, self.diagram_of(x)?, limit)
    }

    fn singleton(&self, state: &[i64]) -> Result<StateSet> {
        if !self.encoding.is_valid(state) {
            return Ok(self.no_states());
        }
        let cube = self.encoding.state(&self.store, state)?;
        Ok(StateSet(self.store.and(&cube, &self.states.0)?))
    }

    fn slice(&self, fixed: &[(VarId, i64)]) -> Result<StateSet> {
        let mut slice = self.states.0.clone();
        for &(variable, value) in fixed {
            let declared = &self.program.variables[variable.index()];
            if !(declared.low..=declared.high).contains(&value) {
                return Ok(self.no_states());
            }
            let offset = value.wrapping_sub(declared.low) as u64;
            slice = self.store.and(&self.encoding.value(&self.store, variable, offset)?, &slice)?;
        }
        Ok(StateSet(slice))
    }

    fn contains(&self, x: &StateSet, state: &[i64]) -> Result<bool> {
        Ok(self.satisfies(self.diagram_of(x)?, state))
    }

    fn membership<'e>(&'e self, sets: &[&StateSet]) -> Result<Box<dyn Membership + 'e>> {
        let diagrams = sets.iter().map(|x| self.diagram_of(x)).collect::<Result<Vec<_>>>()?;
        Ok(match Marks::new(&self.store, &self.encoding, &diagrams, &self.settings)? {
            Some(marks) => Box::new(marks),
            None => Box::new(Each::new(self, sets)),
        })
    }

    fn contains_choice(&self, c: &ChoiceSet, state: &[i64], choice: &Choice) -> Result<bool> {
        let c = self.groups_of(c)?;
        Ok(self.transitions.group_of(choice).is_some_and(|group| self.satisfies(&c[group], state)))
    }

    fn usage(&self) -> Usage {
        self.store.usage()
    }

    fn settings(&self) -> &Settings {
        &self.settings
    }
}
