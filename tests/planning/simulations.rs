//! Simulated runs: their counts, the frequencies of successors, and the run that a report shows.

use meliora::planning::tally::{RunEnd, Trace, Wait};

use crate::common::prelude::*;
use crate::planning::loaded::{Loaded, ladder};

/// The value of `x` in the last state of a run.
fn last(trace: &Trace) -> i64 {
    trace.turns.last().unwrap().state[0]
}

#[test]
fn a_tally_adds_up_its_runs() {
    let model = ladder();
    // Only one level of two is computed, so runs go on after the improvement that is guaranteed.
    let analysis = model.analyse(Safety::Action, Some(1));
    let mut strategy = FiniteMemoryStrategy::new(&analysis, &model.program, Kind::Sasi).unwrap();
    let setup = Setup { scheduler: Scheduler::Progress, runs: 200, steps: 3, seed: 1 };
    let mut traces = Vec::new();
    let mut simulation = Simulation::new(&mut strategy, setup);
    let tally = simulation.run_each(&[0], &mut |trace| traces.push(trace.clone())).unwrap();
    assert_eq!((tally.rank, tally.runs, traces.len()), (Rank::AtLeast(1), 200, 200));

    let counted = |test: fn(i64) -> bool| traces.iter().filter(|t| test(last(t))).count() as u64;
    let expected = BTreeMap::from([
        (0, counted(|x| x == 0)),
        (1, counted(|x| x == 1 || x == 2)),
        (2, counted(|x| x > 2)),
    ]);
    assert_eq!(tally.improvements, expected);
    assert_eq!(
        [0, 1, 2, 3].map(|times| tally.fewer_than(times)),
        [0, expected[&0], expected[&0] + expected[&1], 200]
    );
    assert_eq!((tally.settled, tally.given_up), (expected[&2], expected[&0] + expected[&1]));
    assert_eq!(tally.undecided, expected[&0]);
    assert!(expected[&0] > 0 && expected[&1] > expected[&0], "{expected:?}");

    // The first improvement leaves 0, the second one gets beyond 2.
    let wait = |beyond: i64| {
        let step = |trace: &Trace| trace.turns.iter().position(|turn| turn.state[0] > beyond);
        let steps: Vec<u64> = traces.iter().filter_map(step).map(|at| at as u64 + 1).collect();
        let (least, most) = (*steps.iter().min().unwrap(), *steps.iter().max().unwrap());
        Wait { runs: steps.len() as u64, least, most, total: steps.iter().sum() }
    };
    assert_eq!(tally.waits, [wait(0), wait(2)]);
}

#[test]
fn successors_come_as_often_as_their_probabilities_say() {
    let model = Loaded::new(
        "mdp module m x : [0..3] init 0; [] x=0 -> 0.2:(x'=1) + 0.3:(x'=2) + 0.5:(x'=3); endmodule",
        "objective A = F x=1; objective B = F x=2; objective C = F x=3;",
    );
    let analysis = model.analyse(Safety::Action, None);
    let mut strategy = FiniteMemoryStrategy::new(&analysis, &model.program, Kind::Sasi).unwrap();
    let setup = Setup { scheduler: Scheduler::Permissive, runs: 2000, steps: 5, seed: 1 };
    let mut ends = [0i64; 4];
    let mut each = |trace: &Trace| ends[last(trace) as usize] += 1;
    Simulation::new(&mut strategy, setup).run_each(&[0], &mut each).unwrap();
    for (found, expected) in ends.into_iter().zip([0, 400, 600, 1000]) {
        // More than four standard deviations.
        assert!((found - expected).abs() < 100, "{ends:?}");
    }
}

/// The run that is shown: the best one among the first n, for the least n where the best one has
/// the wanted number of improvements and weakens nothing. At an unbounded rank (none) it must
/// have been cut off instead.
fn shown(traces: &[Trace], wanted: Option<usize>, settled: fn(i64) -> bool) -> (Trace, RunEnd) {
    let weakens = |t: &Trace| t.turns.iter().any(|turn| turn.weakens_step || turn.weakens_start);
    let end = |t: &Trace| match wanted {
        Some(k) if t.improvements() >= k => RunEnd::Kept,
        _ if settled(last(t)) => RunEnd::Failed,
        _ => RunEnd::CutOff,
    };
    let fine = if wanted.is_some() { RunEnd::Kept } else { RunEnd::CutOff };
    let counted = |t: &Trace| t.improvements().min(wanted.unwrap_or(usize::MAX));
    let best = |n: usize| traces[..n].iter().rev().max_by_key(|t| (counted(t), !weakens(t))).unwrap();
    let mut each = (1..=traces.len()).map(best);
    let chosen = each.find(|t| !weakens(t) && end(t) == fine).unwrap_or_else(|| best(traces.len()));
    (chosen.clone(), end(chosen))
}

/// Compares the run that is shown with its definition, for few and many runs and for many seeds.
/// Exactly `ends` must occur.
fn check_shown(
    model: &Loaded,
    (kind, safety): (Kind, Safety),
    rank: Rank,
    settled: fn(i64) -> bool,
    ends: &[RunEnd],
) {
    let analysis = model.analyse(safety, None);
    let mut strategy = FiniteMemoryStrategy::new(&analysis, &model.program, kind).unwrap();
    assert_eq!(strategy.rank(&[0]).unwrap(), rank);
    let wanted = match rank {
        Rank::Finite(k) => Some(k),
        _ => None,
    };
    let mut met = BTreeSet::new();
    for seed in 0..40 {
        for runs in [1, 2, 5] {
            let setup = Setup { scheduler: Scheduler::Permissive, runs, steps: 3, seed };
            let mut traces = Vec::new();
            let mut simulation = Simulation::new(&mut strategy, setup);
            simulation.run_each(&[0], &mut |trace| traces.push(trace.clone())).unwrap();
            let found = simulation.telling(&[0]).unwrap();
            assert_eq!(found, shown(&traces, wanted, settled), "seed {seed}, {runs} runs");
            met.insert(format!("{:?}", found.1));
        }
    }
    assert_eq!(met, ends.iter().map(|end| format!("{end:?}")).collect());
}

#[test]
fn the_run_shown_has_no_step_that_weakens() {
    // Steps to 4 weaken; `transition` drops them, but the simulation takes them.
    let model = Loaded::new(
        "mdp module m x : [0..5] init 0;\n\
         [] x=0 -> 0.3:(x'=1) + 0.3:(x'=2) + 0.4: true;\n\
         [] x=1 | x=2 -> 0.2:(x'=3) + 0.2:(x'=5) + 0.3:(x'=4) + 0.3: true; endmodule",
        "objective A = F x=1; objective B = F x=2; objective C = F x=3; objective D = F x=5;\n\
         prefer C > A; prefer C > B; prefer D > A; prefer D > B;",
    );
    let ends = [RunEnd::Kept, RunEnd::CutOff, RunEnd::Failed];
    check_shown(&model, (Kind::Sasi, Safety::Transition), Rank::Finite(2), |x| x > 2, &ends);
}

#[test]
fn the_run_shown_does_not_weaken_its_start() {
    // A step to 3 is an improvement by Y, but S at the start is preferred to V.
    let model = Loaded::new(
        "mdp module m x : [0..4] init 0;\n\
         [] x=0 -> 0.4:(x'=1) + 0.4:(x'=2) + 0.2: true;\n\
         [] x=1 | x=2 -> 0.4:(x'=3) + 0.2:(x'=4) + 0.4: true; endmodule",
        "objective S = F x=0; objective T = F x=1; objective U = F x=2;\n\
         objective V = F x=3; objective Y = F x=3; objective W = F x=4;\n\
         prefer Y > T; prefer Y > U; prefer W > T; prefer W > U; prefer S > V;",
    );
    let ends = [RunEnd::Kept, RunEnd::CutOff];
    check_shown(&model, (Kind::Sasi, Safety::Action), Rank::Finite(1), |x| x > 2, &ends);
}

#[test]
fn the_run_shown_at_an_unbounded_rank_goes_on() {
    // Each of three states improves on the one before it, around a circle; 3 is a sink.
    let model = Loaded::new(
        "mdp module m x : [0..3] init 0;\n\
         [wait] x<3 -> true; [try] x<3 -> 0.7:(x'=mod(x+1,3)) + 0.3:(x'=3); endmodule",
        "objective o0 = F x=0; objective o1 = F x=1; objective o2 = F x=1; objective o3 = F x=2;\n\
         objective o4 = F x=2; objective o5 = F x=0; objective o6 = F x=3;\n\
         prefer o1 > o0; prefer o3 > o2; prefer o5 > o4;",
    );
    let ends = [RunEnd::CutOff, RunEnd::Failed];
    check_shown(&model, (Kind::Spi, Safety::Action), Rank::Unbounded, |x| x == 3, &ends);
}
