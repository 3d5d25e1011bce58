//! Deterministic monitors: finite automata that read states and mark some of their steps.
//!
//! A formula of the class Π2 is satisfied when infinitely many steps are marked; after the first mark
//! of a co-safe formula all steps are marked. Steps carry the marks, so the monitor of `F a` marks the
//! step that reads a.

use ahash::AHashMap;

use super::formulas::{FormulaId, Formulas};
use super::functions::{FALSE, Function, TRUE};
use super::minimal;
use super::progression::{OBLIGATIONS, Progress};
use meliora_base::error::{Limit, Result};
use meliora_model::expr::ExprId;

/// Maximum number of states of a monitor.
pub(crate) const MOST_STATES: usize = 1 << 12;

/// A decision on the atoms of the present state, by its position.
pub type DecisionId = usize;

/// Transition function of one state of a monitor, as a decision diagram over atoms.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Decision {
    /// Leads to a state, with or without a mark.
    Go {
        /// The next state.
        next: usize,
        /// True if the step is marked.
        mark: bool,
    },
    /// Tests an atom.
    Test {
        /// The position of the atom in [`Monitor::atoms`].
        atom: u32,
        /// The decision if the atom is false.
        no: DecisionId,
        /// The decision if the atom is true.
        yes: DecisionId,
    },
}

/// Decisions, each stored once.
#[derive(Debug, Default)]
pub struct Decisions {
    /// The decisions by position; each one follows those that it leads to.
    pub all: Vec<Decision>,
    known: AHashMap<Decision, DecisionId>,
}

impl Decisions {
    pub(crate) fn add(&mut self, decision: Decision) -> DecisionId {
        if let Decision::Test { no, yes, .. } = decision
            && no == yes
        {
            return no;
        }
        *self.known.entry(decision).or_insert_with(|| {
            self.all.push(decision);
            self.all.len() - 1
        })
    }
}

/// A deterministic monitor; its initial state is 0.
#[derive(Debug)]
pub struct Monitor {
    /// Decision of each state.
    pub states: Vec<DecisionId>,
    /// The decisions of all states.
    pub decisions: Decisions,
    /// Atoms that the decisions test.
    pub atoms: Vec<ExprId>,
}

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
    pub fn of(all: &Formulas, f: FormulaId) -> Result<Self> {
        debug_assert!(all.is_pi2(f));
        let mut build = Build::new();
        let left = build.progress.ask(all, f)?;
        let owed = build.progress.owed(left)?;
        build.run(State { left, owed })
    }

    /// Returns true if both monitors are equal, state by state.
    pub fn is_same(&self, other: &Monitor) -> bool {
        self.states == other.states && self.decisions.all == other.decisions.all && self.atoms == other.atoms
    }

    /// Returns for each state whether all steps from it on are marked (`wanted`) or unmarked, whatever
    /// is read.
    pub fn settled(&self, wanted: bool) -> Vec<bool> {
        let mut settled = vec![true; self.states.len()];
        loop {
            // Decisions come after those that they lead to.
            let mut fine: Vec<bool> = Vec::with_capacity(self.decisions.all.len());
            for decision in &self.decisions.all {
                fine.push(match *decision {
                    Decision::Go { next, mark } => mark == wanted && settled[next],
                    Decision::Test { no, yes, .. } => fine[no] && fine[yes],
                });
            }
            let left: Vec<bool> = self.states.iter().map(|&decision| fine[decision]).collect();
            if left == settled {
                return settled;
            }
            settled = left;
        }
    }

    /// Returns the successor of a state, and whether the step is marked.
    pub fn step(&self, state: usize, holds: impl Fn(ExprId) -> bool) -> (usize, bool) {
        let mut at = self.states[state];
        loop {
            match self.decisions.all[at] {
                Decision::Go { next, mark } => return (next, mark),
                Decision::Test { atom, no, yes } => {
                    at = if holds(self.atoms[atom as usize]) { yes } else { no }
                }
            }
        }
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
        Ok(minimal::minimal(&Monitor { states, decisions, atoms: progress.atoms }))
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
