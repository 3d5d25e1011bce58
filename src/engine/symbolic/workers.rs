//! Workers: engines of the same model with stores of their own, for other threads.

use std::iter;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::relations::lists::Lists;
use super::store::diagram::Bdd;
use super::{ChoiceSet, StateSet, SymbolicEngine};
use crate::parallel::Sets;
use crate::settings::Settings;
use meliora_base::error::Result;

/// The workers of an engine; clones of the engine share them.
#[derive(Clone, Default)]
pub(super) struct Workers(Arc<Mutex<State>>);

#[derive(Default)]
enum State {
    /// Their number is decided when they are needed.
    #[default]
    Possible,
    /// Each is made by the thread that needs it; `None` if the memory did not suffice.
    Prepared(Arc<[OnceLock<Option<SymbolicEngine>>]>),
    /// They are not made again, because the memory did not suffice.
    Refused,
}

impl Workers {
    fn with<T>(&self, change: impl FnOnce(&mut State) -> T) -> T {
        change(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl SymbolicEngine {
    /// Returns the workers, of which some may not be made yet.
    pub(super) fn prepared_workers(&self) -> Arc<[OnceLock<Option<SymbolicEngine>>]> {
        if self.settings.threads <= 1 {
            return Arc::default();
        }
        self.workers.with(|state| {
            if let State::Possible = state {
                // An error is a limit, which the next operation of this engine reports.
                let number = if self.is_large().unwrap_or(false) { self.settings.threads - 1 } else { 0 };
                *state = State::Prepared(iter::repeat_with(OnceLock::new).take(number as usize).collect());
            }
            match state {
                State::Prepared(workers) => Arc::clone(workers),
                State::Possible | State::Refused => Arc::default(),
            }
        })
    }

    /// See [`crate::Engine::dismiss_workers`].
    pub(super) fn drop_workers(&self, forever: bool) {
        let dropped = self.workers.with(|state| {
            let next = if forever { State::Refused } else { State::Possible };
            match state {
                State::Refused => State::Refused,
                state => std::mem::replace(state, next),
            }
        });
        if let State::Prepared(workers) = dropped {
            let made = workers.iter().filter_map(|worker| worker.get()?.as_ref());
            made.for_each(|worker| self.store.work.add(&worker.store.work));
        }
    }

    /// Returns true if the states and the relations have so many nodes that workers pay off.
    fn is_large(&self) -> Result<bool> {
        let enough = self.store.thresholds().nodes_for_threads;
        let mut nodes = self.store.size(&self.states.0)?;
        for piece in &self.transitions.pieces {
            if nodes >= enough {
                break;
            }
            nodes += self.store.size(&piece.steps.relation)?;
        }
        Ok(nodes >= enough)
    }

    /// Creates a worker. Cost: linear in the nodes of the relations and of the states.
    pub(super) fn new_worker(&self) -> Result<SymbolicEngine> {
        let settings = Settings { threads: 1, ..self.settings.clone() };
        let store = self.store.companion(&settings)?;
        let mut transitions = (*self.transitions).clone();
        let mut clusters = (*self.clusters).clone();
        let mut enabled = (*self.enabled).clone();
        let mut choices = (*self.choices.0).clone();
        let mut players = self.game.as_ref().map_or_else(Vec::new, |game| game.players.clone());
        let mut sets = [&self.domain, &self.states.0, &self.initial.0, &self.deadlocks.0].map(Bdd::clone);
        let own = sets.iter_mut().chain(&mut enabled).chain(&mut choices).chain(&mut players);
        store.adopt_all(&self.store, own.chain(transitions.diagrams()).chain(clusters.diagrams()))?;
        let lists = Lists::new(&store);
        clusters.relist(&store, &lists)?;
        let game = self.game.as_ref().map(|game| game.moved(&store, players)).transpose()?;
        let [domain, states, initial, deadlocks] = sets;
        Ok(SymbolicEngine {
            program: self.program.clone(),
            settings,
            encoding: self.encoding.clone(),
            groups: transitions.lists(&store, &lists)?,
            tuple: OnceLock::new(),
            quiet: OnceLock::new(),
            lists,
            transitions: Arc::new(transitions),
            few_parts: self.few_parts.clone(),
            clusters: Arc::new(clusters),
            domain,
            states: StateSet(states),
            initial: StateSet(initial),
            deadlocks: StateSet(deadlocks),
            rounded: self.rounded.clone(),
            enabled: Arc::new(enabled),
            choices: ChoiceSet(Arc::new(choices)),
            has_loops: self.has_loops,
            game,
            workers: Workers::default(),
            store: Arc::new(store),
        })
    }

    /// See [`crate::Engine::adopt`].
    pub(super) fn adopted(
        &self,
        from: &SymbolicEngine,
        mut sets: Sets<StateSet, ChoiceSet>,
    ) -> Result<Sets<StateSet, ChoiceSet>> {
        sets.states.iter().try_for_each(|x| from.diagram_of(x).map(drop))?;
        sets.choices.iter().try_for_each(|c| from.groups_of(c).map(drop))?;
        if !self.shares(from) {
            let choices = sets.choices.iter_mut().flat_map(|c| Arc::make_mut(&mut c.0));
            self.store.adopt_all(&from.store, sets.states.iter_mut().map(|x| &mut x.0).chain(choices))?;
        }
        Ok(sets)
    }
}
