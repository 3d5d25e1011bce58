//! Several objectives against all pure strategies that remember the visited sets.

use std::sync::Arc;

use bitvec::vec::BitVec;
use meliora_base::exact::Ratio;
use meliora_base::random::Draw;
use meliora_engine::{AnyEngine, Settings, Storage};
use meliora_model::Optimum;
use num_traits::{Signed, ToPrimitive};

use super::arenas::{Choice, Made, load};
use crate::equations::arena::Arena;
use crate::several::{Counted, Objective, Several, several};
use crate::solvers::hull::separated;

/// Returns the game whose states remember which of two sets were visited: state s with the sets m is 4 s + m.
fn remembering(made: &Made, sets: &[Vec<bool>; 2]) -> Made {
    let own = |s: usize| usize::from(sets[0][s]) + 2 * usize::from(sets[1][s]);
    let choices = |pair: usize| {
        let moved = |(gain, edges): &Choice| {
            (*gain, edges.iter().map(|&(to, p)| (4 * to + ((pair % 4) | own(to)), p)).collect())
        };
        made.choices[pair / 4].iter().map(moved).collect()
    };
    let pairs = 0..4 * made.states();
    Made {
        choices: pairs.clone().map(choices).collect(),
        theirs: pairs.clone().map(|_| false).collect(),
        of_state: pairs.map(|pair| made.of_state[pair / 4]).collect(),
    }
}

/// The second objective: to visit the second set, infinitely often, or before the first one.
#[derive(Debug, Clone, Copy)]
enum Second {
    Visit,
    Recur,
    Before,
}

/// Returns the points of all pure strategies; `None` if some reward is infinite, or if there are fewer
/// than 4 or more than 100.
fn points(
    made: &Made,
    sets: &[Vec<bool>; 2],
    second: Second,
    wanted: [Optimum; 3],
) -> Option<Vec<Vec<Ratio>>> {
    let memory = remembering(made, sets);
    let start = usize::from(sets[0][0]) + 2 * usize::from(sets[1][0]);
    let every = vec![true; memory.states()];
    let visited =
        |bit: usize| (0..memory.states()).map(|pair| (pair % 4) >> bit & 1 == 1).collect::<Vec<_>>();
    let mut reached = vec![false; memory.states()];
    let mut layer = vec![start];
    while let Some(pair) = layer.pop() {
        if !std::mem::replace(&mut reached[pair], true) {
            layer.extend(memory.choices[pair].iter().flat_map(|choice| choice.1.iter().map(|edge| edge.0)));
        }
    }
    let counts = (0..memory.states()).filter(|&pair| reached[pair]).map(|pair| memory.choices[pair].len());
    if !(4..=100).contains(&counts.product::<usize>()) {
        return None;
    }
    let mut found = Vec::new();
    for pure in memory.strategies(|pair| reached[pair]) {
        let mut point: Vec<Ratio> = Vec::new();
        point.push(memory.until(&pure, &visited(0), &every)[start].clone()?);
        let (target, left) = match second {
            Second::Visit => (visited(1), every.clone()),
            Second::Recur => (memory.recurring(&pure, &|pair| sets[1][pair / 4]), every.clone()),
            Second::Before => (visited(1), visited(0).iter().map(|visited| !visited).collect()),
        };
        point.push(memory.until(&pure, &target, &left)[start].clone()?);
        point.push(memory.total(&pure)[start].clone()?);
        let signed = point.into_iter().zip(wanted);
        found.push(signed.map(|(x, own)| if own == Optimum::Max { x } else { -x }).collect());
    }
    Some(found)
}

/// Lets each step end the path with positive probability, so that all rewards are finite.
fn ending(made: &mut Made) {
    let last = made.states() - 1;
    for (_, edges) in made.choices.iter_mut().flatten() {
        if edges.iter().all(|edge| edge.0 != last) {
            edges.push((last, 1));
        }
    }
    (made.choices[last], made.of_state[last]) = (vec![(0, vec![(last, 1)])], 0);
}

/// Some objectives, and the points of all pure strategies, in which small values are negative.
struct Case<'a> {
    arena: &'a Arena<'a>,
    counted: &'a [Counted<'a>],
    wanted: &'a [Optimum],
    bounds: Vec<Ratio>,
    all: Vec<Vec<Ratio>>,
    precision: f64,
    what: String,
}

impl Case<'_> {
    fn sign(&self, at: usize, x: &Ratio) -> Ratio {
        if self.wanted[at] == Optimum::Max { x.clone() } else { -x }
    }

    fn objective(&self, at: usize, is_bounded: bool) -> Objective<'_> {
        let bound = is_bounded.then(|| self.sign(at, &self.bounds[at]));
        Objective { counted: self.counted[at], optimum: self.wanted[at], bound }
    }

    fn ask(&self, objectives: &[Objective<'_>]) -> Several {
        several(self.arena, 0, objectives, self.precision).unwrap()
    }

    fn is_inside(&self, bounds: &[Ratio]) -> bool {
        !separated(bounds, &self.all).0.is_positive()
    }

    fn achievable(&self) -> bool {
        let asked: Vec<_> = (0..self.wanted.len()).map(|at| self.objective(at, true)).collect();
        let (found, inside) = (self.ask(&asked), self.is_inside(&self.bounds));
        let is_right = matches!(found, Several::Achievable(Some(found)) if found == inside);
        assert!(is_right, "{found:?} {inside} {}", self.what);
        inside
    }

    /// Asks for the best value of the first objective; returns whether there is one.
    fn best(&self) -> bool {
        let asked: Vec<_> = (0..self.wanted.len()).map(|at| self.objective(at, at > 0)).collect();
        let at_first = |x: Ratio| [&[x], &self.bounds[1..]].concat();
        let found = match self.ask(&asked) {
            Several::Best(found) => found,
            other => panic!("{other:?}"),
        };
        let Some(value) = found else {
            let least = self.all.iter().map(|x| x[0].clone()).min().unwrap();
            assert!(!self.is_inside(&at_first(least)), "no value: {}", self.what);
            return false;
        };
        assert!(value.width() <= 3e-6, "{value:?} {}", self.what);
        let away = if self.wanted[0] == Optimum::Max { 4e-6 } else { -4e-6 };
        let middle = f64::midpoint(value.lower, value.upper);
        let inside = |x: f64| self.is_inside(&at_first(self.sign(0, &Ratio::from_float(x).unwrap())));
        assert!(inside(middle - away) && !inside(middle + away), "{value:?} {}", self.what);
        true
    }

    /// Asks for the front of the first and the last objective; returns whether it has several points.
    fn front(&self) -> bool {
        let pair = [0, self.wanted.len() - 1];
        let Several::Front(points) = self.ask(&pair.map(|at| self.objective(at, false))) else { panic!() };
        let exact = |x: &[f64; 2]| -> Vec<Ratio> {
            pair.iter().zip(x).map(|(&at, &x)| self.sign(at, &Ratio::from_float(x).unwrap())).collect()
        };
        let points: Vec<Vec<Ratio>> = points.iter().map(exact).collect();
        let all: Vec<Vec<Ratio>> = self.all.iter().map(|x| pair.map(|at| x[at].clone()).to_vec()).collect();
        let small = Ratio::from_float(3e-6).unwrap();
        for point in &points {
            let less: Vec<Ratio> = point.iter().map(|x| x - &small).collect();
            assert!(!separated(&less, &all).0.is_positive(), "{}", self.what);
        }
        for point in &all {
            let (away, _) = separated(point, &points);
            assert!(away <= small, "{} {}", away.to_f64().unwrap(), self.what);
        }
        points.len() > 1
    }
}

#[test]
fn several_objectives_are_those_of_means_of_pure_strategies() {
    let (mut counts, mut fronts) = ([0; 4], 0);
    for seed in 0..240 {
        let draw = &mut Draw::new(seed);
        let mut made = Made::draw(draw, "mdp");
        if seed % 4 > 0 {
            ending(&mut made);
        }
        let sets = [(); 2].map(|()| (0..made.states()).map(|_| draw.below(3) == 0).collect::<Vec<bool>>());
        let wanted = [(); 3].map(|()| if draw.below(3) == 0 { Optimum::Min } else { Optimum::Max });
        let second = [Second::Visit, Second::Recur, Second::Before][seed as usize % 3];
        let Some(all) = points(&made, &sets, second, wanted) else { continue };
        let program = load(&made.text("mdp"));
        let settings = Settings { storage: Storage::Explicit, ..Settings::default() };
        let engine = AnyEngine::new(Arc::new(program.clone()), settings).unwrap();
        let arena = &Arena::new(&engine, &program).unwrap();
        let rewards = arena.rewards(&engine, 0).unwrap();
        let bits = sets.each_ref().map(|set| set.iter().copied().collect::<BitVec>());
        let others = !bits[0].clone();
        let own = match second {
            Second::Visit => Counted::Visit(&bits[1]),
            Second::Recur => Counted::Recur(&bits[1]),
            Second::Before => Counted::Until(&others, &bits[1]),
        };
        let counted = [Counted::Visit(&bits[0]), own, Counted::Total(&rewards)];
        let few = 2 + draw.below(2);
        let (counted, wanted) = (&counted[..few], &wanted[..few]);
        let all: Vec<Vec<Ratio>> = all.into_iter().map(|point| point[..few].to_vec()).collect();
        let more = |draw: &mut Draw| Ratio::new((draw.below(9) as i64 - 4).into(), 12.into());
        let bounds: Vec<Ratio> = (0..few).map(|at| &all[draw.below(all.len())][at] + more(draw)).collect();
        let precision = [1e-6, 0.0][seed as usize % 2];
        let what =
            format!("seed {seed}, {second:?}, {wanted:?}, {bounds:?}, {precision}\n{}", made.text("mdp"));
        let case = Case { arena, counted, wanted, bounds, all, precision, what };
        counts[usize::from(case.achievable())] += 1;
        counts[2 + usize::from(case.best())] += 1;
        fronts += usize::from(case.front());
    }
    assert!(counts.iter().all(|&count| count > 5) && fronts > 1, "{counts:?} {fronts}");
}
