//! Properties of the preorder, of the maximal sets and of steps.

use meliora::model::preference::{Comparison, ObjectiveSet};
use proptest::prelude::*;

use crate::common::prelude::*;

fn says(left: usize, relation: Relation, right: usize) -> Statement {
    Statement { left, relation, right }
}

fn set(members: &[usize]) -> ObjectiveSet {
    members.iter().copied().collect()
}

#[test]
fn the_closure_is_reflexive_and_transitive() {
    use Relation::{Indifferent, Strict, Weak};
    let order = Preorder::new(
        6,
        &[says(0, Strict, 1), says(1, Weak, 2), says(2, Indifferent, 3), says(3, Strict, 4)],
    )
    .unwrap();
    assert_eq!(order.compare(0, 0), Comparison::Indifferent);
    assert_eq!(order.compare(0, 4), Comparison::Preferred);
    assert_eq!(order.compare(4, 0), Comparison::Dispreferred);
    assert_eq!(order.compare(2, 3), Comparison::Indifferent);
    assert_eq!(order.compare(1, 2), Comparison::Preferred);
    assert_eq!(order.compare(5, 0), Comparison::Incomparable);
    assert!(order.strictly(0, 3) && !order.strictly(3, 2));
}

#[test]
fn weak_preference_both_ways_is_indifference() {
    let order = Preorder::new(2, &[says(0, Relation::Weak, 1), says(1, Relation::Weak, 0)]).unwrap();
    assert_eq!(order.compare(0, 1), Comparison::Indifferent);
}

#[test]
fn a_contradiction_shows_its_shortest_cycle() {
    use Relation::{Indifferent, Strict, Weak};
    let statements = [
        says(3, Weak, 4),
        says(0, Strict, 1),
        says(1, Strict, 2),
        says(2, Weak, 3),
        says(1, Indifferent, 3),
        says(3, Indifferent, 0),
    ];
    let error = Preorder::new(5, &statements).unwrap_err();
    assert_eq!(error.cycle, [0, 1, 3]);
    assert_eq!(error.statements, [1, 4, 5]);
}

#[test]
fn an_objective_preferred_to_itself_is_a_cycle_of_one() {
    let error = Preorder::new(2, &[says(1, Relation::Strict, 1)]).unwrap_err();
    assert_eq!((error.cycle, error.statements), (vec![1], vec![0]));
}

#[test]
fn sets_and_orders_may_have_200_objectives() {
    let chain: Vec<Statement> = (0..199).map(|i| says(i, Relation::Strict, i + 1)).collect();
    let order = Preorder::new(200, &chain).unwrap();
    assert!(order.strictly(0, 199));
    assert_eq!(order.maximal(&set(&[130, 77, 199])), set(&[77]));
    assert_eq!(set(&[130, 77]).iter().collect::<Vec<_>>(), [77, 130]);
    assert_eq!((set(&[130]).len(), set(&[]).is_empty()), (1, true));
}

fn robot(empty: Empty) -> Preferences {
    // A B C D E F: D, E above A, B; E, F above C.
    let above = [(3, 0), (4, 0), (3, 1), (4, 1), (4, 2), (5, 2)];
    let statements: Vec<Statement> = above.iter().map(|&(x, y)| says(x, Relation::Strict, y)).collect();
    Preferences {
        objectives: Vec::new(),
        order: Preorder::new(6, &statements).unwrap(),
        empty,
        history: History::State,
        requirements: Vec::new(),
    }
}

#[test]
fn a_step_that_improves_and_weakens_is_a_weakening() {
    // D is preferred to A, but F was preferred to C.
    let preferences = robot(Empty::Bottom);
    let (from, to) = (set(&[0, 5]), set(&[2, 3]));
    assert!(preferences.improves(&from, &to) && preferences.weakens(&from, &to));
    assert_eq!(preferences.change(&from, &to), Change::Weakening);
    assert_eq!(preferences.change(&set(&[0]), &set(&[2])), Change::Lateral);
    assert_eq!(preferences.change(&set(&[0]), &set(&[3])), Change::Improving);
    assert_eq!(preferences.most_preferred(&set(&[0, 2, 3])), set(&[2, 3]));
}

#[test]
fn nothing_is_worth_what_the_file_says() {
    let (nothing, a) = (set(&[]), set(&[0]));
    let changes = |empty| {
        let p = robot(empty);
        [p.change(&nothing, &a), p.change(&a, &nothing), p.change(&nothing, &nothing)]
    };
    use Change::{Improving, Lateral, Weakening};
    assert_eq!(changes(Empty::Bottom), [Improving, Weakening, Lateral]);
    assert_eq!(changes(Empty::Gain), [Improving, Lateral, Lateral]);
    assert_eq!(changes(Empty::Incomparable), [Lateral, Lateral, Lateral]);
}

fn statements() -> impl Strategy<Value = Vec<Statement>> {
    let relation = prop_oneof![Just(Relation::Strict), Just(Relation::Weak), Just(Relation::Indifferent)];
    prop::collection::vec((0..6usize, relation, 0..6usize).prop_map(|(x, r, y)| says(x, r, y)), 0..12)
}

/// x >= y by walking along statements.
fn walks(statements: &[Statement], x: usize, y: usize) -> bool {
    let mut seen = vec![x];
    let mut next = 0;
    while next < seen.len() {
        let at = seen[next];
        next += 1;
        for s in statements {
            let both = s.relation == Relation::Indifferent;
            for (a, b) in [(s.left, s.right), (s.right, s.left)] {
                if a == at && (both || a == s.left) && !seen.contains(&b) {
                    seen.push(b);
                }
            }
        }
    }
    seen.contains(&y)
}

proptest! {
    #[test]
    fn the_closure_is_reachability_and_every_cycle_is_stated(statements in statements()) {
        match Preorder::new(6, &statements) {
            Ok(order) => {
                for x in 0..6 {
                    for y in 0..6 {
                        prop_assert_eq!(order.at_least(x, y), walks(&statements, x, y));
                    }
                }
                for s in statements.iter().filter(|s| s.relation == Relation::Strict) {
                    prop_assert!(order.strictly(s.left, s.right));
                }
            }
            Err(error) => {
                prop_assert_eq!(error.cycle.len(), error.statements.len());
                prop_assert_eq!(statements[error.statements[0]].relation, Relation::Strict);
                for (k, &index) in error.statements.iter().enumerate() {
                    let s = statements[index];
                    let step = (error.cycle[k], error.cycle[(k + 1) % error.cycle.len()]);
                    let back = s.relation == Relation::Indifferent && step == (s.right, s.left);
                    prop_assert!(step == (s.left, s.right) || back);
                }
            }
        }
    }
}

#[test]
fn sets_and_orders_say_how_many_they_have() {
    assert_eq!((set(&[]).len(), set(&[3]).len(), set(&[0, 64, 65, 200]).len()), (0, 1, 4));
    assert!(set(&[]).is_empty() && !set(&[200]).is_empty());
    for count in [0, 1, 2, 70] {
        let order = Preorder::new(count, &[]).unwrap();
        assert_eq!((order.len(), order.is_empty()), (count, count == 0));
    }
}
