//! Both engines end their work at once when the progress sink cancels it, at every question.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use meliora::engine::regions;
use meliora::error::Result;
use meliora::planning::Phase;

use crate::common::prelude::*;

/// Stops the work from the question of this number on; hears of the phases.
struct Patience {
    asked: AtomicU64,
    allowed: AtomicU64,
    heard: Mutex<BTreeSet<&'static str>>,
}

impl Patience {
    fn new(allowed: u64) -> Arc<Self> {
        Arc::new(Patience {
            asked: AtomicU64::new(0),
            allowed: AtomicU64::new(allowed),
            heard: Mutex::default(),
        })
    }
}

impl ProgressSink for Patience {
    fn stop(&self) -> Option<Limit> {
        let before = self.asked.fetch_add(1, Relaxed);
        (before >= self.allowed.load(Relaxed)).then_some(Limit::Interrupted)
    }

    fn progress(&self, phase: &'static str, _: &dyn Fn() -> String) {
        self.heard.lock().unwrap().insert(phase);
    }
}

/// The length of a way, and the number of ways next to each other.
type Size = (usize, usize);

const LARGE: Size = (20, 1000);
const SMALL: Size = (20, 1);

/// Ways at the end of which chance decides between two objectives.
fn ways((length, width): Size) -> (Arc<Program>, Arc<Preferences>) {
    let text = format!(
        "mdp const int L={length}; module m x : [0..L+2]; y : [0..{width}]; [go] x<L -> (x'=x+1);\n\
        [flip] x=L -> 0.5: (x'=L+1) + 0.5: (x'=L+2); endmodule init x=0 endinit"
    );
    let program = parsed(text);
    let text = "objective B = F x=L+1; objective C = F x=L+2;";
    let lang::Task { program, preferences } =
        lang::load_preferences(&SourceFile::new("p", text), program).unwrap();
    (Arc::new(program), Arc::new(preferences))
}

fn explicit(program: &Arc<Program>, settings: Settings) -> Result<Arc<ExplicitEngine>> {
    ExplicitEngine::new(program.clone(), settings).map(Arc::new)
}

fn symbolic(program: &Arc<Program>, settings: Settings) -> Result<Arc<SymbolicEngine>> {
    SymbolicEngine::new(program.clone(), Settings { order: Order::Declared, ..settings }).map(Arc::new)
}

fn settings(sink: &Arc<Patience>) -> Settings {
    Settings { memory: 64 << 20, sink: sink.clone(), ..Settings::default() }
}

type Build<E> = fn(&Arc<Program>, Settings) -> Result<Arc<E>>;

/// Every fixpoint over the ways needs a look at the progress sink, which now wants the work to end.
fn no_fixpoint_goes_on<E: Engine>(size: Size, build: Build<E>) {
    let (program, preferences) = ways(size);
    let sink = Patience::new(u64::MAX);
    let engine = build(&program, settings(&sink)).unwrap();
    let (all, choices) = (engine.all_states(), engine.all_choices());
    let last = engine.states_where(preferences.objectives[0].target().unwrap()).unwrap();
    let others = engine.difference(&all, &last).unwrap();
    let moving = engine.choices_in(&choices, &others).unwrap();
    let none = engine.no_states();
    let edge_labels = |goal: &E::States| EdgeLabels::new(others.clone(), goal.clone(), none.clone());
    let dropping = [EdgeLabels::new(last.clone(), none.clone(), others.clone())];
    let game = || Region { states: others.clone(), choices: moving.clone() };
    sink.allowed.store(0, Relaxed);
    stopped("can_reach", engine.can_reach(&last, &choices, &[]));
    stopped("can_reach", engine.can_reach(&last, &choices, &dropping));
    stopped("stay_within", engine.stay_within(&others, &choices));
    stopped("almost_surely_reach", engine.almost_surely_reach(&last, &choices));
    stopped("almost_surely_win", engine.almost_surely_win(game(), &[edge_labels(&last)]));
    stopped("pmax_one", regions::pmax_one(&*engine, &last));
    stopped("pmin_positive", regions::pmin_positive(&*engine, &last));
    stopped("regions", regions::regions(&*engine, &last));
    stopped("build", build(&program, settings(&sink)));
}

#[track_caller]
fn stopped<T>(what: &str, result: Result<T>) {
    match result {
        Err(Error::Limit(limit)) => assert_eq!(limit, Limit::Interrupted, "{what}"),
        Err(other) => panic!("{what}: {other}"),
        Ok(_) => panic!("{what} went on"),
    }
}

#[test]
fn no_fixpoint_of_the_explicit_engine_goes_on() {
    no_fixpoint_goes_on(LARGE, explicit);
}

#[test]
fn no_fixpoint_of_the_symbolic_engine_goes_on() {
    no_fixpoint_goes_on(SMALL, symbolic);
}

/// Does all work from building the engine to random runs; returns the parts that were finished.
fn everything<E: Engine>(
    (program, preferences): &(Arc<Program>, Arc<Preferences>),
    build: Build<E>,
    sink: &Arc<Patience>,
    finished: &mut Vec<(&'static str, u64)>,
) -> Result<()> {
    let mut done = |what| finished.push((what, sink.asked.load(Relaxed)));
    let engine = build(program, settings(sink))?;
    done("build");
    let mut analysis = Analysis::new(&engine, preferences, Options::default());
    analysis.run_phase(Phase::Outcomes, &mut |_| ())?;
    done("outcomes");
    analysis.run_phase(Phase::Improvement, &mut |_| ())?;
    analysis.run_phase(Phase::Sasi, &mut |_| ())?;
    analysis.run_phase(Phase::Spi, &mut |_| ())?;
    done("levels");
    let Some(mut strategy) = FiniteMemoryStrategy::new(&analysis, program, Kind::Sasi) else { return Ok(()) };
    let memory = strategy.start(&[0, 0]).unwrap();
    strategy.strategy(memory)?;
    done("strategy");
    strategy.explain(&[0, 0], memory)?;
    done("explanation");
    let setup = Setup { scheduler: Scheduler::Progress, runs: 2, steps: 10, seed: 1 };
    Simulation::new(&mut strategy, setup).run(&[0, 0])?;
    done("simulation");
    Ok(())
}

/// The work tells of its phases; wherever it is ended, it ends with that, and asks no more.
fn each_answer_is_obeyed<E: Engine>(size: Size, build: Build<E>, phases: &[&str]) {
    let case = ways(size);
    let (sink, mut finished) = (Patience::new(u64::MAX), Vec::new());
    everything(&case, build, &sink, &mut finished).unwrap();
    assert_eq!(finished.len(), 6, "{finished:?}");
    assert!(finished.windows(2).all(|w| w[0].1 < w[1].1), "a phase never asks: {finished:?}");
    let told = phases.iter().copied().chain(["runs"]);
    assert_eq!(*sink.heard.lock().unwrap(), told.collect());
    let questions = sink.asked.load(Relaxed);
    for allowed in (0..questions).step_by(questions as usize / 60 + 1).chain([questions - 1]) {
        let sink = Patience::new(allowed);
        stopped("everything", everything(&case, build, &sink, &mut Vec::new()));
        assert_eq!(sink.asked.load(Relaxed), allowed + 1, "of {questions} questions");
    }
}

#[test]
fn the_explicit_engine_obeys_each_answer() {
    each_answer_is_obeyed(LARGE, explicit, &["reachable states", "fixpoints"]);
}

#[test]
fn the_symbolic_engine_obeys_each_answer() {
    each_answer_is_obeyed(
        SMALL,
        symbolic,
        &["reachable states", "backward reachability", "attractor removal"],
    );
}

/// A stopped analysis continues where it was, and ends with the same result.
fn the_rest_can_be_done_later<E: Engine>(size: Size, build: Build<E>) {
    let (program, preferences) = ways(size);
    let sink = Patience::new(u64::MAX);
    let engine = build(&program, settings(&sink)).unwrap();
    let mut whole = Analysis::new(&engine, &preferences, Options::default());
    let before = sink.asked.load(Relaxed);
    whole.run(&mut |_| ()).unwrap();
    for more in (0..sink.asked.load(Relaxed) - before).rev() {
        let engine = build(&program, settings(&sink)).unwrap();
        let mut analysis = Analysis::new(&engine, &preferences, Options::default());
        sink.allowed.store(sink.asked.load(Relaxed) + more, Relaxed);
        let first = analysis.run(&mut |_| ());
        sink.allowed.store(u64::MAX, Relaxed);
        stopped("run", first);
        analysis.run(&mut |_| ()).unwrap();
        assert_eq!(analysis.result(), whole.result(), "stopped after {more} questions");
    }
}

#[test]
fn the_explicit_engine_can_do_the_rest_later() {
    the_rest_can_be_done_later(LARGE, explicit);
}

#[test]
fn the_symbolic_engine_can_do_the_rest_later() {
    the_rest_can_be_done_later(SMALL, symbolic);
}
