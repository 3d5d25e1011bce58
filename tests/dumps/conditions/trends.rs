//! Layers and rounds whose steps lead into themselves: only steps of one trend do, so that no path of them is a
//! cycle.
//!
//! B is almost sure everywhere and preferred to A, so that A decides no class.

use meliora::model::trend::Trend;
use meliora::planning::Safety;

use super::draft::Draft;
use super::{Fault, HISTORIES, cases, refuse};

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
    let faults = [
        Fault {
            condition: "each state in layer 3 of `positive:A` has a step into an earlier layer",
            forge: |d| trapped(d, None),
        },
        Fault {
            condition: "each state in layer 3 of `positive:A` has a falling step into this layer or an earlier one",
            forge: |d| trapped(d, Some(Trend::Falling)),
        },
        Fault {
            condition: "each state in layer 3 of `positive:A` has a rising step into this layer or an earlier one",
            forge: |d| trapped(d, Some(Trend::Rising)),
        },
    ];
    refuse(&cases(MODEL, PREFERENCES, &HISTORIES, Safety::ALL), &faults);
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
    let faults = [
        Fault { condition: CONDITION, forge: |d| lost(d, None) },
        Fault { condition: CONDITION, forge: |d| lost(d, Some(Trend::Falling)) },
        Fault { condition: CONDITION, forge: |d| lost(d, Some(Trend::Rising)) },
    ];
    refuse(&cases(MODEL, PREFERENCES, &HISTORIES, Safety::ALL), &faults);
}

#[test]
fn trends_without_meaning_are_refused() {
    const ORDER: &str =
        "the certificate orders each variable of the model once if a layer or round has a trend, else none";
    let faults = [
        Fault {
            condition: "layer 0 of `positive:A` has no trend",
            forge: |d| d.set_trend("layers:positive:A:0", Some(Trend::Rising)),
        },
        Fault {
            condition: "`target:A` has no trend: it is neither a layer nor a round",
            forge: |d| d.set_trend("target:A", Some(Trend::Falling)),
        },
        Fault { condition: ORDER, forge: |d| d.manifest.certificate.as_mut().unwrap().order.clear() },
        Fault {
            condition: ORDER,
            forge: |d| {
                let order = &mut d.manifest.certificate.as_mut().unwrap().order;
                order[0].variable = "z".to_owned();
            },
        },
        Fault {
            condition: ORDER,
            forge: |d| {
                let order = &mut d.manifest.certificate.as_mut().unwrap().order;
                order.push(order[0].clone());
            },
        },
        Fault {
            condition: ORDER,
            forge: |d| d.manifest.regions.order.clone_from(&d.manifest.certificate.as_ref().unwrap().order),
        },
    ];
    refuse(&cases(MODEL, PREFERENCES, &HISTORIES, Safety::ALL), &faults);
}

/// Layers by distance, and rounds without trends, are what dumps had before.
#[test]
fn layers_by_distance_are_accepted() {
    for (options, case) in cases(MODEL, PREFERENCES, &["history = state;"], Safety::ALL) {
        let mut draft = Draft::of(&case.dump);
        let (target, cycle, first) = (draft.get("target:A"), draft.states(&[4, 5]), draft.states(&[0]));
        draft.layers("positive:A", &[&target, &cycle, &first]);
        draft.layers("almost-sure:A", &[&target, &cycle]);
        draft.rounds("almost-sure:A", &[&draft.states(&[2, 3]), &draft.states(&[6, 7]), &first]);
        super::accepted(&case, &draft.dump(), &options);
    }
}
