//! Classes, levels and strategies against the literal definitions: the doubled MDP, and the chains that
//! strategies induce.

use proptest::prelude::*;

use crate::common::prelude::*;
use crate::planning::generate::case;
use crate::planning::literal::Literal;
use crate::planning::tiny::Tiny;
use crate::planning::{Case, analyse, strategies};

fn check(case: &Case) {
    let engine = case.engine();
    for &empty in Empty::ALL {
        let preferences = case.preferences(&engine, empty);
        let literal = Literal::new(case, empty);
        for &safety in Safety::ALL {
            let analysis = analyse(&engine, &preferences, safety);
            strategies::check(&analysis, &literal);
            if safety.never_weakens() {
                strategies::check_kept(&analysis, &literal);
            }
            check_cut(&engine, &preferences, &analysis);
        }
    }
}

/// Checks that a search that is cut after the first level knows a lower bound.
fn check_cut(engine: &Arc<Tiny>, preferences: &Arc<Preferences>, whole: &Analysis<Tiny>) {
    let options = Options { max_level: Some(1), ..whole.options() };
    let cut = finished(engine, preferences, options);
    for kind in [Kind::Sasi, Kind::Spi] {
        for s in engine.all_states().into_iter().map(|s| s as i64) {
            let [rank, least] =
                [whole, &cut].map(|analysis| analysis.levels(kind).rank(&**engine, &[s]).unwrap());
            match rank {
                // An empty first level ends the search before it is cut.
                Rank::Finite(0) => assert_eq!(least, Rank::Finite(0)),
                _ => assert_eq!(least, Rank::AtLeast(1)),
            }
        }
    }
}

proptest! {
    #![proptest_config(meliora_amount::random(800))]

    #[test]
    fn classes_levels_and_strategies_are_those_of_the_definitions(case in case(7)) {
        check(&case);
    }
}
