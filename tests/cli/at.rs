//! `--at`: one state, all states with some values, and states that are not in the scope.

use crate::cli::common::{Finished, run};

const ROBOT: &str = "models/robot5x5.prism models/robot5x5.pref";

fn states(finished: &Finished, list: &str) -> Vec<String> {
    let json = finished.json();
    json[list].as_array().unwrap().iter().map(|entry| entry["state"].to_string()).collect()
}

/// The states of a command with an `--at` that has `*`, and of one for each of its states.
fn agrees(command: &str, list: &str, any: &str, each: &[&str]) {
    let all = run!("{command} --at {any} --json --quiet").expect(0);
    let ats: String = each.iter().map(|at| format!(" --at {at}")).collect();
    let one_by_one = run!("{command}{ats} --json --quiet").expect(0);
    let (mut found, mut expected) = (states(&all, list), states(&one_by_one, list));
    found.sort();
    expected.sort();
    assert_eq!(found.len(), each.len(), "{command}");
    assert_eq!(found, expected, "{command}");
}

#[test]
fn a_star_stands_for_all_values_of_the_scope() {
    let drone = "models/drone.prism models/drone.pref";
    let each = ["at=0", "at=1", "at=2", "at=3", "at=4", "at=5", "at=6"];
    for engine in ["symbolic", "explicit"] {
        agrees(&format!("strategy {drone} --engine {engine}"), "states", "at=*", &each);
        agrees(&format!("values {drone} --engine {engine}"), "states", "at=*", &each);
    }
    agrees(&format!("simulate {drone} --runs 2"), "plays", "at=*", &each);
    // Without `--scope all`, only states that are reachable; all other variables have their initial values.
    let reachable = run!("strategy {ROBOT} --at r=2,c=2,b=* --json --quiet").expect(0);
    let all = run!("strategy {ROBOT} --at r=2,c=2,b=* --scope all --json --quiet").expect(0);
    let (reachable, all) = (states(&reachable, "states"), states(&all, "states"));
    assert_eq!(all.len(), 9);
    assert!(reachable.len() < 9 && reachable.iter().all(|state| all.contains(state)), "{reachable:?}");
}

#[test]
fn the_limit_bounds_the_states_of_a_star_and_nothing_else() {
    let command = format!("strategy {ROBOT} --scope all --at b=*,d=* --at b=1 --limit 4");
    let found = run!("{command} --json").expect(0);
    assert_eq!(states(&found, "states").len(), 5);
    run(&command).ends(0, "4 of 18 states; a larger `--limit` lists more");
}

#[test]
fn a_state_that_no_path_reaches_is_shown_with_the_values_that_were_not_given() {
    let failed = run!("strategy {ROBOT} --at r=0,c=3,d=true").expect(3);
    let message = "no path reaches the state r=0,c=3,b=8,d=true,e=false,f=false,ch=false";
    failed.says(message);
    let (_, note) = failed.stderr.split_once("variables left out have their initial values (").unwrap();
    let (defaults, rest) = note.split_once("); a path reaches the state with ").unwrap();
    let others = rest.lines().next().unwrap();
    assert_eq!(defaults.matches('=').count(), others.matches('=').count());
    // The advice is right: with these values the state is reachable.
    run!("strategy {ROBOT} --at r=0,c=3,d=true,{others}").expect(0);
}

#[test]
fn mistakes_around_a_star_have_their_places() {
    for (at, message) in [
        ("x=*", "the model has no variable `x`"),
        ("x=left", "the model has no variable `x`"),
        ("r=*,r=1", "`r` is given twice"),
        ("r=1,r=*", "`r` is given twice"),
        ("r=*c=1", "expected"),
    ] {
        run!("strategy {ROBOT} --at {at}").ends(3, message).says("--at:1:");
    }
    run!("strategy {ROBOT} --at r=3,c=*,b=8,ch=true").ends(3, "no path reaches a state with these values");
}

#[test]
fn where_nothing_can_be_improved_the_plan_is_named() {
    let strategy = |at: &str| run!("strategy models/drone.prism models/drone.pref --at {at}").expect(0);
    let plan = "`--kind plan` shows how to achieve Ridge.";
    strategy("at=2").shows(plan);
    assert!(!strategy("at=0").stdout.contains("`--kind plan` shows"));
    let lost = strategy("at=6").stdout;
    assert!(lost.contains("No improvement is possible.") && !lost.contains("shows how"), "{lost}");
    let simulated =
        |at: &str| run!("simulate models/drone.prism models/drone.pref --runs 2 --at {at}").expect(0).stdout;
    assert!(simulated("at=2").contains("No improvement is guaranteed here (SASI), and none is possible."));
    assert!(simulated("at=3").contains("`--choose likely` tries possible ones"));
    let cabin = "strategy models/drone.prism models/drone.pref --kind achieve --objective";
    let unsure = "No strategy achieves this almost surely from here.";
    run!("{cabin} Cabin").prints(0, unsure);
    assert!(!run!("{cabin} Shore").expect(0).stdout.contains(unsure));
}
