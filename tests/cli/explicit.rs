//! Models state by state, read back and compared with what the reports say.

use crate::common::prelude::*;

/// A model as the files have it.
#[derive(Debug, Default, PartialEq)]
struct Read {
    /// For each state and choice the name of the choice and its successors.
    choices: BTreeMap<(usize, usize), (String, BTreeMap<usize, f64>)>,
    labels: BTreeMap<String, BTreeSet<usize>>,
    states: usize,
}

impl Read {
    fn transitions(&self) -> usize {
        self.choices.values().map(|(_, to)| to.len()).sum()
    }
}

fn read_prism(scratch: &Scratch, stem: &str) -> Read {
    let text = |extension: &str| scratch.read(&format!("{stem}.{extension}"));
    let (tra, lab, sta) = (text("tra"), text("lab"), text("sta"));
    let mut lines = tra.lines();
    let sizes: Vec<usize> = lines.next().unwrap().split(' ').map(|n| n.parse().unwrap()).collect();
    let mut read = Read { states: sizes[0], ..Read::default() };
    for line in lines {
        let words: Vec<&str> = line.splitn(5, ' ').collect();
        let number = |i: usize| words[i].parse::<usize>().unwrap();
        let (state, choice, to, p, name) = match sizes.len() {
            2 => (number(0), 0, number(1), words[2], ""),
            _ => (number(0), number(1), number(2), words[3], words[4]),
        };
        let entry = read.choices.entry((state, choice)).or_default();
        entry.0 = name.to_owned();
        entry.1.insert(to, p.parse().unwrap());
    }
    if let [_, choices, transitions] = sizes[..] {
        assert_eq!((choices, transitions), (read.choices.len(), read.transitions()));
    }
    assert_eq!(sta.lines().count(), read.states + 1);
    let mut lines = lab.lines();
    let names: Vec<&str> = lines.next().unwrap().split(' ').map(|n| n.split('"').nth(1).unwrap()).collect();
    read.labels.extend(names.iter().map(|n| ((*n).to_owned(), BTreeSet::new())));
    for line in lines {
        let (state, own) = line.split_once(": ").unwrap();
        for label in own.split(' ') {
            let name = names[label.parse::<usize>().unwrap()];
            read.labels.get_mut(name).unwrap().insert(state.parse().unwrap());
        }
    }
    read
}

fn read_drn(scratch: &Scratch, stem: &str) -> Read {
    let text = scratch.read(&format!("{stem}.drn"));
    let is_dtmc = text.starts_with("@type: DTMC\n");
    let (head, body) = text.split_once("@model\n").unwrap();
    let count = |key: &str| {
        head.lines().skip_while(|l| *l != key).nth(1).and_then(|n| n.parse::<usize>().ok()).unwrap()
    };
    let mut read = Read { states: count("@nr_states"), ..Read::default() };
    let (mut state, mut choice) = (0, 0);
    for line in body.lines() {
        if let Some(rest) = line.strip_prefix("state ") {
            let mut words = rest.split(' ');
            state = words.next().unwrap().parse().unwrap();
            choice = 0;
            for label in words {
                read.labels.entry(label.to_owned()).or_default().insert(state);
            }
        } else if let Some(name) = line.strip_prefix("\taction ") {
            let name = if is_dtmc { "" } else { name };
            read.choices.insert((state, choice), (name.to_owned(), BTreeMap::new()));
            choice += 1;
        } else if let Some((to, p)) = line.trim_start().split_once(" : ") {
            let to = to.parse().unwrap();
            read.choices.get_mut(&(state, choice - 1)).unwrap().1.insert(to, p.parse().unwrap());
        }
    }
    assert_eq!(count("@nr_choices"), read.choices.len());
    read
}

fn export(scratch: &Scratch, model: &str, arguments: &[&str]) -> Json {
    let (prism, pref) = (format!("models/{model}.prism"), format!("models/{model}.pref"));
    let out = scratch.show("");
    let all = ["export", &prism, &pref, "--out", &out, "--json"];
    Finished::of(executable().args(all).args(arguments)).expect(0).json()
}

fn check(model: &str) -> Json {
    let (prism, pref) = (format!("models/{model}.prism"), format!("models/{model}.pref"));
    Finished::of(executable().args(["check", &prism, &pref, "--json"])).expect(0).json()
}

#[test]
fn both_formats_have_the_model_with_its_regions() {
    for model in ["robot5x5", "toy", "lateral"] {
        let scratch = Scratch::new(&[]);
        let report = export(&scratch, model, &["--format", "explicit"]);
        export(&scratch, model, &["--format", "drn"]);
        let (prism, mut drn) = (read_prism(&scratch, "model"), read_drn(&scratch, "model"));
        // A label of no state has no place in the second format.
        for name in prism.labels.keys() {
            drn.labels.entry(name.clone()).or_default();
        }
        assert_eq!(prism, drn, "{model}");
        let checked = check(model);
        let counts = &checked["counts"];
        assert_eq!(counts["states"], prism.states.to_string());
        assert_eq!(counts["choices"], prism.choices.len().to_string());
        assert_eq!(counts["transitions"], prism.transitions().to_string());
        assert_eq!(report["states"], counts["states"]);
        for objective in checked["objectives"].as_array().unwrap() {
            let label = format!("almost_sure_{}", objective["name"].as_str().unwrap());
            assert_eq!(objective["almost_sure"], prism.labels[&label].len().to_string(), "{model} {label}");
        }
        for (index, states) in checked["sasi"]["levels"].as_array().unwrap().iter().enumerate() {
            let label = format!("sasi_{}", index + 1);
            assert_eq!(*states, prism.labels[&label].len().to_string(), "{model} {label}");
        }
        for (_, to) in prism.choices.values() {
            assert!((to.values().sum::<f64>() - 1.0).abs() < 1e-9);
        }
    }
}

#[test]
fn more_states_than_the_limit_end_with_its_name_and_no_file() {
    let scratch = Scratch::new(&[]);
    let run =
        |more: &[&str]| scratch.ask("export models/robot5x5.prism models/robot5x5.pref --out out", more);
    run(&["--format", "drn", "--limit", "10"]).ends(4, "--limit");
    assert!(!scratch.path("out").exists());
    run(&["--strategy", "sasi"]).expect(2);
    run(&["--format", "drn", "--region", "sasi:*"]).expect(2);
    run(&["--format", "drn", "--strategy", "best"]).expect(2);
}

#[test]
fn what_is_there_is_looked_at_before_the_work_and_no_half_is_left() {
    let scratch = Scratch::new(&[("file", "old")]);
    let out = |place: &str| scratch.show(place);
    let run = |place: &str, more: &[&str]| {
        let all = ["export", "models/toy.prism", "models/toy.pref", "--out", place];
        Finished::of(executable().args(all).args(more))
    };
    run("-", &["--format", "drn"]).expect(2);
    for (place, word) in [("file", "not a directory"), ("no/such/place", "does not exist")] {
        run(&out(place), &["--format", "drn"]).ends(3, word);
    }
    run(&out("dump"), &[]).expect(0);
    run(&out("dump"), &["--format", "drn"]).ends(3, "contains a dump");
    run(&out("new"), &["--format", "explicit"]).expect(0);
    let names = |place: &str| {
        let entries = std::fs::read_dir(scratch.path(place)).unwrap();
        let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    };
    assert_eq!(names("new"), ["model.lab", "model.sta", "model.tra"]);
    let before = scratch.read("new/model.tra");
    scratch.write("new/model.tra", "older");
    scratch.write("new/notes", "mine");
    // A file that cannot be replaced keeps the others as they were.
    std::fs::create_dir(scratch.path("new/model.drn")).unwrap();
    run(&out("new"), &["--format", "drn"]).expect(3);
    std::fs::remove_dir(scratch.path("new/model.drn")).unwrap();
    run(&out("new"), &["--format", "explicit"]).expect(0);
    assert_eq!(scratch.read("new/model.tra"), before);
    assert_eq!(names("new"), ["model.lab", "model.sta", "model.tra", "notes"]);
    assert_eq!(names(""), ["dump", "file", "new"]);
}

/// It had the labels of the strategy, and the regions and ranks, only.
#[test]
fn the_model_of_a_strategy_keeps_the_labels_of_the_model() {
    let model = "mdp module m x : [0..3] init 0;
        [go] x=0 -> 0.25 : (x'=1) + 0.75 : (x'=2); [on] x=1 -> (x'=3); [] x>1 -> true; endmodule
        label \"home\" = x=1; label \"improved\" = x=2; label \"class_A\" = x=0;";
    let scratch = Scratch::new(&[("m.prism", model), ("m.pref", "objective A = F x=3;")]);
    for (format, file) in [("explicit", "tra"), ("drn", "drn"), ("umb", "umb")] {
        let out = scratch.show(format);
        let paths = [scratch.show("m.prism"), scratch.show("m.pref")];
        let options = ["--kind", "spi", "--scheduler", "progress", "--format", format, "--out", &out];
        Finished::of(executable().arg("export").args(&paths).args(options)).expect(0);
        let again = scratch.show(&format!("{format}/spi-progress.{file}"));
        // A label with a name of the strategy gets a number; a region with the name of a label, too.
        let reaches = |label: &str| {
            let property = format!("P=? [ F \"{label}\" ]");
            let asked = ["reach", &again, "--property", &property, "--json"];
            let found = Finished::of(executable().args(asked)).expect(0).json();
            found["properties"][0]["value"]["upper"].as_f64().unwrap()
        };
        for (label, p) in [("home", 0.25), ("improved", 0.25), ("improved_2", 0.75), ("class_A", 1.0)] {
            assert!((reaches(label) - p).abs() < 1e-9, "{format}: {label}");
        }
        assert!((reaches("class_A_2") - 0.25).abs() < 1e-9, "{format}");
    }
}
