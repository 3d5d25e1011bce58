//! Mutation tests of dumps of games.

use super::shop::Shop;
use super::{Table, forge};
use crate::common::prelude::*;

/// Two players against one, states from which every choice of the opponent leads on, states that it may leave for
/// something worse, a deadlock, and steps of both trends.
const MODEL: &str = "smg const int K;
    player us m, [go], [back] endplayer
    player friend [help] endplayer
    player them [push], [pull], [drop] endplayer
    module m x:[0..K] init 1; t:[0..2] init 0;
      [] t=0 & x>0 & x<K -> (t'=1); [go] t=0 & x<K & x>0 -> 0.5:(x'=x+1)&(t'=1) + 0.5:(t'=1);
      [back] t=0 & x=K -> (x'=x-1)&(t'=2);
      [push] t=1 & x<K -> (x'=x+1)&(t'=2); [pull] t=1 & x>1 -> (x'=x-1)&(t'=0);
      [drop] t=1 & x=K -> (x'=0)&(t'=0);
      [help] t=2 & x>0 -> (t'=0); [help] t=2 & x=1 -> (x'=K)&(t'=0);
    endmodule";
const PREFERENCES: &str = "objective A = F x=1; objective B = F (x=2 & t=0); objective C = F x=K;
    objective D = F (x=0); prefer C > B > A; prefer C > D;";

#[test]
fn verify_refuses_false_mutations_of_games() {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let mut table = Table(BTreeMap::new());
    for coalition in ["", "coalition us, friend;", "coalition them;"] {
        for requirement in ["", "require G (x!=0);"] {
            let mut shop = Shop::new(MODEL, &format!("{coalition}{PREFERENCES}{requirement}"));
            for (scope, safety) in
                [("reachable", Safety::Action), ("all", Safety::Action), ("all", Safety::Prefix)]
            {
                let named = (scope.to_owned(), safety, None, "K=3".to_owned());
                let dump = shop.honest(named).unwrap().clone();
                forge(&mut shop, &dump, &mut table, &mut random, 2);
            }
        }
    }
    table.close();
}
