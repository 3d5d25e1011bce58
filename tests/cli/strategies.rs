//! Strategies and runs as tables, graphs and reasons; the paper's text on its robot.

use crate::common::prelude::*;

const ROBOT: &str = "models/robot5x5.prism models/robot5x5.pref --scope all";

fn permitted(state: &Json) -> Vec<&str> {
    let actions = state["actions"].as_array().unwrap().iter();
    actions.filter(|a| a["permitted"] == true).map(|a| a["name"].as_str().unwrap()).collect()
}

#[test]
fn the_robot_may_take_the_actions_that_the_paper_tells() {
    let at = "--at r=2,c=2,b=8 --at r=3,c=2,b=7 --at r=3,c=1,b=6";
    let sasi = run!("strategy {ROBOT} --safety transition --kind sasi --json {at}").expect(0).json();
    let spi = run!("strategy {ROBOT} --safety transition --kind spi --json {at}").expect(0).json();
    let start = &sasi["states"][0];
    assert_eq!((&start["sasi_rank"], &start["spi_rank"]), (&json!(2), &json!("unbounded")));
    assert_eq!(start["most_preferred"], json!([]));
    assert_eq!(permitted(start), ["N"]);
    assert_eq!(permitted(&spi["states"][0]), ["N", "S"]);
    assert_eq!(start["actions"][1]["verdict"], "strays");
    let north = &sasi["states"][1];
    assert_eq!(start["actions"][0]["successors"][0]["state"], north["state"]);
    assert_eq!(permitted(north), ["W"]);
    let west = north["actions"][3]["successors"].as_array().unwrap();
    assert!(west.iter().all(|s| s["change"] == "improving" && s["goal"] == true), "{west:?}");
    // B and C are incomparable: on the ice between them, both ways are as good.
    let ice = permitted(&sasi["states"][2]);
    assert!(ice.contains(&"N") && ice.contains(&"S"), "{ice:?}");
}

#[test]
fn the_second_improvement_of_the_robot_is_not_the_one_of_the_paper_s_text() {
    let arguments = format!("strategy {ROBOT} --safety transition --at r=2,c=2,b=8 --dot");
    let dot = run(&arguments).expect(0).stdout;
    let gained =
        |line: &str| line.split("\\n").nth(1)?.split_once(" gained").map(|(names, _)| names.to_owned());
    let gains: std::collections::BTreeSet<String> = dot.lines().filter_map(gained).collect();
    assert_eq!(gains.into_iter().collect::<Vec<_>>(), ["A", "A or B", "B", "B or C", "C", "F"]);
}

#[test]
fn every_play_of_the_robot_improves_twice_before_its_longest_play_ends() {
    let at = "--at r=2,c=2,b=8 --json";
    let strategy = run!("strategy {ROBOT} --safety action {at}").expect(0).json();
    let bound = strategy["states"][0]["longest_play"].as_u64().unwrap();
    let options = format!("--kind sasi --safety action --scheduler progress --runs 500 --steps {bound}");
    let plays = &run!("simulate {ROBOT} {options} {at}").expect(0).json()["plays"][0];
    assert_eq!((&plays["given_up"], &plays["fewer_than_rank"]), (&json!(0), &json!(0)));
    assert_eq!((&plays["weakened_step"], &plays["weakened_start"]), (&json!(0), &json!(0)));
    assert!(plays["steps_to"][1]["most"].as_u64().unwrap() <= bound);
    assert_eq!(plays["steps_to"][1]["plays"], 500);
}

#[test]
fn transition_plays_take_the_branch_that_the_construction_drops() {
    let lateral = "models/lateral.prism models/lateral.pref --safety transition --json";
    let action = &run!("strategy {lateral}").expect(0).json()["states"][0]["actions"][1];
    assert_eq!((&action["name"], &action["permitted"]), (&json!("gamble"), &json!(true)));
    assert_eq!(action["successors"][1]["dropped"], true);
    let plays = &run!("simulate {lateral} --runs 200").expect(0).json()["plays"][0];
    let (weakened, fewer) = (plays["weakened_step"].as_u64().unwrap(), &plays["fewer_than_rank"]);
    assert!((50..150).contains(&weakened), "{weakened}");
    assert_eq!(fewer, weakened);
    assert_eq!(plays["trace"]["turns"].as_array().unwrap().len(), 1);
}

#[test]
fn each_action_is_shown_with_the_reason_why_it_is_not_permitted() {
    let of = |safety: &str| {
        let text = format!("strategy models/lateral.prism models/lateral.pref --safety {safety}");
        run(&text).expect(0).stdout
    };
    assert!(of("action").contains("may weaken: Bronze lost in s=3"), "{}", of("action"));
    assert!(of("transition").contains("leads to s=1, where 1 improvement is not guaranteed"));
    let trader = "models/lateral_prefix.prism models/lateral_prefix.pref";
    run!("strategy {trader} --safety action")
        .prints(0, "stays in the level, but comes no closer to an improvement");
    run!("strategy {trader} --scope all --safety prefix --at good=3")
        .prints(0, "No improvement is possible.");
}

#[test]
fn runs_follow_the_progress_strategy_of_a_plan_unless_told_otherwise() {
    let report = run("simulate models/toy.prism models/toy.pref --json --runs 3").expect(0).json();
    assert_eq!((&report["kind"], &report["strategy"]), (&json!("plan"), &json!("progress")));
    assert_eq!(report["plays"][0]["improvements"], json!([{"times": 1, "plays": 3}]));
}

#[test]
fn dot_draws_what_the_strategy_may_reach() {
    let dot = run("strategy models/toy.prism models/toy.pref --dot").expect(0).stdout;
    assert!(dot.starts_with("digraph strategy {") && dot.ends_with("}\n"), "{dot}");
    assert!(
        dot.contains("label=\"b\"") && dot.contains("label=\"c\"") && !dot.contains("label=\"a\""),
        "{dot}"
    );
    assert!(dot.contains("Second gained"), "{dot}");
    let cut = run("strategy models/toy.prism models/toy.pref --dot --limit 1").expect(0);
    assert!(cut.stdout.contains('…') && cut.stderr.contains("--limit"), "{cut:?}");
}

#[test]
fn wrong_states_are_shown_where_they_are_wrong() {
    let toy = "models/toy.prism models/toy.pref";
    for (command, part) in [("strategy", "range"), ("simulate", "range")] {
        run!("{command} {toy} --at s=7").ends(3, part).says("--at");
    }
    let scratch = Scratch::new(&[
        ("m.prism", "mdp\nmodule m\n  x : [0..2] init 0;\n  [a] x<1 -> (x'=x+1);\nendmodule\n"),
        ("m.pref", "objective A = F x=1;\n"),
    ]);
    let files = format!("{} {}", scratch.show("m.prism"), scratch.show("m.pref"));
    run!("strategy {files} --at x=2 -q").ends(3, "--scope all");
    run!("strategy {files} --at x=2 -q --scope all").expect(0);
    run!("strategy {files} --rank most").expect(2);
    run!("strategy {files} --rank 1 --at x=1").expect(2);
}

/// Returns a report without the fields that may differ from run to run.
fn lasting(arguments: &str) -> Json {
    let mut report = run(arguments).expect(0).json();
    let object = report.as_object_mut().unwrap();
    for key in ["engine", "time", "memory"] {
        object.remove(key);
    }
    report
}

#[test]
fn the_same_seed_gives_the_same_plays_and_another_one_others() {
    let plays = format!("simulate {ROBOT} --kind spi --runs 50 --json");
    let [first, again, other] =
        ["--seed 7", "--seed 7", "--seed 8"].map(|seed| lasting(&format!("{plays} {seed}"))["plays"].take());
    assert_eq!(first, again);
    assert_ne!(first, other);
}

#[test]
fn both_engines_explain_and_play_alike() {
    for kind in ["sasi", "spi"] {
        for safety in ["action", "transition", "prefix"] {
            for command in ["strategy --rank 1 --limit 60", "simulate --runs 30"] {
                let ask = |engine| {
                    lasting(&format!(
                        "{command} {ROBOT} --kind {kind} --safety {safety} --json --engine {engine}"
                    ))
                };
                assert_eq!(ask("symbolic"), ask("explicit"), "{command} {kind} {safety}");
            }
        }
    }
}

#[test]
fn a_plan_improves_and_then_achieves_what_is_sure() {
    let report = run!("simulate {ROBOT} --json").expect(0).json();
    assert_eq!(report["kind"], "plan");
    let runs = &report["plays"][0];
    assert_eq!((&runs["rank"], &runs["fewer_than_rank"]), (&json!(1), &json!(0)));
    assert_eq!(runs["achieved_runs"], 1000);
    let achieved = runs["achieved"].as_array().unwrap();
    let total: u64 = achieved.iter().map(|a| a["plays"].as_u64().unwrap()).sum();
    assert!(achieved.len() > 1 && total >= 1000, "{achieved:?}");
    let last = runs["trace"]["turns"].as_array().unwrap().last().unwrap();
    assert_eq!(last["most_preferred"], last["achieved"]);
}

#[test]
fn a_kind_and_an_objective_that_do_not_fit_are_refused() {
    let toy = "models/toy.prism models/toy.pref";
    for (options, message) in [
        ("--kind achieve", "needs an objective; there are First, Second, Third"),
        (
            "--kind achieve --objective Fourth",
            "no objective is called `Fourth`; there are First, Second, Third",
        ),
        ("--kind plan --objective Fourth", "no objective is called `Fourth`"),
        ("--kind spi --objective First", "the kind `spi` takes no objective"),
        ("--kind achieve --objective First --choose cheap", "with `--kind achieve`, use `--choose likely`"),
        ("--kind sasi --choose likely", "with `--kind sasi`, use `--choose cheap`"),
    ] {
        for command in ["strategy", "simulate", "report"] {
            let found = run!("{command} {toy} {options}");
            let found = found.expect(2).stderr;
            assert!(
                found.contains(message) || command == "report" && found.contains("--choose"),
                "{command} {found}"
            );
        }
    }
    run!("export {toy} --objective First --out never").ends(2, "--kind");
}

#[test]
fn the_model_of_a_plan_settles_where_an_objective_is_achieved() {
    let scratch = Scratch::new(&[]);
    let out = scratch.path("out");
    let out = out.to_str().unwrap();
    run!("export {ROBOT} --format explicit --strategy plan:progress --out {out}").expect(0);
    let labels = scratch.read("out/plan-progress.lab");
    let (names, rows) = labels.split_once('\n').unwrap();
    let number = |name: &str| {
        let quoted = format!("=\"{name}\"");
        names.split(' ').find_map(|entry| entry.strip_suffix(quoted.as_str())).unwrap().to_owned()
    };
    let (settled, achieved) = (number("settled"), number("achieved"));
    let has = |row: &str, label: &str| row.split([' ', ':']).skip(1).any(|found| found == label);
    let ends: Vec<&str> = rows.lines().filter(|row| has(row, &settled)).collect();
    assert!(ends.len() > 2 && ends.iter().all(|row| has(row, &achieved)), "{labels}");
}

/// A plan that goes left or right gives up an objective of the other side.
pub(crate) const CROSS: [(&str, &str); 2] = [
    (
        "cross.prism",
        "mdp module m s : [0..6] init 0; [left] s=0 -> (s'=1); [right] s=0 -> (s'=2);\n\
         [c] s=1 -> (s'=3); [b] s=1 -> (s'=4); [d] s=2 -> (s'=5); [a] s=2 -> (s'=6); endmodule",
    ),
    (
        "cross.pref",
        "objective A = F s=6; objective B = F s=4; objective C = F s=3; objective D = F s=5;\n\
         prefer C > A; prefer D > B;",
    ),
];

#[test]
fn a_plan_that_must_choose_commits_and_is_not_said_to_weaken() {
    let scratch = Scratch::new(&CROSS);
    let cross = format!("{} {}", scratch.show("cross.prism"), scratch.show("cross.pref"));
    for safety in ["action", "transition", "prefix"] {
        for engine in ["symbolic", "explicit"] {
            let options = format!("{cross} --safety {safety} --engine {engine}");
            let report = run!("simulate {options} --json").expect(0).json();
            let runs = &report["plays"][0];
            assert_eq!(runs["commits"], json!([{"objective": "C", "gives_up": ["D"], "runs": 1000}]));
            for weakened in ["weakened_step", "weakened_reference", "weakened_start"] {
                assert_eq!(runs[weakened], 0, "{weakened}, {options}");
            }
            let first = &runs["trace"]["turns"][0];
            assert_eq!((&first["commits"], &first["gives_up"]), (&json!("C"), &json!(["D"])));
            let named = run!("simulate {options} --json --objective D").expect(0).json();
            let commits = json!([{"objective": "D", "gives_up": ["C"], "runs": 1000}]);
            assert_eq!(named["plays"][0]["commits"], commits);
        }
    }
    let text = run!("simulate {cross}").expect(0).stdout;
    assert!(text.contains("  1,000 runs: commits to C, gives up D.\n"), "{text}");
    assert!(text.contains("No run weakened the state of the step before (until it committed).\n"), "{text}");
    assert!(text.contains("commits to C, gives up D\n") && !text.contains("weakens:"), "{text}");
    let achieve = run!("simulate {cross} --kind achieve --objective C --json").expect(0).json();
    let runs = &achieve["plays"][0];
    assert_eq!((&runs["commits"], &runs["weakened_step"]), (&Json::Null, &json!(1000)));
}

#[test]
fn a_strategy_says_to_which_objective_it_commits_and_what_it_gives_up() {
    let scratch = Scratch::new(&CROSS);
    let cross = format!("{} {} --kind plan", scratch.show("cross.prism"), scratch.show("cross.pref"));
    let state = &run!("strategy {cross} --json").expect(0).json()["states"][0];
    assert_eq!((&state["commits"], &state["gives_up"]), (&json!(true), &json!(["D"])));
    assert_eq!(state["actions"][0]["reason"], "comes closer to C; gives up D");
    let after = &run!("strategy {cross} --json --at s=1").expect(0).json()["states"][0];
    assert_eq!((&after["commits"], &after["gives_up"]), (&json!(false), &json!([])));
    assert_eq!(after["pursues"], "B");
    let text = run!("strategy {cross}").expect(0).stdout;
    assert!(text.contains("  The plan commits to C, gives up D: kept actions do not achieve C\n"), "{text}");
    assert!(text.contains("left to 2 (gives up D)"), "{text}");
    let page = run!("report {cross} --out -").expect(0).stdout;
    assert!(page.contains("commits to C, gives up D") && !page.contains("weakens: D lost"));
}

#[test]
fn a_plan_takes_the_first_objective_that_needs_no_weakening_step() {
    // Going right loses C and risks nothing else; D comes after C in the file, and is kept alone.
    let model = "mdp module m s : [0..4] init 0; [left] s=0 -> (s'=1); [right] s=0 -> (s'=2);\n\
         [c] s=1 -> (s'=3); [b] s=1 -> (s'=4); endmodule";
    let preferences = "objective B = F s=4; objective C = F s=3; objective D = F s=2;\n\
         prefer D > B;";
    let scratch = Scratch::new(&[("m.prism", model), ("m.pref", preferences)]);
    let given = format!("{} {}", scratch.show("m.prism"), scratch.show("m.pref"));
    let state = &run!("strategy {given} --kind plan --json").expect(0).json()["states"][0];
    assert_eq!(state["most_preferred"], json!(["C", "D"]));
    assert_eq!((&state["pursues"], &state["commits"]), (&json!("D"), &json!(false)));
    assert_eq!(state["actions"][0]["verdict"], "weakens");
    let runs = &run!("simulate {given} --json").expect(0).json()["plays"][0];
    assert_eq!((&runs["commits"], &runs["weakened_step"]), (&json!([]), &json!(0)));
}

#[test]
fn an_objective_that_no_step_achieves_is_kept() {
    let model = "mdp module m s : [0..2] init 0; [stay] s=0 -> true; [go] s=0 -> (s'=1);\n\
         [back] s=1 -> 1/2:(s'=0) + 1/2:true; [fall] s=1 -> (s'=2); endmodule";
    let scratch = Scratch::new(&[("m.prism", model), ("m.pref", "objective G = G !(s=2);")]);
    let given = format!("{} {}", scratch.show("m.prism"), scratch.show("m.pref"));
    let runs = &run!("simulate {given} --json --steps 20").expect(0).json()["plays"][0];
    assert_eq!((&runs["achieved_runs"], &runs["kept_runs"]), (&json!(0), &json!(1000)));
    run!("simulate {given} --steps 20")
        .prints(0, "All runs kept a most preferred objective of their last state.");
}

#[test]
fn the_chosen_action_is_that_of_the_progress_strategy_unless_values_choose() {
    let scratch = Scratch::new(&[
        (
            "m.prism",
            "mdp module m s : [0..4]; [slow] s=0 -> 1/4:(s'=1) + 1/4:(s'=2) + 1/2:true; \
             [fast] s=0 -> 1/2:(s'=1) + 1/2:(s'=2); [end] s>0 & s<4 -> true; [go] s=4 -> (s'=1); endmodule \
             init s=0 | s=4 endinit",
        ),
        ("m.pref", "objective A = F s=1; objective B = F s=2;"),
    ]);
    let of = |options: &str| {
        let files = [scratch.show("m.prism"), scratch.show("m.pref")].join(" ");
        let report = run!("strategy {files} {options} --json").expect(0).json();
        let state = &report["states"][0];
        [&state["progress_action"], &state["chosen_action"]].map(|name| name.as_str().map(str::to_owned))
    };
    let named = |names: [&str; 2]| names.map(|name| Some(name.to_owned()));
    assert_eq!(of("--at s=0"), named(["slow", "slow"]));
    assert_eq!(of("--at s=0 --choose cheap"), named(["slow", "fast"]));
    // Nothing is left to improve, or the objective is achieved.
    for options in ["--at s=1", "--at s=1 --choose likely", "--at s=1 --kind achieve --objective A"] {
        assert_eq!(of(options), [None, None], "{options}");
    }
    assert_eq!(of("--at s=4"), [None, None]);
    // An objective is pursued at rank 0.
    assert_eq!(of("--at s=4 --kind plan"), named(["go", "go"]));
}

#[test]
fn csv_goes_to_a_file_or_to_standard_output_in_place_of_the_text() {
    let scratch = Scratch::new(&[]);
    let (file, dump) = (scratch.show("x.csv"), scratch.show("dump"));
    run!("export models/toy.prism models/toy.pref --out {dump}").expect(0);
    for (command, heading) in [
        ("strategy models/toy.prism models/toy.pref", "most_preferred,"),
        ("values models/toy.prism models/toy.pref", "sasi_rank"),
        ("simulate models/toy.prism models/toy.pref --runs 10", "start,run,step,"),
        ("check models/chain.prism models/chain.pref -c N=2:4", "N,states,"),
    ]
    .into_iter()
    .chain([(&*format!("query {dump} reachable"), "")])
    {
        let text = run!("{command} --csv {file}").expect(0).stdout;
        let written = std::fs::read_to_string(&file).unwrap();
        assert!(written.lines().next().unwrap().contains(heading), "{command}: {written}");
        assert!(text.lines().all(|line| Some(line) != written.lines().next()), "{command}: {text}");
        let printed = run!("{command} --csv -").expect(0).stdout;
        let without_times = |text: &str| match command.starts_with("check") {
            true => text.lines().map(|line| line.split(',').take(3).collect::<Vec<_>>().join(",")).collect(),
            false => text.to_owned(),
        };
        let (printed, written): (String, String) = (without_times(&printed), without_times(&written));
        assert_eq!(printed, written, "{command}");
        run!("{command} --csv - --json").expect(2);
    }
}

#[test]
fn only_commands_with_sweeps_promise_ranges() {
    for (command, sweeps) in [
        ("check", true),
        ("reach", true),
        ("compare", true),
        ("info", false),
        ("strategy", false),
        ("export", false),
    ] {
        let help = run!("{command} --help").expect(0).stdout;
        assert_eq!(help.contains("N=1:5"), sweeps, "{command}: {help}");
    }
    run("info models/chain.prism -c N=2:3").ends(2, "only `check`, `reach` and `compare` accept ranges");
}
