//! Mutation tests: edited dumps that must be refused. Sizes, counts and hashes are corrected after every
//! edit, so that only the contents of the dump are false. An edited dump that `verify` accepts must be
//! harmless: equal to the dump that `export` writes for the options it names, except for parts without
//! meaning (`docs/dumps.md`).

mod edits;
mod games;
mod plays;
mod shop;
mod steps;

use edits::{EDITS, HARMLESS, byte, proof, without};
use meliora::dump::manifest::{CERTIFICATE, FILE, File, REGIONS};

use crate::common::prelude::*;

pub(crate) use edits::toggled;
pub(crate) use shop::{Named, Shop, same_regions, sealed, text};

/// Two choices of one label, a deadlock, patterns of bits that are no values, constants of three kinds.
const MODEL: &str =
    "mdp const int K; const double p; const double huge; const bool sure = true; const double tiny = 0.00005;
    module m x:[1..K] init 2; b:bool;
      [go] x<K -> p:(x'=x+1) + 1-p:(b'=!b); [go] x<K & !b -> (x'=x+1);
      [back] x>1 & b -> (x'=x-1)&(b'=false); [] x=2 & b -> (x'=1);
    endmodule";
const PREFERENCES: &str = "objective A = F x=3; objective B = F (x=4 & b); objective C = F x=K;
    objective D = F (x=1 & b); prefer C > B > A; prefer C > D;";
const CONSTANTS: &str = "K=5,p=0.3,huge=1e16";

/// The numbers of edits of one kind that were tried, refused, and harmless.
#[derive(Default)]
struct Tally {
    tried: usize,
    refused: usize,
    harmless: usize,
}

struct Table(BTreeMap<&'static str, Tally>);

impl Table {
    /// Judges what now lies in the directory.
    fn judge(&mut self, shop: &mut Shop, kind: &'static str, directory: &Path) {
        let tally = self.0.entry(kind).or_default();
        tally.tried += 1;
        match shop.verify(directory) {
            None => tally.refused += 1,
            Some(dump) => {
                assert!(shop.is_harmless(&dump), "{kind}: accepted: {}", dump.manifest.text().unwrap());
                tally.harmless += 1;
            }
        }
    }

    fn print(&self) {
        println!("| {:62} | tried | refused | harmless |", "edit");
        for (kind, tally) in &self.0 {
            println!("| {kind:62} | {:5} | {:7} | {:8} |", tally.tried, tally.refused, tally.harmless);
        }
        let sum = |part: fn(&Tally) -> usize| self.0.values().map(part).sum::<usize>();
        let (tried, refused, harmless) = (sum(|t| t.tried), sum(|t| t.refused), sum(|t| t.harmless));
        println!("| {:62} | {tried:5} | {refused:7} | {harmless:8} |", "all");
    }

    /// Prints the table. Edits of parts without meaning must never be refused.
    fn close(&self) {
        self.print();
        for kind in HARMLESS {
            assert_eq!(self.0[kind].refused, 0, "{kind}: refused, though it says nothing");
        }
    }
}

fn put(directory: &Path, manifest: &str, regions: &str, certificate: &str) {
    for (name, text) in [(FILE, manifest), (REGIONS, regions), (CERTIFICATE, certificate)] {
        fs::write(directory.join(name), text).unwrap();
    }
}

fn forge(shop: &mut Shop, dump: &Dump, table: &mut Table, random: &mut ChaCha8Rng, rounds: usize) {
    let scratch = tempfile::tempdir().unwrap();
    let directory = scratch.path();
    let [regions, certificate] = [text(&dump.regions), text(dump.certificate.as_ref().unwrap())];
    put(directory, &dump.manifest.text().unwrap(), &regions, &certificate);
    assert!(shop.verify(directory).is_some_and(|d| shop.is_harmless(&d)), "an honest dump is refused");
    for _ in 0..share(rounds) {
        for (kind, edit) in EDITS.iter().chain(steps::EDITS) {
            let mut forged = dump.clone();
            if edit(&mut forged, random) {
                let forged = sealed(forged);
                let [regions, certificate] =
                    [text(&forged.regions), text(forged.certificate.as_ref().unwrap())];
                put(directory, &forged.manifest.text().unwrap(), &regions, &certificate);
                table.judge(shop, kind, directory);
            }
        }
        for _ in 0..5 {
            let (manifest, regions, certificate) = byte(dump, random);
            put(directory, &manifest.text().unwrap(), &regions, &certificate);
            table.judge(shop, "a digit of a file is changed", directory);
        }
    }
}

#[test]
fn verify_refuses_every_mutation_that_is_false() {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut table = Table(BTreeMap::new());
    let mut shop = Shop::new(MODEL, PREFERENCES);
    for scope in ["reachable", "all"] {
        for &safety in Safety::ALL {
            for max_level in [None, Some(1)] {
                let named = (scope.to_owned(), safety, max_level, CONSTANTS.to_owned());
                let dump = shop.honest(named).unwrap().clone();
                forge(&mut shop, &dump, &mut table, &mut random, 4);
            }
        }
    }
    let read = |path: &str| fs::read_to_string(path).unwrap();
    let mut shop = Shop::new(&read("models/lateral_prefix.prism"), &read("models/lateral_prefix.pref"));
    for safety in [Safety::Action, Safety::Prefix] {
        let dump = shop.honest(("all".to_owned(), safety, None, String::new())).unwrap().clone();
        forge(&mut shop, &dump, &mut table, &mut random, 4);
    }
    table.close();
}

/// Returns two numbers: the refused dumps of changed models and preferences under the manifest of the true
/// ones, and all such dumps. The accepted dumps must equal the true one.
fn of_others(
    [model, preferences, constants]: [&str; 3],
    changes: &[(&str, &str)],
    safeties: &[Safety],
) -> (usize, usize) {
    let scratch = tempfile::tempdir().unwrap();
    let (mut refused, mut all) = (0, 0);
    let mut truth = Shop::new(model, preferences);
    for (from, to) in changes {
        let mut other = Shop::new(&model.replace(from, to), &preferences.replace(from, to));
        for scope in ["reachable", "all"] {
            for &safety in safeties {
                let named = (scope.to_owned(), safety, None, constants.to_owned());
                let honest = truth.honest(named.clone()).unwrap().manifest.clone();
                let mut dump = other.honest(named).unwrap().clone();
                let (regions, certificate) = (dump.manifest.regions, dump.manifest.certificate);
                dump.manifest = Manifest { regions, certificate, ..honest };
                let [regions, certificate] = [text(&dump.regions), text(dump.certificate.as_ref().unwrap())];
                put(scratch.path(), &dump.manifest.text().unwrap(), &regions, &certificate);
                all += 1;
                match truth.verify(scratch.path()) {
                    None => refused += 1,
                    Some(dump) => assert!(truth.is_harmless(&dump), "{from} -> {to}, {scope}, {safety}"),
                }
            }
        }
    }
    (refused, all)
}

/// Changes of the model and of the preferences: the replaced text and its replacement.
const OTHERS: &[(&str, &str)] = &[
    ("init 2", "init 3"),
    ("[back] x>1 & b", "[back] x>2 & b"),
    ("[] x=2 & b -> (x'=1);", ""),
    ("1-p:(b'=!b)", "1-p:(b'=true)"),
    ("(x'=x-1)&(b'=false)", "(x'=x-1)"),
    ("[go] x<K & !b", "[go] x<K"),
    ("F x=3", "F x=2"),
    ("F (x=4 & b)", "F x=4"),
    ("prefer C > D", "prefer D > C"),
    ("prefer C > B > A", "prefer C > B"),
    ("prefer C > B > A", "prefer C, B, A > D"),
    ("objective A", "empty = gain; objective A"),
    ("objective A", "empty = incomparable; objective A"),
];

/// All sets fit each other, since they were computed: of another model, or by other preferences.
#[test]
fn a_dump_of_something_else_is_refused() {
    let (refused, all) = of_others([MODEL, PREFERENCES, CONSTANTS], OTHERS, Safety::ALL);
    println!("{refused} of {all} refused, the others say the same");
    assert!(refused > OTHERS.len() * 4);
}

/// Round after round something improves on the last, and a detour leads there, too.
const RING: &str = "mdp module m s:[0..4];
      [go] s=0 -> 0.5:(s'=1) + 0.5:(s'=3); [go] s=1 -> 0.5:(s'=2) + 0.5:(s'=3); [go] s=2 -> 0.5:(s'=0) + 0.5:(s'=3);
      [detour] s=0 -> 0.5:(s'=4) + 0.5:(s'=3); [on] s=4 -> 0.5:(s'=1) + 0.5:(s'=3); [stay] true -> true;
    endmodule";
const RING_PREFERENCES: &str =
    "objective A = F s=0; objective A1 = F s=0; objective B = F s=1; objective B1 = F s=1;
    objective C = F s=2; objective C1 = F s=2; objective Z = F s=3; objective W = F s=4;
    prefer B > A1; prefer C > B1; prefer A > C1;";

/// Against the class of state 0, state 4 is taken out of the unbounded level, of its layers and of its
/// strategy; so is the detour in state 0. Each set fits the others, and something that is permitted is
/// said not to be.
#[test]
fn a_choice_left_out_everywhere_is_missed() {
    const AGAINST: &str = "spi:unbounded@A+A1+Z";
    let mut shop = Shop::new(RING, RING_PREFERENCES);
    let named = ("all".to_owned(), Safety::Prefix, None, String::new());
    let mut dump = shop.honest(named).unwrap().clone();
    let detour = dump.manifest.choices.numbers.iter().find(|n| n.name == "detour").unwrap().number;
    let order = dump.manifest.choices.order.clone();
    let bit = |(position, name): (usize, &'static str)| (name, 4 >> position & 1 == 1);
    let away: Vec<(&str, bool)> = ["s.0", "s.1", "s.2"].into_iter().enumerate().map(bit).collect();
    let width = order.len();
    let number =
        order.iter().enumerate().map(|(k, name)| (name.as_str(), detour >> (width - 1 - k) & 1 == 1));
    let chosen: Vec<_> = [("s.0", false), ("s.1", false), ("s.2", false)].into_iter().chain(number).collect();
    let offset = width as u32;
    let (file, diagram) = proof(&mut dump);
    let layers = format!("layers:{AGAINST}:");
    for root in &mut file.roots {
        if root.name == AGAINST || root.name.starts_with(&layers) {
            root.node = without(diagram, root.node, offset, &away);
        } else if root.name == format!("strategy:{AGAINST}") {
            let rest = without(diagram, root.node, 0, &away);
            root.node = without(diagram, rest, 0, &chosen);
        }
    }
    let (file, diagram) = (&mut dump.manifest.regions, &mut dump.regions);
    let root = file.roots.iter_mut().find(|r| r.name == "strategy:spi:unbounded").unwrap();
    root.node = without(diagram, root.node, 0, &chosen);
    let scratch = tempfile::tempdir().unwrap();
    let forged = sealed(dump);
    let count = |file: &File, name: &str| file.root(name).unwrap().count.clone();
    assert_eq!(count(&forged.manifest.regions, "strategy:spi:unbounded"), "6");
    assert_eq!(count(forged.manifest.certificate.as_ref().unwrap(), AGAINST), "2");
    let [regions, certificate] = [text(&forged.regions), text(forged.certificate.as_ref().unwrap())];
    put(scratch.path(), &forged.manifest.text().unwrap(), &regions, &certificate);
    assert!(shop.verify(scratch.path()).is_none());
}
