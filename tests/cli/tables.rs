//! Whole strategies and runs as tables that other programs can follow.

use std::io::Read;
use std::process::Stdio;

use crate::common::prelude::*;

type Row = BTreeMap<String, String>;

/// Reads lines of comma-separated values.
fn rows(text: &str) -> Vec<Row> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    reader.deserialize().map(Result::unwrap).collect()
}

const ROBOT: &str = "models/robot5x5.prism models/robot5x5.pref --scope all";

/// Returns the rows of each node.
fn nodes(text: &str) -> BTreeMap<usize, Vec<Row>> {
    let mut nodes: BTreeMap<usize, Vec<Row>> = BTreeMap::new();
    for row in rows(text) {
        nodes.entry(row["node"].parse().unwrap()).or_default().push(row);
    }
    nodes
}

/// Returns the probabilities and nodes in a cell `0.5:12 0.5:13`.
fn then(row: &Row) -> Vec<(f64, usize)> {
    let step = |step: &str| {
        let (probability, node) = step.split_once(':').unwrap();
        (probability.parse().unwrap(), node.parse().unwrap())
    };
    row["then"].split_whitespace().map(step).collect()
}

#[test]
fn a_table_of_the_whole_strategy_can_be_followed_without_the_program() {
    for (safety, most) in [("action", 6), ("prefix", 2)] {
        let table = run!("strategy {ROBOT} --safety {safety} --all --csv -").expect(0).stdout;
        let nodes = nodes(&table);
        let level = |node: usize| nodes[&node][0]["level"].parse::<usize>().unwrap();
        let starts = nodes.values().filter(|own| own[0]["start"] == "true");
        assert_eq!(starts.clone().count(), 3600);
        assert!(starts.clone().all(|own| own[0]["level"] == own[0]["sasi_rank"]));
        for (&node, own) in &nodes {
            for row in own {
                let steps = then(row);
                assert_eq!(steps.is_empty(), row["permitted"] == "false", "{row:?}");
                // A guaranteed improvement is the only way down, by one level.
                assert!(steps.iter().all(|(_, to)| level(*to) + 1 >= level(node)), "{row:?}");
                let sum: f64 = steps.iter().map(|(probability, _)| probability).sum();
                assert!(steps.is_empty() || (sum - 1.0).abs() < 1e-9, "{row:?}");
            }
            let picked = own.iter().filter(|row| row["pick"] == "true").count();
            assert_eq!(picked, usize::from(level(node) > 0), "{own:?}");
        }
        assert_eq!(longest(&nodes, |row| row["r"] == "2" && row["c"] == "2" && row["b"] == "8"), most);
    }
}

/// Returns the number of steps after which all paths under the picked actions have ended that start in a
/// state for which `is_start` holds and in which nothing else is true.
fn longest(nodes: &BTreeMap<usize, Vec<Row>>, is_start: impl Fn(&Row) -> bool) -> usize {
    let wanted = |row: &Row| {
        row["start"] == "true"
            && is_start(row)
            && ["d", "e", "f", "ch"].iter().all(|name| row[*name] == "false")
    };
    let mut front: Vec<usize> =
        nodes.iter().filter(|(_, own)| wanted(&own[0])).map(|(node, _)| *node).collect();
    assert_eq!(front.len(), 1);
    for steps in 0.. {
        let picked = front.iter().flat_map(|node| &nodes[node]).filter(|row| row["pick"] == "true");
        front = picked.flat_map(then).map(|(_, to)| to).collect();
        if front.is_empty() {
            return steps;
        }
        assert!(steps < 100, "paths do not end");
    }
    0
}

#[test]
fn a_whole_strategy_in_json_names_the_nodes_that_follow() {
    let report = run("strategy models/drone.prism models/drone.pref --all --json").expect(0).json();
    let states = report["states"].as_array().unwrap();
    assert_eq!((&report["asked"], states.len()), (&"7".into(), 7));
    let numbers: Vec<u64> = states.iter().map(|state| state["node"].as_u64().unwrap()).collect();
    assert_eq!(numbers, (0..7).collect::<Vec<_>>());
    for state in states {
        for action in state["actions"].as_array().unwrap() {
            for successor in action["successors"].as_array().unwrap() {
                let node = successor.get("node").map(|node| &states[node.as_u64().unwrap() as usize]);
                assert_eq!(node.is_some(), action["permitted"] == true, "{state}");
                assert!(node.is_none_or(|node| node["state"] == successor["state"]), "{state}");
            }
        }
    }
    assert_eq!((&states[0]["level"], &states[0]["reference"]), (&1.into(), &serde_json::json!(["Shore"])));
}

#[test]
fn a_whole_strategy_beyond_the_limit_is_refused_with_its_number_of_states() {
    let scratch = Scratch::new(&[]);
    let out = scratch.show("all.csv");
    let drone = "models/drone.prism models/drone.pref";
    let refused = run!("strategy {drone} --all --limit 6 --csv {out}").expect(4);
    let message = "the scope has 7 states, more than `--limit 6`; `--limit 7` or more covers all";
    refused.says(message);
    assert!(!scratch.path("all.csv").exists());
    run!("strategy {drone} --all --limit 7 --csv {out}")
        .prints(0, "The table has 7 states, 7 with their memories.");
    assert_eq!(nodes(&std::fs::read_to_string(out).unwrap()).len(), 7);
    for other in ["--at at=1", "--rank 1", "--dot"] {
        run!("strategy {drone} --all {other}").expect(2);
    }
}

#[test]
fn simulate_writes_its_runs_step_by_step() {
    let options = format!("{ROBOT} --kind plan --safety action --at r=2,c=2,b=8 --runs 50 --seed 7");
    let scratch = Scratch::new(&[]);
    let (file, statistics) = (scratch.show("runs.csv"), scratch.show("statistics.csv"));
    let report = run!("simulate {options} --json --csv {file} --statistics {statistics}").expect(0).json();
    let play = &report["plays"][0];
    let text = std::fs::read_to_string(file).unwrap();
    assert!(text.starts_with("start,run,step,r,c,b,d,e,f,ch,action,probability,most_preferred,rank,event\n"));
    let mut runs: BTreeMap<u64, Vec<Row>> = BTreeMap::new();
    for row in rows(&text) {
        runs.entry(row["run"].parse().unwrap()).or_default().push(row);
    }
    assert_eq!(runs.len(), 50);
    let count = |run: &[Row], event: &str| {
        run.iter().filter(|row| row["event"].split("; ").any(|found| found == event)).count()
    };
    for entry in play["improvements"].as_array().unwrap() {
        let times = entry["times"].as_u64().unwrap() as usize;
        let found = runs.values().filter(|run| count(run, "improvement") == times).count();
        assert_eq!(entry["plays"], found);
    }
    for entry in play["achieved"].as_array().unwrap() {
        let event = format!("achieves {}", entry["objective"].as_str().unwrap());
        let found = runs.values().filter(|run| count(run, &event) > 0).count();
        assert_eq!(entry["plays"], found, "{event}");
    }
    for run in runs.values() {
        assert!((0..).zip(run).all(|(step, row)| row["step"] == step.to_string()), "{run:?}");
        assert_eq!((&*run[0]["r"], &*run[0]["c"], &*run[0]["b"], &*run[0]["action"]), ("2", "2", "8", ""));
    }
    let trace: &Json = &play["trace"];
    let shown = &runs[&trace["play"].as_u64().unwrap()];
    for (turn, row) in trace["turns"].as_array().unwrap().iter().zip(&shown[1..]) {
        assert_eq!(
            (&turn["action"], turn["state"]["b"].to_string()),
            (&row["action"].as_str().into(), row["b"].clone())
        );
    }
    assert!(std::fs::read_to_string(statistics).unwrap().contains(",rank,improvements,runs,steps_least,"));
    assert!(run!("simulate {options} --csv - --statistics -").expect(2).stderr.contains("give one a file"));
}

#[test]
fn a_table_that_ends_early_is_not_written() {
    let scratch =
        Scratch::new(&[("m.prism", crate::cli::common::LONG), ("m.pref", crate::cli::common::LONG_PREFS)]);
    let out = scratch.path("runs.csv");
    std::fs::write(&out, "old").unwrap();
    let model = format!("{} {} -c N=40", scratch.show("m.prism"), scratch.show("m.pref"));
    let command =
        format!("simulate {model} --kind spi --runs 100000000 --timeout 1s --csv {}", out.display());
    let ended = Finished::of(executable().args(command.split_whitespace()));
    assert_eq!((ended.status, std::fs::read_to_string(&out).unwrap().as_str()), (4, "old"), "{ended:?}");
    assert_eq!(std::fs::read_dir(scratch.path("")).unwrap().count(), 3);
}

/// A van on a road, and others that multiply its states: 32,768 in all.
const FLEET: &str = "strategy models/fleet.prism models/fleet.pref -c L=1 --all";

/// All states were computed, and the text was printed at the end, although nobody read it.
#[test]
fn a_whole_strategy_ends_when_its_reader_leaves() {
    for format in ["", "--csv -"] {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_meliora"));
        command.args(FLEET.split(' ').chain(format.split_whitespace())).arg("-v");
        command.current_dir(env!("CARGO_MANIFEST_DIR")).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let mut some = [0; 4096];
        child.stdout.take().unwrap().read_exact(&mut some).unwrap();
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{said}");
        let shown = String::from_utf8_lossy(&some);
        assert!(shown.contains(if format.is_empty() { "\n  Node 0: " } else { "\n0,0," }), "{shown}");
        assert!(said.contains("levels: ") && !said.contains("answer: ") && !said.contains("error"), "{said}");
    }
}

/// The phase was `values`, which had ended, the number of states was that of the whole, and a table that was
/// not written had them all.
#[test]
fn what_a_limit_leaves_of_a_whole_strategy_adds_up() {
    let scratch = Scratch::new(&[]);
    let file = scratch.show("all.csv");
    let numbers = |text: &str| -> (usize, usize, usize) {
        let line = text.lines().find(|line| line.contains("before the work stopped")).unwrap_or_default();
        let mut found = line
            .split(|c: char| !c.is_ascii_digit() && c != ',')
            .filter_map(|word| word.replace(',', "").parse().ok());
        let first = found.next().unwrap_or_else(|| panic!("{text}"));
        (first, found.next().unwrap(), found.next().unwrap_or(0))
    };
    let mut stopped = 0;
    for limit in ["--timeout 100ms", "--timeout 400ms", "--timeout 1s", "--memory 8MiB --timeout 2s"] {
        if stopped == 2 {
            break;
        }
        let text = run!("{FLEET} {limit}");
        if text.status == 0 || !text.stdout.contains("before the work stopped") {
            continue;
        }
        let (states, all, more) = numbers(&text.stdout);
        assert_eq!(all, 32_768, "{limit}");
        assert_eq!(states + more, text.stdout.matches("\n  Node ").count(), "{limit}");
        assert!(states == all || more == 0, "{limit}: all states come first");
        assert!(!text.stderr.contains("`values`"), "{limit}: {}", text.stderr);
        let table = run!("{FLEET} {limit} --csv {file}");
        // A slower run may end before it has a state.
        let text = &table.stdout;
        let has_states = text.contains("before the work stopped") && !text.contains("\n0 of 32,768 states");
        assert!(table.stdout.contains("was not written") || !has_states, "{}", table.stdout);
        assert!(table.status == 0 || !scratch.path("all.csv").exists());
        stopped += 1;
    }
    assert!(stopped > 0, "no run was stopped while it wrote states");
    // Six states, and twice as many with their memories.
    let robot = format!("strategy {ROBOT} --kind plan --all");
    let whole = run!("{robot} --json").expect(0).json();
    let (asked, nodes) = (whole["asked"].as_str().unwrap(), whole["states"].as_array().unwrap().len());
    assert!(nodes > asked.parse().unwrap(), "{asked} {nodes}");
    let limit = nodes - 1;
    let text = run!("{robot} --limit {limit}").expect(4);
    let (states, all, more) = numbers(&text.stdout);
    assert_eq!((states.to_string(), states), (asked.to_owned(), all));
    assert_eq!(states + more, text.stdout.matches("\n  Node ").count());
    text.says("`answer`");
    let json = run!("{robot} --limit {limit} --json").expect(4).json();
    assert_eq!((&json["asked"], json["states"].as_array().unwrap().len()), (&asked.into(), states + more));
}
