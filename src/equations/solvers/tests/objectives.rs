//! Several objectives against all pure strategies that remember the visited sets.

use std::sync::Arc;

use bitvec::vec::BitVec;
use meliora_amount::share;
use meliora_base::exact::Ratio;
use meliora_base::random::Draw;
use meliora_engine::{AnyEngine, Settings, Storage};
use meliora_model::Optimum;
use num_traits::{Signed, ToPrimitive};

use super::arenas::{Choice, Made, load};
use crate::graphs::arena::Arena;
use crate::solvers::hull::separated;
use crate::values::several::{Counted, Node, Objective, Part, Several, mixed, several};

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

/// The second objective: to visit the second set, infinitely often, or before the first one, and the reward before it is
/// visited.
#[derive(Debug, Clone, Copy)]
enum Second {
    Visit,
    Recur,
    First,
    Paid,
}

/// A point; `None` for an infinite reward.
type Raw = Vec<Option<Ratio>>;

/// Returns the points of all pure strategies; `None` if there are fewer than 4 or more than 40.
fn points(made: &Made, sets: &[Vec<bool>; 2], second: Second) -> Option<Vec<Raw>> {
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
    if !(4..=40).contains(&counts.product::<usize>()) {
        return None;
    }
    let point = |pure| {
        let others: Vec<bool> = visited(0).iter().map(|visited| !visited).collect();
        let second = match second {
            Second::Visit => memory.until(&pure, &visited(1), &every),
            Second::Recur => memory.until(&pure, &memory.recurring(&pure, &|pair| sets[1][pair / 4]), &every),
            Second::First => memory.until(&pure, &visited(1), &others),
            Second::Paid => memory.reward_until(&pure, &visited(1)),
        };
        let all = [memory.until(&pure, &visited(0), &every), second, memory.total(&pure)];
        all.map(|of| of[start].clone()).to_vec()
    };
    Some(memory.strategies(|pair| reached[pair]).into_iter().map(point).collect())
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

/// Returns the chain of a strategy, after checking that its steps are those of the model. Gains of several choices that are
/// taken at random do not count.
fn chain(made: &Made, nodes: &[Node]) -> Made {
    let one = |node: &Node| {
        let mut edges: Vec<(usize, Ratio)> = Vec::new();
        let mut gains = Vec::new();
        for taking in &node.choices {
            let (gain, own) = &made.choices[node.state][taking.position];
            gains.push(*gain);
            let sum: i64 = own.iter().map(|edge| edge.1).sum();
            let p = |&(to, weight): &(usize, i64)| (to, Ratio::new(weight.into(), sum.into()));
            let mut expected: Vec<_> = own.iter().map(p).collect();
            let mut found: Vec<_> =
                taking.successors.iter().map(|(to, p)| (nodes[*to].state, Ratio::clone(p))).collect();
            expected.sort();
            found.sort();
            assert_eq!(found, expected);
            let share = Ratio::new(1.into(), node.choices.len().into());
            edges.extend(taking.successors.iter().map(|(to, p)| (*to, &**p * &share)));
        }
        assert!(!gains.is_empty());
        // All denominators are products of numbers up to 9.
        let whole = |(to, p): (usize, Ratio)| (to, (p * Ratio::from_integer(7560.into())).to_i64().unwrap());
        vec![(gains[0], edges.into_iter().map(whole).collect())]
    };
    Made {
        choices: nodes.iter().map(one).collect(),
        theirs: vec![false; nodes.len()],
        of_state: nodes.iter().map(|node| made.of_state[node.state]).collect(),
    }
}

/// Returns the value of an objective from the first state of a chain.
fn value_in(chain: &Made, nodes: &[Node], counted: Counted<'_>) -> Option<Ratio> {
    let pure = vec![0; nodes.len()];
    let of = |set: &BitVec| nodes.iter().map(|node| set[node.state]).collect::<Vec<bool>>();
    let every = vec![true; nodes.len()];
    let found = match counted {
        Counted::Visit(set) => chain.until(&pure, &of(set), &every),
        Counted::Until(left, set) => chain.until(&pure, &of(set), &of(left)),
        Counted::Recur(set) => {
            let own = of(set);
            chain.until(&pure, &chain.recurring(&pure, &|node| own[node]), &every)
        }
        Counted::Total(_) => chain.total(&pure),
        Counted::Before(_, set) => chain.reward_until(&pure, &of(set)),
        Counted::Within(..) => unreachable!("none is drawn"),
    };
    found[0].clone()
}

/// Some objectives, and the points of all pure strategies, in which small values are negative.
struct Case<'a> {
    made: &'a Made,
    arena: &'a Arena<'a>,
    counted: &'a [Counted<'a>],
    wanted: &'a [Optimum],
    bounds: Vec<Ratio>,
    /// The points with finite costs.
    all: Points,
    /// The points without the first coordinate, which may be infinite.
    others: Points,
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
        let (found, parts) = mixed(self.arena, 0, objectives, self.precision).unwrap();
        self.attained(objectives, &found, &parts);
        found
    }

    /// Checks that the mix of strategies attains the answer, and each of them the values that it claims.
    fn attained(&self, objectives: &[Objective<'_>], found: &Several, parts: &[Part]) {
        let small = Ratio::from_float(3e-6).unwrap();
        let mut means = vec![Ratio::default(); objectives.len()];
        for part in parts {
            let chain = chain(self.made, &part.nodes);
            for (at, own) in objectives.iter().enumerate() {
                let value =
                    value_in(&chain, &part.nodes, own.counted).unwrap_or_else(|| panic!("{}", self.what));
                let claimed = self.sign(at, &part.values[at]);
                assert!(
                    self.sign(at, &value) >= &claimed - &small * &small,
                    "{value} {claimed} {}",
                    self.what
                );
                means[at] += value * part.share.clone().unwrap_or_default();
            }
        }
        let reached = |at: usize, bound: &Ratio| {
            assert!(self.sign(at, &means[at]) >= self.sign(at, bound) - &small, "{means:?} {}", self.what);
        };
        let shows = match found {
            Several::Achievable(Some(true)) => true,
            Several::Best(Some(value)) => {
                reached(0, &Ratio::from_float(f64::midpoint(value.lower, value.upper)).unwrap());
                true
            }
            Several::Front(points) => return assert_eq!(points.len(), parts.len(), "{}", self.what),
            _ => false,
        };
        assert_eq!(!parts.is_empty(), shows, "{found:?} {}", self.what);
        if shows {
            let all: Ratio = parts.iter().filter_map(|part| part.share.clone()).sum();
            assert_eq!(all, Ratio::from_integer(1.into()));
            let bounded =
                objectives.iter().enumerate().filter_map(|(at, own)| Some((at, own.bound.as_ref()?)));
            bounded.for_each(|(at, bound)| reached(at, bound));
        }
    }

    fn is_inside(&self, bounds: &[Ratio]) -> bool {
        !self.all.is_empty() && !separated(bounds, &self.all).0.is_positive()
    }

    /// Returns whether the first objective is a cost that is infinite where the others are satisfied.
    fn is_infinite(&self) -> bool {
        !self.others.is_empty() && !separated(&self.bounds[1..], &self.others).0.is_positive()
    }

    /// Returns whether some strategy satisfies the bounds of all but the first objective, which is finite.
    fn is_finite(&self) -> bool {
        let least = self.all.iter().map(|x| x[0].clone()).min();
        least.is_some_and(|least| self.is_inside(&[&[least], &self.bounds[1..]].concat()))
    }

    /// Returns whether every question is refused.
    fn is_refused(&self) -> bool {
        let ask = |is_bounded: &dyn Fn(usize) -> bool| {
            let asked: Vec<_> = (0..self.wanted.len()).map(|at| self.objective(at, is_bounded(at))).collect();
            several(self.arena, 0, &asked, self.precision).is_err()
        };
        ask(&|_| true) && ask(&|at| at > 0) && ask(&|_| false)
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
        let is_finite = self.is_finite();
        let value = match self.ask(&asked) {
            Several::Best(Some(value)) if is_finite => value,
            Several::Best(None) if !is_finite && !self.is_infinite() => return false,
            Several::Infinite if !is_finite && self.is_infinite() => return false,
            other => panic!("{other:?} {}", self.what),
        };
        assert!(value.width() <= 3e-6, "{value:?} {}", self.what);
        let away = if self.wanted[0] == Optimum::Max { 4e-6 } else { -4e-6 };
        let middle = f64::midpoint(value.lower, value.upper);
        let inside = |x: f64| self.is_inside(&at_first(self.sign(0, &Ratio::from_float(x).unwrap())));
        assert!(inside(middle - away) && !inside(middle + away), "{value:?} {}", self.what);
        true
    }

    /// Asks for the front of all objectives; returns whether it has several points.
    fn front(&self) -> bool {
        let every: Vec<usize> = (0..self.wanted.len()).collect();
        let asked: Vec<_> = every.iter().map(|&at| self.objective(at, false)).collect();
        let points = match mixed(self.arena, 0, &asked, self.precision) {
            Ok((Several::Front(points), parts)) => {
                self.attained(&asked, &Several::Front(points.clone()), &parts);
                points
            }
            other => {
                assert!(self.all.is_empty() && other.is_err(), "{other:?} {}", self.what);
                return false;
            }
        };
        let exact = |x: &Vec<f64>| -> Vec<Ratio> {
            every.iter().zip(x).map(|(&at, &x)| self.sign(at, &Ratio::from_float(x).unwrap())).collect()
        };
        let points: Points = points.iter().map(exact).collect();
        let small = Ratio::from_float(3e-6).unwrap();
        for point in &points {
            let less: Vec<Ratio> = point.iter().map(|x| x - &small).collect();
            assert!(!separated(&less, &self.all).0.is_positive(), "{}", self.what);
        }
        for point in &self.all {
            let (away, _) = separated(point, &points);
            assert!(away <= small, "{} {}", away.to_f64().unwrap(), self.what);
        }
        points.len() > 1
    }
}

type Points = Vec<Vec<Ratio>>;

/// The points of a case: with finite costs, if no reward that is to be great is infinite then; and those without the first
/// coordinate if it is a cost.
fn split(raw: &[Raw], wanted: &[Optimum], is_cost: bool) -> Option<(Points, Points)> {
    let finite = |from: usize| {
        let has =
            move |x: &&Raw| (from..wanted.len()).all(|at| wanted[at] == Optimum::Max || x[at].is_some());
        let signed = move |x: &Raw| -> Option<Vec<Ratio>> {
            let own = |at: usize| x[at].clone().map(|x| if wanted[at] == Optimum::Max { x } else { -x });
            (from..wanted.len()).map(own).collect()
        };
        raw.iter().filter(has).map(signed).collect::<Option<Vec<_>>>()
    };
    Some((finite(0)?, if is_cost { finite(1)? } else { Vec::new() }))
}

/// Draws bounds near the coordinates of some points.
fn drawn_bounds(raw: &[Raw], wanted: &[Optimum], draw: &mut Draw) -> Vec<Ratio> {
    let bound = |(at, optimum): (usize, &Optimum)| {
        let all: Vec<Ratio> = raw.iter().filter_map(|x| x[at].clone()).collect();
        let near = if all.is_empty() { Ratio::default() } else { all[draw.below(all.len())].clone() };
        let bound = near + Ratio::new((draw.below(9) as i64 - 4).into(), 12.into());
        if *optimum == Optimum::Max { bound } else { -bound }
    };
    wanted.iter().enumerate().map(bound).collect()
}

#[test]
fn several_objectives_are_those_of_means_of_pure_strategies() {
    let (mut counts, mut fronts, mut refused, mut infinite) = ([0; 4], [0; 2], [0; 2], 0);
    for seed in 0..share(720) as u64 {
        let draw = &mut Draw::new(seed);
        let mut made = Made::draw(draw, "mdp");
        if seed % 4 > 0 {
            ending(&mut made);
        }
        let sets = [(); 2].map(|()| (0..made.states()).map(|_| draw.below(2) == 0).collect::<Vec<bool>>());
        let wanted = [(); 3].map(|()| if draw.below(2) == 0 { Optimum::Min } else { Optimum::Max });
        let second = [Second::Visit, Second::Recur, Second::First, Second::Paid, Second::Paid][draw.below(5)];
        let Some(raw) = points(&made, &sets, second) else { continue };
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
            Second::First => Counted::Until(&others, &bits[1]),
            Second::Paid => Counted::Before(&rewards, &bits[1]),
        };
        let mut counted = [Counted::Visit(&bits[0]), own, Counted::Total(&rewards)];
        let (turn, few) = (draw.below(3), 2 + draw.below(2));
        counted.rotate_left(turn);
        let (counted, wanted) = (&counted[..few], &wanted[..few]);
        let turned = |mut point: Raw| {
            point.rotate_left(turn);
            point.truncate(few);
            point
        };
        let raw: Vec<Raw> = raw.into_iter().map(turned).collect();
        let bounds = drawn_bounds(&raw, wanted, draw);
        let precision = [1e-6, 0.0][seed as usize % 2];
        let what = format!(
            "seed {seed}, {second:?} turned by {turn}, {sets:?}, {wanted:?}, {bounds:?}, {precision}\n{}",
            made.text("mdp")
        );
        let is_cost =
            wanted[0] == Optimum::Min && matches!(counted[0], Counted::Total(_) | Counted::Before(..));
        let parts = split(&raw, wanted, is_cost);
        let (all, others) = parts.clone().unwrap_or_default();
        let case = Case { made: &made, arena, counted, wanted, bounds, all, others, precision, what };
        if case.is_refused() {
            refused[usize::from(parts.is_some())] += 1;
            continue;
        }
        assert!(parts.is_some(), "not refused: {}", case.what);
        counts[usize::from(case.achievable())] += 1;
        counts[2 + usize::from(case.best())] += 1;
        infinite += usize::from(case.is_infinite() && !case.is_finite());
        fronts[few - 2] += usize::from(case.front());
    }
    let done =
        counts.iter().all(|&count| count > 5) && fronts[0] + fronts[1] >= share(12) && infinite >= share(4);
    assert!(
        done && refused[0] >= share(12) && refused[1] < 5,
        "{counts:?} {fronts:?} {refused:?} {infinite}"
    );
}
