//! Among the choices that attain the greatest probability, those with the least expected number of steps
//! are taken: against all memoryless strategies of tiny models.

use meliora::quantities::{Achiever, Chooser, ValuedRule};

use crate::common::prelude::*;
use crate::planning::loaded::Loaded;

const STATES: usize = 6;
/// The state of the objective, and one from which it is impossible.
const GOAL: usize = STATES - 1;
const FAILED: usize = STATES - 2;
const NEAR: f64 = 1e-7;

/// The choices of each state: successors with their probabilities.
type World = Vec<Vec<Vec<(usize, f64)>>>;

fn world(random: &mut SmallRng) -> World {
    let mut world: World = Vec::new();
    for state in 0..STATES {
        let count = if state < FAILED { random.random_range(1..4) } else { 1 };
        let choice = |random: &mut SmallRng| {
            if state >= FAILED {
                return vec![(state, 1.0)];
            }
            let to = |random: &mut SmallRng| random.random_range(0..STATES);
            // Steps without chance make many choices equally good.
            match random.random_range(0..3) {
                0 => vec![(to(random), 0.25), (to(random), 0.75)],
                _ => vec![(random.random_range(0..FAILED), 1.0)],
            }
        };
        let mut choices: Vec<_> = (0..count).map(|_| choice(random)).collect();
        if state < 2 {
            choices.push(vec![(GOAL, 0.5), (FAILED, 0.5)]);
        }
        world.push(choices);
    }
    world
}

fn text(world: &World) -> String {
    let mut text = format!("mdp module m s : [0..{}];\n", STATES - 1);
    for (state, choices) in world.iter().enumerate() {
        for (number, choice) in choices.iter().enumerate() {
            let branches: Vec<String> = choice.iter().map(|(to, p)| format!("{p}:(s'={to})")).collect();
            text += &format!("[a{number}] s={state} -> {};\n", branches.join(" + "));
        }
    }
    text + "endmodule init true endinit"
}

/// Returns the probability to reach the goal states from each state by some choices, and the expected number
/// of steps until one of `ends`.
fn evaluated(world: &World, picks: &[usize], goal: &[bool], ends: &[bool]) -> Vec<(f64, f64)> {
    let reaching = |wanted: &dyn Fn(usize) -> bool| {
        let mut found: Vec<bool> = (0..STATES).map(wanted).collect();
        for _ in 0..STATES {
            for s in (0..STATES).filter(|&s| !ends[s]) {
                found[s] = found[s] || world[s][picks[s]].iter().any(|&(to, _)| found[to]);
            }
        }
        found
    };
    let ending = reaching(&|s| ends[s]);
    let stuck = reaching(&|s| !ending[s]);
    let solve = |constant: &dyn Fn(usize) -> f64, known: &dyn Fn(usize) -> Option<f64>| {
        let mut rows = vec![vec![0.0; STATES + 1]; STATES];
        for (s, row) in rows.iter_mut().enumerate() {
            row[s] = 1.0;
            row[STATES] = known(s).unwrap_or_else(|| constant(s));
            if known(s).is_none() {
                world[s][picks[s]].iter().for_each(|&(to, p)| row[to] -= p);
            }
        }
        eliminated(rows)
    };
    let chance = solve(&|_| 0.0, &|s| (ends[s] || !ending[s]).then(|| f64::from(u8::from(goal[s]))));
    let steps = solve(&|_| 1.0, &|s| (ends[s] || stuck[s]).then_some(0.0));
    let steps = steps.into_iter().zip(&stuck).map(|(n, stuck)| if *stuck { f64::INFINITY } else { n });
    chance.into_iter().zip(steps).collect()
}

/// Solves linear equations; the last column is the constant.
fn eliminated(mut rows: Vec<Vec<f64>>) -> Vec<f64> {
    for at in 0..STATES {
        let pivot = (at..STATES).max_by(|&a, &b| rows[a][at].abs().total_cmp(&rows[b][at].abs())).unwrap();
        rows.swap(at, pivot);
        let own: Vec<f64> = rows[at].iter().map(|x| x / rows[at][at]).collect();
        for (other, row) in rows.iter_mut().enumerate() {
            let factor = if other == at { 0.0 } else { row[at] };
            row.iter_mut().zip(&own).for_each(|(x, own)| *x -= factor * own);
        }
        rows[at] = own;
    }
    rows.iter().map(|row| row[STATES]).collect()
}

/// Returns all memoryless strategies.
fn strategies(world: &World) -> Vec<Vec<usize>> {
    world.iter().fold(vec![Vec::new()], |all, choices| {
        let longer = |picks: &Vec<usize>| {
            let picks = picks.clone();
            (0..choices.len()).map(move |pick| [&picks[..], &[pick]].concat())
        };
        all.iter().flat_map(longer).collect()
    })
}

/// The greatest probabilities, and the fewest steps of the strategies that attain them; and the states where
/// the goal is sure, and those where it is sure or impossible.
fn best(world: &World) -> (Vec<(f64, f64)>, [Vec<bool>; 2]) {
    let all = strategies(world);
    let goal: Vec<bool> = (0..STATES).map(|s| s == GOAL).collect();
    let of = |goal: &[bool], ends: &[bool]| -> Vec<Vec<(f64, f64)>> {
        all.iter().map(|picks| evaluated(world, picks, goal, ends)).collect()
    };
    let greatest = |found: &[Vec<(f64, f64)>], s: usize| found.iter().map(|own| own[s].0).fold(0.0, f64::max);
    let reached = of(&goal, &goal);
    let sure: Vec<bool> = (0..STATES).map(|s| greatest(&reached, s) > 1.0 - NEAR).collect();
    let ends: Vec<bool> = (0..STATES).map(|s| sure[s] || greatest(&reached, s) < NEAR).collect();
    let found = of(&sure, &ends);
    let fewest = |s: usize| {
        let most = greatest(&found, s);
        let attaining = found.iter().filter(|own| own[s].0 > most - NEAR);
        (most, attaining.map(|own| own[s].1).fold(f64::INFINITY, f64::min))
    };
    ((0..STATES).map(fewest).collect(), [sure, ends])
}

/// Checks the choices of a strategy by value: they attain the probability, in the fewest steps.
fn check<E: Engine>(
    strategy: &mut FiniteMemoryStrategy<E>,
    rule: &dyn ValuedRule,
    world: &World,
    label: &str,
) -> usize {
    let (best, [sure, ends]) = best(world);
    let mut picks = vec![0; STATES];
    for s in (0..STATES).filter(|&s| !ends[s]) {
        let state = [s as i64];
        let memory = strategy.start(&state).unwrap();
        picks[s] = strategy.explain(&state, memory).unwrap().pick.unwrap();
    }
    let own = evaluated(world, &picks, &sure, &ends);
    let mut between = 0;
    for s in (0..STATES).filter(|&s| !ends[s]) {
        let (chance, steps) = best[s];
        let what = format!("{label}, s={s}: {:?}, expected {:?}\n{}", own[s], best[s], text(world));
        assert!((own[s].0 - chance).abs() < NEAR && own[s].1 < steps + NEAR, "{what}");
        let bounds = rule.attained(&[s as i64]).unwrap().probability.interval;
        assert!(bounds.lower <= own[s].0 + 1e-12 && own[s].0 <= bounds.upper + 1e-12, "{what}, {bounds:?}");
        assert!(bounds.width() <= 1e-6, "{what}, {bounds:?}");
        between += 1;
    }
    between
}

#[test]
fn of_the_choices_that_attain_the_probability_those_with_the_fewest_steps_are_taken() {
    let mut between = 0;
    for seed in 0..200 {
        let world = world(&mut SmallRng::seed_from_u64(seed));
        let loaded = Loaded::new(&text(&world), "objective A = F s=5;");
        let states: Vec<_> = (0..STATES as i64).map(|s| vec![s]).collect();
        for safety in [Safety::Action, Safety::Prefix, Safety::Transition] {
            let analysis = loaded.analyse(safety, None);
            let rule =
                Chooser::compute(&analysis, &loaded.program, &states, (Aim::Likely, None), &Steps).unwrap();
            let rule = Arc::new(rule);
            let kind = meliora::planning::Kind::Spi;
            let mut strategy = FiniteMemoryStrategy::new(&analysis, &loaded.program, kind).unwrap();
            strategy.choose_by(Arc::clone(&rule) as _);
            between += check(&mut strategy, &*rule, &world, &format!("seed {seed}, {safety}"));
        }
        let analysis = loaded.analyse(Safety::Action, None);
        let kind = StrategyKind::Achieve;
        let Ok(Some(mut strategy)) =
            FiniteMemoryStrategy::of_kind(&analysis, &loaded.program, kind, kind.levels(), Some(0))
        else {
            panic!("no strategy");
        };
        let objectives = strategy.objectives().clone();
        let rule = Arc::new(Achiever::compute(&analysis, &loaded.program, &states, &objectives).unwrap());
        strategy.choose_by(Arc::clone(&rule) as _);
        between += check(&mut strategy, &*rule, &world, &format!("achieve, seed {seed}"));
    }
    assert!(between > 300, "{between}");
}
