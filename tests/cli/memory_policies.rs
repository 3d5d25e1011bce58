//! Policies with memory: `strategy --policy` writes them, `verify` refuses lies about them, `simulate --policy` runs them.

use crate::common::prelude::*;

/// A model with its preferences.
type Case = [&'static str; 2];

/// Two posts that are to be seen again and again, on a path with ice between them.
const PATROL: Case = [
    "mdp module m x:[0..3] init 1; [l] x=1|x=2 -> (x'=x-1); [r] x=1|x=2 -> 0.5:(x'=x+1) + 0.5:(x'=x); \
     [b] x=0 -> (x'=1); [b] x=3 -> (x'=2); [stay] true -> true; endmodule",
    "objective Both = (G F x=0) & (G F x=3); objective Rest = F G x=1; prefer Both > Rest;",
];
/// A game: the safe way leads to an opponent, who decides how one of two better objectives is gained. The bold way may
/// violate the requirement.
const GAME: Case = [
    "smg player us [safe],[bold],[back],[on] endplayer player them [left],[right] endplayer module m s:[0..5] init 0; \
     [safe] s=0 -> (s'=1); [bold] s=0 -> 0.5:(s'=3) + 0.5:(s'=5); [back] s=0 -> (s'=2); \
     [left] s=1 -> 0.5:(s'=3) + 0.5:(s'=4); [right] s=1 -> 0.5:(s'=4) + 0.5:(s'=0); [on] s=2 -> (s'=0); \
     [on] s>2 -> true; endmodule",
    "objective Near = F s<2; objective Left = F s=3; objective Right = F s=4; prefer Left, Right > Near; \
     require G s!=5;",
];
/// From 0, a step sideways loses a sure objective, and then leads to something better than the rest, or not.
const SIDEWAYS: Case = [
    "mdp module m s:[0..4] init 0; [side] s=0 -> (s'=2); [up] s=2 -> 0.5:(s'=3) + 0.5:(s'=4); \
     [on] s>2 -> true; endmodule",
    "objective X = F s=0; objective Y = F (s=2|s=4); objective Z = F s=3; objective Top = F s=3; \
     prefer X > Z; prefer Top > Y;",
];
/// A plan can achieve one of two objectives only with something worse than the other one.
const COMMITS: Case = [
    "mdp module m s:[0..4] init 0; [a] s=0 -> 0.5:(s'=1) + 0.5:(s'=0); [b] s=1 -> (s'=2); [c] s=1 -> (s'=3); \
     [on] s>1 -> true; endmodule",
    "objective A = F s=2; objective B = F s=3; objective WithA = F s=2; objective WithB = F s=3; \
     objective Never = F s=4; prefer B > WithA; prefer A > WithB;",
];

fn files(scratch: &Scratch) -> [String; 3] {
    ["m.prism", "m.pref", "policy.json"].map(|name| scratch.show(name))
}

fn scratch([model, preferences]: Case) -> Scratch {
    Scratch::new(&[("m.prism", model), ("m.pref", preferences)])
}

fn strategy(scratch: &Scratch, options: &[&str]) -> Finished {
    let [model, preferences, policy] = files(scratch);
    Finished::of(executable().args(["strategy", &model, &preferences, "--policy", &policy]).args(options))
}

/// Lets `strategy` write a policy, and returns it.
fn written(scratch: &Scratch, options: &[&str]) -> Json {
    strategy(scratch, options).expect(0);
    serde_json::from_str(&fs::read_to_string(&files(scratch)[2]).unwrap()).unwrap()
}

fn verified(scratch: &Scratch) -> Finished {
    let [model, preferences, policy] = files(scratch);
    Finished::of(executable().args(["verify", &policy, &model, &preferences, "--json"]))
}

fn simulated(scratch: &Scratch) -> Json {
    let [model, preferences, policy] = files(scratch);
    let options = ["--runs", "200", "--steps", "300", "--json"];
    let asked = ["simulate", &model, &preferences, "--policy", &policy];
    Finished::of(executable().args(asked).args(options)).expect(0).json()
}

#[test]
fn policies_of_all_kinds_are_accepted_and_run() {
    let cases: [(Case, &[&str], [&str; 2]); 7] = [
        (PATROL, &["--objective", "Both"], ["achieve", "200"]),
        (PATROL, &["--kind", "plan"], ["plan", "200"]),
        (GAME, &["--kind", "sasi"], ["sasi", "0"]),
        (GAME, &["--kind", "plan"], ["plan", "0"]),
        (GAME, &["--kind", "achieve", "--objective", "Near", "--scheduler", "permissive"], ["achieve", "0"]),
        (SIDEWAYS, &["--kind", "spi", "--safety", "action"], ["spi", "0"]),
        (COMMITS, &["--kind", "plan", "--all"], ["plan", "0"]),
    ];
    for (case, options, [kind, given_up]) in cases {
        let scratch = scratch(case);
        assert_eq!(written(&scratch, options)["promise"]["kind"], json!(kind), "{options:?}");
        let report = verified(&scratch).expect(0).json();
        assert_eq!(report["accepted"], json!(true), "{options:?}");
        let runs = simulated(&scratch)["runs"].clone();
        assert_eq!(runs["done"]["weakened"], json!(0), "{options:?}");
        assert_eq!(runs["given_up"].to_string(), given_up, "{options:?}");
        let reached = runs["reached"].as_u64().unwrap();
        let expected = if given_up == "0" { 200 } else { 0 };
        assert!(
            reached == expected || kind == "spi" && 50 < reached && reached < 150,
            "{options:?}: {reached}"
        );
    }
}

#[test]
fn a_plan_that_must_give_up_an_objective_says_that_it_commits() {
    let scratch = scratch(COMMITS);
    let policy = written(&scratch, &["--kind", "plan"]);
    assert_eq!(policy["nodes"][0]["commits"], json!(true));
    assert_eq!(verified(&scratch).expect(0).json()["promise"]["committed"], json!(3));
}

/// Edits a policy and returns what `verify` says.
fn fault(case: Case, options: &[&str], edit: impl FnOnce(&mut Json)) -> String {
    let scratch = scratch(case);
    let mut policy = written(&scratch, options);
    verified(&scratch).expect(0);
    edit(&mut policy);
    fs::write(&files(&scratch)[2], policy.to_string()).unwrap();
    let refused = verified(&scratch);
    if refused.status == 3 {
        return refused.stderr;
    }
    refused.expect(1).json()["violation"]["condition"].as_str().unwrap().to_owned()
}

/// Returns the number of a node with a state.
fn node(policy: &Json, variable: &str, value: i64) -> usize {
    let nodes = policy["nodes"].as_array().unwrap();
    nodes.iter().position(|node| node["state"][variable] == json!(value)).unwrap()
}

#[test]
fn lies_about_improvements_are_refused() {
    let sasi = |edit: fn(&mut Json)| fault(GAME, &["--kind", "sasi"], edit);
    let wrong = sasi(|p| p["nodes"][0]["actions"][0]["action"] = json!("bold"));
    assert!(wrong.contains("do not have its successors"), "{wrong}");
    let wrong = sasi(|p| p["nodes"][0]["actions"][0]["action"] = json!("no"));
    assert!(wrong.contains("takes `no` in a state where this is not enabled"), "{wrong}");
    let wrong = sasi(|p| p["nodes"][0]["ahead"] = json!(2));
    assert!(wrong.contains("fewer improvements are sure"), "{wrong}");
    let wrong = sasi(|p| p["nodes"][1]["most_preferred"] = json!(["Left"]));
    assert!(wrong.contains("the most preferred objectives are {Near}"), "{wrong}");
    let wrong = sasi(|p| drop(p["nodes"][1]["actions"].as_array_mut().unwrap().pop()));
    assert!(wrong.contains("a choice of the opponent is missing"), "{wrong}");
    let wrong = sasi(|p| p["nodes"].as_array_mut().unwrap().last_mut().unwrap()["state"]["s"] = json!(5));
    assert!(wrong.contains("successors") || wrong.contains("requirements"), "{wrong}");
    let wrong = sasi(|p| p["nodes"][0]["state"]["s"] = json!(2));
    assert!(wrong.contains("no node starts in an initial state"), "{wrong}");
    let wrong = sasi(|p| drop(p["nodes"].as_array_mut().unwrap().pop()));
    assert!(wrong.contains("does not exist"), "{wrong}");
    let wrong = sasi(|p| p["promise"]["kind"] = json!("plan"));
    assert!(wrong.contains("pursues no most preferred objective"), "{wrong}");
    let wrong = sasi(|p| p["promise"]["kind"] = json!("achieve"));
    assert!(wrong.contains("makes no improvement"), "{wrong}");
    let wrong = sasi(|p| p["promise"]["safety"] = json!("transition"));
    assert!(wrong.contains("`prefix` or `action`, not `transition`"), "{wrong}");
}

#[test]
fn a_policy_that_goes_around_for_ever_makes_no_improvement() {
    let wrong = fault(GAME, &["--kind", "sasi"], |p| {
        let back = json!({"state": {"s": 2}, "most_preferred": ["Near"], "ahead": 1,
            "actions": [{"action": "on", "next": [0]}]});
        p["nodes"].as_array_mut().unwrap().push(back);
        let last = p["nodes"].as_array().unwrap().len() - 1;
        p["nodes"][0]["actions"] = json!([{"action": "back", "next": [last]}]);
    });
    assert!(wrong.contains("cannot make the improvements"), "{wrong}");
}

#[test]
fn a_possible_improvement_is_not_sold_as_a_sure_one() {
    let wrong =
        fault(SIDEWAYS, &["--kind", "spi", "--safety", "action"], |p| p["promise"]["kind"] = json!("sasi"));
    assert!(wrong.contains("fewer improvements are sure"), "{wrong}");
}

/// Under `action`, each step is compared with the state before. Such a policy is not one of `prefix`.
#[test]
fn steps_that_weaken_the_start_together_are_refused_under_prefix() {
    let wrong = fault(SIDEWAYS, &["--kind", "spi", "--safety", "action"], |p| {
        p["promise"]["safety"] = json!("prefix")
    });
    assert!(wrong.contains("a step"), "{wrong}");
}

#[test]
fn lies_about_objectives_are_refused() {
    let both = |edit: fn(&mut Json)| fault(PATROL, &["--objective", "Both"], edit);
    let wrong = both(|p| p["promise"]["objectives"] = json!(["Rest"]));
    assert!(wrong.contains("does not pursue the objectives"), "{wrong}");
    let wrong = both(|p| {
        p["promise"]["objectives"] = json!(["Rest"]);
        p["nodes"].as_array_mut().unwrap().iter_mut().for_each(|node| node["pursues"] = json!(["Rest"]));
    });
    assert!(wrong.contains("violates `Rest`"), "{wrong}");
    // The memory says which post is next: without it, the patrol stays at one.
    let wrong = both(|p| {
        let at = node(p, "x", 0);
        let back = node(p, "x", 1);
        p["nodes"][at]["actions"][0]["next"] = json!([back]);
        let left = json!([{"action": "l", "next": [at]}]);
        p["nodes"][back]["actions"] = left;
    });
    assert!(wrong.contains("violates `Both`") || wrong.contains("successors"), "{wrong}");
    let wrong = both(|p| p["nodes"][0]["actions"] = json!([]));
    assert!(wrong.contains("ends before `Both` is achieved"), "{wrong}");
    let near = |edit: fn(&mut Json)| fault(COMMITS, &["--kind", "plan"], edit);
    let wrong = near(|p| {
        p["nodes"].as_array_mut().unwrap().iter_mut().for_each(|node| node["commits"] = json!(false));
    });
    assert!(wrong.contains("a step"), "{wrong}");
    let wrong = near(|p| p["nodes"][0]["pursues"] = json!(["WithA"]));
    assert!(wrong.contains("not a most preferred one"), "{wrong}");
}

#[test]
fn one_target_is_achieved_by_rules_and_all_else_with_memory() {
    let scratch = scratch(COMMITS);
    strategy(&scratch, &["--objective", "A"]).expect(0);
    assert!(fs::read_to_string(&files(&scratch)[2]).unwrap().starts_with('['));
    let policy = written(&scratch, &["--objective", "A", "--all"]);
    assert_eq!((policy["starts"].clone(), &policy["promise"]["kind"]), (json!(3), &json!("achieve")));
    verified(&scratch).expect(0);
    // Without a name, the strategy is that of the command.
    assert_eq!(written(&scratch, &[])["promise"]["kind"], json!("sasi"));
    let several = written(&scratch, &["--kind", "spi", "--all"]);
    assert_eq!(several["starts"], json!(4));
    verified(&scratch).expect(0);
}

#[test]
fn what_no_policy_keeps_is_refused_by_name() {
    let scratch = scratch(COMMITS);
    let refused = |options: &[&str], what: &str| {
        let found = strategy(&scratch, options);
        assert!(found.status == 2 && found.stderr.contains(what), "{options:?}: {}", found.stderr);
    };
    refused(&["--safety", "transition"], "under `--safety transition`");
    refused(&["--kind", "spi", "--choose", "likely"], "`--policy` with `--choose` is not supported");
    refused(
        &["--objective", "Never", "--all"],
        "no policy is written: `Never` is not sure from the initial state s=0",
    );
    refused(&["--objective", "None"], "unknown objective `None`");
    let [model, preferences, policy] = files(&scratch);
    written(&scratch, &[]);
    let without = Finished::of(executable().args(["verify", &policy, &model]));
    assert!(without.status == 2 && without.stderr.contains("name the preference file"), "{}", without.stderr);
    strategy(&scratch, &["--objective", "A"]).expect(0);
    let rules = Finished::of(executable().args(["verify", &policy, &model, &preferences]));
    assert!(rules.status == 2 && rules.stderr.contains("leave out PREFS"), "{}", rules.stderr);
    // The text names another objective, or another thing.
    fs::write(&policy, "{\"format\": \"meliora policy 1\", \"promise\": 3}").unwrap();
    verified(&scratch).expect(3);
}
