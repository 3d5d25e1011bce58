//! Minimisation of monitors.
//!
//! The states from which every path has infinitely many marks become one state, and those from
//! which no path has become another. Then states that have the same marks for all words are merged.

use ahash::AHashMap;

use super::monitor::{Decision, DecisionId, Decisions, Monitor};

/// Steps of a monitor: for each state its successors, each with a flag for a marked step.
type Steps = Vec<Vec<(usize, bool)>>;

/// Returns the same monitor with equivalent states merged; the states left are numbered from the
/// first.
pub(crate) fn minimal(monitor: &Monitor) -> Monitor {
    let settled = Settled::new(monitor);
    let (never, surely) = (monitor.states.len(), monitor.states.len() + 1);
    let redirect = |next: usize, mark: bool| match () {
        () if settled.never[next] => Decision::Go { next: never, mark: false },
        () if settled.surely[next] => Decision::Go { next: surely, mark: true },
        () => Decision::Go { next, mark },
    };
    let mut decisions = Decisions::default();
    let mut states = rebuilt(monitor, &mut decisions, redirect);
    states.push(decisions.add(Decision::Go { next: never, mark: false }));
    states.push(decisions.add(Decision::Go { next: surely, mark: true }));
    let start = match () {
        () if settled.never[0] => never,
        () if settled.surely[0] => surely,
        () => 0,
    };
    merged(Monitor { states, decisions, atoms: monitor.atoms.clone() }, start)
}

/// Copies the decisions of all states, with other ends.
fn rebuilt(
    monitor: &Monitor,
    into: &mut Decisions,
    end: impl Fn(usize, bool) -> Decision,
) -> Vec<DecisionId> {
    // A decision comes after the decisions it leads to.
    let mut made = Vec::with_capacity(monitor.decisions.all.len());
    for &decision in &monitor.decisions.all {
        let new = match decision {
            Decision::Go { next, mark } => end(next, mark),
            Decision::Test { atom, no, yes } => Decision::Test { atom, no: made[no], yes: made[yes] },
        };
        made.push(into.add(new));
    }
    monitor.states.iter().map(|&s| made[s]).collect()
}

fn steps(monitor: &Monitor) -> Steps {
    let mut ends: Vec<Vec<(usize, bool)>> = Vec::with_capacity(monitor.decisions.all.len());
    for decision in &monitor.decisions.all {
        let mut own = match *decision {
            Decision::Go { next, mark } => vec![(next, mark)],
            Decision::Test { no, yes, .. } => [ends[no].as_slice(), ends[yes].as_slice()].concat(),
        };
        own.sort_unstable();
        own.dedup();
        ends.push(own);
    }
    monitor.states.iter().map(|&s| ends[s].clone()).collect()
}

/// States for which the future input no longer matters.
pub struct Settled {
    /// True if no path from the state is marked infinitely often.
    pub never: Vec<bool>,
    /// True if every path from the state is marked infinitely often.
    pub surely: Vec<bool>,
}

impl Settled {
    /// Returns the states of a monitor that are settled.
    pub fn new(monitor: &Monitor) -> Self {
        let steps = &steps(monitor);
        // νY. μX. pre(X) ∪ { s : a marked step into Y }.
        let mut again = vec![true; steps.len()];
        loop {
            let found = least(steps, |x, (to, mark)| x[to] || (mark && again[to]), &vec![false; steps.len()]);
            if found == again {
                break;
            }
            again = found;
        }
        // νZ. { s : an unmarked step into Z }, and then the states that can reach it.
        let mut unmarked = vec![true; steps.len()];
        loop {
            let stays = |own: &Vec<(usize, bool)>| own.iter().any(|&(to, mark)| !mark && unmarked[to]);
            let left: Vec<bool> = steps.iter().map(stays).collect();
            if left == unmarked {
                break;
            }
            unmarked = left;
        }
        let in_vain = least(steps, |x, (to, _)| x[to], &unmarked);
        Settled { never: again.iter().map(|a| !a).collect(), surely: in_vain.iter().map(|v| !v).collect() }
    }
}

/// Computes μX. start ∪ { s : some step of s satisfies `fits` for X }.
fn least(steps: &Steps, fits: impl Fn(&[bool], (usize, bool)) -> bool, start: &[bool]) -> Vec<bool> {
    let mut x = start.to_vec();
    loop {
        let mut grew = false;
        for (state, own) in steps.iter().enumerate().rev() {
            if !x[state] && own.iter().any(|&step| fits(&x, step)) {
                x[state] = true;
                grew = true;
            }
        }
        if !grew {
            return x;
        }
    }
}

/// Merges states by partition refinement, and numbers the classes reachable from `start`.
fn merged(monitor: Monitor, start: usize) -> Monitor {
    let mut class = vec![0; monitor.states.len()];
    let mut count = 1;
    loop {
        let mut decisions = Decisions::default();
        let seen = rebuilt(&monitor, &mut decisions, |next, mark| Decision::Go { next: class[next], mark });
        let mut numbers: AHashMap<(usize, DecisionId), usize> = AHashMap::new();
        for (state, decision) in seen.into_iter().enumerate() {
            let next = numbers.len();
            class[state] = *numbers.entry((class[state], decision)).or_insert(next);
        }
        if numbers.len() == count {
            break;
        }
        count = numbers.len();
    }
    numbered(&monitor, &class, start)
}

/// Returns the monitor of the reachable classes, numbered in the order of a breadth-first search.
fn numbered(monitor: &Monitor, class: &[usize], start: usize) -> Monitor {
    let steps = steps(monitor);
    let (mut number, mut met) = (AHashMap::new(), vec![start]);
    number.insert(class[start], 0);
    let mut at = 0;
    while let Some(&state) = met.get(at) {
        for &(to, _) in &steps[state] {
            let fresh = number.len();
            number.entry(class[to]).or_insert_with(|| {
                met.push(to);
                fresh
            });
        }
        at += 1;
    }
    let mut all = Decisions::default();
    // Ends that are not reached may have any number: no remaining decision leads to them.
    let states = rebuilt(monitor, &mut all, |next, mark| Decision::Go {
        next: number.get(&class[next]).copied().unwrap_or(0),
        mark,
    });
    let states: Vec<DecisionId> = met.iter().map(|&s| states[s]).collect();
    used(&Monitor { states, decisions: all, atoms: monitor.atoms.clone() })
}

/// Removes the decisions and atoms that no state needs.
fn used(monitor: &Monitor) -> Monitor {
    let mut needed = vec![false; monitor.decisions.all.len()];
    monitor.states.iter().for_each(|&s| needed[s] = true);
    let mut tested = vec![false; monitor.atoms.len()];
    for at in (0..needed.len()).rev() {
        if let (true, Decision::Test { atom, no, yes }) = (needed[at], monitor.decisions.all[at]) {
            (needed[no], needed[yes], tested[atom as usize]) = (true, true, true);
        }
    }
    let places: Vec<u32> = tested
        .iter()
        .scan(0, |next, &is| {
            let place = *next;
            *next += u32::from(is);
            Some(place)
        })
        .collect();
    let (mut decisions, mut made) = (Decisions::default(), vec![0; needed.len()]);
    for (at, &decision) in monitor.decisions.all.iter().enumerate().filter(|(at, _)| needed[*at]) {
        made[at] = decisions.add(match decision {
            Decision::Test { atom, no, yes } => {
                Decision::Test { atom: places[atom as usize], no: made[no], yes: made[yes] }
            }
            go => go,
        });
    }
    let atoms = monitor.atoms.iter().zip(&tested).filter(|(_, is)| **is).map(|(a, _)| *a).collect();
    Monitor { states: monitor.states.iter().map(|&s| made[s]).collect(), decisions, atoms }
}
