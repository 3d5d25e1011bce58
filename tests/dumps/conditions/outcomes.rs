//! Targets, positive and almost-sure regions, classes.
//!
//! B is almost sure everywhere and preferred to A, so that A decides no class: a fault in its sets has no effect on
//! classes and levels.

use meliora::planning::Safety;

use super::draft::Draft;
use super::{Fault, HISTORIES, cases};

/// State 1 is the target and state 2 a trap. The only choice of state 3 leads to either by chance.
const MODEL: &str = "mdp module m s:[0..3] init 0;
      [go] s=0 -> (s'=1); [risk] s=0 -> 0.5:(s'=1) + 0.5:(s'=2); [detour] s=0 -> (s'=3);
      [toss] s=3 -> 0.5:(s'=1) + 0.5:(s'=2); [stay] s=1 | s=2 -> true;
    endmodule";
const PREFERENCES: &str = "objective A = F s=1; objective B = F s>=0; prefer B > A;";

#[test]
fn each_condition_on_targets_is_needed() {
    let cases = |history: &str| cases(MODEL, PREFERENCES, &[history], Safety::ALL);
    let fault = |condition| -> Fault { (condition, |d| d.set("target:A", [].into())) };
    cases("history = state;").refuse(&[fault("`target:A` are the states in which the target holds")]);
    cases("history = play;").refuse(&[fault("`target:A` are the states in which the objective is secured")]);
}

/// Makes the positive region empty.
fn unreachable(draft: &mut Draft) {
    draft.set("positive:A", [].into());
    draft.layers("positive:A", &[]);
}

#[test]
fn each_condition_on_positive_regions_is_needed() {
    cases(MODEL, PREFERENCES, &HISTORIES, Safety::ALL).refuse(&[
        ("each state of the target is in `positive:A`", unreachable),
        ("each state with a step into `positive:A` is in it", |d| {
            d.set("positive:A", d.get("target:A"));
            d.layers("positive:A", &[&d.get("target:A")]);
        }),
        ("each state of `positive:A` is in one of its layers", |d| d.add("positive:A", &d.states(&[2]))),
        ("layer 0 of `positive:A` are the states at its goal", |d| {
            d.add("positive:A", &d.states(&[2]));
            d.add("layers:positive:A:0", &d.states(&[2]));
        }),
        ("each state in layer 1 of `positive:A` has a step into an earlier layer", |d| {
            d.set_trend("layers:positive:A:1", None);
            d.add("positive:A", &d.states(&[2]));
            d.add("layers:positive:A:1", &d.states(&[2]));
        }),
    ]);
}

/// Makes the almost-sure region the target alone.
fn only_the_target(draft: &mut Draft) {
    let target = draft.get("target:A");
    draft.layers("almost-sure:A", &[&target]);
    draft.set("almost-sure:A", target);
    draft.set("strategy:almost-sure:A", [].into());
}

#[test]
fn each_condition_on_almost_sure_regions_is_needed() {
    cases(MODEL, PREFERENCES, &HISTORIES, Safety::ALL).refuse(&[
        ("no state lost in round 0 of `almost-sure:A` is in the target", |d| {
            only_the_target(d);
            let target = d.get("target:A");
            d.rounds("almost-sure:A", &[&target, &d.others(&target)]);
        }),
        ("no state lost in round 0 of `almost-sure:A` has a safe step out of the round", |d| {
            only_the_target(d);
            d.rounds("almost-sure:A", &[&d.others(&d.get("target:A"))]);
        }),
        ("each state outside of `almost-sure:A` is lost in some round", |d| {
            only_the_target(d);
            d.rounds("almost-sure:A", &[]);
        }),
        ("`strategy:almost-sure:A` are the choices that stay in `almost-sure:A`", |d| {
            d.add("strategy:almost-sure:A", &d.choices("risk", 0))
        }),
        ("each state of `almost-sure:A` is in one of its layers", |d| {
            d.add("almost-sure:A", &d.states(&[3]));
            d.add("strategy:almost-sure:A", &d.choices("detour", 0));
            d.rounds("almost-sure:A", &[&d.states(&[2])]);
        }),
    ]);
}

/// The other conditions imply this one, which is reported first.
#[test]
fn an_almost_sure_region_without_its_target_is_refused() {
    let condition = "each state of the target is in `almost-sure:A`";
    let forge = |d: &mut Draft| {
        d.set("almost-sure:A", [].into());
        d.set("strategy:almost-sure:A", [].into());
        d.layers("almost-sure:A", &[]);
        d.rounds("almost-sure:A", &[&d.get("reachable")]);
    };
    cases(MODEL, PREFERENCES, &HISTORIES, Safety::ALL).refuse(&[(condition, forge)]);
}

/// An empty layer or round, or a state that is lost twice, proves nothing false, but `export` never writes it.
#[test]
fn layers_and_rounds_have_states_and_rounds_are_disjoint() {
    cases(MODEL, PREFERENCES, &HISTORIES, Safety::ALL).refuse(&[
        ("layer 2 of `positive:A` has a state", |d| d.set("layers:positive:A:2", [].into())),
        ("round 2 of `almost-sure:A` has a state", |d| d.set("refuted:almost-sure:A:2", [].into())),
        ("no state lost in round 1 of `almost-sure:A` was lost before", |d| {
            d.add("refuted:almost-sure:A:1", &d.get("refuted:almost-sure:A:0"))
        }),
    ]);
}

#[test]
fn each_condition_on_classes_is_needed() {
    cases(MODEL, PREFERENCES, &HISTORIES, Safety::ALL).refuse(&[
        ("`class:B` are the states with these most preferred outcomes", |d| {
            d.take("class:B", &d.states(&[0]))
        }),
        ("`class:nothing` has no state", |d| d.set("class:nothing", d.states(&[0]))),
    ]);
}
