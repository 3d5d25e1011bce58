//! Both engines against the definitions: outcomes, classes, improvement MDP, levels, ranks and
//! strategies, state by state and choice by choice.

use meliora::model::preference::Requirement;
use meliora::planning::levels::{End, Level};
use meliora::planning::strategy::{permitted_at_start, strategies};
use proptest::prelude::*;

use crate::common::brute::Pair;
use crate::common::prelude::*;
use crate::planning::literal::{Literal, Set, almost_sure, positive};
use crate::planning::tiny::{Mdp, Tiny};
use crate::planning::worlds::{World, factored, graph};
use crate::planning::{Case, analyse};

/// A world as a case of plain vectors: state and choice numbers are those of the reference.
struct Reference {
    brute: Brute,
    case: Case,
    tiny: Arc<Tiny>,
}

impl Reference {
    fn new(world: &World) -> Self {
        let brute = Brute::new(&world.program, world.scope).unwrap();
        match world.requirement {
            Some(requirement) => Self::of(world, keeping(brute, &world.program, requirement)),
            None => Self::of(world, brute),
        }
    }

    fn of(world: &World, brute: Brute) -> Self {
        let mut choices = vec![Vec::new(); brute.states.len()];
        for pair in &brute.pairs {
            choices[pair.state].push(pair.successors.iter().copied().collect());
        }
        let target = |&e| brute.states_where(&world.program, e).into_iter().collect();
        let targets = world.targets.iter().map(target).collect();
        let case = Case { mdp: Mdp::new(choices), targets, statements: world.statements.clone() };
        Reference { brute, tiny: case.engine(), case }
    }
}

/// Takes out of a model the states that cannot keep a requirement, and the choices that may step
/// into them.
fn keeping(whole: Brute, program: &Program, requirement: ExprId) -> Brute {
    let allowed = whole.states_where(program, requirement);
    let (inside, kept) = whole.stay_within(&allowed, &whole.all_choices());
    let number: BTreeMap<usize, usize> = inside.iter().copied().zip(0..).collect();
    let renumbered = |x: &Set| x.iter().filter_map(|s| number.get(s).copied()).collect();
    let pairs = whole.pairs.iter().enumerate().filter(|(pair, _)| kept.contains(pair));
    Brute {
        states: inside.iter().map(|&s| whole.states[s].clone()).collect(),
        pairs: pairs
            .map(|(_, pair)| Pair {
                state: number[&pair.state],
                choice: pair.choice.clone(),
                successors: renumbered(&pair.successors),
            })
            .collect(),
        initial: renumbered(&whole.initial),
        deadlocks: renumbered(&whole.deadlocks),
    }
}

/// One analysis by an engine, and the expected results.
struct Check<'a, E: Engine> {
    world: &'a World,
    reference: &'a Reference,
    literal: &'a Literal<'a>,
    found: &'a Analysis<E>,
    tiny: &'a Analysis<Tiny>,
}

impl<E: Engine> Check<'_, E> {
    fn all(&self) {
        self.outcomes();
        self.classes();
        self.improvement();
        for kind in [Kind::Sasi, Kind::Spi] {
            self.levels(kind);
            self.strategies(kind);
        }
        self.prospects();
    }

    fn states(&self, what: &str, x: &E::States, expected: &Set) {
        let engine = self.found.engine();
        for (s, state) in self.reference.brute.states.iter().enumerate() {
            assert_eq!(engine.contains(x, state).unwrap(), expected.contains(&s), "{what}: {state:?}");
        }
        assert_eq!(engine.count(x).unwrap(), expected.len().into(), "{what}");
    }

    fn choices(&self, what: &str, c: &E::Choices, expected: &Set) {
        let engine = self.found.engine();
        for (number, pair) in self.reference.brute.pairs.iter().enumerate() {
            let state = &self.reference.brute.states[pair.state];
            let found = engine.contains_choice(c, state, &pair.choice).unwrap();
            assert_eq!(found, expected.contains(&number), "{what}: {state:?} {:?}", pair.choice);
        }
        assert_eq!(engine.count(c).unwrap(), expected.len().into(), "{what}");
    }

    fn outcomes(&self) {
        for (i, target) in self.reference.case.targets.iter().enumerate() {
            let (mdp, target) = (&self.reference.case.mdp, target.iter().copied().collect());
            let outcome = self.found.outcomes().unwrap().get(i).unwrap();
            self.states("target", &outcome.target, &target);
            self.states("almost sure", &outcome.almost_sure, &almost_sure(mdp, &target));
            self.states("positive", &outcome.positive, &positive(mdp, &target));
        }
    }

    fn classes(&self) {
        let mp = &self.literal.mp;
        let classes = &self.found.classes().unwrap().list;
        assert_eq!(classes.len(), mp.iter().collect::<BTreeSet<_>>().len());
        let where_mp = |holds: &dyn Fn(&Set) -> bool| (0..mp.len()).filter(|&s| holds(&mp[s])).collect();
        for class in classes {
            let own: Set = class.most_preferred.iter().collect();
            let weakens = |to: &Set| self.literal.weakens(&own, to);
            let improves = |to: &Set| self.literal.improves(&own, to) && !weakens(to);
            self.states("class", &class.states, &where_mp(&|to| *to == own));
            self.states("better", &class.better, &where_mp(&improves));
            self.states("worse", &class.worse, &where_mp(&weakens));
        }
    }

    fn improvement(&self) {
        let safety = self.found.options().safety;
        let sizes = self.found.result().improvement.clone();
        assert_eq!(sizes.is_none(), safety == Safety::Prefix);
        if let Some(sizes) = sizes {
            let (states, transitions) = self.literal.sizes(safety);
            assert_eq!((sizes.states, &sizes.transitions), (states.into(), &transitions.into()));
            let engine = self.found.engine();
            let total = engine.count_transitions(&engine.all_choices(), &engine.all_states()).unwrap();
            assert_eq!(sizes.dropped, total - sizes.transitions / 2u32);
        }
        let (found, tiny) = (self.found.improvement().unwrap(), self.tiny.improvement().unwrap());
        assert_eq!(found.arenas.len(), tiny.arenas.len());
        for (found, expected) in found.arenas.iter().zip(&tiny.arenas) {
            assert_eq!(found.reference, expected.reference);
            self.states("arena", &found.states, &expected.states);
            self.choices("arena", &found.choices, &expected.choices);
        }
    }

    fn levels(&self, kind: Kind) {
        let levels = self.found.levels(kind);
        let expected = self.literal.levels(kind, self.found.options().safety);
        let mut found: Vec<&E::States> = levels.found.iter().map(|l| &l.states).collect();
        let nothing = self.found.engine().no_states();
        found.push(match &levels.end {
            Some(End::Empty) => &nothing,
            Some(End::Unbounded(level)) => &level.states,
            Some(End::Cut) | None => panic!("not finished"),
        });
        assert_eq!(found.len(), expected.len(), "{kind}");
        for (k, (found, expected)) in found.iter().zip(&expected).enumerate() {
            self.states(&format!("{kind} {}", k + 1), found, expected);
        }
        for (s, state) in self.reference.brute.states.iter().enumerate() {
            let rank = match expected.iter().take_while(|level| level.contains(&s)).count() {
                k if k == expected.len() => Rank::Unbounded,
                k => Rank::Finite(k),
            };
            assert_eq!(levels.rank(self.found.engine(), state).unwrap(), rank, "{kind}: {state:?}");
        }
    }

    fn strategies(&self, kind: Kind) {
        let pairs = every(self.found.levels(kind)).zip(every(self.tiny.levels(kind)));
        for (k, (level, expected)) in pairs.enumerate() {
            let (engine, improvement) = (self.found.engine(), self.found.improvement().unwrap());
            let found = strategies(engine, kind, improvement, level).unwrap();
            let tiny = strategies(self.tiny.engine(), kind, self.tiny.improvement().unwrap(), expected);
            assert_eq!(found.len(), improvement.arenas.len());
            for (found, expected) in found.iter().zip(tiny.unwrap()) {
                self.states("winning", &found.states, &expected.states);
                self.choices(
                    &format!("permitted, {kind} {}", k + 1),
                    &found.permissive,
                    &expected.permissive,
                );
                self.choices(&format!("progress, {kind} {}", k + 1), &found.progress, &expected.progress);
                assert_eq!(found.layers.len(), expected.layers.len());
                for (layer, expected) in found.layers.iter().zip(&expected.layers) {
                    self.states("layer", layer, expected);
                }
            }
            let classes = self.found.classes().unwrap();
            let start = permitted_at_start(engine, kind, classes, improvement, level).unwrap();
            self.choices("at the start", &start, &self.permitted(kind, expected));
        }
    }

    fn permitted(&self, kind: Kind, level: &Level<Tiny>) -> Set {
        let (classes, improvement) = (self.tiny.classes().unwrap(), self.tiny.improvement().unwrap());
        permitted_at_start(self.tiny.engine(), kind, classes, improvement, level).unwrap()
    }

    /// Ranks and names of permitted actions, as reports show them.
    fn prospects(&self) {
        let program = &self.world.program;
        let mut found = self.found.initial_prospects(program, usize::MAX).unwrap();
        found.retain(|prospects| prospects.escape.is_none());
        assert_eq!(found.len(), self.reference.brute.initial.len());
        for (&s, prospects) in self.reference.brute.initial.iter().zip(found) {
            let state = &self.reference.brute.states[s];
            let objectives = &self.found.preferences().objectives;
            let index = |name: &String| objectives.iter().position(|o| o.name == *name).unwrap();
            let mp: Set = prospects.most_preferred.iter().map(index).collect();
            assert_eq!((&prospects.state, &mp), (state, &self.literal.mp[s]));
            let mut steps = program.steps(state).unwrap();
            let own = self.reference.brute.pairs.iter().filter(|pair| pair.state == s);
            let kept: Vec<_> = own.map(|pair| &pair.choice).collect();
            steps.retain(|step| kept.contains(&&step.choice));
            for (kind, plan) in [(Kind::Sasi, prospects.sasi), (Kind::Spi, prospects.spi)] {
                let levels = self.tiny.levels(kind);
                let rank = levels.rank(self.tiny.engine(), &[s as i64]).unwrap();
                let permitted = levels.level(rank).map(|level| self.permitted(kind, level));
                let taken = self.tiny.engine().rows(&permitted.unwrap_or_default()).swap_remove(s);
                let names: Vec<String> = taken.into_iter().map(|a| steps[a].name.clone()).collect();
                let plan = plan.unwrap();
                assert_eq!((plan.rank, plan.actions), (rank, names), "{kind}: {state:?}");
            }
        }
    }
}

/// All levels found, and the fixpoint.
fn every<E: Engine>(levels: &Levels<E>) -> impl Iterator<Item = &Level<E>> {
    levels.found.iter().chain(levels.unbounded())
}

/// All safeties and all values of nothing, on one engine.
fn check<E: Engine>(engine: &Arc<E>, world: &World, reference: &Reference) {
    for &empty in Empty::ALL {
        let literal = Literal::new(&reference.case, empty);
        let tiny_preferences = reference.case.preferences(&reference.tiny, empty);
        let mut preferences = Preferences::clone(&tiny_preferences);
        for (objective, &target) in preferences.objectives.iter_mut().zip(&world.targets) {
            objective.goal = Goal::Reach(world.program.predicate(target));
        }
        let requirement =
            |kept| Requirement { text: "G p".to_owned(), kept: world.program.predicate(kept), monitor: None };
        preferences.requirements.extend(world.requirement.map(requirement));
        let preferences = Arc::new(preferences);
        for &safety in Safety::ALL {
            let tiny = analyse(&reference.tiny, &tiny_preferences, safety);
            let found = finished(engine, &preferences, Options { safety, max_level: None });
            Check { world, reference, literal: &literal, found: &found, tiny: &tiny }.all();
        }
    }
}

fn both(world: &World) {
    let reference = Reference::new(world);
    let settings = || Settings { scope: world.scope, memory: 64 << 20, ..Settings::default() };
    let explicit = Arc::new(ExplicitEngine::new(world.program.clone(), settings()).unwrap());
    check(&explicit, world, &reference);
    for order in [Order::Auto, Order::Declared] {
        let settings = Settings { order, ..settings() };
        let symbolic = SymbolicEngine::new(world.program.clone(), settings).unwrap();
        check(&Arc::new(symbolic), world, &reference);
    }
}

proptest! {
    #![proptest_config(meliora_amount::random(60))]

    #[test]
    fn both_engines_find_what_is_defined_on_factored_programs(factored in factored()) {
        both(&factored.world());
    }

    #[test]
    fn both_engines_find_what_is_defined_on_graphs(graph in graph(24)) {
        both(&graph.world());
    }

    #[test]
    fn a_requirement_removes_states_and_choices_of_factored_programs(factored in factored()) {
        both(&factored.world().forbidding());
    }

    #[test]
    fn a_requirement_removes_states_and_choices_of_graphs(graph in graph(24)) {
        both(&graph.world().forbidding());
    }
}
