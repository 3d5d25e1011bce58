//! Deterministic monitors: finite automata that read states and mark some of their steps.
//!
//! A co-safe formula is satisfied when a step is marked, and then all later steps are marked. `G φ`
//! with co-safe φ is satisfied when infinitely many steps are marked. Steps carry the marks, so the
//! monitor of `F a` marks the step that reads a.

use ahash::AHashMap;

use super::functions::{FALSE, Function, TRUE};
use super::minimal;
use super::normal::Normal;
use super::progression::{OBLIGATIONS, Progress};
use meliora_model::error::{Limit, Result};
use meliora_model::expr::ExprId;

/// Maximum number of states of a monitor.
pub(crate) const MOST_STATES: usize = 1 << 12;

/// A decision on the atoms of the present state, by its position.
pub(crate) type DecisionId = usize;

/// Transition function of one state of a monitor, as a decision diagram over atoms.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Decision {
    /// Leads to a state, with or without a mark.
    Go { next: usize, mark: bool },
    /// Tests an atom.
    Test { atom: u32, no: DecisionId, yes: DecisionId },
}

/// Decisions, each stored once.
#[derive(Debug, Default)]
pub(crate) struct Decisions {
    pub(crate) all: Vec<Decision>,
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
pub(crate) struct Monitor {
    /// Decision of each state.
    pub(crate) states: Vec<DecisionId>,
    pub(crate) decisions: Decisions,
    /// Atoms that the decisions test.
    pub(crate) atoms: Vec<ExprId>,
}

impl Monitor {
    /// Builds the monitor of a co-safe formula: a mark means that the formula holds for every
    /// continuation.
    ///
    /// # Errors
    /// The monitor has too many states, or the formula too many obligations.
    pub(crate) fn of_cosafe(n: &Normal) -> Result<Self> {
        let mut build = Build::new();
        let start = build.progress.ask(n)?;
        build.run((start, TRUE), None)
    }

    /// Builds the monitor of `G φ` with co-safe φ: it marks a step that fulfils all obligations
    /// pending at the last mark.
    ///
    /// Obligations that arise in between become pending at the next mark: the breakpoint
    /// construction of J. Esparza, J. Kretinsky and S. Sickert, *A unified translation of linear
    /// temporal logic to omega-automata*, 2020.
    ///
    /// # Errors
    /// See [`Monitor::of_cosafe`].
    pub(crate) fn of_recurrence(n: &Normal) -> Result<Self> {
        let mut build = Build::new();
        let each = build.progress.ask(n)?;
        build.run((TRUE, TRUE), Some(each))
    }

    /// Returns true if both monitors are equal, state by state.
    pub(crate) fn is_same(&self, other: &Monitor) -> bool {
        self.states == other.states && self.decisions.all == other.decisions.all && self.atoms == other.atoms
    }

    /// Returns for each state whether all steps from it on are marked (`wanted`) or unmarked, whatever
    /// is read.
    pub(crate) fn settled(&self, wanted: bool) -> Vec<bool> {
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
    #[cfg(test)]
    pub(crate) fn step(&self, state: usize, holds: impl Fn(ExprId) -> bool) -> (usize, bool) {
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

/// The obligations pending at the last mark, and those that arose since then.
type Owed = (Function, Function);

/// A monitor under construction.
struct Build {
    progress: Progress,
    decisions: Decisions,
    known: AHashMap<Owed, usize>,
    open: Vec<Owed>,
    made: AHashMap<Owed, DecisionId>,
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

    /// Explores all states from the initial one; `each` is the obligation that arises in every
    /// state.
    fn run(mut self, start: Owed, each: Option<Function>) -> Result<Monitor> {
        self.state(start)?;
        let mut states = Vec::new();
        while let Some(&owed) = self.open.get(states.len()) {
            let read = self.read(owed, each)?;
            states.push(self.decide(read, each.is_some())?);
        }
        let Build { progress, decisions, .. } = self;
        Ok(minimal::minimal(&Monitor { states, decisions, atoms: progress.atoms }))
    }

    fn state(&mut self, owed: Owed) -> Result<usize> {
        if let Some(&known) = self.known.get(&owed) {
            return Ok(known);
        }
        if self.open.len() >= MOST_STATES {
            let what = format!("a temporal formula whose monitor has more than {MOST_STATES} states");
            return Err(Limit::Size { what }.into());
        }
        self.open.push(owed);
        self.known.insert(owed, self.open.len() - 1);
        Ok(self.open.len() - 1)
    }

    fn read(&mut self, (owed, since): Owed, each: Option<Function>) -> Result<Owed> {
        let Some(each) = each else { return Ok((self.progress.read(owed)?, TRUE)) };
        let new = self.progress.read(each)?;
        // When nothing was pending before this step, its new obligations become pending at once,
        // without a mark; the mark follows when they are fulfilled. If this step itself fulfils
        // them, it is marked.
        if owed == TRUE {
            return Ok((new, TRUE));
        }
        let (owed, since) = (self.progress.read(owed)?, self.progress.read(since)?);
        Ok((owed, self.progress.functions.and(since, new)?))
    }

    /// Returns the decision that leads to the remaining parts of `owed` and `since`.
    fn decide(&mut self, (owed, since): Owed, again: bool) -> Result<DecisionId> {
        if let Some(&made) = self.made.get(&(owed, since)) {
            return Ok(made);
        }
        let atom = self.progress.functions.top(owed).min(self.progress.functions.top(since));
        let made = if atom < OBLIGATIONS {
            let (no, yes) = self.progress.functions.halves(owed, atom);
            let (since_no, since_yes) = self.progress.functions.halves(since, atom);
            let no = self.decide((no, since_no), again)?;
            let yes = self.decide((yes, since_yes), again)?;
            self.decisions.add(Decision::Test { atom, no, yes })
        } else {
            let mark = owed == TRUE;
            let next = match (again, owed, since) {
                (true, TRUE, _) => (since, TRUE),
                (true, FALSE, _) | (true, _, FALSE) => (FALSE, TRUE),
                // Obligations implied by the pending ones are fulfilled together with them.
                (true, ..) if self.progress.functions.implies(owed, since)? => (owed, TRUE),
                _ => (owed, since),
            };
            let next = self.state(next)?;
            self.decisions.add(Decision::Go { next, mark })
        };
        self.made.insert((owed, since), made);
        Ok(made)
    }
}
