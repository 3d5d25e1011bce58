//! The edits of the mutation tests.

use meliora::dump::manifest::{ChoiceNumber, File, Root, RootKind};
use meliora::dump::{Node, directory};
use rand::seq::{IndexedMutRandom, IndexedRandom, IteratorRandom};

use super::shop::{edge, text};
use crate::common::prelude::*;

/// The function with one more member or one less.
pub(crate) fn toggled(diagram: &mut Diagram, from: Edge, level: u32, bits: u64) -> Edge {
    if level as usize == diagram.variables.len() {
        return from.complement();
    }
    let (then, otherwise) = diagram.cofactors(from, level);
    let (then, otherwise) = match bits >> level & 1 {
        1 => (toggled(diagram, then, level + 1, bits), otherwise),
        _ => (then, toggled(diagram, otherwise, level + 1, bits)),
    };
    if then == otherwise { then } else { diagram.push(level, then, otherwise).unwrap() }
}

/// The function without the members that have these bits.
pub(super) fn without(diagram: &mut Diagram, from: Edge, level: u32, bits: &[(&str, bool)]) -> Edge {
    let Some(name) = diagram.variables.get(level as usize) else { return Edge::FALSE };
    let fixed = bits.iter().find(|(bit, _)| bit == name).map(|(_, value)| *value);
    let (mut then, mut otherwise) = diagram.cofactors(from, level);
    if fixed != Some(false) {
        then = without(diagram, then, level + 1, bits);
    }
    if fixed != Some(true) {
        otherwise = without(diagram, otherwise, level + 1, bits);
    }
    if then == otherwise { then } else { diagram.push(level, then, otherwise).unwrap() }
}

/// An edit of a dump; false where there is nothing to edit.
pub(super) type Edit = fn(&mut Dump, &mut ChaCha8Rng) -> bool;

/// The edits of a dump; sizes, counts and hashes are corrected afterwards.
pub(super) const EDITS: &[(&str, Edit)] = &[
    ("a region is another one", |d, r| another(&mut d.manifest.regions, r)),
    ("a node of the regions is changed", |d, r| node(&mut d.regions, r)),
    ("a region is changed, its own set is in the certificate", shadowed),
    ("a set of the certificate is another one", |d, r| another(proof(d).0, r)),
    ("a node of the certificate is changed", |d, r| node(proof(d).1, r)),
    ("the names of two regions are swapped", |d, r| swapped(&mut d.manifest.regions, r)),
    ("names of choices are swapped", |d, r| {
        two_choices(d, r, |a, b| std::mem::swap(&mut a.name, &mut b.name))
    }),
    ("labels of choices are swapped", |d, r| {
        two_choices(d, r, |a, b| std::mem::swap(&mut a.action, &mut b.action))
    }),
    ("commands of choices are swapped", |d, r| {
        two_choices(d, r, |a, b| std::mem::swap(&mut a.commands, &mut b.commands))
    }),
    ("the bits are in another order", |d, r| {
        let width = d.manifest.encoding.order.len();
        let (i, j) = (r.random_range(0..width), r.random_range(0..width));
        d.manifest.encoding.order.swap(i, j);
        names_of_bits(d);
        i != j
    }),
    ("two bits of a variable are swapped", |d, _| {
        let variable = d.manifest.encoding.variables.iter_mut().find(|v| v.names.len() > 1);
        variable.map(|v| v.names.swap(0, 1)).is_some()
    }),
    ("a bit has another name", |d, _| {
        let old = std::mem::replace(&mut d.manifest.encoding.variables[0].names[0], "z".to_owned());
        d.manifest.encoding.order.iter_mut().filter(|b| **b == old).for_each(|b| *b = "z".to_owned());
        names_of_bits(d);
        true
    }),
    ("the scope is another one", |d, r| {
        d.manifest.scope = (*["all", "reachable", "nonsense"].choose(r).unwrap()).to_owned();
        if r.random_bool(0.5) {
            proof(d).0.roots.retain(|root| !root.name.starts_with("layers:reachable"));
        }
        true
    }),
    ("the last levels are left out and said to be cut", cut),
    ("two words of an observer are swapped", |d, r| {
        let named = d.manifest.encoding.variables.iter_mut().filter(|v| v.values.len() > 1);
        named.choose(r).map(|v| v.values.swap(0, 1)).is_some()
    }),
    ("a node that no region has", |d, _| {
        let level = d.manifest.choices.order.len() as u32;
        d.regions.push(level, Edge::TRUE, Edge::FALSE).is_ok()
    }),
    ("the regions are listed in another order", |d, _| {
        d.manifest.regions.roots.reverse();
        true
    }),
    ("the version or a path is another one", |d, r| {
        let manifest = &mut d.manifest;
        let texts = [&mut manifest.tool.version, &mut manifest.model.path, &mut manifest.preferences.path];
        texts.into_iter().nth(r.random_range(0..3)).unwrap().push_str("\u{1b}[2J");
        true
    }),
];

/// Edits that must be harmless: else the test would pass where everything is refused.
pub(super) const HARMLESS: &[&str] = &[
    "a node that no region has",
    "the regions are listed in another order",
    "the version or a path is another one",
];

pub(super) fn proof(dump: &mut Dump) -> (&mut File, &mut Diagram) {
    (dump.manifest.certificate.as_mut().unwrap(), dump.certificate.as_mut().unwrap())
}

pub(super) fn root<'f>(file: &'f mut File, random: &mut ChaCha8Rng) -> &'f mut Root {
    let position = random.random_range(0..file.roots.len());
    &mut file.roots[position]
}

fn another(file: &mut File, random: &mut ChaCha8Rng) -> bool {
    let by = root(file, random).clone();
    let like: Vec<usize> = (0..file.roots.len()).filter(|&i| file.roots[i].kind == by.kind).collect();
    file.roots[*like.choose(random).unwrap()].node = by.node;
    true
}

fn node(diagram: &mut Diagram, random: &mut ChaCha8Rng) -> bool {
    let position = random.random_range(0..diagram.nodes.len());
    let node = &mut diagram.nodes[position];
    match random.random_range(0..3) {
        0 => node.otherwise = node.otherwise.complement(),
        1 => node.otherwise = if node.otherwise == Edge::FALSE { Edge::TRUE } else { Edge::FALSE },
        _ if node.otherwise != Edge::TRUE => node.then = Edge::TRUE,
        _ => return false,
    }
    node.then != node.otherwise
}

/// Replaces a region, and puts its function into the certificate under the same name.
fn shadowed(dump: &mut Dump, random: &mut ChaCha8Rng) -> bool {
    let position = random.random_range(0..dump.manifest.regions.roots.len());
    let root = dump.manifest.regions.roots[position].clone();
    let (from, to) = (dump.regions.clone(), &mut dump.certificate.as_mut().unwrap().nodes);
    // The functions of the regions over nodes of their own.
    let shift = to.len() as i32;
    let moved = |e: Edge| if e.is_constant() { e } else { edge(e.number() + e.number().signum() * shift) };
    to.extend(from.nodes.iter().map(|n| Node { then: moved(n.then), otherwise: moved(n.otherwise), ..*n }));
    let node = moved(root.node);
    proof(dump).0.roots.push(Root { node, ..root });
    let (file, diagram) = (&mut dump.manifest.regions, &mut dump.regions);
    let offset = if file.roots[position].kind == RootKind::States {
        dump.manifest.choices.order.len() as u32
    } else {
        0
    };
    let changed = toggled(diagram, file.roots[position].node, offset, random.random());
    file.roots[position].node = changed;
    true
}

fn swapped(file: &mut File, random: &mut ChaCha8Rng) -> bool {
    let (i, j) = (random.random_range(0..file.roots.len()), random.random_range(0..file.roots.len()));
    let name = file.roots[i].name.clone();
    file.roots[i].name = std::mem::replace(&mut file.roots[j].name, name);
    i != j
}

fn two_choices(
    dump: &mut Dump,
    random: &mut ChaCha8Rng,
    change: fn(&mut ChoiceNumber, &mut ChoiceNumber),
) -> bool {
    let numbers = &mut dump.manifest.choices.numbers;
    let middle = random.random_range(1..numbers.len());
    let (left, right) = numbers.split_at_mut(middle);
    change(left.choose_mut(random).unwrap(), right.choose_mut(random).unwrap());
    true
}

fn names_of_bits(dump: &mut Dump) {
    let names: Vec<String> = dump.manifest.variables().cloned().collect();
    dump.regions.variables.clone_from(&names);
    proof(dump).1.variables = names;
}

fn cut(dump: &mut Dump, random: &mut ChaCha8Rng) -> bool {
    let last = random.random_range(0..3);
    dump.manifest.max_level = Some(last);
    let gone = |name: &str| {
        let level = name.split(['@']).next().unwrap_or_default();
        let mut words = level.split(':').skip_while(|w| *w != "sasi" && *w != "spi").skip(1);
        words.next().is_some_and(|k| k == "unbounded" || k.parse().is_ok_and(|k: usize| k > last))
    };
    dump.manifest.regions.roots.retain(|r| !gone(&r.name));
    proof(dump).0.roots.retain(|r| !gone(&r.name));
    true
}

/// Changes one byte of a file and the hash with it.
pub(super) fn byte(dump: &Dump, random: &mut ChaCha8Rng) -> (Manifest, String, String) {
    let mut texts = [text(&dump.regions), text(dump.certificate.as_ref().unwrap())];
    let text = texts.choose_mut(random).unwrap();
    let places: Vec<usize> =
        text.bytes().enumerate().filter(|(_, b)| b.is_ascii_digit()).map(|(i, _)| i).collect();
    let place = *places.choose(random).unwrap();
    let digit = random.random_range(0..10).to_string();
    text.replace_range(place..=place, &digit);
    let mut manifest = dump.manifest.clone();
    manifest.regions.sha256 = directory::sha256(texts[0].as_bytes());
    manifest.certificate.as_mut().unwrap().sha256 = directory::sha256(texts[1].as_bytes());
    let [regions, certificate] = texts;
    (manifest, regions, certificate)
}
