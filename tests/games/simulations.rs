//! Simulated runs of games against both opponents.

use meliora::planning::Opponent;
use meliora::planning::tally::Tally;
use proptest::prelude::*;

use super::levels::{Case, Reference, some_case};
use super::strategies::{Analysed, Strategy, each};
use crate::common::prelude::*;

const SETUP: Setup = Setup { scheduler: Scheduler::Progress, runs: 12, steps: 150, seed: 5 };

fn simulated(strategy: &mut Strategy, setup: Setup, opponent: Opponent, start: &[i64]) -> Tally {
    Simulation::new(strategy, setup).against(opponent).run(start).unwrap()
}

proptest! {
    #![proptest_config(meliora_amount::random(60))]

    /// Checks that no run weakens, and that each run that ends has made the guaranteed improvements.
    #[test]
    fn no_run_weakens(case in some_case()) {
        let reference = Reference::new(&case);
        each(&case, |analysed, safety| {
            for (&opponent, &scheduler) in
                Opponent::ALL.iter().flat_map(|by| Scheduler::ALL.iter().map(move |how| (by, how)))
            {
                for kind in [StrategyKind::Sasi, StrategyKind::Spi, StrategyKind::Plan] {
                    let mut strategy = analysed.strategy(kind, &[]);
                    for start in (0..case.raw.len()).filter(|&s| reference.safe[s]) {
                        let setup = Setup { scheduler, ..SETUP };
                        let tally = simulated(&mut strategy, setup, opponent, &[start as i64]);
                        assert_eq!(tally.weakened_reference, 0, "{kind} {opponent:?} {start}: {case:?}");
                        assert_eq!(tally.entered_unsafe, 0);
                        if safety == Safety::Action {
                            assert_eq!(tally.weakened_step, 0, "{kind} {opponent:?} {start}: {case:?}");
                        }
                        let fewer = tally.fewer_than_rank().filter(|_| kind != StrategyKind::Spi);
                        assert!(fewer.is_none_or(|fewer| fewer == tally.undecided), "{start}: {case:?}");
                        let mut from = start;
                        for turn in &tally.trace.turns {
                            assert_eq!(turn.owner.map(|owner| !owner.ours), Some(case.raw.theirs[from]));
                            from = turn.state[0] as usize;
                        }
                    }
                }
            }
        });
    }

    /// Without chance, the worst opponent needs as many steps as any path under the strategy has.
    #[test]
    fn the_worst_opponent_takes_the_longest_path(case in some_case()) {
        let case = certain(case);
        each(&case, |analysed, _| {
            for objective in 0..case.targets.len() {
                let mut strategy = analysed.strategy(StrategyKind::Achieve, &[objective]);
                for start in 0..case.raw.len() {
                    let start = vec![start as i64];
                    let model =
                        InducedModel::unfold(&mut strategy, std::slice::from_ref(&start), Scheduler::Progress, 999);
                    let longest = model.unwrap().longest_path().unwrap();
                    let of = |strategy: &mut Strategy, opponent| {
                        let tally = simulated(strategy, SETUP, opponent, &start);
                        tally.steps_of.values().sum::<u64>()
                    };
                    let [random, worst] = [Opponent::Random, Opponent::Worst].map(|by| of(&mut strategy, by));
                    assert_eq!(worst, longest as u64 * SETUP.runs, "{start:?}: {case:?}");
                    assert!(random <= worst, "{start:?}: {case:?}");
                }
            }
        });
    }
}

/// Keeps one successor of each choice.
fn certain(mut case: Case) -> Case {
    case.raw.choices.iter_mut().flatten().for_each(|successors| successors.truncate(1));
    case
}

/// A corridor in which the opponent lets us pass at once, or sends us round.
const CORRIDOR: &str = "smg
player us walker, [go] endplayer
player them [open], [send], [wait] endplayer
module walker
 x : [0..4] init 0;
 [go] x=0 -> 1/2:(x'=1) + 1/2:(x'=0);
 [go] x=2 -> (x'=3);
 [open] x=1 -> (x'=4);
 [send] x=1 -> (x'=2);
 [wait] x=3 -> 1/4:(x'=3) + 3/4:(x'=4);
endmodule
";

#[test]
fn the_worst_opponent_takes_longer_than_a_random_one() {
    let preferences = "objective Out = F x=4; objective In = F x=0; prefer Out > In; empty = gain;";
    for storage in [Storage::Explicit, Storage::Symbolic] {
        let analysed = Analysed::new(CORRIDOR, preferences, Safety::Action, storage);
        let mut strategy = analysed.strategy(StrategyKind::Achieve, &[0]);
        let setup = Setup { runs: 400, ..SETUP };
        let [random, worst] = [Opponent::Random, Opponent::Worst].map(|opponent| {
            let tally = simulated(&mut strategy, setup, opponent, &[0]);
            let moves: u64 = tally.steps_of.values().sum();
            assert_eq!(tally.achieved.unwrap().runs, 400);
            assert!(tally.steps_of.keys().eq([&0, &1]));
            (moves as f64 / 400.0, tally.steps_of[&1] as f64 / 400.0)
        });
        // Two steps of ours to leave x=0, then one step if the opponent opens, or else 1 + 1 + 4/3.
        assert!((random.0 - (2.0 + (1.0 + 10.0 / 3.0) / 2.0)).abs() < 0.5, "{random:?}");
        assert!((worst.0 - (2.0 + 10.0 / 3.0)).abs() < 0.5 && worst.1 > random.1, "{worst:?}");
        let again = simulated(&mut strategy, setup, Opponent::Worst, &[0]);
        assert_eq!(again.steps_of.values().sum::<u64>() as f64 / 400.0, worst.0);
    }
}

#[test]
fn a_run_ends_where_nothing_is_left_even_if_the_opponent_could_move() {
    let preferences = "objective Out = F x=4; objective In = F x=0; prefer Out > In; empty = gain;";
    let analysed = Analysed::new(CORRIDOR, preferences, Safety::Action, Storage::Explicit);
    let mut strategy = analysed.strategy(StrategyKind::Sasi, &[]);
    let start = strategy.start(&[1]).unwrap();
    assert_eq!((start.level, strategy.levels()), (Rank::Finite(0), Kind::Sasi));
    let tally = simulated(&mut strategy, SETUP, Opponent::Random, &[1]);
    assert!(tally.trace.turns.is_empty() && tally.settled == SETUP.runs, "{tally:?}");
}
