//! Answers of single questions that were refused, or said two things.

use crate::cli::common::{Scratch, run};

const TWO: &str = "mdp module m s:[0..3] init 0;
 [a] s=0 -> 0.5:(s'=1)+0.5:(s'=2);
 [b] s=0 -> 0.25:(s'=1)+0.75:(s'=3);
 [c] s=1 -> (s'=0); [d] s>=2 -> (s'=0); endmodule
rewards \"c\" s=1 : 3; [a] true : 1; endrewards";

/// Each part of the conjunction has a monitor of its own, and only one monitor was expected.
#[test]
fn rewards_until_a_conjunction_are_those_until_its_last_part() {
    let scratch = Scratch::new(&[("m.prism", TWO)]);
    let value = |property: &str| {
        let report = scratch.run(format!("reach m.prism --property '{property}' --json"));
        report.expect(0).json()["properties"][0]["value"].clone()
    };
    for optimum in ["min", "max"] {
        let expected = value(&format!("R{{\"c\"}}{optimum}=? [ F ((F s=1) & (F s=2)) ]"));
        assert!(!expected.is_null());
        // The suffix from the first state on is the first one that satisfies both parts.
        assert_eq!(value(&format!("R{{\"c\"}}{optimum}=? [ (F s=1) & (F s=2) ]")), expected);
    }
}

#[test]
fn states_with_a_long_run_average_of_zero_are_not_printed() {
    let text = "dtmc module m s:[0..4] init 0;
 [] s=0 -> 1/5:(s'=1) + 3/10:(s'=2) + 1/2:(s'=0);
 [] s=1 -> 1/3:(s'=0) + 2/3:(s'=2);
 [] s=2 -> 1/7:(s'=1) + 6/7:(s'=3);
 [] s>2 -> true; endmodule";
    let scratch = Scratch::new(&[("m.prism", text)]);
    let report = scratch.run("reach m.prism --property 'filter(print, S=? [ s=4 ])' --json").expect(0).json();
    assert_eq!(report.to_string().matches("\"state\"").count(), 0, "{report}");
}

/// The state was said to have one guaranteed improvement, and its only action to have none.
#[test]
fn a_choice_by_values_says_that_guarantees_under_transition_need_luck() {
    let text = "mdp module m s:[0..3] init 0;
        [a] s=0 -> 1/2:(s'=1)+1/2:(s'=2); [b] s=0 -> (s'=3); [w] s>0 -> true; endmodule";
    let wishes = "objective Low = F (s=1 | s=3); objective High = F s=1; prefer High > Low;";
    let scratch = Scratch::new(&[("m.prism", text), ("m.pref", wishes)]);
    let [model, wishes] = ["m.prism", "m.pref"].map(|name| scratch.show(name));
    let asked = format!("strategy {model} {wishes} --safety transition --choose cheap");
    let text = run(&asked).expect(0).stdout;
    assert!(text.contains("Guaranteed only if no dropped branch happens"), "{text}");
    assert!(!text.contains("no improvement is guaranteed from here"), "{text}");
    let reason = run!("{asked} --json").expect(0).json()["states"][0]["actions"][0]["reason"].clone();
    assert_eq!(reason, "safe, but no improvement is certain if a dropped branch happens");
}

#[test]
fn the_policy_of_a_game_is_refused_without_a_reference_to_itself() {
    let error = run("reach models/pursuit.prism -c N=3 --target true --policy -");
    assert_ne!(error.status, 0);
    error.says("in a game, `strategy` without `--policy`");
}

/// It wrote `x.prism.prism`.
#[test]
fn a_prefix_with_the_extension_of_a_file_is_that_file() {
    let scratch = Scratch::new(&[]);
    for name in ["x.prism", "x.pref"] {
        run!("generate gridworld --rows 4 --cols 4 --force --out {}", scratch.show(name)).expect(0);
        for written in ["x.prism", "x.pref"] {
            std::fs::remove_file(scratch.path(written)).unwrap();
        }
    }
    assert_eq!(std::fs::read_dir(scratch.path("")).unwrap().count(), 0);
}
