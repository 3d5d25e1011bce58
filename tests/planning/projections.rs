//! Maps over two variables: what a cell shows is what the sets say of its states.

use meliora::projections::{self, Inside, Plane, Projections};

use crate::common::prelude::*;

/// The robot with its analysis and projections over its plane, handed to a test.
fn with_projections(
    scope: Scope,
    nodes: usize,
    test: impl Fn(&SymbolicEngine, &Analysis<SymbolicEngine>, &Projections),
) {
    let read = |name: &str| SourceFile::new(name, fs::read_to_string(name).unwrap());
    let program =
        lang::load(&read("models/robot5x5.prism"), &SourceFile::new("constants", "")).unwrap().program;
    let lang::Task { program, preferences } =
        lang::load_preferences(&read("models/robot5x5.pref"), program).unwrap();
    let preferences = Arc::new(preferences);
    let plane = Plane::guess(&program).unwrap();
    let program = Arc::new(program);
    let settings = Settings { scope, memory: 256 << 20, ..Settings::default() };
    let engine = Arc::new(SymbolicEngine::new(program.clone(), settings).unwrap());
    let analysis = finished(&engine, &preferences, Options { safety: Safety::Action, max_level: None });
    let at = engine.list_states(&engine.initial_states(), 1).unwrap().remove(0);
    let projections = projections::build(&analysis, plane, &at, nodes).unwrap();
    test(&engine, &analysis, &projections);
}

#[test]
fn cells_say_of_each_state_what_the_sets_say() {
    with_projections(Scope::All, usize::MAX, |engine, analysis, projections| {
        assert!(!projections.projected && projections.rows_up);
        for state in engine.list_states(&engine.all_states(), usize::MAX).unwrap() {
            let view = state.iter().copied().map(Some).collect();
            let cell = projections.cell(&view).unwrap();
            let rank = |kind| analysis.levels(kind).rank(engine, &state).unwrap();
            assert_eq!((cell.sasi, cell.spi), (rank(Kind::Sasi), rank(Kind::Spi)), "{state:?}");
            let class = analysis.classes().unwrap().of(engine, &state).unwrap().unwrap();
            assert_eq!(cell.classes, [class], "{state:?}");
        }
    });
}

#[test]
fn arrows_are_the_permitted_actions_and_point_where_they_lead() {
    with_projections(Scope::Reachable, usize::MAX, |engine, analysis, projections| {
        let directions: Vec<(&str, i8, i8)> =
            projections.choices.iter().map(|c| (c.name.as_str(), c.row, c.column)).collect();
        assert_eq!(directions[..4], [("N", 1, 0), ("S", -1, 0), ("E", 0, 1), ("W", 0, -1)]);
        for state in engine.list_states(&engine.all_states(), usize::MAX).unwrap() {
            let view = state.iter().copied().map(Some).collect();
            let prospects = analysis.prospects(engine.program(), &state).unwrap();
            for (plan, ladder) in [(prospects.sasi, &projections.sasi), (prospects.spi, &projections.spi)] {
                let here = projections.choices.iter().zip(&ladder.permitted);
                let names: Vec<&str> = here
                    .filter(|(_, e)| projections.holds(**e, &view))
                    .map(|(c, _)| c.name.as_str())
                    .collect();
                let plan = plan.unwrap().actions;
                let plain: Vec<&str> = plan.iter().map(|a| a.split('(').next().unwrap()).collect();
                assert_eq!(names, plain, "{state:?}");
            }
        }
    });
}

#[test]
fn open_variables_give_the_best_that_some_value_allows() {
    with_projections(Scope::Reachable, usize::MAX, |engine, analysis, projections| {
        let mut best: BTreeMap<(i64, i64), usize> = BTreeMap::new();
        for state in engine.list_states(&engine.all_states(), usize::MAX).unwrap() {
            let Rank::Finite(rank) = analysis.levels(Kind::Sasi).rank(engine, &state).unwrap() else {
                panic!()
            };
            let cell = best.entry((state[0], state[1])).or_default();
            *cell = rank.max(*cell);
        }
        let open = vec![None; 7];
        for row in 0..5 {
            for column in 0..5 {
                let cell = projections.cell(&projections.view(&open, row, column));
                let expected = best.get(&(row, column)).map(|&k| Rank::Finite(k));
                assert_eq!(cell.as_ref().map(|c| c.sasi), expected, "{row},{column}");
                // With the battery full there is but one state: the others are spoken of all the same.
                let found = projections.found(&projections.opening(), row, column);
                assert_eq!(found.as_ref().is_some_and(|f| f.1), (row, column) == (2, 2));
                assert!(
                    (row, column) == (2, 2) || found.map(|f| f.0) == cell.map(Inside::Safe),
                    "{row},{column}"
                );
            }
        }
    });
}

#[test]
fn what_is_too_large_loses_first_its_arrows_and_then_its_sliders() {
    with_projections(Scope::Reachable, usize::MAX, |_, _, whole| {
        with_projections(Scope::Reachable, whole.diagram.nodes.len() - 1, |_, _, projections| {
            assert!(!projections.projected && projections.choices.is_empty() && projections.rows_up);
            assert!(projections.diagram.nodes.len() < whole.diagram.nodes.len());
        });
        with_projections(Scope::Reachable, 100, |_, _, projections| {
            assert!(projections.projected && projections.diagram.nodes.len() <= 100);
            for row in 0..5 {
                for column in 0..5 {
                    let cell = |projections: &Projections| {
                        projections.cell(&projections.view(&vec![None; 7], row, column))
                    };
                    assert_eq!(cell(projections), cell(whole), "{row},{column}");
                }
            }
        });
    });
}
