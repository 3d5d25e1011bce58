//! Strategies of `multi(…)` in files: `verify` computes their values again, `simulate --policy` measures them.

use crate::common::prelude::*;

/// From 0, `a` leads to 1 or 2 and `b` to 3 or 4; 2 leads back at a cost; 5 and 6 form a cycle.
const MODEL: &str = "mdp\nmodule m\n x : [0..6] init 0;\n\
     [a] x=0 -> 0.5:(x'=1) + 0.5:(x'=2);\n [b] x=0 -> 1/3:(x'=3) + 2/3:(x'=4);\n [c] x=1 -> (x'=3);\n\
     [d] x=1 -> (x'=4);\n [e] x=2 -> (x'=0);\n [f] x=2 -> (x'=4);\n [g] x=0 -> 0.5:(x'=5) + 0.5:(x'=4);\n\
     [h] x=5 -> (x'=6);\n [i] x=6 -> (x'=5);\n [j] x=3 | x=4 -> true;\nendmodule\n\
     rewards \"cost\" [a] true : 1; [b] true : 0.5; [e] true : 2; endrewards\n";

/// Writes the strategies of a property; returns them with the paths of the model and of the file.
fn written(scratch: &Scratch, property: &str) -> (Json, [String; 2]) {
    let [model, out] = ["m.prism", "mix.json"].map(|name| scratch.show(name));
    let found = scratch.run(format!("reach m.prism --property '{property}' --policy mix.json"));
    let text = fs::read_to_string(&out).unwrap_or_else(|e| panic!("{property}: {e} {}", found.stderr));
    (serde_json::from_str(&text).unwrap(), [model, out])
}

fn verified(model: &str, file: &str) -> Finished {
    Finished::of(executable().args(["verify", file, model, "--json"]))
}

fn simulated(model: &str, file: &str, runs: &str) -> Finished {
    Finished::of(executable().args(["simulate", model, "--policy", file, "--runs", runs, "--json"]))
}

/// The kinds of objectives, also as negations.
const PROPERTIES: [&str; 9] = [
    "multi(Pmax=? [ F x=3 ], R{\"cost\"}<=2 [ F x>2 ])",
    "multi(P>=0.5 [ F x=3 ], P>=0.25 [ F x=4 ])",
    "multi(Pmax=? [ x!=1 U x=4 ], P>=0.1 [ F x=3 ])",
    "multi(Pmin=? [ G x!=3 ], R{\"cost\"}<=1.25 [ C ])",
    "multi(Pmax=? [ G F x=5 ], P>=0.25 [ F x=3 ])",
    "multi(Pmin=? [ F G x=4 ], P>=0.5 [ F x>2 ])",
    "multi(R{\"cost\"}max=? [ C<=3 ], P>=0.5 [ F x=4 ])",
    "multi(R{\"cost\"}min=? [ C ], P>=0.4 [ F x=3 ])",
    "multi(Pmax=? [ G x<=4 ], P<=0.75 [ F x=4 ])",
];

#[test]
fn strategies_of_several_objectives_are_verified_and_measured() {
    for property in PROPERTIES {
        let scratch = Scratch::new(&[("m.prism", MODEL)]);
        let (mix, [model, file]) = written(&scratch, property);
        let checked = verified(&model, &file).expect(0).json();
        assert_eq!(checked["accepted"], json!(true), "{property}");
        let count = mix["strategies"].as_array().unwrap().len();
        assert_eq!(checked["strategies"].as_array().unwrap().len(), count, "{property}");
        let found = simulated(&model, &file, "4000").expect(0).json();
        assert_eq!(found["runs"]["reached"], json!(4000), "{property}");
        for own in found["runs"]["objectives"].as_array().unwrap() {
            let [low, high] = [0, 1].map(|at| own["interval"][at].as_f64().unwrap());
            let (claimed, wide) = (own["claimed"].as_f64().unwrap(), high - low);
            assert!(low - wide <= claimed && claimed <= high + wide, "{property}: {own}");
            assert!(wide < 0.4, "{property}: {own}");
        }
    }
}

/// After one step, no run has decided both objectives; after two, some have.
#[test]
fn runs_that_are_given_up_are_not_counted_as_decided() {
    let scratch = Scratch::new(&[("m.prism", MODEL)]);
    let (_, files) = written(&scratch, "multi(Pmax=? [ F x=3 ], R{\"cost\"}<=2 [ F x>2 ])");
    let runs = |steps: &str| {
        let more = ["--policy", &files[1], "--runs", "1000", "--steps", steps, "--json"];
        let found = Finished::of(executable().args(["simulate", &files[0]]).args(more)).expect(0).json();
        found["runs"]["reached"].as_u64().unwrap()
    };
    assert_eq!(runs("1"), 0);
    let some = runs("2");
    assert!(0 < some && some < 1000, "{some}");
}

/// Changes the first strategy, or the file.
type Edit = fn(&mut Json);

/// Returns what `verify` and `simulate` say of an edited file.
fn judged(edit: Edit) -> [Finished; 2] {
    let scratch = Scratch::new(&[("m.prism", MODEL)]);
    let (mut mix, [model, file]) = written(&scratch, PROPERTIES[0]);
    edit(&mut mix);
    fs::write(&file, mix.to_string()).unwrap();
    [verified(&model, &file), simulated(&model, &file, "10")]
}

#[test]
fn strategies_of_another_model_are_refused() {
    let fails: [(Edit, &str); 4] = [
        (
            |m| m["strategies"][0]["nodes"][0]["actions"] = json!([]),
            "has no action in a state that it visits",
        ),
        (
            |m| m["strategies"][0]["nodes"][0]["actions"][0]["successors"][0]["probability"] = json!(0.25),
            "are not its successors with their probabilities",
        ),
        (
            |m| {
                let all = m["strategies"][0]["nodes"][0]["actions"][0]["successors"].as_array_mut();
                all.unwrap().truncate(1);
            },
            "are not its successors with their probabilities",
        ),
        (
            |m| m["strategies"][0]["nodes"].as_array_mut().unwrap().rotate_left(1),
            "does not begin in the initial state",
        ),
    ];
    for (edit, condition) in fails {
        for found in judged(edit) {
            let found = found.expect(1).json();
            let said = found["violation"]["condition"].as_str().unwrap();
            assert!(said.contains(condition), "{said}");
        }
    }
}

#[test]
fn false_claims_are_refused() {
    let claims: [(Edit, &str); 3] = [
        (
            |m| {
                let value = &mut m["strategies"][0]["values"][0];
                *value = json!(value.as_f64().unwrap() + 1e-9);
            },
            "does not attain the value",
        ),
        (
            |m| {
                let value = &mut m["strategies"][0]["values"][1];
                *value = json!(value.as_f64().unwrap() - 1e-9);
            },
            "does not attain the value",
        ),
        (
            |m| m["property"] = json!("multi(Pmax=? [ F x=3 ], R{\"cost\"}<=0.1 [ F x>2 ])"),
            "the strategies together do not satisfy `R{\"cost\"}<=0.1 [ F x>2 ]`",
        ),
    ];
    for (edit, condition) in claims {
        let [found, _] = judged(edit);
        let said = found.expect(1).json()["violation"]["condition"].as_str().unwrap().to_owned();
        assert!(said.contains(condition), "{said}");
    }
}

#[test]
fn files_that_are_no_strategies_are_errors() {
    let texts: [(Edit, i32, &str); 10] = [
        (|m| m["strategies"][0]["share"] = json!("1/2"), 3, "sum to 1"),
        (|m| m["strategies"][0]["share"] = json!(-1), 3, "sum to 1"),
        (|m| m["strategies"][0]["share"] = json!("1/0"), 3, "expected a decimal number, or a fraction"),
        (|m| m["strategies"][0]["nodes"][0]["decided"] = json!([1, 0]), 3, "in ascending order"),
        (|m| m["strategies"][0]["share"] = json!(0.9), 3, "sum to 1"),
        (|m| m["strategies"] = json!([]), 3, "sum to 1"),
        (
            |m| m["strategies"][0]["nodes"][0]["state"] = json!({"y": 0}),
            3,
            "`y=0` is not a state of the model",
        ),
        (|m| m["strategies"][0]["nodes"][0]["actions"][0]["action"] = json!("z"), 3, "is not `z`"),
        (|m| m["strategies"][0]["values"] = json!([1]), 2, "one value for each of the 2 objectives"),
        (|m| m["property"] = json!("Pmax=? [ F x=3 ]"), 3, "expected one strategy for one operator"),
    ];
    for (edit, status, message) in texts {
        for found in judged(edit) {
            found.ends(status, message);
        }
    }
}

/// The strategies of a front have no shares, so none can be drawn.
#[test]
fn a_front_is_verified_and_not_simulated() {
    let scratch = Scratch::new(&[("m.prism", MODEL)]);
    let (_, [model, file]) = written(&scratch, "multi(Pmax=? [ F x=3 ], Pmax=? [ G F x=5 ])");
    let found = verified(&model, &file).expect(0).json();
    assert!(found["strategies"].as_array().unwrap().len() > 1, "{found}");
    simulated(&model, &file, "10").ends(2, "have no shares");
    Finished::of(executable().args(["verify", &file, &model, "--strong"]))
        .ends(2, "have objectives of their own");
}

/// Runs `verify` on a file with one strategy, or several, each of one step from 0 and a loop.
fn judged_mix(property: &str, strategies: &[(&str, &str, [f64; 2])]) -> Finished {
    const MODEL: &str = "mdp\nmodule m\n s : [0..3] init 0;\n [a] s=0 -> 1/2:(s'=1) + 1/2:(s'=2);\n\
         [c] s=0 -> (s'=3);\n [d] s>0 -> true;\nendmodule\nrewards \"r\" [a] s=0 : 1000000000; endrewards\n";
    let scratch = Scratch::new(&[("m.prism", MODEL)]);
    let node = |state: usize, action: &str, position: usize, next: &[usize]| {
        let p = 1.0 / next.len() as f64;
        let to: Vec<_> = next.iter().map(|to| json!({"node": to, "probability": p})).collect();
        let actions = json!([{"action": action, "position": position, "successors": to}]);
        json!({"state": {"s": state}, "decided": [], "steps": 0, "actions": actions})
    };
    let one = |(share, action, values): &(&str, &str, [f64; 2])| {
        let nodes = match *action {
            "a" => json!([node(0, "a", 0, &[1, 2]), node(1, "d", 0, &[1]), node(2, "d", 0, &[2])]),
            _ => json!([node(0, "c", 1, &[1]), node(3, "d", 0, &[1])]),
        };
        let mut strategy = json!({"values": values, "nodes": nodes});
        strategy["share"] = serde_json::from_str(share).unwrap();
        strategy
    };
    let mut mix = json!({"property": property});
    mix["strategies"] = strategies.iter().map(one).collect();
    // What the paths decide: s=1 is the first objective, s=3 the second one, unless the property has rewards.
    for node in mix["strategies"]
        .as_array_mut()
        .unwrap()
        .iter_mut()
        .flat_map(|own| own["nodes"].as_array_mut().unwrap())
    {
        match node["state"]["s"].as_u64() {
            Some(1) if !property.contains("R{") => node["decided"] = json!([0]),
            Some(3) => node["decided"] = json!([1]),
            _ => {}
        }
    }
    scratch.write("mix.json", mix.to_string());
    verified(&scratch.show("m.prism"), &scratch.show("mix.json"))
}

const A: [f64; 2] = [0.5, 0.0];
const C: [f64; 2] = [0.0, 1.0];

#[test]
fn shares_are_fractions_that_sum_to_one() {
    let third = "multi(P>=1/6 [ F s=1 ], P>=2/3 [ F s=3 ])";
    judged_mix(third, &[("\"1/3\"", "a", A), ("\"2/3\"", "c", C)]).expect(0);
    judged_mix(third, &[("\"0.33333333333333333\"", "a", A), ("\"0.66666666666666667\"", "c", C)]).expect(1);
    judged_mix("multi(P>=0.1 [ F s=1 ], P>=0.8 [ F s=3 ])", &[("0.2", "a", A), ("0.8", "c", C)]).expect(0);
    // A slack of a millionth would be multiplied by the rewards.
    let much = "multi(R{\"r\"}>=1000000900 [ C ], P>=0 [ F s=3 ])";
    judged_mix(much, &[("1", "a", [1e9, 0.0]), ("9e-7", "a", [1e9, 0.0])]).expect(3);
    let little = "multi(R{\"r\"}<=999999100 [ C ], P>=0 [ F s=3 ])";
    judged_mix(little, &[("0.9999991", "a", [1e9, 0.0]), ("0", "c", C)]).expect(3);
}

#[test]
fn shares_are_needed_where_the_property_has_bounds() {
    let bounds = "multi(P>=1 [ F s=1 ], P>=1 [ F s=3 ])";
    let found = judged_mix(bounds, &[("null", "a", A), ("null", "c", C)]).expect(1).json();
    assert!(found["violation"]["condition"].as_str().unwrap().contains("have no shares"), "{found}");
    let front = "multi(Pmax=? [ F s=1 ], Pmax=? [ F s=3 ])";
    judged_mix(front, &[("null", "a", A), ("null", "c", C)]).ends(0, "a front may be incomplete");
    judged_mix(front, &[("0.5", "a", A), ("null", "c", C)]).expect(3);
}

#[test]
fn bounds_have_no_slack() {
    let bound = |p: &str| format!("multi(P>={p} [ F s=1 ], P>=0 [ F s=3 ])");
    judged_mix(&bound("0.5"), &[("1", "a", A)]).expect(0);
    judged_mix(&bound("0.500001"), &[("1", "a", A)]).expect(1);
    judged_mix(&bound("0.50000000000000000001"), &[("1", "a", A)]).expect(1);
    let sure = "multi(P>=0 [ F s=1 ], P>=1 [ F s=3 ])";
    judged_mix(sure, &[("0.999999", "c", C), ("0.000001", "a", A)]).expect(1);
    judged_mix(sure, &[("1", "c", C), ("0", "a", A)]).expect(0);
    judged_mix(&bound("0"), &[("1", "a", [0.5000000000000001, 0.0])]).expect(1);
}

#[test]
fn memory_that_no_path_has_and_doubled_variables_are_refused() {
    let memories: [(Edit, &str); 3] = [
        (|m| m["strategies"][0]["nodes"][0]["decided"] = json!([0]), "`decided` and `steps`"),
        (|m| m["strategies"][0]["nodes"][1]["steps"] = json!(77), "`decided` and `steps`"),
        (
            |m| {
                let nodes = m["strategies"][0]["nodes"].as_array_mut().unwrap();
                nodes.push(nodes[0].clone());
            },
            "`decided` and `steps`",
        ),
    ];
    for (edit, condition) in memories {
        for found in judged(edit) {
            let found = found.expect(1).json();
            assert!(found["violation"]["condition"].as_str().unwrap().contains(condition), "{found}");
        }
    }
    let scratch = Scratch::new(&[("m.prism", MODEL)]);
    let (_, [model, file]) = written(&scratch, PROPERTIES[0]);
    let text = fs::read_to_string(&file).unwrap().replacen("\"x\": 0", "\"x\": 3, \"x\": 0", 1);
    fs::write(&file, text).unwrap();
    verified(&model, &file).ends(3, "the variable `x` occurs twice");
}
