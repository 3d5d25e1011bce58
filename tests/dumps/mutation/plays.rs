//! Mutation tests of dumps of objectives over whole paths.

use super::shop::Shop;
use super::{Table, forge};
use crate::common::prelude::*;

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
fn verify_refuses_false_mutations_of_whole_plays() {
    let mut random = ChaCha8Rng::seed_from_u64(8);
    let mut table = Table(BTreeMap::new());
    let mut shop = Shop::new(MODEL, PREFERENCES);
    for scope in ["reachable", "all"] {
        for &safety in Safety::ALL {
            let named = (scope.to_owned(), safety, None, CONSTANTS.to_owned());
            let dump = shop.honest(named).unwrap().clone();
            forge(&mut shop, &dump, &mut table, &mut random, 4);
        }
    }
    table.close();
}

/// Nested formulas: monitors with debts and with formulas that must last, alone and joined by a normal
/// form.
const NESTED: &str = "objective A = x!=3 U (G x=2); objective B = (F x=1) W x=2;
    objective C = G (x=1 => F (x=0 & G F x=2)); prefer A > B; prefer B > C;";

#[test]
fn verify_refuses_false_mutations_of_nested_formulas() {
    let mut random = ChaCha8Rng::seed_from_u64(10);
    let mut table = Table(BTreeMap::new());
    let mut shop = Shop::new(MODEL, NESTED);
    for (scope, safety) in [("reachable", Safety::Prefix), ("all", Safety::Action)] {
        let named = (scope.to_owned(), safety, None, CONSTANTS.to_owned());
        let dump = shop.honest(named).unwrap().clone();
        forge(&mut shop, &dump, &mut table, &mut random, 4);
    }
    table.close();
}

#[test]
fn verify_refuses_false_mutations_under_requirements() {
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let mut table = Table(BTreeMap::new());
    for requirements in ["require G x!=1;", "require G (x=0 => X x!=3); require G (x=2 => X x!=0);"] {
        let mut shop = Shop::new(MODEL, &format!("{PREFERENCES}{requirements}"));
        for (scope, safety) in
            [("reachable", Safety::Action), ("all", Safety::Transition), ("all", Safety::Prefix)]
        {
            let named = (scope.to_owned(), safety, None, CONSTANTS.to_owned());
            let dump = shop.honest(named).unwrap().clone();
            forge(&mut shop, &dump, &mut table, &mut random, 3);
        }
    }
    table.close();
}
