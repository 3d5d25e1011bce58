//! Several monitors that read the same word: their joint states, and what some continuation makes of
//! all marks together.

use std::collections::BTreeSet;

use ahash::AHashMap;

use super::breakpoints::MOST_STATES;
use super::functions::MOST_NODES;
use super::monitor::{Decision, DecisionId, Monitor};
use meliora_model::expr::ExprId;

/// Joint states of monitors; the initial one is 0.
#[derive(Debug)]
pub struct Joint {
    /// The state of each monitor.
    pub states: Vec<Vec<usize>>,
    /// The steps from each state: where they lead, and whether each monitor marks them.
    steps: Vec<BTreeSet<(usize, Vec<bool>)>>,
}

impl Joint {
    /// Explores the joint states; `None` if there are more than `MOST_STATES` of them, or more than
    /// `MOST_NODES` letters to read.
    pub fn explore(monitors: &[&Monitor]) -> Option<Self> {
        let start = vec![0; monitors.len()];
        let mut known = AHashMap::from([(start.clone(), 0)]);
        let mut joint = Joint { states: vec![start], steps: Vec::new() };
        let mut read = Reading { monitors, atoms: AHashMap::new(), ends: BTreeSet::new(), left: MOST_NODES };
        while let Some(state) = joint.states.get(joint.steps.len()) {
            let at = state.iter().zip(monitors).map(|(&state, monitor)| monitor.states[state]).collect();
            read.letters(at)?;
            let mut steps = BTreeSet::new();
            for (next, marks) in std::mem::take(&mut read.ends) {
                let new = joint.states.len();
                let to = *known.entry(next.clone()).or_insert(new);
                if to == new {
                    joint.states.push(next);
                }
                steps.insert((to, marks));
            }
            joint.steps.push(steps);
            if joint.states.len() > MOST_STATES {
                return None;
            }
        }
        Some(joint)
    }

    /// Returns for each state whether after some word each monitor in `again` marks infinitely many steps, and
    /// each in `off` finitely many.
    ///
    /// νZ. { s : for each i in `again`, a path in Z without marks of `off` leads to a mark of i and into Z }, and
    /// the states that reach it.
    pub fn may(&self, again: &[usize], off: &[usize]) -> Vec<bool> {
        let goes_on = |marks: &[bool]| !off.iter().any(|&i| marks[i]);
        let mut within = vec![true; self.states.len()];
        loop {
            let mut left = self.step_into(|_, (to, marks)| goes_on(marks) && within[*to]);
            for &i in again {
                let marked = self.step_into(|_, (to, marks)| goes_on(marks) && marks[i] && within[*to]);
                let reached =
                    self.reaching(marked, |s, (to, marks)| goes_on(marks) && within[s] && within[*to]);
                left.iter_mut().zip(reached).for_each(|(left, reached)| *left &= reached);
            }
            left.iter_mut().zip(&within).for_each(|(left, within)| *left &= within);
            if left == within {
                return self.reaching(within, |_, _| true);
            }
            within = left;
        }
    }

    /// Returns for each state whether it has a step that fits.
    fn step_into(&self, fits: impl Fn(usize, &(usize, Vec<bool>)) -> bool) -> Vec<bool> {
        self.steps.iter().enumerate().map(|(s, steps)| steps.iter().any(|step| fits(s, step))).collect()
    }

    /// Returns the states that reach some states by steps that fit.
    fn reaching(&self, mut found: Vec<bool>, fits: impl Fn(usize, &(usize, Vec<bool>)) -> bool) -> Vec<bool> {
        let mut before = vec![Vec::new(); self.states.len()];
        for (from, steps) in self.steps.iter().enumerate() {
            steps.iter().filter(|step| fits(from, step)).for_each(|(to, _)| before[*to].push(from));
        }
        let mut open: Vec<usize> = (0..found.len()).filter(|&s| found[s]).collect();
        while let Some(to) = open.pop() {
            for &from in &before[to] {
                if !std::mem::replace(&mut found[from], true) {
                    open.push(from);
                }
            }
        }
        found
    }
}

/// The letters that all monitors read in one state.
struct Reading<'m> {
    monitors: &'m [&'m Monitor],
    /// The values of the atoms that were read.
    atoms: AHashMap<ExprId, bool>,
    /// The joint states after the letters, and the marks of their steps.
    ends: BTreeSet<(Vec<usize>, Vec<bool>)>,
    /// The number of letters that may still be read.
    left: usize,
}

impl Reading<'_> {
    /// Follows the decisions of all monitors for all letters; `None` if these are too many. The recursion depth is
    /// at most the number of atoms.
    fn letters(&mut self, mut at: Vec<DecisionId>) -> Option<()> {
        for place in 0..at.len() {
            let monitor = self.monitors[place];
            while let Decision::Test { atom, no, yes } = monitor.decisions.all[at[place]] {
                let atom = monitor.atoms[atom as usize];
                if let Some(&value) = self.atoms.get(&atom) {
                    at[place] = if value { yes } else { no };
                    continue;
                }
                for (value, next) in [(false, no), (true, yes)] {
                    self.atoms.insert(atom, value);
                    let mut then = at.clone();
                    then[place] = next;
                    self.letters(then)?;
                }
                self.atoms.remove(&atom);
                return Some(());
            }
        }
        self.left = self.left.checked_sub(1)?;
        let ends = at.iter().zip(self.monitors).map(|(&at, monitor)| match monitor.decisions.all[at] {
            Decision::Go { next, mark } => (next, mark),
            Decision::Test { .. } => (0, false),
        });
        self.ends.insert(ends.unzip());
        Some(())
    }
}
