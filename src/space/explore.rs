//! Breadth-first exploration of the states of a program and their choices.

use std::sync::Arc;

use num_bigint::BigUint;

use super::batch::Batch;
use super::enabled::Enabled;
use super::graph::Graph;
use super::index::{Index, NOBODY};
use super::initial::Search;
use super::layout::{Layout, by_words, width};
use super::lists::Collected;
use super::meter::{Array, Meter};
use super::players::PlayersFound;
use super::probabilities::{Probabilities, Weighed, Weighing};
use super::program::{Chances, Prepared};
use super::set::{self, BitSet};
pub use super::states::{Space, fixed};
use super::stepper::{Broken, Stepper, sum};
use crate::{Limits, STEPS_PER_WORK, Scope};
use meliora_base::error::{Error, Limit, Result};
use meliora_model::players::Unlisted;
use meliora_model::temporal::Begin;
use meliora_model::{Program, State, fault};

/// Number of states explored or taken from a work list, or of operations of the search for initial states, between
/// two checks of the progress sink.
pub const PATIENCE: usize = 1 << 12;
/// Minimum number of bytes per state: its entries in the sparse rows.
const LEAST_BYTES: u64 = 12;
/// Guards that are looked at in about the time of a state or a successor.
const LOOKS: u64 = 16;

/// The states of a scope with their choices and successors.
pub struct Explored {
    /// The states by number.
    pub space: Space,
    /// Their choices and successors.
    pub graph: Graph,
    /// The initial states.
    pub initial: BitSet,
    /// The states without a choice of the program; each has a loop.
    pub deadlocks: BitSet,
    /// The number of states of a `dtmc` whose choice draws from several.
    pub drawing: u64,
    /// The first state in which probabilities sum to 1 only after rounding.
    pub rounded: Option<State>,
    /// For a game, the player of each state; [`NOBODY`] for deadlocks.
    pub players: Option<Array<u32>>,
    /// The choices of the states by their commands, if they are kept.
    pub choices: Option<Enabled>,
    /// The probabilities of the choices, if they are kept. The successors of a choice are in the order of their values then.
    pub probabilities: Option<Probabilities>,
}

/// An exploration.
pub struct Exploration {
    /// The input.
    pub task: Task,
    found: Frontier,
}

/// The input of an exploration.
pub struct Task {
    /// The program.
    pub program: Arc<Program>,
    /// The extent and the limits.
    pub limits: Limits,
    /// The layout of the codes.
    pub layout: Layout,
    /// The compiled program.
    pub prepared: Arc<Prepared>,
    /// The meter of all arrays.
    pub meter: Meter,
}

/// Chooses the layout of the codes of the states.
///
/// # Errors
/// The valuations are too many for the memory limit, or the variables for a code.
fn layout(program: &Program, limits: &Limits) -> Result<Layout> {
    let begin = program.monitors.as_ref().map(|o| o.begin);
    if limits.scope == Scope::Reachable || begin == Some(Begin::Initially) {
        return Layout::packed(program);
    }
    let layout = Layout::radix(program);
    match layout.filter(|l| l.valuations().is_some_and(|n| n <= limits.memory / LEAST_BYTES)) {
        Some(layout) => Ok(layout),
        None => {
            let sizes = program.variables.iter().map(|v| BigUint::from(width(v)) + 1u32);
            let states: BigUint = sizes.product();
            let what = format!(
                "the scope `all` has {states} states, too many for the {} bytes of the explicit engine",
                limits.memory
            );
            Err(Limit::Memory { what }.into())
        }
    }
}

impl Exploration {
    /// Prepares an exploration of the scope.
    ///
    /// # Errors
    /// The states do not fit the memory or a code, or the work is cancelled.
    pub fn new(program: Arc<Program>, limits: Limits) -> Result<Self> {
        let layout = layout(&program, &limits)?;
        let prepared = Arc::new(Prepared::new(&program, &layout, &*limits.sink)?);
        let meter = Meter::new(limits.memory);
        let task = Task { program, limits, layout, prepared, meter };
        let found = task.start()?;
        Ok(Exploration { task, found })
    }

    /// Finds all initial states.
    ///
    /// # Errors
    /// A limit of the engine is reached, or a command has no meaning in some state.
    pub fn begin(&mut self) -> Result<()> {
        let Exploration { task, found } = self;
        by_words!(task.words(), W => task.begin::<W>(found))
    }

    /// Returns the codes of the initial states, once they are found.
    pub fn beginnings(&self) -> impl Iterator<Item = &[u64]> {
        let index = match &self.found.space {
            Space::Indexed(index) => Some(index),
            Space::Every(_) => None,
        };
        index.into_iter().flat_map(|index| (0..self.found.started).map(|state| index.code(state)))
    }

    /// Explores all states, and returns the work.
    #[cfg(test)]
    pub fn all_work(mut self) -> Result<u64> {
        self.begin()?;
        let Exploration { task, mut found } = self;
        by_words!(task.words(), W => task.explore::<W>(&mut found))?;
        Ok(found.work)
    }

    /// Explores all states, and returns them with their choices and successors.
    ///
    /// # Errors
    /// The errors of [`Exploration::begin`].
    pub fn finish(mut self) -> Result<(Task, Explored)> {
        self.begin()?;
        let Exploration { task, mut found } = self;
        by_words!(task.words(), W => task.explore::<W>(&mut found))?;
        let explored = task.finish(found);
        Ok((task, explored))
    }
}

impl Task {
    fn words(&self) -> usize {
        self.layout.words()
    }

    fn explore<const W: usize>(&self, found: &mut Frontier) -> Result<()> {
        let (mut stepper, mut weighing) = (Stepper::new(&self.prepared), Weighing::new(self));
        let (mut batch, mut due) = (Batch::new(), 0);
        // A state takes longer if more guards are evaluated, so the interval depends on the
        // commands.
        let interval = (PATIENCE / self.program.commands.len().max(1)).max(1);
        while found.next < found.space.states() {
            // A state with many successors takes as long as many states.
            if found.next >= due || stepper.steps.len() >= PATIENCE {
                due = found.next + interval;
                self.report(found)?;
            }
            if found.has_steps_only() {
                self.explore_batch(found, &mut stepper, &mut batch)?;
                continue;
            }
            let code = found.space.code::<W>(found.next);
            self.look(found, &mut stepper, &code)?;
            batch.add(&stepper, &code);
            let successors = batch.look_up(&mut found.space)?;
            found.add(&stepper, &code, successors, &mut weighing)?;
            batch.clear();
        }
        self.report(found)
    }

    /// Explores the next states.
    fn explore_batch<const W: usize>(
        &self,
        found: &mut Frontier,
        stepper: &mut Stepper<'_, W>,
        batch: &mut Batch<W>,
    ) -> Result<()> {
        while found.next < found.space.states() && !batch.is_full() {
            let code = found.space.code::<W>(found.next);
            self.look(found, stepper, &code)?;
            batch.add(stepper, &code);
            found.end(stepper);
        }
        batch.finish(&mut found.space, &mut found.graph)
    }

    fn start(&self) -> Result<Frontier> {
        let (space, search) = match self.layout.valuations() {
            Some(n) => (Space::Every(n as usize), None),
            None => {
                let index = Index::new(self.layout.words(), &self.meter);
                (Space::Indexed(Box::new(index)), Some(self.search()?))
            }
        };
        let begin = self.program.monitors.as_ref().map(|o| o.begin);
        Ok(Frontier {
            restarts: begin == Some(Begin::Everywhere) && search.is_some(),
            search,
            started: space.states(),
            next: 0,
            work: 0,
            reported: 0,
            space,
            graph: Graph::new(&self.meter)?,
            initial: Vec::new(),
            deadlocks: Vec::new(),
            drawing: 0,
            rounded: None,
            players: self.players(),
            choices: self.limits.keeps_choices.then(|| Collected::new(&self.meter, &[])),
            probabilities: self.keeps_probabilities().then(|| Box::new(Weighed::new(&self.meter))),
        })
    }

    /// Returns whether probabilities are kept if they are wanted. States of the scope `all` have no codes of their own.
    /// Probabilities that depend on the state take longer than the exploration: they are computed where they are needed.
    fn keeps_probabilities(&self) -> bool {
        let varies = self.prepared.commands.iter().any(|command| command.chances == Chances::Vary);
        self.limits.keeps_probabilities && self.layout.valuations().is_none() && !varies
    }

    /// Returns the players of a game.
    fn players(&self) -> Option<PlayersFound> {
        self.program.players.as_ref()?;
        let player = |s| self.program.player_of(s).map_or(NOBODY, |player| player as u32);
        let players = self.program.synchronisations.iter().map(player).collect();
        let is_alone = |s| self.program.unlisted(s) == Some(Unlisted::Alone);
        let alone = self.program.synchronisations.iter().map(is_alone).collect();
        Some(PlayersFound::new(players, alone, Array::new(&self.meter)))
    }

    /// Computes the steps from the next state and tests whether it is an initial state.
    #[inline]
    fn look<const W: usize>(
        &self,
        found: &mut Frontier,
        stepper: &mut Stepper<'_, W>,
        code: &[u64; W],
    ) -> Result<()> {
        stepper.enter(&self.layout, code);
        let tests = self.limits.scope == Scope::All && found.next < found.started;
        if tests || self.prepared.initial_is_partial {
            let holds = stepper.is_initial().map_err(|_| self.fault(code))?;
            if holds && tests {
                found.initial.push(found.next);
            }
        }
        stepper.expand().map_err(|broken| self.broken(broken, code))?;
        if let Some(players) = &mut found.players
            && !players.add(&stepper.active, stepper.ends.len())?
        {
            return Err(fault::of_two_players(&self.program, &self.values(code))?);
        }
        if let Some(choices) = &mut found.choices {
            stepper.key_into(&mut choices.key);
            if !choices.add()? {
                found.choices = None;
            }
        }
        if stepper.rounded {
            found.rounded.get_or_insert_with(|| self.values(code));
        }
        Ok(())
    }

    fn finish(&self, found: Frontier) -> Explored {
        let Frontier {
            mut space,
            mut graph,
            mut initial,
            deadlocks,
            drawing,
            rounded,
            started,
            players,
            choices,
            probabilities,
            ..
        } = found;
        if let Space::Indexed(index) = &mut space {
            index.shrink();
            if self.limits.scope == Scope::Reachable {
                initial.extend(0..started);
            }
        }
        graph.shrink();
        let bits = |states: Vec<usize>| {
            let mut bits = BitSet::empty(&self.meter, space.states());
            states.into_iter().for_each(|s| set::set(bits.words_mut(), s));
            bits
        };
        let (initial, deadlocks) = (bits(initial), bits(deadlocks));
        let players = players.map(|players| players.of_state);
        let choices = choices.map(|choices| Enabled(choices.finish()));
        let probabilities = probabilities.map(|weighed| weighed.finish());
        Explored { initial, deadlocks, drawing, rounded, space, graph, players, choices, probabilities }
    }

    /// Creates the search for the initial states. Its work is not done yet.
    fn search(&self) -> Result<Box<Beginning>> {
        let condition = match (self.limits.scope, &self.program.monitors) {
            (Scope::All, Some(monitors)) => monitors.fresh,
            _ => self.program.initial,
        };
        let search = Search::new(&self.program, condition, &*self.limits.sink)?;
        Ok(Box::new(Beginning { search, codes: Array::new(&self.meter) }))
    }

    /// Searches for the initial states.
    fn begin<const W: usize>(&self, found: &mut Frontier) -> Result<()> {
        let Some(mut beginning) = found.search.take() else { return Ok(()) };
        let Beginning { search, codes } = &mut *beginning;
        search.run(u64::MAX, &*self.limits.sink, &mut |state| {
            let code = self.layout.encode(state);
            code.map_or(Ok(()), |code| codes.extend(&fixed::<W>(&code)))
        })?;
        let all = || codes.chunks_exact(W).map(fixed::<W>);
        if all().is_sorted() {
            found.start(all())?;
        } else {
            let _copied = self.meter.charge(codes.len() * size_of::<u64>())?;
            let mut all: Vec<[u64; W]> = all().collect();
            // Codes compare as the values do.
            all.sort_unstable();
            found.start(all.into_iter())?;
        }
        Ok(())
    }

    fn report(&self, found: &mut Frontier) -> Result<()> {
        let explored = found.next;
        // In the scope `all` every valuation is a state, so the explored states are reported.
        let reached = if matches!(found.space, Space::Every(_)) { explored } else { found.space.states() };
        self.meter.reached(reached);
        let detail = || format!("{explored} states explored, {reached} reached");
        self.limits.sink.progress("reachable states", &detail);
        let work = found.work - std::mem::replace(&mut found.reported, found.work);
        self.limits.sink.advance(work * STEPS_PER_WORK);
        match self.limits.sink.stop() {
            Some(limit) => Err(limit.into()),
            None => Ok(()),
        }
    }

    /// Returns the error of a state whose choices cannot be listed.
    pub fn broken(&self, broken: Broken, code: &[u64]) -> Error {
        broken.error(&self.program, &self.values(code))
    }

    /// Returns the error of a state in which a command has no meaning.
    pub fn fault(&self, code: &[u64]) -> Error {
        fault::in_state(&self.program, &self.values(code))
    }

    /// Returns the values of a code.
    pub fn values(&self, code: &[u64]) -> State {
        let mut values = vec![0; self.program.variables.len()];
        self.layout.decode(code, &mut values);
        values
    }
}

/// The search for the initial states.
struct Beginning {
    search: Search,
    /// The codes of the states found.
    codes: Array<u64>,
}

/// The states found so far, and the next one to explore.
struct Frontier {
    /// The search for the initial states, until all are found.
    search: Option<Box<Beginning>>,
    space: Space,
    /// Number of states before the first step.
    started: usize,
    /// The next state.
    next: usize,
    /// The number of states explored and of their successors, and a share of the guards that this took.
    work: u64,
    /// The work at the last report.
    reported: u64,
    /// True if monitors may begin in every reached state.
    restarts: bool,
    graph: Graph,
    initial: Vec<usize>,
    deadlocks: Vec<usize>,
    drawing: u64,
    rounded: Option<State>,
    players: Option<PlayersFound>,
    /// The choices of the states so far, if they are kept.
    choices: Option<Collected>,
    /// Their probabilities, if they are kept.
    probabilities: Option<Box<Weighed>>,
}

impl Frontier {
    /// Begins with the states of these codes.
    fn start<const W: usize>(&mut self, codes: impl Iterator<Item = [u64; W]>) -> Result<()> {
        for code in codes {
            self.space.number(&code)?;
        }
        self.started = self.space.states();
        Ok(())
    }

    /// Adds the steps from the next state to the graph, given its code, and the numbers of its successors with the end of
    /// each choice among them. A deadlock stays.
    #[inline]
    fn add<const W: usize>(
        &mut self,
        stepper: &Stepper<'_, W>,
        code: &[u64; W],
        (successors, ends): (&[u32], &[u32]),
        weighing: &mut Weighing<'_, W>,
    ) -> Result<()> {
        let weighs = |into| weighing.weigh(stepper, code, into);
        let is_weighed = self.probabilities.as_deref_mut().is_some_and(weighs);
        match self.probabilities.take().filter(|_| is_weighed) {
            Some(mut into) if !stepper.ends.is_empty() => {
                let is_kept = weighing.add(stepper, (code, successors), &mut self.graph, &mut into)?;
                self.probabilities = is_kept.then_some(into);
            }
            // No probabilities are kept, or the one choice is that of a deadlock.
            own => {
                self.add_choices(successors, ends)?;
                self.probabilities = own;
                self.probabilities.iter_mut().try_for_each(|own| own.certain())?;
            }
        }
        self.graph.end_state()?;
        if self.restarts {
            self.space.number(&sum(code, &stepper.restart()))?;
        }
        self.end(stepper);
        Ok(())
    }

    /// Returns whether states have no other successors and nothing else is kept of them: then several are added at once.
    #[inline]
    fn has_steps_only(&self) -> bool {
        !self.restarts && self.probabilities.is_none()
    }

    /// Counts the next state, and moves to the one after it.
    #[inline]
    fn end<const W: usize>(&mut self, stepper: &Stepper<'_, W>) {
        if stepper.ends.is_empty() || stepper.steps_alone() {
            self.deadlocks.push(self.next);
        }
        self.drawing += u64::from(stepper.draws);
        self.next += 1;
        self.work += 1 + stepper.steps.len() as u64 + stepper.guards as u64 / LOOKS;
    }

    /// Adds choices, given their successors, and the end of each choice among these.
    fn add_choices(&mut self, successors: &[u32], ends: &[u32]) -> Result<()> {
        let mut at = 0;
        for &end in ends {
            self.graph.extend(&successors[at..end as usize])?;
            self.graph.end_choice()?;
            at = end as usize;
        }
        Ok(())
    }
}
