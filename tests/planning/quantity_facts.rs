//! Facts about quantities: {P_k > 0} and {P_k = 1} are levels, on all models of `models`; and the
//! expected number of improvements is attained.

use meliora::quantities::Node;
use proptest::prelude::*;

use crate::common::prelude::*;
use crate::planning::quantities::{chain, exact};
use crate::planning::worlds::{World, graph};

/// The greatest number of improvements that is checked.
const LEVELS: usize = 3;

/// The constants of families of models.
const FAMILIES: &[(&str, &str)] = &[
    ("chain", "N=3"),
    ("network", "K=2,M=2"),
    ("patrol", "N=2"),
    ("rescue", "H=2"),
    ("ring", "N=8,T=2"),
    ("scramble", "cells=4"),
];

fn analysed<E: Engine>(engine: &Arc<E>, preferences: &Arc<Preferences>, safety: Safety) -> Analysis<E> {
    finished(engine, preferences, Options { safety, max_level: None })
}

fn solved<E: Engine>(analysis: &Analysis<E>, program: &Program, states: &[State], exact: bool) -> Values {
    let mut values = Values::new(ValueOptions { levels: LEVELS, exact, within: None });
    values.explore(analysis, program, states, &Steps).unwrap();
    values.solve(analysis.engine()).unwrap();
    values
}

fn solved_everywhere<E: Engine>(analysis: &Analysis<E>, program: &Program) -> Values {
    let mut values = Values::new(ValueOptions { levels: LEVELS, exact: false, within: None });
    values.explore_everywhere(analysis, program, &Steps).unwrap();
    values.solve(analysis.engine()).unwrap();
    values
}

/// Checks that two explorations find overlapping bounds in a state, and the same certainty.
fn agree((values, node): (&Values, Node), (others, other): (&Values, Node), k: usize) {
    let [p, q] = [values.probability(node, k), others.probability(other, k)].map(|bounds| bounds.interval);
    assert!(p.lower <= q.upper && q.lower <= p.upper, "P_{k}: {p:?} {q:?}");
    assert_eq!((p.lower > 0.0, p.lower == 1.0), (q.lower > 0.0, q.lower == 1.0), "P_{k}");
    match [values.cost(node, k), others.cost(other, k)].map(|bounds| bounds.map(|b| b.interval)) {
        [None, None] => {}
        [Some(c), Some(d)] => assert!(c.lower <= d.upper && d.lower <= c.upper, "C_{k}: {c:?} {d:?}"),
        other => panic!("C_{k}: {other:?}"),
    }
}

fn at_least<E: Engine>(analysis: &Analysis<E>, kind: Kind, state: &State, k: usize) -> bool {
    match analysis.levels(kind).rank(analysis.engine(), state).unwrap() {
        Rank::Finite(n) | Rank::AtLeast(n) => n >= k,
        Rank::Unbounded => true,
    }
}

fn levels_are_facts<E: Engine>(
    engine: &Arc<E>,
    program: &Program,
    preferences: &Arc<Preferences>,
    name: &str,
) {
    let states = engine.list_states(&engine.all_states(), usize::MAX).unwrap();
    let action = analysed(engine, preferences, Safety::Action);
    for &safety in Safety::ALL {
        let analysis = analysed(engine, preferences, safety);
        let values = solved(&analysis, program, &states, false);
        let everywhere = solved_everywhere(&analysis, program);
        // Under `transition`, a step that may weaken may also fail.
        let strict = if safety == Safety::Transition { &action } else { &analysis };
        for state in &states {
            let (Some(node), Some(same)) = (values.start(state), everywhere.start(state)) else {
                assert!(analysis.is_unsafe(state).unwrap(), "{name}, {safety}: {state:?}");
                continue;
            };
            for k in 1..=LEVELS {
                let p = values.probability(node, k).interval;
                agree((&values, node), (&everywhere, same), k);
                let (possible, sure) =
                    (at_least(&analysis, Kind::Spi, state, k), at_least(strict, Kind::Sasi, state, k));
                let at = format!("{name}, {safety}, P_{k} in {state:?}: {p:?}");
                assert_eq!((p.lower > 0.0, p.upper > 0.0), (possible, possible), "{at}");
                assert_eq!((p.lower == 1.0, p.upper == 1.0), (sure, sure), "{at}");
                assert_eq!(values.cost(node, k).is_some(), sure, "{at}");
            }
        }
    }
}

#[test]
fn levels_say_where_probabilities_are_positive_and_one_in_all_models() {
    let mut models = 0;
    for entry in fs::read_dir("models").unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|ending| ending != "prism") {
            continue;
        }
        let read = |path: &std::path::Path| {
            SourceFile::new(path.display().to_string(), fs::read_to_string(path).unwrap())
        };
        let name = path.display().to_string();
        let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap();
        let family = FAMILIES.iter().find(|family| family.0 == stem);
        let constants = SourceFile::new("constants", family.map_or("", |family| family.1));
        // Large families are left out.
        let Ok(loaded) = lang::load(&read(&path), &constants) else { continue };
        let program = loaded.program;
        let lang::Task { program, preferences } =
            lang::load_preferences(&read(&path.with_extension("pref")), program).unwrap();
        let (program, preferences) = (Arc::new(program), Arc::new(preferences));
        let settings = || Settings { memory: 256 << 20, ..Settings::default() };
        let symbolic = Arc::new(SymbolicEngine::new(program.clone(), settings()).unwrap());
        if symbolic.count(&symbolic.all_states()).unwrap() > Count::from(5000u32) {
            continue;
        }
        levels_are_facts(&symbolic, &program, &preferences, &name);
        let explicit = Arc::new(ExplicitEngine::new(program.clone(), settings()).unwrap());
        levels_are_facts(&explicit, &program, &preferences, &name);
        models += 1;
    }
    assert!(models >= 8, "only {models} models");
}

/// Checks the probability to climb a ladder: each try climbs or is stuck, and only the goal of the own rung is certain.
fn climbs<E: Engine>(engine: &Arc<E>, program: &Program, preferences: &Arc<Preferences>, safety: Safety) {
    let analysis = analysed(engine, preferences, safety);
    let mut values = Values::new(ValueOptions { levels: RUNGS, exact: true, within: None });
    let bottom = vec![0; program.variables.len()];
    values.explore(&analysis, program, std::slice::from_ref(&bottom), &Steps).unwrap();
    values.solve(engine.as_ref()).unwrap();
    let node = values.start(&bottom).unwrap();
    for k in [1, 62, 63, 64, 65, RUNGS] {
        let half = Ratio::new(1.into(), 2.into());
        assert_eq!(exact(&values.probability(node, k)), num_traits::pow(half, k), "{safety:?}, P_{k}");
    }
}

/// More levels and classes than a word has bits.
const RUNGS: usize = 70;

#[test]
fn many_levels_and_classes_have_their_probabilities() {
    let model = format!(
        "mdp module m n : [0..{RUNGS}]; stuck : bool; done : bool;
           [try] n<{RUNGS} & !stuck & !done -> 1/2:(n'=n+1) + 1/2:(stuck'=true);
           [take] !done -> (done'=true); [] done -> true; endmodule"
    );
    let goal = |n: usize| format!("objective g{n} = F (done & n={n});\n");
    let order: Vec<String> = (0..=RUNGS).rev().map(|n| format!("g{n}")).collect();
    let goals: String = (0..=RUNGS).map(goal).collect();
    let (program, preferences) = task(model, format!("{goals}prefer {};", order.join(" > ")));
    let symbolic = Arc::new(SymbolicEngine::new(program.clone(), Settings::default()).unwrap());
    let explicit = Arc::new(ExplicitEngine::new(program.clone(), Settings::default()).unwrap());
    for safety in [Safety::Action, Safety::Prefix] {
        climbs(&symbolic, &program, &preferences, safety);
        climbs(&explicit, &program, &preferences, safety);
    }
}

/// The expected numbers of one analysis, with the kept choices of each state.
struct Numbers<'a> {
    analysis: &'a Analysis<ExplicitEngine>,
    states: Vec<State>,
    numbers: Vec<Ratio>,
    kept: Vec<Vec<Step<Ratio>>>,
}

impl<'a> Numbers<'a> {
    fn new(world: &World, analysis: &'a Analysis<ExplicitEngine>) -> Self {
        let engine = analysis.engine();
        let states = engine.list_states(&engine.all_states(), usize::MAX).unwrap();
        let values = solved(analysis, &world.program, &states, true);
        let numbers = states.iter().map(|s| exact(&values.number(values.start(s).unwrap()))).collect();
        let arena = &analysis.improvement().unwrap().arenas[0];
        let kept = |state: &State| {
            let mut steps = world.program.exact_steps(state).unwrap();
            steps.retain(|s| engine.contains_choice(&arena.choices, state, &s.choice).unwrap());
            steps
        };
        let kept = states.iter().map(kept).collect();
        Numbers { analysis, states, numbers, kept }
    }

    /// The edges of a step that are not lost: the number of the state, the probability, and 1 for an
    /// improvement.
    fn edges(&self, from: usize, step: &Step<Ratio>) -> Vec<(usize, Ratio, bool)> {
        let (classes, engine) = (self.analysis.classes().unwrap(), self.analysis.engine());
        let members = |state: &State| classes.most_preferred(engine, state).unwrap();
        let mut edges = Vec::new();
        for (to, p) in &step.successors {
            match self.analysis.preferences().change(&members(&self.states[from]), &members(to)) {
                Change::Weakening => {}
                change => {
                    let number = self.states.iter().position(|state| state == to).unwrap();
                    edges.push((number, p.clone(), change == Change::Improving));
                }
            }
        }
        edges
    }

    fn value(&self, from: usize, step: &Step<Ratio>) -> Ratio {
        let bonus = |improves: bool| if improves { Ratio::one() } else { Ratio::zero() };
        let term = |(to, p, improves): (usize, Ratio, bool)| p * (bonus(improves) + &self.numbers[to]);
        self.edges(from, step).into_iter().map(term).fold(Ratio::zero(), |a, b| a + b)
    }

    /// A choice for each state that attains the number there and comes closer to states with none.
    fn strategy(&self) -> Vec<Option<usize>> {
        let mut picks: Vec<Option<usize>> = vec![None; self.states.len()];
        let settled = |picks: &[Option<usize>], to: usize| picks[to].is_some() || self.numbers[to].is_zero();
        while let Some((state, choice)) = (0..self.states.len()).find_map(|s| {
            let closer = |step: &Step<Ratio>| {
                let edges = self.edges(s, step);
                let leaves = edges.len() < step.successors.len();
                leaves || edges.iter().any(|(to, _, _)| settled(&picks, *to))
            };
            let open = picks[s].is_none() && !self.numbers[s].is_zero();
            let good = |step: &Step<Ratio>| self.value(s, step) == self.numbers[s] && closer(step);
            open.then(|| Some((s, self.kept[s].iter().position(good)?))).flatten()
        }) {
            picks[state] = Some(choice);
        }
        picks
    }

    fn check(&self) {
        for (state, number) in self.numbers.iter().enumerate() {
            let best = self.kept[state].iter().map(|step| self.value(state, step)).max();
            assert_eq!(*number, best.unwrap_or_else(Ratio::zero), "N in {:?}", self.states[state]);
        }
        let picks = self.strategy();
        let chosen =
            |s: usize| picks[s].map(|choice| self.edges(s, &self.kept[s][choice])).unwrap_or_default();
        let rows: Vec<_> =
            (0..picks.len()).map(|s| chosen(s).into_iter().map(|(to, p, _)| (to, p)).collect()).collect();
        let gained = |s: usize| {
            let improving = chosen(s).into_iter().filter(|edge| edge.2).map(|edge| edge.1);
            improving.fold(Ratio::zero(), |a, b| a + b)
        };
        let attained = attained(&rows, &picks, gained);
        assert_eq!(attained, self.numbers, "the strategy attains N");
    }
}

/// The expected sum of gains, where every path ends in a state without a choice or is lost.
fn attained(
    rows: &[Vec<(usize, Ratio)>],
    picks: &[Option<usize>],
    gained: impl Fn(usize) -> Ratio,
) -> Vec<Ratio> {
    // A last state takes the lost part.
    let rest = |row: &Vec<(usize, Ratio)>| {
        Ratio::one() - row.iter().map(|edge| edge.1.clone()).fold(Ratio::zero(), |a, b| a + b)
    };
    let mut whole: Vec<Vec<(usize, Ratio)>> =
        rows.iter().map(|row| row.iter().cloned().chain([(rows.len(), rest(row))]).collect()).collect();
    whole.iter_mut().for_each(|row| row.retain(|edge| !edge.1.is_zero()));
    whole.push(Vec::new());
    let end = |s: usize| picks.get(s).copied().flatten().is_none().then(Ratio::zero);
    let mut values = chain(&whole, end, |s| if s < rows.len() { gained(s) } else { Ratio::zero() });
    values.pop();
    values
}

proptest! {
    #![proptest_config(crate::common::amount::random(40))]

    #[test]
    fn expected_numbers_are_attained(graph in graph(8)) {
        let world = graph.world();
        let settings = Settings { scope: world.scope, ..Settings::default() };
        let engine = Arc::new(ExplicitEngine::new(world.program.clone(), settings).unwrap());
        let preferences = Arc::new(crate::planning::quantities::preferences(&world, Default::default()));
        for safety in [Safety::Action, Safety::Transition] {
            Numbers::new(&world, &analysed(&engine, &preferences, safety)).check();
        }
    }
}
