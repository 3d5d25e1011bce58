//! Rewards that are lost where the target is not reached, against runs of a limited length.

use std::collections::HashMap;
use std::sync::Arc;

use bitvec::vec::BitVec;
use meliora_amount::share;
use meliora_base::error::Error;
use meliora_base::random::Draw;
use meliora_engine::{AnyEngine, Settings, Storage};
use meliora_model::Optimum;

use super::arenas::{Made, load};
use crate::graphs::arena::Arena;
use crate::graphs::game_graph::Extremes;
use crate::values::value::Value;
use crate::values::vector::{Accumulation, Asked};

/// The lengths of runs: values of longer ones are greater.
const STEPS: [usize; 2] = [40, 80];

/// The value of runs of a limited length, from the definition. Its limit is the value of all runs.
struct Runs<'a> {
    made: &'a Made,
    target: &'a [bool],
    goal: Extremes,
    known: HashMap<(usize, usize, i64), f64>,
}

impl Runs<'_> {
    fn value(&mut self, steps: usize, state: usize, so_far: i64) -> f64 {
        if self.target[state] {
            return so_far as f64;
        }
        if steps == 0 {
            return 0.0;
        }
        if let Some(&known) = self.known.get(&(steps, state, so_far)) {
            return known;
        }
        let made = self.made;
        let values = made.choices[state].iter().map(|(gain, edges)| {
            let sum: i64 = edges.iter().map(|edge| edge.1).sum();
            let then = so_far + made.of_state[state] + gain;
            let part =
                |&(to, weight): &(usize, i64)| self.value(steps - 1, to, then) * weight as f64 / sum as f64;
            edges.iter().map(part).sum::<f64>()
        });
        let values: Vec<f64> = values.collect();
        let optimum = if made.theirs[state] { self.goal.theirs } else { self.goal.ours };
        let best = match optimum {
            Optimum::Max => values.into_iter().fold(0.0, f64::max),
            Optimum::Min => values.into_iter().fold(f64::INFINITY, f64::min),
        };
        self.known.insert((steps, state, so_far), best);
        best
    }
}

/// The states that were compared: those whose value is near that of short runs, those with a greater one, and those
/// without bound whose runs gain with their length; and the games that are refused.
#[derive(Debug, Default)]
struct Seen {
    near: usize,
    far: usize,
    growing: usize,
    refused: usize,
}

impl Seen {
    fn compare(&mut self, made: &Made, kind: &str, target: &[bool], optimum: Optimum) {
        let program = load(&made.text(kind));
        let settings = Settings { storage: Storage::Explicit, ..Settings::default() };
        let engine = AnyEngine::new(Arc::new(program.clone()), settings).unwrap();
        let arena = Arena::new(&engine, &program).unwrap();
        let goal = if kind == "smg" { Extremes::against(optimum) } else { Extremes::all(optimum) };
        let bits: BitVec = target.iter().collect();
        let rewards = arena.rewards(&engine, 0).unwrap();
        let ask = |precision| {
            Asked::all(&arena, goal, precision).reward(&rewards, &Accumulation::IfReached(bits.clone()))
        };
        let (near, exact) = match (ask(1e-6), ask(0.0)) {
            (Ok(near), Ok(exact)) => (near.values, exact.values),
            (Err(Error::Usage(_)), Err(Error::Usage(_))) => {
                self.refused += 1;
                return;
            }
            wrong => panic!("{wrong:?}"),
        };
        let mut runs = Runs { made, target, goal, known: HashMap::new() };
        for state in 0..made.states() {
            let [short, long] = STEPS.map(|steps| runs.value(steps, state, 0));
            match (&near[state], &exact[state]) {
                (Value::Infinite, Value::Infinite) => self.growing += usize::from(long > short),
                (Value::Finite(near), Value::Finite(exact)) => {
                    let (low, high) = (near.interval.lower, near.interval.upper);
                    let value = exact.interval.lower;
                    assert!(low <= value * (1.0 + 1e-12) && value <= high * (1.0 + 1e-12), "{made:?}");
                    assert!(long <= value * (1.0 + 1e-9), "{long} {value} {state} {target:?} {made:?}");
                    let is_near = value - long <= 1e-6 * value.max(1.0);
                    *if is_near { &mut self.near } else { &mut self.far } += 1;
                }
                wrong => panic!("{wrong:?} {made:?}"),
            }
        }
    }
}

#[test]
fn lost_rewards_are_the_limit_of_those_of_longer_runs() {
    let mut seen = Seen::default();
    for seed in 0..share(320) as u64 {
        let mut draw = Draw::numbered(7, seed);
        let kind = ["smg", "mdp", "smg", "dtmc"][seed as usize % 4];
        let made = Made::draw(&mut draw, kind);
        let target: Vec<bool> = (0..made.states()).map(|_| draw.below(3) == 0).collect();
        for optimum in [Optimum::Max, Optimum::Min] {
            seen.compare(&made, kind, &target, optimum);
        }
    }
    assert!(seen.near > share(1800) && seen.far < share(40) && seen.growing > share(80), "{seen:?}");
}
