//! Strategies of the kind `achieve` for several objectives in one path, and for an objective that is
//! not sure.

use crate::common::prelude::*;

/// Both ends of a corridor can be reached in one path, one after the other.
const HALL: [(&str, &str); 2] = [
    (
        "hall.prism",
        "mdp module hall x : [0..4] init 2; [left] x>0 -> 9/10: (x'=x-1) + 1/10: true;\n\
         [right] x<4 -> (x'=x+1); [jump] x=2 -> 1/2: (x'=0) + 1/2: (x'=4); endmodule",
    ),
    ("hall.pref", "objective C = F x=0; objective D = F x=4; prefer C, D > E; objective E = F x=1;"),
];

#[test]
fn objectives_that_go_together_are_achieved_in_one_path() {
    let scratch = Scratch::new(&HALL);
    let hall = format!("{} {}", scratch.show("hall.prism"), scratch.show("hall.pref"));
    for history in ["state", "play"] {
        let wishes = format!("history = {history}; {}", HALL[1].1);
        scratch.write("hall.pref", wishes);
        for engine in ["symbolic", "explicit"] {
            let options = format!("{hall} --engine {engine} --kind achieve --objective C,D --json");
            let start = &run!("strategy {options}").expect(0).json()["states"][0];
            assert_eq!((&start["pursues"], &start["left"]), (&json!("C and D"), &json!(["C", "D"])));
            let runs = &run!("simulate {options}").expect(0).json()["plays"][0];
            assert_eq!(runs["achieved_runs"], 1000, "{history}");
            for (position, name) in ["C", "D"].iter().enumerate() {
                let achieved = &runs["achieved"][position];
                assert_eq!((&achieved["objective"], &achieved["plays"]), (&json!(name), &json!(1000)));
            }
            for scheduler in ["progress", "permissive"] {
                let given = format!("{hall} --kind achieve --objective D,C --scheduler {scheduler} --json");
                let runs = &run!("simulate {given}").expect(0).json()["plays"][0];
                assert_eq!(runs["achieved_runs"], 1000, "{history}");
            }
        }
    }
}

#[test]
fn the_text_says_what_is_left_of_objectives_that_go_together() {
    let scratch = Scratch::new(&HALL);
    let hall = format!("{} {}", scratch.show("hall.prism"), scratch.show("hall.pref"));
    let text = run!("strategy {hall} --kind achieve --objective C,D").expect(0).stdout;
    for line in [
        "  Achieves almost surely: C and D\n",
        "  jump  permitted, progress action: achieves C or D; the rest stays sure\n",
        "keeps C and D sure together, but comes no closer\n",
        "to C and D  jump to 2 or 3\n",
        "to D        right to 4\n",
    ] {
        assert!(text.contains(line), "{line}{text}");
    }
    run!("simulate {hall} --kind achieve --objective C,D").prints(0, "All runs achieved the objectives.\n");
    let out = scratch.path("out");
    let export = "--strategy achieve:progress --objective C,D --format explicit";
    run!("export {hall} {export} --out {}", out.display()).expect(0);
    // The states contain the reached targets.
    let states = std::fs::read_to_string(out.join("achieve-progress.sta")).unwrap();
    assert!(states.lines().count() > 6, "{states}");
}

#[test]
fn several_objectives_are_refused_where_they_have_no_meaning() {
    let scratch = Scratch::new(&HALL);
    let hall = format!("{} {}", scratch.show("hall.prism"), scratch.show("hall.pref"));
    for (options, message) in [
        ("--kind plan --objective C,D", "takes one objective; `achieve` achieves several together"),
        ("--kind achieve --objective C,X", "no objective is called `X`; there are C, D, E"),
        ("--kind achieve --objective C,D --choose likely", "`likely` is for one objective"),
        ("--kind achieve --objective C --choose likely --levels 2", "`--levels` is about improvements"),
    ] {
        run!("strategy {hall} {options}").ends(2, message);
    }
    let names: Vec<String> = (0..11).map(|i| format!("o{i}")).collect();
    let wishes: Vec<String> = names.iter().map(|name| format!("objective {name} = F x=0;")).collect();
    scratch.write("hall.pref", wishes.join("\n"));
    run!("strategy {hall} --kind achieve --objective {}", names.join(","))
        .ends(2, "at most 10 objectives are achieved together, and 11 are named");
}

#[test]
fn an_objective_that_is_not_sure_is_achieved_as_likely_as_possible() {
    let drone = "models/drone.prism models/drone.pref --kind achieve --objective Cabin";
    run!("strategy {drone}").prints(0, "  `--choose likely` makes it as likely as possible.\n");
    let text = run!("strategy {drone} --choose likely").expect(0).stdout;
    for line in [
        "  Makes as likely as possible: Cabin\n",
        "  Attains: Cabin with probability 0.166667\n",
        "  survey  permitted, most likely: makes Cabin as likely as possible\n",
        "  shore  not permitted: does not make Cabin more likely than the action that is taken\n",
    ] {
        assert!(text.contains(line), "{line}{text}");
    }
    run!("report {drone} --choose likely --seed 3")
        .prints(0, "the permitted action with the greatest probability of success");
    for engine in ["symbolic", "explicit"] {
        let given = format!("{drone} --choose likely --engine {engine} --json");
        let runs = &run!("simulate {given} --runs 3000").expect(0).json()["plays"][0];
        let (value, achieved) = (&runs["value"], runs["achieved_runs"].as_f64().unwrap());
        assert_eq!((&value["objective"], &value["agrees"]), (&json!("Cabin"), &json!(true)));
        assert_eq!(value["measured_probability"].as_f64().unwrap(), achieved / 3000.0);
        let lost = &run!("strategy {given} --at at=1").expect(0).json()["states"][0];
        assert_eq!(
            (&lost["chosen_action"], &lost["actions"][0]["verdict"]),
            (&json!(null), &json!("impossible"))
        );
    }
}
