//! `reach`: the answer, and the ways to it, do not depend on how a property is written.

use crate::cli::direction::{lamps_and, power, register};
use crate::common::prelude::*;

const GOAL: &str = "Pmax>=1 [ F \"goal\" ]";

/// A planning problem with millions of states, and a file of properties.
fn lamps(properties: &str) -> Scratch {
    let [domain, problem] = lamps_and(24, &power("(power) (and)"));
    Scratch::new(&[("d.pddl", &domain), ("p.pddl", &problem), ("f.props", properties)])
}

fn asked(scratch: &Scratch, more: &[&str]) -> Finished {
    let model = [scratch.show("d.pddl"), scratch.show("p.pddl")];
    Finished::of(executable().arg("reach").args(model).args(more).args(["--memory", "1GiB"]))
}

#[test]
fn a_guided_search_answers_wherever_its_question_stands() {
    let scratch = lamps(&format!("{GOAL}\n\"again\": {GOAL}\n"));
    let cases = [
        (format!("!!({GOAL})"), true),
        (format!("true & ({GOAL})"), true),
        (format!("filter(forall, {GOAL}, \"init\")"), true),
        (format!("!({GOAL})"), false),
        (format!("({GOAL}) & P>0 [ F \"goal\" ]"), false),
        (format!("({GOAL}) | P>=1 [ F \"goal\" ]"), true),
        (format!("({GOAL}) <=> !\"goal\""), true),
        ("Pmax<1 [ F \"goal\" ]".to_owned(), false),
        (format!("({GOAL}) | S>=0.5 [ \"goal\" ]"), true),
    ];
    for (property, holds) in &cases {
        let found = asked(&scratch, &["--json", "--property", property]).expect(i32::from(!holds)).json();
        assert_eq!(found["by_guided_search"], true, "{property}");
        assert_eq!(found["properties"][0]["holds"], *holds, "{property}: {found}");
        if property.contains(">=1 [ F \"goal\" ]") || property.contains("<1") {
            assert_eq!(found["plan"]["strong_cyclic"], true, "{property}: {found}");
        }
    }
    let file = scratch.show("f.props");
    for list in [&["--properties", &file][..], &["--property", GOAL, "--property", GOAL]] {
        let found = asked(&scratch, &[list, &["--json"]].concat()).expect(0).json();
        assert_eq!(found["by_guided_search"], true, "{found}");
        for property in found["properties"].as_array().unwrap() {
            assert_eq!((&property["holds"], &property["strong_cyclic"]), (&json!(true), &json!(true)));
        }
        asked(&scratch, list).prints(0, "A strong cyclic plan exists.");
    }
}

/// The answer was missing.
#[test]
fn a_property_that_the_initial_state_decides_needs_no_states() {
    let scratch = lamps("");
    for (property, holds) in
        [(format!("\"goal\" => ({GOAL})"), true), (format!("\"goal\" & ({GOAL})"), false)]
    {
        let found = asked(&scratch, &["--json", "--property", &property]).expect(i32::from(!holds)).json();
        assert_eq!((&found["holds"], &found["counts"]), (&json!(holds), &Json::Null), "{property}");
    }
}

#[test]
fn no_property_holds_where_no_strategy_keeps_the_requirements() {
    for property in ["at=3 | P>=1 [ F at=5 ]", "!(P>=1 [ F at=5 ] & P>0 [ F at=4 ])"] {
        let given =
            ["reach", "models/pond.prism", "--property", property, "--require", "G (!at=4)", "--json"];
        let found = Finished::of(executable().args(given)).expect(1).json();
        assert_eq!(found["holds"], false, "{property}: {found}");
    }
}

#[test]
fn a_search_over_all_valuations_answers_wherever_its_question_stands() {
    let scratch = Scratch::new(&[("m.prism", &register())]);
    for (property, holds) in [
        ("!!(Pmax>0 [ F done ])", true),
        ("!(Pmax>0 [ F done ])", false),
        ("Pmax>0 [ F done ] & Pmax>=1 [ G !done ]", true),
        ("done | P>0 [ F done ]", false),
    ] {
        let found = scratch.ask("reach m.prism", ["--property", property, "--json"]);
        let found = found.expect(i32::from(!holds)).json();
        let everywhere = (&found["over_all_valuations"], &found["counts"]);
        assert_eq!(everywhere, (&json!(true), &Json::Null), "{property}");
        assert_eq!(found["holds"], holds, "{property}");
    }
}

#[test]
fn a_policy_is_written_however_its_property_is_written() {
    let scratch = lamps("");
    let policy = scratch.show("p.txt");
    let property = format!("true & !!({GOAL})");
    let found = asked(&scratch, &["--json", "--property", &property, "--policy", &policy]).expect(0).json();
    assert_eq!(found["plan"]["policy_states"], "25", "{found}");
}

#[test]
fn several_initial_states_may_differ_in_a_part_of_a_property() {
    let text = "mdp module m x:[0..3]; [] x=1 -> (x'=2); [] x=2 -> (x'=1); [] x=0 -> (x'=3); endmodule \
                init x<2 endinit";
    let scratch = Scratch::new(&[("m.prism", text)]);
    for (property, holds) in [
        ("P>=1 [ F x=3 ]", false),
        ("!(P>=1 [ F x=3 ])", false),
        ("P>=1 [ F x=3 ] | P>=1 [ F x=2 ]", true),
        ("P>=1 [ F x=3 ] & P>=1 [ F x=2 ]", false),
        ("P>=1 [ F x=3 ] <=> x=0", true),
        ("x=0 => P>=1 [ F x=3 ]", true),
        ("filter(exists, P>=1 [ F x=3 ], \"init\")", true),
        ("!filter(forall, P>=1 [ F x=3 ], \"init\")", true),
    ] {
        let found = scratch.ask("reach m.prism", ["--property", property, "--json"]);
        let found = found.expect(i32::from(!holds)).json();
        assert_eq!(found["properties"][0]["holds"], holds, "{property}: {found}");
    }
}

#[test]
fn requirements_with_monitors_restrict_each_operator_of_a_property() {
    let text = "mdp module m x:[0..3]; [] x=0 -> (x'=1); [] x=1 -> (x'=2); [] x=2 -> (x'=0); [] x=2 -> (x'=3); \
                endmodule";
    let scratch = Scratch::new(&[("m.prism", text)]);
    let asked = |property: &str| {
        let given = ["--property", property, "--require", "G (x!=2 | X x!=0)", "--json"];
        scratch.ask("reach m.prism", given)
    };
    for (property, holds) in [
        ("P>=1 [ F x=3 ]", true),
        ("!!(P>=1 [ F x=3 ])", true),
        ("true & P>=1 [ F x=3 ]", true),
        ("P>=1 [ F x=3 ] & P>=0.5 [ F x=2 ]", true),
        ("P>=1 [ F x=3 ] & P<0.5 [ F x=2 ]", false),
        ("!(P>=1 [ F x=3 ] & P>=1 [ F x=2 ])", false),
    ] {
        let found = asked(property).expect(i32::from(!holds)).json();
        assert_eq!(found["properties"][0]["holds"], holds, "{property}: {found}");
    }
    asked("P>=1 [ F P>=1 [ F x=3 ] ]").ends(3, "under other requirements than `G condition`");
}

#[test]
fn paths_stop_at_a_target_however_the_property_is_written() {
    let ask = |property: &str| {
        let given = ["reach", "models/pond.prism", "--property", property, "--stop-at-target", "--json"];
        Finished::of(executable().args(given))
    };
    let alone = ask("Pmax>0 [ F at=5 ]").expect(0).json();
    for property in ["!!(Pmax>0 [ F at=5 ])", "true & Pmax>0 [ F at=5 ]", "!(Pmax<=0 [ F at=5 ])"] {
        let found = ask(property).expect(0).json();
        assert_eq!(found["counts"], alone["counts"], "{property}");
        assert_eq!(
            (&found["holds"], &found["pmax_positive"]),
            (&json!(true), &alone["pmax_positive"]),
            "{property}"
        );
    }
    for function in ["exists", "print", "count"] {
        let found = ask(&format!("filter({function}, Pmax>0 [ F at=5 ], \"init\")")).expect(0).json();
        assert_eq!(found["counts"], alone["counts"], "{function}");
    }
    for more in ["Pmax>0 [ F at=5 ] & P>0 [ F at=4 ]", "filter(count, P>0 [ F at=5 ])"] {
        ask(more).ends(3, "this property asks for more");
    }
}

/// The condition was evaluated over the states of the model, which do not know the monitor.
#[test]
fn initial_states_that_differ_are_named_under_requirements_with_monitors() {
    let model =
        "mdp module m x:[0..3]; [a] x<3 -> (x'=x); [b] x=0 -> (x'=3); endmodule init x=0 | x=2 endinit";
    let scratch = Scratch::new(&[("m.prism", model)]);
    let ask = |property: &str| {
        let require = ["--require", "!(x=1) W (x=2)"];
        scratch.ask(format!("reach m.prism --property '{property}'"), require)
    };
    ask("(Pmax>=1 [ F x=3 ]) & (Pmax>=1 [ F x=2 ])").expect(1);
    ask("(Pmax>=1 [ F x=3 ]) | (Pmax>=1 [ F x=2 ])").ends(3, "the initial states differ");
}
