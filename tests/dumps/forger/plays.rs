//! The forger over objectives that speak of whole plays.

use std::collections::BTreeMap;

use meliora::dump::Manifest;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

use super::edits::HARMLESS;
use super::shop::{Shop, text};
use super::{Table, forge, put};

/// A coin, a place that can be kept, and a deadlock.
const MODEL: &str = "mdp const int K;
    module m x:[0..K] init 0;
      [go] x=0 -> 0.5:(x'=1) + 0.5:(x'=2); [back] x=1 -> (x'=0); [on] x=1 -> (x'=3);
      [stay] x=2 -> true; [slip] x=2 -> 0.9:(x'=0) + 0.1:(x'=2);
    endmodule";
/// Two recurrences at once, cases, a persistence, safety, and order in time.
const PREFERENCES: &str = "objective A = (G F x=0) & (G F x=2); objective B = (F G x=2) | (F (x=1 & F x=3));
    objective C = (G x!=1) & (F x=2); objective D = F x=3; prefer A > D; prefer C > B > D;";
const CONSTANTS: &str = "K=4";

#[test]
fn nothing_false_of_whole_plays_gets_past_verify() {
    let mut random = ChaCha8Rng::seed_from_u64(8);
    let mut table = Table(BTreeMap::new());
    let mut shop = Shop::new(MODEL, PREFERENCES);
    for scope in ["reachable", "all"] {
        for safety in ["action", "transition", "prefix"] {
            let named = (scope.to_owned(), safety.to_owned(), None, CONSTANTS.to_owned());
            let dump = shop.honest(named).unwrap().clone();
            forge(&mut shop, &dump, &mut table, &mut random, 4);
        }
    }
    table.print();
    for kind in HARMLESS {
        assert_eq!(table.0[kind].refused, 0, "{kind}: refused, though it says nothing");
    }
}

/// Other models and formulas over the same variables, observers included.
const OTHERS: &[(&str, &str)] = &[
    ("[back] x=1", "[back] x=2"),
    ("[on] x=1 -> (x'=3);", ""),
    ("init 0", "init 2"),
    ("0.9:(x'=0) + 0.1:(x'=2)", "0.9:(x'=0) + 0.1:(x'=1)"),
    ("[slip] x=2 -> 0.9:(x'=0) + 0.1:(x'=2);", ""),
    ("(G F x=0) & (G F x=2)", "(G F x=0) & (G F x=1)"),
    ("(G F x=0) & (G F x=2)", "(G F x=0) | (G F x=2)"),
    ("(G F x=0) & (G F x=2)", "G F x=0"),
    ("F G x=2", "F G x=0"),
    ("F G x=2", "G F x=2"),
    ("(F G x=2) |", "(F G x=2) &"),
    ("(G x!=1) & (F x=2)", "(G x!=1) | (F x=2)"),
    ("(G x!=1) & (F x=2)", "(F x=1) & (F x=2)"),
    ("F x=3", "G x!=3"),
    ("prefer A > D", "prefer D > A"),
    ("objective A", "empty = gain; objective A"),
];

/// All sets fit each other, since they were computed: of another model, or by other formulas.
#[test]
fn a_dump_of_other_plays_is_refused() {
    let scratch = tempfile::tempdir().unwrap();
    let (mut refused, mut all) = (0, 0);
    let mut truth = Shop::new(MODEL, PREFERENCES);
    for (from, to) in OTHERS {
        let mut other = Shop::new(&MODEL.replace(from, to), &PREFERENCES.replace(from, to));
        for scope in ["reachable", "all"] {
            for safety in ["action", "prefix"] {
                let named = (scope.to_owned(), safety.to_owned(), None, CONSTANTS.to_owned());
                let honest = truth.honest(named.clone()).unwrap().manifest.clone();
                let mut dump = other.honest(named).unwrap().clone();
                let (regions, certificate) = (dump.manifest.regions, dump.manifest.certificate);
                dump.manifest = Manifest { regions, certificate, ..honest };
                let [regions, certificate] = [text(&dump.regions), text(dump.certificate.as_ref().unwrap())];
                put(scratch.path(), &dump.manifest.text(), &regions, &certificate);
                all += 1;
                match truth.verify(scratch.path()) {
                    None => refused += 1,
                    Some(dump) => assert!(truth.is_harmless(&dump), "{from} -> {to}, {scope}, {safety}"),
                }
            }
        }
    }
    println!("{refused} of {all} refused, the others say the same");
    assert!(refused > 3 * OTHERS.len());
}
