//! The regions that a verdict lists, searches that were cut, and the form of the files.

use std::process::Command;

use meliora::certify::{self, pictures};
use meliora::dump::manifest::{File, Root};
use meliora::dump::write_directory;
use meliora::export::read_shield;

use super::draft::Draft;
use super::{Cases, HISTORIES, SCOPES, accepted, cases, levels, refused, safe};
use crate::common::prelude::*;
use crate::dumps::others::read;
use crate::dumps::verify::Case;

fn all_cases(model: &str, preferences: &str) -> Cases {
    cases(model, preferences, &HISTORIES, Safety::ALL)
}

/// All regions of the manifest, and the safe regions of `prefix`.
#[test]
fn a_verdict_lists_each_region_once() {
    let ring = cases(levels::RING, levels::RING_PREFERENCES, &["history = play;"], Safety::ALL);
    let others = [(levels::MODEL, levels::PREFERENCES), (safe::MODEL, safe::PREFERENCES)];
    let others = others.into_iter().flat_map(|(model, preferences)| all_cases(model, preferences).0);
    for (options, case) in others.chain(ring.0) {
        let manifest = &case.dump.manifest;
        let safe = &manifest.certificate.as_ref().unwrap().roots;
        let safe = safe.iter().filter(|root| root.name.starts_with("safe:"));
        let mut expected: Vec<&str> =
            manifest.regions.roots.iter().chain(safe).map(|root| root.name.as_str()).collect();
        expected.sort_unstable();
        let verdict = case.verify(&case.dump).unwrap();
        assert!(verdict.checked.iter().all(|c| c.inside && c.outside), "{options}");
        let mut listed: Vec<&str> = verdict.checked.iter().map(|c| c.region.as_str()).collect();
        listed.sort_unstable();
        assert_eq!(listed, expected, "{options}");
    }
}

/// The search ends after level 1, and the model has a level 2.
#[test]
fn a_search_that_was_cut_is_accepted() {
    for history in HISTORIES {
        for scope in SCOPES {
            for &safety in Safety::ALL {
                let (program, preferences) =
                    read(levels::MODEL, &format!("{} {history}", levels::PREFERENCES));
                let case = Case::cut(program, preferences, scope, safety, Some(1));
                assert_eq!(case.dump.manifest.max_level, Some(1));
                assert!(case.dump.manifest.regions.root("sasi:unbounded").is_none());
                accepted(&case, &case.dump, &format!("{history} {} {safety}", scope.name()));
            }
        }
    }
}

fn one_case() -> Case {
    let (program, preferences) = read(levels::MODEL, levels::PREFERENCES);
    Case::of(program, preferences, Scope::All, Safety::Prefix)
}

#[test]
fn sizes_and_counts_that_the_manifest_says_are_compared() {
    let case = one_case();
    for certificate in [false, true] {
        for position in 0..3 {
            let mut dump = case.dump.clone();
            let file = file(&mut dump, certificate).0;
            let root = &mut file.roots[position];
            root.nodes += 1;
            let (name, nodes) = (root.name.clone(), root.nodes);
            let condition = format!("`{name}` has {nodes} nodes: it has {}", nodes - 1);
            refused(&case, &dump, &condition, "nodes");
            let mut dump = case.dump.clone();
            let root = &mut self::file(&mut dump, certificate).0.roots[position];
            let count: u64 = root.count.parse().unwrap();
            root.count = (count + 1).to_string();
            let condition = format!("`{name}` has {} members: it has {count}", count + 1);
            refused(&case, &dump, &condition, "count");
        }
    }
}

fn file(dump: &mut Dump, certificate: bool) -> (&mut File, &mut Diagram) {
    match certificate {
        true => (dump.manifest.certificate.as_mut().unwrap(), dump.certificate.as_mut().unwrap()),
        false => (&mut dump.manifest.regions, &mut dump.regions),
    }
}

#[test]
fn sets_that_no_check_asks_for_are_refused() {
    all_cases(levels::MODEL, levels::PREFERENCES).refuse(&[
        ("`sasi:9` belongs to a dump with these options", |d| d.set("sasi:9", d.get("reachable"))),
        ("`strategy:spi:9` belongs to a dump with these options", |d| d.set("strategy:spi:9", [].into())),
        ("`safe:nobody` belongs to a dump with these options", |d| d.set("safe:nobody", [].into())),
    ]);
}

/// The count is that of the choices that the model has.
#[test]
fn choices_that_the_model_does_not_have_are_refused() {
    for (options, case) in all_cases(levels::MODEL, levels::PREFERENCES).0 {
        let mut draft = Draft::of(&case.dump);
        let past = draft.manifest.choices.numbers.len() as i64;
        assert!(past < 1 << draft.manifest.choices.order.len(), "all numbers are of choices");
        let more = draft.states(&[0]).into_iter().map(|state| [&[past], &state[..]].concat()).collect();
        draft.add("strategy:sasi:2", &more);
        let mut dump = draft.dump();
        let count = case.dump.manifest.regions.root("strategy:sasi:2").unwrap().count.clone();
        let mut roots = dump.manifest.regions.roots.iter_mut();
        roots.find(|root| root.name == "strategy:sasi:2").unwrap().count = count;
        refused(&case, &dump, "`strategy:sasi:2` has only choices of the model", &options);
    }
}

#[test]
fn sets_that_a_check_needs_are_missed() {
    all_cases(levels::MODEL, levels::PREFERENCES).refuse(&[
        ("the dump has the region `reachable`", |d| d.remove(|n| n == "reachable")),
        ("the dump has `sasi:unbounded`, a set of states, which this check needs", |d| {
            d.remove(|name| name == "sasi:unbounded")
        }),
        ("the dump has `strategy:spi:1`, a set of choices, which this check needs", |d| {
            d.remove(|name| name == "strategy:spi:1")
        }),
    ]);
}

#[test]
fn the_order_of_the_bits_has_each_bit_once() {
    let case = one_case();
    let mut dump = case.dump.clone();
    let order = &mut dump.manifest.encoding.order;
    order[0] = order[1].clone();
    let variables: Vec<String> = dump.manifest.variables().cloned().collect();
    for certificate in [false, true] {
        file(&mut dump, certificate).1.variables.clone_from(&variables);
    }
    refused(&case, &dump, "the order contains exactly the bits of the model", "order");
}

#[test]
fn a_dump_without_a_certificate_is_refused() {
    let case = one_case();
    let refused = |change: fn(&mut Dump)| {
        let mut dump = case.dump.clone();
        change(&mut dump);
        refused(&case, &dump, "the dump has a certificate", "prefix");
    };
    refused(|dump| dump.certificate = None);
    refused(|dump| dump.manifest.certificate = None);
}

/// A dump whose file, or whose certificate, is changed as no writer could is refused. `change` gets the number of bits of a
/// choice, too.
fn refuses(change: impl Fn(u32, bool, (&mut File, &mut Diagram))) {
    let case = one_case();
    for certificate in [false, true] {
        let mut dump = case.dump.clone();
        change(dump.manifest.choices.order.len() as u32, certificate, file(&mut dump, certificate));
        assert!(matches!(case.verify(&dump), Err(Error::Dump { .. })), "certificate: {certificate}");
    }
}

/// A dump that was not read from files may not fit its manifest.
#[test]
fn a_dump_in_memory_fits_its_manifest() {
    refuses(|_, _, (_, diagram)| diagram.variables.swap(0, 1));
}

/// Two sets have the same name. Readers find the first one; the second one is right.
#[test]
fn a_name_that_is_there_twice_is_refused() {
    refuses(|_, _, (file, diagram)| {
        let last = file.roots.last().unwrap().clone();
        file.roots.insert(0, Root { root: diagram.roots.len(), node: Edge::FALSE, nodes: 0, ..last });
        diagram.roots.push(Edge::FALSE);
    });
}

/// Readers that follow the arcs find states in the set; a checker that goes through the nodes in order finds none,
/// which is right.
#[test]
fn a_diagram_whose_arcs_lead_to_later_nodes_is_refused() {
    refuses(|level, certificate, (file, diagram)| {
        let later = Edge::new(diagram.nodes.len() as i64 + 3).unwrap();
        let first = diagram.push(level, later, Edge::FALSE).unwrap();
        assert_eq!(diagram.push(level + 1, Edge::TRUE, Edge::FALSE).unwrap(), later);
        let name = if certificate { "spi:3@L" } else { "class:nothing" };
        let root = file.roots.iter_mut().find(|root| root.name == name).unwrap();
        assert_eq!(root.count, "0");
        (root.node, root.nodes) = (first, diagram.size(first));
        diagram.roots[root.root] = first;
        file.nodes = diagram.nodes.len() + 1;
    });
}

#[test]
fn pictures_are_those_of_the_regions() {
    let case = one_case();
    let scratch = tempfile::tempdir().unwrap();
    let directory = scratch.path().join("dump");
    write_directory(case.dump.clone(), &directory, true, &NoProgress).unwrap();
    let mut dump = read_directory(&directory, true, &NoProgress).unwrap();
    let condition =
        |dump: &Dump| pictures(&directory, dump, &NoProgress).unwrap().map(|v| v.condition.to_string());
    assert_eq!(condition(&dump), None);
    let root = dump.manifest.regions.root("sasi:1").unwrap();
    let (picture, name) = (directory.join(root.dot.as_ref().unwrap()), "sasi:1");
    let honest = fs::read(&picture).unwrap();
    fs::write(&picture, "digraph {}").unwrap();
    let expected = |name: &str| format!("the DOT file that the manifest names for `{name}` is its picture");
    assert_eq!(condition(&dump), Some(expected(name)));
    fs::write(&picture, honest).unwrap();
    assert_eq!(condition(&dump), None);
    let root = &mut file(&mut dump, true).0.roots[0];
    root.dot = Some("manifest.json".to_owned());
    let name = root.name.clone();
    assert_eq!(condition(&dump), Some(expected(&name)));
}

/// Opening a named pipe would wait for somebody who writes into it.
#[test]
fn a_named_pipe_in_the_place_of_a_file_is_refused_at_once() {
    let scratch = tempfile::tempdir().unwrap();
    let path = scratch.path().join("dump");
    let dump = one_case().dump;
    write_directory(dump, &path, true, &NoProgress).unwrap();
    let files: Vec<_> = fs::read_dir(&path).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert!(files.len() > 10);
    for name in files {
        let (file, aside) = (path.join(&name), scratch.path().join("aside"));
        fs::rename(&file, &aside).unwrap();
        assert!(Command::new("mkfifo").arg(&file).status().unwrap().success());
        match certify::read(&path, &NoProgress) {
            Err(Error::Io { message, .. }) => assert_eq!(message, "this is not a regular file"),
            Err(other) => panic!("{other}"),
            Ok((_, picture)) => assert!(picture.is_some() && name.to_string_lossy().ends_with(".dot")),
        }
        fs::remove_file(&file).unwrap();
        fs::rename(&aside, &file).unwrap();
    }
    let shield = scratch.path().join("shield");
    fs::create_dir(&shield).unwrap();
    assert!(Command::new("mkfifo").arg(shield.join("shield.json")).status().unwrap().success());
    assert!(matches!(read_shield(&shield), Err(Error::Io { .. })));
}
