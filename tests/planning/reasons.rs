//! The reasons that explanations give for actions.

use meliora::planning::explain::Verdict::{
    self, Approaches, Hopeless, Improves, MayImprove, NothingAhead, Stays, Strays, Weakens,
};
use meliora::planning::explain::{Action, Explanation};

use crate::common::prelude::*;
use crate::planning::loaded::Loaded;

/// From 1 a random step achieves A at 2 or B at 3; nothing is achieved at 4.
fn decision() -> Loaded {
    Loaded::new(
        "mdp module m x : [0..4] init 0;\n\
         [near] x=0 -> (x'=1);\n\
         [wait] x<2 -> true;\n\
         [sure] x=1 -> 0.5:(x'=2) + 0.5:(x'=3);\n\
         [may] x=1 -> 0.25:(x'=2) + 0.25:(x'=3) + 0.5: true;\n\
         [stray] x=1 -> 0.5:(x'=2) + 0.5:(x'=4);\n\
         [die] x=1 -> (x'=4);\n\
         [rest] x=2 -> true;\n\
         [back] x=2 -> 0.5: true + 0.5:(x'=4);\n\
         endmodule",
        "objective A = F x=2; objective B = F x=3; empty = bottom;",
    )
}

/// The reason for an action; a successor is named by its value of `x` instead of its position.
fn reason(action: &Action) -> Verdict {
    let x = |position: usize| action.successors[position].state[0] as usize;
    match action.verdict {
        Weakens(position) => Weakens(x(position)),
        Strays(position) => Strays(x(position)),
        other => other,
    }
}

/// Checks the names and the reasons of all actions of a state.
fn check(kind: Kind, x: i64, expected: &[(&str, Verdict)]) {
    let model = decision();
    let analysis = model.analyse(Safety::Action, None);
    let mut strategy = FiniteMemoryStrategy::new(&analysis, &model.program, kind).unwrap();
    let memory = strategy.start(&[x]).unwrap();
    let actions = strategy.explain(&[x], memory).unwrap().actions;
    let found: Vec<(&str, Verdict)> = actions.iter().map(|a| (a.name.as_str(), reason(a))).collect();
    assert_eq!(found, expected, "{kind}: x={x}");
}

#[test]
fn each_action_has_its_reason() {
    for &kind in Kind::ALL {
        check(kind, 0, &[("near", Approaches), ("wait", Stays)]);
        check(kind, 2, &[("rest", NothingAhead), ("back", Weakens(4))]);
    }
    let common = [("wait", Stays), ("sure", Improves), ("may", MayImprove)];
    check(Kind::Sasi, 1, &[&common[..], &[("stray", Strays(4)), ("die", Strays(4))]].concat());
    check(Kind::Spi, 1, &[&common[..], &[("stray", MayImprove), ("die", Hopeless)]].concat());
}

/// Returns the first verdict that applies, in the order of `docs/json.md`.
fn first_that_applies(kind: Kind, at: &Explanation, action: &Action) -> &'static str {
    let mut kept = action.successors.iter().filter(|s| !s.dropped);
    let any = |is: &dyn Fn(&meliora::planning::explain::Successor) -> bool| action.successors.iter().any(is);
    let order = [
        ("improves", action.permitted && kept.clone().all(|s| s.goal)),
        ("may-improve", action.permitted && kept.clone().any(|s| s.goal)),
        ("approaches", action.permitted && action.progress),
        ("stays", action.permitted),
        ("violates", at.is_unsafe || any(&|s| s.is_unsafe)),
        ("weakens", !action.kept && any(&|s| s.change == Change::Weakening)),
        ("unsafe", !action.kept),
        ("nothing-ahead", at.memory.level == Rank::Finite(0)),
        ("strays", kind == Kind::Sasi && kept.any(|s| !s.goal && !s.stays)),
        ("hopeless", true),
    ];
    order.into_iter().find(|(_, applies)| *applies).unwrap().0
}

/// A model of nine states with random branches, a requirement, and wishes about some of them.
fn drawn(seed: u64) -> Loaded {
    let random = &mut SmallRng::seed_from_u64(seed);
    let mut text = "mdp module m s : [0..8] init 0;\n".to_owned();
    for state in 0..9 {
        for action in ["a", "b", "c"].iter().take(random.random_range(1..4)) {
            let low = if random.random_bool(0.8) { state } else { 0 };
            let [one, other] = [0; 2].map(|_| random.random_range(low..9));
            text += &format!("[{action}] s={state} -> 1/2: (s'={one}) + 1/2: (s'={other});\n");
        }
    }
    let require = ["", "require G !(s=8);"][usize::from(random.random_bool(0.5))];
    Loaded::new(
        &(text + "endmodule"),
        &format!(
            "objective A = F s=5; objective B = F s=6; objective C = F s=7; objective D = F s=4; \
             prefer A, B > C; prefer D > B; {require}"
        ),
    )
}

#[test]
fn a_verdict_is_the_first_that_applies_in_the_documented_order() {
    let mut seen = BTreeMap::<&str, usize>::new();
    for seed in 0..200 {
        let model = drawn(seed);
        for safety in [Safety::Action, Safety::Transition, Safety::Prefix] {
            let analysis = model.analyse(safety, None);
            for &kind in Kind::ALL {
                let mut strategy = FiniteMemoryStrategy::new(&analysis, &model.program, kind).unwrap();
                for state in (0..9).map(|s| [s]) {
                    if !strategy.is_state(&state).unwrap() {
                        continue;
                    }
                    let memory = strategy.start(&state).unwrap();
                    let at = strategy.explain(&state, memory).unwrap();
                    for action in &at.actions {
                        let expected = first_that_applies(kind, &at, action);
                        let name = &action.name;
                        assert_eq!(action.verdict.name(), expected, "seed {seed}, {kind}, {state:?}, {name}");
                        *seen.entry(expected).or_default() += 1;
                    }
                }
            }
        }
    }
    assert_eq!(seen.len(), 10, "{seen:?}");
}

/// The step from 1 to 2 is lateral for the class of 1, and improves the class of the start, 0.
#[test]
fn a_change_under_prefix_is_relative_to_the_reference() {
    let model = Loaded::new(
        "mdp module m s : [0..3] init 0; [go] s=0 -> (s'=1); [try] s=1 -> 1/2:(s'=2) + 1/2:(s'=3); \
         [rest] s>1 -> true; endmodule",
        "objective Low = F s=0; objective Side = F s=1; objective High = F s=2; objective Other = F s=3; \
         prefer High, Other > Low;",
    );
    for (safety, expected) in [(Safety::Prefix, Change::Improving), (Safety::Action, Change::Lateral)] {
        let analysis = model.analyse(safety, None);
        let mut strategy = FiniteMemoryStrategy::new(&analysis, &model.program, Kind::Sasi).unwrap();
        let start = strategy.start(&[0]).unwrap();
        let (memory, improves) = strategy.after(start, &[0], &[1]).unwrap();
        assert!(!improves);
        let at = strategy.explain(&[1], memory).unwrap();
        let changes: Vec<Change> = at.actions[0].successors.iter().map(|s| s.change).collect();
        assert_eq!(changes, [expected; 2], "{}", safety.name());
        // Gains and losses are compared with the same objectives.
        assert!(at.actions[0].successors.iter().all(|s| s.gained.is_empty() == (safety == Safety::Action)));
    }
}

#[test]
fn a_choice_that_is_not_safe_names_the_successor_that_is_not() {
    // From 1 the path must continue to 2, where A can not be reached any more.
    let text = "mdp module m x : [0..2] init 0; [stay] x=0 -> true; [go] x=0 -> 0.5: true + 0.5: (x'=1);\n\
        [on] x=1 -> (x'=2); endmodule";
    let (program, preferences) = task(text, "objective A = F x=1;");
    let settings = Settings { order: Order::Declared, ..Settings::default() };
    let engine = Arc::new(SymbolicEngine::new(program.clone(), settings).unwrap());
    let options = Options { safety: Safety::Prefix, ..Options::default() };
    let analysis = finished(&engine, &preferences, options);
    let mut strategy = FiniteMemoryStrategy::new(&analysis, &program, Kind::Sasi).unwrap();
    let memory = strategy.start(&[0]).unwrap();
    let actions = strategy.explain(&[0], memory).unwrap().actions;
    let go = actions.iter().find(|a| a.name == "go").unwrap();
    let bad = go.successors.iter().position(|s| s.state == [1]);
    assert_eq!(go.verdict, Verdict::Unsafe(bad));
}
