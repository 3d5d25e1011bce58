//! `meliora generate`: the paper's robot is an instance, small worlds look as they did, and mistakes
//! are shown with their place.

use meliora::generate::{Choices, Generated, Parameters, from_map, gridworld};

use crate::common::prelude::*;

fn map(text: &str) -> Result<Generated, Error> {
    from_map(&SourceFile::new("world.map", text), &Choices::default())
}

/// Returns the rendered error message for a map with a mistake.
fn complaint(text: &str) -> String {
    match map(text) {
        Err(Error::Input(diagnostics)) => render(&diagnostics, false),
        other => panic!("expected a mistake in the map, got {other:?}"),
    }
}

fn usage(parameters: &Parameters, choices: &Choices) -> String {
    match gridworld(parameters, choices) {
        Err(Error::Usage(message)) => message,
        other => panic!("expected a usage error, got {other:?}"),
    }
}

#[test]
fn the_papers_robot_is_an_instance() {
    let scratch = Scratch::new(&[]);
    let prefix = scratch.show("robot");
    run!("generate gridworld --from-map models/robot5x5.map --out {prefix}").expect(0);
    for safety in ["transition", "action", "prefix"] {
        let check = |model: &str, preferences: &str| {
            run!("check {model} {preferences} --scope all --safety {safety} --json").expect(0).json()
        };
        let given = check("models/robot5x5.prism", "models/robot5x5.pref");
        let drawn = check(&format!("{prefix}.prism"), &format!("{prefix}.pref"));
        for fact in ["empty", "counts", "classes", "improvement", "sasi", "spi"] {
            assert_eq!(given[fact], drawn[fact], "{fact} under {safety}");
        }
        if safety == "transition" {
            assert_eq!(drawn["counts"]["states"], "3600");
            assert_eq!(drawn["counts"]["transitions"], "18496");
            assert_eq!(drawn["sasi"]["levels"], serde_json::json!(["768", "98"]));
            assert_eq!(drawn["initial"][0]["sasi_actions"], serde_json::json!(["north"]));
        }
    }
}

#[test]
fn small_worlds_look_as_they_did() {
    let small = Parameters { battery: Some(4), robots: 2, patrols: 1, ..Parameters::new(3, 4, 2) };
    let generated = gridworld(&small, &Choices { seed: 3, ..Choices::default() }).unwrap();
    insta::assert_snapshot!("two_robots_and_an_obstacle", generated.model);
    let forked = Parameters { one_way: 1, disabled: 1, ..Parameters::new(9, 8, 4) };
    let generated = gridworld(&forked, &Choices { seed: 1, ..Choices::default() }).unwrap();
    insta::assert_snapshot!("forked", generated.model);
    insta::assert_snapshot!("forked_preferences", generated.preferences);
}

#[test]
fn opponents_make_the_world_a_game() {
    let small = Parameters { opponents: 1, ..Parameters::new(4, 4, 2) };
    let generated = gridworld(&small, &Choices { seed: 3, ..Choices::default() }).unwrap();
    insta::assert_snapshot!("an_opponent", generated.model);
    let scratch = Scratch::new(&[]);
    let prefix = scratch.show("game");
    for (more, players, meeting) in [
        ("--opponent 1 --items 2 --seed 3", 2, "r=opponent_r & c=opponent_c"),
        (
            "--opponent 2 --items 2 --seed 2",
            3,
            "r=opponent_r2 & c=opponent_c2 | opponent_r1=opponent_r2 & opponent_c1=opponent_c2",
        ),
        ("--opponent 1 --robots 2 --items 1 --seed 4", 2, "r2=opponent_r & c2=opponent_c"),
    ] {
        let world = "generate gridworld --rows 3 --cols 4 --walls 5 --battery none";
        run!("{world} {more} --out {prefix} --force").expect(0);
        run!("compare {prefix}.prism {prefix}.pref").expect(0);
        let info = run!("info {prefix}.prism --json").expect(0).json();
        assert_eq!(info["players"].as_array().unwrap().len(), players);
        let target = ["reach", &format!("{prefix}.prism"), "--target", meeting, "--json"];
        let found = Finished::of(executable().args(target)).expect(0).json();
        assert_eq!(found["pmax_positive"], "0", "{more}");
    }
    let good = || Parameters::new(8, 8, 4);
    for (wrong, message) in [
        (Parameters { opponents: 10, ..good() }, "there can be at most 9 opponents, not 10"),
        (Parameters { opponents: 1, patrols: 1, ..good() }, "a world with opponents has no moving obstacles"),
    ] {
        assert_eq!(usage(&wrong, &Choices::default()), message);
    }
}

#[test]
fn forks_promise_improvements() {
    let scratch = Scratch::new(&[]);
    let prefix = scratch.show("forks");
    for (rows, items, levels) in [(16, 3, 1), (16, 7, 2)] {
        run!("generate gridworld --rows {rows} --cols {rows} --items {items} --out {prefix} --force")
            .expect(0);
        let report = run!("check {prefix}.prism {prefix}.pref --json").expect(0).json();
        let found = report["sasi"]["levels"].as_array().unwrap().len();
        assert!(found >= levels, "{found} levels with {items} items");
    }
}

#[test]
fn mistakes_in_maps_are_shown_with_their_place() {
    let mistakes = [
        "battery 5\n",
        "map\nA.@\n",
        "map\nend\n",
        "map\nA.@\nB.\nend\n",
        "map\nA.?\nB.@\nend\n",
        "map\nA..\nB..\nend\n",
        "map\nAé.@\nB.@\nend\ncell é slip north\n",
        "map\nAéé@\nend\ncell é no north south east west\n",
        "map\n@..\nend\n",
        "map\nA.@\nend\nbattery 0\n",
        "map\nA.@\nend\nopen A -> B\n",
        "map\nA@B\nend\nopen A B\n",
        "map\nA@B\nend\nopen B -> A // closed\nopen A -> B\n",
        "map\nA@B\nend\nprefer A>B, B>=A\n",
        "map\nA@B\nend\nprefer A>C\n",
        "map\nA@B\nend\npatrol 0,0 1,0\n",
        "map\nA@B\nend\ncell + no\n",
        "map\nA@+\nend\ncell + no north south east west\n",
        "map\nA@B\nend\nempty full\n",
        "map\nA@B\nend\nrobot 1\n",
    ];
    let shown: Vec<String> = mistakes.into_iter().map(complaint).collect();
    insta::assert_snapshot!(shown.join("\n"));
}

#[test]
fn parameters_out_of_bounds_are_usage_errors() {
    let good = || Parameters::new(8, 8, 4);
    let bad = [
        Parameters { rows: 0, ..good() },
        Parameters { cols: 5000, ..good() },
        Parameters { items: 0, forks: 0, ..good() },
        Parameters { items: 27, ..good() },
        Parameters { locked: 4, ..good() },
        Parameters { battery: Some(0), ..good() },
        Parameters { robots: 10, ..good() },
        Parameters { walls: 95, ..good() },
        Parameters { drifts: Vec::new(), ..good() },
        Parameters { forks: 4, ..good() },
        Parameters { forks: 2, ..good() },
        Parameters { patrols: 60, ..good() },
        Parameters { one_way: 64, ..good() },
        Parameters { rows: 2, cols: 2, forks: 0, ..good() },
    ];
    let mut shown: Vec<String> = bad.iter().map(|p| usage(p, &Choices::default())).collect();
    for order in ["A>", ">A", "A", "A>B>", "A B", "A>>B", "A>Z", "A>B,B>A", "A>A", "A~B,A>B"] {
        shown.push(usage(&good(), &Choices { prefer: Some(order.to_owned()), ..Choices::default() }));
    }
    insta::assert_snapshot!(shown.join("\n"));
}

#[test]
fn the_command_writes_both_files_or_one_to_stdout() {
    let scratch = Scratch::new(&[]);
    let world =
        "generate gridworld --rows 4 --cols 4 --items 2 --prefer B>A --empty gain --battery none --drift NS";
    let model = run(world).expect(0).stdout;
    let preferences = run!("{world} --print prefs").expect(0).stdout;
    assert!(preferences.contains("prefer B > A;") && preferences.contains("empty = gain;"), "{preferences}");
    assert!(!model.contains("b>0"), "a battery that never ends needs no variable");
    run!("{world} --out {}", scratch.show("v1.2")).expect(0);
    assert_eq!(std::fs::read_to_string(scratch.show("v1.2.prism")).unwrap(), model);
    assert_eq!(std::fs::read_to_string(scratch.show("v1.2.pref")).unwrap(), preferences);
    run("generate gridworld --rows 4").expect(2);
    run("generate gridworld --from-map models/robot5x5.map --items 3").expect(2);
    run("generate gridworld --from-map missing.map").expect(3);
    run("generate gridworld --rows 4 --cols 4 --drift NX").expect(2);
    run("generate gridworld --rows 1 --cols 1").expect(2);
}
