//! Exploration by both engines in turns, until one of them knows all states, or the question is answered without.

use std::sync::Arc;

use super::budget::Budget;
use super::explicit::{Exploration, Guided, Pace};
use super::schedule::Schedule;
use super::settings::{MEMORY_SHARE, Settings, Storage};
use super::symbolic::{self, Exploring, Question};
use meliora_base::error::{Error, Limit, Result};
use meliora_model::Program;
use meliora_model::predicate::Predicate;

/// The way that was the first to end, with its result.
pub(crate) enum First {
    /// The explicit engine; also whether it was the only one that explored.
    Explicit(Box<Exploration>, bool),
    /// The symbolic engine.
    Symbolic(Box<Begun>),
    /// The question was answered over all valuations.
    Answered,
    /// The question was answered by a guided search, which knows the answer.
    Guided(Box<Guided>),
}

/// The result of the symbolic engine, with what the explicit one has done.
pub(crate) struct Begun {
    pub(crate) explored: symbolic::Explored,
    /// The sink of the symbolic engine; it has no limit.
    pub(crate) budget: Arc<Budget>,
    /// The states that the explicit engine has explored, unless it met a limit.
    pub(crate) rest: Option<Box<Exploration>>,
    /// The cost of states in the explicit engine.
    pub(crate) pace: Pace,
}

/// A question about the initial states, with the ways to its answer that do not know all states.
#[derive(Default)]
pub(crate) struct Asked<'a, 'q> {
    /// The question for engines of all valuations.
    pub(crate) everywhere: Option<&'a mut Question<'q>>,
    /// The target, if the question is whether some strategy reaches it almost surely.
    pub(crate) target: Option<&'a Predicate>,
}

/// The ways to the states, or past them to an answer.
#[derive(Clone, Copy)]
enum Way {
    Explicit,
    Symbolic,
    Everywhere,
    Guided,
}

/// Explores a program by both engines in turns of a [`Schedule`]. A question about the initial states takes turns with
/// them: diagrams answer it over all valuations, from its target backwards, and a guided search by some of the states.
///
/// The explicit engine explores for a while alone, since it is the faster one for few states. Then all have equal turns,
/// of which the likelier engine has the first: the explicit one if a question lists the states anyway, else the symbolic
/// one; for a planning problem, which has too many states in most cases, the guided search. Each continues
/// where its last turn ended. Turns are counted in steps of diagrams, and in states and their successors of the explicit
/// engine, which take about as long; so every run ends with the same engine, after at most a fixed multiple of its work
/// alone. A way that runs out of memory has no more turns.
///
/// # Errors
/// The model has no meaning in some state; a limit that ends both explorations.
pub(crate) fn explore(
    program: &Arc<Program>,
    settings: &Settings,
    lists_states: bool,
    asked: Asked<'_, '_>,
) -> Result<First> {
    let mut both = Both::new(program, settings, asked)?;
    if both.explicitly(settings.thresholds.work_before_diagrams)? {
        return both.by_explicit();
    }
    both.share_memory();
    both.prepare()?;
    let ways = both.ways(lists_states, program.planning.is_some());
    let mut schedule = Schedule::even(ways.len(), settings.thresholds.first_turn);
    while let Some(turn) = schedule.next() {
        let way = ways[turn.way];
        match way {
            Way::Explicit if both.explicitly(turn.steps)? => return both.by_explicit(),
            Way::Explicit => {}
            Way::Symbolic => {
                if let Some(explored) = both.symbolically(turn.steps)? {
                    let Both { budget, explicit: rest, pace, .. } = both;
                    return Ok(First::Symbolic(Box::new(Begun { explored, budget, rest, pace })));
                }
            }
            Way::Everywhere if both.asks(turn.steps)? => return Ok(First::Answered),
            Way::Everywhere => {}
            Way::Guided if both.by_guidance(turn.steps)? => return both.guided(),
            Way::Guided => {}
        }
        if !both.has(way) {
            schedule.withdraw(turn.way);
        }
    }
    Err(both.full.unwrap_or(Limit::Interrupted).into())
}

/// Two explorations of the same states, and a question; `None` once they have met a limit of their own.
struct Both<'a, 'q> {
    explicit: Option<Box<Exploration>>,
    symbolic: Option<Exploring>,
    /// The sink of the symbolic exploration.
    budget: Arc<Budget>,
    /// The cost of the states that the explicit engine has explored so far.
    pace: Pace,
    everywhere: Option<(Exploring, &'a mut Question<'q>)>,
    guided: Option<Box<Guided>>,
    /// The target of the guided search as long as that is not prepared.
    target: Option<&'a Predicate>,
    /// The steps that the symbolic engine may have taken so far, in an exploration and for the question.
    allowed: [u64; 2],
    /// The memory limit of both together.
    memory: u64,
    /// The limit of the symbolic engine, or else of the explicit one.
    full: Option<Limit>,
}

impl<'a, 'q> Both<'a, 'q> {
    fn new(program: &Arc<Program>, settings: &Settings, asked: Asked<'a, 'q>) -> Result<Self> {
        let share = settings.memory / MEMORY_SHARE;
        // A guided search has as much as the exploration.
        let shares = share * (1 + u64::from(asked.target.is_some()));
        let own = |storage: Storage, memory: u64| Settings { storage, memory, ..settings.clone() };
        // Diagrams are kept during a turn only, so the exploration and the question have the same memory.
        let budget = Arc::new(Budget::new(u64::MAX, &settings.sink));
        let diagrams = |is_backward: bool| {
            let own = own(Storage::Symbolic, settings.memory - shares);
            let own = if is_backward { own } else { Settings { sink: Arc::clone(&budget) as _, ..own } };
            Exploring::new(Arc::clone(program), own, is_backward)
        };
        let mut both = Both {
            explicit: None,
            symbolic: Some(diagrams(false)?),
            pace: Pace::default(),
            everywhere: asked
                .everywhere
                .map(|question| diagrams(true).map(|own| (own, question)))
                .transpose()?,
            budget,
            guided: None,
            target: asked.target,
            allowed: [0; 2],
            memory: settings.memory,
            full: None,
        };
        // As long as it explores alone, it has all.
        let explicit = Exploration::new(Arc::clone(program), own(Storage::Explicit, settings.memory));
        both.explicit = both.within_limits(explicit.map(Box::new))?;
        Ok(both)
    }

    /// Returns the memory of the explicit engine next to other ways, and of the guided search.
    fn share(&self) -> u64 {
        self.memory / MEMORY_SHARE
    }

    /// Limits the explicit engine to its share of the memory. If it uses more, it has no more turns.
    fn share_memory(&mut self) {
        let share = self.share();
        self.explicit.take_if(|_| self.pace.bytes > share);
        if let Some(exploration) = &mut self.explicit {
            exploration.set_memory(share);
        }
    }

    /// Prepares the guided search, if it is made for the model, once the initial states are known.
    fn prepare(&mut self) -> Result<()> {
        let Some(exploration) = self.explicit.as_ref().filter(|exploration| exploration.has_begun()) else {
            self.target = self.target.filter(|_| self.explicit.is_some());
            return Ok(());
        };
        if let Some(target) = self.target.take() {
            let guided = Guided::new(exploration, target, self.share());
            self.guided = self.within_limits(guided)?.flatten().map(Box::new);
        }
        Ok(())
    }

    /// Returns the ways that have turns.
    fn ways(&self, lists_states: bool, is_planning: bool) -> Vec<Way> {
        let mut ways = match lists_states {
            true => vec![Way::Explicit, Way::Symbolic],
            false => vec![Way::Symbolic, Way::Explicit],
        };
        if self.everywhere.is_some() {
            ways.insert(1, Way::Everywhere);
        }
        if self.has(Way::Guided) {
            ways.insert(if is_planning { 0 } else { ways.len() }, Way::Guided);
        }
        ways
    }

    /// Returns the result of an engine; `None` if a limit of this engine alone was met.
    fn within_limits<T>(&mut self, result: Result<T>) -> Result<Option<T>> {
        match result {
            Err(Error::Limit(limit @ (Limit::Memory { .. } | Limit::Size { .. } | Limit::States(_)))) => {
                self.full.get_or_insert(limit);
                Ok(None)
            }
            result => result.map(Some),
        }
    }

    /// Continues the explicit exploration for some work. Returns whether it knows all states.
    fn explicitly(&mut self, work: u64) -> Result<bool> {
        let Some(mut exploration) = self.explicit.take() else { return Ok(false) };
        let most = exploration.work().saturating_add(work);
        let end = exploration.run(most);
        let end = self.within_limits(end)?;
        self.pace = exploration.pace();
        if end.is_some() {
            self.explicit = Some(exploration);
        }
        Ok(end == Some(true))
    }

    /// Continues the symbolic exploration for some steps. Returns the states once it knows all.
    fn symbolically(&mut self, steps: u64) -> Result<Option<symbolic::Explored>> {
        let Some(mut exploring) = self.symbolic.take() else { return Ok(None) };
        self.allowed[0] = self.allowed[0].saturating_add(steps);
        let explored = exploring.run(self.allowed[0]);
        match self.within_limits(explored)? {
            Some(explored) => {
                self.symbolic = Some(exploring);
                Ok(explored)
            }
            None => {
                if let Some(exploration) = &mut self.explicit {
                    exploration.set_memory(self.memory);
                }
                Ok(None)
            }
        }
    }

    /// Continues to answer the question over all valuations for some steps. Returns whether it is answered.
    fn asks(&mut self, steps: u64) -> Result<bool> {
        let Some((mut exploring, question)) = self.everywhere.take() else { return Ok(false) };
        self.allowed[1] = self.allowed[1].saturating_add(steps);
        let asked = exploring.ask(self.allowed[1], question);
        let asked = self.within_limits(asked)?;
        if asked == Some(None) {
            self.everywhere = Some((exploring, question));
        }
        Ok(asked == Some(Some(true)))
    }

    /// Continues the guided search for some steps. Returns whether it knows the answer.
    fn by_guidance(&mut self, steps: u64) -> Result<bool> {
        self.prepare()?;
        let Some(mut guided) = self.guided.take() else { return Ok(false) };
        let most = guided.work().saturating_add(steps);
        let answer = guided.run(most);
        let answer = self.within_limits(answer)?;
        if answer.is_some() {
            self.guided = Some(guided);
        }
        Ok(answer.flatten().is_some())
    }

    /// Returns whether a way has more turns.
    fn has(&self, way: Way) -> bool {
        match way {
            Way::Explicit => self.explicit.is_some(),
            Way::Symbolic => self.symbolic.is_some(),
            Way::Everywhere => self.everywhere.is_some(),
            Way::Guided => self.guided.is_some() || self.target.is_some(),
        }
    }

    /// Returns the guided search, which knows the answer.
    fn guided(self) -> Result<First> {
        Ok(First::Guided(self.guided.ok_or(Limit::Interrupted)?))
    }

    /// Returns the explicit exploration, which knows all states.
    fn by_explicit(self) -> Result<First> {
        let is_alone = self.allowed == [0; 2];
        let explicit = self.explicit.ok_or(Limit::Interrupted)?;
        Ok(First::Explicit(explicit, is_alone))
    }
}
