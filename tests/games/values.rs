//! Probabilities, costs and numbers of improvements against an opponent: over all pairs of pure strategies of small games,
//! and in games with known values.

use meliora::planning::Opponent;
use meliora::quantities::{Bounds, Chooser, Interval};
use num_traits::{FromPrimitive, ToPrimitive};
use proptest::prelude::*;

use super::levels::{Case, Reference, some_case};
use super::strategies::Analysed;
use crate::common::prelude::*;

pub(crate) const LEVELS: usize = 2;

/// A value; `None` if it is infinite.
pub(crate) type Number = Option<Ratio>;

/// A choice: its gain and its edges.
pub(crate) type Action = (Ratio, Vec<(usize, Ratio)>);

/// Returns the least solution of x = gain + Σ p · x for one action per state.
fn of_chain(rows: &[&Action]) -> Vec<Number> {
    let n = rows.len();
    let reaching = |from: &dyn Fn(usize) -> bool| {
        let mut found: Vec<bool> = (0..n).map(from).collect();
        while let Some(more) = (0..n).find(|&s| !found[s] && rows[s].1.iter().any(|(to, _)| found[*to])) {
            found[more] = true;
        }
        found
    };
    let gaining = reaching(&|s| !rows[s].0.is_zero());
    let mass = |s: usize| rows[s].1.iter().map(|(_, p)| p.clone()).sum::<Ratio>();
    let ending = reaching(&|s| !gaining[s] || mass(s) < Ratio::one());
    let infinite = reaching(&|s| !ending[s]);
    let open: Vec<usize> = (0..n).filter(|&s| gaining[s] && !infinite[s]).collect();
    let mut a: Vec<Vec<Ratio>> = open
        .iter()
        .map(|&s| {
            let p = |to: usize| rows[s].1.iter().filter(|e| e.0 == to).map(|e| e.1.clone()).sum::<Ratio>();
            let own = |&to: &usize| if to == s { Ratio::one() - p(to) } else { -p(to) };
            open.iter().map(own).chain([rows[s].0.clone()]).collect()
        })
        .collect();
    for i in 0..open.len() {
        let pivot = (i..open.len()).find(|&r| !a[r][i].is_zero()).unwrap();
        a.swap(i, pivot);
        let row: Vec<Ratio> = a[i].iter().map(|x| x / &a[i][i]).collect();
        a[i] = row.clone();
        for (_, other) in a.iter_mut().enumerate().filter(|(r, _)| *r != i) {
            let factor = other[i].clone();
            other.iter_mut().zip(&row).for_each(|(x, y)| *x -= &factor * y);
        }
    }
    let value = |s: usize| match open.iter().position(|&o| o == s) {
        Some(at) => Some(a[at][open.len()].clone()),
        None => (!infinite[s]).then(Ratio::zero),
    };
    (0..n).map(value).collect()
}

/// Returns all ways to take an action in each state of one side; 0 in those of the other.
fn strategies(actions: &[Vec<Action>], is_open: impl Fn(usize) -> bool) -> Vec<Vec<usize>> {
    let mut all = vec![vec![]];
    for (s, own) in actions.iter().enumerate() {
        let count = if is_open(s) { own.len() } else { 1 };
        let longer = |pure: Vec<usize>| (0..count).map(move |at| [&pure[..], &[at]].concat());
        all = all.into_iter().flat_map(longer).collect();
    }
    all
}

/// Returns the greatest values that we guarantee, or the least ones.
pub(crate) fn against(actions: &[Vec<Action>], theirs: &[bool], greatest: bool) -> Vec<Number> {
    let above = |a: &Number, b: &Number| match (a, b) {
        (Some(a), Some(b)) => a > b,
        (None, Some(_)) => true,
        _ => false,
    };
    let better = |a: &Number, b: &Number| if greatest { above(a, b) } else { above(b, a) };
    let mut best: Option<Vec<Number>> = None;
    for mine in strategies(actions, |s| !theirs[s]) {
        let mut worst: Option<Vec<Number>> = None;
        for yours in strategies(actions, |s| theirs[s]) {
            let rows: Vec<&Action> = (0..actions.len()).map(|s| &actions[s][mine[s] + yours[s]]).collect();
            let found = of_chain(&rows);
            worst = Some(match worst {
                None => found,
                Some(old) => {
                    old.into_iter().zip(found).map(|(a, b)| if better(&a, &b) { b } else { a }).collect()
                }
            });
        }
        let worst = worst.unwrap();
        best = Some(match best {
            None => worst,
            Some(old) => {
                old.into_iter().zip(worst).map(|(a, b)| if better(&b, &a) { b } else { a }).collect()
            }
        });
    }
    best.unwrap()
}

/// Returns the kept choices as actions: an improving step to `t` gains `gain(t)`, in place of the value of `t` unless
/// that continues; `none` is the action of a state without a choice.
fn actions(
    reference: &Reference<'_>,
    cost: Ratio,
    gain: impl Fn(usize) -> Option<Ratio>,
    goes_on: bool,
    none: impl Fn(usize) -> Action,
) -> Vec<Vec<Action>> {
    let of = |s: usize, a: usize| {
        let to = reference.successors(s, a);
        let p = Ratio::new(1.into(), to.len().into());
        let mut action = (cost.clone(), Vec::new());
        for &t in to {
            let gain = gain(t).filter(|_| reference.improves(&reference.mp[s], &reference.mp[t]));
            if let Some(gain) = &gain {
                action.0 += gain * &p;
            }
            if gain.is_none() || goes_on {
                action.1.push((t, p.clone()));
            }
        }
        action
    };
    let kept = reference.kept();
    let of_state = |s: usize| match kept[s].is_empty() {
        true => vec![none(s)],
        false => kept[s].iter().map(|&a| of(s, a)).collect(),
    };
    (0..kept.len()).map(of_state).collect()
}

fn fits(found: &Bounds, expected: &Ratio, is_exact: bool) -> bool {
    let [lower, upper] = [found.interval.lower, found.interval.upper].map(|x| Ratio::from_f64(x).unwrap());
    let is_narrow = found.interval.width() <= 1e-6 * found.interval.lower.max(1.0);
    lower <= *expected
        && *expected <= upper
        && is_narrow
        && (!is_exact || found.exact.as_ref() == Some(expected))
}

/// Returns P_k and C_k of all states for k = 1, 2, …, over all pairs of pure strategies; `None` where a cost is infinite.
pub(crate) fn levels(reference: &Reference<'_>) -> Vec<[Vec<Number>; 2]> {
    let (zero, one, raw) = (Ratio::zero, Ratio::one, &reference.case.raw);
    let (nothing, stay) = (|_| (zero(), vec![]), |s: usize| (one(), vec![(s, one())]));
    let (mut p, mut c) = (vec![Some(one()); raw.len()], vec![Some(zero()); raw.len()]);
    let mut levels = Vec::new();
    for _ in 1..=LEVELS {
        p = against(&actions(reference, zero(), |t| p[t].clone(), false, nothing), &raw.theirs, true);
        c = against(&actions(reference, one(), |t| c[t].clone(), false, stay), &raw.theirs, false);
        levels.push([p.clone(), c.clone()]);
    }
    levels
}

fn check(case: &Case, exact: bool) {
    let reference = Reference::new(case);
    let analysed = Analysed::new(&case.raw.text(), &case.preferences(), Safety::Action, Storage::Explicit);
    let (zero, one) = (Ratio::zero, Ratio::one);
    let safe: Vec<usize> = (0..case.raw.len()).filter(|&s| reference.safe[s]).collect();
    let starts: Vec<Vec<i64>> = safe.iter().map(|&s| vec![s as i64]).collect();
    let options = ValueOptions { levels: LEVELS, exact, within: None };
    let values = Values::compute(options, &analysed.analysis, &analysed.program, &starts, &Steps).unwrap();
    let node = |s: usize| values.start(&[s as i64]).unwrap();
    let nothing = |_| (zero(), vec![]);
    let numbers =
        against(&actions(&reference, zero(), |_| Some(one()), true, nothing), &case.raw.theirs, true);
    for &s in &safe {
        let found = values.number(node(s));
        let is_right = match &numbers[s] {
            Some(number) => fits(&found, number, exact),
            None => found.interval.lower.is_infinite(),
        };
        assert!(is_right, "N of {s}: {found:?}, {:?}, {case:?}", numbers[s]);
    }
    for (k, [p, c]) in (1..).zip(levels(&reference)) {
        for &s in &safe {
            let (found, expected) = (values.probability(node(s), k), p[s].as_ref().unwrap());
            assert!(fits(&found, expected, exact), "P_{k} of {s}: {found:?}, {expected}, {case:?}");
            match (values.cost(node(s), k), &c[s]) {
                (None, None) => {}
                (Some(found), Some(expected)) if fits(&found, expected, exact) => {}
                other => panic!("C_{k} of {s}: {other:?}, {case:?}"),
            }
        }
    }
}

proptest! {
    #![proptest_config(meliora_amount::random(150))]

    #[test]
    fn values_are_those_over_all_pairs_of_strategies(case in some_case()) {
        check(&case, true);
        check(&case, false);
    }
}

fn computed(game: &Analysed, levels: usize, start: &[i64]) -> Values {
    let options = ValueOptions { levels, exact: true, within: Some(3) };
    Values::compute(options, &game.analysis, &game.program, &[start.to_vec()], &Steps).unwrap()
}

fn analysed(text: &str, preferences: &str) -> Analysed {
    Analysed::new(text, preferences, Safety::Action, Storage::Explicit)
}

/// With `half`, two improvements or none; with `one`, one for certain.
#[test]
fn an_opponent_cannot_be_bad_for_all_numbers_of_improvements_at_once() {
    let game = "smg player us [go] endplayer player them [half], [one], [c], [d] endplayer
        module m x : [0..5] init 0;
         [half] x=0 -> 1/2:(x'=1) + 1/2:(x'=4);
         [one] x=0 -> (x'=3);
         [c] x=1 -> (x'=2);
         [d] x=1 -> (x'=5);
         [go] x>1 -> true;
        endmodule";
    let wishes = "objective A = F (x>=0); objective B = F (x=1 | x=3); objective C = F (x=2);\
        objective D = F (x=5); prefer C > B; prefer D > B; prefer B > A;";
    let values = computed(&analysed(game, wishes), 2, &[0]);
    let start = values.start(&[0]).unwrap();
    let exact = |bounds: Bounds| bounds.exact.unwrap().to_f64().unwrap();
    let p = [1, 2].map(|k| exact(values.probability(start, k)));
    assert_eq!((p, exact(values.number(start))), ([0.5, 0.0], 1.0));
    assert_eq!(values.within(start, 1).unwrap(), [0.0, 0.5, 0.5, 0.5]);
    let order: Vec<usize> = values.choices(start, 1, Aim::Likely).iter().map(|c| c.position).collect();
    assert_eq!(order, [0, 1], "the opponent's choices, the worst for us first");
}

/// From x=0, the opponent picks one of two rooms, and there one of two prizes; we may take it, or come back.
#[test]
fn improvements_that_no_opponent_can_end_are_infinitely_many() {
    let game = "smg player us [y], [x], [back] endplayer player them [l], [r] endplayer
        module m x : [0..12] init 0;
         [l] x=0 -> (x'=1); [r] x=0 -> (x'=2);
         [l] x=1 -> (x'=3); [r] x=1 -> (x'=4);
         [l] x=2 -> (x'=5); [r] x=2 -> (x'=6);
         [y] x>2 & x<7 -> (x'=x+6);
         [x] x>2 & x<7 -> (x'=x<5 ? 7 : 8);
         [back] x>2 & x<7 -> (x'=0);
         [back] x>6 -> true;
        endmodule";
    let wishes = "objective X = F x=7; objective Y = F x=8; objective A = F x=9; objective B = F x=10;\
        objective C = F x=11; objective D = F x=12; prefer A, B > X; prefer C, D > Y; empty = gain;";
    let game = analysed(game, wishes);
    assert_eq!(game.analysis.rank(Kind::Sasi, &[0]).unwrap(), Rank::Unbounded);
    for exact in [true, false] {
        let options = ValueOptions { levels: 3, exact, within: None };
        let values = Values::compute(options, &game.analysis, &game.program, &[vec![0]], &Steps).unwrap();
        let start = values.start(&[0]).unwrap();
        assert_eq!(values.number(start).interval, Interval { lower: f64::INFINITY, upper: f64::INFINITY });
        let costs = [1, 2, 3].map(|k| values.cost(start, k).unwrap().interval);
        assert_eq!(costs, [1.0, 2.0, 4.0].map(|x| Interval { lower: x, upper: x }));
    }
}

/// Our choice `a` has the value 1/4, since the opponent answers with `c`; `b` has 1/5.
#[test]
fn a_strategy_by_value_attains_the_value_against_the_worst_opponent() {
    let game = "smg player us [a], [b] endplayer player them [c], [d] endplayer
        module m x : [0..3] init 0;
         [a] x=0 -> 1/2:(x'=1) + 1/2:(x'=2);
         [b] x=0 -> 1/5:(x'=3) + 4/5:(x'=2);
         [c] x=1 -> 1/2:(x'=3) + 1/2:(x'=2);
         [d] x=1 -> (x'=3);
         [a] x>1 -> true;
        endmodule";
    let game = analysed(game, "objective A = F (x>=0); objective G = F x=3; prefer G > A;");
    let (start, runs) = (vec![0], 4000);
    let rule = Chooser::compute(
        &game.analysis,
        &game.program,
        std::slice::from_ref(&start),
        (Aim::Likely, None),
        &Steps,
    );
    let mut strategy = game.strategy(StrategyKind::Spi, &[]);
    strategy.choose_by(Arc::new(rule.unwrap()));
    let setup = Setup { scheduler: Scheduler::Progress, runs, steps: 10, seed: 3 };
    for (opponent, value) in [(Opponent::Worst, 0.25), (Opponent::Random, 0.375)] {
        let tally = Simulation::new(&mut strategy, setup).against(opponent).run(&start).unwrap();
        let reached = tally.improvements.get(&1).copied().unwrap_or_default() as f64 / runs as f64;
        assert!((reached - value).abs() < 0.02, "{opponent:?}: {reached}");
    }
}
