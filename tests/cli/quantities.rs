//! Probabilities and expected rewards: `reach --property 'Pmax=? [ … ]'` and `R{"name"}min=? [ F … ]`.

use crate::common::prelude::*;

/// Tries `a` until it succeeds, or gives up by `b`. In 3 nothing happens any more.
const MODEL: &str = "mdp
    module m
      x : [0..3] init 0;
      [a] x=0 -> 1/10 : (x'=1) + 9/10 : true;
      [b] x=0 -> 1/3 : (x'=1) + 2/3 : (x'=3);
      [wait] x=0 -> true;
      [] x=1 -> (x'=2);
      [] x=2 -> true;
    endmodule
    rewards \"cost\"
      [a] true : 0.1;
      [b] true : 1/3;
      x=1 : 5;
    endrewards
    rewards \"wrong\" x=1 : -1; endrewards
    rewards true : 1; endrewards";

fn ask(text: &str, more: &[&str]) -> Finished {
    let scratch = Scratch::new(&[("m.prism", text)]);
    scratch.ask("reach m.prism --json", more)
}

/// Returns the bounds of a property under both engines.
fn bounds(text: &str, property: &str) -> (f64, f64) {
    let values: Vec<(f64, f64)> = ["symbolic", "explicit"]
        .map(|engine| {
            let found = ask(text, &["--engine", engine, "--property", property]).expect(0).json();
            let value = &found["properties"][0]["value"];
            let bound = |name: &str| match &value[name] {
                Json::String(infinite) if infinite == "inf" => f64::INFINITY,
                number => number.as_f64().unwrap_or_else(|| panic!("{property}: {found}")),
            };
            (bound("lower"), bound("upper"))
        })
        .to_vec();
    assert_eq!(values[0], values[1], "{property}");
    values[0]
}

#[test]
fn a_free_loop_does_not_make_a_target_free() {
    // Value iteration from 0 finds 0, since waiting costs nothing.
    let (lower, upper) = bounds(MODEL, "R{\"cost\"}min=? [ F x=1 ]");
    assert!(lower <= 1.0 && 1.0 <= upper && upper - lower < 1e-9, "{lower} {upper}");
}

#[test]
fn a_dtmc_needs_no_min_or_max() {
    let chain = "dtmc module m x : [0..2]; [] x=0 -> 0.3 : (x'=1) + 0.7 : (x'=2); endmodule";
    let (lower, upper) = bounds(chain, "P=? [ F x=1 ]");
    assert!(lower <= 0.3 && 0.3 <= upper && upper - lower < 1e-9);
    ask(MODEL, &["--property", "P=? [ F x=1 ]"]).prints(3, "least and a greatest");
}

#[test]
fn values_are_over_all_initial_states() {
    let model = MODEL.replace("init 0", "").replace("rewards \"cost\"", "init true endinit rewards \"cost\"");
    assert_eq!(bounds(&model, "Rmin=? [ F x=3 ]"), (0.0, f64::INFINITY));
    let found = ask(&model, &["--property", "Pmax=? [ F x=3 ]"]).expect(0).json();
    assert_eq!(found["properties"][0]["value"]["lower"], json!(0.0));
    assert_eq!(found["properties"][0]["value"]["upper"], json!(1.0));
}

#[test]
fn wrong_rewards_are_errors_at_their_place() {
    let negative = ask(MODEL, &["--property", "R{\"wrong\"}min=? [ F x=2 ]"]).expect(3).json();
    assert_eq!(negative["message"], json!("the reward structure \"wrong\" earns -1 in the state x=1"));
    assert_eq!(negative["line"], json!(15));
    let unknown = ask(MODEL, &["--property", "R{\"costs\"}min=? [ F x=2 ]"]).expect(3).json();
    assert_eq!(unknown["message"], json!("unknown reward structure"));
    for engine in ["symbolic", "explicit"] {
        // The state x=1 is the target, but a state of the scope.
        let unused = ["--engine", engine, "--property", "R{\"wrong\"}min=? [ F x=1 ]"];
        assert_eq!(ask(MODEL, &unused).expect(3).json()["message"], negative["message"]);
    }
    let elsewhere =
        MODEL.replace("x=1 : -1;", "x=4 : -1; [a] x=2 : -1; [b] x>0 : 1/0;").replace("0..3", "0..4");
    let found = ask(&elsewhere, &["--property", "R{\"wrong\"}min=? [ F x=2 ]"]).expect(0).json();
    assert_eq!(found["properties"][0]["value"]["upper"], json!(0.0), "not in the scope, or not enabled");
}

#[test]
fn the_text_says_the_value() {
    let scratch = Scratch::new(&[("m.prism", MODEL)]);
    let shown = scratch.run("reach m.prism --property 'Rmin=? [ F x=0 ]'");
    shown.prints(0, "The value in the initial states: 0");
}

/// A model whose ranges have 2^24 valuations, 21 of which are reachable.
const SPARSE: &str = "mdp module m x : [0..4095]; y : [0..4095];
  [go] x<20 -> 0.9: (x'=x+1) & (y'=4095) + 0.1: (x'=0) & (y'=0); endmodule";

#[test]
fn numbers_are_found_by_the_explicit_engine_if_it_stores_the_states_in_few_bytes() {
    let scratch = Scratch::new(&[("m.prism", SPARSE)]);
    let ask = |arguments: &str| run!("reach {} --json {arguments}", scratch.show("m.prism"));
    let number = "--property Pmax=?[F(x=20)]";
    let found = ask(number).json();
    assert_eq!((&found["engine"], &found["engine_reason"]), (&json!("explicit"), &json!("21 states found")));
    for other in ["--engine symbolic", "--engine explicit", "--order declared"] {
        let other = ask(&format!("{number} {other}")).json();
        assert_eq!(found["properties"][0]["value"], other["properties"][0]["value"], "{other}");
        assert_eq!(found["counts"], other["counts"], "{other}");
    }
    let all = ask(&format!("{number} --scope all")).json();
    assert_eq!(all["engine"], "symbolic", "{}", all["engine_reason"]);
    // Several properties of which one asks for a number.
    let several = ask(&format!("{number} --property P>=1[F(x=20)]")).json();
    assert_eq!(several["engine"], "explicit");
    assert_eq!(several["properties"][1]["holds"], true);
}

#[test]
fn an_expected_cost_beyond_the_doubles_has_the_greatest_double_as_its_lower_bound() {
    let model = "mdp module m x : [0..2] init 0; [] x=0 -> 1e-400 : (x'=1) + 1-1e-400 : (x'=2);
        [] x=2 -> 1/2 : (x'=0) + 1/2 : true; endmodule rewards true : 1; endrewards";
    assert_eq!(bounds(model, "Rmin=? [ F x=1 ]"), (f64::MAX, f64::INFINITY));
}

/// A model with as many states as its constant says, up to a factor of 9.
const SCRAMBLE: &str = "models/scramble.prism --const cells=1013";
/// A model of 32,768 states with few nodes.
const COUNTERS: &str = "mdp module m x : [0..127]; y : [0..127]; z : [0..127];
  [x] x<127 -> (x'=x+1); [y] y<127 -> (y'=y+1); [z] z<127 -> 0.5: (z'=z+1) + 0.5: true; endmodule";

#[test]
fn states_that_share_no_nodes_are_stored_one_by_one() {
    let scratch = Scratch::new(&[("m.prism", COUNTERS)]);
    let ask = |model: &str, arguments: &str| run!("reach {model} --json {arguments}").json();
    let regions = ["counts", "target", "pmax_one", "pmax_positive", "pmin_one", "pmin_positive"];
    let target = "--target x=7";
    let taken = ask(SCRAMBLE, target);
    assert_eq!(taken["engine"], "explicit", "{}", taken["engine_reason"]);
    assert_eq!(taken["engine_reason"], "9108 states found");
    let named = ask(SCRAMBLE, &format!("{target} --engine symbolic"));
    assert_eq!((&named["engine"], named.get("engine_reason")), (&json!("symbolic"), None));
    for region in regions {
        assert_eq!(taken[region], named[region], "{region}");
    }
    // The order is one of bits of diagrams.
    assert_eq!(ask(SCRAMBLE, &format!("{target} --order declared"))["engine"], "symbolic");
    let dense = ask(&scratch.show("m.prism"), target);
    assert_eq!((&dense["engine"], &dense["counts"]["states"]), (&json!("symbolic"), &json!("2097152")));
}

/// Sums of a number of steps and averages have a meaning for rewards of either sign; sums without an end may have none.
#[test]
fn negative_rewards_count_in_sums_of_steps_and_in_averages() {
    let text = "mdp module m s : [0..3];
        [a] s<3 -> 1/2 : (s'=s+1) + 1/2 : true; [b] s<3 -> (s'=3); [stay] s=3 -> true; endmodule
        rewards \"gain\" [a] true : -1; [b] true : -3; s=3 : 1; s=0 : -1/4; endrewards";
    // By hand: of four steps, `b` and three steps in 3 are best, and three steps of `a` before `b` are worst.
    for (property, value) in [
        ("R{\"gain\"}max=? [ C<=4 ]", -0.25),
        ("R{\"gain\"}min=? [ C<=4 ]", -5.96875),
        ("R{\"gain\"}max=? [ C<=0 ]", 0.0),
        ("R{\"gain\"}min=? [ I=1 ]", -0.125),
        ("R{\"gain\"}max=? [ I=1 ]", 1.0),
        ("R{\"gain\"}min=? [ S ]", 1.0),
    ] {
        let (lower, upper) = bounds(text, property);
        assert!(lower <= value && value <= upper && upper - lower < 1e-6, "{property}: {lower} {upper}");
    }
    for (bound, holds) in [(">=-0.25", true), (">-0.25", false), ("<=-0.25", true)] {
        let property = format!("R{{\"gain\"}}max{bound} [ C<=4 ]");
        let found = ask(text, &["--property", &property]);
        assert_eq!(found.json()["properties"][0]["holds"], json!(holds), "{property}");
    }
    let refused = ask(text, &["--property", "R{\"gain\"}max=? [ F s=3 ]"]).expect(3);
    assert!(
        refused.stderr.contains("except in `C<=k`, `I=k` and `S`") || refused.json()["message"].is_string()
    );
}
