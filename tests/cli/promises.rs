//! The promise of the default: no step weakens the start, and gains are gains over the start.

use crate::common::prelude::*;

/// At the start A and B are sure. The way to B loses A, then B, and may then gain A again.
const LATERAL: &str = "mdp\nmodule m\n at : [0..6] init 0;\n [a] at=0 -> (at'=3);\n [c] at=0 -> (at'=4);\n [b] at=0 -> (at'=1);\n \
    [drop] at=1 -> 1/2:(at'=2) + 1/2:(at'=5);\n [try] at=2 | at=5 -> 1/2:(at'=3) + 1/2:(at'=4);\n \
    [stay] at=3 | at=4 -> true;\nendmodule\n";
const LATERAL_PREFS: &str = "objective A1 = F at=3; objective A2 = F at=4; objective B = F at=1; \
    objective C = F at=2; objective D = F at=5; prefer A1, A2 > C, D;";

/// Three ends with chances of their own.
const CHANCE: &str = "mdp\nmodule m\n x : [0..4] init 0;\n [go] x=0 -> 1/8:(x'=1) + 3/8:(x'=2) + 1/2:(x'=4);\n \
    [safe] x=0 -> (x'=4);\n [on] x=4 -> 1/4:(x'=1) + 1/2:(x'=3) + 1/4:(x'=4);\nendmodule\n";
const CHANCE_PREFS: &str = "objective Low = F (x=1 | x=2 | x=3); objective Gold = F x=1; objective Silver = F x=2; prefer Gold, Silver > Low;";

fn files(model: &str, preferences: &str) -> (Scratch, String) {
    let scratch = Scratch::new(&[("m.prism", model), ("m.pref", preferences)]);
    let files = format!("{} {}", scratch.show("m.prism"), scratch.show("m.pref"));
    (scratch, files)
}

#[test]
fn what_was_sure_at_the_start_is_no_gain() {
    let (_scratch, files) = files(LATERAL, LATERAL_PREFS);
    let initial =
        |options: &str| run!("check {files} --json {options}").expect(0).json()["initial"][0].clone();
    assert_eq!((&initial("")["sasi_rank"], &initial("")["spi_rank"]), (&json!(0), &json!(0)));
    assert_eq!(initial("--safety action")["sasi_rank"], json!(1));
    // Steps between incomparable classes add up to a loss, so nothing is gained over the start.
    assert_eq!(initial("--safety action")["sasi_gains"], json!([[]]));
    let text = run!("check {files} -v").expect(0).stdout;
    assert!(text.contains("no improvement over A1, A2 or B is guaranteed"), "{text}");
    assert!(text.contains("`--safety action` counts 1 (SASI) and 1 (SPI)"), "{text}");
    let toy = run("check models/toy.prism models/toy.pref -v").expect(0).stdout;
    assert!(!toy.contains("--safety action"), "the modes agree: {toy}");
}

#[test]
fn runs_of_the_default_never_weaken_their_start() {
    let (_scratch, files) = files(LATERAL, LATERAL_PREFS);
    for kind in ["sasi", "spi", "plan"] {
        let play = &run!("simulate {files} --kind {kind} --json").expect(0).json()["plays"][0];
        assert_eq!((&play["weakened_start"], &play["better_than_start"]), (&json!(0), &json!(0)), "{kind}");
    }
    let play = &run!("simulate {files} --kind sasi --safety action --json").expect(0).json()["plays"][0];
    assert_eq!((&play["weakened_start"], &play["gained"]), (&json!(1000), &json!([])));
}

#[test]
fn gains_over_the_start_are_counted_and_named() {
    let (_scratch, files) = files(CHANCE, CHANCE_PREFS);
    run!("check {files}").prints(0, "one improvement over Low is possible: to Gold or Silver");
    let play = &run!("simulate {files} --kind spi --json").expect(0).json()["plays"][0];
    let runs = |at: usize| play["gained"][at]["runs"].as_u64().unwrap();
    assert_eq!(
        [&play["gained"][0]["objective"], &play["gained"][1]["objective"]],
        [&json!("Gold"), &json!("Silver")]
    );
    assert_eq!(play["better_than_start"].as_u64(), Some(runs(0) + runs(1)));
}

#[test]
fn values_by_goal_add_up_to_the_probability_of_an_improvement() {
    let (_scratch, files) = files(CHANCE, CHANCE_PREFS);
    let state = run!("values {files} --by-goal --json").expect(0).json()["states"][0].clone();
    let found = state["by_goal"].as_array().unwrap();
    let bounds =
        |gain: &serde_json::Value| ["lower", "upper"].map(|end| gain["probability"][end].as_f64().unwrap());
    // 1/8 + 1/2 * 1/3 by way of x=4, and 3/8.
    for (gain, (name, value)) in found.iter().zip([("Gold", 7.0 / 24.0), ("Silver", 3.0 / 8.0)]) {
        assert_eq!(gain["gained"], json!([name]));
        let [lower, upper] = bounds(gain);
        assert!(lower - 1e-12 <= value && value <= upper + 1e-12 && upper - lower < 1e-6, "{gain}");
    }
    let total: f64 = found.iter().map(|gain| bounds(gain)[0]).sum();
    let all = state["levels"][0]["probability"]["upper"].as_f64().unwrap();
    assert!((total - all).abs() < 2e-6 && found.len() == 2, "{state}");
    let game = "models/pursuit.prism models/pursuit.pref -c N=4";
    run!("values {game} --by-goal").ends(2, "the opponent decides on the gain");
}

#[test]
fn three_reasons_for_an_empty_target_are_three_warnings() {
    let model = "mdp\nmodule m\n x : [0..3] init 0;\n b : [0..2] init 2;\n \
        [go] x<3 & b>0 -> (x'=x+1) & (b'=b-1);\n [stay] true -> true;\nendmodule\n";
    let (_scratch, files) = files(
        model,
        "objective A = F x=7; objective B = F x=3; objective C = F x=2; prefer A > B; require G x<2;",
    );
    let warned = run!("check {files}").expect(0).stderr;
    for text in [
        "the target of objective `A` is false for all values that its variables can have",
        "no path reaches a state that satisfies the target of objective `B`",
        "the requirements exclude all states that satisfy the target of objective `C`",
    ] {
        assert!(warned.contains(text), "{warned}");
    }
}

#[test]
fn values_are_written_by_their_names_in_conditions() {
    let scratch = Scratch::new(&[]);
    let dump = scratch.show("dump");
    run!("export models/workshop.jani models/workshop.pref --const N=1 --out {dump}").expect(0);
    let count = |condition: &str| {
        run!("query {dump} reachable --count --where {condition}").expect(0).stdout.trim().to_owned()
    };
    let [idle, other] = [count("left_loc=idle"), count("left_loc!=idle")].map(|n| n.parse::<u64>().unwrap());
    assert!(idle > 0 && other > 0);
    assert_eq!((idle + other).to_string(), count("true"));
    run!("query {dump} reachable --where left_loc=idel").ends(3, "unknown name `idel`");
}

#[test]
fn a_slip_in_a_name_is_recognised() {
    let toy = "models/toy.prism models/toy.pref";
    run!("strategy {toy} --kind achieve --objective Frist").ends(2, "did you mean `First`?");
    let scratch = Scratch::new(&[]);
    let dump = scratch.show("dump");
    run!("export {toy} --out {dump}").expect(0);
    run!("query {dump} reachabel").ends(3, "did you mean `reachable`?");
    let scratch = Scratch::new(&[("m.prism", &format!("{CHANCE}label \"gold\" = x=1;\n"))]);
    run!("reach {} --target \"gild\"", scratch.show("m.prism")).ends(3, "did you mean `\"gold\"`?");
}

#[test]
fn runs_that_cannot_achieve_their_objective_say_why() {
    let text =
        run("simulate models/drone.prism models/drone.pref --kind achieve --objective Cabin --runs 10")
            .expect(0)
            .stdout;
    assert!(text.contains("No strategy achieves this almost surely from here."), "{text}");
}
