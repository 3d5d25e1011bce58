//! Unedited dumps, and the verdicts on edited ones.

use std::collections::HashMap;

use meliora::advanced::symbolic::Encoding;
use meliora::certify;
use meliora::dump::dddmp;
use meliora::dump::manifest::{File, RootKind, SafetyMode};
use meliora::error::Result;

use crate::common::prelude::*;

const HASHES: Hashes<'static> = Hashes { model: "the model's", preferences: "the preferences'" };

/// The options that a manifest can name.
pub(crate) type Named = (String, Safety, Option<usize>, String);

/// A model with its preferences and its unedited dumps.
pub(crate) struct Shop {
    model: Arc<SourceFile>,
    preferences: Arc<SourceFile>,
    honest: HashMap<Named, Option<Dump>>,
}

impl Shop {
    pub(crate) fn new(model: &str, preferences: &str) -> Self {
        let source = |name: &str, text: &str| SourceFile::new(name, text);
        Shop {
            model: source("m.prism", model),
            preferences: source("p.pref", preferences),
            honest: HashMap::new(),
        }
    }

    fn program(&self, constants: &str) -> Result<(Arc<Program>, Arc<Preferences>)> {
        let program = lang::load(&self.model, &SourceFile::new("--const", constants))?.program;
        let lang::Task { program, preferences } = lang::load_preferences(&self.preferences, program)?;
        Ok((Arc::new(program), Arc::new(preferences)))
    }

    /// Returns the dump that `export` writes, with the bits in the given order if there is one.
    fn export(
        &self,
        (scope, safety, max_level, constants): &Named,
        order: Option<&[String]>,
    ) -> Option<Dump> {
        let (program, preferences) = self.program(constants).ok()?;
        let order = match order {
            Some(names) => Order::Bits(Encoding::order_of(&program, names)?),
            None => Order::Auto,
        };
        let settings = Settings { memory: 4 << 20, scope: scope_named(scope)?, order, ..Settings::default() };
        let engine = Arc::new(SymbolicEngine::new(Arc::clone(&program), settings).ok()?);
        let options = Options { safety: *safety, max_level: *max_level };
        let analysis = finished(&engine, &preferences, options);
        let named = |text: &str| (text.to_owned(), text.to_owned());
        let inputs = Inputs { model: named(HASHES.model), preferences: named(HASHES.preferences) };
        let content = DumpContent { wanted: &|_| true, certificate: true };
        let dump = export(&analysis, &inputs, &content).unwrap();
        Some(sealed(dump))
    }

    pub(crate) fn honest(&mut self, named: Named) -> Option<&Dump> {
        if !self.honest.contains_key(&named) {
            let dump = self.export(&named, None);
            self.honest.insert(named.clone(), dump);
        }
        self.honest[&named].as_ref()
    }

    /// Returns the dump in a directory if `meliora verify` accepts it.
    pub(crate) fn verify(&self, directory: &Path) -> Option<Dump> {
        let (dump, picture) = certify::read(directory, &NoProgress).ok()?;
        let (program, preferences) = self.program(&dump.manifest.given_constants()).ok()?;
        let scope = scope_named(&dump.manifest.scope).unwrap_or_default();
        let settings = Settings { memory: 4 << 20, scope, ..Settings::default() };
        let verdict = certify::verify(&program, &preferences, HASHES, &dump, settings).ok()?;
        (verdict.is_accepted() && picture.is_none()).then_some(dump)
    }

    /// Returns true if an accepted dump is the one that `export` writes for the options that it names.
    pub(crate) fn is_harmless(&mut self, forged: &Dump) -> bool {
        let said = &forged.manifest;
        let named = (said.scope.clone(), safety_of(said.safety), said.max_level, said.given_constants());
        let Some(mut honest) = self.honest(named.clone()).cloned() else { return false };
        if said.encoding.order != honest.manifest.encoding.order {
            let Some(other) = self.export(&named, Some(&said.encoding.order)) else { return false };
            honest = other;
        }
        let honest = &honest;
        let mut free = said.clone();
        free.tool.version.clone_from(&honest.manifest.tool.version);
        free.model.path.clone_from(&honest.manifest.model.path);
        free.preferences.path.clone_from(&honest.manifest.preferences.path);
        free.regions = honest.manifest.regions.clone();
        free.certificate = honest.manifest.certificate.clone();
        free == honest.manifest
            && same_sets(honest, forged, |d| (&d.manifest.regions, &d.regions), &|_| false)
            && same_sets(
                honest,
                forged,
                |d| (d.manifest.certificate.as_ref().unwrap(), d.certificate.as_ref().unwrap()),
                &|name| is_witness(honest, name),
            )
    }
}

/// Returns true if two dumps have the same regions.
pub(crate) fn same_regions(a: &Dump, b: &Dump) -> bool {
    same_sets(a, b, |d| (&d.manifest.regions, &d.regions), &|_| false)
}

/// Returns true for sets that only prove other sets and need not be unique: the layers, the rounds, and the
/// supersets of the states that win the level after the last one.
fn is_witness(honest: &Dump, name: &str) -> bool {
    let after_the_last = |level: &str| honest.manifest.regions.root(level).is_none();
    let level = name.split_once('@').map(|(level, _)| level);
    name.starts_with("layers:")
        || name.starts_with("refuted:")
        || level.is_some_and(|l| (l.starts_with("sasi:") || l.starts_with("spi:")) && after_the_last(l))
}

fn scope_named(name: &str) -> Option<Scope> {
    [("reachable", Scope::Reachable), ("all", Scope::All)]
        .into_iter()
        .find(|(n, _)| *n == name)
        .map(|(_, s)| s)
}

fn safety_of(mode: SafetyMode) -> Safety {
    match mode {
        SafetyMode::Action => Safety::Action,
        SafetyMode::Transition => Safety::Transition,
        SafetyMode::Prefix => Safety::Prefix,
    }
}

type Part = for<'d> fn(&'d Dump) -> (&'d File, &'d Diagram);

/// Returns true if the sets of one file are the same, except for those whose names are `free`.
fn same_sets(honest: &Dump, forged: &Dump, part: Part, free: &dyn Fn(&str) -> bool) -> bool {
    let ((a, left), (b, right)) = (part(honest), part(forged));
    let bound = |file: &File| -> Vec<(String, RootKind, Edge)> {
        let mut all: Vec<_> =
            file.roots.iter().filter(|r| !free(&r.name)).map(|r| (r.name.clone(), r.kind, r.node)).collect();
        all.sort_by(|x, y| x.0.cmp(&y.0));
        all
    };
    let (a, b) = (bound(a), bound(b));
    left.variables == right.variables
        && a.len() == b.len()
        && a.iter()
            .zip(&b)
            .all(|(x, y)| (&x.0, x.1) == (&y.0, y.1) && same(left, x.2, right, y.2, &mut BTreeMap::new()))
}

/// Returns true if two functions of two diagrams are the same.
fn same(a: &Diagram, x: Edge, b: &Diagram, y: Edge, known: &mut BTreeMap<(i32, i32), bool>) -> bool {
    if x.is_constant() || y.is_constant() {
        return x.number() == y.number();
    }
    let key = (x.number(), y.number());
    if let Some(&known) = known.get(&key) {
        return known;
    }
    let level = a.level(x);
    let ((xt, xe), (yt, ye)) = (a.cofactors(x, level), b.cofactors(y, level));
    let equal = level == b.level(y) && same(a, xt, b, yt, known) && same(a, xe, b, ye, known);
    known.insert(key, equal);
    equal
}

/// Makes sizes, counts and hashes those of the diagrams.
pub(crate) fn sealed(mut dump: Dump) -> Dump {
    let offset = dump.manifest.choices.order.len() as u32;
    seal(&mut dump.manifest.regions, &mut dump.regions, offset);
    if let (Some(file), Some(diagram)) = (&mut dump.manifest.certificate, &mut dump.certificate) {
        seal(file, diagram, offset);
    }
    dump
}

fn seal(file: &mut File, diagram: &mut Diagram, offset: u32) {
    diagram.roots.clear();
    for (position, root) in file.roots.iter_mut().enumerate() {
        let function = root.node;
        root.root = position;
        diagram.roots.push(function);
        root.nodes = diagram.size(function);
        let top = if root.kind == RootKind::States { offset } else { 0 };
        root.count = if diagram.level(function) < top {
            "0".to_owned()
        } else {
            diagram.count(function, top).to_string()
        };
    }
    file.nodes = diagram.nodes.len() + 1;
    file.sha256 = meliora::dump::directory::sha256(text(diagram).as_bytes());
}

pub(crate) fn text(diagram: &Diagram) -> String {
    let mut bytes = Vec::new();
    dddmp::write(diagram, &mut bytes).unwrap();
    String::from_utf8(bytes).unwrap()
}

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
