//! A game in which one side owns every choice is an `mdp`.

use meliora::model::players::{Owner, Player, Players};
use meliora::planning::explain::Action;
use meliora::planning::{AnalysisResult, Explanation};
use proptest::prelude::*;

use super::{settings, thresholds};
use crate::common::prelude::*;

/// Turns a program into a game of one player.
pub(crate) fn as_game(program: &Program) -> Program {
    let players = Players {
        list: vec![Player { name: "all".into(), ours: true }],
        of_module: vec![Some(0); program.modules.len()],
        of_action: vec![Some(0); program.actions.len()],
        span: 0..0,
    };
    Program { kind: ModelKind::Smg, players: Some(players), ..program.clone() }
}

fn engine(program: &Arc<Program>, storage: Storage) -> AnyEngine {
    let settings = meliora::engine::Settings { storage, ..settings(Scope::All, thresholds()[0]) };
    AnyEngine::new(Arc::clone(program), settings).unwrap()
}

fn listed<E: Engine>(engine: &E, target: &Predicate) -> Regions<Vec<State>> {
    let found = regions(engine, &engine.states_where(target).unwrap()).unwrap();
    found.map(|x| engine.list_states(&x, usize::MAX).unwrap())
}

fn preferences(targets: &[Predicate]) -> Arc<Preferences> {
    let objective = |(i, target): (usize, &Predicate)| Objective {
        name: format!("o{i}"),
        goal: Goal::Reach(target.clone()),
        span: None,
    };
    let statement = Statement { left: 0, relation: Relation::Strict, right: 1 };
    Arc::new(Preferences {
        objectives: targets.iter().enumerate().map(objective).collect(),
        order: Preorder::new(targets.len(), &[statement]).unwrap(),
        empty: Empty::Bottom,
        history: History::State,
        requirements: Vec::new(),
    })
}

fn analysed(engine: AnyEngine, targets: &[Predicate], safety: Safety) -> AnalysisResult {
    let options = Options { safety, ..Options::default() };
    let analysis = finished(&Arc::new(engine), &preferences(targets), options);
    analysis.result().clone()
}

/// Explains all states under the strategies of all kinds, without their owner.
fn explained(engine: AnyEngine, program: &Arc<Program>, safety: Safety) -> Vec<Explanation> {
    let targets = [0, 1].map(|at| program.labels[at].1).map(|target| program.predicate(target));
    let options = Options { safety, ..Options::default() };
    let analysis = finished(&Arc::new(engine), &preferences(&targets), options);
    let engine = analysis.engine();
    let states = engine.list_states(&engine.all_states(), 40).unwrap();
    let mut found = Vec::new();
    for (kind, objectives) in [
        (StrategyKind::Sasi, &[][..]),
        (StrategyKind::Spi, &[]),
        (StrategyKind::Plan, &[]),
        (StrategyKind::Achieve, &[0]),
        (StrategyKind::Achieve, &[0, 1]),
    ] {
        let objectives = objectives.iter().copied();
        let of = FiniteMemoryStrategy::of_kind(&analysis, program, kind, kind.levels(), objectives);
        let mut strategy = of.unwrap().unwrap();
        for state in &states {
            let memory = strategy.start(state).unwrap();
            let at = strategy.explain(state, memory).unwrap();
            let deadlock = at.actions.iter().all(|action| action.name == "deadlock");
            let is_game = program.players.is_some() && !deadlock;
            assert_eq!(at.owner, is_game.then_some(Owner { player: 0, ours: true }));
            // A game also names how a class can be lost, which an MDP does not.
            let actions = at.actions.into_iter().map(|action| Action { threat: None, ..action });
            found.push(Explanation { owner: None, actions: actions.collect(), ..at });
        }
    }
    found
}

proptest! {
    #![proptest_config(crate::common::amount::random(100))]

    #[test]
    fn strategies_of_one_player_are_those_of_an_mdp(
        of in proptest::collection::vec(0u16..1000, 0..120),
        first in proptest::collection::vec(0u16..1000, 0..20),
        second in proptest::collection::vec(0u16..1000, 0..20),
    ) {
        let mut program = random_program(&of, false);
        program.kind = ModelKind::Mdp;
        let targets = [random_predicate(&mut program, &first), random_predicate(&mut program, &second)];
        program.labels = targets.into_iter().enumerate().map(|(i, id)| (format!("o{i}"), id)).collect();
        let (mdp, game) = (Arc::new(program.clone()), Arc::new(as_game(&program)));
        for storage in [Storage::Explicit, Storage::Symbolic] {
            for safety in [Safety::Action, Safety::Prefix] {
                let expected = explained(engine(&mdp, storage), &mdp, safety);
                prop_assert_eq!(explained(engine(&game, storage), &game, safety), expected);
            }
        }
    }
}

proptest! {
    #![proptest_config(crate::common::amount::random(1000))]

    #[test]
    fn one_player_is_an_mdp(
        of in proptest::collection::vec(0u16..1000, 0..120),
        first in proptest::collection::vec(0u16..1000, 0..20),
        second in proptest::collection::vec(0u16..1000, 0..20),
    ) {
        let mut program = random_program(&of, false);
        program.kind = ModelKind::Mdp;
        let targets = [random_predicate(&mut program, &first), random_predicate(&mut program, &second)];
        let targets = targets.map(|target| program.predicate(target));
        let (mdp, game) = (Arc::new(program.clone()), Arc::new(as_game(&program)));
        for storage in [Storage::Explicit, Storage::Symbolic] {
            let (one, other) = (engine(&mdp, storage), engine(&game, storage));
            let opponent = other.with_coalition(&[false]).unwrap();
            for target in &targets {
                let expected = listed(&one, target);
                prop_assert_eq!(&listed(&other, target), &expected);
                let Regions { pmax_one, pmax_positive, pmin_one, pmin_positive } = listed(&opponent, target);
                prop_assert_eq!(&pmin_one, &expected.pmax_one);
                prop_assert_eq!(&pmin_positive, &expected.pmax_positive);
                prop_assert_eq!(&pmax_one, &expected.pmin_one);
                prop_assert_eq!(&pmax_positive, &expected.pmin_positive);
            }
            for safety in [Safety::Action, Safety::Prefix] {
                let found = analysed(other.clone(), &targets, safety);
                prop_assert_eq!(found, analysed(one.clone(), &targets, safety));
            }
        }
    }
}
