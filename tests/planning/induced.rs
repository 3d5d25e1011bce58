//! Induced models with a limit on their size.

use meliora::planning::{FiniteMemoryStrategy, InducedModel, Kind, Safety, Scheduler};

use crate::planning::loaded::ladder;

#[test]
fn an_induced_model_has_the_nodes_of_its_limit_and_is_complete_when_these_are_all() {
    let model = ladder();
    let analysis = model.analyse(Safety::Action, None);
    let mut strategy = FiniteMemoryStrategy::new(&analysis, &model.program, Kind::Sasi).unwrap();
    // From 0 all states are met, each with one memory.
    for limit in 1..8 {
        let found = InducedModel::unfold(&mut strategy, &[vec![0]], Scheduler::Permissive, limit).unwrap();
        assert_eq!((found.nodes.len(), found.complete), (limit.min(5), limit >= 5), "limit {limit}");
    }
}

#[test]
fn an_induced_model_without_room_for_all_starts_is_not_complete() {
    let model = ladder();
    let analysis = model.analyse(Safety::Action, None);
    let mut strategy = FiniteMemoryStrategy::new(&analysis, &model.program, Kind::Sasi).unwrap();
    // No improvement is left at 3 and at 4: each is the only node of its runs.
    let starts = [vec![3], vec![4]];
    for limit in 0..4 {
        let found = InducedModel::unfold(&mut strategy, &starts, Scheduler::Permissive, limit).unwrap();
        assert_eq!((found.nodes.len(), found.complete), (limit.min(2), limit >= 2), "limit {limit}");
    }
}
