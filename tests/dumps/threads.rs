//! Dumps of analyses on several threads: the same bytes, or the limit of memory by name.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use meliora::advanced::symbolic::Thresholds;
use meliora::dump::directory::write_directory;
use meliora::engine::{NoProgress, Settings, SymbolicEngine};
use meliora::error::{Error, Limit, Result, SourceFile};
use meliora::export::{DumpContent, Inputs, export};
use meliora::generate::{Choices, Parameters, gridworld};
use meliora::lang;
use meliora::planning::{Analysis, Options, Safety};

/// The contents of all files of a dump.
type Files = BTreeMap<String, Vec<u8>>;

fn files(directory: &Path) -> Files {
    let entries = fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().path());
    entries.map(|path| (path.file_name().unwrap().display().to_string(), fs::read(path).unwrap())).collect()
}

/// Analyses a model on several threads, however small it is, and writes its dump with certificate.
fn dumped(texts: (&str, &str), safety: Safety, (threads, memory): (u32, u64)) -> Result<Files> {
    let source = |name: &str, text: &str| SourceFile::new(name, text);
    let mut program = lang::load(&source("m", texts.0), &source("constants", ""))?.program;
    let preferences = Arc::new(lang::load_preferences(&source("p", texts.1), &mut program)?);
    let thresholds = Thresholds { nodes_for_threads: 0, ..Thresholds::default() };
    let settings = Settings { threads, memory, thresholds, ..Settings::default() };
    let engine = Arc::new(SymbolicEngine::new(Arc::new(program), settings)?);
    let mut analysis = Analysis::new(&engine, &preferences, Options { safety, max_level: None });
    analysis.run(&mut |_| ())?;
    let named = |name: &str| (name.to_owned(), String::new());
    let inputs = Inputs { model: named("m.prism"), preferences: named("p.pref") };
    let dump = export(&analysis, &inputs, &DumpContent { wanted: &|_| true, certificate: true })?;
    let scratch = tempfile::tempdir().unwrap();
    let target = scratch.path().join("dump");
    write_directory(dump, &target, false, &NoProgress)?;
    Ok(files(&target))
}

#[test]
fn dumps_are_the_same_byte_by_byte_with_each_number_of_threads() {
    for model in ["toy", "courier", "pond"] {
        let [text, preferences] =
            ["prism", "pref"].map(|e| fs::read_to_string(format!("models/{model}.{e}")).unwrap());
        for &safety in Safety::ALL {
            let dumped = |threads| dumped((&text, &preferences), safety, (threads, 64 << 20)).unwrap();
            let expected = dumped(1);
            for threads in [2, 4] {
                assert!(dumped(threads) == expected, "{model}, {safety}, {threads} threads");
            }
        }
    }
}

#[test]
fn an_analysis_whose_workers_have_little_memory_ends_with_the_limit_or_with_the_same_dump() {
    let written = gridworld(&Parameters::new(3, 6, 3), &Choices { seed: 7, ..Choices::default() }).unwrap();
    let texts = (written.model.as_str(), written.preferences.as_str());
    let expected = dumped(texts, Safety::Action, (1, 256 << 20)).unwrap();
    let (mut done, mut ended) = (0, 0);
    for memory in (96 << 10..448 << 10).step_by(8 << 10) {
        match dumped(texts, Safety::Action, (2, memory)) {
            Ok(found) => {
                assert!(found == expected, "{memory} bytes");
                done += 1;
            }
            Err(Error::Limit(Limit::Memory { .. })) => ended += 1,
            Err(other) => panic!("{memory} bytes: {other}"),
        }
    }
    assert!(done > 0 && ended > 0, "{done} done, {ended} ended");
}
