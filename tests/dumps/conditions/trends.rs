//! Layers and rounds whose steps lead into themselves: only steps of one trend do, so that no path of them is a
//! cycle.
//!
//! B is almost sure everywhere and preferred to A, so that A decides no class.

use meliora::dump::manifest::Digit;
use meliora::model::trend::Trend;
use meliora::planning::Safety;

use super::draft::{Draft, Members};
use super::{HISTORIES, cases};

/// State 1 is the target. States 2 and 3 lead to each other. States 4 and 5 lead to each other or to the target, by
/// chance; states 6 and 7 in the same way to each other or to state 2.
const MODEL: &str = "mdp module m s:[0..7] init 0;
      [begin] s=0 -> 0.25:(s'=2) + 0.25:(s'=4) + 0.25:(s'=5) + 0.25:(s'=6); [stay] s=1 -> true;
      [circle] s=2 -> (s'=3); [circle] s=3 -> (s'=2);
      [try] s=4 -> 0.5:(s'=5) + 0.5:(s'=1); [try] s=5 -> 0.5:(s'=4) + 0.5:(s'=1);
      [risk] s=6 -> 0.5:(s'=7) + 0.5:(s'=2); [risk] s=7 -> 0.5:(s'=6) + 0.5:(s'=2);
    endmodule";
const PREFERENCES: &str = "objective A = F s=1; objective B = F s>=0; prefer B > A;";

/// Adds the states that never reach the target to its positive region, as a layer with this trend.
fn trapped(draft: &mut Draft, trend: Option<Trend>) {
    let cycle = draft.states(&[2, 3, 6, 7]);
    let [first, near] = [&[0][..], &[4, 5]].map(|s| draft.states(s));
    draft.layers("positive:A", &[&draft.get("target:A"), &near, &first, &cycle]);
    draft.add("positive:A", &cycle);
    draft.set_trend("layers:positive:A:3", trend);
}

/// States that lead to each other, and not to the target, are said to reach it.
#[test]
fn no_cycle_is_a_layer() {
    cases(MODEL, PREFERENCES, &HISTORIES, Safety::ALL).refuse(&[
        ("each state in layer 3 of `positive:A` has a step into an earlier layer", |d| trapped(d, None)),
        ("each state in layer 3 of `positive:A` has a falling step into this layer or an earlier one", |d| {
            trapped(d, Some(Trend::Falling))
        }),
        ("each state in layer 3 of `positive:A` has a rising step into this layer or an earlier one", |d| {
            trapped(d, Some(Trend::Rising))
        }),
    ]);
}

/// States that may return to each other before they reach the target are said to be lost.
fn lost(draft: &mut Draft, trend: Option<Trend>) {
    let (target, cycle) = (draft.get("target:A"), draft.states(&[4, 5]));
    draft.layers("almost-sure:A", &[&target]);
    draft.set("almost-sure:A", target.clone());
    draft.set("strategy:almost-sure:A", [].into());
    draft.rounds("almost-sure:A", &[&cycle, &draft.others(&(&target | &cycle))]);
    draft.set_trend("refuted:almost-sure:A:0", trend);
}

#[test]
fn no_cycle_is_a_round() {
    const CONDITION: &str = "no state lost in round 0 of `almost-sure:A` has a safe step out of the round";
    cases(MODEL, PREFERENCES, &HISTORIES, Safety::ALL).refuse(&[
        (CONDITION, |d| lost(d, None)),
        (CONDITION, |d| lost(d, Some(Trend::Falling))),
        (CONDITION, |d| lost(d, Some(Trend::Rising))),
    ]);
}

const OWN_ORDER: &str =
    "an order of rounds has each variable of the model once, and only rounds with a trend have one";

#[test]
fn trends_without_meaning_are_refused() {
    const ORDER: &str =
        "the certificate orders each variable of the model once if a layer or round has a trend, else none";
    cases(MODEL, PREFERENCES, &HISTORIES, Safety::ALL).refuse(&[
        ("layer 0 of `positive:A` has no trend", |d| d.set_trend("layers:positive:A:0", Some(Trend::Rising))),
        ("`target:A` has no trend: it is neither a layer nor a round", |d| {
            d.set_trend("target:A", Some(Trend::Falling))
        }),
        (ORDER, |d| d.manifest.certificate.as_mut().unwrap().order.clear()),
        (ORDER, |d| {
            let order = &mut d.manifest.certificate.as_mut().unwrap().order;
            order[0].variable = "z".to_owned();
        }),
        (ORDER, |d| {
            let order = &mut d.manifest.certificate.as_mut().unwrap().order;
            order.push(order[0].clone());
        }),
        ("only the certificate orders the variables", |d| {
            d.manifest.regions.order.clone_from(&d.manifest.certificate.as_ref().unwrap().order)
        }),
        ("only the certificate orders the variables", |d| {
            let order = &d.manifest.certificate.as_ref().unwrap().order;
            d.manifest.regions.order_of_rounds.clone_from(order);
        }),
        (OWN_ORDER, |d| {
            let proof = d.manifest.certificate.as_mut().unwrap();
            proof.order_of_rounds = [&proof.order[..], &proof.order].concat();
            d.set_trend("refuted:almost-sure:A:0", Some(Trend::Rising));
        }),
    ]);
}

#[test]
fn orders_of_values_without_meaning_are_refused() {
    fn values(draft: &mut Draft, values: &[i64]) {
        let order = &mut draft.manifest.certificate.as_mut().unwrap().order;
        order.iter_mut().find(|digit| digit.variable == "s").unwrap().values = values.to_vec();
    }
    const CONDITION: &str = "an order of the values of `s` has each of them once";
    cases(MODEL, PREFERENCES, &HISTORIES, Safety::ALL).refuse(&[
        (CONDITION, |d| values(d, &[0, 1, 2, 3, 4, 5, 6])),
        (CONDITION, |d| values(d, &[0, 1, 2, 3, 4, 5, 6, 8])),
        (CONDITION, |d| values(d, &[0, 1, 2, 3, 4, 5, 6, 7, 7])),
        (CONDITION, |d| values(d, &[-1, 1, 2, 3, 4, 5, 6, 7])),
    ]);
}

#[test]
fn an_order_of_rounds_without_a_round_that_needs_it_is_refused() {
    for (options, case) in cases(MODEL, PREFERENCES, &HISTORIES, Safety::ALL).0 {
        let mut draft = Draft::of(&case.dump);
        draft.without_trends("refuted:");
        let mut dump = draft.dump();
        let proof = dump.manifest.certificate.as_mut().unwrap();
        proof.order_of_rounds.clone_from(&proof.order);
        super::refused(&case, &dump, OWN_ORDER, &options);
    }
}

/// Layers by distance, and rounds without trends, are what dumps had before.
#[test]
fn layers_by_distance_are_accepted() {
    for (options, case) in cases(MODEL, PREFERENCES, &["history = state;"], Safety::ALL).0 {
        let mut draft = Draft::of(&case.dump);
        let (target, cycle, first) = (draft.get("target:A"), draft.states(&[4, 5]), draft.states(&[0]));
        draft.layers("positive:A", &[&target, &cycle, &first]);
        draft.layers("almost-sure:A", &[&target, &cycle]);
        draft.rounds("almost-sure:A", &[&draft.states(&[2, 3]), &draft.states(&[6, 7]), &first]);
        super::accepted(&case, &draft.dump(), &options);
    }
}

/// We move where t is 0. State x=3 is the target. The states with x=1 and x=2 lead to each other; those with x=4 and x=5
/// lead to each other or to the target, by chance.
const GAME: &str = "smg
      player us [begin], [circle], [try] endplayer
      player them [back], [answer] endplayer
      module m x:[0..5] init 0; t:[0..1] init 0;
      [begin] x=0 & t=0 -> 0.5:(x'=1) + 0.5:(x'=4);
      [circle] x=1 & t=0 -> (x'=2) & (t'=1); [back] x=2 & t=1 -> (x'=1) & (t'=0);
      [try] x=4 & t=0 -> 0.5:(x'=5) & (t'=1) + 0.5:(x'=3); [answer] x=5 & t=1 -> 0.5:(x'=4) & (t'=0) + 0.5:(x'=3);
    endmodule";
const GAME_PREFERENCES: &str = "objective A = F x=3; objective B = F x>=0; prefer B > A;";

/// Forges the dumps of the game with every order of its two variables, each digit in every direction, and with both
/// trends.
fn refuse_all_orders(condition: &str, forge: impl Fn(&mut Draft, Vec<Digit>, Trend)) {
    let safeties = [Safety::Action, Safety::Prefix];
    for (options, case) in cases(GAME, GAME_PREFERENCES, &["history = state;"], &safeties).0 {
        super::accepted(&case, &case.dump, &options);
        for variables in [["x", "t"], ["t", "x"]] {
            for directions in 0..16 {
                let digit = |(at, name): (usize, &str)| Digit {
                    variable: name.to_owned(),
                    reversed: directions >> (2 * at) & 1 == 1,
                    steady: directions >> (2 * at + 1) & 1 == 1,
                    values: Vec::new(),
                };
                for trend in Trend::ALL {
                    let mut draft = Draft::of(&case.dump);
                    draft.without_trends("");
                    forge(&mut draft, variables.into_iter().enumerate().map(digit).collect(), trend);
                    let condition = condition.replace("{trend}", trend.name());
                    super::refused(&case, &draft.dump(), &condition, &options);
                }
            }
        }
    }
}

/// Our step and that of the opponent lead to each other: no order of the variables lets both fall.
#[test]
fn no_cycle_of_two_players_is_a_layer() {
    let condition =
        "each state in layer 3 of `positive:A` has a {trend} step into this layer or an earlier one";
    refuse_all_orders(condition, |draft, order, trend| {
        let [cycle, near, first] = [&[[1, 0], [2, 1]][..], &[[4, 0], [5, 1]], &[[0, 0]]].map(exactly);
        draft.layers("positive:A", &[&draft.get("target:A"), &near, &first, &cycle]);
        draft.add("positive:A", &cycle);
        draft.set_trend("layers:positive:A:3", Some(trend));
        draft.manifest.certificate.as_mut().unwrap().order = order;
    });
}

/// States of two players that may return to each other before they reach the target are said to be lost.
#[test]
fn no_cycle_of_two_players_is_a_round() {
    let condition = "no state lost in round 0 of `almost-sure:A` has a safe step out of the round";
    for has_own in [false, true] {
        refuse_all_orders(condition, |draft, order, trend| {
            let (target, cycle) = (draft.get("target:A"), exactly(&[[4, 0], [5, 1]]));
            draft.layers("almost-sure:A", &[&target]);
            draft.set("almost-sure:A", target.clone());
            draft.set("strategy:almost-sure:A", [].into());
            draft.rounds("almost-sure:A", &[&cycle, &draft.others(&(&target | &cycle))]);
            draft.set_trend("refuted:almost-sure:A:0", Some(trend));
            let proof = draft.manifest.certificate.as_mut().unwrap();
            if has_own {
                proof.order_of_rounds.clone_from(&order);
            }
            proof.order = order;
        });
    }
}

/// These states of the game.
fn exactly(states: &[[i64; 2]]) -> Members {
    states.iter().map(|state| state.to_vec()).collect()
}
