//! Bounds of quantities in dumps of games: in the opponent's states the conditions change sides.

use meliora::dump::bounds::Row;

use crate::common::prelude::*;
use crate::dumps::values::{Case, between, cost, row};

/// The states 1 and 2, 3 and 5, 9 and 10 are cycles that the opponent or we may stay in forever; 9 and 10 cost nothing.
/// At 7, the opponent decides how long it takes.
pub(super) const CYCLES: &str = "smg
    player us [a], [b], [pay], [stay] endplayer
    player them [c], [d], [free] endplayer
    module m s:[0..23] init 0;
      [a] s=0 -> (s'=1); [b] s=0 -> 0.5:(s'=21) + 0.5:(s'=23);
      [c] s=1 -> 0.3:(s'=21) + 0.7:(s'=23); [d] s=1 -> (s'=2);
      [a] s=2 -> (s'=1); [b] s=2 -> 0.4:(s'=22) + 0.6:(s'=23);
      [c] s=3 -> (s'=5); [a] s=5 -> (s'=3); [b] s=5 -> 0.4:(s'=22) + 0.6:(s'=23);
      [c] s=7 -> 0.5:(s'=21) + 0.5:(s'=22); [d] s=7 -> 0.5:(s'=7) + 0.5:(s'=8);
      [a] s=8 -> 0.25:(s'=21) + 0.75:(s'=22); [b] s=8 -> (s'=7);
      [free] s=9 -> (s'=10); [stay] s=10 -> (s'=9); [pay] s=10 -> 0.5:(s'=21) + 0.5:(s'=22);
      [stay] s=4 | s=6 | s>10 -> true;
    endmodule
    rewards \"fuel\" [pay] true : 5; [a] true : 1; [c] true : 1; [d] true : 1; [b] true : 2; endrewards";
pub(super) const GOALS: &str =
    "objective A = F s>=0; objective G = F s=21; objective H = F s=22; prefer G, H > A;";

/// A walk in which every state reaches every other one. In every third state the opponent chooses, so that large
/// components occur.
const WALK: &str = "smg player us [a], [b] endplayer player them [c], [d] endplayer
    module m x:[0..60] init 30;
      [a] x>0 & x<60 & mod(x,3)>0 -> 0.5:(x'=x-1) + 0.5:(x'=x+1);
      [b] x>0 & x<60 & mod(x,3)>0 -> 0.3:(x'=x-1) + 0.3:(x'=x+1) + 0.4:(x'=max(x-3,0));
      [c] x>0 & x<60 & mod(x,3)=0 -> 0.5:(x'=x-1) + 0.5:(x'=x+1);
      [d] x>0 & x<60 & mod(x,3)=0 -> 0.45:(x'=x-1) + 0.45:(x'=x+1) + 0.1:true;
      [a] x=60 | x=0 -> true;
    endmodule";
const ENDS: &str = "objective A = F x=60; objective B = F x=0; prefer A > B; empty = gain;";

fn cycles(reward: &str) -> Case {
    Case::of([CYCLES, GOALS], Scope::All, Safety::Action, reward)
}

#[test]
fn every_dump_of_a_game_with_values_is_accepted() {
    for safety in [Safety::Action, Safety::Prefix] {
        for coalition in ["", "coalition them; "] {
            for (text, wishes, reward) in
                [(CYCLES, GOALS, "steps"), (CYCLES, GOALS, "fuel"), (WALK, ENDS, "steps")]
            {
                let case = Case::of([text, &format!("{coalition}{wishes}")], Scope::All, safety, reward);
                assert_eq!(case.violated(&case.dump), None, "{safety} {reward} {coalition}");
                assert!(case.width <= 1e-6, "{safety} {reward} {coalition}: {}", case.width);
                assert!(case.is_true(&case.dump), "{safety} {reward} {coalition}");
            }
        }
    }
}

fn refused(case: &Case, state: i64, edit: impl Fn(&mut Row)) -> String {
    case.row_refused(&[state], edit)
}

#[test]
fn each_condition_on_probabilities_of_a_game_fails_alone() {
    let case = cycles("steps");
    let bounds = |lower, upper, rank| move |r: &mut Row| r.probabilities[0] = between(lower, upper, rank);
    let least = |who: &str| format!("{who} at least the lower bound of P_1, and enters a smaller rank");
    let [ours, theirs] = ["some kept choice has", "each choice of the opponent has"].map(least);
    // Without [c], the opponent would leave us 2/5 at 1.
    assert_eq!(refused(&case, 1, bounds(0.4, 0.5, 9)), theirs);
    assert_eq!(refused(&case, 2, bounds(0.41, 0.5, 1)), ours);
    assert_eq!(
        refused(&case, 1, bounds(0.0, 0.29, 0)),
        "some choice of the opponent has no more than the upper bound of P_1"
    );
    assert_eq!(
        refused(&case, 2, bounds(0.35, 0.39, 1)),
        "no kept choice has more than the upper bound of P_1"
    );
    // Two states that confirm each other.
    let cycle = |ranks: [u32; 2]| {
        case.refused(|dump| {
            for (state, rank) in [3, 5].into_iter().zip(ranks) {
                row(dump, &[state]).probabilities[0] = between(0.9, 1.0, rank);
            }
        })
    };
    assert_eq!([cycle([8, 7]), cycle([7, 8])], [ours.clone(), theirs.clone()]);
    // A rank of each choice: [d] of 1 enters the rank of 2.
    assert_eq!(refused(&case, 1, |r| r.probabilities[0].rank = 1), theirs);
}

#[test]
fn each_condition_on_costs_of_a_game_fails_alone() {
    let case = cycles("steps");
    let bounds = |lower, upper, rank| move |r: &mut Row| *cost(r) = between(lower, upper, rank);
    let most = |who: &str| format!("{who} costs at most the upper bound of C_1, and enters a smaller rank");
    let [ours, theirs] = ["some permitted choice", "each choice of the opponent is permitted,"].map(most);
    // Without [d], the opponent would make one step.
    assert_eq!(refused(&case, 7, bounds(0.0, 1.0, 9)), theirs);
    assert_eq!(
        refused(&case, 7, bounds(3.1, f64::INFINITY, 0)),
        "some choice of the opponent does not cost less than the lower bound of C_1"
    );
    // Nothing is said about 7, which depends on 8.
    let at_8 = |edit: &dyn Fn(&mut Row)| {
        case.refused(|dump| {
            bounds(0.0, f64::INFINITY, 0)(row(dump, &[7]));
            edit(row(dump, &[8]));
        })
    };
    assert_eq!(at_8(&bounds(0.0, 0.9, 9)), ours);
    assert_eq!(
        at_8(&bounds(1.1, f64::INFINITY, 0)),
        "no permitted choice costs less than the lower bound of C_1"
    );
    assert_eq!(refused(&case, 7, |r| cost(r).rank = 1), theirs);
    // A cycle of cost 0, which nobody leaves.
    let case = cycles("fuel");
    let cycle = |ranks: [u32; 2]| {
        case.refused(|dump| {
            for (state, rank) in [9, 10].into_iter().zip(ranks) {
                *cost(row(dump, &[state])) = between(0.0, 0.0, rank);
            }
        })
    };
    assert_eq!([cycle([8, 7]), cycle([7, 8])], [ours, theirs]);
}

/// A random game of `n` states and three ends, in which most steps lead to states nearby.
fn random_game(n: i64, random: &mut ChaCha8Rng) -> String {
    let mut text = format!(
        "smg player us [u0], [u1], [u2] endplayer player them [t0], [t1], [t2] endplayer
        module m s:[0..{}]; [u0] s>={n} -> true;\n",
        n + 2
    );
    for action in ["u1", "u2", "t0", "t1", "t2"] {
        text += &format!("[{action}] false -> true;\n");
    }
    for s in 0..n {
        let side = ["u", "t"][usize::from(random.random_bool(0.5))];
        for choice in 0..random.random_range(1..=3) {
            let shares: &[&str] = match random.random_range(0..4) {
                0 => &["1"],
                1 => &["0.5", "0.5"],
                2 => &["0.999", "0.001"],
                _ => &["1/3", "2/3"],
            };
            let branch = |share: &&str| {
                let near = (s + random.random_range(-5..=5)).clamp(0, n - 1);
                let to = if random.random_bool(0.1) { n + random.random_range(0..3) } else { near };
                format!("{share}:(s'={to})")
            };
            let branches = Vec::from_iter(shares.iter().map(branch)).join(" + ");
            text += &format!("[{side}{choice}] s={s} -> {branches};\n");
        }
    }
    text + "endmodule rewards \"cost\" [u0] true : 1; [t1] true : 0.25; [u2] true : 5; endrewards"
}

/// An improving step under `prefix` is counted or not, whichever has the better bound. Where the bounds differ only by
/// rounding, the strategy may do the other one.
#[test]
fn certificates_of_larger_games_are_accepted() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let (mut rows, mut open) = (0, 0);
    for at in 0..share(40).max(12) {
        let n = [12, 30, 60][at % 3];
        let (text, [first, second, third]) = (random_game(n, &mut random), [n, n + 1, n + 2]);
        let wishes = format!(
            "objective A = F s={first}; objective B = F s={second}; objective C = F s={third};
            prefer C > B > A; empty = gain; {}",
            ["", "coalition them;"][at / 3 % 2]
        );
        let safety = [Safety::Prefix, Safety::Action][usize::from(at % 4 == 0)];
        let case = match Case::new([&text, &wishes], Scope::All, safety, ["steps", "cost"][at % 2]) {
            Err(error) if error.to_string().starts_with("no improvement is possible") => continue,
            case => case.unwrap(),
        };
        assert_eq!(case.violated(&case.dump), None, "{at} {safety} {text}");
        assert!(case.width <= 1e-6, "{at}: {}", case.width);
        assert!(case.is_true(&case.dump), "{at} {safety} {text}");
        let values = case.dump.values.iter().flatten();
        rows += values.clone().count();
        open += values.filter(|row| row.costs[0].is_none()).count();
    }
    assert!(rows > share(500) && open > share(100), "{rows} {open}");
}
