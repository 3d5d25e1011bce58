//! The checker accepts every written dump and refuses changed ones.

use std::sync::atomic::{AtomicBool, Ordering};

use meliora::certify::Verdict;
use meliora::dump::manifest::Root;
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
