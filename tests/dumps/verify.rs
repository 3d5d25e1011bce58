//! The checker accepts every written dump and refuses changed ones.

use std::sync::atomic::{AtomicBool, Ordering};

use meliora::certify::Verdict;
use meliora::dump::manifest::{Root, SafetyMode};
use meliora::dump::write_directory;
use meliora::error::Result;

use crate::common::prelude::*;

const HASHES: Hashes<'static> = Hashes { model: "m", preferences: "p" };

/// A dump with the model and the preferences that it was made from.
pub(super) struct Case {
    program: Arc<Program>,
    preferences: Arc<Preferences>,
    pub(super) dump: Dump,
}

fn settings(scope: Scope) -> Settings {
    Settings { scope, memory: 16 << 20, ..Settings::default() }
}

fn case(model: &str, scope: Scope, safety: Safety) -> Case {
    let read = |path: String| SourceFile::new(path.clone(), fs::read_to_string(path).unwrap());
    let source = read(format!("models/{model}.prism"));
    let program = lang::load(&source, &SourceFile::new("--const", "")).unwrap().program;
    let lang::Task { program, preferences } =
        lang::load_preferences(&read(format!("models/{model}.pref")), program).unwrap();
    Case::of(program, preferences, scope, safety)
}

impl Case {
    pub(super) fn of(program: Program, preferences: Preferences, scope: Scope, safety: Safety) -> Self {
        Case::cut(program, preferences, scope, safety, None)
    }

    /// The same, with no levels past a greatest one.
    pub(super) fn cut(
        program: Program,
        preferences: Preferences,
        scope: Scope,
        safety: Safety,
        max_level: Option<usize>,
    ) -> Self {
        let (program, preferences) = (Arc::new(program), Arc::new(preferences));
        let engine = Arc::new(SymbolicEngine::new(Arc::clone(&program), settings(scope)).unwrap());
        let analysis = finished(&engine, &preferences, Options { safety, max_level });
        let inputs = Inputs {
            model: ("m.prism".to_owned(), HASHES.model.to_owned()),
            preferences: ("p.pref".to_owned(), HASHES.preferences.to_owned()),
        };
        let content = DumpContent { wanted: &|_| true, certificate: true };
        let dump = export(&analysis, &inputs, &content).unwrap();
        drop(analysis);
        drop(engine);
        Case { program, preferences, dump }
    }

    pub(super) fn verify(&self, dump: &Dump) -> Result<Verdict> {
        let scope = if dump.manifest.scope == "all" { Scope::All } else { Scope::Reachable };
        verify(&self.program, &self.preferences, HASHES, dump, settings(scope))
    }

    /// The condition that a changed dump violates.
    #[track_caller]
    pub(super) fn refused(&self, change: impl FnOnce(&mut Dump)) -> String {
        let mut dump = self.dump.clone();
        change(&mut dump);
        align(&mut dump);
        let verdict = self.verify(&dump).unwrap();
        let violation = verdict.violation.expect("a changed dump was accepted");
        violation.condition.to_string()
    }
}

/// Makes the files fit a changed manifest.
fn align(dump: &mut Dump) {
    let variables: Vec<String> = dump.manifest.variables().cloned().collect();
    let certificate = dump.manifest.certificate.as_mut().unwrap();
    let files =
        [(&mut dump.manifest.regions, &mut dump.regions), (certificate, dump.certificate.as_mut().unwrap())];
    for (file, diagram) in files {
        diagram.variables.clone_from(&variables);
        diagram.roots = file.roots.iter().map(|r| r.node).collect();
        file.roots.iter_mut().enumerate().for_each(|(position, root)| root.root = position);
    }
}

/// Makes a root what another root of the same file is.
pub(super) fn replace(dump: &mut Dump, name: &str, by: &str) {
    let certificate = dump.manifest.certificate.as_mut().unwrap();
    for file in [&mut dump.manifest.regions, certificate] {
        if let Some(by) = file.root(by).cloned() {
            let root = file.roots.iter_mut().find(|r| r.name == name).unwrap();
            *root = Root { name: name.to_owned(), ..by };
            return;
        }
    }
    panic!("no root is called {by}");
}

#[test]
fn every_dump_is_accepted() {
    for model in ["toy", "lateral", "lateral_prefix", "robot5x5"] {
        for scope in [Scope::Reachable, Scope::All] {
            for &safety in Safety::ALL {
                let case = case(model, scope, safety);
                let verdict = case.verify(&case.dump).unwrap();
                assert_eq!(verdict.violation, None, "{model} {scope:?} {safety}");
                assert!(verdict.checked.iter().all(|c| c.inside && c.outside), "{verdict:?}");
            }
        }
    }
}

#[test]
fn a_region_in_the_place_of_another_is_refused() {
    let case = case("robot5x5", Scope::All, Safety::Transition);
    for (name, by, word) in [
        ("reachable", "positive:F", "one of `reachable`"),
        ("initial", "target:A", "initial states"),
        ("deadlock", "initial", "nothing is enabled"),
        ("choices", "strategy:spi:1", "enabled"),
        ("target:A", "target:B", "target"),
        ("positive:D", "reachable", "layers"),
        ("positive:D", "almost-sure:D", "step into"),
        ("almost-sure:D", "positive:D", "strategy"),
        ("almost-sure:F", "target:F", "strategy"),
        ("strategy:almost-sure:D", "choices", "strategy"),
        ("class:A", "class:B", "most preferred"),
        ("class:nothing", "class:D+F", "most preferred"),
        ("sasi:2", "sasi:1", "fewer than the level below"),
        ("sasi:1", "sasi:2", "strategy"),
        ("strategy:sasi:1", "strategy:sasi:2", "keep winning"),
        ("sasi:unbounded", "sasi:2", "strategy"),
        ("spi:1", "reachable", "strategy"),
        ("spi:2", "spi:3", "strategy"),
        ("strategy:spi:1", "choices", "keep winning"),
        ("spi:unbounded", "sasi:unbounded", "has no choice"),
    ] {
        let condition = case.refused(|dump| replace(dump, name, by));
        assert!(condition.contains(word), "{name} := {by}: {condition}");
    }
}

#[test]
fn layers_and_rounds_out_of_place_are_refused() {
    let case = case("robot5x5", Scope::Reachable, Safety::Action);
    for (name, by) in [
        ("layers:reachable:1", "layers:reachable:2"),
        ("layers:reachable:3", "layers:reachable:0"),
        ("layers:positive:D:1", "layers:positive:D:2"),
        ("layers:almost-sure:D:0", "layers:almost-sure:D:1"),
        ("layers:sasi:1:0", "layers:sasi:1:1"),
        ("refuted:almost-sure:D:0", "layers:almost-sure:D:0"),
        ("refuted:sasi:1:0", "layers:sasi:1:0"),
    ] {
        let condition = case.refused(|dump| replace(dump, name, by));
        assert!(
            condition.contains("layer") || condition.contains("round") || condition.contains("reachable"),
            "{name}: {condition}"
        );
    }
}

#[test]
fn a_changed_manifest_is_refused() {
    let case = case("robot5x5", Scope::All, Safety::Transition);
    let refused = |change: fn(&mut Dump)| case.refused(change);
    assert!(refused(|d| d.manifest.model.sha256 = "x".into()).contains("SHA-256 of the model"));
    assert!(refused(|d| d.manifest.preferences.sha256 = "x".into()).contains("SHA-256 of the preferences"));
    assert!(refused(|d| d.manifest.empty = "bottom".into()).contains("`empty`"));
    assert!(refused(|d| d.manifest.objectives.swap(0, 1)).contains("objectives"));
    assert!(refused(|d| d.manifest.encoding.variables[0].low = -1).contains("variables"));
    assert!(refused(|d| d.manifest.regions.roots[3].count = "1".into()).contains("members"));
    assert!(!refused(|d| d.manifest.safety = SafetyMode::Action).is_empty());
    assert!(refused(|d| d.manifest.encoding.order.swap(0, 5)).contains("reachable"));
    assert!(refused(|d| d.manifest.regions.roots.retain(|r| r.name != "class:A")).contains("class"));
    assert!(refused(|d| d.manifest.regions.roots.retain(|r| r.name != "sasi:2")).contains("sasi"));
}

/// All regions are determined by the model, so that any change of any function must be seen.
#[test]
fn every_single_complemented_arc_is_refused() {
    for (model, safety) in [("toy", Safety::Action), ("lateral_prefix", Safety::Prefix)] {
        let case = case(model, Scope::Reachable, safety);
        for index in 0..case.dump.regions.nodes.len() {
            let mut dump = case.dump.clone();
            let node = &mut dump.regions.nodes[index];
            node.otherwise = node.otherwise.complement();
            // A larger set of states may have some in which the model has no meaning: an error.
            if let Ok(verdict) = case.verify(&dump) {
                assert!(verdict.violation.is_some(), "{model}: node {}", index + 2);
            }
        }
    }
}

#[test]
fn a_dump_that_is_replaced_while_it_is_read_is_the_old_or_the_new_one() {
    let scratch = tempfile::tempdir().unwrap();
    let directory = scratch.path().join("dump");
    let dumps = [Safety::Action, Safety::Transition].map(|safety| case("toy", Scope::All, safety).dump);
    let write = |dump: &Dump| write_directory(dump.clone(), &directory, false, &NoProgress).unwrap();
    let written = dumps.each_ref().map(write);
    let is_over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            dumps.iter().cycle().take_while(|_| !is_over.load(Ordering::Relaxed)).for_each(|dump| {
                write(dump);
            });
        });
        let read: Vec<_> = (0..300).map(|_| read_directory(&directory, true, &NoProgress)).collect();
        is_over.store(true, Ordering::Relaxed);
        for dump in read {
            assert!(written.contains(&dump.unwrap().manifest));
        }
    });
}
