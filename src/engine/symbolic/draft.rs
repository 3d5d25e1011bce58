//! A program as diagrams, before its states are known: encoding, relations, exploration, faults.

use std::sync::Arc;

use super::encoding::Encoding;
use super::encoding::command::CommandBuilder;
use super::encoding::transitions::{Builder, Transitions};
use super::encoding::translate::Translator;
use super::order::Bit;
use super::pick;
use super::relations::lists::{Lists, RelationList};
use super::store::Store;
use super::store::diagram::Bdd;
use super::store::tables::cache_for_nodes;
use super::store::walk::Pass;
use crate::settings::{Scope, Settings};
use meliora_base::error::Result;
use meliora_model::temporal::Begin;
use meliora_model::{Program, State, fault};

/// The parts of an engine under construction.
pub(super) struct Draft {
    pub(super) program: Arc<Program>,
    pub(super) settings: Settings,
    pub(super) encoding: Encoding,
    /// Replaced by [`Draft::size_to`].
    pub(super) store: Store,
    pub(super) lists: Arc<Lists>,
    pub(super) domain: Bdd,
    pub(super) translated: Translated,
    /// The relations of all groups.
    pub(super) list: Arc<RelationList>,
}

impl Draft {
    pub(super) fn new(program: Arc<Program>, order: Vec<Bit>, settings: Settings) -> Result<Self> {
        let encoding = Encoding::new(&program, order);
        let store = Store::new(encoding.width(), &settings)?;
        let lists = Lists::new(&store);
        let domain = encoding.domain(&store)?;
        let translated = translate(&program, &encoding, &store, &domain)?;
        let list = translated.transitions.list(&store, &lists)?;
        Ok(Draft { program, settings, encoding, store, lists, domain, translated, list })
    }

    /// Computes the states of the scope.
    ///
    /// If monitors may begin everywhere, each reached state of the model is combined with all
    /// values of the monitors. This set has a simpler diagram than the reachable pairs, and the
    /// answers are the same.
    pub(super) fn explore(&self) -> Result<Bdd> {
        let Draft { program, encoding, store, domain, .. } = self;
        let initial = &self.translated.initial;
        let Some(start) = beginnings(program, encoding, store, self.settings.scope, initial, domain)? else {
            return Ok(domain.clone());
        };
        let phase = "reachable states";
        store.progress(phase);
        // Variable orders take turns, so methods do not: the recursion was faster wherever both ended.
        let reached = store.fixpoint(false, Pass::forward(phase), u64::MAX, &self.list, &start, domain)?;
        let reached = reached.ok_or_else(|| store.full())?;
        match &program.monitors {
            Some(o) if o.begin == Begin::Everywhere => {
                let bits = encoding.bits_of(store, &o.variables)?;
                store.and(&store.exists(&reached, &bits)?, domain)
            }
            _ => Ok(reached),
        }
    }

    /// Checks that every part of the program has a meaning in all states. Returns an example of a
    /// state in which an enabled command has probabilities that were rounded, if there is one.
    ///
    /// # Errors
    /// A limit, or a state in which some part of the program has no meaning.
    pub(super) fn checked(&self, states: &Bdd) -> Result<Option<State>> {
        let Draft { program, encoding, store, translated, .. } = self;
        let bad = self.without_meaning(states)?;
        if !store.is_zero(&bad) {
            return Err(fault::in_state(program, &pick::first(store, encoding, &bad)?));
        }
        Ok(pick::list(store, encoding, &store.and(&translated.rounded, states)?, 1)?.pop())
    }

    /// Returns the states in which some part of the program has no meaning.
    fn without_meaning(&self, states: &Bdd) -> Result<Bdd> {
        let Translated { transitions, initial_fails, .. } = &self.translated;
        self.store.and(&self.store.or(&transitions.bad, initial_fails)?, states)
    }

    /// Returns the valuations from which no state is reached in which some part of the program has no meaning; `None`
    /// if an initial state is not one of these.
    pub(super) fn meaningful(&self) -> Result<Option<Bdd>> {
        let Draft { store, domain, translated, .. } = self;
        let failing = store.reach(
            Pass::backward("states without a meaning"),
            &self.list,
            &self.without_meaning(domain)?,
            domain,
        )?;
        if !store.is_zero(&store.and(&failing, &translated.initial)?) {
            return Ok(None);
        }
        store.minus(domain, &failing).map(Some)
    }

    /// Moves all diagrams into a larger store, if this one is too small for the remaining work. The fixpoints after
    /// exploration need hundreds of nodes for each node of the set of states.
    pub(super) fn size_to(&mut self, states: &mut Bdd) -> Result<()> {
        let entries = cache_for_nodes(self.store.size(states)?);
        let Some(larger) = self.store.larger(entries, &self.settings) else { return Ok(()) };
        let Translated { transitions, initial, initial_fails, rounded } = &mut self.translated;
        let single = [&mut self.domain, initial, initial_fails, rounded, states].into_iter();
        let all = single.chain(transitions.diagrams());
        larger.adopt_all(&self.store, |level| level, all)?;
        let lists = Lists::new(&larger);
        self.list = transitions.list(&larger, &lists)?;
        (self.store, self.lists) = (larger, lists);
        Ok(())
    }
}

/// Returns the states in which the exploration of a scope begins; `None` if all valuations are
/// states and nothing is explored.
pub(super) fn beginnings(
    program: &Program,
    encoding: &Encoding,
    store: &Store,
    scope: Scope,
    initial: &Bdd,
    domain: &Bdd,
) -> Result<Option<Bdd>> {
    match (scope, &program.monitors) {
        (Scope::Reachable, _) => Ok(Some(initial.clone())),
        (Scope::All, Some(o)) if o.begin == Begin::Initially => {
            let (fresh, _) = Translator::new(program, encoding, store).condition(o.fresh)?;
            Ok(Some(store.and(&fresh, domain)?))
        }
        (Scope::All, _) => Ok(None),
    }
}

/// A program as diagrams.
pub(super) struct Translated {
    pub(super) transitions: Transitions,
    pub(super) initial: Bdd,
    /// The states in which the expression for the initial states has no value.
    initial_fails: Bdd,
    /// The states in which an enabled command has probabilities that were rounded.
    rounded: Bdd,
}

fn translate(program: &Program, encoding: &Encoding, store: &Store, domain: &Bdd) -> Result<Translated> {
    let translator = Translator::new(program, encoding, store);
    let commands = CommandBuilder { store, encoding, translator: &translator, rounded: store.zero().into() };
    let transitions = Builder::build(program, store, &commands)?;
    let (initial, fails) = translator.condition(program.initial)?;
    // In states without a value, the diagram of the expression is arbitrary.
    let initial = store.minus(&store.and(&initial, domain)?, &fails)?;
    let initial_fails = store.and(&fails, domain)?;
    Ok(Translated { transitions, initial, initial_fails, rounded: commands.rounded.into_inner() })
}
