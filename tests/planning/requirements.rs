//! Requirements: unsafe states, the path to a violation, and reasons.

use std::sync::Arc;

use meliora::engine::{AnyEngine, Engine, Settings, Storage};
use meliora::error::SourceFile;
use meliora::lang;
use meliora::model::Program;
use meliora::model::valuation::Valuation;
use meliora::planning::explain::Verdict;
use meliora::planning::{Analysis, FiniteMemoryStrategy, Kind, Options, Rank, Scheduler, Setup, Simulation};

const MODEL: &str = "mdp
    module m x : [0..6] init 0;
      [on] x=0 -> (x'=1); [wait] x=0 -> true; [quick] x=0 -> 1/2: (x'=3) + 1/2: (x'=6);
      [left] x=1 -> 1/2: (x'=1) + 1/2: (x'=2); [right] x=1 -> 1/2: (x'=1) + 1/2: (x'=4);
      [fall] x=2 -> (x'=5); [fall] x=4 -> (x'=2);
    endmodule";

fn analysis(storage: Storage, preferences: &str) -> (Analysis, Arc<Program>) {
    let none = SourceFile::new("--const", "");
    let mut program = lang::load(&SourceFile::new("m", MODEL), &none).unwrap().program;
    let preferences = lang::load_preferences(&SourceFile::new("p", preferences), &mut program).unwrap();
    let program = Arc::new(program);
    let settings = Settings { storage, memory: 16 << 20, ..Settings::default() };
    let engine = Arc::new(AnyEngine::new(Arc::clone(&program), settings).unwrap());
    let mut analysis = Analysis::new(&engine, &Arc::new(preferences), Options::default());
    analysis.run(&mut |_| ()).unwrap();
    (analysis, program)
}

/// The states of a path as texts, each followed by its action.
fn shown(path: &[(Valuation, Option<String>)]) -> String {
    let step = |(state, action): &(Valuation, Option<String>)| {
        format!("{state} {}", action.as_deref().unwrap_or("end"))
    };
    path.iter().map(step).collect::<Vec<_>>().join(", ")
}

#[test]
fn a_shortest_path_leads_through_states_that_cannot_avoid_the_violation() {
    for storage in [Storage::Symbolic, Storage::Explicit] {
        let (found, program) = analysis(storage, "objective A = F x=3; require G x<7; require G x!=5;");
        let engine = found.whole_engine();
        let unsafe_states = &found.requirements().unwrap().unsafe_states;
        let listed = engine.list_states(unsafe_states, 10).unwrap();
        assert_eq!(listed, [[1], [2], [4], [5]]);
        // A step of `on` would be shorter than the way over 4, but each is a path without a way out.
        let escape = found.escape(&program, &[4]).unwrap().unwrap();
        assert_eq!(shown(&escape.path), "x=4 fall, x=2 fall, x=5 end");
        assert_eq!(escape.violated.as_deref(), Some("G x!=5"));
        let escape = found.escape(&program, &[1]).unwrap().unwrap();
        assert_eq!(shown(&escape.path), "x=1 left, x=2 fall, x=5 end");
        assert_eq!(found.escape(&program, &[0]).unwrap(), None);
    }
}

#[test]
fn a_deadlock_that_violates_nothing_keeps_the_requirements() {
    for storage in [Storage::Symbolic, Storage::Explicit] {
        let (found, _) = analysis(storage, "objective A = F x=3; require G x!=5;");
        assert!(!found.is_unsafe(&[3]).unwrap() && !found.is_unsafe(&[6]).unwrap());
        assert!(found.is_unsafe(&[5]).unwrap(), "the deadlock in 5 violates");
    }
}

#[test]
fn an_unsafe_state_has_no_class_no_rank_and_no_run() {
    for storage in [Storage::Symbolic, Storage::Explicit] {
        let (found, program) = analysis(storage, "objective A = F x=3; objective B = F x=5; require G x!=5;");
        let classes = found.classes().unwrap();
        assert_eq!(classes.of(found.engine(), &[1]).unwrap(), None);
        assert_eq!(found.rank(Kind::Spi, &[1]).unwrap(), Rank::Finite(0));
        assert_eq!(found.result().objectives[1].positive, 0u32.into());
        let mut strategy = FiniteMemoryStrategy::new(&found, &program, Kind::Spi).unwrap();
        let memory = strategy.start(&[1]).unwrap();
        let at = strategy.explain(&[1], memory).unwrap();
        assert!(at.is_unsafe && at.actions.iter().all(|a| a.verdict == Verdict::Violates(None)));
        let memory = strategy.start(&[0]).unwrap();
        let at = strategy.explain(&[0], memory).unwrap();
        assert_eq!((at.actions[0].verdict, at.actions[0].kept), (Verdict::Violates(Some(0)), false));
        assert!(at.actions[2].permitted, "the quick way keeps the requirement");
        let setup = Setup { scheduler: Scheduler::Progress, runs: 3, steps: 5, seed: 1 };
        let tally = Simulation::new(&mut strategy, setup).run(&[1]).unwrap();
        assert!(tally.is_unsafe && tally.trace.turns.is_empty());
    }
}

#[test]
fn sets_of_the_restricted_model_are_sets_of_the_whole_one() {
    for storage in [Storage::Symbolic, Storage::Explicit] {
        let (found, _) = analysis(storage, "objective A = F x=3; require G x!=5;");
        let found = meliora::Analysis::from(found);
        let (whole, part) = (found.whole_engine(), found.engine());
        let again = whole.restricted_to(&meliora::engine::Region {
            states: part.all_states(),
            choices: part.all_choices(),
        });
        assert!(part.shares(&again.unwrap()) && part.shares(whole));
        assert!(found.region("unsafe").unwrap().contains(&[2]).unwrap());
        assert!(found.exploration().states().contains(&[2]).unwrap());
        assert_eq!(found.region_names()[0], "unsafe");
    }
}
