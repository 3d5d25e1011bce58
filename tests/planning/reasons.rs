//! The reasons that explanations give for actions.

use meliora::planning::explain::Action;
use meliora::planning::explain::Verdict::{
    self, Approaches, Hopeless, Improves, MayImprove, NothingAhead, Stays, Strays, Weakens,
};
use meliora::planning::{FiniteMemoryStrategy, Kind, Safety};

use crate::loaded::Loaded;

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
