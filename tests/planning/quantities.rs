//! Quantities against their equations, and the strategies that choose by them. With fractions, a value is right if it satisfies the
//! equations (so it is not too small, for costs not too large) and if the chosen actions attain it
//! (so it is not too large, for costs not too small). Both are checked here from the definitions,
//! with linear equations solved by plain elimination.

use std::collections::HashMap;

use meliora::model::preference::ObjectiveSet;
use meliora::quantities::{Bounds, ChoiceValues, Exploration, Interval, Node};
use num_rational::BigRational;
use num_traits::{FromPrimitive, Signed};
use proptest::prelude::*;

use crate::common::prelude::*;
use crate::planning::choosing;
use crate::planning::worlds::{World, factored, graph};

/// The greatest number of improvements that is checked.
const LEVELS: usize = 3;

/// A finished analysis with its exact quantities.
struct Check<'a, E: Engine> {
    world: &'a World,
    analysis: &'a Analysis<E>,
    values: Values,
    states: Vec<State>,
}

pub(crate) fn exact(bounds: &Bounds) -> Ratio {
    bounds.exact.clone().unwrap()
}

impl<'a, E: Engine> Check<'a, E> {
    fn new(world: &'a World, analysis: &'a Analysis<E>, exact: bool) -> Self {
        let engine = analysis.engine();
        let states = engine.list_states(&engine.all_states(), usize::MAX).unwrap();
        let mut values = Values::new(ValueOptions { levels: LEVELS, exact, within: Some(4) });
        let exploration = Exploration::new(values.options(), analysis, &world.program, &Steps).unwrap();
        exploration.run(&mut values, &states).unwrap();
        values.solve(engine).unwrap();
        Check { world, analysis, values, states }
    }

    fn safety(&self) -> Safety {
        self.analysis.options().safety
    }

    fn most_preferred(&self, state: &State) -> ObjectiveSet {
        let classes = self.analysis.classes().unwrap();
        classes.list[classes.of(self.analysis.engine(), state).unwrap().unwrap()].most_preferred.clone()
    }

    /// MP of what steps from a state of an arena are compared with.
    fn reference(&self, arena: usize, state: &State) -> ObjectiveSet {
        match self.analysis.improvement().unwrap().arenas[arena].reference {
            Some(class) => self.analysis.classes().unwrap().list[class].most_preferred.clone(),
            None => self.most_preferred(state),
        }
    }

    fn p(&self, node: Option<Node>, k: usize) -> Ratio {
        node.map_or_else(Ratio::zero, |node| exact(&self.values.probability(node, k)))
    }

    fn c(&self, node: Option<Node>, k: usize) -> Option<Ratio> {
        self.values.cost(node?, k).as_ref().map(exact)
    }

    fn kept(&self, arena: usize, state: &State) -> Vec<Step<Ratio>> {
        let choices = &self.analysis.improvement().unwrap().arenas[arena].choices;
        let mut steps = self.world.program.exact_steps(state).unwrap();
        steps.retain(|s| self.analysis.engine().contains_choice(choices, state, &s.choice).unwrap());
        steps
    }

    fn all(&self) {
        for arena in 0..self.analysis.improvement().unwrap().arenas.len() {
            for state in &self.states {
                let Some(node) = self.values.node(Some(arena), state) else { continue };
                for k in 1..=LEVELS {
                    self.probability(arena, state, node, k);
                    self.cost(arena, state, node, k);
                }
            }
        }
        for state in &self.states {
            let start = self.values.start(state).unwrap();
            self.facts(state, start);
            for k in 1..=LEVELS {
                self.attained(start, k, Aim::Likely);
                if self.values.cost(start, k).is_some() {
                    self.attained(start, k, Aim::Cheap);
                }
                self.curve(start, k);
            }
        }
    }

    /// P_k = max over kept choices of Σ p·v
    fn probability(&self, arena: usize, state: &State, node: Node, k: usize) {
        let reference = self.reference(arena, state);
        let value = |step: &Step<Ratio>| {
            let term = |(to, p): &(State, Ratio)| {
                let stay = || self.p(self.values.node(Some(arena), to), k);
                let count = || self.p(self.values.start(to), k - 1);
                let change = self.analysis.preferences().change(&reference, &self.most_preferred(to));
                let v = match (change, self.safety()) {
                    (Change::Weakening, _) => Ratio::zero(),
                    (Change::Lateral, _) => stay(),
                    (Change::Improving, Safety::Prefix) => count().max(stay()),
                    (Change::Improving, _) => count(),
                };
                p * v
            };
            step.successors.iter().map(term).fold(Ratio::zero(), |a, b| a + b)
        };
        // Where no improvement is possible, nothing is explored: the value 0 is a fact.
        if self.p(Some(node), 1).is_zero() {
            return;
        }
        let best = self.kept(arena, state).iter().map(value).max().unwrap_or_else(Ratio::zero);
        assert_eq!(self.p(Some(node), k), best, "P_{k} in {state:?}, {}", self.safety());
    }

    /// C_k = min over permitted choices of 1 + Σ p·w
    fn cost(&self, arena: usize, state: &State, node: Node, k: usize) {
        let Some(cost) = self.c(Some(node), k) else { return };
        let reference = self.reference(arena, state);
        let value = |step: &Step<Ratio>| {
            let mut sum = Ratio::one();
            for (to, p) in &step.successors {
                let improves = self.analysis.preferences().change(&reference, &self.most_preferred(to))
                    == Change::Improving;
                let count = self.c(self.values.start(to), k - 1).filter(|_| improves);
                let stay = self.c(self.values.node(Some(arena), to), k);
                sum += p * match (count, stay, self.safety()) {
                    (Some(a), Some(b), Safety::Prefix) => a.min(b),
                    (Some(a), _, _) => a,
                    (None, b, _) => b?,
                };
            }
            Some(sum)
        };
        let best = self.kept(arena, state).iter().filter_map(value).min();
        assert_eq!(Some(cost), best, "C_{k} in {state:?}, {}", self.safety());
    }

    /// {P_k > 0} and {P_k = 1} are levels.
    fn facts(&self, state: &State, node: Node) {
        let engine = self.analysis.engine();
        let at_least = |rank: Rank, k: usize| match rank {
            Rank::Finite(n) | Rank::AtLeast(n) => n >= k,
            Rank::Unbounded => true,
        };
        let [sasi, spi] =
            [Kind::Sasi, Kind::Spi].map(|kind| self.analysis.levels(kind).rank(engine, state).unwrap());
        for k in 1..=LEVELS {
            let p = self.p(Some(node), k);
            assert_eq!(!p.is_zero(), at_least(spi, k));
            assert!(p.is_zero() || p.is_positive() && p <= Ratio::one());
            assert_eq!(p.is_one(), self.values.cost(node, k).is_some());
            match self.safety() {
                Safety::Transition => assert!(!p.is_one() || at_least(sasi, k)),
                _ => assert_eq!(p.is_one(), at_least(sasi, k)),
            }
        }
        let number = exact(&self.values.number(node));
        let sum = (1..=LEVELS).map(|k| self.p(Some(node), k)).max().unwrap();
        assert!(number >= sum, "N is at least P_1");
    }

    /// The choices of a strategy attain the value.
    fn attained(&self, start: Node, k: usize, aim: Aim) {
        let (mut nodes, mut index) = (vec![(start, k)], HashMap::from([((start, k), 0)]));
        let mut rows = Vec::new();
        while rows.len() < nodes.len() {
            let (node, left) = nodes[rows.len()];
            let mut row = Vec::new();
            if left > 0
                && let Some(position) = self.values.best_choice(node, left, aim)
            {
                let state = &self.values.state(node);
                let step = self.world.program.exact_steps(state).unwrap().swap_remove(position);
                for (to, p) in step.successors {
                    if let Some(next) = self.values.successor(node, left, aim, &to) {
                        let number = *index.entry(next).or_insert(nodes.len());
                        if number == nodes.len() {
                            nodes.push(next);
                        }
                        row.push((number, p));
                    }
                }
            }
            rows.push(row);
        }
        let goal = |n: usize| nodes[n].1 == 0;
        let reaches = chain(&rows, |n| if goal(n) { Some(Ratio::one()) } else { None }, |_| Ratio::zero());
        assert_eq!(reaches[0], self.p(Some(start), k), "level {k} by {aim:?}, {}", self.safety());
        if aim == Aim::Cheap {
            let cost = chain(&rows, |n| goal(n).then(Ratio::zero), |_| Ratio::one());
            assert_eq!(Some(cost[0].clone()), self.c(Some(start), k));
        }
    }

    /// Curves grow towards the value.
    fn curve(&self, node: Node, k: usize) {
        let curve = self.values.within(node, k).unwrap();
        assert_eq!(curve.len(), 5);
        assert!(curve.windows(2).all(|w| w[0] <= w[1]) && curve[0] == 0.0);
        assert!(Ratio::from_f64(curve[4]).unwrap() <= self.p(Some(node), k));
    }
}

/// Solves x_n = reward(n) + Σ p·x, with given values at ends; 0 where no end can be reached.
pub(crate) fn chain(
    rows: &[Vec<(usize, Ratio)>],
    end: impl Fn(usize) -> Option<Ratio>,
    reward: impl Fn(usize) -> Ratio,
) -> Vec<Ratio> {
    let n = rows.len();
    let mut ahead: BTreeSet<usize> = (0..n).filter(|&i| end(i).is_some()).collect();
    while let Some(more) =
        (0..n).find(|i| !ahead.contains(i) && rows[*i].iter().any(|(to, _)| ahead.contains(to)))
    {
        ahead.insert(more);
    }
    let mut a = vec![vec![Ratio::zero(); n + 1]; n];
    for i in 0..n {
        a[i][i] = Ratio::one();
        match end(i) {
            Some(value) => a[i][n] = value,
            None if ahead.contains(&i) => {
                a[i][n] = reward(i);
                rows[i].iter().for_each(|(to, p)| a[i][*to] -= p);
            }
            None => {}
        }
    }
    for i in 0..n {
        let pivot = (i..n).find(|&r| !a[r][i].is_zero()).unwrap();
        a.swap(i, pivot);
        let row = a[i].clone();
        for (r, other) in a.iter_mut().enumerate() {
            if r != i && !other[i].is_zero() {
                let f = &other[i] / &row[i];
                other.iter_mut().zip(&row).for_each(|(x, y)| *x -= &f * y);
            }
        }
    }
    (0..n).map(|i| &a[i][n] / &a[i][i]).collect()
}

fn holds(interval: Interval, value: &Ratio) -> bool {
    contains(interval, value) && interval.width() <= 1e-9 * interval.upper.max(1.0)
}

fn contains(Interval { lower, upper }: Interval, value: &Ratio) -> bool {
    BigRational::from_f64(lower).unwrap() <= *value
        && BigRational::from_f64(upper).is_none_or(|upper| *value <= upper)
}

/// Bounds from each part of the states that a state reaches contain the values, and become narrow.
fn parts<E: Engine>(right: &Check<'_, E>, state: &State) {
    let (analysis, start) = (right.analysis, right.values.start(state).unwrap());
    let options = ValueOptions { levels: LEVELS, exact: false, within: None };
    let exploration = Exploration::new(options, analysis, &right.world.program, &Steps).unwrap();
    let mut part = Values::new(options);
    for nodes in 1.. {
        exploration.run_part(&mut part, std::slice::from_ref(state), nodes).unwrap();
        part.solve(analysis.engine()).unwrap();
        exploration.close(&mut part, nodes + nodes / 2).unwrap();
        let node = part.start(state).unwrap();
        let mut pairs = vec![(Some(part.number(node)), Some(right.values.number(start)))];
        for k in 1..=LEVELS {
            let [found, value] = [(&part, node), (&right.values, start)].map(|(values, node)| {
                let mut choices = values.choices(node, k, Aim::Likely);
                choices.sort_by_key(|choice| choice.position);
                let of = |choice: ChoiceValues| [Some(choice.probability), choice.cost];
                let own = [Some(values.probability(node, k)), values.cost(node, k)];
                own.into_iter().chain(choices.into_iter().flat_map(of)).collect::<Vec<_>>()
            });
            pairs.extend(found.into_iter().zip(value));
        }
        for (found, value) in pairs.into_iter().filter_map(|(found, value)| found.zip(value)) {
            let (Interval { lower, .. }, width) = (found.interval, found.interval.width());
            assert!(
                contains(found.interval, &exact(&value)),
                "{nodes} nodes, {state:?}: {found:?}, {value:?}"
            );
            assert!(
                !part.is_settled() || width <= 1e-6 * lower.max(1.0),
                "{nodes} nodes, {state:?}: {found:?}"
            );
        }
        if part.is_settled() {
            return;
        }
    }
    unreachable!("all nodes are explored at last")
}

pub(crate) fn preferences(world: &World, empty: Empty) -> Preferences {
    let objective = |(i, &target): (usize, &meliora::model::expr::ExprId)| Objective {
        name: format!("o{i}"),
        goal: Goal::Reach(world.program.predicate(target)),
        span: None,
    };
    Preferences {
        objectives: world.targets.iter().enumerate().map(objective).collect(),
        order: Preorder::new(world.targets.len(), &world.statements).unwrap(),
        empty,
        history: Default::default(),
        requirements: Vec::new(),
    }
}

fn check<E: Engine>(engine: &Arc<E>, world: &World, empty: Empty) {
    let preferences = Arc::new(preferences(world, empty));
    for &safety in Safety::ALL {
        let analysis = finished(engine, &preferences, Options { safety, max_level: None });
        let right = Check::new(world, &analysis, true);
        right.all();
        let rounded = Check::new(world, &analysis, false);
        for state in &right.states {
            let [x, y] = [&right.values, &rounded.values].map(|v| v.start(state).unwrap());
            assert!(holds(rounded.values.number(y).interval, &exact(&right.values.number(x))));
            for k in 1..=LEVELS {
                assert!(holds(rounded.values.probability(y, k).interval, &right.p(Some(x), k)));
                if let Some(cost) = right.c(Some(x), k) {
                    assert!(holds(rounded.values.cost(y, k).unwrap().interval, &cost));
                }
            }
        }
        right.states.iter().take(3).for_each(|state| parts(&right, state));
        let Check { values, states, .. } = right;
        choosing::check(&analysis, world, &states, values, &format!("{safety}, {empty:?}"));
    }
}

fn both(world: &World) {
    let settings = || Settings { scope: world.scope, memory: 64 << 20, ..Settings::default() };
    let explicit = Arc::new(ExplicitEngine::new(world.program.clone(), settings()).unwrap());
    Empty::ALL.iter().for_each(|&empty| check(&explicit, world, empty));
    let symbolic = Arc::new(SymbolicEngine::new(world.program.clone(), settings()).unwrap());
    check(&symbolic, world, Empty::Bottom);
}

proptest! {
    #![proptest_config(meliora_amount::random(60))]

    #[test]
    fn values_satisfy_their_equations_and_strategies_attain_them_on_graphs(graph in graph(9)) {
        both(&graph.world());
    }

    #[test]
    fn values_satisfy_their_equations_and_strategies_attain_them_on_programs(factored in factored()) {
        both(&factored.world());
    }
}
