//! Objectives that are achieved together: the chain that the strategy induces achieves all of them
//! almost surely, from each state from which `Joint` says that this is possible.

use meliora::engine::{Algebra, Engine};
use meliora::model::State;
use meliora::model::preference::{Goal, ObjectiveSet};
use meliora::planning::joint::Joint;
use meliora::planning::{FiniteMemoryStrategy, InducedModel, Scheduler, StrategyKind};
use proptest::test_runner::Config;

use crate::Analysed;
use crate::coverage::draw_until;
use crate::graphs::{Set, bottom_components, chain, edges};
use crate::random_case::{RandomCase, random_case};

/// Checks that the paths from a state almost surely visit each target, without the strategy's memory:
/// no bottom component is left if the states of the target are taken out.
fn visits_all(of: &Analysed, objectives: &ObjectiveSet, unfolded: &InducedModel) {
    assert!(unfolded.complete);
    let (engine, all) = (of.analysis.engine(), chain(&edges(unfolded)));
    for objective in objectives.iter() {
        let target = &of.analysis.outcomes().unwrap().get(objective).unwrap().target;
        let hit = |node: &usize| engine.contains(target, &unfolded.nodes[*node].at.state).unwrap();
        let absorbing: Set = (0..all.len()).filter(hit).collect();
        for component in bottom_components(&all, 0, &absorbing) {
            assert!(component.iter().any(|node| absorbing.contains(node)), "{objective}: {unfolded:?}");
        }
    }
}

/// Checks that paths end where all objectives are achieved, or go on forever in a stage that keeps them.
fn ends(unfolded: &InducedModel, is_temporal: bool) {
    for component in bottom_components(&chain(&edges(unfolded)), 0, &Set::new()) {
        for &node in &component {
            let at = &unfolded.nodes[node].at;
            let kept = is_temporal && at.memory.pursuit.is_some_and(|pursuit| pursuit.stage > 0);
            assert!(at.is_achieved() && component.len() == 1 || kept, "{at:?}");
        }
    }
}

/// Returns true if the objectives are formulas on whole paths: all are, or none.
fn is_temporal(of: &Analysed) -> bool {
    matches!(of.analysis.preferences().objectives[0].goal, Goal::Satisfy { .. })
}

/// Checks the states of a class, `sure` of which achieve the objectives together. Returns their number.
fn check_set(of: &Analysed, objectives: &ObjectiveSet, states: &[State], sure: &[State]) -> usize {
    let kind = StrategyKind::Achieve;
    let mut strategy =
        FiniteMemoryStrategy::of_kind(&of.analysis, &of.program, kind, kind.levels(), objectives.iter())
            .unwrap()
            .unwrap();
    for state in states {
        let pursuit = strategy.start(state).unwrap().pursuit;
        assert_eq!(pursuit.is_some(), sure.contains(state), "{state:?}");
    }
    let of_play = is_temporal(of);
    for start in sure.iter().take(12) {
        for scheduler in [Scheduler::Progress, Scheduler::Permissive] {
            let starts = std::slice::from_ref(start);
            let unfolded = InducedModel::unfold(&mut strategy, starts, scheduler, 10_000).unwrap();
            ends(&unfolded, of_play);
            if !of_play {
                visits_all(of, objectives, &unfolded);
            }
        }
    }
    sure.len()
}

/// Checks all sets of all classes. Returns the numbers of states for targets and for formulas.
fn check(case: &RandomCase) -> [usize; 2] {
    let mut seen = [0; 2];
    let [symbolic, explicit, _] = Analysed::all(case);
    for of in [symbolic, explicit] {
        let (engine, joint) = (of.analysis.engine(), Joint::new(&of.analysis).unwrap());
        let list = |set: &_| engine.list_states(set, usize::MAX).unwrap();
        let of_play = is_temporal(&of);
        for class in &of.analysis.classes().unwrap().list {
            for (objectives, sure) in joint.of_class(engine, class).unwrap().unwrap() {
                let sure = engine.intersection(&sure, &class.states).unwrap();
                let checked = check_set(&of, &objectives, &list(&class.states), &list(&sure));
                seen[usize::from(of_play)] += checked;
            }
        }
    }
    seen
}

#[test]
fn what_is_sure_together_is_achieved_in_one_path() {
    let config = Config { source_file: Some(file!()), ..crate::amount::random(100) };
    let enough = |seen: &[usize; 2]| seen.iter().all(|&n| n > 100);
    draw_until(&config, &random_case(), enough, |case, seen| {
        for (total, found) in seen.iter_mut().zip(check(&case)) {
            *total += found;
        }
    });
}
