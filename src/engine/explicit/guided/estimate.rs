//! Estimates of the distance to the target, by plans of the relaxation (the heuristic h_FF: Hoffmann and Nebel, "The
//! FF planning system", JAIR 2001, with the cheapest supporters of h_add).

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::facts::Fact;
use super::relaxation::Relaxation;
use meliora_space::index::NOBODY;

/// An estimate of the distance of a state to the target.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub(super) struct Estimate {
    /// The steps of a relaxed plan.
    pub(super) steps: u32,
    /// The conditions of the target that are false in the state.
    pub(super) goals: u32,
}

/// A cost that no fact has.
const NEVER: u32 = u32::MAX;

/// Computes estimates.
pub(super) struct Estimator {
    /// For each fact the cost to reach it, and the rule by which.
    cost: Vec<(u32, u32)>,
    /// For each rule the number of its conditions that are open, and the sum of the costs of the others.
    rules: Vec<(u32, u32)>,
    /// The values for a new state.
    fresh: Vec<(u32, u32)>,
    open: BinaryHeap<Reverse<u64>>,
    /// For each rule and for each command, the number of the last estimate whose plan contains it.
    used: Vec<u64>,
    first: Vec<u64>,
    now: u64,
    /// The commands whose conditions are true in the state of the last estimate; some may occur twice.
    pub(super) enabled: Vec<u32>,
    /// The work of all estimates: the facts that were reached, each with the rules that need it.
    pub(super) work: u64,
}

impl Estimator {
    pub(super) fn new(relaxation: &Relaxation, commands: usize) -> Self {
        let fresh: Vec<(u32, u32)> = relaxation.conditions.iter().map(|&count| (count, 0)).collect();
        Estimator {
            cost: vec![(NEVER, NOBODY); relaxation.facts],
            rules: fresh.clone(),
            used: vec![0; fresh.len()],
            first: vec![0; commands],
            fresh,
            open: BinaryHeap::new(),
            now: 0,
            enabled: Vec::new(),
            work: 0,
        }
    }

    /// Leaves out the rules of a command from now on.
    pub(super) fn forbid(&mut self, relaxation: &Relaxation, command: u32) {
        for (rule, &own) in relaxation.commands.iter().enumerate() {
            if own == command {
                // No state has as many facts.
                self.fresh[rule].0 = NEVER;
            }
        }
    }

    /// Returns the distance of a state with these facts to the target by a relaxed plan. Returns `None` if there is none:
    /// then no path of the program leads there, also from states with fewer facts.
    pub(super) fn estimate(&mut self, relaxation: &Relaxation, facts: &[Fact]) -> Option<Estimate> {
        self.now += 1;
        self.cost.fill((NEVER, NOBODY));
        self.rules.copy_from_slice(&self.fresh);
        self.open.clear();
        self.enabled.clear();
        facts.iter().for_each(|&fact| self.reach(fact, 0, NOBODY));
        for rule in 0..self.fresh.len() {
            if self.fresh[rule].0 == 0 {
                self.apply(relaxation, rule);
            }
        }
        while let Some(Reverse(next)) = self.open.pop() {
            let (cost, fact) = ((next >> 32) as u32, next as u32);
            if cost > self.cost[fact as usize].0 {
                continue;
            }
            // The target costs as much as all its conditions together, so its plan is known before its turn comes. All
            // facts of the state come before those that cost a step.
            let is_known = self.cost[relaxation.target as usize].0 != NEVER;
            if fact == relaxation.target || cost > 0 && is_known {
                return Some(Estimate { steps: self.plan(relaxation), goals: self.goals(relaxation) });
            }
            let uses = relaxation.uses.of(fact as usize);
            self.work += 1;
            for &rule in uses {
                let (left, sum) = &mut self.rules[rule as usize];
                *left -= 1;
                *sum = sum.saturating_add(cost);
                if *left == 0 {
                    self.apply(relaxation, rule as usize);
                }
            }
        }
        None
    }

    /// Returns whether a command may begin the last plan: its conditions are true in the state.
    pub(super) fn is_helpful(&self, command: u32) -> bool {
        self.first[command as usize] == self.now
    }

    fn apply(&mut self, relaxation: &Relaxation, rule: usize) {
        // All facts of the state come before those that cost a step, and the target is the last fact.
        if self.rules[rule].1 == 0 && relaxation.commands[rule] != NOBODY {
            self.enabled.push(relaxation.commands[rule]);
        }
        let step = u32::from(relaxation.commands[rule] != NOBODY);
        // The largest cost stays below that of a fact that is not reached.
        let cost = self.rules[rule].1.saturating_add(step).min(NEVER - 1);
        for &fact in relaxation.effects.of(rule) {
            self.reach(fact, cost, rule as u32);
        }
    }

    #[inline]
    fn reach(&mut self, fact: u32, cost: u32, rule: u32) {
        let known = &mut self.cost[fact as usize];
        if cost < known.0 {
            *known = (cost, rule);
            self.open.push(Reverse(u64::from(cost) << 32 | u64::from(fact)));
        }
    }

    /// Counts the conditions of the target that are false in the state.
    fn goals(&self, relaxation: &Relaxation) -> u32 {
        let (_, rule) = self.cost[relaxation.target as usize];
        let is_open = |&&fact: &&u32| self.cost[fact as usize].0 > 0;
        relaxation.needs.of(rule as usize).iter().filter(is_open).count() as u32
    }

    /// Counts the rules of a plan that are steps, and marks the commands that may come first.
    fn plan(&mut self, relaxation: &Relaxation) -> u32 {
        let (mut open, mut steps) = (vec![relaxation.target], 0);
        while let Some(fact) = open.pop() {
            let rule = self.cost[fact as usize].1;
            if rule == NOBODY || self.used[rule as usize] == self.now {
                continue;
            }
            self.used[rule as usize] = self.now;
            let command = relaxation.commands[rule as usize];
            if command != NOBODY {
                steps += 1;
                if self.rules[rule as usize].1 == 0 {
                    self.first[command as usize] = self.now;
                }
            }
            open.extend_from_slice(relaxation.needs.of(rule as usize));
        }
        steps
    }
}
