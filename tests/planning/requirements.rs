//! Requirements: unsafe states, the path to a violation, and reasons.

use meliora::planning::explain::Verdict;
use meliora::planning::result::EscapeStep;
use meliora::{Choose, Wanted};

use crate::common::prelude::*;

const MODEL: &str = "mdp
    module m x : [0..6] init 0;
      [on] x=0 -> (x'=1); [wait] x=0 -> true; [quick] x=0 -> 1/2: (x'=3) + 1/2: (x'=6);
      [left] x=1 -> 1/2: (x'=1) + 1/2: (x'=2); [right] x=1 -> 1/2: (x'=1) + 1/2: (x'=4);
      [fall] x=2 -> (x'=5); [fall] x=4 -> (x'=2);
    endmodule";

fn analysis(storage: Storage, preferences: &str) -> (Analysis, Arc<Program>) {
    let (program, preferences) = task(MODEL, preferences);
    let settings = Settings { storage, memory: 16 << 20, ..Settings::default() };
    let engine = Arc::new(AnyEngine::new(Arc::clone(&program), settings).unwrap());
    let analysis = finished(&engine, &preferences, Options::default());
    (analysis, program)
}

/// The states of a path as texts, each followed by its action.
fn shown(path: &[EscapeStep]) -> String {
    let step =
        |EscapeStep { state, action }: &EscapeStep| format!("{state} {}", action.as_deref().unwrap_or("end"));
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

/// The forbidden way is more likely to succeed than the other one.
const TEMPTING: &str = "mdp module m s:[0..3] init 0;
    [b] s=0 -> 1/4:(s'=1)+3/4:(s'=2); [a] s=0 -> 1/2:(s'=1)+1/2:(s'=3); [back] s=3 -> (s'=1);
    endmodule";

fn tempting(storage: Storage, safety: Safety) -> meliora::Analysis {
    let settings = Settings { storage, memory: 16 << 20, ..Settings::default() };
    let explored = meliora::Model::parse(TEMPTING, "").unwrap().explore(settings).unwrap();
    let wishes = SourceFile::new("wishes", "objective A = F s=1; require G !(s=3);");
    let mut analysis = explored.prefer(&wishes, Options { safety, ..Options::default() }).unwrap();
    analysis.run(&mut |_| ()).unwrap();
    analysis
}

#[test]
fn values_do_not_count_choices_that_the_requirements_forbid() {
    for storage in [Storage::Symbolic, Storage::Explicit] {
        for &safety in Safety::ALL {
            let found = tempting(storage, safety);
            for exact in [false, true] {
                let wanted = Wanted { exact, within: Some(2), ..Wanted::default() };
                let at = found.state_values(&[vec![0]], &wanted).unwrap().remove(0);
                let level = &at.levels[0];
                assert_eq!((level.probability.lower, level.probability.upper), (0.25, 0.25));
                let actions: Vec<&str> = level.actions.iter().map(|a| a.action.as_str()).collect();
                assert_eq!(actions, ["b"], "{safety}");
                assert_eq!(level.within.as_deref(), Some(&[0.0, 0.25, 0.25][..]));
                let at = found.state_values(&[vec![3]], &wanted).unwrap().remove(0);
                assert!(at.is_unsafe && at.levels.is_empty() && at.number.is_none());
            }
        }
    }
}

#[test]
fn the_likely_strategy_takes_a_permitted_action_and_runs_stay_safe() {
    for storage in [Storage::Symbolic, Storage::Explicit] {
        for &safety in Safety::ALL {
            let found = tempting(storage, safety);
            let mut strategy = found.strategy(Kind::Spi).unwrap();
            let start = [vec![0]];
            found.choose_by(&mut strategy, Choose::Likely, &start, &Wanted::default()).unwrap();
            let memory = strategy.start(&[0]).unwrap();
            let at = strategy.explain(&[0], memory).unwrap();
            let pick = &at.actions[at.pick.unwrap()];
            assert!(pick.name == "b" && pick.permitted && pick.kept, "{pick:?}");
            let setup = Setup { scheduler: Scheduler::Progress, runs: 1000, steps: 5, seed: 1 };
            let tally = Simulation::new(&mut strategy, setup).run(&[0]).unwrap();
            assert_eq!(tally.entered_unsafe, 0, "{safety}");
        }
    }
}

#[test]
fn a_step_from_or_to_an_unsafe_state_neither_improves_nor_weakens() {
    for storage in [Storage::Symbolic, Storage::Explicit] {
        for &safety in Safety::ALL {
            let found = tempting(storage, safety);
            let mut strategy = found.strategy(Kind::Spi).unwrap();
            for (state, action) in [(0, 1), (3, 0)] {
                let memory = strategy.start(&[state]).unwrap();
                let at = strategy.explain(&[state], memory).unwrap();
                for step in at.actions[action].successors.iter().filter(|s| at.is_unsafe || s.is_unsafe) {
                    assert_eq!(step.change, Change::Lateral, "{safety} {state}");
                    assert!(!step.improves && !step.goal && step.gained.is_empty() && step.lost.is_empty());
                }
                // The step to s=1 improves, but by an action that is not kept.
                assert!(at.actions[action].successors.iter().all(|s| !s.goal), "{safety} {state}");
            }
            let memory = strategy.start(&[0]).unwrap();
            let (after, improves) = strategy.after(memory, &[0], &[3]).unwrap();
            assert_eq!((after.level, after.arena, improves), (Rank::Finite(0), None, false));
        }
    }
}

/// The results of a model under some requirements for whole paths.
fn of_requirements(storage: Storage, requirements: &str) -> (Analysis, Arc<Program>) {
    analysis(storage, &format!("objective A = F x=3; history = play; {requirements}"))
}

#[test]
fn several_requirements_are_one_formula_their_conjunction() {
    for storage in [Storage::Symbolic, Storage::Explicit] {
        for (lines, one) in [
            ("require G (x=0 => X x!=6); require X X x!=2;", "require (G (x=0 => X x!=6)) & (X X x!=2);"),
            ("require X x=1; require X x!=1;", "require (X x=1) & (X x!=1);"),
            ("require G x!=5; require X x!=6;", "require (G x!=5) & (X x!=6);"),
            ("require G x!=5; require G x<6;", "require (G x!=5) & (G x<6);"),
        ] {
            let [(ours, program), (theirs, other)] = [lines, one].map(|text| of_requirements(storage, text));
            assert_eq!(ours.result(), theirs.result(), "{lines}");
            let starts = ours.whole_engine().list_states(&ours.whole_engine().initial_states(), 9).unwrap();
            let ours = ours.escape(&program, &starts[0]).unwrap();
            let theirs = theirs.escape(&other, &starts[0]).unwrap();
            assert_eq!(ours.map(|e| e.path), theirs.map(|e| e.path), "{lines}");
        }
    }
}

#[test]
fn the_path_ends_where_no_continuation_keeps_all_requirements_together() {
    for storage in [Storage::Symbolic, Storage::Explicit] {
        let path = |requirements: &str| {
            let (found, program) = of_requirements(storage, requirements);
            let engine = found.whole_engine();
            let start = engine.list_states(&engine.initial_states(), 1).unwrap().remove(0);
            let escape = found.escape(&program, &start).unwrap().unwrap();
            let x = |step: &EscapeStep| step.state.to_string().split(',').next().unwrap().to_owned();
            (escape.path.iter().map(x).collect::<Vec<_>>(), escape.violated)
        };
        // Each alone can still be kept after the first state.
        let (states, violated) = path("require X x=1; require X x!=1;");
        assert_eq!(states, ["x=0"]);
        assert_eq!(violated.as_deref(), Some("(X x=1) & (X x!=1)"));
        // The second state decides, not the one after it.
        let (states, violated) = path("require G (x=0 => X x=5);");
        assert_eq!(states.len(), 2, "{states:?}");
        assert_eq!(violated.as_deref(), Some("G (x=0 => X x=5)"));
        let (states, violated) = path("require G x!=0; require X x!=1;");
        assert_eq!(states, ["x=0"]);
        assert_eq!(violated.as_deref(), Some("G x!=0"));
    }
}

#[test]
fn the_violated_formula_keeps_its_outer_brackets() {
    let (found, program) = analysis(Storage::Explicit, "objective A = F x=3; require (G x!=5) & (G x!=0);");
    let escape = found.escape(&program, &[0]).unwrap().unwrap();
    assert_eq!(escape.violated.as_deref(), Some("(G x!=5) & (G x!=0)"));
}
