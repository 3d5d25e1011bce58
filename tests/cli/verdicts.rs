//! `strategy` at states where nothing is guaranteed, and for formulas that are satisfied at once.

use crate::common::prelude::*;

/// Returns what `strategy` says of states, the same under both engines.
fn asked(model: &str, wishes: &str, options: &str) -> Json {
    let scratch = Scratch::new(&[("m.prism", model), ("m.pref", wishes)]);
    let files = format!("{} {}", scratch.show("m.prism"), scratch.show("m.pref"));
    let [symbolic, explicit] = ["symbolic", "explicit"].map(|engine| {
        run!("strategy {files} {options} --engine {engine} --json -q").expect(0).json()["states"].clone()
    });
    assert_eq!(symbolic, explicit, "{options}");
    symbolic
}

/// The opponent's action was called `lateral`, although weakening cannot be avoided after it.
#[test]
fn an_opponents_action_in_a_class_without_a_safe_state_is_unsafe() {
    let game = "smg player us [a] endplayer player them [d], [e], [f] endplayer
        module m x : [0..3] init 0;
        [d] x=0 -> (x'=1); [e] x=0 -> true; [f] x=0 -> (x'=3);
        [a] x>0 -> (x'=x=3?3:2); endmodule";
    let wishes = "objective A = F x<2; objective B = F x=3; prefer B > A;";
    let states = asked(game, wishes, "--kind sasi --safety prefix --at x=0");
    assert_eq!(states[0]["owner"], "opponent");
    let actions = states[0]["actions"].as_array().unwrap().iter();
    let said: Vec<[&str; 2]> =
        actions.map(|a| ["name", "verdict"].map(|key| a[key].as_str().unwrap())).collect();
    assert_eq!(said, [["d", "unsafe"], ["e", "unsafe"], ["f", "improves"]]);
}

const RISK: &str = "mdp module m x : [0..4] init 0;
    [try] x=0 -> 1/2:(x'=1) + 1/2:(x'=2);
    [risk] x=0 -> 0.9:(x'=1) + 0.1:(x'=3);
    [bad] x=3 -> (x'=4);
    [] x=1 | x=2 | x=4 -> true; endmodule";

/// An unsafe state had the value 0, or none. If it was asked for before, actions that may lead to it were taken.
#[test]
fn an_unsafe_state_has_no_value_and_no_action_leads_to_it() {
    let wishes = "objective A = F x=1; require G !(x=4);";
    for order in ["--at x=3 --at x=0", "--at x=0 --at x=3"] {
        let options = format!("--kind achieve --objective A --choose likely --scope all {order}");
        for state in asked(RISK, wishes, &options).as_array().unwrap() {
            let said = [&state["attains"]["probability"], &state["chosen_action"]];
            match state["state"]["x"].as_i64() {
                Some(0) => assert_eq!(said, [&json!({"lower": 0.5, "upper": 0.5}), &json!("try")], "{order}"),
                _ => assert_eq!((said, &state["attains"]), ([&Json::Null; 2], &Json::Null), "{order}"),
            }
        }
    }
}

/// The disjunction is decided before the first step, but none of its leaves is.
#[test]
fn a_disjunction_of_which_one_part_must_come_true_is_achieved_at_once() {
    let model =
        "mdp module m x : [0..2] init 0; [a] x=0 -> (x'=1); [b] x=0 -> (x'=2); [] x>0 -> true; endmodule";
    for (formula, achieved) in [
        ("(F x=1) | (G x!=1)", true),
        ("(F x=1) | (G F x!=1)", true),
        ("(G F x=1) | (F G x!=1)", true),
        ("((F x=1) | (G x!=1)) & (F x=2)", false),
        ("(F x=1) | (G F x=2)", false),
    ] {
        let wishes = format!("objective A = {formula}; objective B = F x=2;");
        let states = asked(model, &wishes, "--kind achieve --objective A");
        let expected = if achieved { json!(["A"]) } else { json!([]) };
        assert_eq!(states[0]["achieved"], expected, "{formula}");
    }
}
