//! The breakpoint construction of monitors.

use ahash::AHashMap;

use super::formulas::{FormulaId, Formulas};
use super::functions::{FALSE, Function, TRUE};
use super::minimal::minimal;
use super::monitor::{Decision, DecisionId, Decisions, Monitor};
use super::progression::{OBLIGATIONS, Progress};
use meliora_base::error::{Limit, Result};

/// Maximum number of states of a monitor.
pub(crate) const MOST_STATES: usize = 1 << 12;

impl Monitor {
    /// Builds the monitor of a formula of the class Π2: it marks a step that fulfils all that was owed
    /// at the last mark.
    ///
    /// Debts that arise in between become due at the next mark: the breakpoint construction of
    /// J. Esparza, J. Kretinsky and S. Sickert, *A unified translation of linear temporal logic to
    /// omega-automata*, 2020. A co-safe formula owes itself, so a mark means that it holds for every
    /// continuation.
    ///
    /// # Errors
    /// The monitor has too many states, or the formula too many obligations.
    pub fn owing(all: &Formulas, f: FormulaId) -> Result<Self> {
        debug_assert!(all.is_pi2(f));
        let mut build = Build::new();
        let left = build.progress.ask(all, f)?;
        let owed = build.progress.owed(left)?;
        build.run(State { left, owed })
    }
}

/// A state of a monitor under construction.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct State {
    /// The formula for the rest of the path.
    left: Function,
    /// The part of it that is owed since the last mark.
    owed: Function,
}

/// A monitor under construction.
struct Build {
    progress: Progress,
    decisions: Decisions,
    known: AHashMap<State, usize>,
    open: Vec<State>,
    made: AHashMap<State, DecisionId>,
}

impl Build {
    fn new() -> Self {
        Build {
            progress: Progress::new(),
            decisions: Decisions::default(),
            known: AHashMap::new(),
            open: Vec::new(),
            made: AHashMap::new(),
        }
    }

    /// Explores all states from the initial one.
    fn run(mut self, start: State) -> Result<Monitor> {
        self.state(start)?;
        let mut states = Vec::new();
        while let Some(&state) = self.open.get(states.len()) {
            let read = self.read(state)?;
            states.push(self.decide(read)?);
        }
        let Build { progress, decisions, .. } = self;
        Ok(minimal(&Monitor { states, decisions, atoms: progress.atoms }))
    }

    fn state(&mut self, state: State) -> Result<usize> {
        if let Some(&known) = self.known.get(&state) {
            return Ok(known);
        }
        if self.open.len() >= MOST_STATES {
            let what = format!("a monitor of more than {MOST_STATES} states");
            return Err(Limit::Size { what }.into());
        }
        self.open.push(state);
        self.known.insert(state, self.open.len() - 1);
        Ok(self.open.len() - 1)
    }

    fn read(&mut self, State { left, owed }: State) -> Result<State> {
        let left = self.progress.read(left)?;
        // When nothing was owed before this step, its new debts become due at once, without a mark;
        // the mark follows when they are paid. If this step itself pays them, it is marked.
        let owed = if owed == TRUE { self.progress.owed(left)? } else { self.progress.read(owed)? };
        Ok(State { left, owed })
    }

    /// Returns the decision that leads to what remains after the atoms of the present state.
    fn decide(&mut self, read: State) -> Result<DecisionId> {
        if let Some(&made) = self.made.get(&read) {
            return Ok(made);
        }
        let State { left, owed } = read;
        let atom = self.progress.functions.top(left).min(self.progress.functions.top(owed));
        let made = if atom < OBLIGATIONS {
            let (left_no, left_yes) = self.progress.functions.halves(left, atom);
            let (owed_no, owed_yes) = self.progress.functions.halves(owed, atom);
            let no = self.decide(State { left: left_no, owed: owed_no })?;
            let yes = self.decide(State { left: left_yes, owed: owed_yes })?;
            self.decisions.add(Decision::Test { atom, no, yes })
        } else {
            let mark = owed == TRUE;
            let owed = match mark {
                true => self.progress.owed(left)?,
                false if left == FALSE => FALSE,
                false => owed,
            };
            let next = self.state(State { left, owed })?;
            self.decisions.add(Decision::Go { next, mark })
        };
        self.made.insert(read, made);
        Ok(made)
    }
}
