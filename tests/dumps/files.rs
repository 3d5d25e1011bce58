//! The text of dumps: a written dump can be read again, and malformed text is refused.

use meliora::dump::{Node, dddmp};
use proptest::prelude::*;

use crate::common::prelude::*;

/// x ∧ ¬y, and its complement.
const GOOD: &str = ".ver DDDMP-2.0
.mode A
.varinfo 0
.dd meliora
.nnodes 3
.nvars 2
.nsuppvars 2
.suppvarnames x y
.orderedvarnames x y
.ids 0 1
.permids 0 1
.nroots 2
.rootids -3 3
.nodes
1 T 1 0 0
2 1 1 1 -1
3 0 0 2 1
.end
";

fn read(text: &str) -> Result<Diagram, Error> {
    dddmp::read("a.dddmp", text.as_bytes())
}

fn written(diagram: &Diagram) -> String {
    let mut text = Vec::new();
    dddmp::write(diagram, &mut text).unwrap();
    String::from_utf8(text).unwrap()
}

/// The line and the message of the error.
#[track_caller]
fn refused(text: &str) -> (usize, String) {
    match read(text) {
        Err(Error::Dump { file, line, message }) => {
            assert_eq!(file, "a.dddmp");
            (line, message)
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn diagrams_are_written_as_they_were_ever() {
    let diagram = read(GOOD).unwrap();
    assert_eq!(written(&diagram), GOOD);
    let [not, yes] = diagram.roots[..] else { panic!() };
    let values =
        |edge: Edge| [0b00, 0b01, 0b10, 0b11].map(|v| diagram.eval(edge, |level| v >> level & 1 == 1));
    assert_eq!(values(not), [false, true, false, false]);
    assert_eq!(values(yes), [true, false, true, true]);
    assert_eq!(diagram.count(yes, 0), 3u32.into());
    assert_eq!(diagram.count(not, 0), 1u32.into());
}

#[test]
fn hostile_files_are_errors_with_a_line() {
    for (from, to, line, word) in [
        ("3 0 0 2 1", "3 0 0 3 1", 17, "earlier line"),
        ("2 1 1 1 -1", "2 1 1 3 -1", 16, "earlier line"),
        ("2 1 1 1 -1", "2 1 1 999999999999 -1", 16, "earlier line"),
        ("2 1 1 1 -1", "2 1 1 99999999999999999999999 -1", 16, "is not the number"),
        ("2 1 1 1 -1", "2 1 1 -1 1", 16, "complemented then"),
        ("2 1 1 1 -1", "2 1 1 0 -1", 16, "earlier line"),
        ("2 1 1 1 -1", "2 1 1 1 1", 16, "both arcs"),
        ("2 1 1 1 -1", "2 1 1 1", 16, "five"),
        ("2 1 1 1 -1", "2 1 1 1 -1 7", 16, "more than five"),
        ("2 1 1 1 -1", "2 1 1 one -1", 16, "is not the number"),
        ("2 1 1 1 -1", "7 1 1 1 -1", 16, "node 7"),
        ("2 1 1 1 -1", "2 2 2 1 -1", 16, "unknown variable 2"),
        ("2 1 1 1 -1", "2 -1 -1 1 -1", 16, "unknown variable"),
        ("2 1 1 1 -1", "2 1 0 1 -1", 16, "index"),
        ("2 1 1 1 -1", "2 0 0 1 -1", 17, "not deeper"),
        ("1 T 1 0 0", "1 F 1 0 0", 15, "terminal"),
        (".nnodes 3", ".nnodes 4", 18, "`.nnodes` says more"),
        (".nnodes 3", ".nnodes 2", 14, "root"),
        (".nnodes 3", ".nnodes 99999999999", 5, "a number up to"),
        (".nvars 2", ".nvars 3", 7, "differ"),
        (".ids 0 1", ".ids 0", 14, "`.ids`"),
        (".permids 0 1", ".permids 1 0", 11, "in order"),
        (".orderedvarnames x y", ".orderedvarnames x x", 9, "twice"),
        (".suppvarnames x y", ".suppvarnames y x", 14, "differ"),
        (".nroots 2", ".nroots 7", 14, ".nroots"),
        (".rootids -3 3", ".rootids -3 0", 13, "is not the number of a node"),
        (".rootids -3 3", ".rootids -3 8", 14, "is not a node"),
        (".mode A", ".mode B", 2, "only `A`"),
        (".varinfo 0", ".varinfo 4", 3, "only `0`"),
        (".varinfo 0", ".mode A", 3, "twice"),
        (".ver DDDMP-2.0\n", "", 13, "`.ver` is missing"),
        (".dd meliora", ".add", 4, "is not a header"),
        (".end", ".end\n.end", 19, "after"),
        (".end", "4 0 0 1 2", 18, ".end"),
    ] {
        let text = GOOD.replacen(from, to, 1);
        assert_ne!(text, GOOD);
        let (at, message) = refused(&text);
        assert!(at == line && message.contains(word), "{from} -> {to}: {at}: {message}");
    }
}

#[test]
fn every_truncation_is_an_error() {
    for length in 0..GOOD.trim_end().len() {
        refused(&GOOD[..length]);
    }
}

#[test]
fn counts_in_a_header_take_no_memory() {
    let text = GOOD.replace(".nnodes 3", ".nnodes 2147483646");
    assert_eq!(refused(&text).0, 18);
}

/// A diagram with many nodes: each on the level above the last, or on its own.
fn tall(levels: usize, width: usize) -> Diagram {
    let mut diagram =
        Diagram { variables: (0..levels).map(|l| format!("v{l}")).collect(), ..Diagram::default() };
    let mut below = vec![Edge::TRUE, Edge::FALSE];
    for level in (0..levels as u32).rev() {
        let at = |k: usize| below[k % below.len()];
        let mixed = |k: usize| (k.wrapping_mul(2_654_435_761) + level as usize * 40_503) >> 7;
        let pair = |k: usize| (at(k), at(mixed(k)));
        let row = (0..width).map(pair).filter(|(t, e)| t != e).collect::<Vec<_>>();
        below = row.iter().map(|&(t, e)| diagram.push(level, t, e).unwrap()).collect();
    }
    diagram.roots = below;
    diagram
}

#[test]
fn a_million_nodes_are_read() {
    let diagram = tall(1000, share(1000));
    assert!(diagram.nodes.len() > share(900_000));
    let text = written(&diagram);
    assert!(read(&text).unwrap() == diagram);
}

#[test]
fn a_dump_of_a_million_nodes_answers() {
    let mut diagram = tall(600, share(2000));
    diagram.roots.truncate(1);
    let nodes = diagram.size(diagram.roots[0]);
    assert!(nodes > share(1_000_000), "{nodes}");
    let names: Vec<String> = diagram.variables.clone();
    let variables: Vec<serde_json::Value> = names
        .iter()
        .map(|n| serde_json::json!({"name": n, "type": "bool", "low": 0, "high": 1, "bits": 1, "names": [n], "initial": 0}))
        .collect();
    let source = serde_json::json!({"path": "m", "sha256": ""});
    let manifest = serde_json::json!({"schema": "meliora.dump/1", "tool": {"name": "meliora", "version": "0"},
        "model": source, "constants": {}, "given": [], "preferences": source, "objectives": [], "empty": "bottom",
        "scope": "all", "safety": "action", "max_level": null, "encoding": {"variables": variables, "order": names},
        "choices": {"order": [], "numbers": []}, "certificate": null,
        "regions": {"path": "regions.dddmp", "sha256": "", "nodes": 1, "roots": [{"name": "reachable",
            "kind": "states", "root": 0, "node": diagram.roots[0].number(), "nodes": nodes, "count": "0"}]}});
    let manifest = meliora::dump::Manifest::parse("m", &manifest.to_string()).unwrap();
    let scratch = tempfile::tempdir().unwrap();
    let directory = scratch.path().join("dump");
    let root = diagram.roots[0];
    let expected = diagram.eval(root, |_| false);
    let dump = meliora::dump::Dump { manifest, regions: diagram, certificate: None, values: None };
    let watch = meliora::engine::NoProgress;
    meliora::dump::write_directory(dump, &directory, false, &watch).unwrap();
    let settings = meliora::engine::Settings { memory: 512 << 20, ..Default::default() };
    let archive = meliora::query::Archive::open(&directory, None, settings).unwrap();
    let all = archive.select("reachable").unwrap();
    let state = archive.state("").unwrap();
    assert_eq!(archive.member(&all, &state).unwrap().is_some(), expected);
}

#[test]
fn a_directory_is_written_whole_or_not_at_all() {
    let scratch = tempfile::tempdir().unwrap();
    let occupied = scratch.path().join("mine");
    fs::create_dir(&occupied).unwrap();
    fs::write(occupied.join("thesis.tex"), "years of work").unwrap();
    let manifest = r#"{"schema":"meliora.dump/1","tool":{"name":"meliora","version":"0"},
        "model":{"path":"m","sha256":"0"},"constants":{},"given":[],"preferences":{"path":"p","sha256":"0"},
        "objectives":[],"empty":"bottom","scope":"all","safety":"action","max_level":null,
        "encoding":{"variables":[],"order":[]},"choices":{"order":[],"numbers":[]},
        "regions":{"path":"regions.dddmp","sha256":"","nodes":1,"roots":[]},"certificate":null}"#;
    let manifest = meliora::dump::Manifest::parse("m", manifest).unwrap();
    let dump = meliora::dump::Dump { manifest, regions: Diagram::default(), certificate: None, values: None };
    let watch = meliora::engine::NoProgress;
    assert!(meliora::dump::write_directory(dump.clone(), &occupied, false, &watch).is_err());
    assert_eq!(fs::read_dir(&occupied).unwrap().count(), 1);
    let free = scratch.path().join("new");
    for _ in 0..2 {
        meliora::dump::write_directory(dump.clone(), &free, false, &watch).unwrap();
        assert!(meliora::dump::read_directory(&free, true, &watch).is_ok());
    }
    assert_eq!(fs::read_dir(scratch.path()).unwrap().count(), 2, "something temporary was left");
    let file = free.join("regions.dddmp");
    let changed = fs::read_to_string(&file).unwrap().replace("meliora", "Meliora");
    fs::write(&file, changed).unwrap();
    let error = meliora::dump::read_directory(&free, true, &watch).unwrap_err();
    assert!(error.to_string().contains("SHA-256"), "{error}");
}

#[test]
fn manifests_that_do_not_fit_are_errors() {
    for (text, word) in [
        ("", "EOF"),
        ("[1, 2", "expected a string"),
        ("{}", "schema"),
        (r#"{"schema":"meliora.dump/2"}"#, "meliora.dump/2"),
        (r#"{"schema":"meliora.dump/1"}"#, "missing field"),
        (r#"{"schema":"meliora.dump/1","note":"checked"}"#, "unknown field"),
        (r#"{"schema":"meliora.dump/1","schema":"meliora.dump/1"}"#, "duplicate field"),
        ("{\"schema\":\"\\u001b[2J\"}", "`\\u{1b}[2J`"),
        (
            r#"{"schema":"meliora.dump/1","safety":"none"}"#,
            "expected one of `action`, `transition`, `prefix`",
        ),
        (r#"{"schema":"meliora.dump/1","constants":{"K":1,"K":2}}"#, "`K` occurs twice"),
    ] {
        let error = meliora::dump::Manifest::parse("m.json", text).unwrap_err();
        assert!(matches!(&error, Error::Dump { message, .. } if message.contains(word)), "{text}: {error}");
    }
}

#[test]
fn a_missing_node_is_an_error_and_not_the_empty_set() {
    for number in ["0", "-2147483648", "2147483648"] {
        assert!(serde_json::from_str::<Edge>(number).is_err(), "{number}");
    }
    let source = SourceFile::new("m", "mdp module m x : bool; endmodule");
    let program = lang::load(&source, &SourceFile::new("constants", "")).unwrap().program;
    let engine = SymbolicEngine::new(program.into(), Settings::default()).unwrap();
    let missing = Edge::new(9).unwrap();
    let node = Node { level: 0, then: Edge::TRUE, otherwise: missing };
    let diagram = Diagram { variables: vec!["x".to_owned()], nodes: vec![node], roots: Vec::new() };
    for edge in [missing, missing.complement(), Edge::new(2).unwrap()] {
        assert!(matches!(engine.load_states(&diagram, &[edge]), Err(Error::Usage(_))), "{edge:?}");
        assert!(matches!(engine.load_choices(&diagram, edge, 1), Err(Error::Usage(_))), "{edge:?}");
    }
}

#[test]
fn choice_sets_with_fewer_numbers_than_groups_are_refused() {
    let source =
        SourceFile::new("m", "mdp module m x : [0..2]; [] true -> (x'=1); [] x=1 -> (x'=2); endmodule");
    let program = lang::load(&source, &SourceFile::new("constants", "")).unwrap().program;
    let engine = SymbolicEngine::new(program.into(), Settings::default()).unwrap();
    let (states, all) = (engine.all_states(), engine.all_choices());
    let variables = vec!["x.1".to_owned(), "x.0".to_owned()];
    let diagram = Diagram { variables, ..Diagram::default() };
    let few = engine.load_choices(&diagram, Edge::TRUE, 1).unwrap().unwrap();
    let refused = [
        engine.pre(&few, &states).map(drop),
        engine.post(&few).map(drop),
        engine.count_transitions(&few, &states).map(drop),
        engine.can_reach(&states, &few, &[]).map(drop),
        engine.stay_within(&states, &few).map(drop),
        engine.almost_surely_reach(&states, &few).map(drop),
        engine.union(&few, &all).map(drop),
        engine.difference(&all, &few).map(drop),
        engine.same(&few, &all).map(drop),
    ];
    for (position, result) in refused.into_iter().enumerate() {
        assert!(matches!(result, Err(Error::Usage(_))), "{position}: {result:?}");
    }
    assert!(engine.same(&engine.sources(&few).unwrap(), &engine.valuations()).is_ok());
}

/// Diagrams of a few variables from random truth tables of their levels.
fn diagrams() -> impl Strategy<Value = Diagram> {
    let node = (0u32..6, any::<(u16, u16)>(), any::<bool>());
    (prop::collection::vec(node, 0..60), prop::collection::vec(any::<(u16, bool)>(), 0..8)).prop_map(
        |(mut nodes, roots)| {
            nodes.sort_by_key(|n| std::cmp::Reverse(n.0));
            let mut diagram =
                Diagram { variables: (0..6).map(|l| format!("v.{l}")).collect(), ..Diagram::default() };
            for (level, (then, otherwise), flip) in nodes {
                let deeper = diagram.nodes.partition_point(|n: &Node| n.level > level) as u16 + 1;
                let then = Edge::new(i64::from(then % deeper) + 1).unwrap();
                let otherwise = Edge::new(i64::from(otherwise % deeper) + 1).unwrap().complement_if(flip);
                if then != otherwise {
                    diagram.push(level, then, otherwise).unwrap();
                }
            }
            let all = diagram.nodes.len() as u16 + 1;
            let root =
                |(n, flip): (u16, bool)| Edge::new(i64::from(n % all) + 1).unwrap().complement_if(flip);
            diagram.roots = roots.into_iter().map(root).collect();
            diagram
        },
    )
}

proptest! {
    #[test]
    fn a_written_diagram_reads_back(diagram in diagrams()) {
        prop_assert_eq!(read(&written(&diagram)).unwrap(), diagram);
    }

    #[test]
    fn counting_agrees_with_evaluation(diagram in diagrams()) {
        for &root in &diagram.roots {
            let expected = (0u32..64).filter(|v| diagram.eval(root, |level| v >> level & 1 == 1)).count();
            prop_assert_eq!(diagram.count(root, 0), expected.into());
        }
    }
}
