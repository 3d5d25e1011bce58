//! The entry points for untrusted text. Each accepts arbitrary bytes and never panics. Accepted input must
//! survive being written and read again.
//!
//! The fuzz targets in `fuzz/` and the tests in `tests/dumps/hostile.rs` call these functions. Other packages compile this
//! file, so it imports nothing from the tests.

#![allow(dead_code, unreachable_pub, reason = "each user takes a part")]

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use meliora::advanced::lang::property::{Named, Term};
use meliora::advanced::lang::property_file::{open_constants, parse_properties};
use meliora::advanced::policies;
use meliora::advanced::symbolic::order;
use meliora::dump::{Diagram, Manifest, bounds, dddmp, directory};
use meliora::engine::ExplicitEngine;
use meliora::engine::SymbolicEngine;
use meliora::engine::{Engine, ProgressSink, Scope, Settings};
use meliora::error::{Error, Limit, SourceFile, render};
use meliora::export::{DumpContent, Inputs, export, read_shield, write_shield};
use meliora::lang;
use meliora::model::step::Step;
use meliora::model::{Program, State};
use meliora::planning::{Analysis, Options, Shield};
use meliora::query::Archive;
use meliora::question::plan::Planner;
use meliora::question::{Asking, Target};
use tempfile::TempDir;

/// A model with something of everything that names can refer to.
pub const MODEL: &str = "mdp const int K=3; const double p=0.5; formula f = x>y; label \"l\" = f & !b;\n\
    module m x:[0..K] init 1; y:[-2..2]; b:bool;\n [go] x<K & y<2 -> p:(x'=x+1)&(b'=!b) + 1-p:(y'=y+1);\n\
    [] x>0 -> (x'=x-1);\nendmodule\n";

/// Preferences for [`MODEL`].
pub const PREFERENCES: &str =
    "objective A = F \"l\"; objective B = F (x=K); objective C = F !b; prefer A, B > C; empty = gain;";

/// Valuations up to which an accepted model is also explored.
const MOST_VALUATIONS: u128 = 1 << 10;

fn source(text: &str) -> Arc<SourceFile> {
    SourceFile::new("fuzz", text)
}

/// The program of [`MODEL`].
pub fn program() -> Program {
    lang::load(&source(MODEL), &source("")).unwrap().program
}

/// Returns the value, or checks that the error can be printed wherever in the text it points.
fn seen<T>(result: Result<T, Error>) -> Option<T> {
    match result {
        Ok(value) => Some(value),
        Err(error) => {
            assert!(!error.to_string().is_empty());
            if let Error::Input(diagnostics) = &error {
                assert!(!diagnostics.is_empty());
                assert!(!render(diagnostics, false).is_empty());
            }
            None
        }
    }
}

/// A model: reads it, writes it and reads that, takes the steps of one state.
pub fn model(text: &str) {
    let text = source(text);
    seen(lang::parse_model(&text));
    let Some(checked) = seen(lang::load(&text, &source(""))) else { return };
    accepted(&checked.program);
}

/// Writes an accepted program, reads it again, and takes the steps of one state in both.
fn accepted(program: &Program) {
    let Some(text) = written(program) else { return };
    let again = lang::load(&source(&text), &source(""));
    let again = again.unwrap_or_else(|e| panic!("{e}: {text}")).program;
    assert_eq!(program.variables.len(), again.variables.len(), "{text}");
    if branching(program) <= 1000.0 {
        assert_eq!(entered(program), entered(&again), "{text}");
    }
}

/// The successors of each choice of one state; none where a step has no meaning.
fn entered(program: &Program) -> Option<BTreeSet<Vec<State>>> {
    let state: State = program.variables.iter().map(|v| v.initial.unwrap_or(v.low)).collect();
    let steps = program.steps(&state).ok()?;
    let support = |step: Step| step.successors.into_iter().map(|(to, _)| to).collect();
    Some(steps.into_iter().map(support).collect())
}

/// The flat program as text, unless it would be too long. That of a game is not supported.
fn written(program: &Program) -> Option<String> {
    match lang::flat(program) {
        refused if program.players.is_some() => {
            assert!(refused.is_err());
            None
        }
        Ok(text) => Some(text),
        Err(Error::Limit(_)) => None,
        Err(error) => panic!("{error}"),
    }
}

/// A JANI model: reads it, writes it in the modelling language, reads that, takes the steps of one state.
pub fn jani(text: &str) {
    let given = lang::Given { constants: source("K=2"), bounds: source("x=0..3") };
    let sink = Patience(AtomicU32::new(0));
    let document = SourceFile::new("fuzz.jani", text);
    let without = lang::Given { constants: source(""), bounds: source("") };
    let loaded = [given, without].map(|given| seen(lang::load_given(&document, &given, &sink)));
    loaded.into_iter().flatten().for_each(|checked| accepted(&checked.program));
}

/// A planning problem, domain and problem in one text: reads it, writes it in the modelling language, reads
/// that, takes the steps of one state.
pub fn planning(text: &str) {
    let sink = Patience(AtomicU32::new(0));
    let given = lang::Given { constants: source(""), bounds: source("") };
    let document = lang::Document::new(SourceFile::new("fuzz.pddl", text));
    if let Some(checked) = seen(document.load(&given, &sink)) {
        accepted(&checked.program);
    }
}

/// A policy of a fixed planning problem: reads it, checks it.
pub fn policy(text: &str) {
    let problem = SourceFile::new("responders.pddl", include_str!("../../models/responders.pddl"));
    let given = lang::Given { constants: source(""), bounds: source("") };
    let sink = Patience(AtomicU32::new(0));
    let program = lang::Document::new(problem).load(&given, &sink).unwrap().program;
    let Some(rules) = seen(policies::read(&source(text), &program)) else { return };
    let initial: State = program.variables.iter().map(|v| v.initial.unwrap()).collect();
    let asked = Asking::target(&program, &source("\"goal\""), &[]).unwrap();
    let Target::States(goal) = asked.goal.target else { panic!("a goal is a condition") };
    let _ = rules.check(&program, &goal, &[initial], false, &sink);
}

/// A UMB archive: reads it, writes the model, takes the steps of one state.
pub fn umb(bytes: &[u8]) {
    loaded(lang::Document::read("fuzz.umb", bytes));
}

/// A model state by state: transitions of PRISM or of Storm, and after lines `%` the values and the
/// labels of states.
pub fn tables(text: &str) {
    let mut parts = text.splitn(3, "\n%\n");
    FOLDER.with(|folder| {
        let path = folder.path().join("fuzz.tra");
        for extension in ["tra", "sta", "lab"] {
            let path = path.with_extension(extension);
            match parts.next() {
                Some(part) => std::fs::write(path, part).unwrap(),
                None if path.exists() => std::fs::remove_file(path).unwrap(),
                None => {}
            }
        }
        loaded(lang::Document::open(&path));
    });
}

fn loaded(document: Result<lang::Document, Error>) {
    let given = lang::Given { constants: source(""), bounds: source("") };
    let sink = Patience(AtomicU32::new(0));
    let Some(document) = seen(document) else { return };
    if let Some(checked) = seen(document.load(&given, &sink)) {
        accepted(&checked.program);
    }
}

/// Returns an upper bound on the number of outcomes of a step, over all combinations of commands.
fn branching(program: &Program) -> f64 {
    let branches = |c: &meliora::model::CommandId| program.commands[c.index()].branches.len() as f64;
    let factor = |f: &Vec<meliora::model::CommandId>| f.iter().map(branches).sum::<f64>();
    program.synchronisations.iter().map(|s| s.factors.iter().map(factor).product::<f64>()).sum()
}

/// Stops an engine that takes long, by the number of times it asks.
struct Patience(AtomicU32);

impl ProgressSink for Patience {
    fn stop(&self) -> Option<Limit> {
        (self.0.fetch_add(1, Ordering::Relaxed) > 20_000).then_some(Limit::Interrupted)
    }
}

fn settings() -> Settings {
    Settings {
        scope: Scope::All,
        memory: 16 << 20,
        sink: Arc::new(Patience(AtomicU32::new(0))),
        ..Settings::default()
    }
}

/// A small model in both engines: the same counts, or the same kind of error.
pub fn engines(text: &str) {
    let Ok(checked) = lang::load(&source(text), &source("")) else { return };
    let program = Arc::new(checked.program);
    let width = |v: &meliora::model::Variable| (i128::from(v.high) - i128::from(v.low)) as u128 + 1;
    let valuations = program.variables.iter().try_fold(1u128, |n, v| n.checked_mul(width(v)));
    if valuations.is_none_or(|n| n > MOST_VALUATIONS) || branching(&program) > 1000.0 {
        return;
    }
    let explicit = counts(ExplicitEngine::new(program.clone(), settings()));
    let symbolic = SymbolicEngine::new(program.clone(), settings());
    match (explicit, counts(symbolic)) {
        (Err(Error::Limit(_)), _) | (_, Err(Error::Limit(_))) => {}
        (Err(a), Err(b)) => assert_eq!(std::mem::discriminant(&a), std::mem::discriminant(&b)),
        (Ok(a), Ok(b)) => assert_eq!(a, b),
        (a, b) => panic!("explicit {a:?}, symbolic {b:?}"),
    }
}

fn counts<E: Engine>(engine: Result<E, Error>) -> Result<[String; 4], Error> {
    let engine = engine?;
    let all = engine.all_choices();
    Ok([
        engine.count(&engine.all_states())?.to_string(),
        engine.count(&all)?.to_string(),
        engine.count_transitions(&all, &engine.all_states())?.to_string(),
        engine.count(&engine.deadlock_states())?.to_string(),
    ])
}

/// A preference file for [`MODEL`].
pub fn preferences(text: &str) {
    seen(lang::load_preferences(&source(text), program()));
}

/// Text that an argument may contain: a state, an expression, a property, constants, a region of a dump.
pub fn arguments(text: &str) {
    let source = source(text);
    let program = program();
    seen(lang::parse_state(&source, &program));
    seen(lang::parse_constants(&source));
    if let Some(tree) = seen(lang::parse_expression(&source)) {
        seen(lang::lower_target(&program, &source, &tree));
    }
    if let Some(property) = seen(lang::parse_property(&source))
        && let Some(term) = seen(property.term(&program, &source, &Named::default()))
    {
        asked(&program, &source, &term);
    }
    ARCHIVE.with_borrow(|archive| {
        if let Some(selected) = seen(archive.select(text)) {
            seen(archive.count(&selected));
        }
        seen(archive.state(text));
    });
}

/// Plans a property: adds the monitors that it needs to a program.
fn asked(program: &Program, source: &Arc<SourceFile>, term: &Term) {
    let mut planner = Planner::new(program, &[], false).unwrap();
    seen(planner.add(0, &source.text, source, term.clone()));
    let plan = planner.finish();
    assert!(plan.requests.iter().all(|request| !request.properties.is_empty()));
}

/// A file of properties of [`MODEL`].
pub fn properties(text: &str) {
    let source = source(text);
    seen(open_constants(&source));
    let mut program = program();
    let given = SourceFile::new("--const", "N=2");
    let Some(all) = seen(parse_properties(&source, &given, &mut program)) else { return };
    accepted(&program);
    for stated in all.iter().take(3) {
        match &stated.term {
            Ok(term) => asked(&program, &source, term),
            Err(reason) => assert!(!reason.reason.is_empty()),
        }
    }
}

/// The table of a shield: one that is read keeps its promise, and is the same after it was written.
pub fn shield(bytes: &[u8]) {
    let nodes = serde_json::from_slice(bytes).map_or(0, |table: Shield| table.nodes.len());
    let sha256 = directory::sha256(bytes);
    let manifest = serde_json::json!({"format": "meliora shield 1", "sha256": sha256, "nodes": nodes});
    FOLDER.with(|folder| {
        std::fs::write(folder.path().join("shield.json"), manifest.to_string()).unwrap();
        std::fs::write(folder.path().join("nodes.json"), bytes).unwrap();
        let Some(shield) = seen(read_shield(folder.path())) else { return };
        promised(&shield);
        let again = folder.path().join("again");
        write_shield(&shield, &again).unwrap();
        assert_eq!(read_shield(&again).unwrap(), shield);
    });
}

/// Checks that permitted steps from secure nodes enter secure nodes, and weaken nothing; that nodes of one state agree; and
/// that sure improvements and the objectives of `achieve` are not given up.
fn promised(shield: &Shield) {
    for node in &shield.nodes {
        for other in shield.nodes.iter().filter(|other| other.state == node.state) {
            assert_eq!((node.class, node.theirs), (other.class, other.theirs), "{node:?}");
            assert_eq!(node.actions.len(), other.actions.len(), "{node:?}");
        }
        for next in
            node.actions.iter().filter(|a| a.permitted).flat_map(|a| &a.next).map(|&to| &shield.nodes[to])
        {
            let [k, left] = [node, next].map(|node| node.ahead.unwrap_or(usize::MAX));
            let is_improved = next.class != Some(node.reference);
            let is_lost = left < k && (left + 1 < k || !is_improved);
            assert!(shield.kind == "spi" || !is_lost, "{node:?}");
            let changes =
                !next.pursues.is_empty() && next.pursues != node.pursues && !node.pursues.is_empty();
            assert!(shield.kind != "achieve" || !changes, "{node:?}");
        }
    }
    for node in shield.nodes.iter().filter(|node| node.secure) {
        for action in node.actions.iter().filter(|action| action.permitted) {
            for next in action.next.iter().map(|&to| &shield.nodes[to]) {
                let class = next.class.unwrap();
                assert!(next.secure && !shield.weakening[node.reference].contains(&class), "{node:?}");
            }
        }
    }
}

/// A file for `--order`.
pub fn order_file(text: &str) {
    let program = program();
    let bits: u32 = program.variables.iter().map(|v| v.bits()).sum();
    if let Some(order) = seen(order::parse(&program, &source(text))) {
        assert_eq!(order.len(), bits as usize);
    }
}

/// The file of a diagram.
pub fn diagram(bytes: &[u8]) {
    let Some(diagram) = seen(dddmp::read("fuzz", bytes)) else { return };
    let mut written = Vec::new();
    dddmp::write(&diagram, &mut written).unwrap();
    let again = dddmp::read("written", written.as_slice()).unwrap();
    assert_eq!(again.nodes, diagram.nodes);
    assert_eq!(again.roots, diagram.roots);
}

/// The file of bounds of quantities.
pub fn values(bytes: &[u8]) {
    for arenas in [false, true] {
        let variables = vec!["x".to_owned(), "b".to_owned()];
        let layout = bounds::Layout { arenas, variables, levels: 1 };
        let Some(rows) = seen(bounds::read("fuzz", &layout, &mut &bytes[..])) else { continue };
        let mut written = Vec::new();
        bounds::write(&layout, &rows, &mut written).unwrap();
        assert_eq!(bounds::read("written", &layout, &mut written.as_slice()).ok(), Some(rows));
    }
}

/// Reads a manifest, alone and together with the diagram of the dump of [`MODEL`].
pub fn manifest(text: &str) {
    let Some(manifest) = seen(Manifest::parse("fuzz", text)) else { return };
    assert_eq!(Manifest::parse("again", &manifest.text().unwrap()).ok(), Some(manifest.clone()));
    let regions = DUMP.with(|dump| dump.regions.clone());
    opened(manifest, &regions);
}

/// A diagram with the manifest of [`MODEL`], and queries of every region.
pub fn dump(bytes: &[u8]) {
    let Some(diagram) = seen(dddmp::read("fuzz", bytes)) else { return };
    let mut manifest = DUMP.with(|dump| dump.manifest.clone());
    manifest.regions.nodes = diagram.nodes.len() + 1;
    for root in &mut manifest.regions.roots {
        if let Some(edge) = diagram.roots.get(root.root) {
            root.node = *edge;
        }
    }
    opened(manifest, &diagram);
}

/// Queries of what a directory with this manifest and this diagram says.
fn opened(mut manifest: Manifest, regions: &Diagram) {
    let directory = tempfile::tempdir().unwrap();
    let mut bytes = Vec::new();
    dddmp::write(regions, &mut bytes).unwrap();
    manifest.regions.sha256 = directory::sha256(&bytes);
    manifest.certificate = None;
    if manifest.regions.path != "regions.dddmp" {
        return;
    }
    std::fs::write(directory.path().join("regions.dddmp"), bytes).unwrap();
    std::fs::write(directory.path().join("manifest.json"), manifest.text().unwrap()).unwrap();
    let Some(archive) = seen(Archive::open(directory.path(), None, settings())) else { return };
    for root in &manifest.regions.roots {
        if let Some(selected) = seen(archive.select(&root.name)) {
            seen(archive.count(&selected));
            seen(archive.list(&selected, 3));
        }
    }
}

thread_local! {
    static FOLDER: TempDir = tempfile::tempdir().unwrap();
    static DUMP: directory::Dump = exported();
    static ARCHIVE: RefCell<Archive> = RefCell::new(archive());
}

/// The dump of [`MODEL`] in memory.
pub fn exported() -> directory::Dump {
    let program = program();
    let lang::Task { program, preferences } = lang::load_preferences(&source(PREFERENCES), program).unwrap();
    let preferences = Arc::new(preferences);
    let program = Arc::new(program);
    let settings = Settings { memory: 16 << 20, ..Settings::default() };
    let engine = Arc::new(SymbolicEngine::new(program.clone(), settings).unwrap());
    let mut analysis = Analysis::new(&engine, &preferences, Options::default());
    analysis.run(&mut |_| ()).unwrap();
    let named = |name: &str| (name.to_owned(), String::new());
    let inputs = Inputs { model: named("m.prism"), preferences: named("m.pref") };
    export(&analysis, &inputs, &DumpContent { wanted: &|_| true, certificate: false }).unwrap()
}

fn archive() -> Archive {
    let directory = tempfile::tempdir().unwrap();
    let target = directory.path().join("dump");
    directory::write_directory(exported(), &target, false, &meliora::engine::NoProgress).unwrap();
    let settings = Settings { memory: 16 << 20, ..Settings::default() };
    Archive::open(&target, None, settings).unwrap()
}
