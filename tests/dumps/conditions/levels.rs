//! Levels and their strategies.

use meliora::planning::Safety;

use super::draft::{Draft, Members};
use super::{Cases, HISTORIES, cases};

/// Two improvements in a row, each by chance: from 0 and 3 to 1 or 2, and from these to 7 or 8. Certain are only 4
/// from states 0 and 3, 5 from state 1, and 6 from state 2.
pub(super) const MODEL: &str = "mdp module m s:[0..8] init 0;
      [wait] s=0 -> (s'=3); [again] s=3 -> (s'=0); [toss] s=3 -> 0.5:(s'=1) + 0.5:(s'=2);
      [sure] s=0 | s=3 -> (s'=4); [sure] s=1 -> (s'=5); [sure] s=2 -> (s'=6);
      [toss] s=1 | s=2 -> 0.5:(s'=7) + 0.5:(s'=8); [stay] s>3 -> true;
    endmodule";
pub(super) const PREFERENCES: &str = "objective L = F s=4; objective M = F s=5; objective N = F s=6;
    objective H = F s=7; objective I = F s=8; prefer H, I > M, N > L;";

/// Without `prefix` there is one arena; with it, each class has its own, with levels in the certificate.
const WITHOUT_CLASSES: [Safety; 2] = [Safety::Action, Safety::Transition];
const WITH_CLASSES: [Safety; 1] = [Safety::Prefix];

fn under(safeties: &[Safety]) -> Cases {
    cases(MODEL, PREFERENCES, &HISTORIES, safeties)
}

/// Makes level 2 the fixpoint, and removes the sets that show that level 3 is empty.
fn unbounded(draft: &mut Draft, kind: &str) {
    let gone = [format!("{kind}:unbounded"), format!("{kind}:3")];
    draft.remove(|name| gone.iter().any(|gone| name.contains(gone)));
    draft.rename(&format!("{kind}:2"), &format!("{kind}:unbounded"));
}

#[test]
fn a_level_that_is_no_fixpoint_is_refused_as_unbounded() {
    under(Safety::ALL).refuse(&[
        ("`sasi:unbounded` is the last level", |d| unbounded(d, "sasi")),
        ("`spi:unbounded` is the last level", |d| unbounded(d, "spi")),
    ]);
}

/// Makes level 2 the fixpoint as well, with the choices that stay in it and no layers.
fn repeated(draft: &mut Draft, kind: &str, class: &str) {
    let fixpoint = format!("{kind}:unbounded");
    draft.remove(|name| name.contains(&fixpoint));
    draft.rename(&format!("{kind}:3"), &fixpoint);
    for name in draft.names().iter().filter(|name| name.starts_with(&format!("{fixpoint}@"))) {
        draft.set(&format!("strategy:{name}"), [].into());
    }
    let staying = &draft.choices("wait", 0) | &draft.choices("again", 3);
    for name in [fixpoint.clone(), fixpoint + class] {
        draft.set(&name, draft.get(&format!("{kind}:2")));
        draft.set(&format!("strategy:{name}"), staying.clone());
        draft.rounds(&name, &[]);
    }
}

#[test]
fn a_last_level_made_the_fixpoint_is_refused() {
    under(&WITHOUT_CLASSES).refuse(&[
        ("each state of `sasi:unbounded` is in one of its layers", |d| repeated(d, "sasi", "")),
        ("each state of `spi:unbounded` is in one of its layers", |d| repeated(d, "spi", "")),
    ]);
    under(&WITH_CLASSES).refuse(&[
        ("each state of `sasi:unbounded@L` is in one of its layers", |d| repeated(d, "sasi", "@L")),
        ("each state of `spi:unbounded@L` is in one of its layers", |d| repeated(d, "spi", "@L")),
    ]);
}

/// Takes level 2 out of the regions. In the certificate it becomes the level after the last one.
fn leave_out(draft: &mut Draft, kind: &str) {
    let (level, strategy) = (format!("{kind}:2"), format!("strategy:{kind}:2"));
    let (layers, next) = (format!("layers:{kind}:2"), format!("{kind}:3"));
    draft.remove(|name| name == level || name.starts_with(&strategy) || name.starts_with(&layers));
    draft.remove(|name| name.contains(&next));
}

/// The same, and makes the level with the class of state 0 empty, with these rounds.
fn leave_out_of_the_class(draft: &mut Draft, kind: &str, rounds: &[&Members]) {
    leave_out(draft, kind);
    draft.set(&format!("{kind}:2@L"), [].into());
    draft.rounds(&format!("{kind}:2@L"), rounds);
}

#[test]
fn a_last_level_left_out_is_missed() {
    under(&WITHOUT_CLASSES).refuse(&[
        ("no state lost in round 0 of `sasi:2` has a safe step out of the round", |d| {
            leave_out(d, "sasi");
            d.rounds("sasi:2", &[&d.get("sasi:1")]);
        }),
        ("each state outside of `sasi:2` is lost in some round", |d| {
            leave_out(d, "sasi");
            d.rounds("sasi:2", &[]);
        }),
        ("each state with a step towards `spi:2` is in it", |d| leave_out(d, "spi")),
    ]);
}

#[test]
fn a_last_level_left_out_of_a_class_is_missed() {
    under(&WITH_CLASSES).refuse(&[
        ("no state wins `sasi:2`", |d| leave_out(d, "sasi")),
        ("no state wins `spi:2`", |d| leave_out(d, "spi")),
        ("no state lost in round 0 of `sasi:2@L` has a safe step out of the round", |d| {
            leave_out_of_the_class(d, "sasi", &[&d.get("sasi:1@L")])
        }),
        ("each state outside of `sasi:2@L` is lost in some round", |d| {
            leave_out_of_the_class(d, "sasi", &[])
        }),
        ("each state with a step towards `spi:2@L` is in it", |d| leave_out_of_the_class(d, "spi", &[])),
    ]);
}

#[test]
fn each_condition_on_levels_of_classes_is_needed() {
    under(&WITH_CLASSES).refuse(&[
        ("`sasi:2` is what its reference classes win", |d| d.take("sasi:2", &d.states(&[0]))),
        ("`spi:2` is what its reference classes win", |d| d.take("spi:2", &d.states(&[0]))),
        ("`strategy:sasi:2` is what its reference classes permit", |d| {
            d.take("strategy:sasi:2", &d.choices("again", 3))
        }),
        ("`strategy:spi:2` is what its reference classes permit", |d| {
            d.take("strategy:spi:2", &d.choices("again", 3))
        }),
    ]);
}

#[test]
fn a_strategy_that_lacks_or_adds_choices_is_refused() {
    under(&WITHOUT_CLASSES).refuse(&[
        ("`strategy:sasi:2` are the kept choices that keep winning", |d| {
            d.take("strategy:sasi:2", &d.choices("again", 3))
        }),
        ("`strategy:sasi:2` are the kept choices that keep winning", |d| {
            d.add("strategy:sasi:2", &d.choices("sure", 0))
        }),
        ("`strategy:spi:2` are the kept choices that keep winning", |d| {
            d.take("strategy:spi:2", &d.choices("again", 3))
        }),
    ]);
    under(&WITH_CLASSES).refuse(&[
        ("`strategy:sasi:2@L` are the kept choices that keep winning", |d| not_again(d, "sasi")),
        ("`strategy:spi:2@L` are the kept choices that keep winning", |d| not_again(d, "spi")),
    ]);
}

/// Takes a permitted choice out of both strategies.
fn not_again(draft: &mut Draft, kind: &str) {
    let again = draft.choices("again", 3);
    draft.take(&format!("strategy:{kind}:2@L"), &again);
    draft.take(&format!("strategy:{kind}:2"), &again);
}

#[test]
fn a_strategy_of_an_empty_level_is_refused() {
    under(Safety::ALL).refuse(&[
        ("`strategy:sasi:unbounded` has no choice, as `sasi:unbounded` has no state", |d| {
            d.set("strategy:sasi:unbounded", d.choices("again", 3))
        }),
        ("`strategy:spi:unbounded` has no choice, as `spi:unbounded` has no state", |d| {
            d.set("strategy:spi:unbounded", d.choices("again", 3))
        }),
    ]);
}

/// Adds state 1 to level 2; it has no path to a goal edge of level 2.
fn too_large_level_2(draft: &mut Draft) {
    draft.add("sasi:2", &draft.states(&[1]));
    draft.rounds("sasi:2", &[&(&draft.get("sasi:1") - &draft.get("sasi:2"))]);
    draft.rounds("sasi:3", &[&draft.get("sasi:2")]);
}

/// Adds state 4, which is never left, to level 1.
fn too_large_level_1(draft: &mut Draft) {
    draft.add("spi:1", &draft.states(&[4]));
    let ahead = [draft.choices("sure", 0), draft.choices("sure", 3), draft.choices("stay", 4)];
    ahead.iter().for_each(|choices| draft.add("strategy:spi:1", choices));
}

#[test]
fn a_level_that_is_too_large_is_refused() {
    under(&WITHOUT_CLASSES).refuse(&[
        ("each state of `sasi:2` is in one of its layers", too_large_level_2),
        ("each state of `spi:1` is in one of its layers", too_large_level_1),
        ("layer 0 of `sasi:2` are the states at its goal", |d| d.layers("sasi:2", &[&d.get("sasi:2")])),
        ("each state in layer 1 of `spi:1` has a step into an earlier layer", |d| {
            d.set_trend("layers:spi:1:1", None);
            too_large_level_1(d);
            d.add("layers:spi:1:1", &d.states(&[4]));
        }),
    ]);
}

/// A state without an improvement is said to win level 2 with the lowest class.
#[test]
fn a_level_that_is_too_large_in_a_class_is_refused() {
    under(&WITH_CLASSES).refuse(&[
        ("each state of `sasi:2@L` is in one of its layers", |d| {
            d.add("sasi:2@L", &d.states(&[7]));
            d.add("strategy:sasi:2@L", &d.choices("stay", 7));
            let lost = &d.get("sasi:1@L") - &d.get("sasi:2@L");
            let first = d.states(&[8]);
            d.rounds("sasi:2@L", &[&first, &(&lost - &first)]);
            d.rounds("sasi:3@L", &[&d.get("sasi:2@L")]);
        }),
        ("each state of `spi:2@L` is in one of its layers", |d| {
            d.add("spi:2@L", &d.states(&[1, 2, 7]));
            let ahead = [d.choices("toss", 1), d.choices("toss", 2), d.choices("stay", 7)];
            ahead.iter().for_each(|choices| d.add("strategy:spi:2@L", choices));
        }),
    ]);
}

/// Adds a level 3 that is empty.
fn one_more(draft: &mut Draft, kind: &str) {
    for name in draft.names() {
        if let Some(class) = name.strip_prefix(&format!("{kind}:3@")) {
            assert_eq!(draft.get(&name), [].into());
            draft.set(&format!("strategy:{name}"), [].into());
            draft.set(&format!("{kind}:4@{class}"), [].into());
        }
    }
    draft.set(&format!("{kind}:3"), [].into());
    draft.set(&format!("strategy:{kind}:3"), [].into());
}

#[test]
fn an_empty_level_is_refused() {
    under(Safety::ALL).refuse(&[
        ("`sasi:3` has a state, and fewer than the level below", |d| one_more(d, "sasi")),
        ("`spi:3` has a state, and fewer than the level below", |d| one_more(d, "spi")),
    ]);
}

/// Each step around the ring improves or ends in state 3.
pub(super) const RING: &str = "mdp module m s:[0..3] init 0;
      [go] s=0 -> 0.5:(s'=1) + 0.5:(s'=3); [go] s=1 -> 0.5:(s'=2) + 0.5:(s'=3); [go] s=2 -> 0.5:(s'=0) + 0.5:(s'=3);
      [stay] true -> true;
    endmodule";
pub(super) const RING_PREFERENCES: &str =
    "objective A = G F s=0; objective A1 = G F s=0; objective B = G F s=1;
    objective B1 = G F s=1; objective C = G F s=2; objective C1 = G F s=2; objective Z = G F s=3;
    prefer B > A1; prefer C > B1; prefer A > C1;";

/// The fixpoint is level 1; here it is level 2 as well.
#[test]
fn a_level_that_is_there_twice_is_refused() {
    let forge = |d: &mut Draft| {
        for name in d.names().iter().filter(|name| name.contains("spi:unbounded")) {
            let repeated = name.replace("spi:unbounded", "spi:2");
            assert!(!d.has(&repeated));
            d.set(&repeated, d.get(name));
        }
    };
    let condition = "`spi:2` has a state, and fewer than the level below";
    cases(RING, RING_PREFERENCES, &["history = play;"], Safety::ALL).refuse(&[(condition, forge)]);
}

/// The other conditions imply this one, which is reported first.
#[test]
fn levels_that_do_not_decrease_are_refused() {
    under(Safety::ALL).refuse(&[
        ("each state of `sasi:2` is in the level below", |d| d.add("sasi:2", &d.states(&[4]))),
        ("each state of `spi:2` is in the level below", |d| d.add("spi:2", &d.states(&[4]))),
    ]);
}

#[test]
fn a_search_that_is_falsely_said_to_be_cut_is_refused() {
    let condition = "the search for levels stopped at the maximum level 3";
    under(Safety::ALL).refuse(&[(condition, |d| d.manifest.max_level = Some(3))]);
}
