//! Shields on random models: the promise holds, and secure nodes are the greatest such set.

use meliora::export::{read_shield, write_shield};
use meliora::{Choose, Options};
use sha2::{Digest, Sha256};

use crate::common::prelude::*;

/// Returns a model of eight states with random branches, and wishes about three of them.
fn analysed(seed: u64, safety: Safety) -> meliora::Analysis {
    let mut random = SmallRng::seed_from_u64(seed);
    let mut text = "mdp module m s : [0..7] init 0;\n".to_owned();
    for state in 0..8 {
        for action in ["a", "b", "c"].iter().take(random.random_range(1..4)) {
            // Most steps lead to later states, so decisions are final.
            let low = if random.random_bool(0.9) { state } else { 0 };
            let [one, other] = [0; 2].map(|_| random.random_range(low..8));
            text += &format!("[{action}] s={state} -> 1/2: (s'={one}) + 1/2: (s'={other});\n");
        }
    }
    let model = Model::parse(text + "endmodule", "").unwrap();
    let wishes = "objective A = F s=5; objective B = F s=6; objective C = F s=7; prefer A, B > C;";
    let explored = model.explore(Settings::default()).unwrap();
    let options = Options { safety, ..Options::default() };
    let mut analysis = explored.prefer(&SourceFile::new("wishes", wishes), options).unwrap();
    analysis.run(&mut |_| ()).unwrap();
    analysis
}

fn shield(seed: u64, safety: Safety, kind: Kind) -> Shield {
    Shield::new(&mut analysed(seed, safety).strategy(kind).unwrap(), 1000).unwrap()
}

/// Returns the nodes from which a permitted step may weaken now or later. While improvements are
/// ahead, the agent may choose badly among the permitted actions; at level 0 it avoids the worst.
fn threatened(shield: &Shield) -> Vec<bool> {
    let nodes = &shield.nodes;
    let mut bad = vec![false; nodes.len()];
    for _ in 0..nodes.len() {
        for (v, node) in nodes.iter().enumerate() {
            let threat = |next: &Vec<usize>| {
                next.iter().any(|&to| {
                    let class = nodes[to].class.unwrap();
                    bad[to] || shield.weakening[node.reference].contains(&class)
                })
            };
            let mut threats = node.actions.iter().filter(|a| a.permitted).map(|a| threat(&a.next));
            bad[v] |= match node.ahead {
                Some(0) => node.actions.iter().all(|a| threat(&a.next)),
                _ => threats.any(|threat| threat),
            };
        }
    }
    bad
}

#[test]
fn secure_nodes_are_those_that_nothing_threatens() {
    let (mut secure, mut others, mut ahead) = (0, 0, 0);
    for seed in 0..share(150) as u64 {
        for (safety, kind) in [(Safety::Action, Kind::Sasi), (Safety::Action, Kind::Spi)] {
            let shield = shield(seed, safety, kind);
            assert_eq!(shield.fault(), None);
            let bad = threatened(&shield);
            for (v, node) in shield.nodes.iter().enumerate() {
                assert_eq!(node.secure, !bad[v], "seed {seed}, node {v}");
                secure += usize::from(node.secure);
                others += usize::from(!node.secure);
                ahead += usize::from(node.ahead != Some(0));
            }
        }
    }
    assert!(secure > share(100) && others > 0 && ahead > share(20), "{secure} {others} {ahead}");
}

/// Returns the shield of states 0 to 3 with these commands, under `prefix`.
fn under_prefix(commands: &str, wishes: &str) -> Shield {
    let model = Model::parse(format!("mdp module m s : [0..3] init 0; {commands} endmodule"), "");
    let explored = model.unwrap().explore(Settings::default()).unwrap();
    let options = Options { safety: Safety::Prefix, ..Options::default() };
    let mut analysis = explored.prefer(&SourceFile::new("wishes", wishes), options).unwrap();
    analysis.run(&mut |_| ()).unwrap();
    Shield::new(&mut analysis.strategy(Kind::Sasi).unwrap(), 1000).unwrap()
}

/// A step to an incomparable class made that class the reference, and the next one could weaken the start.
#[test]
fn under_prefix_an_incomparable_step_does_not_change_the_reference() {
    let mut shield = under_prefix(
        "[go] s=0 -> (s'=1); [risk] s=1 -> 1/2:(s'=2) + 1/2:(s'=3); [stay] true -> true;",
        "objective A = F s=0; objective B = F (s=1 | s=3); objective C = F s=2; prefer A > C;",
    );
    assert_eq!(shield.fault(), None);
    let node =
        |shield: &Shield, state: i64| shield.nodes.iter().position(|node| node.state[0] == state).unwrap();
    let allowed = |shield: &Shield, v: usize| {
        let permitted = shield.nodes[v].actions.iter().filter(|action| action.permitted);
        Vec::from_iter(permitted.map(|action| shield.actions[action.action].clone()))
    };
    let start = node(&shield, 0);
    assert_eq!(allowed(&shield, start), ["go", "stay"]);
    let after = shield.nodes[start].actions[0].next[0];
    assert_eq!((shield.nodes[after].state[0], shield.nodes[after].secure), (1, true));
    assert_eq!(allowed(&shield, after), ["stay"]);
    // An episode that starts there has promised nothing about A.
    assert_eq!(allowed(&shield, node(&shield, 1)), ["risk", "stay"]);
    // A table that changes the reference by such a step is refused.
    shield.nodes[start].actions[0].next = vec![node(&shield, 1)];
    assert!(shield.fault().unwrap().contains("`go` weakens or ends the promise"), "{:?}", shield.fault());
}

#[test]
fn a_table_with_a_weakening_step_is_refused() {
    let mut refused = 0;
    for seed in 0..share(50) as u64 {
        let shield = shield(seed, Safety::Action, Kind::Sasi);
        for v in 0..shield.nodes.len() {
            let mut changed = shield.clone();
            changed.nodes[v].actions.iter_mut().for_each(|action| action.permitted = true);
            refused += usize::from(changed.fault().is_some());
            changed.nodes[v].reference = 99;
            assert!(changed.fault().is_some());
        }
    }
    assert!(refused > share(10), "{refused}");
}

#[test]
fn strategies_that_may_weaken_have_no_shield() {
    let mut strategy = analysed(1, Safety::Transition).strategy(Kind::Sasi).unwrap();
    assert!(matches!(Shield::new(&mut strategy, 1000), Err(Error::Usage(_))));
    let mut strategy = analysed(1, Safety::Action).strategy(Kind::Sasi).unwrap();
    assert!(matches!(Shield::new(&mut strategy, 2), Err(Error::Limit(_))));
}

#[test]
fn a_saved_shield_replaces_an_older_one_and_nothing_else() {
    let (folder, new) = (tempfile::tempdir().unwrap(), shield(1, Safety::Action, Kind::Sasi));
    let names = || {
        let entries = std::fs::read_dir(folder.path().join("deep")).unwrap();
        Vec::from_iter(entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()))
    };
    let path = folder.path().join("deep/shield");
    for seed in [2, 1] {
        write_shield(&shield(seed, Safety::Action, Kind::Sasi), &path).unwrap();
        assert_eq!(names(), ["shield"]);
    }
    assert_eq!(read_shield(&path).unwrap().nodes.len(), new.nodes.len());
    std::fs::write(path.join("letter.txt"), "mine").unwrap();
    let refused = write_shield(&shield(2, Safety::Action, Kind::Sasi), &path).unwrap_err().to_string();
    assert!(refused.contains("`letter.txt`, which does not belong to the shield"), "{refused}");
    assert_eq!(read_shield(&path).unwrap().nodes.len(), new.nodes.len());
    assert_eq!(names(), ["shield"]);
}

/// Two files of the user were deleted because of their names.
#[test]
fn a_shield_replaces_only_files_that_are_as_they_were_written() {
    let folder = tempfile::tempdir().unwrap();
    let again = || write_shield(&shield(2, Safety::Action, Kind::Sasi), folder.path());
    std::fs::write(folder.path().join("nodes.json"), "mine").unwrap();
    assert!(again().is_err());
    std::fs::remove_file(folder.path().join("nodes.json")).unwrap();
    again().unwrap();
    std::fs::write(folder.path().join("nodes.json"), "mine").unwrap();
    let refused = again().unwrap_err().to_string();
    assert!(
        refused.contains("`nodes.json`, which does not belong to the shield as it was written"),
        "{refused}"
    );
    assert_eq!(std::fs::read_to_string(folder.path().join("nodes.json")).unwrap(), "mine");
    std::fs::write(folder.path().join("shield.json"), "mine").unwrap();
    assert!(again().is_err());
    assert_eq!(std::fs::read_to_string(folder.path().join("shield.json")).unwrap(), "mine");
}

/// Writes a table as an attacker would: with the hash that fits. Returns the refusal.
fn refused(table: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let nodes = serde_json::from_str::<Json>(table).unwrap()["nodes"].as_array().unwrap().len();
    let hash = Sha256::digest(table.as_bytes());
    let sha256: String = hash.iter().map(|byte| format!("{byte:02x}")).collect();
    let manifest = json!({"format": "meliora shield 1", "sha256": sha256, "nodes": nodes});
    std::fs::write(folder.path().join("nodes.json"), table).unwrap();
    std::fs::write(folder.path().join("shield.json"), manifest.to_string()).unwrap();
    read_shield(folder.path()).map_or_else(|error| error.to_string(), |_| String::new())
}

/// The shield of `s`: from 0 a step leads to 1, where A is achieved, or to 2, where B is; A and B are
/// preferred to C, which 3 achieves, and which `risk` may lead to.
fn small() -> Json {
    let model = Model::parse(
        "mdp module m s : [0..3] init 0; [go] s=0 -> 1/2:(s'=1) + 1/2:(s'=2); [wait] s<3 -> true; \
         [risk] s<3 -> (s'=3); [rest] s=3 -> true; endmodule",
        "",
    );
    let wishes = "objective A = F s=1; objective B = F s=2; objective C = F s=3; prefer A, B > C;";
    let explored = model.unwrap().explore(Settings::default()).unwrap();
    let mut analysis = explored.prefer(&SourceFile::new("wishes", wishes), Options::default()).unwrap();
    analysis.run(&mut |_| ()).unwrap();
    let shield = Shield::new(&mut analysis.strategy(Kind::Sasi).unwrap(), 1000).unwrap();
    assert_eq!(shield.fault(), None);
    serde_json::to_value(&shield).unwrap()
}

/// Returns the position of the node of a state.
fn at(table: &Json, state: i64) -> usize {
    table["nodes"].as_array().unwrap().iter().position(|node| node["state"] == json!([state])).unwrap()
}

/// Returns the position of a node's action.
fn action(table: &Json, node: usize, name: &str) -> usize {
    let number = table["actions"].as_array().unwrap().iter().position(|action| action == name).unwrap();
    let actions = table["nodes"][node]["actions"].as_array().unwrap();
    actions.iter().position(|action| action["action"] == number).unwrap()
}

/// Changes the table of `small`, and returns the refusal.
fn refused_after(change: impl Fn(&mut Json)) -> String {
    let mut table = small();
    change(&mut table);
    refused(&table.to_string())
}

/// A second entry permitted an action that the first one forbids.
#[test]
fn a_repeated_action_cannot_break_the_promise() {
    let refusal = refused_after(|table| {
        let one = at(table, 1);
        let risk = action(table, one, "risk");
        assert_eq!(table["nodes"][one]["secure"], true);
        let mut entry = table["nodes"][one]["actions"][risk].clone();
        assert_eq!(entry["permitted"], false);
        entry["permitted"] = true.into();
        entry["next"] = json!([one]);
        table["nodes"][one]["actions"].as_array_mut().unwrap().push(entry);
    });
    assert!(refusal.ends_with("node 1, s=1: two entries for the action `risk`"), "{refusal}");
}

#[test]
fn a_step_to_nowhere_is_refused() {
    let empty = |table: &mut Json| {
        let one = at(table, 1);
        let risk = action(table, one, "risk");
        table["nodes"][one]["actions"][risk] = json!({"action": table["nodes"][one]["actions"][risk]["action"],
            "permitted": true, "next": []});
    };
    assert!(refused_after(empty).ends_with("the action `risk` has no successor"), "{}", refused_after(empty));
}

#[test]
fn kinds_modes_and_names_of_a_shield_are_known_and_occur_once() {
    let set = |key: &'static str, value: Json| refused_after(move |table| table[key] = value.clone());
    for (refusal, end) in [
        (set("kind", "best".into()), "the kind is `best`, expected `sasi` or `spi` or `plan` or `achieve`"),
        (
            set("safety", "transition".into()),
            "the safety mode is `transition`, expected `action` or `prefix`",
        ),
        (set("actions", json!(["go", "wait", "risk", "wait"])), "two actions are called `wait`"),
        (set("classes", json!([["A", "B"], ["A", "A"], [], ["C"]])), "has the objective `A`"),
        (set("starts", 9.into()), "9 start states, but 4 nodes"),
        (set("weakening", json!([])), "lists of weakening classes"),
    ] {
        assert!(refusal.ends_with(end), "{refusal}");
    }
    let twice = |table: &mut Json| {
        let [one, two] = [at(table, 1), at(table, 2)];
        table["nodes"][two]["state"] = table["nodes"][one]["state"].clone();
    };
    assert!(refused_after(twice).ends_with("two start nodes have the state s=1"), "{}", refused_after(twice));
}

/// `ahead` without a value is unbounded; a file that leaves it out must not promise that.
#[test]
fn a_field_that_is_left_out_or_given_twice_is_refused() {
    let without = |table: &mut Json| {
        table["nodes"][0].as_object_mut().unwrap().shift_remove("ahead");
    };
    assert!(refused_after(without).contains("missing field `ahead`"), "{}", refused_after(without));
    let text = small().to_string().replacen("\"starts\":", "\"starts\":0,\"starts\":", 1);
    assert!(refused(&text).contains("duplicate field `starts`"), "{}", refused(&text));
}

#[test]
fn improvements_that_permitted_steps_cannot_make_are_not_promised() {
    let end = "improvements are ahead, but permitted steps cannot make the next one";
    for ahead in [json!(1), Json::Null] {
        let more = |table: &mut Json| {
            let one = at(table, 1);
            table["nodes"][one]["ahead"] = ahead.clone();
        };
        assert!(refused_after(more).ends_with(end), "{}", refused_after(more));
    }
    // From 0, one improvement is ahead: not two, and not without `go`.
    let two = |table: &mut Json| {
        let zero = at(table, 0);
        table["nodes"][zero]["ahead"] = 2.into();
    };
    assert!(refused_after(two).ends_with(end), "{}", refused_after(two));
    let idle = |table: &mut Json| {
        let zero = at(table, 0);
        let [go, wait] = ["go", "wait"].map(|name| action(table, zero, name));
        table["nodes"][zero]["actions"][go]["permitted"] = false.into();
        table["nodes"][zero]["pick"] = wait.into();
    };
    assert!(refused_after(idle).ends_with(end), "{}", refused_after(idle));
}

/// With another reference, a weakening step would pass as harmless.
#[test]
fn a_foreign_reference_is_refused() {
    let foreign = |table: &mut Json| {
        let [one, three] = [at(table, 1), at(table, 3)];
        table["nodes"][one]["reference"] = table["nodes"][three]["reference"].clone();
    };
    let refusal = refused_after(foreign);
    assert!(refusal.ends_with("node 1, s=1: the reference is not the class of the state"), "{refusal}");
}

#[test]
fn successors_with_one_state_are_refused() {
    let double = |table: &mut Json| {
        let [zero, one, two] = [0, 1, 2].map(|state| at(table, state));
        let monitor = json!({"name": "seen", "boolean": false, "low": 0, "values": [], "monitor": 0});
        table["variables"].as_array_mut().unwrap().push(monitor);
        for (number, node) in table["nodes"].as_array_mut().unwrap().iter_mut().enumerate() {
            node["state"].as_array_mut().unwrap().push(number.into());
        }
        // Two successors that differ in the monitor only.
        table["nodes"][two]["state"] = json!([1, 9]);
        assert_eq!(table["nodes"][zero]["actions"][0]["next"], json!([one, two]));
    };
    let refusal = refused_after(double);
    assert!(refusal.ends_with("the successors 1 and 2 have the same state s=1,seen=9"), "{refusal}");
}

#[test]
fn a_table_that_gives_up_what_it_pursues_is_refused() {
    let mut refused = 0;
    for seed in 0..share(300) as u64 {
        let analysis = analysed(seed, Safety::Action);
        let mut strategy = analysis.strategy_of(StrategyKind::Achieve, Choose::First, Some("A")).unwrap();
        let shield = Shield::new(&mut strategy, 1000).unwrap();
        let pursues = |v: &usize| !shield.nodes[*v].pursues.is_empty() && !shield.nodes[*v].achieved;
        for v in (0..shield.nodes.len()).filter(pursues) {
            let lost = shield.nodes[v].actions.iter().any(|action| !action.permitted);
            let mut changed = shield.clone();
            changed.nodes[v].actions.iter_mut().for_each(|action| action.permitted = true);
            assert_eq!(changed.fault().is_some(), lost, "seed {seed}, node {v}");
            refused += usize::from(lost);
            let mut changed = shield.clone();
            changed.nodes.iter_mut().for_each(|node| node.achieved = false);
            assert!(changed.fault().is_some(), "seed {seed}");
        }
    }
    assert!(refused > share(20), "{refused}");
}

/// Returns the table with one node more: a second one for the state of another node.
fn doubled(state: i64, change: impl Fn(&mut Json)) -> String {
    refused_after(|table| {
        let (zero, own, new) = (at(table, 0), at(table, state), table["nodes"].as_array().unwrap().len());
        let mut node = table["nodes"][own].clone();
        change(&mut node);
        table["nodes"].as_array_mut().unwrap().push(node);
        let go = action(table, zero, "go");
        for to in table["nodes"][zero]["actions"][go]["next"].as_array_mut().unwrap() {
            if *to == own {
                *to = new.into();
            }
        }
    })
}

#[test]
fn nodes_of_one_state_that_contradict_each_other_are_refused() {
    assert_eq!(doubled(1, |_| {}), "");
    let other_class = doubled(1, |node| node["class"] = 0.into());
    assert!(other_class.contains("has another class or other steps"), "{other_class}");
    let other_steps = doubled(1, |node| node["actions"][0]["next"] = json!([3]));
    assert!(other_steps.contains("has another class or other steps"), "{other_steps}");
    let without = doubled(1, |node| drop(node["actions"].as_array_mut().unwrap().pop()));
    assert!(without.contains("has another class or other steps"), "{without}");
    let theirs = doubled(3, |node| node["theirs"] = true.into());
    assert!(theirs.contains("has another owner or other steps"), "{theirs}");
}

/// From 0, `go` may miss A.
#[test]
fn a_shield_of_possible_improvements_is_none_of_sure_ones() {
    let model =
        "mdp module m s : [0..2] init 0; [go] s=0 -> 1/2:(s'=1) + 1/2:(s'=2); [end] s>0 -> true; endmodule";
    let explored = Model::parse(model, "").unwrap().explore(Settings::default()).unwrap();
    let mut analysis =
        explored.prefer(&SourceFile::new("wishes", "objective A = F s=1;"), Options::default()).unwrap();
    analysis.run(&mut |_| ()).unwrap();
    let mut shield = Shield::new(&mut analysis.strategy(Kind::Spi).unwrap(), 1000).unwrap();
    assert_eq!(shield.fault(), None);
    for kind in ["sasi", "plan"] {
        shield.kind = kind.to_owned();
        let fault = shield.fault().unwrap();
        assert!(
            fault.ends_with("after the permitted action `go`, fewer improvements may be ahead without one"),
            "{fault}"
        );
    }
}

#[test]
fn the_objective_of_achieve_does_not_change_on_the_way() {
    let mut refused = 0;
    for seed in 0..share(50) as u64 {
        let analysis = analysed(seed, Safety::Action);
        let mut strategy = analysis.strategy_of(StrategyKind::Achieve, Choose::First, Some("A")).unwrap();
        let mut shield = Shield::new(&mut strategy, 1000).unwrap();
        assert_eq!(shield.fault(), None);
        let mut pursuing = (0..shield.nodes.len()).filter(|&v| !shield.nodes[v].pursues.is_empty());
        let Some(second) = pursuing.nth(1) else { continue };
        shield.nodes[second].pursues = vec!["B".to_owned()];
        assert!(shield.fault().unwrap().contains("pursues other objectives"), "{:?}", shield.fault());
        refused += 1;
    }
    assert!(refused > share(10), "{refused}");
}
