//! The seeds of the fuzz targets, and what fuzzing found.

use crate::common::entry;
use crate::common::prelude::*;

/// Calls the entry point of a fuzz target. Targets for text skip other bytes.
fn run(target: &str, bytes: &[u8]) {
    match target {
        "diagram" => return entry::diagram(bytes),
        "dump" => return entry::dump(bytes),
        "shield" => return entry::shield(bytes),
        "umb" => return entry::umb(bytes),
        "values" => return entry::values(bytes),
        _ => {}
    }
    let of_text = match target {
        "arguments" => entry::arguments,
        "engines" => entry::engines,
        "jani" => entry::jani,
        "manifest" => entry::manifest,
        "model" => entry::model,
        "order_file" => entry::order_file,
        "planning" => entry::planning,
        "policy" => entry::policy,
        "preferences" => entry::preferences,
        "properties" => entry::properties,
        "tables" => entry::tables,
        _ => panic!("the target {target} is not tested"),
    };
    std::str::from_utf8(bytes).into_iter().for_each(of_text);
}

#[test]
fn every_fuzz_target_accepts_or_refuses_its_seeds() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz");
    // A published package has no fuzz targets.
    if !folder.exists() {
        return;
    }
    for target in fs::read_dir(folder.join("targets")).unwrap() {
        let target = target.unwrap().path();
        let target = target.file_stem().unwrap().to_str().unwrap();
        let mut seeds = 0;
        for seed in fs::read_dir(folder.join("corpus").join(target)).unwrap() {
            let path = seed.unwrap().path();
            println!("{}", path.display());
            run(target, &fs::read(&path).unwrap());
            seeds += 1;
        }
        assert!(seeds > 0, "{target} has no seeds");
    }
}
