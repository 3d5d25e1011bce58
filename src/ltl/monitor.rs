//! Deterministic monitors: finite automata that read states and mark some of their steps.
//!
//! A formula of the class Π2 is satisfied when infinitely many steps are marked; after the first mark
//! of a co-safe formula all steps are marked. Steps carry the marks, so the monitor of `F a` marks the
//! step that reads a.

use ahash::AHashMap;

use meliora_model::expr::ExprId;

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
