//! `meliora shield`: values of actions as text, table and directory, and the shield expressions of tempest.

use meliora::export::read_shield;

use crate::cli::common::Scratch;

const WORLD: &str = "mdp module world s : [0..3] init 0;
  [safe] s=0 -> 0.9:(s'=1) + 0.1:(s'=3);
  [mid] s=0 -> 0.8:(s'=1) + 0.2:(s'=3);
  [bad] s=0 -> 0.5:(s'=1) + 0.5:(s'=3);
  [go] s=1 -> (s'=2); [go] s=1 -> 0.1:(s'=2) + 0.9:(s'=3);
  [back] s=2 -> (s'=0); [stay] s=2 -> true; [end] s=3 -> true; endmodule
label \"crash\" = s=3;";

/// Returns the names of the permitted actions in the initial state.
fn permitted(scratch: &Scratch, options: &str) -> Vec<String> {
    let report = run!("shield {} --json {options}", scratch.show("w.prism")).expect(0).json();
    let actions = report["states"][0]["actions"].as_array().unwrap().clone();
    let permitted = actions.iter().filter(|action| action["permitted"] == true);
    permitted.map(|action| action["action"].as_str().unwrap().to_owned()).collect()
}

#[test]
fn a_bad_event_and_its_absence_have_the_same_shield() {
    let scratch = Scratch::new(&[("w.prism", WORLD)]);
    // The thresholds are values of actions: only fractions decide them.
    for (threshold, expected) in [
        ("0.9", &["safe"][..]),
        ("0.8", &["safe", "mid"]),
        ("8/9 --relative", &["safe", "mid"]),
        ("0.95", &["safe"]),
        ("0", &["safe", "mid", "bad"]),
    ] {
        for property in [
            "--property Pmin=?[F\"crash\"] --threshold",
            "--property Pmax=?[G!\"crash\"] --threshold",
            "--property Pmax=?[G<=2!\"crash\"] --threshold",
        ] {
            let found = permitted(&scratch, &format!("{property} {threshold}"));
            assert_eq!(found, expected, "{property} {threshold}");
        }
    }
}

#[test]
fn shield_expressions_of_tempest_have_thresholds_on_their_values() {
    let scratch = Scratch::new(&[("w.prism", WORLD)]);
    for (expression, expected) in [
        ("<pre,PreSafety,lambda=0.88>Pmax=?[G!\"crash\"]", &["safe", "mid"][..]),
        ("<_,PostSafety,gamma=0.9>Pmax=?[G!\"crash\"]", &["safe"]),
        ("<_,PreSafety,gamma=0.2>Pmin=?[F\"crash\"]", &["safe", "mid"]),
    ] {
        assert_eq!(permitted(&scratch, &format!("--property {expression}")), expected, "{expression}");
    }
    for (options, message) in [
        ("<_,PreSafety,lambda=0.1>Pmin=?[F\"crash\"]", "`lambda` of a `Pmin` is not supported"),
        ("<_,Optimal>Pmax=?[G!\"crash\"]", "(`Optimal`) are not supported"),
        ("<_,PreSafe,lambda=0.1>Pmax=?[G!\"crash\"]", "unknown kind of shield `PreSafe`"),
        ("<_,PreSafety,delta=0.1>Pmax=?[G!\"crash\"]", "unknown comparison `delta=0.1`"),
        ("<_,PreSafety,gamma=2>Pmax=?[G!\"crash\"]", "expected a number between 0 and 1"),
        ("Pmax=?[G!\"crash\"]", "a threshold is missing"),
        ("<_,PreSafety,gamma=1>Pmax=?[G!\"crash\"] --threshold 1", "has a threshold of its own"),
        ("Pmax>=0.5[G!\"crash\"] --threshold 1", "the bound of a shield is not a part of the property"),
        ("1-Pmax=?[G!\"crash\"] --threshold 1", "a shield is about one operator `P`"),
        ("Pmax=?[F>=2\"crash\"] --threshold 1", "lower bounds on the steps of a shield are not supported"),
        ("Pmax=?[G!\"crash\"] --threshold 1.5", "expected a number between 0 and 1"),
        ("Pmax=?[G!\"crash\"] --threshold 1 --states 3", "more than the 3 that are wanted"),
    ] {
        let found = run!("shield {} --property {options}", scratch.show("w.prism"));
        found.says(message);
    }
}

/// Two choices with one label are two actions of the table.
#[test]
fn every_choice_has_its_value_in_the_table_and_in_the_directory() {
    let scratch = Scratch::new(&[("w.prism", WORLD)]);
    let (model, out) = (scratch.show("w.prism"), scratch.path("shield"));
    let options = format!("--property Pmin=?[F\"crash\"] --threshold 0.8 --out {} --csv -", out.display());
    let table = run!("shield {model} {options}").expect(0).stdout;
    let expected = "s,action,value_lower,value_upper,permitted,instead\n1,go(world#1),0,0,true,\n";
    let rows: Vec<&str> = table.lines().collect();
    assert_eq!(rows.len(), 1 + 8, "{table}");
    assert_eq!(format!("{}\n{}\n", rows[0], rows[4]), expected);
    assert!(
        rows[5].starts_with("1,go(world#2),0.8999") && rows[5].ends_with(",false,go(world#1)"),
        "{table}"
    );
    let shield = read_shield(&out).unwrap();
    assert_eq!((shield.kind.as_str(), shield.nodes.len()), ("safety", 4));
    let nodes = out.join("nodes.json");
    let changed =
        std::fs::read_to_string(&nodes).unwrap().replacen("\"permitted\":false", "\"permitted\":true", 1);
    std::fs::write(&nodes, changed).unwrap();
    assert!(read_shield(&out).unwrap_err().to_string().contains("the file has changed"));
}

/// A formula with memory has the states of its monitor; in each, the values are those of the rest of the path.
#[test]
fn the_shield_of_a_formula_with_memory_knows_what_the_path_has_done() {
    let scratch = Scratch::new(&[("w.prism", WORLD)]);
    let property = "--property Pmax=?[(F(s=2&X(s=0)))&(G!\"crash\")] --threshold 0.5";
    let report = run!("shield {} --json {property}", scratch.show("w.prism")).expect(0).json();
    let states = report["states"].as_array().unwrap();
    assert!(states.len() > 4 && report["property"].as_str().unwrap().contains("X("));
    let first = &states[0]["actions"];
    let value = |at: usize| first[at]["value"]["lower"].as_f64().unwrap();
    // It goes once to s=0 again, and then stays away from the crash: 0.9 twice.
    assert!((value(0) - 0.81).abs() < 1e-9 && (value(2) - 0.45).abs() < 1e-9, "{first}");
}
