//! Random small models with random preferences.

use meliora::model::preference::{Preorder, Relation, Statement};
use proptest::prelude::*;

use crate::planning::Case;
use crate::planning::tiny::Mdp;

/// Up to `states` states with up to three choices, and up to five objectives, in a chain half of the
/// time: chains have the most levels.
pub(crate) fn case(states: usize) -> impl Strategy<Value = Case> {
    (2..=states, 1..=5usize).prop_flat_map(|(n, objectives)| {
        let successors = prop::collection::vec(0..n, 1..=3);
        let choices = prop::collection::vec(prop::collection::vec(successors, 0..=3), n);
        let target = prop::collection::vec(0..n, 0..=2);
        let targets = prop::collection::vec(target, objectives);
        (choices, targets, order(objectives)).prop_map(|(choices, targets, statements)| Case {
            mdp: Mdp::new(choices),
            targets,
            statements,
        })
    })
}

/// Statements about `n` objectives that do not contradict each other, half of the time a chain.
pub(crate) fn order(n: usize) -> impl Strategy<Value = Vec<Statement>> {
    let relation = prop_oneof![
        5 => Just(Relation::Strict),
        1 => Just(Relation::Weak),
        1 => Just(Relation::Indifferent),
    ];
    let statement =
        (0..n, relation, 0..n).prop_map(|(left, relation, right)| Statement { left, relation, right });
    let chain: Vec<Statement> =
        (1..n).map(|i| Statement { left: i, relation: Relation::Strict, right: i - 1 }).collect();
    let statements = prop_oneof![prop::collection::vec(statement, 0..=6), Just(chain)];
    statements.prop_map(move |statements| consistent(n, statements))
}

/// Leaves out statements that contradict the ones before.
fn consistent(n: usize, statements: Vec<Statement>) -> Vec<Statement> {
    let mut kept = Vec::new();
    for statement in statements {
        kept.push(statement);
        if Preorder::new(n, &kept).is_err() {
            kept.pop();
        }
    }
    kept
}
