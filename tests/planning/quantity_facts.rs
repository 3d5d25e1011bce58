//! Facts about quantities: {P_k > 0} and {P_k = 1} are levels, on all models of `models`; and the
//! expected number of improvements is attained.

use proptest::prelude::*;

use crate::common::prelude::*;
use crate::planning::quantities::{chain, exact};
use crate::planning::worlds::{World, graph};

/// The greatest number of improvements that is checked.
const LEVELS: usize = 3;

fn analysed<E: Engine>(engine: &Arc<E>, preferences: &Arc<Preferences>, safety: Safety) -> Analysis<E> {
    finished(engine, preferences, Options { safety, max_level: None })
}

fn solved<E: Engine>(analysis: &Analysis<E>, program: &Program, states: &[State], exact: bool) -> Values {
    let mut values = Values::new(ValueOptions { levels: LEVELS, exact, within: None });
    values.explore(analysis, program, states, &Steps).unwrap();
    values.solve(analysis.engine()).unwrap();
    values
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
