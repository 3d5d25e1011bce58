//! Both engines give the same report, and the same strategies in all states.

use meliora::planning::{InducedModel, Scheduler};
use proptest::prelude::*;

use crate::Analysed;
use crate::random_case::random_case;

/// Checks that two engines report the same, with the same strategies from every state on.
fn agree(one: &Analysed, other: &Analysed) {
    assert_eq!(one.analysis.result(), other.analysis.result());
    let states = one.states();
    assert_eq!(states, other.states());
    let prospects = |of: &Analysed| of.analysis.initial_prospects(&of.program, usize::MAX).unwrap();
    assert_eq!(prospects(one), prospects(other));
    for (mut mine, mut others) in one.strategies().into_iter().zip(other.strategies()) {
        let label = format!("{:?} {:?}", mine.kind(), mine.objectives());
        let unfold = |strategy: &mut _| {
            let unfolded = InducedModel::unfold(strategy, &states, Scheduler::Permissive, 10_000).unwrap();
            assert!(unfolded.complete);
            unfolded.nodes
        };
        let (mine, others) = (unfold(&mut mine), unfold(&mut others));
        assert_eq!(mine.len(), others.len(), "{label}");
        mine.iter().zip(&others).for_each(|(a, b)| assert_eq!(a, b, "{label}"));
    }
}

proptest! {
    #![proptest_config(crate::amount::random(100))]

    #[test]
    fn both_engines_report_the_same_and_explain_the_same_in_every_state(case in random_case()) {
        let [symbolic, explicit, taken_over] = Analysed::all(&case);
        agree(&symbolic, &explicit);
        agree(&symbolic, &taken_over);
    }
}
