//! From a program to an engine: encoding, relations, reachable states, faults.

use std::sync::Arc;

use super::clusters::Clusters;
use super::command::CommandBuilder;
use super::diagram::Bdd;
use super::encoding::{Bit, Encoding};
use super::local::Local;
use super::store::Store;
use super::transitions::{Builder, Piece, Transitions};
use super::translate::Translator;
use super::walk::Direction;
use super::{StateSet, SymbolicEngine, pick};
use crate::engine::{Scope, Settings};
use crate::error::{Limit, Result};
use crate::model::fault;
use crate::model::temporal::Begin;
use crate::model::{ModelKind, Program, State};

/// Recursion over diagrams is as deep as states have bits.
const MOST_BITS: usize = 1 << 16;

/// Says which states there are, instead of an exploration.
pub(super) type Given<'a> = dyn Fn(&Store) -> Result<Bdd> + 'a;

/// Builds the engine; see [`SymbolicEngine::new`]. The states of the scope may be given.
pub(super) fn build(
    program: Arc<Program>,
    order: Vec<Bit>,
    settings: Settings,
    given: Option<&Given<'_>>,
) -> Result<SymbolicEngine> {
    check_width(order.len())?;
    let encoding = Encoding::new(&program, order);
    let mut store = Store::new(encoding.width(), settings.threads, &settings)?;
    let mut domain = encoding.domain(&store)?;
    let translated = translate(&program, &encoding, &store, &domain)?;
    let mut clusters = Clusters::new(&store, &translated.transitions.pieces)?;
    let mut states = match given {
        Some(given) => store.and(&given(&store)?, &domain)?,
        None => Explore { program: &program, encoding: &encoding, store: &store, clusters: &clusters }
            .scope(settings.scope, &translated.initial, &domain)?,
    };
    let rounded = checked(&program, &encoding, &store, &translated, &states)?;
    let Translated { mut transitions, mut initial, .. } = translated;
    if let Some(larger) = store.larger(&states, settings.threads, &settings) {
        let single = [&mut domain, &mut initial, &mut states].into_iter();
        larger.adopt_all(&store, single.chain(transitions.diagrams()).chain(clusters.diagrams()))?;
        clusters.relist(&larger)?;
        store = larger;
    }
    let (enabled, looping) = enabled(&store, &transitions, &states)?;
    let deadlocks = deadlocks(&program, &encoding, &store, &states)?.unwrap_or(looping);
    if program.kind == ModelKind::Dtmc {
        transitions.pieces = disjoint(&store, std::mem::take(&mut transitions.pieces), &states)?;
    }
    let groups = transitions.lists(&store)?;
    Ok(SymbolicEngine {
        program,
        settings,
        encoding,
        transitions,
        groups,
        few_parts: Default::default(),
        clusters,
        domain,
        states: StateSet(states),
        initial: StateSet(initial),
        deadlocks: StateSet(deadlocks),
        rounded,
        enabled: Arc::new(enabled),
        reaching: Default::default(),
        store,
    })
}

fn check_width(bits: usize) -> Result<()> {
    if bits > MOST_BITS {
        let what = format!("states of {bits} bits for the symbolic engine, which takes {MOST_BITS}");
        return Err(Limit::Size { what }.into());
    }
    Ok(())
}

/// What the exploration of a scope works with.
struct Explore<'a> {
    program: &'a Program,
    encoding: &'a Encoding,
    store: &'a Store,
    clusters: &'a Clusters,
}

impl Explore<'_> {
    /// The states of the scope. Where observers may begin everywhere, all their states go with each state of
    /// the model: the set is simpler than that of the pairs that can be reached, and answers are the same.
    fn scope(&self, scope: Scope, initial: &Bdd, domain: &Bdd) -> Result<Bdd> {
        let store = self.store;
        let Some(start) = beginnings(self.program, self.encoding, store, scope, (initial, domain))? else {
            return Ok(domain.clone());
        };
        let met = self.clusters.forward(store, &start, domain)?;
        match &self.program.observers {
            Some(o) if o.begin == Begin::Everywhere => {
                let bits = self.encoding.bits_of(store, &o.variables)?;
                store.and(&store.exists(&met, &bits)?, domain)
            }
            _ => Ok(met),
        }
    }
}

/// Where the exploration of a scope begins; none where all valuations are states, and nothing is explored.
pub(super) fn beginnings(
    program: &Program,
    encoding: &Encoding,
    store: &Store,
    scope: Scope,
    (initial, domain): (&Bdd, &Bdd),
) -> Result<Option<Bdd>> {
    match (scope, &program.observers) {
        (Scope::Reachable, _) => Ok(Some(initial.clone())),
        (Scope::All, Some(o)) if o.begin == Begin::Initially => {
            let (fresh, _) = Translator::new(program, encoding, store).condition(o.fresh)?;
            Ok(Some(store.and(&fresh, domain)?))
        }
        (Scope::All, _) => Ok(None),
    }
}

/// A program as diagrams.
struct Translated {
    transitions: Transitions,
    initial: Bdd,
    /// Where the expression for the initial states has no value.
    initial_fails: Bdd,
    /// Where an enabled command has probabilities that were rounded.
    rounded: Bdd,
}

fn translate(program: &Program, encoding: &Encoding, store: &Store, domain: &Bdd) -> Result<Translated> {
    let translator = Translator::new(program, encoding, store);
    let commands = CommandBuilder { store, encoding, translator: &translator, rounded: store.zero().into() };
    let transitions = Builder::build(program, store, &commands)?;
    let (initial, fails) = translator.condition(program.initial)?;
    // Where the expression has no value, its diagram may say anything.
    let initial = store.minus(&store.and(&initial, domain)?, &fails)?;
    let initial_fails = store.and(&fails, domain)?;
    Ok(Translated { transitions, initial, initial_fails, rounded: commands.rounded.into_inner() })
}

/// A state in which an enabled command has probabilities that were rounded, where every state has a meaning.
///
/// # Errors
/// A limit, or a state in which some part of the program has no meaning.
fn checked(
    program: &Program,
    encoding: &Encoding,
    store: &Store,
    translated: &Translated,
    states: &Bdd,
) -> Result<Option<State>> {
    let bad = store.and(&store.or(&translated.transitions.bad, &translated.initial_fails)?, states)?;
    if !store.is_zero(&bad) {
        return Err(fault::in_state(program, &pick::first(store, encoding, &bad)?));
    }
    Ok(pick::list(store, encoding, &store.and(&translated.rounded, states)?, 1)?.pop())
}

/// For each group, and last for the self-loops of deadlocks, where it is enabled; and the deadlocks.
fn enabled(store: &Store, transitions: &Transitions, states: &Bdd) -> Result<(Vec<Bdd>, Bdd)> {
    let mut enabled = Vec::new();
    for guard in &transitions.guards {
        enabled.push(store.and(guard, states)?);
    }
    let deadlocks = store.minus(states, &store.any(enabled.iter().cloned())?)?;
    enabled.push(deadlocks.clone());
    Ok((enabled, deadlocks))
}

/// The deadlocks of the model, where observers step there: for the engine it is a choice like any other.
fn deadlocks(program: &Program, encoding: &Encoding, store: &Store, states: &Bdd) -> Result<Option<Bdd>> {
    let Some(deadlock) = program.observers.as_ref().and_then(|o| o.deadlock) else { return Ok(None) };
    let (holds, _) = Translator::new(program, encoding, store).condition(deadlock)?;
    store.and(&holds, states).map(Some)
}

/// Unites pieces that move the same state, so that no transition is counted twice.
fn disjoint(store: &Store, pieces: Vec<Piece>, states: &Bdd) -> Result<Vec<Piece>> {
    let mut done: Vec<(Bdd, Piece)> = Vec::new();
    for mut piece in pieces {
        let list = store.lists.of(store, vec![piece.steps.clone()])?;
        let mut sources = store.step(Direction::Backward, &list, &store.one(), states)?;
        let (mut apart, mut together) = (Vec::new(), Vec::new());
        for (theirs, other) in done {
            let overlap = !store.is_zero(&store.and(&theirs, &sources)?);
            (if overlap { &mut together } else { &mut apart }).push((theirs, other));
        }
        for (theirs, other) in together {
            piece.steps = Local::union(store, &[&piece.steps, &other.steps])?;
            sources = store.or(&sources, &theirs)?;
        }
        apart.push((sources, piece));
        done = apart;
    }
    Ok(done.into_iter().map(|(_, piece)| piece).collect())
}
