//! Reward structures: the values that choices earn, and the errors in them.

use meliora::lang::{flat, load};
use num_rational::BigRational;

use crate::common::prelude::*;

fn checked(text: &str) -> Checked {
    load(&SourceFile::new("m", text), &SourceFile::new("--const", "")).expect("the model is right")
}

/// Returns the rewards of all choices of a state, as fractions.
fn earned(program: &Program, name: Option<&str>, state: &[i64]) -> Result<Vec<String>, String> {
    let structure = &program.rewards[program.reward_structure(name).expect("the structure exists")];
    let choices = program.choices(state).expect("the state has a meaning");
    let reward = |choice| program.reward(structure, state, choice).map(|r: BigRational| r.to_string());
    choices.iter().map(|(choice, _)| reward(choice)).collect::<Result<_, Error>>().map_err(message)
}

fn message(error: Error) -> String {
    match error {
        Error::Input(all) => {
            let (line, column) = all[0].position();
            format!("{line}:{column}: {}", all[0].message)
        }
        other => other.to_string(),
    }
}

const MODEL: &str = "mdp
    const double third = 1/3;
    module m
      x : [0..3];
      [a] x<2 -> third : (x'=x+1) + 1-third : true;
      [a] x=1 -> (x'=2);
      [] x<2 -> (x'=3);
    endmodule
    module n
      y : bool;
      [a] true -> (y'=!y);
    endmodule
    rewards \"cost\"
      [a] true : third;
      x=1 : 2;
      true : 0.1;
      [] true : x;
      [a] y : x * 0.3;
    endrewards
    rewards
      true : 1;
    endrewards";

#[test]
fn the_items_that_apply_are_added_exactly() {
    let program = checked(MODEL).program;
    let cost = |state: &[i64]| earned(&program, Some("cost"), state).unwrap();
    assert_eq!(cost(&[0, 0]), ["1/10", "13/30"], "[] earns x, [a] a third");
    assert_eq!(cost(&[1, 1]), ["31/10", "41/15", "41/15"], "two choices of one label earn the same");
    assert_eq!(cost(&[3, 1]), ["1/10"], "the loop of a deadlock has no action");
    assert_eq!(earned(&program, None, &[1, 1]).unwrap(), cost(&[1, 1]), "without a name: the first one");
    assert_eq!(program.rewards[1].name, None);
    assert_eq!(program.reward_structure(Some("costs")), None);
}

#[test]
fn a_hidden_action_earns_as_a_step_without_label() {
    let text = "mdp module m x : bool; [a] true -> true; [b] true -> true; endmodule
        rewards [] true : 1; [b] true : 2; [c] true : 4; endrewards
        system (m / {a}) {b<-c} endsystem";
    assert_eq!(earned(&checked(text).program, None, &[0]).unwrap(), ["1", "4"]);
}

#[test]
fn the_choice_of_a_dtmc_earns_the_mean_of_what_it_draws_from() {
    let text = "dtmc module m x : bool; [a] true -> true; [b] true -> true; [] x -> true; endmodule
        rewards [a] true : 1; true : 5; endrewards";
    let program = checked(text).program;
    assert_eq!(earned(&program, None, &[0]).unwrap(), ["11/2"]);
    assert_eq!(earned(&program, None, &[1]).unwrap(), ["16/3"]);
}

#[test]
fn negative_and_undefined_rewards_are_errors_where_they_are_earned() {
    for (reward, at_two) in [
        ("x<3 : 1-x;", "7:9: the reward structure \"r\" earns -1 in the state x=2"),
        (
            "true : 1/(2-x);",
            "7:9: the reward structure \"r\" has no value in the state x=2: the value is not",
        ),
        (
            "true : log(1-x,2);",
            "7:9: the reward structure \"r\" has no value in the state x=2: the value is not",
        ),
        (
            "mod(1,2-x)=0 : 1;",
            "7:9: the reward structure \"r\" has no value in the state x=2: division by zero",
        ),
    ] {
        let text = format!(
            "mdp\nmodule m\n x : [0..3];\n [] x<3 -> (x'=x+1);\nendmodule\nrewards \"r\"\n        {reward}\nendrewards"
        );
        let checked = checked(&text);
        // A logarithm counts as a double, which is a warning of its own.
        let others = checked.warnings.iter().filter(|w| !w.message.starts_with("a double counts"));
        assert_eq!(others.count(), 0, "{reward}");
        assert!(earned(&checked.program, Some("r"), &[0]).is_ok(), "{reward}");
        let found = earned(&checked.program, Some("r"), &[2]).expect_err(reward);
        assert!(found.starts_with(at_two), "{reward}: {found}");
    }
}

#[test]
fn a_wrong_structure_is_a_warning_until_it_is_used() {
    for (rewards, place) in [
        ("rewards \"r\" [aa] true : 1; endrewards", "2:14: unknown action `aa`"),
        ("rewards \"r\" true : y; endrewards", "2:20: unknown name `y`"),
        ("rewards \"r\" x : 1; endrewards", "2:13: type error: the guard of a reward must be of type `bool`"),
        ("rewards \"r\" true : x=1; endrewards", "2:20: type error: a reward must be of type `double`"),
        ("rewards \"r\" true : mod(x,0); endrewards", "2:20: this expression has no value"),
    ] {
        let text = format!("mdp module m x : [0..1]; [a] true -> true; endmodule\n{rewards}");
        let checked = checked(&text);
        let warning = message(Error::Input(checked.warnings.clone()));
        assert_eq!(warning, place, "{rewards}");
        assert_eq!(earned(&checked.program, Some("r"), &[0]), Err(place.to_owned()), "{rewards}");
    }
    let text = "mdp module m endmodule rewards \"r\" endrewards rewards \"r\" true : 1; endrewards";
    let program = checked(text).program;
    assert!(program.rewards[0].errors.is_empty() && !program.rewards[1].errors.is_empty());
}

#[test]
fn the_flat_program_earns_the_same() {
    let hidden = "mdp module m x : bool; [a] true -> true; [b] true -> true; endmodule
        rewards [] true : 1; [b] true : 2; [c] true : 4; endrewards
        rewards \"none\" endrewards
        system (m / {a}) {b<-c} endsystem";
    for (text, states) in [
        (MODEL.replace("1/3", "0.3").as_str(), vec![vec![0, 0], vec![1, 0], vec![1, 1], vec![3, 1]]),
        (hidden, vec![vec![0], vec![1]]),
    ] {
        let program = checked(text).program;
        // The text of a constant such as 1/3 has its rounded value.
        let again = checked(&flat(&program).unwrap()).program;
        assert_eq!(program.rewards.len(), again.rewards.len());
        for state in states {
            for name in program.rewards.iter().map(|structure| structure.name.as_deref()) {
                let [mut one, mut other] = [&program, &again].map(|p| earned(p, name, &state).unwrap());
                one.sort();
                other.sort();
                assert_eq!(one, other, "{name:?} in {state:?}");
            }
        }
    }
}
