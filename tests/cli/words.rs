//! Lists of the words that a field may have, on the pages and in the Python package.

use meliora_planning::Phase;
use meliora_planning::explain::Verdict;

use crate::common::prelude::*;

/// Reads a file of the repository.
fn file(path: &str) -> String {
    fs::read_to_string(format!("{}/{path}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

/// Returns the words in quotes that a text has, beginning with `start` and up to `end`.
fn quoted(text: &str, start: &str, end: &str) -> BTreeSet<String> {
    let from = text.find(start).unwrap_or_else(|| panic!("no {start:?}"));
    let part = &text[from..from + text[from..].find(end).unwrap()];
    part.split("`\"").skip(1).filter_map(|rest| Some(rest.split_once("\"`")?.0.to_owned())).collect()
}

/// The lists of the Python package had no `likeliest`, `passed-over` and `impossible`.
#[test]
fn every_verdict_is_listed_for_json_and_python() {
    let all = BTreeSet::from_iter(Verdict::NAMES.iter().map(|&name| name.to_owned()));
    let source = file("python/src/explanation.rs");
    assert_eq!(quoted(&source, "The reason in one word", "The reason in a sentence"), all);
    let page = file("docs/json.md");
    let section = page.split("### verdicts").nth(1).unwrap().split("\n## ").next().unwrap();
    for name in all {
        assert!(section.contains(&format!("`{name}`")), "docs/json.md: {name}");
    }
}

#[test]
fn every_phase_that_python_reports_is_listed() {
    let mut all = BTreeSet::from_iter(Phase::ALL.iter().map(|phase| phase.name().to_owned()));
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/python/src");
    for source in fs::read_dir(folder).unwrap() {
        let text = fs::read_to_string(source.unwrap().path()).unwrap();
        for begin in [
            "reporter.report(\"",
            "phase(py, call, \"",
            "phase(py, &call, \"",
            "call(py, call, \"",
            "call(py, &call, \"",
        ] {
            let named = text.split(begin).skip(1).filter_map(|rest| Some(rest.split_once('"')?.0.to_owned()));
            all.extend(named);
        }
    }
    assert!(all.len() > 12, "{all:?}");
    assert_eq!(quoted(&file("python/src/progress.rs"), "The phase: `", "phase: &"), all);
}
