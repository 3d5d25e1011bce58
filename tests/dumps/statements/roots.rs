//! The roots of both files, and all names that roots may have.

use meliora::dump::manifest::{File, Root, RootKind};

use super::{Counts, Place, least, places};
use crate::common::prelude::*;
use crate::dumps::shop::toggled;

type Part = for<'d> fn(&'d mut Dump) -> (&'d mut File, &'d mut Diagram);

/// Both files of a dump.
const PARTS: [Part; 2] = [
    |dump| (&mut dump.manifest.regions, &mut dump.regions),
    |dump| (dump.manifest.certificate.as_mut().unwrap(), dump.certificate.as_mut().unwrap()),
];

/// The names that roots of a dump may have: of regions, of strategies, and of what proves them. The
/// classes are those of the dump and two others.
fn possible(dump: &Dump) -> BTreeSet<String> {
    let manifest = &dump.manifest;
    let names: Vec<&str> = manifest.regions.roots.iter().map(|root| root.name.as_str()).collect();
    let mut classes: BTreeSet<String> =
        names.iter().filter_map(|name| Some(name.strip_prefix("class:")?.to_owned())).collect();
    classes.insert(manifest.objectives.join("+"));
    let mut levels = Vec::new();
    for kind in ["sasi", "spi"] {
        let own = |number: &str| format!("{kind}:{number}");
        levels.extend(["1", "2", "3", "unbounded"].map(own));
    }
    let against = |class: &String| levels.iter().map(|level| format!("{level}@{class}")).collect::<Vec<_>>();
    let in_arenas: Vec<String> = classes.iter().flat_map(against).collect();
    let mut sets: Vec<String> =
        ["reachable", "initial", "deadlock", "unsafe", "bad", "choices"].map(str::to_owned).into();
    sets.extend(["us", "them"].map(|player| format!("player:{player}")));
    sets.extend(classes.iter().flat_map(|class| [format!("class:{class}"), format!("safe:{class}")]));
    for name in &manifest.objectives {
        sets.extend(["target", "positive", "almost-sure"].map(|kind| format!("{kind}:{name}")));
        sets.extend(["1", "2", "3"].map(|case| format!("secured:{name}:{case}")));
    }
    sets.extend(levels);
    sets.extend(in_arenas);
    let mut all = BTreeSet::from_iter(sets.iter().cloned());
    for name in &sets {
        all.insert(format!("strategy:{name}"));
        all.extend(name.starts_with("secured:").then(|| format!("layers:{name}:2:0")));
        for proof in ["layers", "refuted"] {
            // The first number that is not there.
            let there = |number: &usize| {
                let name = format!("{proof}:{name}:{number}");
                manifest.certificate.as_ref().unwrap().root(&name).is_some()
            };
            let next = (0usize..).find(|number| !there(number)).unwrap();
            all.insert(format!("{proof}:{name}:{next}"));
        }
    }
    all
}

/// The kind of a root, as `docs/dumps.md` names it.
pub(super) fn kind(name: &str) -> String {
    let parts: Vec<&str> = name.split(':').collect();
    if let ["layers", "secured", _, _, _, _] = parts[..] {
        return "layers:secured:A:d:i:j".to_owned();
    }
    if parts[0] == "layers" || parts[0] == "refuted" {
        let of_unsafe = parts[..2] == ["refuted", "unsafe"];
        return if of_unsafe { "refuted:unsafe:j".to_owned() } else { format!("{}:R:j", parts[0]) };
    }
    if let Some(of) = name.strip_prefix("strategy:") {
        return format!("strategy:{}", kind(of));
    }
    let second = match parts[0] {
        "player" => "p",
        "target" | "positive" | "almost-sure" => "A",
        "secured" => "A:d",
        "class" | "safe" => "C",
        "sasi" | "spi" => match (parts[1].starts_with("unbounded"), parts[1].contains('@')) {
            (true, true) => "unbounded@C",
            (true, false) => "unbounded",
            (false, true) => "k@C",
            (false, false) => "k",
        },
        _ => return name.to_owned(),
    };
    format!("{}:{second}", parts[0])
}

/// Returns true for a layer or round.
fn is_step(name: &str) -> bool {
    name.starts_with("layers:") || name.starts_with("refuted:")
}

impl Place {
    /// Adds a root with each of several sets; returns whether each was refused.
    fn added(&mut self, part: Part, name: &str) -> Vec<bool> {
        let number = name.bytes().map(usize::from).sum::<usize>();
        let is_choice = name.starts_with("strategy:") || name == "choices";
        let like = if is_choice { RootKind::Choices } else { RootKind::States };
        // None, and the members of a root that the name decides.
        let edits: [fn(&File, RootKind, usize) -> Edge; 2] = [
            |_, _, _| Edge::FALSE,
            |file, kind, number| {
                let like = file.roots.iter().filter(|root| root.kind == kind);
                let all: Vec<Edge> = like.map(|root| root.node).collect();
                all.get(number % all.len().max(1)).copied().unwrap_or(Edge::FALSE)
            },
        ];
        // Layers and rounds, of which there are most, get the second only.
        let refused = edits.iter().skip(usize::from(is_step(name))).map(|set| {
            self.is_edit_refused(name, |dump| {
                let (file, _) = part(dump);
                let node = set(file, like, number);
                let root = Root {
                    name: name.to_owned(),
                    kind: like,
                    dot: None,
                    trend: None,
                    node,
                    ..file.roots[0].clone()
                };
                file.roots.push(root);
            })
        });
        refused.collect()
    }

    /// Changes a root, and leaves it out; returns whether each edit was refused.
    fn changed(&mut self, part: Part, at: usize, name: &str) -> Vec<bool> {
        let bits = self.honest.manifest.choices.order.len() as u32;
        let width = bits + self.honest.manifest.encoding.order.len() as u32;
        let mut refused: Vec<bool> = [Edge::complement, |_| Edge::FALSE, |_| Edge::TRUE]
            .into_iter()
            .map(|change: fn(Edge) -> Edge| {
                self.is_edit_refused(name, |dump| {
                    let root = &mut part(dump).0.roots[at];
                    root.node = change(root.node);
                })
            })
            .collect();
        refused.push(self.is_edit_refused(name, |dump| drop(part(dump).0.roots.remove(at))));
        // One member more or less: every one in turn, or 8 of many.
        let states = |dump: &mut Dump| part(dump).0.roots[at].kind == RootKind::States;
        let low = if states(&mut self.honest.clone()) { bits } else { 0 };
        let members = 1usize << (width - low);
        for member in (0..members as u64).step_by((members / 8) | 1) {
            refused.push(self.is_edit_refused(name, |dump| {
                let (file, diagram) = part(dump);
                file.roots[at].node = toggled(diagram, file.roots[at].node, low, member << low);
            }));
        }
        refused
    }
}

#[test]
fn each_root_of_a_dump_is_proved_and_no_other_is_accepted() {
    let mut counts = Counts::new();
    for mut place in places() {
        let possible = possible(&place.honest);
        for (number, part) in PARTS.into_iter().enumerate() {
            let mut honest = place.honest.clone();
            let names: Vec<String> = part(&mut honest).0.roots.iter().map(|root| root.name.clone()).collect();
            for (at, name) in names.iter().enumerate() {
                if !counts.takes(&kind(name)) {
                    continue;
                }
                let refused = place.changed(part, at, name);
                // Layers and rounds may move a state; other sets have no second form, except for the
                // bound of the level after the last one.
                let may_vary = number == 1 && is_step(name);
                assert!(may_vary || name.contains('@') || !refused[3..].contains(&false), "{name}");
                counts.record(&kind(name), &refused);
            }
            // No check looks for a layer or round among the regions.
            let fits = |name: &&String| number == 1 || !is_step(name);
            for name in possible.iter().filter(|name| !names.contains(name)).filter(fits) {
                if counts.takes_more() {
                    let refused = place.added(part, name);
                    counts.record_more(&kind(name), &refused);
                }
            }
        }
    }
    let [statements, edits, refused] = counts.close();
    assert!(statements > least(2000) && refused * 100 > edits * 95, "{statements} {edits} {refused}");
}
