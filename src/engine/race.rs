//! Several ways to one answer, each in a thread of its own: the first to end has it, and the others end.
//!
//! The threads take turns, counted in steps of diagrams. As many of them run at once as the caller allows; with one, every
//! run takes the same turns. A way that waits keeps its results so far. The first way has the first steps alone, and the
//! second one a turn after these. A way may begin late, after a number of steps of the others. The way that is the first
//! to know all states leads from then on: it is the likeliest to be the first to end. So it has a multiple of its steps so
//! far alone, and half of all steps after these. If it knows in how many steps the first way is likely to end, it has at
//! most as many alone, and the first way the next ones.
//!
//! A way whose further work costs the same on each of them *settles* the race: it goes on alone, with the memory of all.

#[cfg(test)]
mod tests;

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering::Relaxed};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::{Builder, Scope};
use std::time::Duration;

use meliora_base::error::{Error, Limit, Result};
use meliora_base::memory::{STACK, check_heap};
use meliora_base::progress::ProgressSink;
use meliora_base::sync::lock;

/// The time after which the limits of the whole work are looked at again.
const CHECKS: Duration = Duration::from_millis(10);
/// In place of the way that has won: none so far, none at all, and none of those whose threads have all ended.
const OPEN: usize = usize::MAX;
const NOBODY: usize = usize::MAX - 1;
const FREE: usize = usize::MAX - 2;

/// The rules of a race.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rules {
    /// The number of ways that run at once.
    pub(crate) threads: usize,
    /// The steps that the first way has alone.
    pub(crate) alone: u64,
    /// The steps of a turn.
    pub(crate) turn: u64,
    /// The steps that the leader has alone, for each step in which it has found all states.
    pub(crate) lead: u64,
    /// The bytes of all ways together.
    pub(crate) memory: u64,
}

/// The part of a way of all steps.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Share {
    /// Its steps in proportion to those of the others.
    pub(crate) weight: u64,
    /// The steps that it counts as taken before it begins. Each of the others has as many first, times its weight.
    pub(crate) late: u64,
}

/// A way as its own thread sees it: a progress sink that lets its work wait for its turns.
pub(crate) struct Lane {
    race: Arc<Race>,
    pub(crate) way: usize,
    sink: Arc<dyn ProgressSink>,
    /// The steps so far, and those at the end of the turn.
    spent: AtomicU64,
    until: AtomicU64,
    /// True for a way without others: it takes no turns, and has all memory.
    pub(crate) is_last: bool,
}

/// The place of a way among those that know all states.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Place {
    /// It is the first, before any other way has begun.
    Alone,
    First,
    Later,
}

struct Race {
    state: Mutex<State>,
    changed: Condvar,
    /// The way that has won, [`OPEN`], [`NOBODY`] or [`FREE`].
    winner: AtomicUsize,
}

impl Race {
    /// Returns whether no way has won or settled the race.
    fn is_open(&self) -> bool {
        self.winner.load(Relaxed) == OPEN
    }
}

struct State {
    rules: Rules,
    ways: Vec<Way>,
    /// The way that was the first to know all states, and its steps at the end of those that it has alone.
    leader: Option<(usize, u64)>,
    /// The steps in which the first way is likely to end, if the leader knows them.
    likely: Option<u64>,
}

struct Way {
    phase: Phase,
    /// True if it has ended with the answer, an error of the question or a panic.
    has_answer: bool,
    /// Its part of all steps, in proportion to those of the others.
    weight: u64,
    /// The steps so far, and those that it counts as taken before it began or while another one was alone.
    spent: u64,
    missed: u64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// Its thread has not begun.
    New,
    Waits,
    Runs,
    Ended,
}

/// The end of a way.
enum End<T> {
    Answer(Result<T>),
    /// It has no answer; with the limit that it met.
    Leaves(Option<Limit>),
    Panic(Box<dyn Any + Send>),
}

/// The end of a race.
enum Over<T> {
    Answer(Result<T>),
    Panic(Box<dyn Any + Send>),
    /// All ways have ended without an answer.
    Nobody,
}

impl State {
    fn is_open(&self, way: usize) -> bool {
        self.ways[way].phase != Phase::Ended
    }

    /// Returns whether a way has begun and not ended.
    fn is_under_way(&self, way: usize) -> bool {
        matches!(self.ways[way].phase, Phase::Waits | Phase::Runs)
    }

    fn waits(&self, way: usize) -> bool {
        matches!(self.ways[way].phase, Phase::New | Phase::Waits)
    }

    /// Returns the way that runs next, with its steps at the end of this turn; `None` if no other may run now.
    fn next(&self) -> Option<(usize, u64)> {
        let running = self.ways.iter().filter(|way| way.phase == Phase::Runs).count();
        if running >= self.rules.threads {
            return None;
        }
        let leader = self.leader.filter(|&(way, _)| self.is_open(way));
        let first = [(0, self.rules.alone), (1, self.rules.turn)].into_iter().take(self.ways.len());
        let has_steps = |&(way, until): &(usize, u64)| self.is_open(way) && self.ways[way].spent < until;
        let alone = leader.into_iter().chain(first.filter(|_| leader.is_none())).find(has_steps);
        if let Some((way, until)) = alone {
            return self.waits(way).then_some((way, until));
        }
        let turn = |way: usize| (way, self.ways[way].spent + self.rules.turn);
        // On several cores the leader always has one.
        let waits = leader.map(|(way, _)| way).filter(|&way| self.rules.threads > 1 && self.waits(way));
        let likely = leader.and(self.likely).map(|until| (0, until)).filter(has_steps);
        let likely = likely.filter(|_| self.waits(0));
        let open = (0..self.ways.len()).filter(|&way| self.waits(way));
        let least = open.min_by_key(|&way| self.ways[way].time());
        waits.map(turn).or(likely).or(least.map(turn))
    }

    /// Lets a way lead that knows all states, unless another one does. Returns its steps at the end of those alone.
    fn lead(&mut self, way: usize, likely: Option<u64>) -> Option<u64> {
        // The results of a leader that has the answer are not replaced before it is taken.
        if self.leader.is_some_and(|(leader, _)| self.is_open(leader) || self.ways[leader].has_answer) {
            return None;
        }
        let spent = self.ways[way].spent;
        let Rules { turn, lead, .. } = self.rules;
        let alone = spent.saturating_mul(lead).min(likely.unwrap_or(u64::MAX));
        let until = spent.saturating_add(alone.max(turn));
        (self.leader, self.likely) = (Some((way, until)), likely);
        let others = (0..self.ways.len()).filter(|&other| other != way && self.is_open(other));
        let others = Vec::from_iter(others);
        self.ways[way].weight = (others.len() as u64).max(1);
        let time = until / self.ways[way].weight;
        for other in others {
            let Way { spent, missed, weight, .. } = &mut self.ways[other];
            (*weight, *missed) = (1, time.saturating_sub(*spent));
        }
        Some(until)
    }
}

impl Way {
    /// Returns the steps in proportion to the weight: the way with the least runs next.
    fn time(&self) -> u64 {
        (self.spent + self.missed) / self.weight
    }
}

impl Lane {
    /// Returns the steps that this way has alone if it knows all states now, and is the first.
    pub(crate) fn alone(&self) -> u64 {
        self.spent.load(Relaxed).saturating_mul(lock(&self.race.state).rules.lead)
    }

    /// Notes that this way knows all states, and the steps in which the first way is likely to end. The first one to know
    /// them leads from now on.
    pub(crate) fn knows_all_states(&self, likely: Option<u64>) -> Place {
        let mut state = lock(&self.race.state);
        state.ways[self.way].spent = self.spent.load(Relaxed);
        let until = state.lead(self.way, likely);
        until.iter().for_each(|&until| self.until.store(until, Relaxed));
        let is_alone =
            (0..state.ways.len()).all(|way| way == self.way || state.ways[way].phase == Phase::New);
        match until {
            _ if is_alone || self.is_last => Place::Alone,
            Some(_) => Place::First,
            None => Place::Later,
        }
    }

    /// Ends the turn, and waits for the next one.
    fn wait(&self, spent: u64) {
        let mut state = lock(&self.race.state);
        let own = &mut state.ways[self.way];
        (own.phase, own.spent) = (Phase::Waits, spent);
        self.race.changed.notify_all();
        let waits = |state: &mut State| state.ways[self.way].phase == Phase::Waits && self.race.is_open();
        drop(self.race.changed.wait_while(state, waits));
    }

    /// Returns whether this way must end; `None` if it takes turns.
    fn is_over(&self) -> Option<bool> {
        match self.race.winner.load(Relaxed) {
            _ if self.is_last => Some(false),
            OPEN => None,
            FREE => Some(false),
            winner => Some(winner != self.way),
        }
    }
}

impl ProgressSink for Lane {
    fn stop(&self) -> Option<Limit> {
        if let Some(limit) = self.sink.stop() {
            return Some(limit);
        }
        if self.is_over().is_none() {
            let spent = self.spent.load(Relaxed);
            if spent >= self.until.load(Relaxed) {
                self.wait(spent);
            }
        }
        self.is_over().unwrap_or(false).then_some(Limit::Interrupted)
    }

    fn advance(&self, steps: u64) {
        self.spent.fetch_add(steps, Relaxed);
        self.sink.advance(steps);
    }

    fn clock(&self) -> Duration {
        self.sink.clock()
    }

    fn settle(&self) -> Option<u64> {
        let winner = self.race.winner.compare_exchange(OPEN, self.way, Relaxed, Relaxed);
        if self.is_last || winner.is_err_and(|winner| winner != self.way) {
            return None;
        }
        let mut state = lock(&self.race.state);
        self.race.changed.notify_all();
        let others = (0..state.ways.len()).filter(|&way| way != self.way);
        while others.clone().any(|way| state.is_under_way(way)) && self.sink.stop().is_none() {
            let waited = self.race.changed.wait_timeout(state, CHECKS);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        Some(state.rules.memory)
    }

    fn progress(&self, phase: &'static str, detail: &dyn Fn() -> String) {
        self.sink.progress(phase, detail);
    }
}

/// The work of a way; `None` if it has no answer.
pub(crate) type Run<'r, T> = &'r (dyn Fn(&Arc<Lane>) -> Result<Option<T>> + Sync);

/// Runs some ways until the first has the answer, each with a sink of its own and with its share. A way that is out of
/// memory leaves the others; the last one begins again, with all memory.
///
/// # Errors
/// The error of the way that is the first to end; the limit of the whole work, which `sink` tells; the limit of the
/// last way. A panic of a way is passed on.
pub(crate) fn race<T: Send>(
    rules: Rules,
    shares: &[Share],
    sink: &dyn ProgressSink,
    sinks: &dyn Fn(usize) -> Arc<dyn ProgressSink>,
    run: Run<'_, T>,
) -> Result<T> {
    let way = |&Share { weight, late: missed }: &Share| Way {
        phase: Phase::New,
        has_answer: false,
        weight,
        spent: 0,
        missed,
    };
    let state = State { rules, ways: shares.iter().map(way).collect(), leader: None, likely: None };
    let race = Race { state: Mutex::new(state), changed: Condvar::new(), winner: AtomicUsize::new(OPEN) };
    let race = Arc::new(race);
    let lane = |way: usize, is_last: bool| {
        let [spent, until] = [0; 2].map(AtomicU64::new);
        Arc::new(Lane { race: Arc::clone(&race), way, sink: sinks(way), spent, until, is_last })
    };
    let mut field = Field { lanes: Vec::new(), ends: Mutex::default(), left: Vec::new() };
    field.lanes.extend((0..shares.len()).map(|way| lane(way, false)));
    let is_memory = |limit: &Limit| matches!(limit, Limit::Memory { .. } | Limit::System { .. });
    match field.run(&race, sink, run) {
        Over::Answer(found) => found,
        Over::Panic(panic) => resume_unwind(panic),
        Over::Nobody => {
            let last = field.left.iter().rev().find(|(_, limit)| is_memory(limit));
            let found = last.map(|&(way, _)| run(&lane(way, true))).transpose()?.flatten();
            found.ok_or_else(|| match field.left.first() {
                Some((_, limit)) => limit.clone().into(),
                None => Error::Usage("no way of the race answers this question".to_owned()),
            })
        }
    }
}

/// The ways that have begun, and the ends that the caller has not looked at.
struct Field<T> {
    lanes: Vec<Arc<Lane>>,
    ends: Mutex<Vec<(usize, End<T>)>>,
    /// The ways that met a limit, in the order of their ends.
    left: Vec<(usize, Limit)>,
}

impl<T: Send> Field<T> {
    /// Gives the ways their turns until one of them wins, or all have ended.
    fn run(&mut self, race: &Race, sink: &dyn ProgressSink, run: Run<'_, T>) -> Over<T> {
        let Field { lanes, ends, left } = self;
        let over = std::thread::scope(|scope| {
            let mut state = lock(&race.state);
            let (winner, over) = loop {
                let mut over = None;
                for (way, end) in std::mem::take(&mut *lock(ends)) {
                    match end {
                        End::Answer(found) => drop(over.get_or_insert((way, Over::Answer(found)))),
                        End::Panic(panic) => over = Some((NOBODY, Over::Panic(panic))),
                        End::Leaves(Some(limit)) if race.winner.load(Relaxed) == way => {
                            over = Some((NOBODY, Over::Answer(Err(limit.into()))));
                        }
                        End::Leaves(limit) => left.extend(limit.map(|limit| (way, limit))),
                    }
                }
                // Before another way takes the place of the one that has ended.
                if let Some(over) = over {
                    break over;
                }
                while let Some((way, until)) = state.next().filter(|_| race.is_open()) {
                    let is_new = state.ways[way].phase == Phase::New;
                    lanes[way].until.store(until, Relaxed);
                    state.ways[way].phase = Phase::Runs;
                    if is_new && let Err(limit) = spawn(scope, &lanes[way], ends, run) {
                        state.ways[way].phase = Phase::Ended;
                        left.push((way, limit));
                    }
                    race.changed.notify_all();
                }
                if let Some(limit) = sink.stop() {
                    break (NOBODY, Over::Answer(Err(limit.into())));
                }
                if (0..lanes.len()).all(|way| !state.is_open(way)) {
                    break (NOBODY, Over::Nobody);
                }
                let waited = race.changed.wait_timeout(state, CHECKS);
                state = waited.unwrap_or_else(PoisonError::into_inner).0;
            };
            race.winner.store(winner, Relaxed);
            race.changed.notify_all();
            over
        });
        // The partial results of a way that a limit has ended can be continued.
        let _ = race.winner.compare_exchange(NOBODY, FREE, Relaxed, Relaxed);
        over
    }
}

/// Starts the thread of a way.
fn spawn<'s, T: Send>(
    scope: &'s Scope<'s, '_>,
    lane: &Arc<Lane>,
    ends: &'s Mutex<Vec<(usize, End<T>)>>,
    run: Run<'s, T>,
) -> Result<(), Limit> {
    let lane = Arc::clone(lane);
    let work = move || {
        let begin = || {
            check_heap()?;
            run(&lane)
        };
        let end = match catch_unwind(AssertUnwindSafe(begin)) {
            Ok(Ok(Some(found))) => End::Answer(Ok(found)),
            Ok(Ok(None)) => End::Leaves(None),
            Ok(Err(Error::Limit(limit))) => End::Leaves(Some(limit)),
            Ok(Err(error)) => End::Answer(Err(error)),
            Err(panic) => End::Panic(panic),
        };
        let has_answer = !matches!(end, End::Leaves(_));
        lock(ends).push((lane.way, end));
        let mut state = lock(&lane.race.state);
        let own = &mut state.ways[lane.way];
        (own.phase, own.has_answer, own.spent) = (Phase::Ended, has_answer, lane.spent.load(Relaxed));
        lane.race.changed.notify_all();
    };
    match Builder::new().name("meliora-way".to_owned()).stack_size(STACK).spawn_scoped(scope, work) {
        Ok(_) => Ok(()),
        Err(e) => Err(Limit::System { what: format!("a thread of its own for a way ({e})"), bytes: None }),
    }
}
