//! `reach --out`: the regions of questions as a dump, which `query` reads and `verify` refuses.

use crate::common::prelude::*;

fn count(dump: &str, region: &str) -> Json {
    run!("query {dump} {region} --json").expect(0).json()["count"].clone()
}

fn manifest(scratch: &Scratch, dump: &str) -> Json {
    let text = std::fs::read_to_string(scratch.path(dump).join("manifest.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

#[test]
fn the_regions_of_a_target_can_be_queried() {
    let scratch = Scratch::new(&[]);
    let out = scratch.show("dump");
    let robot = "reach models/robot5x5.prism --scope all --target d&b=0";
    let report = run!("{robot} --out {out} --json").expect(0).json();
    for region in ["target", "pmax_one", "pmax_positive", "pmin_one", "pmin_positive"] {
        assert_eq!(report[region], count(&out, region), "{region}");
    }
    assert_eq!(count(&out, "initial"), report["counts"]["initial"]);
    let inside = run!("query {out} pmax_positive&!target --where b<3 --count").expect(0);
    assert!(inside.stdout.trim().parse::<u64>().unwrap() > 0);
    let names = report["written"]["regions"].as_array().unwrap().iter().map(|region| &region["name"]);
    let expected = [
        "reachable",
        "initial",
        "deadlock",
        "target",
        "pmax_positive",
        "pmax_one",
        "pmin_positive",
        "pmin_one",
    ];
    assert!(names.eq(expected), "{report}");
    assert_eq!(manifest(&scratch, "dump")["questions"][0]["text"], "d&b=0");
    // A second run replaces the dump, and `--only` selects a property of a file.
    scratch.write("p.props", "\"one\": P>=1 [ F d ]; \"two\": Pmax>=1 [ G F d ];");
    let props = format!("reach models/robot5x5.prism --properties {} --out {out}", scratch.show("p.props"));
    run(&props).ends(2, "`Pmax>=1 [ G F d ]` has a monitor of its own: ask it alone");
    run!("{props} --only two").expect(0);
    assert_eq!(manifest(&scratch, "dump")["questions"][0]["name"], "two");
}

#[test]
fn several_properties_have_their_regions_under_their_numbers() {
    let scratch = Scratch::new(&[]);
    let out = scratch.show("dump");
    let toy = "reach models/toy.prism --property P>=1[F(s=3)] --property P>0[F(s=1)] --json";
    for engine in ["symbolic", "auto"] {
        let report = run!("{toy} --engine {engine} --out {out}").expect(1).json();
        let plain = run(toy).expect(1).json();
        assert_eq!(report["engine"], "symbolic");
        for (number, property) in (1..).zip(report["properties"].as_array().unwrap()) {
            for region in ["pmax_one", "pmax_positive", "pmin_one", "pmin_positive"] {
                assert_eq!(property[region], plain["properties"][number - 1][region]);
                if !property[region].is_null() {
                    assert_eq!(property[region], count(&out, &format!("{region}:{number}")));
                }
            }
        }
        assert_eq!((count(&out, "target:1"), count(&out, "target:2")), (json!("1"), json!("1")));
    }
    // Of a game, each property may have its own players.
    let game =
        "reach models/pursuit.prism -c N=4 --property <<guard>>P>0[F(x=1)] --property <<robot>>P>0[F(x=1)]";
    let report = run!("{game} --out {out} --json");
    let report = report.json();
    for (number, property) in (1..).zip(report["properties"].as_array().unwrap()) {
        assert_eq!(property["pmax_positive"], count(&out, &format!("pmax_positive:{number}")), "{report}");
    }
}

#[test]
fn regions_of_a_question_are_not_certified() {
    let scratch = Scratch::new(&[]);
    let (out, dump) = (scratch.show("regions"), scratch.show("dump"));
    run!("reach models/pond.prism --target at=5 --require G(at!=4) --out {out}").expect(0);
    assert_eq!(count(&out, "unsafe"), json!("3"));
    let toy = "models/toy.prism models/toy.pref";
    let refused = run!("verify {out} {toy}").expect(3).stderr;
    assert!(refused.contains("written by `meliora reach --out`"), "{refused}");
    assert!(refused.contains("its regions are not certified"), "{refused}");
    // A certified dump with a question is refused, too.
    run!("export {toy} --out {dump}").expect(0);
    run!("verify {dump} {toy}").expect(0);
    let mut forged = manifest(&scratch, "dump");
    forged["questions"] = json!([{"name": null, "text": "s=3", "regions": ["initial"]}]);
    std::fs::write(scratch.path("dump").join("manifest.json"), forged.to_string()).unwrap();
    run!("verify {dump} {toy}").expect(3);
    forged["questions"][0]["regions"] = json!(["none"]);
    std::fs::write(scratch.path("dump").join("manifest.json"), forged.to_string()).unwrap();
    run!("query {dump} initial").ends(3, "the region `none` of a question is missing");
}

#[test]
fn regions_are_written_for_one_model_as_a_whole() {
    let scratch = Scratch::new(&[("file", "text")]);
    let out = scratch.show("dump");
    for (arguments, message) in [
        ("models/toy.prism --target s=3 --engine explicit", "`--engine explicit`, which has none"),
        ("models/toy.prism --target s=3 --stop-at-target", "cannot be used with `--stop-at-target`"),
        ("models/chain.prism --target x=1 -c N=1:2", "a sweep has several"),
    ] {
        let refused = run!("reach {arguments} --out {out}").expect(2).stderr;
        assert!(refused.contains(message) && !scratch.path("dump").exists(), "{refused}");
    }
    run("reach models/toy.prism --target s=3 --out -").expect(2);
    let file = scratch.show("file");
    for command in ["reach models/toy.prism --target s=3", "export models/toy.prism models/toy.pref"] {
        let refused = run!("{command} --out {file}").expect(3).stderr;
        assert!(refused.contains("this is a file; a dump is a directory") && !refused.contains("os error"));
    }
    assert_eq!(std::fs::read_to_string(file).unwrap(), "text");
}

/// The dump did not say who moves, and named the players of the model as those of a question about others.
#[test]
fn regions_of_games_have_the_states_of_the_players_and_the_coalition_of_each_question() {
    let props = "<<guard>> P>=1 [ F x=1 ];\n<<robot,guard>> Pmax=? [ F x=2 ];\n";
    let scratch = Scratch::new(&[("p.props", props)]);
    let (out, props) = (scratch.show("dump"), scratch.show("p.props"));
    let coalitions = |more: &str| {
        let asked = run!("reach models/pursuit.prism -c N=4 {more} --out {out} --json");
        assert!([0, 1].contains(&asked.status), "{asked:?}");
        let text = std::fs::read_to_string(scratch.path("dump").join("manifest.json")).unwrap();
        let manifest: Json = serde_json::from_str(&text).unwrap();
        let questions = manifest["questions"].as_array().unwrap();
        let own = questions.iter().map(|question| question["coalition"].clone()).collect::<Vec<_>>();
        (manifest["coalition"].clone(), own)
    };
    let (guard, robot) = (json!(["guard"]), json!(["robot"]));
    let several = coalitions(&format!("--properties {props}"));
    assert_eq!(several, (robot, vec![guard.clone(), json!(["robot", "guard"])]));
    assert_eq!(coalitions("--target x=1 --coalition guard"), (guard.clone(), vec![guard]));
    let count = |region: &str| run!("query {out} {region} --json").expect(0).json()["count"].clone();
    let [of_robot, of_guard, all] = ["player:robot", "player:guard", "reachable"]
        .map(|name| count(name).as_str().unwrap().parse::<u64>());
    assert_eq!(of_robot.unwrap() + of_guard.unwrap(), all.unwrap());
    // Other models have neither.
    run!("reach models/toy.prism --target s=3 --out {out}").expect(0);
    let text = std::fs::read_to_string(scratch.path("dump").join("manifest.json")).unwrap();
    assert!(!text.contains("coalition") && !text.contains("player:"), "{text}");
}

/// An expression over states was said to be undecided, and had no region.
#[test]
fn conditions_over_states_have_the_states_that_satisfy_them() {
    let scratch = Scratch::new(&[]);
    let (out, file) = (scratch.show("dump"), scratch.show("p.props"));
    let text = "filter(count, P>=1 [ F s=3 ] | s=1);\nP>=1 [ F s=3 ] | s=1;\nPmax=? [ F s=3 ] + 0;\nPmax>=1 [ F s=3 ];\n";
    scratch.write("p.props", text);
    let found = run!("reach models/toy.prism --properties {file} --out {out} --json").expect(1);
    let report = found.json();
    let (all, holds) = (&report["properties"][0]["value"]["upper"], &report["properties"][1]["holds"]);
    let size: f64 = count(&out, "satisfied:2").as_str().unwrap().parse().unwrap();
    assert_eq!(json!(size), *all, "{report}");
    let initial = count(&out, "initial&!satisfied:2");
    assert_eq!(*holds, json!(initial == json!("0")));
    assert_eq!(count(&out, "pmax_one:4"), report["properties"][3]["pmax_one"]);
    let regions: Vec<Json> = manifest(&scratch, "dump")["questions"]
        .as_array()
        .unwrap()
        .iter()
        .map(|question| question["regions"].clone())
        .collect();
    assert_eq!(regions, [json!(["satisfied:2"]), json!(["target:4", "pmax_one:4"])]);
    found.says("is a number");
    let number = format!("reach models/toy.prism --property Pmax=?[F(s=3)]+0 --out {out}");
    run(&number).ends(2, "`filter(printall, …)` lists its values");
}
