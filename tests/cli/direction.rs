//! `reach` with a property about the initial states: all valuations, or a guided search, may answer before the states are
//! known.

use crate::common::prelude::*;

/// A shift register of 31 flags that takes 2^31 - 1 steps to return to its first state, and can be left at any time.
pub(crate) fn register() -> String {
    let flag = |i: usize| format!("b{i} : bool init {};", i == 0);
    let shift = |i: usize| format!(" & (b{i}'=b{})", i - 1);
    let (flags, shifts) = ((0..31).map(flag).collect::<String>(), (1..31).map(shift).collect::<String>());
    format!(
        "mdp module m done : bool; {flags} [] !done -> (b0'=(b30!=b2)){shifts}; [] !done -> (done'=true); endmodule"
    )
}

fn asked(property: &str, more: &[&str]) -> Finished {
    let scratch = Scratch::new(&[("m.prism", &register())]);
    scratch.ask(format!("reach m.prism --property '{property}'"), more)
}

#[test]
fn a_property_is_decided_before_the_states_are_known() {
    let cases = [
        ("Pmax>0 [ F done ]", true, json!({"pmax_positive": "all"})),
        ("P>0 [ F done ]", false, json!({"pmin_positive": "none"})),
        ("Pmax>=1 [ G !done ]", true, Json::Null),
    ];
    for (property, holds, initial) in cases {
        let found = asked(property, &["--json"]).expect(i32::from(!holds)).json();
        assert_eq!(found["holds"], holds, "{property}: {found}");
        assert_eq!(found["properties"][0]["holds"], holds);
        assert_eq!((&found["over_all_valuations"], &found["counts"]), (&json!(true), &Json::Null));
        assert_eq!((&found["pmax_one"], &found["engine"]), (&Json::Null, &json!("symbolic")));
        let shares = initial.as_object().into_iter().flatten();
        shares.for_each(|(region, share)| assert_eq!(found["initial"][region], *share, "{property}"));
    }
}

#[test]
fn a_policy_over_all_valuations_visits_reachable_states_only() {
    // The guided search is not made for a command without a meaning in some valuations.
    let partial = register().replace("done : bool;", "done : bool; n : [0..1];");
    let partial = partial.replace("endmodule", "[] n=1 -> (n'=n+1); endmodule");
    let scratch = Scratch::new(&[("m.prism", &partial)]);
    let found = scratch
        .run("reach m.prism --property 'Pmax>=1 [ F done ]' --policy policy.json --json")
        .expect(0)
        .json();
    assert_eq!((&found["over_all_valuations"], &found["plan"]["policy_states"]), (&json!(true), &json!("1")));
    assert_eq!(found["plan"]["strong_cyclic"], json!(true));
    scratch.run("verify policy.json m.prism --target done").expect(0);
    let (none, never) = (scratch.show("none.json"), "Pmax>=1 [ F done & b0 & !b0 ]");
    let found = scratch.run(format!("reach m.prism --property '{never}' --policy '{none}' --json"));
    let found = found.expect(1).json();
    assert_eq!(found["plan"]["strong_cyclic"], json!(false));
}

#[test]
fn the_text_says_that_the_states_are_not_counted() {
    let text = asked("Pmax>0 [ F done ]", &[]).expect(0).stdout;
    assert!(text.contains("The property was decided over all combinations of values"), "{text}");
    assert!(text.contains("The property holds in all initial states."), "{text}");
}

#[test]
fn states_that_are_soon_known_are_counted() {
    let small = register().replace("b30!=b2", "false");
    let scratch = Scratch::new(&[("m.prism", &small)]);
    let found = scratch.run("reach m.prism --property 'Pmax>=1 [ F done ]' --json").expect(0).json();
    assert_eq!((&found["counts"]["states"], &found["pmax_one"]), (&json!("64"), &json!("64")));
    assert!(found.get("over_all_valuations").is_none());
}

/// A problem whose lamps are switched on one by one, each in any state of the others.
fn lamps(count: usize, more: &str) -> Scratch {
    let [domain, problem] = lamps_and(count, more);
    Scratch::new(&[("d.pddl", &domain), ("p.pddl", &problem)])
}

/// Returns the domain and the problem of lamps, with more actions.
pub(crate) fn lamps_and(count: usize, more: &str) -> [String; 2] {
    let lamps: String = (0..count).map(|i| format!("l{i} ")).collect();
    let on: String = (0..count).map(|i| format!("(on l{i})")).collect();
    let domain = format!(
        "(define (domain lamps) (:predicates (on ?x) (power) (blown))
         (:action switch :parameters (?x) :precondition (power) :effect (oneof (on ?x) (and)))
         (:action reset :parameters (?x) :precondition (on ?x) :effect (not (on ?x))) {more})"
    );
    let problem =
        format!("(define (problem p) (:domain lamps) (:objects {lamps}) (:init) (:goal (and {on})))");
    [domain, problem]
}

/// The power is switched on; some outcome is that the fuse has blown.
pub(crate) fn power(outcomes: &str) -> String {
    format!("(:action connect :precondition (not (blown)) :effect (oneof {outcomes}))")
}

#[test]
fn a_guided_search_finds_a_policy_of_few_states_among_millions() {
    let scratch = lamps(24, &power("(power) (and)"));
    let policy = scratch.show("p.txt");
    let asked = |more: &[&str]| scratch.ask("reach d.pddl p.pddl", more).expect(0);
    let found = asked(&["--json", "--policy", &policy]).json();
    assert_eq!(
        (&found["by_guided_search"], &found["counts"], &found["holds"]),
        (&json!(true), &Json::Null, &json!(true))
    );
    assert_eq!(
        (&found["initial"]["pmax_one"], &found["plan"]["policy_states"]),
        (&json!("all"), &json!("25"))
    );
    let verified = scratch.run("verify p.txt d.pddl p.pddl --json").expect(0).json();
    assert_eq!(verified["states"], "25", "{verified}");
    asked(&[]).shows("decided by a guided search").shows("A strong cyclic plan exists");
}

#[test]
fn a_guided_search_proves_that_no_plan_exists() {
    let scratch = lamps(24, &power("(power) (blown)"));
    let found = scratch.run("reach d.pddl p.pddl --json").expect(1).json();
    assert_eq!((&found["by_guided_search"], &found["holds"]), (&json!(true), &json!(false)), "{found}");
    assert_eq!(
        (&found["initial"]["pmax_one"], &found["plan"]["strong_cyclic"]),
        (&json!("none"), &json!(false))
    );
}
