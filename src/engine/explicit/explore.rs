//! Breadth-first exploration of the states of a program and their choices.

use std::sync::Arc;

use num_bigint::BigUint;

use super::games::PlayersFound;
use super::graph::Graph;
use super::index::{Index, NOBODY};
use super::initial::Search;
use super::layout::{Layout, width};
use super::meter::{Array, Meter};
use super::program::Prepared;
use super::set::{self, BitSet};
use super::stepper::{Broken, Stepper, sum};
use crate::settings::{Scope, Settings};
use meliora_model::error::{Error, Limit, Result};
use meliora_model::temporal::Begin;
use meliora_model::{Program, State, fault};

/// Number of states explored between two checks of the progress sink.
const PATIENCE: usize = 1 << 12;
/// Minimum number of bytes per state: its entries in the sparse rows.
const LEAST_BYTES: u64 = 12;

/// The states of a scope, by number.
#[derive(Debug)]
pub(super) enum Space {
    /// The states reached, numbered in this order.
    Indexed(Index),
    /// Every valuation, numbered in the order of the values; contains their number.
    Every(usize),
}

/// The states of a scope with their choices and successors.
pub(super) struct Explored {
    pub(super) space: Space,
    pub(super) graph: Graph,
    pub(super) initial: BitSet,
    pub(super) deadlocks: BitSet,
    /// The first state in which probabilities sum to 1 only after rounding.
    pub(super) rounded: Option<State>,
    /// For a game, the player of each state; [`NOBODY`] for deadlocks.
    pub(super) players: Option<Array<u32>>,
}

/// The input of an exploration.
pub(super) struct Task<'a> {
    pub(super) program: &'a Arc<Program>,
    pub(super) settings: &'a Settings,
    pub(super) layout: &'a Layout,
    pub(super) prepared: &'a Prepared,
    pub(super) meter: &'a Meter,
}

/// Chooses the layout of the codes of the states.
///
/// # Errors
/// The valuations are too many for the memory limit, or the variables for a code.
pub(super) fn layout(program: &Program, settings: &Settings) -> Result<Layout> {
    let begin = program.monitors.as_ref().map(|o| o.begin);
    if settings.scope == Scope::Reachable || begin == Some(Begin::Initially) {
        return Layout::packed(program);
    }
    let layout = Layout::radix(program);
    match layout.filter(|l| l.valuations().is_some_and(|n| n <= settings.memory / LEAST_BYTES)) {
        Some(layout) => Ok(layout),
        None => {
            let sizes = program.variables.iter().map(|v| BigUint::from(width(v)) + 1u32);
            let states: BigUint = sizes.product();
            let what = format!(
                "the scope `all` has {states} states, too many for the {} bytes of the explicit engine",
                settings.memory
            );
            Err(Limit::Memory { what }.into())
        }
    }
}

impl Task<'_> {
    /// Explores the scope.
    ///
    /// # Errors
    /// A limit of the engine is reached, or a command has no meaning in some state.
    pub(super) fn run(&self) -> Result<Explored> {
        match self.layout.words() {
            1 => self.explore::<1>(),
            2 => self.explore::<2>(),
            3 => self.explore::<3>(),
            4 => self.explore::<4>(),
            5..=8 => self.explore::<8>(),
            9..=16 => self.explore::<16>(),
            _ => self.explore::<32>(),
        }
    }

    fn explore<const W: usize>(&self) -> Result<Explored> {
        let mut exploring = self.start::<W>()?;
        // A state takes longer if more guards are evaluated, so the interval depends on the
        // commands.
        let interval = (PATIENCE / self.program.commands.len().max(1)).max(1);
        let mut state = 0;
        while state < exploring.space.len() {
            // A state with many successors takes as long as many states.
            if state % interval == 0 || exploring.stepper.steps.len() >= PATIENCE {
                // In the scope `all` every valuation is a state, so the explored states are
                // reported.
                let reached =
                    if matches!(exploring.space, Space::Every(_)) { state } else { exploring.space.len() };
                self.report(state, reached)?;
            }
            let code = exploring.space.code::<W>(state);
            self.look(&mut exploring, state, &code)?;
            exploring.add(state, &code)?;
            state += 1;
        }
        Ok(self.finish(exploring))
    }

    fn start<const W: usize>(&self) -> Result<Exploring<'_, W>> {
        let space = match self.layout.valuations() {
            Some(n) => Space::Every(n as usize),
            None => Space::Indexed(self.initial_states::<W>()?),
        };
        let begin = self.program.monitors.as_ref().map(|o| o.begin);
        Ok(Exploring {
            restarts: begin == Some(Begin::Everywhere) && matches!(space, Space::Indexed(_)),
            started: space.len(),
            space,
            stepper: Stepper::new(self.prepared),
            graph: Graph::new(self.meter)?,
            initial: Vec::new(),
            deadlocks: Vec::new(),
            rounded: None,
            players: self.players(),
        })
    }

    /// Returns the players of a game.
    fn players(&self) -> Option<PlayersFound> {
        self.program.players.as_ref()?;
        let player = |s| self.program.player_of(s).map_or(NOBODY, |player| player as u32);
        let players = self.program.synchronisations.iter().map(player).collect();
        Some(PlayersFound::new(players, Array::new(self.meter)))
    }

    /// Computes the steps from a state and tests whether it is an initial state.
    #[inline]
    fn look<const W: usize>(
        &self,
        exploring: &mut Exploring<'_, W>,
        state: usize,
        code: &[u64; W],
    ) -> Result<()> {
        exploring.stepper.enter(self.layout, code);
        let tests = self.settings.scope == Scope::All && state < exploring.started;
        if tests || self.prepared.initial_is_partial {
            let holds = exploring.stepper.is_initial().map_err(|_| self.fault(code))?;
            if holds && tests {
                exploring.initial.push(state);
            }
        }
        exploring.stepper.expand().map_err(|broken| self.broken(broken, code))?;
        if let Some(players) = &mut exploring.players
            && !players.add(|synchronisation| exploring.stepper.combinations(synchronisation))?
        {
            return Err(fault::of_two_players(self.program, &self.values(code))?);
        }
        if exploring.stepper.rounded {
            exploring.rounded.get_or_insert_with(|| self.values(code));
        }
        Ok(())
    }

    fn finish<const W: usize>(&self, exploring: Exploring<'_, W>) -> Explored {
        let Exploring { mut space, mut graph, mut initial, deadlocks, rounded, started, players, .. } =
            exploring;
        if let Space::Indexed(index) = &mut space {
            index.shrink();
            if self.settings.scope == Scope::Reachable {
                initial.extend(0..started);
            }
        }
        graph.shrink();
        let bits = |states: Vec<usize>| {
            let mut bits = BitSet::empty(self.meter, space.len());
            states.into_iter().for_each(|s| set::set(bits.words_mut(), s));
            bits
        };
        let (initial, deadlocks) = (bits(initial), bits(deadlocks));
        let players = players.map(|players| players.of_state);
        Explored { initial, deadlocks, rounded, space, graph, players }
    }

    fn initial_states<const W: usize>(&self) -> Result<Index> {
        let mut index = Index::new(W, self.meter);
        let start = match (self.settings.scope, &self.program.monitors) {
            (Scope::All, Some(monitors)) => monitors.fresh,
            _ => self.program.initial,
        };
        let mut search = Search::new(self.program, start, &*self.settings.sink)?;
        search.run(&mut |values| {
            if let Some(code) = self.layout.encode(values) {
                index.intern::<W>(&fixed(&code))?;
            }
            Ok(())
        })?;
        Ok(index)
    }

    fn report(&self, explored: usize, reached: usize) -> Result<()> {
        self.meter.reached(reached);
        let detail = || format!("{explored} states explored, {reached} reached");
        self.settings.sink.progress("reachable states", &detail);
        match self.settings.sink.stop() {
            Some(limit) => Err(limit.into()),
            None => Ok(()),
        }
    }

    fn broken(&self, broken: Broken, code: &[u64]) -> Error {
        broken.error(self.program, &self.values(code))
    }

    fn fault(&self, code: &[u64]) -> Error {
        fault::in_state(self.program, &self.values(code))
    }

    fn values(&self, code: &[u64]) -> State {
        let mut values = vec![0; self.program.variables.len()];
        self.layout.decode(code, &mut values);
        values
    }
}

/// The state of an exploration.
struct Exploring<'a, const W: usize> {
    space: Space,
    /// Number of states before the first step.
    started: usize,
    /// True if monitors may begin in every reached state.
    restarts: bool,
    stepper: Stepper<'a, W>,
    graph: Graph,
    initial: Vec<usize>,
    deadlocks: Vec<usize>,
    rounded: Option<State>,
    players: Option<PlayersFound>,
}

impl<const W: usize> Exploring<'_, W> {
    /// Adds the steps from a state, with their successors, to the graph.
    #[inline]
    fn add(&mut self, state: usize, code: &[u64; W]) -> Result<()> {
        if self.stepper.ends.is_empty() || self.stepper.steps_alone() {
            self.deadlocks.push(state);
        }
        if self.stepper.ends.is_empty() {
            self.graph.add(state as u32)?;
            self.graph.end_choice()?;
        }
        let mut at = 0;
        for &end in &self.stepper.ends {
            for step in &self.stepper.steps[at..end as usize] {
                self.graph.add(self.space.number(&sum(code, step))?)?;
            }
            self.graph.end_choice()?;
            at = end as usize;
        }
        self.graph.end_state()?;
        if self.restarts {
            self.space.number(&sum(code, &self.stepper.restart()))?;
        }
        Ok(())
    }
}

impl Space {
    /// Returns the number of states.
    #[inline]
    pub(super) fn len(&self) -> usize {
        match self {
            Space::Indexed(index) => index.len(),
            Space::Every(n) => *n,
        }
    }

    /// Returns the code of a state.
    #[inline]
    fn code<const W: usize>(&self, state: usize) -> [u64; W] {
        match self {
            Space::Indexed(index) => fixed(index.code(state)),
            Space::Every(_) => fixed(&[state as u64]),
        }
    }

    /// Returns the number of the state with this code; assigns a new number if necessary.
    #[inline]
    fn number<const W: usize>(&mut self, code: &[u64; W]) -> Result<u32> {
        match self {
            Space::Indexed(index) => index.intern::<W>(code),
            Space::Every(_) => Ok(code[0] as u32),
        }
    }

    /// Returns the number of the state with this code, if it is in the scope.
    pub(super) fn find(&self, code: &[u64]) -> Option<usize> {
        match self {
            Space::Indexed(index) => index.find(code).map(|id| id as usize),
            Space::Every(_) => code.first().map(|&c| c as usize),
        }
    }
}

/// Copies words to a code of fixed length; missing words are 0.
#[inline]
pub(super) fn fixed<const W: usize>(words: &[u64]) -> [u64; W] {
    let mut code = [0; W];
    for (to, from) in code.iter_mut().zip(words) {
        *to = *from;
    }
    code
}
