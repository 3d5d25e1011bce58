//! The secured regions of temporal objectives.
//!
//! B is almost sure everywhere and preferred to A, so that A decides no class.

use meliora::planning::Safety;

use super::draft::{Draft, Members};
use super::{Cases, Fault, cases};

const HISTORY: &[&str] = &["history = play;"];

/// State 0 is left at once, and state 1 is never left.
const LEFT: &str = "mdp module m s:[0..1] init 0; [go] true -> (s'=1); endmodule";
/// The same, but a choice stays in state 0.
const CHOSEN: &str =
    "mdp module m s:[0..1] init 0; [stay] s=0 -> true; [go] s=0 -> (s'=1); [end] s=1 -> true; endmodule";

fn under(model: &str, formula: &str) -> Cases {
    let preferences = format!("objective A = {formula}; objective B = F s>=0; prefer B > A;");
    cases(model, &preferences, HISTORY, Safety::ALL)
}

/// Replaces the secured region, the layers towards its only mark, and the rounds of the other states.
fn secure(draft: &mut Draft, region: &Members, layers: &[&Members], rounds: &[&Members]) {
    draft.set("secured:A:1", region.clone());
    draft.set("target:A", region.clone());
    draft.layers("secured:A:1:1", layers);
    draft.rounds("secured:A:1", rounds);
}

/// Makes the positive and the almost-sure region the union of these layers.
fn reach(draft: &mut Draft, layers: &[&Members], strategy: Members) {
    let all = layers.iter().fold(Members::new(), |all, layer| &all | layer);
    draft.rounds("almost-sure:A", &[&draft.others(&all)]);
    if draft.others(&all).is_empty() {
        draft.rounds("almost-sure:A", &[]);
    }
    for name in ["positive:A", "almost-sure:A"] {
        draft.set(name, all.clone());
        draft.layers(name, layers);
    }
    draft.set("strategy:almost-sure:A", strategy);
}

/// Makes the secured region and all that follows from it empty.
fn nothing(draft: &mut Draft, rounds: &[&Members]) {
    secure(draft, &Members::new(), &[], rounds);
    draft.set("strategy:secured:A:1", [].into());
    reach(draft, &[], [].into());
}

#[test]
fn a_region_that_is_left_is_refused() {
    let condition = "each state of `secured:A:1` has a choice that stays in it";
    let forge = |d: &mut Draft| {
        let (first, last) = (d.states(&[0]), d.states(&[1]));
        secure(d, &first, &[&first], &[&last]);
        reach(d, &[&first], [].into());
    };
    under(LEFT, "G F s=0").refuse(&[(condition, forge)]);
}

#[test]
fn a_region_without_what_is_always_asked_is_refused() {
    let condition = "each state of `secured:A:1` satisfies the conditions that must always hold there";
    let forge = |d: &mut Draft| {
        let all = d.get("reachable");
        secure(d, &all, &[], &[]);
        d.set("strategy:secured:A:1", d.get("choices"));
        reach(d, &[&all], [].into());
    };
    under(LEFT, "F G s=0").refuse(&[(condition, forge)]);
}

#[test]
fn a_region_from_where_a_mark_is_not_reached_is_refused() {
    let condition = "each state of `secured:A:1:1` is in one of its layers";
    let forge = |d: &mut Draft| {
        let all = d.get("reachable");
        secure(d, &all, &[&d.states(&[0])], &[]);
        d.set("strategy:secured:A:1", d.get("choices"));
        reach(d, &[&all], [].into());
    };
    let layers: Fault = ("layer 0 of `secured:A:1:1` are the states at its goal", |d| {
        let all = d.get("reachable");
        secure(d, &all, &[&all], &[]);
        d.set("strategy:secured:A:1", d.get("choices"));
        reach(d, &[&all], [].into());
    });
    under(CHOSEN, "G F s=0").refuse(&[(condition, forge), layers]);
}

#[test]
fn a_strategy_that_leaves_its_region_is_refused() {
    let condition = "`strategy:secured:A:1` are the choices that stay in `secured:A:1`";
    let more = |d: &mut Draft| d.add("strategy:secured:A:1", &d.choices("go", 0));
    let fewer = |d: &mut Draft| d.take("strategy:secured:A:1", &d.choices("stay", 0));
    under(CHOSEN, "G F s=0").refuse(&[(condition, more), (condition, fewer)]);
}

#[test]
fn a_region_that_is_too_small_is_refused() {
    let faults: &[Fault] = &[
        (
            "paths that stay in round 0 of `secured:A:1` violate a condition that must hold infinitely often",
            |d| nothing(d, &[&d.get("reachable")]),
        ),
        ("each state outside of `secured:A:1` is lost in some round", |d| nothing(d, &[])),
    ];
    under(CHOSEN, "G F s=0").refuse(faults);
    under(CHOSEN, "F G s=0").refuse(faults);
    let condition = "no state lost in round 0 of `secured:A:1` has a safe step out of the round";
    let forge = |d: &mut Draft| {
        let (first, last) = (d.states(&[0]), d.states(&[1]));
        secure(d, &last, &[&last], &[&first]);
        d.set("strategy:secured:A:1", d.choices("go", 1));
        reach(d, &[&last, &first], d.choices("go", 0));
    };
    under(LEFT, "G F s=1").refuse(&[(condition, forge)]);
}
