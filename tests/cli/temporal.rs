//! Temporal properties and objectives.

use crate::common::prelude::*;

/// Two places of which one is left for good, and a coin.
const MODEL: &str = "mdp\nmodule m\n x : [0..3] init 0;\n [go] x=0 -> 0.5: (x'=1) + 0.5: (x'=2);\n\
    [back] x=1 -> (x'=0);\n [on] x<2 -> (x'=3);\n [stay] x=3 -> true;\nendmodule\nlabel \"b\" = x=1;\n";

fn reach(arguments: &[&str]) -> Finished {
    let scratch = Scratch::new(&[("m.prism", MODEL)]);
    scratch.ask("reach m.prism", arguments)
}

#[test]
fn a_property_that_is_false_at_the_start_has_exit_status_1() {
    for (property, status) in [
        ("Pmax>0 [ G F x=0 ]", 1),
        ("Pmax>0 [ G x<3 ]", 0),
        ("P>=1 [ (F x=3) | (F x=2) ]", 0),
        ("P>=1 [ F x=3 ]", 1),
        ("Pmax>=1 [ F x=3 ]", 0),
        ("P<1 [ !\"b\" U x=2 ]", 0),
    ] {
        for engine in ["symbolic", "explicit"] {
            let found = reach(&["--property", property, "--json", "--engine", engine]).expect(status).json();
            assert_eq!(found["holds"], json!(status == 0), "{property}");
            assert_eq!(found["counts"]["states"], json!("4"), "{property}");
            let listed = &found["properties"][0];
            assert_eq!(listed["property"], json!(property));
            assert_eq!(listed["pmax_one"], found["pmax_one"]);
            assert_eq!(found["counts"].get("model_states"), None);
        }
    }
}

#[test]
fn a_property_file_has_temporal_formulas_too() {
    let properties = "\"often\": Pmax>0 [ G x<3 ];\nP>=1 [ F x=3 ]\n\"mixed\": Pmax>0 [ (x=0) U (G x=3) ];\n";
    let scratch = Scratch::new(&[("m.prism", MODEL), ("m.props", properties)]);
    for engine in ["symbolic", "explicit"] {
        let asked = scratch
            .run(format!("reach m.prism --properties m.props --engine {engine} --json"))
            .expect(1)
            .json();
        assert_eq!(asked["properties"][0]["holds"], json!(true));
        assert_eq!(asked["properties"][1]["holds"], json!(false));
        assert_eq!(asked["properties"][2]["holds"], json!(true));
    }
}

#[test]
fn bad_formulas_are_refused_at_their_place() {
    for (formula, word, column) in [
        ("x<3 -> F x=3", "`->` is not an operator", 12),
        ("[] x<3", "`[]` is not an operator", 8),
        ("F<=x x=3", "must be a constant", 11),
        ("F [3,1] x=3", "no number of steps", 8),
        ("F y=3", "unknown name `y`", 10),
        ("F \"c\"", "unknown label", 10),
        ("F x=1 & F x=2", "more than one way", 16),
        ("X<=3 x=1", "is not supported", 9),
        ("G b => F x=3", "more than one way", 15),
    ] {
        let property = format!("P>=1 [ {formula} ]");
        let found = reach(&["--property", &property]).expect(3);
        found.says(word);
        let place = format!("--property:1:{column}");
        found.says(&place);
    }
}

#[test]
fn huge_formulas_end_with_a_status() {
    for formula in [
        format!("{}x=1{}", "F (".repeat(20_000), ")".repeat(20_000)),
        format!("(F x=1){}", " & (F x=1)".repeat(10_000)),
        format!("(F x=1){}", " => (F x=1)".repeat(10_000)),
        format!("{}x=1", "!".repeat(50_000)),
    ] {
        reach(&["--property", &format!("P>=1 [ {formula} ]")]).expect(3);
    }
    // The part that is too large is named, with the limit.
    let all = (1..=13).map(|i| format!("(F x*{i}=3)")).collect::<Vec<_>>().join(" & ");
    for (part, limit) in [("F<=100000 x=2", "8192 obligations"), (&format!("F ({all})"), "4096 states")] {
        let found = reach(&["--property", &format!("P>=1 [ (F x=1) & ({part}) ]")]).expect(4).stderr;
        let named = format!("the temporal formula `{part}` needs a monitor of more than {limit}");
        assert!(found.contains(&named), "{found}");
    }
    let many = |n| (0..n).map(|i| format!("((G F x={i}) | (F G x>{i}))")).collect::<Vec<_>>().join(" & ");
    reach(&["--property", &format!("P>=1 [ {} ]", many(9))])
        .ends(3, "the formula has more than 64 cases over its");
}

/// A corridor with two items; `seen` remembers them by hand.
fn corridor(memory: bool) -> String {
    let (variables, updates) = match memory {
        true => (" a : bool init false; b : bool init false;\n", " & (a'=a|x=0) & (b'=b|x=4)"),
        false => ("", ""),
    };
    format!(
        "mdp\nmodule m\n x : [0..5] init 2;\n{variables}\
        [w] x>0 & x<5 -> 0.9: (x'=x-1){updates} + 0.1: (x'=x){updates};\n\
        [e] x<4 -> 0.9: (x'=x+1){updates} + 0.1: (x'=5){updates};\n\
        [s] x=5 -> (x'=5){updates};\nendmodule\n"
    )
}

#[test]
fn history_play_is_memory_written_by_hand() {
    let by_hand = "objective A = F (a | x=0); objective B = F (b | x=4); objective C = F (x=5);\nprefer B > A; prefer A > C;\n";
    let whole = "objective A = F x=0; objective B = F x=4; objective C = F x=5;\nprefer B > A; prefer A > C;\nhistory = play;\n";
    // An objective that was reached once stays achieved, C too.
    let scratch = Scratch::new(&[
        ("plain.prism", &corridor(false)),
        ("memory.prism", &corridor(true)),
        ("hand.pref", by_hand),
        ("play.pref", whole),
    ]);
    for safety in ["action", "transition", "prefix"] {
        for engine in ["symbolic", "explicit"] {
            let check = |model: &str, preferences: &str| {
                let (model, preferences) = (scratch.show(model), scratch.show(preferences));
                let arguments =
                    ["check", &model, &preferences, "--safety", safety, "--engine", engine, "--json"];
                Finished::of(executable().args(arguments)).expect(0).json()
            };
            let (hand, play) = (check("memory.prism", "hand.pref"), check("plain.prism", "play.pref"));
            assert_eq!(play["history"], json!("play"));
            assert_eq!(play["counts"]["model_states"], json!("6"));
            assert_eq!(play["objectives"][0]["observer"], json!(2));
            assert_eq!(hand["initial"][0]["sasi_rank"], play["initial"][0]["sasi_rank"], "{safety} {engine}");
            assert_eq!(hand["initial"][0]["spi_rank"], play["initial"][0]["spi_rank"], "{safety} {engine}");
            assert_eq!(
                hand["initial"][0]["sasi_actions"], play["initial"][0]["sasi_actions"],
                "{safety} {engine}"
            );
        }
    }
}

#[test]
fn states_of_monitors_are_named_in_words() {
    run("check models/courier.prism models/courier.pref").prints(0, "Deliver=waiting for key");
    let at = "place=0,Deliver=\"waiting for door\"";
    let arguments = ["strategy", "models/courier.prism", "models/courier.pref", "--kind", "spi", "--at", at];
    Finished::of(executable().args(arguments)).prints(0, "Deliver=waiting for door");
    Finished::of(executable().args(arguments).arg("--dot"))
        .prints(0, "Deliver=waiting for door, Clean=kept so far");
}

#[test]
fn many_leaves_are_many_small_monitors() {
    let model = "mdp module m x:[0..25] init 0; [up] x<25 -> (x'=x+1); [down] x>0 -> (x'=x-1); endmodule";
    let scratch = Scratch::new(&[("m.prism", model)]);
    let leaves = |form: &str| (1..=25).map(|k| form.replace('k', &k.to_string())).collect::<Vec<_>>();
    for (property, sure, status) in [
        (leaves("(F x=k)").join(" & "), "26", 0),
        (format!("!({})", leaves("(F x=k)").join(" & ")), "26", 0),
        (leaves("(G x!=k)").join(" & "), "0", 1),
    ] {
        let property = format!("Pmax>=1 [ {property} ]");
        let found =
            scratch.run(format!("reach m.prism --property '{property}' --json")).expect(status).json();
        assert_eq!(found["pmax_one"], json!(sure), "{property}");
    }
}

#[test]
fn info_shows_monitors() {
    let arguments = ["info", "models/courier.prism", "--preferences", "models/courier.pref"];
    Finished::of(executable().args(arguments)).prints(0, "{waiting for key, waiting for door, done}");
}

#[test]
fn history_state_takes_reachabilities_alone_and_is_said_once() {
    for (text, word) in [
        ("objective A = G x=0;\nhistory = state;\n", "accepts only reachability formulas"),
        ("objective A = F x=0;\nhistory = state;\nhistory = play;\n", "given twice"),
        ("objective A = F x=0;\nhistory = past;\n", "`state` or `play`"),
        ("objective A = x=0;\n", "a formula over paths"),
        ("objective A = F x=0; require F x=0;\n", "cannot be required"),
        ("history = play; objective A = F x=0; require (x=0) U (G x=3);\n", "cannot be required"),
    ] {
        let scratch = Scratch::new(&[("m.prism", MODEL), ("p.pref", text)]);
        scratch.run("check m.prism p.pref").ends(3, word);
    }
}

#[test]
fn states_are_read_as_they_are_printed() {
    let strategy = ["strategy", "models/courier.prism", "models/courier.pref", "--kind", "spi", "--at"];
    let shown = Finished::of(executable().args(strategy).arg("place=0,Deliver=waiting for door")).expect(0);
    let line = shown.stdout.lines().find_map(|line| line.strip_prefix("State ")).expect("a state is shown");
    assert!(line.contains("Deliver=waiting for door,Clean=kept so far"), "{line}");
    Finished::of(executable().args(strategy).arg(line)).prints(0, line);
    let error = Finished::of(executable().args(strategy).arg("Deliver=\"finished\"")).expect(3).stderr;
    assert!(error.contains("`Deliver` has no value `finished`"), "{error}");
    assert!(error.contains("its values are \"waiting for key\", \"waiting for door\""), "{error}");
}

#[test]
fn a_state_that_no_path_reaches_is_refused_with_advice_on_monitors() {
    for scope in ["reachable", "all"] {
        let at = "place=2,Deliver=done,Clean=kept so far";
        let arguments =
            ["strategy", "models/courier.prism", "models/courier.pref", "--scope", scope, "--at", at];
        let error = Finished::of(executable().args(arguments)).expect(3).stderr;
        assert!(error.contains("no path reaches the state place=2,sky=0,"), "{error}");
        assert!(error.contains("leave out `Deliver`, `Clean`"), "{error}");
        assert!(!error.contains("--scope all"), "{error}");
    }
    // Here the monitors are left out already.
    let model = "mdp module m x : [0..3] init 0; [] x<2 -> (x'=x+1); endmodule";
    let scratch =
        Scratch::new(&[("m.prism", model), ("m.pref", "objective A = G x<2;\nobjective B = F x=1;\n")]);
    let strategy = ["strategy", &scratch.show("m.prism"), &scratch.show("m.pref"), "--at", "x=3"];
    let error = Finished::of(executable().args(strategy)).expect(3).stderr;
    assert!(error.contains("no path reaches the state x=3,") && error.contains("`--scope all`"), "{error}");
    assert!(!error.contains("leave out"), "{error}");
}
