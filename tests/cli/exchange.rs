//! Archives in UMB through the command: a written archive is read as the same model.

use std::io::Read;

use crate::common::prelude::*;

fn json(arguments: &[&str], constants: &str) -> Json {
    let mut command = executable();
    command.args(arguments).arg("--json");
    if !constants.is_empty() {
        command.args(["--const", constants]);
    }
    Finished::of(&mut command).expect(0).json()
}

#[test]
fn a_strategy_in_an_archive_is_the_model_that_it_induces() {
    let scratch = Scratch::new(&[]);
    let out = scratch.show("out");
    for (strategy, kind) in [("sasi:progress", "dtmc"), ("sasi:permissive", "mdp")] {
        let files = ["models/robot5x5.prism", "models/robot5x5.pref", "--out", &out];
        let written =
            json(&[&["export"], &files[..], &["--format", "umb", "--strategy", strategy]].concat(), "");
        let archive = format!("{out}/{}.umb", strategy.replace(':', "-"));
        let read = json(&["info", &archive], "");
        assert_eq!(read["model"]["type"], kind);
        for count in ["states", "choices", "transitions"] {
            assert_eq!(read["counts"][count], written[count], "{strategy} {count}");
        }
    }
}

#[test]
fn rewards_and_labels_survive_the_round_trip() {
    let model = "mdp\nmodule m x:[0..3] init 0;\n[a] x<3 -> 1/3:(x'=x+1) + 2/3:true;\n[b] x=0 -> (x'=3);\n\
        endmodule\nlabel \"far\" = x=3;\nrewards \"cost\" x>0 : 1/7; [b] true : 5; endrewards\n";
    let scratch = Scratch::new(&[("m.prism", model), ("p.pref", "objective A = F \"far\";")]);
    let (model, prefs, out) = (scratch.show("m.prism"), scratch.show("p.pref"), scratch.show("out"));
    json(&["export", &model, &prefs, "--format", "umb", "--out", &out], "");
    let archive = format!("{out}/model.umb");
    let question = ["--property", "R{\"cost\"}max=? [ F \"far\" ]"];
    let asked = |file: &str| json(&[&["reach", file], &question[..]].concat(), "")["properties"].clone();
    assert_eq!(asked(&archive), asked(&model));
}

/// Returns the bounds of a quantity in the states of an archive.
fn bounds(archive: &str, name: &str) -> Vec<[f64; 2]> {
    let packed = std::fs::File::open(archive).unwrap();
    let mut files = tar::Archive::new(flate2::read::GzDecoder::new(packed));
    let path = format!("annotations/values/{name}/states/values.bin");
    let is_wanted = |entry: &tar::Entry<_>| entry.path().unwrap().to_str() == Some(&path);
    let mut entry = files.entries().unwrap().map(Result::unwrap).find(is_wanted).unwrap();
    let mut bytes = Vec::new();
    entry.read_to_end(&mut bytes).unwrap();
    let double = |bytes: &[u8; 8]| f64::from_le_bytes(*bytes);
    bytes.as_chunks::<16>().0.iter().map(|both| [0, 1].map(|i| double(&both.as_chunks().0[i]))).collect()
}

#[test]
fn quantities_are_annotations_of_states() {
    let scratch = Scratch::new(&[]);
    let out = scratch.show("out");
    for (name, constants, safety) in [
        ("drone", "", "action"),
        ("network", "K=5,M=2", "transition"),
        ("lateral_prefix", "", "prefix"),
        ("rescue", "H=2", "action"),
        ("pursuit", "N=3", "action"),
        ("pursuit", "N=3", "prefix"),
    ] {
        let (model, prefs) = (format!("models/{name}.prism"), format!("models/{name}.pref"));
        let inputs = [model.as_str(), &prefs, "--safety", safety, "--levels", "2"];
        let written = json(
            &[&["export"], &inputs[..], &["--format", "umb", "--values", "--out", &out]].concat(),
            constants,
        );
        let archive = format!("{out}/model.umb");
        assert_eq!(json(&["info", &archive], "")["counts"]["states"], written["states"]);
        let list = json(&[&["values"], &inputs[..], &["--all"]].concat(), constants)["states"].clone();
        let list = list.as_array().unwrap();
        let number = |x: &Json| x.as_f64().unwrap_or(f64::INFINITY);
        let pair = |bound: &Json| match bound {
            Json::Null => [f64::INFINITY; 2],
            _ => [number(&bound["lower"]), number(&bound["upper"])],
        };
        // Both commands round differently.
        let shown = |bounds: [f64; 2]| bounds.map(|x| format!("{x:.6}"));
        // The archive has the initial states first, so the values are compared in any order.
        let sorted = |mut all: Vec<Vec<[String; 2]>>| {
            all.sort_unstable();
            all
        };
        let expected = list.iter().map(|state| {
            let levels = state["levels"].as_array().unwrap().iter();
            let own = levels.flat_map(|level| [pair(&level["probability"]), pair(&level["cost"])]);
            own.chain([pair(&state["number"])]).map(shown).collect()
        });
        let columns = ["p_1", "c_1", "p_2", "c_2", "n"].map(|name| bounds(&archive, name));
        let found = (0..list.len()).map(|i| columns.iter().map(|c| shown(c[i])).collect());
        assert_eq!(sorted(found.collect()), sorted(expected.collect()), "{name}");
        assert_eq!(written["values"]["rows"], list.len(), "{name}");
        assert_eq!(written["values"]["narrow"], true, "{name}");
        assert!(columns[0].iter().any(|[lower, _]| *lower > 0.0), "{name}");
    }
}
