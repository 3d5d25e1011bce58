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
