//! The control of a guided search: which state comes next, and the search for a path from it.

use std::collections::VecDeque;
use std::sync::Arc;

use super::estimate::Estimate;
use super::follow::Visited;
use super::novelty::Novelty;
use super::part::{Standing, Taken};
use super::queue::Queue;
use super::{Guide, Guided};
use meliora_base::error::Result;
use meliora_space::STEPS_PER_WORK;
use meliora_space::expand::{self, Expand};
use meliora_space::explore::PATIENCE;
use meliora_space::index::NOBODY;
use meliora_space::layout::Code;
use meliora_space::meter::{Array, Meter};

/// A best-first search for a path from one state to the target or to the policy.
pub(super) struct Search {
    /// The state where it begins; [`NOBODY`] if none is under way.
    start: u32,
    /// The edges that may be followed, and those from states with something new. Both have turns.
    queues: [Queue; 2],
    novelty: Novelty,
    turn: usize,
    /// For each state the number of the last search that entered it, and the edge by which it did.
    entered: Array<(u32, u32)>,
    number: u32,
    /// The states that it has entered.
    found: Vec<u32>,
}

impl Search {
    pub(super) fn new(meter: &Meter) -> Self {
        Search {
            start: NOBODY,
            queues: [Queue::new(meter), Queue::new(meter)],
            novelty: Novelty::new(meter),
            turn: 0,
            entered: Array::new(meter),
            number: 0,
            found: Vec::new(),
        }
    }

    fn begin(&mut self, start: u32) {
        self.end();
        self.start = start;
        self.number += 1;
    }

    fn end(&mut self) {
        self.queues.iter_mut().for_each(Queue::clear);
        self.found.clear();
        self.novelty.clear();
        self.start = NOBODY;
    }

    fn pop(&mut self) -> Option<u32> {
        self.turn ^= 1;
        let turn = self.turn;
        self.queues[turn].pop().or_else(|| self.queues[turn ^ 1].pop())
    }

    pub(super) fn has_entered(&self, state: u32) -> bool {
        self.entered.get(state as usize).is_some_and(|&(number, _)| number == self.number)
    }

    /// Enters a state by an edge; [`NOBODY`] for the first one.
    pub(super) fn enter(&mut self, state: u32, edge: u32) -> Result<()> {
        while self.entered.len() <= state as usize {
            self.entered.push((0, NOBODY))?;
        }
        self.entered[state as usize] = (self.number, edge);
        self.found.push(state);
        Ok(())
    }
}

impl Guided {
    /// Adds an initial state.
    pub(super) fn start(&mut self, code: &[u64]) -> Result<()> {
        let state = self.number(code)?;
        self.initial.push(state);
        Ok(())
    }

    /// Returns the number of a state, in which the target is tested if it is new.
    fn number(&mut self, code: &[u64]) -> Result<u32> {
        let (state, is_new) = self.part.number(code)?;
        if is_new {
            self.part.standing[state as usize].is_target = self.target.holds(&self.task, code)?;
        }
        Ok(state)
    }

    pub(super) fn advance(&mut self, most: u64) -> Result<Option<bool>> {
        let prepared = Arc::clone(&self.task.prepared);
        let mut stepper = expand::stepper(&prepared, self.task.layout.words());
        while self.work() < most {
            self.report()?;
            if self.initial.iter().any(|&state| self.part.standing[state as usize].is_lost) {
                return Ok(Some(false));
            }
            if self.search.start == NOBODY {
                let Some(next) = self.next() else { return Ok(Some(true)) };
                self.search.begin(next);
                if !self.is_led(&mut *stepper, next)? {
                    self.search.begin(next);
                    self.look(&mut *stepper, next, NOBODY)?;
                }
                continue;
            }
            if self.part.standing[self.search.start as usize].is_lost {
                self.search.end();
                continue;
            }
            let Some(edge) = self.search.pop() else {
                // Each choice that may be taken stays among these states.
                self.part.lose(self.search.found.clone());
                self.search.end();
                continue;
            };
            let state = self.part.successor(edge);
            if self.part.is_open(self.part.source(edge).0) && !self.search.has_entered(state) {
                self.look(&mut *stepper, state, edge)?;
            }
        }
        Ok(None)
    }

    /// Returns a state that needs a choice; `None` if the policy is closed.
    fn next(&mut self) -> Option<u32> {
        // States that the policy no longer visits wait, too: after a repair, it is followed again, unless that would
        // take longer than the work since the last time.
        let [at, took] = self.walked;
        if !self.part.detached.is_empty() && self.work() >= at + took {
            self.open.clear();
        }
        for _ in 0..2 {
            while let Some(state) = self.open.pop() {
                if !self.part.leads_on(state) && !self.part.standing[state as usize].is_lost {
                    return Some(state);
                }
            }
            self.walk();
        }
        None
    }

    /// Follows the policy from the initial states, depth first, and lists those that need a choice.
    fn walk(&mut self) {
        self.part.detached.clear();
        let Visited { open, steps, .. } = self.visited(VecDeque::pop_back);
        self.open = open;
        self.steps += steps;
        self.walked = [self.work(), steps];
    }

    /// Enters a state: estimates its distance, and lists its choices and their successors. If one of these is in the
    /// target or the policy, the path becomes part of the policy.
    fn look(&mut self, stepper: &mut dyn Expand, state: u32, edge: u32) -> Result<()> {
        self.search.enter(state, edge)?;
        let standing = self.part.standing[state as usize];
        let goes_on = match standing {
            Standing { is_lost: true, .. } => false,
            Standing { is_expanded: true, .. } => self.renew(state),
            _ => self.expand(stepper, state)?,
        };
        if !goes_on {
            // A search that begins there has no way to go.
            if edge != NOBODY && self.judge(self.part.source(edge).0) {
                return self.restart(stepper);
            }
            return Ok(());
        }
        let known = self.part.estimate[state as usize];
        let is_novel = self.is_novel(state)?;
        for choice in
            self.part.choices_of(state).filter(|&choice| self.part.is_open(choice)).collect::<Vec<_>>()
        {
            for edge in self.part.edges_of(choice) {
                let to = self.part.successor(edge);
                if self.part.leads_on(to) {
                    return self.adopt(stepper, state, choice, to);
                }
                if self.search.has_entered(to) {
                    continue;
                }
                let is_estimated = self.part.standing[to as usize].age != 0;
                let Estimate { steps, goals } =
                    if is_estimated { self.part.estimate[to as usize] } else { known };
                self.search.queues[0].push([steps, 0, 0], edge)?;
                if is_novel {
                    let key = [goals, steps, u32::from(!self.part.is_helpful(choice))];
                    self.search.queues[1].push(key, edge)?;
                }
            }
        }
        Ok(())
    }

    /// Lets the guide read the facts of a state, unless it knows them.
    fn read(&mut self, state: u32) {
        let guide = &mut self.guide;
        if std::mem::replace(&mut guide.state, state) != state {
            self.task.layout.decode(self.part.index.code(state as usize), &mut guide.values);
            guide.facts.clear();
            guide.relaxation.facts_of(&guide.values, &mut guide.facts);
        }
    }

    /// Returns whether a state that was just entered has something new to the search.
    fn is_novel(&mut self, state: u32) -> Result<bool> {
        self.read(state);
        self.search.novelty.see(&self.guide, self.part.estimate[state as usize])
    }

    /// Estimates the distance of a state to the target. Returns false if it is lost.
    pub(super) fn estimate(&mut self, state: u32) -> bool {
        self.read(state);
        let guide = &mut self.guide;
        let found = guide.estimator.estimate(&guide.relaxation, &guide.facts);
        self.part.standing[state as usize].age = self.guide.age;
        match found {
            Some(found) => self.part.estimate[state as usize] = found,
            None => self.part.lose(vec![state]),
        }
        found.is_some()
    }

    /// Lists the choices of a state. Returns false if it is lost.
    pub(super) fn expand(&mut self, stepper: &mut dyn Expand, state: u32) -> Result<bool> {
        // Also of a state whose distance is known: the plan names the helpful commands.
        if !self.estimate(state) {
            return Ok(false);
        }
        let code = Code::from_slice(self.part.index.code(state as usize));
        stepper.enter(&self.task.layout, &code);
        let Guide { relaxation, estimator, .. } = &self.guide;
        let of = |&command: &u32| relaxation.synchronisations.of(command as usize);
        let mut among: Vec<u32> = estimator.enabled.iter().flat_map(of).copied().collect();
        among.sort_unstable();
        among.dedup();
        let mut among = among.into_iter().map(|index| index as usize);
        stepper.expand_among(&mut among).map_err(|broken| self.task.broken(broken, &code))?;
        self.steps += 1 + stepper.ends().last().map_or(0, |&end| u64::from(end));
        self.part.begin(state);
        let (mut at, mut number, mut successors) = (0, 0, Vec::new());
        let mut successor = code.clone();
        for place in 0..stepper.active().len() {
            let index = stepper.active()[place];
            for combination in 0..stepper.combinations(index) {
                let end = stepper.ends()[number] as usize;
                successors.clear();
                for step in at..end {
                    successor.copy_from_slice(&code);
                    stepper.step(step, &mut successor);
                    successors.push(self.number(&successor)?);
                }
                successors.sort_unstable();
                successors.dedup();
                let estimator = &self.guide.estimator;
                let commands = stepper.combination(index, combination);
                let taken = Taken {
                    command: if let &[command] = commands.as_slice() { command } else { NOBODY },
                    place: [index as u32, combination as u32],
                    is_helpful: commands.iter().any(|&command| estimator.is_helpful(command)),
                    is_fatal: commands.iter().any(|&command| self.guide.fatal[command as usize]),
                };
                self.part.add(state, &successors, taken)?;
                (at, number) = (end, number + 1);
            }
        }
        self.part.end(state);
        Ok(!self.part.standing[state as usize].is_lost)
    }

    /// Takes the path that the search has found into the policy. Its other outcomes are estimated: those that are lost
    /// make it useless at once.
    pub(super) fn adopt(&mut self, stepper: &mut dyn Expand, state: u32, choice: u32, to: u32) -> Result<()> {
        let (mut path, mut last) = (vec![(state, choice, to)], state);
        loop {
            let (_, edge) = self.search.entered[last as usize];
            if edge == NOBODY {
                break;
            }
            let (choice, owner) = self.part.source(edge);
            if !self.part.is_open(choice) {
                // The search learnt too late that this choice may lead to a lost state.
                return self.restart(stepper);
            }
            path.push((owner, choice, last));
            last = owner;
        }
        self.search.end();
        path.iter().for_each(|&(state, choice, to)| self.part.attach(state, choice, to));
        self.learn(&path);
        for &(_, choice, _) in path.iter().rev() {
            for edge in self.part.edges_of(choice) {
                let to = self.part.successor(edge);
                let standing = self.part.standing[to as usize];
                if self.part.leads_on(to) || standing.is_lost {
                    continue;
                }
                if standing.age != 0 || self.estimate(to) {
                    self.open.push(to);
                } else {
                    self.judge(choice);
                }
            }
        }
        Ok(())
    }

    /// Begins the search from its state again.
    fn restart(&mut self, stepper: &mut dyn Expand) -> Result<()> {
        let start = self.search.start;
        self.search.begin(start);
        self.look(stepper, start, NOBODY)
    }

    fn report(&mut self) -> Result<()> {
        if self.work() < self.reported + PATIENCE as u64 {
            return Ok(());
        }
        let sink = &self.task.limits.sink;
        sink.advance((self.work() - self.reported) * STEPS_PER_WORK);
        self.reported = self.work();
        let (states, open) = (self.part.standing.len(), self.open.len());
        let detail = || format!("{states} states found, {open} wait for a choice");
        let sink = &self.task.limits.sink;
        sink.progress("guided search", &detail);
        sink.stop().map_or(Ok(()), |limit| Err(limit.into()))
    }
}
