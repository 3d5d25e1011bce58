//! The safe regions of `prefix`: where some strategy never weakens a class.

use meliora::planning::Safety;

use super::draft::Draft;
use super::{HISTORIES, cases};

/// Both choices of state 0 weaken its class: each loses one of two objectives, and a lesser one takes its place.
pub(super) const MODEL: &str =
    "mdp module m s:[0..2] init 0; [a] s=0 -> (s'=1); [c] s=0 -> (s'=2); [stay] s>0 -> true; endmodule";
pub(super) const PREFERENCES: &str = "objective A = F s=1; objective X = F s=1;
    objective C = F s=2; objective Y = F s=2; prefer A > Y; prefer C > X;";

/// Makes the safe region of the class of state 1 empty, with all of its levels.
fn nowhere(draft: &mut Draft) {
    draft.set("safe:A+X", [].into());
    draft.remove(|name| name.contains("@A+X"));
    draft.rounds("safe:A+X", &[]);
}

#[test]
fn each_condition_on_safe_regions_is_needed() {
    cases(MODEL, PREFERENCES, &HISTORIES, &[Safety::Prefix]).refuse(&[
        ("no state of `safe:A+X` weakens the class", |d| {
            let all = d.get("reachable");
            d.set("safe:A+X", all.clone());
            d.rounds("safe:A+X", &[]);
            d.rounds("sasi:1@A+X", &[&all]);
        }),
        ("each state of `safe:A+C` has a choice that stays in it", |d| {
            let first = d.states(&[0]);
            d.set("safe:A+C", first.clone());
            d.rounds("safe:A+C", &[&d.others(&first)]);
            d.set("sasi:1@A+C", [].into());
            d.rounds("sasi:1@A+C", &[&first]);
            d.set("spi:1@A+C", [].into());
        }),
        ("each state lost in round 0 of `safe:A+X` weakens, or must risk an earlier round", |d| {
            nowhere(d);
            d.rounds("safe:A+X", &[&d.get("reachable")]);
        }),
        ("each state outside of `safe:A+X` is lost in some round", nowhere),
    ]);
}

/// The class of state 0 has no safe state, and so no levels.
#[test]
fn a_class_that_is_never_safe_is_accepted() {
    for (options, case) in cases(MODEL, PREFERENCES, &HISTORIES, &[Safety::Prefix]).0 {
        let draft = Draft::of(&case.dump);
        assert_eq!(draft.get("class:A+C"), draft.states(&[0]));
        assert_eq!(draft.get("safe:A+C"), [].into());
        assert!(!draft.has("sasi:1@A+C") && draft.has("sasi:1@A+X"));
        super::accepted(&case, &case.dump, &options);
    }
}
