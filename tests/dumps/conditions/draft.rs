//! A dump as explicit sets of valuations, which tests edit and write again as diagrams.

use meliora::dump::manifest::{Root, RootKind};
use meliora::model::trend::Trend;

use crate::common::prelude::*;
use crate::dumps::shop::sealed;

/// The members of a set. A state is its values in the order of the manifest; a choice has its number before them.
pub(super) type Members = BTreeSet<Vec<i64>>;

/// A set of a dump.
#[derive(Clone)]
struct Set {
    in_certificate: bool,
    kind: RootKind,
    members: Members,
    /// The trend of a layer or round.
    trend: Option<Trend>,
}

/// A dump that can be edited.
pub(super) struct Draft {
    /// Written unchanged, except for the files.
    pub(super) manifest: Manifest,
    sets: BTreeMap<String, Set>,
}

impl Draft {
    pub(super) fn of(dump: &Dump) -> Self {
        let mut draft = Draft { manifest: dump.manifest.clone(), sets: BTreeMap::new() };
        let certificate = dump.manifest.certificate.as_ref().unwrap();
        let files =
            [(&dump.manifest.regions, &dump.regions), (certificate, dump.certificate.as_ref().unwrap())];
        for (in_certificate, (file, diagram)) in [false, true].into_iter().zip(files) {
            for root in &file.roots {
                let members = draft.members(diagram, root);
                let set = Set { in_certificate, kind: root.kind, members, trend: root.trend };
                assert!(
                    draft.sets.insert(root.name.clone(), set).is_none(),
                    "{} is in both files",
                    root.name
                );
            }
        }
        draft
    }

    /// The members of a root.
    fn members(&self, diagram: &Diagram, root: &Root) -> Members {
        let mut found = Members::new();
        let first = self.first_level(root.kind);
        let levels = diagram.variables.len();
        let function = root.node;
        for pattern in 0..1u64 << (levels - first) {
            let bits: Vec<bool> =
                (0..levels).map(|k| k >= first && pattern >> (k - first) & 1 == 1).collect();
            if diagram.eval(function, |level| bits[level as usize]) {
                found.insert(self.values(root.kind, &bits));
            }
        }
        found
    }

    fn first_level(&self, kind: RootKind) -> usize {
        if kind == RootKind::States { self.manifest.choices.order.len() } else { 0 }
    }

    fn values(&self, kind: RootKind, bits: &[bool]) -> Vec<i64> {
        let (width, order) = (self.manifest.choices.order.len(), &self.manifest.encoding.order);
        let number = bits[..width].iter().fold(0, |number, &bit| 2 * number + i64::from(bit));
        let bit_of = |name: &String| bits[width + order.iter().position(|n| n == name).unwrap()];
        let values = self.manifest.encoding.variables.iter().map(|v| {
            let bits = v.names.iter().enumerate().map(|(k, name)| i64::from(bit_of(name)) << k);
            v.low + bits.sum::<i64>()
        });
        (kind == RootKind::Choices).then_some(number).into_iter().chain(values).collect()
    }

    fn bits(&self, kind: RootKind, values: &[i64]) -> Vec<bool> {
        let width = self.manifest.choices.order.len();
        let (number, values) =
            if kind == RootKind::Choices { (values[0], &values[1..]) } else { (0, values) };
        let mut bits: Vec<bool> = (0..width).map(|k| number >> (width - 1 - k) & 1 == 1).collect();
        for name in &self.manifest.encoding.order {
            let mut variables = self.manifest.encoding.variables.iter().zip(values);
            let of = |v: &[String]| v.iter().position(|n| n == name);
            let found = variables.find_map(|(v, value)| Some((value - v.low) >> of(&v.names)? & 1 == 1));
            bits.push(found.unwrap());
        }
        bits
    }

    /// The set of this name.
    #[track_caller]
    pub(super) fn get(&self, name: &str) -> Members {
        self.sets.get(name).unwrap_or_else(|| panic!("no set is called {name}")).members.clone()
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.sets.contains_key(name)
    }

    /// The names of all sets.
    pub(super) fn names(&self) -> Vec<String> {
        self.sets.keys().cloned().collect()
    }

    /// The states of the dump whose first variable has one of these values.
    pub(super) fn states(&self, first: &[i64]) -> Members {
        self.get("reachable").into_iter().filter(|state| first.contains(&state[0])).collect()
    }

    /// The states of the dump outside of this set.
    pub(super) fn others(&self, than: &Members) -> Members {
        &self.get("reachable") - than
    }

    /// The enabled choices of this name in states whose first variable has this value.
    pub(super) fn choices(&self, name: &str, first: i64) -> Members {
        let numbers = &self.manifest.choices.numbers;
        let named = |c: &Vec<i64>| numbers[c[0] as usize].name == name && c[1] == first;
        self.get("choices").into_iter().filter(named).collect()
    }

    /// Replaces or adds a set. Its kind and its file follow from its name; a trend stays.
    pub(super) fn set(&mut self, name: &str, members: Members) {
        let is_proof = ["layers:", "refuted:", "safe:"].iter().any(|start| name.starts_with(start));
        let kind = if name == "choices" || name.starts_with("strategy:") {
            RootKind::Choices
        } else {
            RootKind::States
        };
        let trend = self.sets.get(name).and_then(|set| set.trend);
        let set = Set { in_certificate: is_proof || name.contains('@'), kind, members, trend };
        self.sets.insert(name.to_owned(), set);
    }

    /// Takes members out of a set.
    pub(super) fn take(&mut self, from: &str, members: &Members) {
        let rest = &self.get(from) - members;
        assert_ne!(rest, self.get(from), "{from} does not change");
        self.set(from, rest);
    }

    /// Adds members to a set.
    pub(super) fn add(&mut self, to: &str, members: &Members) {
        let more = &self.get(to) | members;
        assert_ne!(more, self.get(to), "{to} does not change");
        self.set(to, more);
    }

    /// Removes all sets with these names.
    pub(super) fn remove(&mut self, chosen: impl Fn(&str) -> bool) {
        self.sets.retain(|name, _| !chosen(name));
    }

    /// Removes a layer or round; the later ones move up.
    pub(super) fn leave_out(&mut self, name: &str) {
        self.sets.remove(name);
        let (start, number) = name.rsplit_once(':').unwrap();
        for number in number.parse::<usize>().unwrap().. {
            let Some(set) = self.sets.remove(&format!("{start}:{}", number + 1)) else { break };
            self.sets.insert(format!("{start}:{number}"), set);
        }
    }

    /// Replaces a part of the names of all sets.
    pub(super) fn rename(&mut self, from: &str, to: &str) {
        let sets = std::mem::take(&mut self.sets);
        self.sets = sets.into_iter().map(|(name, set)| (name.replace(from, to), set)).collect();
    }

    /// Gives a layer or round another trend.
    pub(super) fn set_trend(&mut self, name: &str, trend: Option<Trend>) {
        self.sets.get_mut(name).unwrap().trend = trend;
    }

    /// Takes the trends from all layers and rounds whose names start so.
    pub(super) fn without_trends(&mut self, start: &str) {
        let named = self.sets.iter_mut().filter(|(name, _)| name.starts_with(start));
        named.for_each(|(_, set)| set.trend = None);
        self.manifest.certificate.as_mut().unwrap().order_of_rounds.clear();
    }

    /// Replaces all layers of a region by layers without a trend.
    pub(super) fn layers(&mut self, region: &str, layers: &[&Members]) {
        self.sequence(&format!("layers:{region}:"), layers);
    }

    /// Replaces all rounds of a region by rounds without a trend.
    pub(super) fn rounds(&mut self, region: &str, rounds: &[&Members]) {
        self.sequence(&format!("refuted:{region}:"), rounds);
    }

    fn sequence(&mut self, start: &str, sets: &[&Members]) {
        let is_one = |name: &str| name.strip_prefix(start).is_some_and(|rest| rest.parse::<usize>().is_ok());
        self.remove(is_one);
        for (position, set) in sets.iter().enumerate() {
            self.set(&format!("{start}{position}"), (*set).clone());
        }
    }

    /// Writes the dump with sizes, counts and hashes that agree.
    pub(super) fn dump(&self) -> Dump {
        let mut manifest = self.manifest.clone();
        let certificate = manifest.certificate.as_mut().unwrap();
        if self.sets.values().all(|set| set.trend.is_none()) {
            certificate.order.clear();
        }
        let round = |(name, set): (&String, &Set)| name.starts_with("refuted:") && set.trend.is_some();
        if !self.sets.iter().any(round) {
            certificate.order_of_rounds.clear();
        }
        let [regions, certificate] =
            [(false, &mut manifest.regions), (true, certificate)].map(|(which, file)| {
                let variables: Vec<String> = self.manifest.variables().cloned().collect();
                let mut writer =
                    Writer { diagram: Diagram { variables, ..Diagram::default() }, known: BTreeMap::new() };
                file.roots.clear();
                for (name, set) in self.sets.iter().filter(|(_, set)| set.in_certificate == which) {
                    let patterns: Vec<Vec<bool>> =
                        set.members.iter().map(|m| self.bits(set.kind, m)).collect();
                    let node = writer.write(&patterns, self.first_level(set.kind));
                    let count = String::new();
                    file.roots.push(Root {
                        name: name.clone(),
                        kind: set.kind,
                        root: 0,
                        node,
                        nodes: 0,
                        count,
                        dot: None,
                        trend: set.trend,
                    });
                }
                writer.diagram
            });
        sealed(Dump { manifest, regions, certificate: Some(certificate), values: None })
    }
}

/// Writes sets of patterns as one reduced diagram.
struct Writer {
    diagram: Diagram,
    known: BTreeMap<(u32, Edge, Edge), Edge>,
}

impl Writer {
    /// The function of these patterns from a level on.
    fn write(&mut self, patterns: &[Vec<bool>], level: usize) -> Edge {
        if patterns.is_empty() {
            return Edge::FALSE;
        }
        if level == self.diagram.variables.len() {
            return Edge::TRUE;
        }
        let (ones, zeros): (Vec<_>, Vec<_>) = patterns.iter().cloned().partition(|pattern| pattern[level]);
        let (then, otherwise) = (self.write(&ones, level + 1), self.write(&zeros, level + 1));
        if then == otherwise {
            return then;
        }
        let flip = then.is_complemented();
        let (then, otherwise) = (then.complement_if(flip), otherwise.complement_if(flip));
        let key = (level as u32, then, otherwise);
        let node = match self.known.get(&key) {
            Some(&node) => node,
            None => self.diagram.push(key.0, then, otherwise).unwrap(),
        };
        self.known.insert(key, node);
        node.complement_if(flip)
    }
}
