//! The methods for components on random graphs, against exact elimination.

use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use bitvec::vec::BitVec;
use num_traits::FromPrimitive;

use crate::graphs::game_graph::{Edge, LOST};
use crate::graphs::graph::{Graph, Rank};
use crate::graphs::meter::Meter;
use crate::solvers::solution::Solution;
use crate::solvers::system::{Candidates, Method, Quantity, System};
use crate::solvers::ties::{self, Solutions};
use meliora_amount::{share, takes};
use meliora_base::error::Limit;
use meliora_base::exact::Ratio;
use meliora_base::interval::Interval;
use meliora_base::number::{Number, Weight};
use meliora_base::random::Draw;
use meliora_engine::{NoProgress, ProgressSink};

/// The choices of each node: their costs, and their edges with weights. The last node is the end.
type Rows = Vec<Vec<(i64, Vec<(u32, i64)>)>>;

fn rows(draw: &mut Draw, nodes: usize) -> Rows {
    let edge = |draw: &mut Draw| {
        let to = if draw.below(12) == 0 { LOST } else { draw.below(nodes) as u32 };
        (to, [1, 1, 3, 9, 99][draw.below(5)])
    };
    let choice = |draw: &mut Draw| {
        let mut edges: Vec<(u32, i64)> = (0..=draw.below(3)).map(|_| edge(draw)).collect();
        edges.sort_unstable_by_key(|edge| edge.0);
        edges.dedup_by_key(|edge| edge.0);
        ([0, 0, 1, 5][draw.below(4)], edges)
    };
    (1..nodes).map(|_| (0..=draw.below(3)).map(|_| choice(draw)).collect()).chain([Vec::new()]).collect()
}

/// Adds a loss to the choices that have none, so that no number of improvements is infinite.
fn with_losses(mut rows: Rows) -> Rows {
    for (_, edges) in rows.iter_mut().flatten() {
        if edges.iter().all(|edge| edge.0 != LOST) {
            edges.push((LOST, 9));
        }
    }
    rows
}

/// Returns the greatest solution of X = μY. { s : a choice stays in `within(X)` and enters Y or the end }.
fn winning(rows: &Rows, sure: bool) -> Vec<bool> {
    let end = rows.len() - 1;
    let mut x = vec![true; end];
    loop {
        let mut y = vec![false; end];
        let at = |set: &[bool], to: u32| to != LOST && (to as usize == end || set[to as usize]);
        while let Some(more) = (0..end).find(|&s| {
            let wins = |(_, edges): &(i64, Vec<(u32, i64)>)| {
                (!sure || edges.iter().all(|&(to, _)| at(&x, to))) && edges.iter().any(|&(to, _)| at(&y, to))
            };
            !y[s] && rows[s].iter().any(wins)
        }) {
            y[more] = true;
        }
        if x == y || !sure {
            return y;
        }
        x = y;
    }
}

/// Counts the edges to the end.
fn ends(rows: &Rows, _: u32, to: u32) -> bool {
    to as usize == rows.len() - 1
}

/// Counts the edges to the end and some others.
fn improves(rows: &Rows, node: u32, to: u32) -> bool {
    ends(rows, node, to) || to != LOST && (node + to).is_multiple_of(3)
}

fn graph(rows: &Rows, counts: fn(&Rows, u32, u32) -> bool, meter: &mut Meter<'_>) -> Graph {
    let (sure, positive) = (winning(rows, true), winning(rows, false));
    let mut graph = Graph::default();
    for s in 0..rows.len() {
        let is = |set: &[bool]| u32::from(set.get(s).is_some_and(|&inside| inside));
        graph.add_node(Rank { positive: is(&positive), sure: is(&sure) }, false, meter).unwrap();
    }
    fill(&mut graph, rows, counts, meter);
    graph
}

/// Adds the choices of all nodes.
fn fill(graph: &mut Graph, rows: &Rows, counts: fn(&Rows, u32, u32) -> bool, meter: &mut Meter<'_>) {
    for (node, choices) in (0..).zip(rows) {
        graph.begin(node, meter).unwrap();
        for (position, (cost, edges)) in (0..).zip(choices) {
            let sum: i64 = edges.iter().map(|edge| edge.1).sum();
            let cost = graph.fraction(Ratio::from_integer((*cost).into()));
            graph.add_choice(position, cost);
            for &(to, weight) in edges {
                let probability = graph.fraction(Ratio::new(weight.into(), sum.into()));
                graph.add_edge(Edge::new(to, probability, counts(rows, node, to)));
            }
        }
        graph.end(node, meter).unwrap();
    }
    graph.finish();
}

fn solved<N: Number>(
    graph: &Graph,
    quantity: Quantity,
    only: Option<Method>,
    meter: &mut Meter<'_>,
) -> Solution<N> {
    let fractions: Vec<N> = graph.fractions().iter().map(N::of).collect();
    let system = System { only, ..System::new(graph, quantity, None, &fractions) };
    let mut solution = system.start(meter).unwrap();
    system.solve(&mut solution, meter).unwrap();
    solution
}

/// Returns the values of the chosen actions by exact iteration of their linear equations: a policy
/// that attains the values has no other solution below them.
fn attains(graph: &Graph, quantity: Quantity, picks: &Solution<Interval>, exact: &Solution<Ratio>) -> bool {
    let value = |node: u32| exact.get(node).cloned().unwrap_or_default();
    (0..graph.nodes() as u32).filter(|&node| picks.pick(node) != u32::MAX).all(|node| {
        let choice = picks.pick(node);
        let cost = match quantity {
            Quantity::Cost(_) => graph.fractions()[graph.cost(choice) as usize].clone(),
            _ => Weight::zero(),
        };
        let term = |edge: Edge| {
            let to = match (edge.to, edge.counts(), quantity) {
                (LOST, _, _) | (_, true, Quantity::Cost(_)) => Weight::zero(),
                (_, true, Quantity::Probability(_)) => Weight::one(),
                (to, true, _) => value(to) + <Ratio as Weight>::one(),
                (to, false, _) => value(to),
            };
            &graph.fractions()[edge.probability() as usize] * to
        };
        let sum = graph.edges(choice).map(term).fold(cost, |a, b| a + b);
        let (a, b) = (Interval::around(&sum), Interval::around(&value(node)));
        (a.lower - b.lower).abs() <= 1e-6 * b.lower.max(1.0)
    })
}

/// Solves a system by both methods; returns the number of values that iteration found.
fn iterated(seed: u64, graph: &Graph, quantity: Quantity, meter: &mut Meter<'_>) -> usize {
    let exact: Solution<Ratio> = solved(graph, quantity, None, meter);
    let mut iterated = 0;
    for how in [None, Some(Method::Iterate), Some(Method::Eliminate), Some(Method::Exact)] {
        let found: Solution<Interval> = solved(graph, quantity, how, meter);
        for node in 0..graph.nodes() as u32 {
            let (Some(x), Some(y)) = (exact.get(node), found.get(node)) else { continue };
            let [low, high] = [y.lower, y.upper].map(|x| Ratio::from_f64(x).unwrap());
            assert!(
                low <= *x && *x <= high,
                "seed {seed}, {quantity}, {how:?}, node {node}: {x} not in {y:?}"
            );
            assert!(y.width() <= 1e-7 * y.lower.max(1.0), "seed {seed}, {quantity}: {y:?}");
            iterated += usize::from(how == Some(Method::Iterate) && y.width() > 1e-12);
        }
        assert!(attains(graph, quantity, &found, &exact), "seed {seed}, {quantity}, {how:?}");
    }
    iterated
}

#[test]
fn iteration_and_elimination_agree_on_random_graphs() {
    let mut values = 0;
    for seed in 0..400 {
        let mut draw = Draw::new(seed);
        let nodes = 3 + draw.below(12);
        let mut meter = Meter::unlimited(&NoProgress);
        let graph = graph(&rows(&mut draw, nodes), ends, &mut meter);
        for quantity in [Quantity::Probability(1), Quantity::Cost(1)] {
            values += iterated(seed, &graph, quantity, &mut meter);
        }
    }
    assert!(values > 100, "{values} values by iteration");
}

#[test]
fn iteration_and_elimination_agree_on_numbers_of_improvements() {
    let mut values = 0;
    for seed in 0..100 {
        let mut draw = Draw::new(seed);
        let nodes = 3 + draw.below(12);
        let mut meter = Meter::unlimited(&NoProgress);
        let graph = graph(&with_losses(rows(&mut draw, nodes)), improves, &mut meter);
        values += iterated(seed, &graph, Quantity::Number, &mut meter);
    }
    assert!(values > 100, "{values} values by iteration");
}

/// Returns the exact solution of a system whose choices are those that fit, if they are to be told.
fn of_choices(
    graph: &Graph,
    quantity: Quantity,
    fits: &dyn Fn(u32, u32) -> bool,
    (costs, meter): ([u32; 2], &mut Meter<'_>),
) -> Solution<Ratio> {
    let mut choices = BitVec::repeat(false, graph.choices_in_all());
    for node in 0..graph.nodes() as u32 {
        graph.choices(node).for_each(|choice| choices.set(choice as usize, fits(node, choice)));
    }
    let candidates = Candidates::of(choices, costs);
    let system = System::new(graph, quantity, None, graph.fractions());
    let system = System { candidates: Some(&candidates), ..system };
    let mut solution = system.start(meter).unwrap();
    system.solve(&mut solution, meter).unwrap();
    solution
}

/// Returns the solution with bounds that are further apart, each by another amount.
fn widened(solution: &mut Solution<Interval>, graph: &Graph, draw: &mut Draw) {
    for node in 0..graph.nodes() as u32 {
        let mut more = || [0.0, 1e-12, 1e-9, 3e-8][draw.below(4)];
        if solution.knows(node) {
            let Interval { lower, upper } = *solution.stored(node);
            let bounds = Interval { lower: (lower - more()).max(0.0), upper: upper + more() };
            solution.set(node, bounds);
        }
    }
}

/// Whatever the bounds are, the choices attain the values up to the precision, and need no more steps than
/// the best of those that attain them exactly.
#[test]
fn ties_are_decided_by_steps_and_cost_no_more_than_the_precision() {
    let (mut decided, mut fewer) = (0, 0);
    for seed in 0..600 {
        let mut draw = Draw::new(seed);
        let nodes = 3 + draw.below(9);
        let mut meter = Meter::unlimited(&NoProgress);
        let mut graph = graph(&rows(&mut draw, nodes), ends, &mut meter);
        let costs = ties::costs(&mut graph);
        let mut known = [Quantity::Probability(1), Quantity::Cost(1)]
            .map(|quantity| solved::<Interval>(&graph, quantity, Some(Method::Iterate), &mut meter));
        if seed % 2 == 0 {
            known.iter_mut().for_each(|solution| widened(solution, &graph, &mut draw));
        }
        let fractions: Vec<Interval> = graph.fractions().iter().map(Interval::around).collect();
        let [probability, cost] = known.each_ref().map(std::slice::from_ref);
        let solutions = Solutions { graph: &graph, fractions: &fractions, costs, probability, cost };
        let Some(ties) = solutions.decide(&mut meter).unwrap() else { continue };
        decided += 1;
        let exact = [Quantity::Probability(1), Quantity::Cost(1)]
            .map(|quantity| solved::<Ratio>(&graph, quantity, None, &mut meter));
        let is_sure = |node: u32| graph.rank(node).sure > 0;
        let tied = |node: u32, choice: u32| {
            let quantity = if is_sure(node) { Quantity::Cost(1) } else { Quantity::Probability(1) };
            let own = &exact[usize::from(is_sure(node))];
            let system = System::new(&graph, quantity, None, graph.fractions());
            system.value(choice, own).is_some_and(|value| Some(&value) == own.get(node))
        };
        let taken = |node: u32, choice: u32| ties.pick(node, 0) == choice;
        let mut of = |quantity, fits: &dyn Fn(u32, u32) -> bool| {
            of_choices(&graph, quantity, fits, (costs, &mut meter))
        };
        let own = [Quantity::Probability(1), Quantity::Cost(1)].map(|quantity| of(quantity, &taken));
        let [least, steps] =
            [&tied as &dyn Fn(u32, u32) -> bool, &taken].map(|fits| of(Quantity::Steps(1), fits));
        for node in (0..graph.nodes() as u32).filter(|&node| graph.rank(node).positive > 0) {
            let number = |solution: &Solution<Ratio>| solution.get(node).unwrap().bounds().upper;
            let what = format!("seed {seed}, node {node}");
            assert!(number(&steps) <= number(&least) * (1.0 + 1e-6), "{what}: more steps");
            fewer += usize::from(ties.pick(node, 0) != known[usize::from(is_sure(node))].pick(node));
            let (value, bounds) =
                (number(&own[usize::from(is_sure(node))]), known[usize::from(is_sure(node))].get(node));
            let (bounds, [loss, more]) = (bounds.unwrap(), ties.loss(node, 0));
            match is_sure(node) {
                false => {
                    assert!(value >= bounds.lower - loss - 1e-15 && value >= bounds.upper - 1e-6, "{what}")
                }
                true => assert!(
                    value <= (bounds.upper + more) * (1.0 + 1e-15)
                        && value <= bounds.lower + 1e-6 * bounds.lower.max(1.0),
                    "{what}"
                ),
            }
        }
    }
    assert!(decided > 100 && fewer > 50, "{decided} {fewer}");
}

/// Stops the work when it is asked once more than this number of times.
struct Patience(AtomicUsize);

impl ProgressSink for Patience {
    fn stop(&self) -> Option<Limit> {
        let last = |n: usize| n.checked_sub(1);
        self.0.fetch_update(Relaxed, Relaxed, last).err().map(|_| Limit::Interrupted)
    }
}

#[test]
fn bounds_hold_wherever_a_limit_ends_the_work() {
    let (mut ended, mut narrow, mut wide) = (0, 0, 0);
    for seed in 0..share(6) as u64 {
        let graph = graph(&rows(&mut Draw::new(seed), 300), ends, &mut Meter::unlimited(&NoProgress));
        let fractions: Vec<Interval> = graph.fractions().iter().map(Number::of).collect();
        for quantity in [Quantity::Probability(1), Quantity::Cost(1)] {
            let whole: Solution<Interval> =
                solved(&graph, quantity, Some(Method::Iterate), &mut Meter::unlimited(&NoProgress));
            let only = Some(Method::Iterate);
            let system = System { only, ..System::new(&graph, quantity, None, &fractions) };
            for patience in (0..).filter(|&patience| takes(patience)) {
                let sink = Patience(AtomicUsize::new(patience));
                let mut meter = Meter::unlimited(&sink);
                let mut solution = system.start(&mut meter).unwrap();
                if system.solve(&mut solution, &mut meter).is_ok() {
                    break;
                }
                ended += 1;
                for node in (0..graph.nodes() as u32).filter(|&node| system.is_open(node)) {
                    let (Some(x), Some(y)) = (whole.get(node), solution.get(node)) else { panic!("{node}") };
                    assert!(y.lower <= x.upper && x.lower <= y.upper, "seed {seed}, {quantity}: {x:?} {y:?}");
                    let is_narrow = y.width() < 1e-3;
                    (narrow, wide) = (narrow + usize::from(is_narrow), wide + usize::from(!is_narrow));
                }
            }
        }
    }
    assert!(ended > 15 && narrow > 50 && wide > 50, "{ended} {narrow} {wide}");
}

/// Returns a ring of nodes in which a step leads to the next node or back to one of two hubs, which are in the
/// middle; the end is entered from the node before the second one.
fn around_hubs(nodes: u32, meter: &mut Meter<'_>) -> Graph {
    let (hubs, end) = ([nodes / 2, nodes / 2 + 9], nodes);
    let choices = |node: u32| {
        let hub = hubs[node as usize % 2];
        match (node + 1) % nodes {
            to if to == hubs[1] => vec![(1, vec![(to, 1), (end, 1)])],
            to if to == hub => vec![(1, vec![(to, 1)])],
            to => vec![(1, vec![(to, 999), (hub, 1)]), (2, vec![(to, 99_999), (hub, 1)])],
        }
    };
    let rows: Rows = (0..nodes).map(choices).chain([Vec::new()]).collect();
    let mut graph = Graph::default();
    for node in 0..=nodes {
        let rank = u32::from(node < nodes);
        graph.add_node(Rank { positive: rank, sure: rank }, false, meter).unwrap();
    }
    fill(&mut graph, &rows, ends, meter);
    graph
}

#[test]
fn values_around_hubs_are_those_of_elimination() {
    let meter = &mut Meter::unlimited(&NoProgress);
    let graph = around_hubs(1500, meter);
    let methods = [None, Some(Method::Iterate), Some(Method::Eliminate)];
    let [others @ .., eliminated] =
        methods.map(|how| solved::<Interval>(&graph, Quantity::Cost(1), how, meter));
    for (node, found) in (0..1500).flat_map(|node| others.iter().map(move |found| (node, found))) {
        let [a, b] = [found, &eliminated].map(|solution| solution.get(node).unwrap());
        assert!(a.lower <= b.upper && b.lower <= a.upper, "{node}: {a:?} {b:?}");
        assert!(a.width() <= 1e-7 * a.lower && b.width() <= 1e-7 * b.lower, "{node}: {a:?} {b:?}");
    }
}
