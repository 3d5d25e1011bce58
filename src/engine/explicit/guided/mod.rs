//! A guided search: almost-sure reachability of one target from the initial states, by a part of the states.
//!
//! The search keeps two sides of the answer, both sound at every moment:
//! - *lost* states, from which no strategy reaches the target almost surely, however the states that are not explored
//!   behave: a relaxed plan does not exist, each choice may lead to a lost state, or all states that can be reached by
//!   other choices are explored and none is in the target.
//! - a *policy*, which has a choice in explored states and leads from each of them to the target by some path, through
//!   states of the policy. Where it is closed, it reaches the target almost surely.
//!
//! It begins with the initial states. From a state without a choice, a best-first search follows single outcomes, with
//! estimates of the distance (`estimate`) on the delete relaxation (`relaxation`), and in turns only from states with
//! something new (`novelty`), until it meets the target or the policy: the path becomes part of the policy, and its
//! other outcomes are the next states. If the path does not exist, the states that were found are lost; choices that may
//! lead there are given up, and the policy is repaired (`part`). Before a search begins, the path of a state that agrees
//! in all that matters to it is tried (`advice`). The answer is *yes* once the policy is closed, *no* once
//! an initial state is lost. Without a fringe, each state is one or the other, so the search is complete.
//!
//! Sources: the search for weak plans and their repair is that of NDP (Kuter et al., ICAPS 2008) and PRP (Muise,
//! McIlraith and Beck, ICAPS 2012), with full states; the two sides are those of partial exploration (Brázdil et al.,
//! ATVA 2014).

mod advice;
mod estimate;
mod facts;
mod fatal;
mod follow;
mod novelty;
mod part;
mod queue;
mod relaxation;
mod search;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use meliora_base::error::Result;
use meliora_base::progress::Poll;
use meliora_model::predicate::Predicate;
use meliora_model::step::Choice;
use meliora_model::{ModelKind, Program, State, VarId};

use crate::settings::{Scope, Settings};
use advice::Advice;
use estimate::Estimator;
use facts::Fact;
use meliora_space::compile::Compiler;
use meliora_space::explore::{Exploration, Task};
use meliora_space::index::NOBODY;
use meliora_space::machine::{Code, Machine};
use meliora_space::meter::Meter;
use meliora_space::total::is_total;
use part::Part;
use relaxation::Relaxation;
use search::Search;

/// A guided search for a strategy that reaches a target almost surely. It can be interrupted and continued.
pub struct Guided {
    task: Task,
    target: Condition,
    guide: Guide,
    part: Part,
    initial: Vec<u32>,
    /// The states that wait for a choice.
    open: Vec<u32>,
    search: Search,
    advice: Advice,
    /// The states and successors explored.
    steps: u64,
    /// The work when the policy was followed last, and how much that took.
    walked: [u64; 2],
    /// The work at the last report of progress.
    reported: u64,
    answer: Option<bool>,
}

/// A state of a policy with its choice.
#[derive(Debug, Clone)]
pub struct Guiding {
    /// The state, outside of the target.
    pub state: State,
    /// The choice.
    pub choice: Choice,
    /// The name of the choice.
    pub name: String,
    /// The least number of steps in which the policy may reach the target.
    pub distance: usize,
}

/// A compiled condition.
struct Condition {
    code: Code,
    start: u32,
    machine: Machine,
    /// The variables that it reads.
    support: Vec<VarId>,
}

/// The estimates.
struct Guide {
    relaxation: Relaxation,
    estimator: Estimator,
    /// The state that was read last, its values and its facts.
    state: u32,
    values: State,
    facts: Vec<Fact>,
    /// The commands that are known to be fatal, and those that were judged.
    fatal: Vec<bool>,
    judged: Vec<bool>,
    /// 1 and the number of fatal commands: estimates of another age knew fewer.
    age: u32,
}

impl Guided {
    /// Searches until the answer is known. Returns `None` for models that the search is not made for; see
    /// [`Guided::new`].
    ///
    /// # Errors
    /// A limit is reached.
    pub(crate) fn finished(
        program: Arc<Program>,
        settings: Settings,
        target: &Predicate,
    ) -> Result<Option<Self>> {
        let mut exploration = Exploration::new(program, settings.limits())?;
        exploration.begin()?;
        let Some(mut guided) = Guided::new(&exploration, target)? else { return Ok(None) };
        drop(exploration);
        guided.run(u64::MAX)?;
        Ok(Some(guided))
    }

    /// Prepares a search for a target in the model of an exploration that knows its initial states. Returns `None` for
    /// models that it is not made for: games, Markov chains, and programs in which the text does not show that each
    /// command has a meaning in each state.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(super) fn new(of: &Exploration, target: &Predicate) -> Result<Option<Self>> {
        let (task, program) = (&of.task, &of.task.program);
        let is_plain = program.kind == ModelKind::Mdp && task.limits.scope == Scope::Reachable;
        if !is_plain || !is_total(program, &task.prepared, target) {
            return Ok(None);
        }
        let mut poll = Poll::new(&*task.limits.sink);
        let mut compiler = Compiler::new(program, target.pool(), &[target.id()], &mut poll)?;
        let start = compiler.condition(target.id()).start;
        let code = compiler.finish();
        let machine = Machine::new(&code);
        let relaxation = Relaxation::new(program, target, &mut poll)?;
        let estimator = Estimator::new(&relaxation, program.commands.len());
        let values = vec![0; program.variables.len()];
        let fatal = vec![false; program.commands.len()];
        let (judged, facts) = (fatal.clone(), Vec::new());
        let guide = Guide { relaxation, estimator, state: NOBODY, values, facts, fatal, judged, age: 1 };
        let meter = Meter::new(task.limits.memory);
        let task = Task {
            program: program.clone(),
            limits: task.limits.clone(),
            layout: task.layout.clone(),
            prepared: task.prepared.clone(),
            meter: meter.clone(),
        };
        let mut guided = Guided {
            part: Part::new(task.layout.words(), &meter),
            target: Condition { code, start, machine, support: target.pool().support(target.id()) },
            guide,
            initial: Vec::new(),
            open: Vec::new(),
            search: Search::new(&meter),
            advice: Advice::new(),
            steps: 0,
            walked: [0; 2],
            reported: 0,
            answer: None,
            task,
        };
        for code in of.beginnings() {
            guided.start(code)?;
        }
        Ok(Some(guided))
    }

    /// Returns the work so far, counted in states and successors, facts of estimates and lists of advice.
    pub(super) fn work(&self) -> u64 {
        self.steps + self.guide.estimator.work + self.advice.looks
    }

    /// Continues until the answer is known, or the work so far is at least `most`. Returns whether some strategy
    /// reaches the target almost surely from all initial states.
    ///
    /// # Errors
    /// A limit is reached.
    pub(super) fn run(&mut self, most: u64) -> Result<Option<bool>> {
        self.answer = self.advance(most)?;
        Ok(self.answer)
    }

    /// Returns whether some strategy reaches the target almost surely from all initial states; `None` if that is not known.
    pub fn answer(&self) -> Option<bool> {
        self.answer
    }

    /// Returns the number of initial states, and of those from which no strategy is known to reach the target almost
    /// surely.
    pub fn initial(&self) -> [usize; 2] {
        let lost = |state: &&u32| self.part.standing[**state as usize].is_lost;
        [self.initial.len(), self.initial.iter().filter(lost).count()]
    }

    /// Returns the initial states.
    pub fn initial_states(&self) -> Vec<State> {
        self.initial.iter().map(|&state| self.task.values(self.part.index.code(state as usize))).collect()
    }
}

impl Condition {
    /// Returns whether the condition is true in a state.
    fn holds(&mut self, task: &Task, code: &[u64]) -> Result<bool> {
        for variable in &self.support {
            self.machine.regs[variable.index()] = task.layout.value(code, variable.index());
        }
        self.machine.next_state();
        self.machine.run(&self.code, self.start).map_err(|_| task.fault(code))
    }
}
