//! The states of the scope and their choices; all other sets are subsets of them.

use super::draft::{Draft, Members};
use super::{HISTORIES, case, cases, refused};
use crate::common::prelude::*;

/// State 2 has a step to state 1 and no predecessor; state 1 is a deadlock. Two bits also encode 3, which is not a
/// value.
const MODEL: &str = "mdp module m s:[0..2] init 0; [go] s=0 -> (s'=1); [on] s=2 -> (s'=1); endmodule";
const PREFERENCES: &str = "objective A = F s=1; objective B = F s>=0; prefer B > A;";

#[test]
fn each_condition_on_what_the_model_says_is_needed() {
    cases(MODEL, PREFERENCES, &HISTORIES, Safety::ALL).refuse(&[
        ("`initial` are the initial states", |d| d.set("initial", d.states(&[1]))),
        ("`choices` are the enabled ones", |d| d.take("choices", &d.choices("go", 0))),
        ("`deadlock` are the states where nothing is enabled", |d| d.set("deadlock", [].into())),
        ("`deadlock` are the states where nothing is enabled", |d| d.add("deadlock", &d.states(&[0]))),
    ]);
}

/// The dump of the scope `reachable` under a manifest that says `all`.
#[test]
fn all_valuations_are_in_the_scope_all() {
    let condition = "`reachable` contains all valuations, as the scope `all` requires";
    for &safety in Safety::ALL {
        let [reachable, all] = [Scope::Reachable, Scope::All]
            .map(|scope| case(MODEL, &format!("{PREFERENCES} history = state;"), scope, safety));
        let mut draft = Draft::of(&reachable.dump);
        draft.manifest.scope = "all".to_owned();
        draft.layers("reachable", &[]);
        refused(&all, &draft.dump(), condition, &safety.to_string());
    }
}

/// Takes states and their choices out of all sets. Layers and rounds of which nothing remains are left out.
fn forget(draft: &mut Draft, gone: &Members) {
    assert!(!gone.is_empty());
    let mut empty = Vec::new();
    for name in draft.names() {
        let members = draft.get(&name);
        let is_kept = |m: &Vec<i64>| !gone.contains(m) && !gone.contains(&m[1..]);
        let kept: Members = members.iter().filter(|m| is_kept(m)).cloned().collect();
        let is_step = name.starts_with("layers:") || name.starts_with("refuted:");
        if kept.is_empty() && is_step {
            empty.push(name);
        } else if kept != members {
            draft.set(&name, kept);
        }
    }
    empty.iter().rev().for_each(|name| draft.leave_out(name));
}

/// A state in which paths may begin, and which has no predecessor, is left out.
#[test]
fn states_in_which_plays_begin_are_not_left_out() {
    let condition = "each state in which paths start is in `reachable`";
    for &safety in Safety::ALL {
        let preferences = format!("{PREFERENCES} history = play;");
        let case = case(MODEL, &preferences, Scope::All, safety);
        let mut draft = Draft::of(&case.dump);
        let gone = draft.states(&[2]);
        forget(&mut draft, &gone);
        refused(&case, &draft.dump(), condition, &safety.to_string());
    }
}

/// The dump of the scope `all` under a manifest that says `reachable`.
#[test]
fn states_that_cannot_be_reached_are_refused() {
    let condition = "each state of `reachable` is in one of its layers";
    for &safety in Safety::ALL {
        let [reachable, all] = [Scope::Reachable, Scope::All]
            .map(|scope| case(MODEL, &format!("{PREFERENCES} history = state;"), scope, safety));
        let mut draft = Draft::of(&all.dump);
        draft.manifest.scope = "reachable".to_owned();
        draft.layers("reachable", &[&draft.states(&[0]), &draft.states(&[1])]);
        refused(&reachable, &draft.dump(), condition, &safety.to_string());
    }
}

/// Bit patterns that are not values.
fn no_values(draft: &Draft) -> Members {
    draft.states(&[0]).iter().map(|state| [&[3], &state[1..]].concat()).collect()
}

/// The set for the level after the last one may be any that contains all states that win it, but only states of the
/// scope.
#[test]
fn all_sets_are_within_the_scope() {
    cases(MODEL, PREFERENCES, &HISTORIES, &[Safety::Prefix]).refuse(&[
        ("each state of `spi:1@B` is one of `reachable`", |d| d.add("spi:1@B", &no_values(d))),
        ("each state of `sasi:1@B` is one of `reachable`", |d| d.add("sasi:1@B", &no_values(d))),
    ]);
    let condition = "each state of `reachable` has values in range";
    let forge = |d: &mut Draft| d.add("reachable", &no_values(d));
    cases(MODEL, PREFERENCES, &HISTORIES, Safety::ALL).refuse(&[(condition, forge)]);
}
